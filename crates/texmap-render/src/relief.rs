//! What turns the normal of a sample without moving the surface: bump and offset maps, carvings, normal maps.

use texmap_light::lanes::{V3, bump_on as bump_lanes};
use texmap_light::{Green, NormalMap, bump_on, decode_offsets, unit};
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_math::glam::{DMat3, DVec3};
use texmap_math::lanes::above;
use texmap_math::simd::{Scalar, X16};
use texmap_math::{Footprint, Level, narrow, wide};
use texmap_raster::RunValues;
use texmap_sample::Origin;
use texmap_sample::sample_columns;

use crate::canvas::{Colors, LANES, straight_lanes};
use crate::carved::Carved;
use crate::lit::{Sample, Site};
use crate::shade::three;
use crate::texel::{RunUv, places};
use crate::textures::Slot;
use crate::vertices::{Values, Vertices};
use texmap_math::color::straight;
use texmap_scene::{Mesh, Relief};

/// A relief, as the stages read it.
pub(crate) enum ReliefStage<'s> {
    /// A height map.
    Bump(Slot<'s>, Rise),
    /// A map of slopes.
    Offsets(Slot<'s>, Rise, Green),
    Carved(Carved),
    NormalMap(Slot<'s>, NormalMap, Space),
}

/// How far a value of 1 rises.
#[derive(Clone, Copy)]
pub(crate) struct Rise {
    /// Units of the object.
    height: f32,
    /// World units of one of them.
    unit: f32,
}

/// What the vectors of a normal map are relative to.
#[derive(Clone, Copy)]
pub(crate) enum Space {
    /// The object; normals go to the world by this.
    Object(DMat3),
    /// Tangent frames, which are attributes from here on.
    Tangent(usize),
}

impl<'s> ReliefStage<'s> {
    /// Asks for the attributes that it reads; the caller sees to uv, normals and positions.
    pub(crate) fn new(
        relief: &'s Relief,
        mesh: &Mesh,
        vertices: &mut Vertices,
        slot: impl Fn(&'s texmap_scene::TextureSlot) -> Slot<'s>,
    ) -> Self {
        let unit = unit_of(mesh);
        let rise = |height| Rise {
            height,
            unit: unit as f32,
        };
        match relief {
            Relief::Bump { slot: map, height } => Self::Bump(slot(map), rise(*height)),
            Relief::Offsets {
                slot: map,
                slope,
                green,
            } => Self::Offsets(slot(map), rise(*slope), *green),
            Relief::Carved {
                heights,
                world_from_solid,
                height,
            } => {
                let height = (f64::from(*height) * unit) as f32;
                Self::Carved(Carved::new(*heights, *world_from_solid, height))
            }
            Relief::NormalMap {
                slot: map,
                green,
                rebuild_z,
                object_space,
                strength,
            } => {
                let space = if *object_space {
                    Space::Object(
                        DMat3::from_mat4(mesh.world_from_object)
                            .inverse()
                            .transpose(),
                    )
                } else {
                    Space::Tangent(vertices.push(Values::Tangent, false))
                };
                let decoder = NormalMap {
                    green: *green,
                    rebuild_z: *rebuild_z,
                    strength: *strength,
                };
                Self::NormalMap(slot(map), decoder, space)
            }
        }
    }

    /// The unit normal that it leaves of an interpolated one on the side that is seen.
    pub(crate) fn normal(
        &self,
        at: &Sample<'_>,
        normal: [f32; 3],
        uv: ([f32; 2], Footprint),
    ) -> [f32; 3] {
        let n = unit(normal);
        match self {
            Self::Carved(carved) => carved.normal(&at.site, n),
            Self::Bump(slot, rise) => bumped(&at.site, n, slot.place(uv.0, uv.1), |place, d| {
                heights(slot, place, d).map(|c| c * rise.height * rise.unit)
            }),
            Self::Offsets(slot, rise, green) => {
                bumped(&at.site, n, slot.place(uv.0, uv.1), |place, d| {
                    let [r, g, _] = straight(slot.sampler.sample_grad(&slot.texture, place, d));
                    let [along_u, along_v] = decode_offsets([r, g], *green);
                    // The slot counts v down the picture, or up it from a bottom-left origin.
                    let down = match slot.texture.origin() {
                        Origin::TopLeft => along_v,
                        Origin::BottomLeft => -along_v,
                    };
                    [along_u, down].map(|c| c * rise.height * rise.unit)
                })
            }
            Self::NormalMap(slot, map, space) => {
                let texel = straight(slot.texel(uv.0, uv.1));
                let front = at.fragment.front;
                match *space {
                    Space::Object(normal_to_world) => {
                        let world = normal_to_world * wide(map.decode(Scalar, texel));
                        unit(narrow(if front { world } else { -world }))
                    }
                    Space::Tangent(first) => {
                        let [x, y, z] = three(at.fragment, first);
                        let sign = at.fragment.values[first + 3];
                        // The frame belongs to the front; on the back N and so B are turned round with it.
                        let sign = if front { sign } else { -sign };
                        let sign = if sign < 0.0 { -1.0 } else { 1.0 };
                        map.turn(Scalar, n, [x, y, z], sign, texel)
                    }
                }
            }
        }
    }
}

/// Blinn's normal on the unit normal `n`, with O_u and O_v from the analytic change of position and coordinates from pixel to pixel
/// and the slopes that `slopes` finds there.
fn bumped(
    at: &Site,
    n: [f32; 3],
    (place, d): ([f32; 2], Footprint),
    slopes: impl Fn([f32; 2], Footprint) -> [f32; 2],
) -> [f32; 3] {
    let det = d.du_dx * d.dv_dy - d.dv_dx * d.du_dy;
    if det == 0.0 || !det.is_finite() {
        return n;
    }
    let (px, py) = (at.position_dx, at.position_dy);
    let o_u = [0, 1, 2].map(|i| (px[i] * d.dv_dy - py[i] * d.dv_dx) / det);
    let o_v = [0, 1, 2].map(|i| (py[i] * d.du_dx - px[i] * d.du_dy) / det);
    let [b_u, b_v] = slopes(place, d);
    bump_on(n, o_u, o_v, b_u, b_v)
}

/// Slopes of a relief over a run, and where it is read.
pub(crate) struct SlopeTexels {
    /// Coordinates of the slot.
    placed: RunValues,
    /// What is looked up beside them.
    beside: RunUv,
    colors: Colors,
    /// Rise along u and v.
    slopes: RunUv,
}

impl Default for SlopeTexels {
    fn default() -> Self {
        Self {
            placed: RunValues::default(),
            beside: RunUv::default(),
            colors: Colors::new(),
            slopes: RunUv::default(),
        }
    }
}

impl ReliefStage<'_> {
    /// The slopes that a bump or offset map has over `blocks` blocks, at columns 0 and 1 of `uv`.
    #[inline(always)]
    pub(crate) fn slopes<S: Simd>(
        &self,
        s: S,
        level: Level,
        uv: &RunValues,
        blocks: usize,
        out: &mut SlopeTexels,
    ) {
        let (Self::Bump(slot, rise) | Self::Offsets(slot, rise, _)) = self else {
            return;
        };
        out.placed.columns.clear();
        out.placed
            .columns
            .extend(uv.columns.iter().take(2).cloned());
        slot.place_columns(&mut out.placed, blocks * LANES);
        match self {
            Self::Offsets(_, _, green) => {
                out.look_up(level, slot, blocks, false);
                let up = (*green == Green::Up) != (slot.texture.origin() == Origin::BottomLeft);
                for i in 0..blocks {
                    let [r, g, _] = straight_lanes(s, out.colors.lanes(s, i));
                    let (x, y) = (r * 2.0 - 1.0, g * 2.0 - 1.0);
                    let y = if up { -y } else { y };
                    out.put(i, [x, y], rise);
                }
            }
            _ => {
                let texels = [
                    1.0 / slot.texture.width() as f32,
                    1.0 / slot.texture.height() as f32,
                ];
                for (axis, texel) in texels.into_iter().enumerate() {
                    for i in 0..blocks {
                        out.step_aside(s, i, axis, texel, false);
                    }
                    out.look_up(level, slot, blocks, true);
                    for i in 0..blocks {
                        let [above, ..] = straight_lanes(s, out.colors.lanes(s, i));
                        let mut slopes = out.slopes.at(s, i);
                        slopes[axis] = above;
                        out.slopes.put(i, slopes);
                        out.step_aside(s, i, axis, texel, true);
                    }
                    out.look_up(level, slot, blocks, true);
                    for i in 0..blocks {
                        let [below, ..] = straight_lanes(s, out.colors.lanes(s, i));
                        let mut slopes = out.slopes.at(s, i);
                        slopes[axis] =
                            (slopes[axis] - below) / (out.width(s, i, axis, texel) * 2.0);
                        out.slopes.put(i, slopes);
                    }
                }
                for i in 0..blocks {
                    let slopes = out.slopes.at(s, i);
                    out.put(i, slopes, rise);
                }
            }
        }
    }
}

impl SlopeTexels {
    /// [`bumped`] for a block: on unit normals `n`, where positions change by these from pixel to pixel.
    #[inline(always)]
    pub(crate) fn bump<S: Simd>(&self, s: S, i: usize, n: V3<S>, changes: [V3<S>; 2]) -> V3<S> {
        let [ux, uy] = self.changes(s, i, 0);
        let [vx, vy] = self.changes(s, i, 1);
        let det = ux * vy - vx * uy;
        let useful = det.abs().simd_lt(f32::INFINITY) & !det.simd_eq(0.0);
        let [px, py] = changes;
        let (mut o_u, mut o_v) = (n, n);
        for k in 0..3 {
            o_u[k] = (px[k] * vy - py[k] * vx) / det;
            o_v[k] = (py[k] * ux - px[k] * uy) / det;
        }
        let [b_u, b_v] = self.slopes.at(s, i);
        let bumped = bump_lanes(X16(s), n, o_u, o_v, b_u, b_v);
        [
            useful.select(bumped[0], n[0]),
            useful.select(bumped[1], n[1]),
            useful.select(bumped[2], n[2]),
        ]
    }

    /// Change of a placed coordinate to the right and down.
    #[inline(always)]
    fn changes<S: Simd>(&self, s: S, i: usize, axis: usize) -> [f32x16<S>; 2] {
        let (at, column) = (i * LANES..(i + 1) * LANES, &self.placed.columns[axis]);
        [
            f32x16::from_slice(s, &column.ddx[at.clone()]),
            f32x16::from_slice(s, &column.ddy[at]),
        ]
    }

    /// Half the width of the difference along an axis: a texel, or the pixel where that is wider.
    #[inline(always)]
    fn width<S: Simd>(&self, s: S, i: usize, axis: usize, texel: f32) -> f32x16<S> {
        let [dx, dy] = self.changes(s, i, axis);
        above(above(dx.abs(), dy.abs()), f32x16::splat(s, texel))
    }

    /// Places beside a block's.
    #[inline(always)]
    fn step_aside<S: Simd>(&mut self, s: S, i: usize, axis: usize, texel: f32, back: bool) {
        let at = i * LANES..(i + 1) * LANES;
        let columns = &self.placed.columns;
        let mut uv = [
            f32x16::from_slice(s, &columns[0].value[at.clone()]),
            f32x16::from_slice(s, &columns[1].value[at]),
        ];
        let width = self.width(s, i, axis, texel);
        uv[axis] = if back {
            uv[axis] - width
        } else {
            uv[axis] + width
        };
        self.beside.put(i, uv);
    }

    /// The texels of a run at its places, or `beside` them.
    fn look_up(&mut self, level: Level, slot: &Slot<'_>, blocks: usize, beside: bool) {
        let count = blocks * LANES;
        let mut at = places(slot, &self.placed, count);
        if beside {
            (at.u, at.v) = (&self.beside.u[..count], &self.beside.v[..count]);
        }
        let columns = self.colors.0.each_mut().map(|c| &mut c[..count]);
        sample_columns(level, &slot.sampler, &slot.texture, &at, columns)
            .expect("the columns have one length");
    }

    /// Slopes in world units.
    #[inline(always)]
    fn put<S: Simd>(&mut self, i: usize, [along_u, along_v]: [f32x16<S>; 2], rise: &Rise) {
        let (height, unit) = (rise.height, rise.unit);
        self.slopes
            .put(i, [along_u * height * unit, along_v * height * unit]);
    }
}

/// Slopes of a height map over u and v: central differences over a texel to each side, or over the pixel where that is wider.
fn heights(slot: &Slot<'_>, [u, v]: [f32; 2], placed: Footprint) -> [f32; 2] {
    let wider = |texel: f32, a: f32, b: f32| {
        let pixel = if a.abs() > b.abs() { a.abs() } else { b.abs() };
        if pixel > texel { pixel } else { texel }
    };
    let (w, h) = (slot.texture.width() as f32, slot.texture.height() as f32);
    let (du, dv) = (
        wider(1.0 / w, placed.du_dx, placed.du_dy),
        wider(1.0 / h, placed.dv_dx, placed.dv_dy),
    );
    let sample =
        |u: f32, v: f32| straight(slot.sampler.sample_grad(&slot.texture, [u, v], placed))[0];
    [
        (sample(u + du, v) - sample(u - du, v)) / (2.0 * du),
        (sample(u, v + dv) - sample(u, v - dv)) / (2.0 * dv),
    ]
}

/// World units of one unit of a mesh's own space, the mean of its three axes by volume.
fn unit_of(mesh: &Mesh) -> f64 {
    let volume = DMat3::from_mat4(mesh.world_from_object).determinant().abs();
    texmap_math::det::pow(volume, 1.0 / 3.0)
}

/// Tangents of a mesh's corners for normal maps whose y points up the picture: world-space vectors and the sign of the bitangent.
pub(crate) fn corner_tangents(mesh: &Mesh, normals: &[DVec3]) -> Vec<[f32; 4]> {
    let faces = texmap_uv::Faces::from_triangles(&mesh.triangles);
    let corners: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    let set = texmap_uv::UvSet {
        uvs: mesh.uvs.clone(),
        corners: corners.clone(),
    };
    let normal = |v: &u32| normals[*v as usize].normalize_or_zero().to_array();
    let at_corners: Vec<[f32; 3]> = corners
        .iter()
        .map(|v| normal(v).map(|c| c as f32))
        .collect();
    let fallback = || vec![[0.0; 4]; corners.len()];
    let Ok(shape) = texmap_uv::Mesh::new(&mesh.positions, &faces) else {
        return fallback();
    };
    let Ok(tangents) = texmap_uv::tangents(&shape, &set, &at_corners) else {
        return fallback();
    };
    let world = DMat3::from_mat4(mesh.world_from_object);
    let mirror = if world.determinant() < 0.0 { -1.0 } else { 1.0 };
    // The bitangent follows growing v, which runs down the picture from a top-left origin.
    let down = if mesh.uv_origin == Origin::TopLeft {
        -1.0
    } else {
        1.0
    };
    tangents
        .into_iter()
        .map(|[x, y, z, sign]| {
            let t = (world * DVec3::new(x.into(), y.into(), z.into())).normalize_or_zero();
            let [x, y, z] = t.to_array().map(|c| c as f32);
            [x, y, z, sign * mirror * down]
        })
        .collect()
}
