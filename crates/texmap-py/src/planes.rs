//! Barycentrics, depth and their derivatives in 4x4 blocks of pixels, from planes over the picture.
//!
//! The planes are the homogeneous edge functions of a triangle (Olano and Greer 1997), so that no vertex is divided by its w. All values
//! are f64 until they are stored.

use texmap_math::simd::{GatherTable, Isa, prelude::*};
use texmap_raster::{BinnedDraws, NO_PRIMITIVE};

/// Triangles of a group, as many as slots of one draw in `TileVisibility`.
const GROUP: usize = 16;

/// Ids up to this stand in f32 as they are; larger ones as its bits counted on from those of 2^24.
const EXACT: u32 = 1 << 24;

/// The number of a triangle as `rast` holds it: id + 1 as f32, or beyond 2^24 as the bits 0x4a800000 + id + 1.
fn encode(triangle: usize) -> f32 {
    let id = triangle as u32 + 1;
    match id <= EXACT {
        true => id as f32,
        false => f32::from_bits(0x4a80_0000 + id),
    }
}

/// The triangle of a pixel of `rast`; `None` where there is none.
#[inline(always)]
pub(crate) fn decode(id: f32) -> Option<usize> {
    let id = match id <= EXACT as f32 {
        true => id as u32,
        false => id.to_bits() - 0x4a80_0000,
    };
    (id as usize).checked_sub(1)
}

/// The triangles of a picture in clip space.
pub(crate) struct Triangles<'a> {
    pub(crate) pos: &'a [[f32; 4]],
    pub(crate) tri: &'a [[u32; 3]],
    /// Half of the width and height.
    pub(crate) half: [f64; 2],
    /// Number of the first triangle.
    pub(crate) first: usize,
}

/// The planes of a tile's triangles by slot: of sixteen once one of them is seen.
#[derive(Default)]
pub(crate) struct TilePlanes {
    groups: Vec<Group>,
}

impl TilePlanes {
    /// For another tile with so many slots.
    pub(crate) fn forget(&mut self, slots: usize) {
        for group in &mut self.groups {
            group.known = false;
        }
        let groups = slots.div_ceil(GROUP);
        if self.groups.len() < groups {
            self.groups.resize_with(groups, Group::default);
        }
    }

    /// u, v, z/w and the number of the triangle of each pixel of a block, row by row, and if `DB` du/dX, du/dY, dv/dX and dv/dY; zeros
    /// where nothing is. `at` is the centre of its first pixel; `ids` are those of the slots. Weights end at 0 and 1: a pixel may lie
    /// outside of the exact triangle by the 1/256 pixel that its vertices are snapped to.
    #[inline(always)]
    pub(crate) fn block<I: Isa, const DB: bool>(
        &mut self,
        i: I,
        scene: &Triangles<'_>,
        binned: &BinnedDraws<'_>,
        ids: &[u32],
        slots: &[u32; 16],
        mask: u16,
        at: [f64; 2],
        out: &mut [f32; 64],
        db: &mut [f32; 64],
    ) {
        for first in (0..16).step_by(I::LANES) {
            let pixel = i.iota() + first as i32;
            let px = i.widen((pixel & 3).to_f32()) + at[0];
            let py = i.widen((pixel >> 2).to_f32()) + at[1];
            let here = i.load_u32(&slots[first..]);
            // Weights are the first two over the third, the sum of the edge functions.
            let mut values = [i.f64(0.0), i.f64(0.0), i.f64(1.0), i.f64(0.0)];
            let mut slopes = [[i.f64(0.0); 2]; 3];
            let mut id = i.f32(0.0);
            let mut left = u32::from(mask >> first) & (u32::MAX >> (32 - I::LANES));
            while left != 0 {
                let slot = slots[first + left.trailing_zeros() as usize];
                let same = here.simd_eq(slot);
                let bits = same.to_bitmask();
                left &= !bits;
                let (number, lane) = (slot as usize / GROUP, slot as usize % GROUP);
                let Some(group) = self.groups.get_mut(number) else {
                    continue;
                };
                if !group.known {
                    group.fill(i, scene, binned, &ids[number * GROUP..]);
                }
                let wide = i.mask64_from_bits(bits);
                for k in 0..4 {
                    let [a, b, c] = &group.planes[k];
                    let new = px * a[lane] + (py * b[lane] + c[lane]);
                    values[k] = wide.select(new, values[k]);
                    if DB && k < 3 {
                        let [x, y] = slopes[k];
                        slopes[k] = [
                            wide.select(i.f64(a[lane]), x),
                            wide.select(i.f64(b[lane]), y),
                        ];
                    }
                }
                id = same.select(i.f32(group.id[lane]), id);
            }
            let [u, v, sum, depth] = values;
            let inv = i.f64(1.0) / sum;
            let (u, v) = (u * inv, v * inv);
            if DB {
                let [ux, vx, sum] = slopes;
                let found = [
                    i.narrow((ux[0] - u * sum[0]) * inv),
                    i.narrow((ux[1] - u * sum[1]) * inv),
                    i.narrow((vx[0] - v * sum[0]) * inv),
                    i.narrow((vx[1] - v * sum[1]) * inv),
                ];
                store(i, found, &mut db[4 * first..]);
            }
            let u = bounded(i, u);
            let rest = i.f64(1.0) - u;
            let v = bounded(i, v);
            let v = v.simd_lt(rest).select(v, rest);
            store(
                i,
                [i.narrow(u), i.narrow(v), i.narrow(depth), id],
                &mut out[4 * first..],
            );
        }
    }
}

/// Within 0 and 1; NaN gives 0.
#[inline(always)]
fn bounded<I: Isa>(i: I, x: I::F64) -> I::F64 {
    let x = x.simd_gt(0.0).select(x, i.f64(0.0));
    x.simd_lt(1.0).select(x, i.f64(1.0))
}

/// The four values of each lane one after the other.
#[inline(always)]
fn store<I: Isa>(i: I, values: [I::F32; 4], out: &mut [f32]) {
    let [a, b, c, d] = values;
    let even = i.interleave(a.to_bits(), c.to_bits());
    let odd = i.interleave(b.to_bits(), d.to_bits());
    for k in 0..2 {
        let [low, high] = i.interleave(even[k], odd[k]);
        low.to_f32_bits().store(&mut out[2 * k * I::LANES..]);
        high.to_f32_bits().store(&mut out[(2 * k + 1) * I::LANES..]);
    }
}

/// Planes of sixteen triangles.
#[derive(Default)]
#[repr(align(64))]
struct Group {
    /// Change to the right, change up and value at the corner of the picture: of the first two edge functions, of the sum of all three
    /// and of z/w, which is linear on the screen.
    planes: [[[f64; GROUP]; 3]; 4],
    /// Numbers of the triangles as `rast` holds them.
    id: [f32; GROUP],
    known: bool,
}

impl Group {
    /// Of the triangles of `ids`. Out of line: compiled once a level.
    #[inline(never)]
    fn fill<I: Isa>(&mut self, i: I, scene: &Triangles<'_>, binned: &BinnedDraws<'_>, ids: &[u32]) {
        let mut corners = [[[0; 4]; GROUP]; 3];
        for (lane, id) in ids
            .iter()
            .take(GROUP)
            .enumerate()
            .filter(|(_, id)| **id != NO_PRIMITIVE)
        {
            // Ids count the triangles of the one draw, then pieces of those that were cut.
            let triangle = match (*id as usize) < scene.tri.len() {
                true => *id as usize,
                false => binned.source(*id).1 as usize,
            };
            let [a, b, c] = scene.tri[triangle];
            corners[0][lane] = words(&scene.pos[a as usize]);
            corners[1][lane] = words(&scene.pos[b as usize]);
            corners[2][lane] = words(&scene.pos[c as usize]);
            self.id[lane] = encode(scene.first + triangle);
        }
        let [a, b, c] = &corners;
        let table = |corner| GatherTable::new(<[[u32; 4]]>::as_flattened(corner));
        let (Some(a), Some(b), Some(c)) = (table(a), table(b), table(c)) else {
            return;
        };
        i.vectorize(
            #[inline(always)]
            || {
                for at in (0..GROUP).step_by(I::LANES) {
                    self.planes(i, scene.half, [a, b, c], at);
                }
            },
        );
        self.known = true;
    }

    /// Lanes from `at` on; x, y, z and w of each corner stand together.
    #[inline(always)]
    fn planes<I: Isa>(&mut self, i: I, half: [f64; 2], corners: [GatherTable<'_>; 3], at: usize) {
        let (a, za) = pixels(i, half, corners[0], at);
        let (b, zb) = pixels(i, half, corners[1], at);
        let (c, zc) = pixels(i, half, corners[2], at);
        let [e, f, g] = [cross(i, b, c), cross(i, c, a), cross(i, a, b)];
        let det = e[0] * a[0] + e[1] * a[1] + e[2] * a[2];
        for k in 0..3 {
            let depth = (e[k] * za + f[k] * zb + g[k] * zc) / det;
            e[k].store(&mut self.planes[0][k][at..]);
            f[k].store(&mut self.planes[1][k][at..]);
            (e[k] + f[k] + g[k]).store(&mut self.planes[2][k][at..]);
            depth.store(&mut self.planes[3][k][at..]);
        }
    }
}

/// Corners of triangles in homogeneous pixels (x, y, w), and their z.
#[inline(always)]
fn pixels<I: Isa>(
    i: I,
    half: [f64; 2],
    corner: GatherTable<'_>,
    at: usize,
) -> ([I::F64; 3], I::F64) {
    let index = ((i.iota() + at as i32) << 2).to_u32();
    let [x, y, z, w] = match i.gather_quads(corner, index) {
        Some(found) => found,
        None => [
            i.gather(corner, index),
            i.gather(corner, index + 1),
            i.gather(corner, index + 2),
            i.gather(corner, index + 3),
        ],
    };
    let (x, y) = (i.widen(x.to_f32_bits()), i.widen(y.to_f32_bits()));
    let (z, w) = (i.widen(z.to_f32_bits()), i.widen(w.to_f32_bits()));
    ([(x + w) * half[0], (y + w) * half[1], w], z)
}

#[inline(always)]
fn words(p: &[f32; 4]) -> [u32; 4] {
    [
        p[0].to_bits(),
        p[1].to_bits(),
        p[2].to_bits(),
        p[3].to_bits(),
    ]
}

#[inline(always)]
fn cross<I: Isa>(_: I, p: [I::F64; 3], q: [I::F64; 3]) -> [I::F64; 3] {
    [
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    ]
}
