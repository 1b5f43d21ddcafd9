//! Views of buffers that are compressed by meshoptimizer.
//!
//! `EXT_meshopt_compression` and `KHR_meshopt_compression`, whose texts give the streams (appendix A) and the filters (appendix B).
//! Streams that break their rules are refused; nothing is read beyond their ends.

mod attributes;
mod filters;
mod indices;

use rayon::prelude::*;

use super::json::{BufferView, Meshopt};
use super::model::Model;
use crate::IoError;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// The bytes of every view that is compressed, by the number of the view; `None` for the others, and where a buffer was lost.
pub(super) fn decoded(model: &Model<'_>) -> Result<Vec<Option<Vec<u8>>>, IoError> {
    let views = &model.document.buffer_views;
    let compressed = views
        .iter()
        .filter(|v| v.extensions.stated().next().is_some());
    let bytes = compressed.fold(0_u64, |sum, view| sum.saturating_add(view.byte_length));
    model.ask(bytes, "/bufferViews")?;
    views
        .par_iter()
        .enumerate()
        .map(|(i, view)| match view.extensions.stated().next() {
            Some((name, meshopt)) => {
                let at = format!("/bufferViews/{i}/extensions/{name}");
                view_of(model, view, meshopt, &at)
            }
            None => Ok(None),
        })
        .collect()
}

fn view_of(
    model: &Model<'_>,
    view: &BufferView,
    meshopt: &Meshopt,
    at: &str,
) -> Result<Option<Vec<u8>>, IoError> {
    let Some(bytes) = model.slice(meshopt.buffer, meshopt.byte_offset, meshopt.byte_length, at)?
    else {
        return Ok(None);
    };
    let length = meshopt.count.checked_mul(meshopt.byte_stride);
    if length != Some(view.byte_length) {
        let problem = format!(
            "{} elements of {} bytes are not the {} bytes of the view",
            meshopt.count, meshopt.byte_stride, view.byte_length
        );
        return Err(model.broken(at, problem));
    }
    decode(bytes, meshopt)
        .map(Some)
        .map_err(|problem| model.broken(at, problem))
}

/// The elements of a stream, of which the document says enough and nothing that contradicts itself.
fn decode(bytes: &[u8], meshopt: &Meshopt) -> Result<Vec<u8>, String> {
    let mode = match meshopt.mode.as_str() {
        "ATTRIBUTES" => Mode::Attributes,
        "TRIANGLES" => Mode::Triangles,
        "INDICES" => Mode::Indices,
        other => return Err(format!("there is no mode '{}'", crate::shortened(other))),
    };
    let filter = match meshopt.filter.as_deref() {
        None | Some("NONE") => None,
        Some(name) => Some(
            filters::Filter::named(name)
                .ok_or_else(|| format!("there is no filter '{}'", crate::shortened(name)))?,
        ),
    };
    let whole = |n: u64| usize::try_from(n).map_err(|_| format!("{n} bytes are too many"));
    let (count, stride) = (whole(meshopt.count)?, whole(meshopt.byte_stride)?);
    let fits = match (mode, filter) {
        (Mode::Attributes, filter) => {
            (4..=256).contains(&stride)
                && stride.is_multiple_of(4)
                && filter.is_none_or(|filter| filter.fits(stride))
        }
        (_, None) => stride == 2 || stride == 4,
        (_, Some(_)) => return Err("indices have no filter".to_owned()),
    };
    if !fits {
        return Err(format!(
            "elements of {stride} bytes do not go with its mode and filter"
        ));
    }
    if mode == Mode::Triangles && !count.is_multiple_of(3) {
        return Err(format!("{count} indices are not whole triangles"));
    }
    match mode {
        Mode::Attributes => {
            let mut elements = attributes::decode(bytes, count, stride)?;
            if let Some(filter) = filter {
                filter.decode(&mut elements, stride);
            }
            Ok(elements)
        }
        Mode::Triangles => indices::triangles(bytes, count, stride),
        Mode::Indices => indices::sequence(bytes, count, stride),
    }
}

/// The bytes of a stream, read from the front.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(n).ok_or_else(ends_early)?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, String> {
        Ok(self.take(1)?[0])
    }

    /// All bytes are read.
    fn finish(self) -> Result<(), String> {
        match self.0.len() {
            0 => Ok(()),
            n => Err(format!("{n} bytes of the stream are left over")),
        }
    }
}

fn ends_early() -> String {
    "the stream ends early".to_owned()
}

/// A stream without its first byte, which is one of some, and its tail of some bytes; and that byte.
fn body<'a>(
    bytes: &'a [u8],
    headers: &[u8],
    tail: impl Fn(u8) -> usize,
) -> Result<(u8, Reader<'a>, &'a [u8]), String> {
    let (&header, rest) = bytes.split_first().ok_or_else(ends_early)?;
    if !headers.contains(&header) {
        return Err(format!(
            "the stream begins with {header:#04x}, of no known version"
        ));
    }
    let middle = rest
        .len()
        .checked_sub(tail(header))
        .ok_or_else(ends_early)?;
    let (middle, tail) = rest.split_at(middle);
    Ok((header, Reader(middle), tail))
}

#[cfg(test)]
mod tests;
