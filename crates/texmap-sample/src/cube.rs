mod edges;
mod kernel;

pub use kernel::{DirectionBatch, sample_cube_soa};

use crate::{
    address::lod,
    error::SampleError,
    mip,
    sampler::{Precision, Sampler},
    texel_data::Chain,
    texture::{Image, Texture2d, check_size},
    upload::{MAX_WORDS, choose_format, upload},
};
use alloc::vec::Vec;
use kernel::FaceVector;
use texmap_math::simd::{One, Scalar, prelude::*};

/// Six square faces around a point: +X -X +Y -Y +Z -Z, oriented as OpenGL and Vulkan have them.
///
/// Linear filters are seamless: beyond an edge lie the neighbour face's texels, and the missing
/// texel at a corner is the mean of the three that are there (ARB_seamless_cube_map).
#[derive(Clone, Debug)]
pub struct TextureCube<'a> {
    chain: Chain<'a>,
}

impl TextureCube<'static> {
    /// From six images of equal square size. Their rows count from the top, whatever their [`origin`](Image::origin) is.
    ///
    /// # Errors
    /// As [`Texture2d::new`]; a face that is not square or unlike the first.
    pub fn new(faces: &[Image<'_>; 6]) -> Result<Self, SampleError> {
        let first = faces[0];
        check_size(first.width, first.height)?;
        let texels = 6 * first.check(1)? as u64;
        if texels * choose_format(&first).words() as u64 > MAX_WORDS as u64 {
            return Err(SampleError::TooLarge {
                width: first.width,
                height: first.height,
            });
        }
        let mut words = Vec::new();
        let mut chain: Option<Chain<'static>> = None;
        for face in faces {
            if face.width != first.width || face.height != first.width {
                return Err(SampleError::Size {
                    width: face.width,
                    height: face.height,
                });
            }
            let c = upload(face, 1)?;
            if chain.as_ref().is_some_and(|first| first.format != c.format) {
                // One face with soft alpha needs 16 bits, so all get them.
                return Self::with_wide_faces(faces);
            }
            words.extend_from_slice(c.words());
            chain = Some(match chain {
                None => c,
                Some(first) => Chain {
                    opaque: first.opaque && c.opaque,
                    ..first
                },
            });
        }
        let Some(mut chain) = chain else {
            return Err(SampleError::Size {
                width: 0,
                height: 0,
            });
        };
        chain.words = crate::texel_data::Words::Owned(alloc::sync::Arc::new(words));
        chain.levels[0].depth = 6;
        chain.flip = false;
        Ok(Self { chain })
    }

    fn with_wide_faces(faces: &[Image<'_>; 6]) -> Result<Self, SampleError> {
        let mut wide = Vec::new();
        for face in faces {
            // Faces of a cube have their rows from the top.
            let t = Texture2d::new(&Image {
                origin: crate::texture::Origin::TopLeft,
                ..*face
            })?;
            for y in 0..face.height {
                for x in 0..face.width {
                    wide.extend(t.texel(0, x, y).unwrap_or_default());
                }
            }
        }
        let n = faces[0].width as usize;
        let image = |i: usize| Image {
            channels: 4,
            texels: crate::texel_data::TexelData::F32(&wide[i * n * n * 4..(i + 1) * n * n * 4]),
            color: crate::texture::ColorSpace::Linear,
            alpha: crate::texture::Alpha::Premultiplied,
            origin: crate::texture::Origin::TopLeft,
            ..faces[0]
        };
        Self::new(&[0, 1, 2, 3, 4, 5].map(image))
    }

    /// With the mip chain of each face.
    #[must_use]
    pub fn with_mips(self) -> Self {
        Self {
            chain: mip::build(self.chain, mip::Reduce::Mean),
        }
    }
}

impl TextureCube<'_> {
    /// Texels along an edge of level 0.
    pub fn side(&self) -> u32 {
        self.chain.levels[0].width as u32
    }

    /// Levels of the chain.
    pub fn levels(&self) -> u32 {
        self.chain.levels.len() as u32
    }
}

/// Face (0 to 5) of a direction and s, t in `[0, 1]` there, within 2^-23. Ties go to z before y before x (Vulkan 1.4, "Cube
/// Map Face Selection"). The zero vector and vectors that are not finite read as +Z.
pub fn cube_face(direction: [f32; 3]) -> (usize, [f32; 2]) {
    let (place, usual) = FaceVector::new(Scalar, direction);
    let [s, t] = place.coordinates(Scalar, usual);
    (place.face.0 as usize, [s, t])
}

/// The direction through (s, t) of a face, with the major axis at length 1.
pub fn cube_direction(face: usize, [s, t]: [f64; 2]) -> [f64; 3] {
    let (s, t) = (2.0 * s - 1.0, 2.0 * t - 1.0);
    match face {
        0 => [1.0, -t, -s],
        1 => [-1.0, -t, s],
        2 => [s, 1.0, t],
        3 => [s, -1.0, -t],
        4 => [s, -t, 1.0],
        _ => [-s, -t, -1.0],
    }
}

impl Sampler {
    /// The colour in a direction (any length) at a level of detail. Wrap modes do not apply; filters
    /// beyond trilinear take their trilinear form.
    pub fn sample_cube(&self, t: &TextureCube<'_>, direction: [f32; 3], lod: f32) -> [f32; 4] {
        kernel::sample(self, t, direction, lod)
    }

    /// The colour in a direction that changes by `dx` and `dy` per pixel step.
    pub fn sample_cube_grad(
        &self,
        t: &TextureCube<'_>,
        direction: [f32; 3],
        dx: [f32; 3],
        dy: [f32; 3],
    ) -> [f32; 4] {
        let (at, _) = FaceVector::new(Scalar, direction);
        let (One(face), [s, tc], m) = (at.face, at.across, at.major);
        let n = t.chain.levels[0].width as f32;
        // Lengths whose squares leave f32 are divided by first.
        let usual = m > 1e-12 && m < 1e15;
        let by = if usual { 1.0 } else { m };
        let [s, tc, m] = if usual {
            [s, tc, m]
        } else {
            [s / m, tc / m, 1.0]
        };
        // The quotient rule on sc / |major| and tc / |major| (Vulkan 1.4, "Cube Map Derivative
        // Transformation"); 0.5 n texels per unit.
        let slope2 = |d: [f32; 3]| {
            let [ds, dt, dm] = on_face(face as usize, d.map(|c| c / by));
            let du = 0.5 * n * (ds * m - s * dm) / (m * m);
            let dv = 0.5 * n * (dt * m - tc * dm) / (m * m);
            let r = du * du + dv * dv;
            if r.is_nan() { 0.0 } else { r }
        };
        let (x, y) = (slope2(dx), slope2(dy));
        let rho2 = if x > y { x } else { y };
        let rho2 = if rho2 > 1e36 { 1e36 } else { rho2 };
        let lod = match self.precision {
            Precision::Exact => 0.5 * lod::log2(Scalar, rho2),
            Precision::Fast => lod::log2_sqrt_fixed(Scalar, rho2).to_f32() / 256.0,
        };
        self.sample_cube(t, direction, lod)
    }
}

/// Components of a vector along sc, tc and the major axis of a face.
const fn on_face(face: usize, [x, y, z]: [f32; 3]) -> [f32; 3] {
    match face {
        0 => [-z, -y, x],
        1 => [z, -y, -x],
        2 => [x, z, y],
        3 => [x, -z, -y],
        4 => [x, -y, z],
        _ => [-x, -y, -z],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texel_data::TexelData;
    use crate::texture::{Alpha, ColorSpace, Origin};

    fn face(side: u32, texels: &[f32]) -> Image<'_> {
        Image {
            width: side,
            height: side,
            channels: 1,
            texels: TexelData::F32(texels),
            color: ColorSpace::Linear,
            alpha: Alpha::Data,
            origin: Origin::TopLeft,
        }
    }

    /// Six faces are one list of words: each alone would fit.
    #[test]
    fn faces_that_are_too_large_together_are_refused() {
        let side = 16_384;
        let texels = alloc::vec![0; (side * side) as usize];
        let face = Image {
            texels: TexelData::U8(&texels),
            color: ColorSpace::Linear,
            ..face(side, &[])
        };
        let refused = TextureCube::new(&[face; 6]);
        assert!(matches!(refused, Err(SampleError::TooLarge { .. })));
    }

    /// A footprint is that of a direction of length 1, whatever its length is.
    #[test]
    fn levels_do_not_depend_on_the_length_of_a_direction() {
        let texels: Vec<f32> = (0..64 * 64)
            .map(|i| (i % 64 % 3 + i / 64 % 2) as f32)
            .collect();
        let t = TextureCube::new(&[face(64, &texels); 6])
            .unwrap()
            .with_mips();
        let s = Sampler::default();
        for d in [[0.2, 0.3, 1.0], [-1.0, 0.4, 0.1]] {
            let seen = |k: f32| {
                let by = |v: [f32; 3]| v.map(|c| c * k);
                s.sample_cube_grad(&t, by(d), by([0.0, 0.09, 0.02]), by([0.03, 0.0, 0.05]))[0]
            };
            let base = s.sample_cube(&t, d, 0.0)[0];
            assert!((seen(1.0) - base).abs() > 0.05, "{} {base}", seen(1.0));
            for k in [1e-30, 1e-10, 1e10, 1e20, 1e30] {
                assert!(
                    (seen(k) - seen(1.0)).abs() < 1e-3,
                    "{k}: {} {}",
                    seen(k),
                    seen(1.0)
                );
            }
        }
    }
}
