//! Texture coordinates of a fragment: from the vertices, or per pixel from a texture frame or a round shape.

use texmap_math::CameraFrame;
use texmap_math::Footprint;
use texmap_math::ViewRays;
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::Fragment;
use texmap_uv::PixelMapping;

/// Where texture coordinates come from.
pub(crate) enum Coordinates {
    None,
    /// Attributes 0 and 1.
    Vertices,
    Frame(CameraFrame),
    /// A shape in world space, and the first of the attributes that hold the world position.
    Round(PixelMapping, usize),
}

impl Coordinates {
    /// Coordinates of a fragment; `None` if the mesh has none there.
    pub(crate) fn at(&self, fragment: &Fragment) -> Option<([f32; 2], Footprint)> {
        match self {
            Self::None => None,
            Self::Vertices => Some(attributes(fragment, 0)),
            Self::Frame(frame) => frame.uv(fragment.pixel[0], fragment.pixel[1]),
            Self::Round(map, first) => {
                let three = |of: &[f32]| [of[*first], of[first + 1], of[first + 2]];
                let Fragment {
                    values, ddx, ddy, ..
                } = fragment;
                Some(map.one(three(values), three(ddx), three(ddy)))
            }
        }
    }
}

/// Coordinates among the attributes of a fragment, from this one on, and their footprint.
pub(crate) fn attributes(fragment: &Fragment, first: usize) -> ([f32; 2], Footprint) {
    let Fragment {
        values, ddx, ddy, ..
    } = fragment;
    let d = Footprint {
        du_dx: ddx[first],
        dv_dx: ddx[first + 1],
        du_dy: ddy[first],
        dv_dy: ddy[first + 1],
    };
    ([values[first], values[first + 1]], d)
}

/// Directions to the eye from what is seen at the samples of a grid, world space. Their length is that of the ray where it is 1 along the
/// camera's axis, so that they change evenly from sample to sample.
#[derive(Clone, Copy)]
pub(crate) struct EyeRays {
    /// At the middle of the picture.
    middle: [f32; 3],
    /// From the middle to the centre of the first sample, in samples.
    first: [f32; 2],
    /// Change per sample to the right.
    pub(crate) dx: [f32; 3],
    /// Change per sample down.
    pub(crate) dy: [f32; 3],
}

impl EyeRays {
    pub(crate) fn new(rays: &ViewRays, view_from_world: DMat4) -> Self {
        let world_from_view = view_from_world.inverse();
        let world = |v: DVec3| {
            let v = world_from_view.transform_vector3(v);
            v.to_array().map(|c| c as f32)
        };
        let [right, up] = rays.half_step().map(|half| 2.0 * half);
        Self {
            middle: world(DVec3::Z),
            first: rays.size().map(|size| (0.5 - 0.5 * size) as f32),
            dx: world(DVec3::X * -right),
            dy: world(DVec3::Y * up),
        }
    }

    /// The directions `off` samples beside.
    pub(crate) fn beside(&self, off: [f64; 2]) -> Self {
        let [x, y] = off.map(|c| c as f32);
        Self {
            middle: [0, 1, 2].map(|i| self.middle[i] + (self.dx[i] * x + self.dy[i] * y)),
            ..*self
        }
    }

    /// At the centre of a sample.
    pub(crate) fn at(&self, [x, y]: [u32; 2]) -> [f32; 3] {
        let (x, y) = (x as f32 + self.first[0], y as f32 + self.first[1]);
        [0, 1, 2].map(|i| self.middle[i] + (self.dx[i] * x + self.dy[i] * y))
    }

    /// [`at`](Self::at) for the 4 x 4 samples from one on.
    #[inline(always)]
    pub(crate) fn block<S: Simd>(&self, s: S, [x, y]: [u32; 2]) -> [f32x16<S>; 3] {
        let column = [
            0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.,
        ];
        let row = [
            0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.,
        ];
        // Whole numbers and halves: nothing is rounded.
        let x = f32x16::from_slice(s, &column) + (x as f32 + self.first[0]);
        let y = f32x16::from_slice(s, &row) + (y as f32 + self.first[1]);
        [
            x * self.dx[0] + y * self.dy[0] + self.middle[0],
            x * self.dx[1] + y * self.dy[1] + self.middle[1],
            x * self.dx[2] + y * self.dy[2] + self.middle[2],
        ]
    }
}
