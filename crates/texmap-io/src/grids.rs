//! Grids of voxels from `.npy` arrays.

use std::path::Path;

use texmap_sample::{Alpha, ColorSpace, Image, Origin, SampleError, TexelData, Texture3d};

use crate::npy::{self, Data};
use crate::{FileSource, IoError, SourceLocation, image_io};

/// Reads a three-dimensional texture, with its mip chain: an array of shape (D, H, W), or (D, H, W, C) with 1 to 4 channels, of
/// u8, u16 or f32 (f64 is rounded). The first axis is the slice, from w = 0; the second the row, from v = 0; the third the
/// column, from u = 0. Values are taken as they are, integers as shares of their largest.
///
/// # Errors
/// File errors; [`IoError::BrokenArray`] for another shape or type, an axis of length 0, and a voxel that is not finite, by name.
pub fn read_grid(path: &Path) -> Result<Texture3d<'static>, IoError> {
    read_named(&FileSource::anywhere(), path, None)
}

pub(crate) fn read_named(
    files: &FileSource,
    path: &Path,
    by: Option<&SourceLocation>,
) -> Result<Texture3d<'static>, IoError> {
    let stored = npy::Stored::open(files, path, by)?;
    let broken = |problem: String| IoError::BrokenArray {
        path: path.to_path_buf(),
        problem,
    };
    let (depth, height, width, channels) = match *stored.shape {
        [d, h, w] => (d, h, w, 1),
        [d, h, w, c] => (d, h, w, c),
        _ => {
            return Err(broken(format!(
                "shape {:?}: a grid is (slices, rows, columns), or that and 1 to 4 channels",
                stored.shape
            )));
        }
    };
    let small = |n: usize| u32::try_from(n).map_err(|_| broken(format!("an axis of length {n}")));
    let (depth, width, height) = (small(depth)?, small(width)?, small(height)?);
    let voxels = [depth, height, width].map(u64::from);
    let voxels = voxels
        .iter()
        .try_fold(1_u64, |n, &side| n.checked_mul(side));
    if voxels.is_none_or(|n| n > image_io::MAX_TEXELS) || channels > 4 {
        return Err(broken(format!(
            "shape {:?}: a grid has 1 to 4 channels and at most {} voxels",
            stored.shape,
            image_io::MAX_TEXELS
        )));
    }
    let array = stored.read()?;
    let texels = match &array.data {
        Data::U8(t) => TexelData::U8(t),
        Data::U16(t) => TexelData::U16(t),
        Data::F32(t) => TexelData::F32(t),
        Data::U32(_) => {
            return Err(broken(
                "element type <u4: grids are |u1, <u2, <f4 or <f8".into(),
            ));
        }
    };
    let slices = Image {
        width,
        height,
        channels: small(channels)?,
        texels,
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    };
    // Up to four floats a voxel, and a seventh more for the mip chain.
    let voxels = array.shape.iter().take(3).map(|n| *n as u64);
    files.ask(
        voxels.product::<u64>() * 16 * 8 / 7,
        format_args!("the grid of shape {:?} of {}", array.shape, path.display()),
        "take a smaller grid",
        by,
    )?;
    let grid = Texture3d::new(depth, &slices).map_err(|error| {
        broken(match error {
            SampleError::Texel { x, y } => {
                let (row, slice) = (y % slices.height.max(1), y / slices.height.max(1));
                format!(
                    "voxel (slice {slice}, row {row}, column {x}) is NaN, infinite or beyond 2^120"
                )
            }
            other => format!("shape {:?}: {other}", array.shape),
        })
    })?;
    Ok(grid.with_mips())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::npy::{Values, write};

    #[test]
    fn shapes_and_voxels_are_read_or_refused_by_name() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("grid.npy");
        let of = |shape: &[usize], values: Values<'_>| {
            write(&path, shape, values).unwrap();
            read_grid(&path)
        };
        let values: Vec<f32> = (0..24).map(|i| i as f32).collect();
        let grid = of(&[2, 3, 4], Values::F32(&values)).unwrap();
        assert_eq!(grid.level_size(0), Some([4, 3, 2]));
        // Slice 1, row 2, column 3.
        assert_eq!(grid.texel(0, [3, 2, 1]), Some([23.0, 23.0, 23.0, 1.0]));
        assert_eq!(grid.texel(0, [1, 0, 0]), Some([1.0, 1.0, 1.0, 1.0]));
        let bytes: Vec<u8> = (0..16).map(|i| i * 17).collect();
        let grid = of(&[1, 2, 2, 4], Values::U8(&bytes)).unwrap();
        assert!(grid.has_alpha());
        assert_eq!(grid.texel(0, [1, 1, 0]).unwrap()[3], 1.0);
        assert_eq!(of(&[1, 1, 1], Values::U8(&[9])).unwrap().levels(), 1);

        let mut holed = values.clone();
        holed[17] = f32::NAN;
        for (shape, values, says) in [
            (&[2usize, 3, 4][..], &holed[..], "slice 1, row 1, column 1"),
            (&[24], &values, "slices, rows, columns"),
            (&[2, 0, 4], &[], "out of range"),
            (&[0, 3, 4], &[], "out of range"),
            (&[1, 2, 2, 6], &values, "1 to 4 channels"),
        ] {
            let error = of(shape, Values::F32(values)).unwrap_err();
            assert_eq!(error.code(), "broken-array");
            assert!(error.to_string().contains(says), "{error}");
        }
        let error = of(&[1, 1, 2], Values::U32(&[1, 2])).unwrap_err();
        assert!(error.to_string().contains("<u4"), "{error}");
    }
}
