//! Bands of a picture, joined from the top to the bottom.

use std::io;
use std::path::Path;

use texmap_io::image_io::{Depth, Rgba, read_image, write_png};
use texmap_io::{IoError, PixelCode, write_pixels};
use texmap_math::MemoryBudget;
use texmap_render::PixelHash;
use texmap_sample::ColorSpace;

use super::shards::{Report, bad};
use crate::cmd::batch::files::FileMark;
use crate::cmd::batch::record::{Record, Status};
use crate::failure::{Exit, Failure};
use crate::output::{Destination, Stage};

/// The record of the picture of bands in order: failed if one of them is; `None` without bands.
pub(super) fn record(parts: &[(&Report, &Record)]) -> Option<Record> {
    let failed = parts.iter().find(|(_, record)| record.status != Status::Ok);
    let (_, shown) = failed.or(parts.first())?;
    let mut record = (*shown).clone();
    record.index = parts.iter().map(|(_, r)| r.index).min().unwrap_or_default();
    if let Some((id, _)) = record.id.rsplit_once('#') {
        record.id = id.to_owned();
    }
    record.band = None;
    record.outputs.clear();
    record.ms = parts.iter().map(|(_, r)| r.ms).sum();
    record.peak_bytes = parts.iter().filter_map(|(_, r)| r.peak_bytes).max();
    for (_, part) in parts {
        for warning in &part.warnings {
            if !record.warnings.contains(warning) {
                record.warnings.push(warning.clone());
            }
        }
    }
    Some(record)
}

/// Joins bands in order to a picture of the bytes that a single run writes.
pub(super) fn join(parts: &[(&Report, &Record)], output: &Path) -> Result<FileMark, Failure> {
    let mut bands = Vec::new();
    let (mut width, mut height, mut deep) = (0, 0, false);
    for (report, record) in parts {
        let Some(mark) = record.outputs.first() else {
            let what = format!("the band {} has no file", record.id);
            return Err(bad(&report.path, &what));
        };
        let path = report.folder.join(&mark.path);
        let band = read_image(&path)?;
        let is_deep = matches!(band.texels, Depth::U16(_));
        if bands.is_empty() {
            (width, deep) = (band.width, is_deep);
        }
        if band.width != width || is_deep != deep {
            return Err(Failure::new(
                Exit::Input,
                "mixed-shards",
                format!(
                    "{}: a band of {} pixels among bands of {width}",
                    path.display(),
                    band.width
                ),
                "run its shard again",
            ));
        }
        height += band.height;
        bands.push(path);
    }
    let main = Destination::new(output)?;
    let mut stage = Stage::new(&main)?;
    let place = stage.add(main, "png");
    let mut hash = PixelHash::new(width, height);
    match deep {
        true => {
            let code = PixelCode::Png16(ColorSpace::Srgb);
            stream(&place, code, (width, height), &bands, &mut hash)?;
        }
        false => eight_bits(&place, (width, height), &bands, &mut hash)?,
    }
    let mut mark = FileMark::of(&place).map_err(|source| IoError::Write {
        path: output.to_owned(),
        source,
    })?;
    stage.commit()?;
    mark.pixel_hash = Some(hash.digits());
    mark.path = output.to_string_lossy().into_owned();
    Ok(mark)
}

/// Writes a picture of 8 bits a channel, and hashes it. The file has the bytes of a single run if the whole fits into memory, else the same
/// pixels, compressed row by row.
fn eight_bits(
    place: &Path,
    (width, height): (u32, u32),
    bands: &[impl AsRef<Path>],
    hash: &mut PixelHash,
) -> Result<(), Failure> {
    let bytes = 4 * u64::from(width) * u64::from(height);
    let asked = MemoryBudget::of_process().ask(
        // The encoder holds twice as much, and a band is read meanwhile.
        3 * bytes + bytes / bands.len().max(1) as u64,
        format_args!("a picture of {width} x {height} pixels"),
        "",
    );
    if asked.is_err() {
        let code = PixelCode::Png8(ColorSpace::Srgb);
        return stream(place, code, (width, height), bands, hash);
    }
    let mut all = Vec::with_capacity(bytes as usize);
    for band in bands {
        all.extend(codes(&read_image(band.as_ref())?, hash));
    }
    write_png(place, width, height, &all)?;
    Ok(())
}

/// Writes the rows of bands one band after the other, and hashes them.
fn stream(
    place: &Path,
    code: PixelCode,
    size: (u32, u32),
    bands: &[impl AsRef<Path>],
    hash: &mut PixelHash,
) -> Result<(), Failure> {
    write_pixels(place, code, size, |out| {
        bands.iter().try_for_each(|band| {
            let band = read_image(band.as_ref()).map_err(io::Error::other)?;
            out.write_all(&codes(&band, hash))
        })
    })?;
    Ok(())
}

/// Bytes of the pixels as PNG has them, and in the hash as [`Buffer::hash`](texmap_truth::buffer::Buffer::hash) of the whole takes them.
fn codes(image: &Rgba, hash: &mut PixelHash) -> Vec<u8> {
    match &image.texels {
        Depth::U8(codes) => {
            hash.update(codes);
            codes.clone()
        }
        Depth::U16(codes) => {
            codes
                .iter()
                .for_each(|code| hash.update(&code.to_le_bytes()));
            codes.iter().flat_map(|code| code.to_be_bytes()).collect()
        }
        Depth::F32(_) => Vec::new(),
    }
}
