//! Texture coordinates of fragments: from the vertices, or per pixel from a texture frame or a round shape.

use texmap_math::glam::{DMat4, DVec3};
use texmap_math::simd::Isa;
use texmap_math::{CameraFrame, Footprint, Level, ViewRays};
use texmap_raster::{Fragment, Varying, Varyings};
use texmap_uv::PerPixelProjection;

use crate::batch::{Batch, LANES, columns};

/// The source of texture coordinates.
pub enum Coordinates {
    /// No stage reads a texture by coordinates.
    None,
    /// Attributes 0 and 1.
    Vertices,
    /// Coordinates of the camera's own frame.
    Frame(CameraFrame),
    /// A shape in world space, and the first of the attributes that hold the world position.
    Round(PerPixelProjection, usize),
}

/// Lists of the fragments of a batch: positions and their changes right and down, uv, footprints.
#[derive(Default)]
pub(crate) struct UvScratch {
    moves: [Vec<[f32; 3]>; 3],
    uv: Vec<[f32; 2]>,
    footprint: Vec<Footprint>,
}

impl Coordinates {
    /// Coordinates of a fragment; `None` if the mesh has none there.
    pub fn at(&self, fragment: &Fragment) -> Option<([f32; 2], Footprint)> {
        let Fragment {
            values, ddx, ddy, ..
        } = fragment;
        match self {
            Self::None => None,
            Self::Vertices => Some(uv_of_attributes(fragment, 0)),
            Self::Frame(frame) => frame.uv(fragment.pixel[0], fragment.pixel[1]),
            Self::Round(map, first) => {
                let three = |of: &[f32]| [of[*first], of[first + 1], of[first + 2]];
                Some(map.uv_at(three(values), three(ddx), three(ddy)))
            }
        }
    }

    /// Coordinates of a batch and their changes as columns 0 and 1: those of its attributes, or computed into `out`; 0 where a mesh has
    /// none.
    pub(crate) fn columns<'c>(
        &self,
        level: Level,
        batch: &Batch<'c>,
        scratch: &mut UvScratch,
        out: &'c mut Varyings,
    ) -> &'c Varyings {
        let UvScratch {
            moves,
            uv,
            footprint,
        } = scratch;
        uv.clear();
        footprint.clear();
        match self {
            Self::Vertices => return batch.values,
            Self::None => {
                uv.resize(batch.list.len() * LANES, [0.0; 2]);
                footprint.resize(uv.len(), Footprint::default());
            }
            Self::Frame(frame) => {
                for (_, at, bit) in batch.fragments() {
                    let [x, y] = batch.sample(at, bit);
                    let (place, d) = frame.uv(x, y).unwrap_or_default();
                    uv.push(place);
                    footprint.push(d);
                }
            }
            Self::Round(map, first) => {
                let position: &[Varying; 3] = columns(batch.values, *first);
                let [points, dx, dy] = moves;
                for list in [&mut *points, &mut *dx, &mut *dy] {
                    list.clear();
                }
                for (at, ..) in batch.fragments() {
                    points.push(position.each_ref().map(|c| c.value[at]));
                    dx.push(position.each_ref().map(|c| c.ddx[at]));
                    dy.push(position.each_ref().map(|c| c.ddy[at]));
                }
                uv.resize(points.len(), [0.0; 2]);
                footprint.resize(points.len(), Footprint::default());
                map.uv_batch(level, points, dx, dy, uv, footprint)
                    .expect("the lists have one length");
            }
        }
        out.varyings.resize(2, Varying::ZERO);
        for ((at, ..), (uv, d)) in batch.fragments().zip(uv.iter().zip(footprint)) {
            let changes = [[d.du_dx, d.du_dy], [d.dv_dx, d.dv_dy]];
            for ((column, value), [dx, dy]) in out.varyings.iter_mut().zip(uv).zip(changes) {
                column.value[at] = *value;
                column.ddx[at] = dx;
                column.ddy[at] = dy;
            }
        }
        out
    }
}

/// Coordinates that are attributes of a fragment, from this one on.
pub fn uv_of_attributes(fragment: &Fragment, first: usize) -> ([f32; 2], Footprint) {
    let Fragment {
        values, ddx, ddy, ..
    } = fragment;
    let (u, v) = (first, first + 1);
    let d = Footprint::new(ddx[u], ddx[v], ddy[u], ddy[v]);
    ([values[u], values[v]], d)
}

/// Directions to the eye from the samples of a grid, world space. Their length is that of the ray where it is 1 along the camera's axis,
/// so that they change evenly from sample to sample.
#[derive(Clone, Copy)]
pub struct EyeRays {
    /// Direction at the middle of the picture.
    middle: [f32; 3],
    /// Vector from the middle to the centre of the first sample, in samples.
    first: [f32; 2],
    /// Change per sample to the right.
    pub(crate) dx: [f32; 3],
    /// Change per sample down.
    pub(crate) dy: [f32; 3],
}

impl EyeRays {
    /// Rays of a perspective view.
    pub fn new(rays: &ViewRays, view_from_world: DMat4) -> Self {
        let world_from_view = view_from_world.inverse();
        let world = |v: DVec3| {
            let v = world_from_view.transform_vector3(v);
            v.to_array().map(|c| c as f32)
        };
        let [right, up] = rays.half_step().map(|half| 2.0 * half);
        Self {
            middle: world(DVec3::Z),
            first: {
                let ([width, height], [x, y]) = (rays.size(), rays.center());
                [0.5 - 0.5 * (width + x), 0.5 - 0.5 * (height - y)].map(|first| first as f32)
            },
            dx: world(DVec3::X * -right),
            dy: world(DVec3::Y * up),
        }
    }

    /// The directions of a parallel projection, which are one.
    pub fn parallel(view_from_world: DMat4) -> Self {
        let back = view_from_world.inverse().transform_vector3(DVec3::Z);
        Self {
            middle: back.to_array().map(|c| c as f32),
            first: [0.0; 2],
            dx: [0.0; 3],
            dy: [0.0; 3],
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

    /// The directions from `pixel` on of the 4 x 4 samples whose first is `[x, y]`.
    #[inline(always)]
    pub(crate) fn part<I: Isa>(&self, i: I, [x, y]: [u32; 2], pixel: usize) -> [I::F32; 3] {
        let column = [
            0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.,
        ];
        let row = [
            0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.,
        ];
        // Whole numbers and halves: nothing is rounded.
        let x = i.load_f32(&column[pixel..]) + (x as f32 + self.first[0]);
        let y = i.load_f32(&row[pixel..]) + (y as f32 + self.first[1]);
        [
            x * self.dx[0] + y * self.dy[0] + self.middle[0],
            x * self.dx[1] + y * self.dy[1] + self.middle[1],
            x * self.dx[2] + y * self.dy[2] + self.middle[2],
        ]
    }
}
