#[path = "cube/kernel.rs"]
mod lanes;

pub use lanes::{Directions, sample_cube_columns};

use crate::{
    error::SampleError,
    filter::{across_levels, floor, level_of, mix_four},
    mip,
    sampler::{Sampler, Texel},
    texels::{Chain, Level, scaled},
    texture::{Image, Texture2d, check_size, upload},
};
use alloc::vec::Vec;

/// Six square faces around a point: +X -X +Y -Y +Z -Z, oriented as OpenGL and Vulkan have them.
///
/// Linear filters are seamless: beyond an edge lie the neighbour face's texels, and the missing
/// texel at a corner is the mean of the three that are there (ARB_seamless_cube_map).
#[derive(Clone, Debug)]
pub struct TextureCube<'a> {
    chain: Chain<'a>,
}

impl TextureCube<'static> {
    /// From six images of equal square size.
    ///
    /// # Errors
    /// As [`Texture2d::new`]; a face that is not square or unlike the first.
    pub fn new(faces: &[Image<'_>; 6]) -> Result<Self, SampleError> {
        let first = faces[0];
        check_size(first.width, first.height)?;
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
        chain.words = crate::texels::Words::Owned(alloc::sync::Arc::new(words));
        chain.levels[0].depth = 6;
        chain.flip = false;
        Ok(Self { chain })
    }

    fn with_wide_faces(faces: &[Image<'_>; 6]) -> Result<Self, SampleError> {
        let mut wide = Vec::new();
        for face in faces {
            let t = Texture2d::new(face)?;
            for y in 0..face.height {
                for x in 0..face.width {
                    wide.extend(t.texel(0, x, y).unwrap_or_default());
                }
            }
        }
        let n = faces[0].width as usize;
        let image = |i: usize| Image {
            channels: 4,
            texels: crate::texels::Texels::F32(&wide[i * n * n * 4..(i + 1) * n * n * 4]),
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
    let (face, [s, t, m]) = select_face(direction);
    let total = direction.map(f32::abs).iter().sum::<f32>();
    let place = if (USUAL[0]..=USUAL[1]).contains(&total) {
        let k = 0.5 / m;
        [s * k, t * k]
    } else {
        [0.5 * (s / m), 0.5 * (t / m)]
    };
    (face, place.map(|c| c + 0.5))
}

/// Sums of components that are finite and whose reciprocals lose nothing.
const USUAL: [f32; 2] = [1e-30, 1e30];

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

/// Face and (sc, tc, |major|).
fn select_face([x, y, z]: [f32; 3]) -> (usize, [f32; 3]) {
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let finite = ax <= f32::MAX && ay <= f32::MAX && az <= f32::MAX;
    if !finite || (ax == 0.0 && ay == 0.0 && az == 0.0) {
        (4, [0.0, 0.0, 1.0])
    } else if az >= ax && az >= ay {
        if z > 0.0 {
            (4, [x, -y, az])
        } else {
            (5, [-x, -y, az])
        }
    } else if ay >= ax {
        if y > 0.0 {
            (2, [x, z, ay])
        } else {
            (3, [x, -z, ay])
        }
    } else if x > 0.0 {
        (0, [-z, -y, ax])
    } else {
        (1, [z, -y, ax])
    }
}

impl Sampler {
    /// The colour in a direction (any length) at a level of detail. Wrap modes do not apply; filters
    /// beyond trilinear take their trilinear form.
    pub fn sample_cube(&self, t: &TextureCube<'_>, direction: [f32; 3], lod: f32) -> [f32; 4] {
        let chain = &t.chain;
        let place = cube_face(direction);
        let lod = self.limit_lod(lod);
        let c = across_levels(self.filter, chain, lod, |level, texel| {
            in_face(chain, level, place, texel)
        });
        let scale = chain.format.scale();
        scaled(c, scale)
    }

    /// The colour in a direction that changes by `dx` and `dy` per pixel step.
    pub fn sample_cube_grad(
        &self,
        t: &TextureCube<'_>,
        direction: [f32; 3],
        dx: [f32; 3],
        dy: [f32; 3],
    ) -> [f32; 4] {
        let (face, [s, tc, m]) = select_face(direction);
        let n = t.chain.levels[0].width as f32;
        // The quotient rule on sc / |major| and tc / |major| (Vulkan 1.4, "Cube Map Derivative
        // Transformation"); 0.5 n texels per unit.
        let slope2 = |d: [f32; 3]| {
            let [ds, dt, dm] = on_face(face, d);
            let du = 0.5 * n * (ds * m - s * dm) / (m * m);
            let dv = 0.5 * n * (dt * m - tc * dm) / (m * m);
            let r = du * du + dv * dv;
            if r.is_nan() { 0.0 } else { r }
        };
        let (x, y) = (slope2(dx), slope2(dy));
        let rho2 = if x > y { x } else { y };
        let rho2 = if rho2 > 1e36 { 1e36 } else { rho2 };
        self.sample_cube(t, direction, level_of(self, rho2))
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

fn in_face(
    t: &Chain<'_>,
    level: &Level,
    (face, [s, v]): (usize, [f32; 2]),
    texel: Texel,
) -> [f32; 4] {
    let n = level.width;
    let (x, y) = (s * n as f32, v * n as f32);
    if texel == Texel::Nearest {
        return t.fetch(
            level,
            floor(x).clamp(0, n - 1),
            floor(y).clamp(0, n - 1),
            face as i32,
        );
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (i, j) = (floor(x), floor(y));
    let (wx, wy) = (x - i as f32, y - j as f32);
    let inside = i >= 0 && j >= 0 && i + 1 < n && j + 1 < n;
    let texels = if inside {
        t.fetch_four(level, [i, i + 1], [j, j + 1], face as i32)
    } else {
        [
            seamless(t, level, face, i, j),
            seamless(t, level, face, i + 1, j),
            seamless(t, level, face, i, j + 1),
            seamless(t, level, face, i + 1, j + 1),
        ]
    };
    mix_four(texels, wx, wy)
}

/// A texel of a face or, one step beyond its edge, of the neighbour.
fn seamless(t: &Chain<'_>, level: &Level, face: usize, i: i32, j: i32) -> [f32; 4] {
    let n = level.width;
    let (ci, cj) = (i.clamp(0, n - 1), j.clamp(0, n - 1));
    match (ci == i, cj == j) {
        (true, true) => t.fetch(level, i, j, face as i32),
        (true, false) | (false, true) => beyond(t, level, face, i, j),
        (false, false) => {
            let a = t.fetch(level, ci, cj, face as i32);
            let b = beyond(t, level, face, i, cj);
            let c = beyond(t, level, face, ci, j);
            // The mean over differences keeps a constant cube constant.
            [0, 1, 2, 3].map(|k| a[k] + ((b[k] - a[k]) + (c[k] - a[k])) / 3.0)
        }
    }
}

/// The texel half a texel past one edge: its centre's direction lies inside the neighbour's border
/// texel of the same place along the edge, at every size.
fn beyond(t: &Chain<'_>, level: &Level, face: usize, i: i32, j: i32) -> [f32; 4] {
    let n = f64::from(level.width);
    let d = cube_direction(face, [(f64::from(i) + 0.5) / n, (f64::from(j) + 0.5) / n]);
    let major = (0..3).fold(
        0,
        |best, k| if d[k].abs() > d[best].abs() { k } else { best },
    );
    let neighbour = 2 * major + usize::from(d[major] < 0.0);
    let [x, y, z] = d;
    let m = d[major].abs();
    let (s, v) = match neighbour {
        0 => (-z, -y),
        1 => (z, -y),
        2 => (x, z),
        3 => (x, -z),
        4 => (x, -y),
        _ => (-x, -y),
    };
    let index = |c: f64| (((c / m + 1.0) * 0.5 * n) as i32).clamp(0, level.width - 1);
    t.fetch(level, index(s), index(v), neighbour as i32)
}
