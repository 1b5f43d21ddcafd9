//! Cube textures, and look-ups in them.

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use rayon::prelude::*;
use texmap_sample::{Alpha, ColorSpace, Image, Origin, TexelData, TextureCube};

use crate::by_levels::ByLevels;
use crate::support::{Threads, expect_length, unlocked, value};
use crate::texture::Group;

/// A cube of six images.
#[pyclass(frozen, module = "texmap._texmap")]
pub(crate) struct Cube {
    groups: Vec<TextureCube<'static>>,
    channels: usize,
}

#[pymethods]
impl Cube {
    /// From flat texels of six faces +X -X +Y -Y +Z -Z, one after the other.
    #[new]
    fn new(
        py: Python<'_>,
        texels: PyReadonlyArray1<'_, f32>,
        side: u32,
        channels: usize,
        mips: bool,
    ) -> PyResult<Self> {
        let texels = texels.as_slice()?;
        let face = side as usize * side as usize * channels;
        expect_length("the cube", texels.len(), 6 * face)?;
        py.detach(|| {
            let made = (0..channels).step_by(4).map(|first| {
                let count = (channels - first).min(4);
                let faces: [Group; 6] = std::array::from_fn(|k| {
                    let face = TexelData::F32(&texels[k * face..(k + 1) * face]);
                    Group::of(face, channels, first, count)
                });
                let images = faces.each_ref().map(|group| Image {
                    width: side,
                    height: side,
                    channels: count as u32,
                    texels: group.data(),
                    color: ColorSpace::Linear,
                    alpha: Alpha::Data,
                    origin: Origin::TopLeft,
                });
                let cube = TextureCube::new(&images).map_err(value)?;
                Ok(if mips { cube.with_mips() } else { cube })
            });
            Ok(Self {
                groups: made.collect::<PyResult<_>>()?,
                channels,
            })
        })
    }
}

/// Look-ups in a cube at flat directions (three each), with flat derivatives (six each: dx/dX, dx/dY, dy/dX, ..) or none. Zero and
/// non-finite directions give 0.
#[pyfunction]
#[pyo3(signature = (cube, directions, da, bias, out, filter, max_level, threads))]
pub(crate) fn sample_cube(
    py: Python<'_>,
    cube: &Cube,
    directions: PyReadonlyArray1<'_, f32>,
    da: Option<PyReadonlyArray1<'_, f32>>,
    bias: Option<PyReadonlyArray1<'_, f32>>,
    mut out: PyReadwriteArray1<'_, f32>,
    filter: &str,
    max_level: f32,
    threads: Option<Threads>,
) -> PyResult<()> {
    let directions = directions.as_slice()?;
    let out = out.as_slice_mut()?;
    let channels = cube.channels;
    let count = directions.len() / 3;
    expect_length("out", out.len(), count * channels)?;
    let by_levels = ByLevels::new(filter, "cube", max_level, (&da, 6), &bias, count)?;
    let ByLevels { sampler, da, bias } = by_levels;
    unlocked(py, threads, || {
        out.par_chunks_mut(channels)
            .enumerate()
            .for_each(|(k, out)| {
                let d = [
                    directions[3 * k],
                    directions[3 * k + 1],
                    directions[3 * k + 2],
                ];
                if d == [0.0; 3] || !d.iter().all(|c| c.is_finite()) {
                    out.fill(0.0);
                    return;
                }
                let shift = bias.map_or(0.0, |bias| bias[k]);
                let mut own = sampler.clone();
                own.lod.bias = shift;
                for (cube, out) in cube.groups.iter().zip(out.chunks_mut(4)) {
                    let color = match da {
                        Some(da) => {
                            let of = |axis: usize| [0, 2, 4].map(|c| da[6 * k + c + axis]);
                            own.sample_cube_grad(cube, d, of(0), of(1))
                        }
                        None => sampler.sample_cube(cube, d, shift),
                    };
                    out.copy_from_slice(&color[..out.len()]);
                }
            });
    })
}
