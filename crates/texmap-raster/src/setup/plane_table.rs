//! Attribute planes of a tile's triangles, set up in groups.
use alloc::vec::Vec;

use texmap_math::dispatch_simd;
use texmap_math::simd::{GatherTable, Isa, prelude::*};

use crate::setup::group::{GROUP, Ids, solve};
use crate::setup::planes::{COEFFICIENTS, hull, is_moderate, w_is_even};
use crate::setup::{Ranged, TILE, TriangleSetup, origin, widen_attribute, widen_w};
use crate::visibility::runs::Runs;
use crate::visibility::visible::NO_PRIMITIVE;
use crate::{BinnedDraws, Interp, MAX_ATTRIBUTES};

/// Planes of 1/w and of every attribute for each slot of a tile. Slots are those of
/// [`TileVisibility::slot`](crate::TileVisibility); planes lie coefficient by coefficient in groups of sixteen slots.
#[derive(Debug, Clone, Default)]
pub struct AttributePlanes {
    pub(crate) words: Vec<f32>,
    /// Coefficients a group.
    pub(crate) per_group: usize,
    /// Slots that f32 planes cannot serve, by the index of their set-up; [`NO_PRIMITIVE`] for the others.
    odd: Vec<u32>,
    pub(crate) setups: Vec<TriangleSetup>,
    /// Of each group, a bit per attribute that is linear on the screen.
    linear: Vec<u32>,
    pub(crate) has_linear: bool,
    /// Neither set-ups nor attributes linear on the screen.
    pub(crate) plain: bool,
    /// The tile's corner.
    pub(crate) corner: [u32; 2],
}

impl AttributePlanes {
    /// Without planes.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The coefficients of the sixteen slots that a slot lies among.
    #[inline(always)]
    pub(crate) fn group_of(&self, slot: u32) -> &[[f32; GROUP]] {
        let start = slot as usize / GROUP * self.per_group * GROUP;
        self.words.get(start..).unwrap_or(&[]).as_chunks().0
    }

    /// The set-up of a slot that f32 planes cannot serve.
    pub(crate) fn odd_setup(&self, slot: u32) -> Option<&TriangleSetup> {
        let index = *self.odd.get(slot as usize)?;
        self.setups.get(index as usize)
    }

    /// The attributes of a slot that are linear on the screen, a bit each.
    #[inline(always)]
    pub(crate) fn linear(&self, slot: u32) -> u32 {
        let group = self.linear.get(slot as usize / GROUP);
        group.copied().unwrap_or(0)
    }

    /// Resizes the buffers for `groups` groups with `attributes` attributes.
    fn reset(&mut self, groups: usize, attributes: usize, corner: [u32; 2]) {
        self.per_group = (1 + attributes) * COEFFICIENTS;
        // Values of an earlier tile remain only where no triangle is, and for attributes that a draw lacks.
        self.words.resize(groups * self.per_group * GROUP, 0.0);
        self.odd.clear();
        self.odd.resize(groups * GROUP, NO_PRIMITIVE);
        self.setups.clear();
        self.corner = corner;
    }

    fn coefficients(&mut self, group: usize, k: usize, c: usize) -> &mut [f32] {
        let at = (group * self.per_group + k * COEFFICIENTS + c) * GROUP;
        &mut self.words[at..at + GROUP]
    }

    fn set(&mut self, slot: usize, k: usize, plane: &Ranged) {
        let (group, lane) = (slot / GROUP, slot % GROUP);
        for (c, v) in [
            plane.near[0],
            plane.near[1],
            plane.near[2],
            plane.lo,
            plane.hi,
        ]
        .into_iter()
        .enumerate()
        {
            self.coefficients(group, k, c)[lane] = v;
        }
    }

    /// Widens the hulls of all slots.
    #[inline(always)]
    fn widen(&mut self) {
        let group_words = self.per_group * GROUP;
        let groups = self.words.chunks_exact_mut(group_words.max(1));
        for (group, linear) in groups.zip(&self.linear) {
            let (planes, _) = group.as_chunks_mut::<GROUP>();
            let mut planes = planes.chunks_exact_mut(COEFFICIENTS);
            let Some([wa, wb, _, w_lo, w_hi]) = planes.next() else {
                return;
            };
            let mut w_slope = [0.0; GROUP];
            for lane in 0..GROUP {
                w_slope[lane] = wa[lane].abs() + wb[lane].abs();
                widen_w(w_slope[lane], &mut w_lo[lane], &mut w_hi[lane]);
            }
            for (k, plane) in planes.enumerate() {
                let [a, b, _, lo, hi] = plane else {
                    return;
                };
                let is_linear = linear >> k & 1 == 1;
                for lane in 0..GROUP {
                    let slope = a[lane].abs() + b[lane].abs();
                    let (lo, hi) = (&mut lo[lane], &mut hi[lane]);
                    let (change, w) = if is_linear {
                        (0.0, 1.0)
                    } else {
                        (w_slope[lane], w_lo[lane])
                    };
                    widen_attribute(slope, change, w, lo, hi);
                }
            }
        }
        self.setups.iter_mut().for_each(TriangleSetup::widen);
    }

    /// A triangle that was set up by itself.
    fn set_triangle(&mut self, slot: usize, setup: &TriangleSetup) {
        let (w, attributes) = setup.planes();
        self.set(slot, 0, w);
        for (k, plane) in attributes.iter().enumerate() {
            self.set(slot, 1 + k, plane);
        }
        if setup.is_odd() {
            self.odd[slot] = self.setups.len() as u32;
            self.setups.push(*setup);
        }
    }
}

impl BinnedDraws<'_> {
    /// Sets up the attribute planes of every triangle in a tile's bin. Values are clamped to the triangle's; of what was prepared
    /// [`with_samples`](Self::with_samples), where a pixel's centre may lie outside of the triangle, to those within half a pixel
    /// of it.
    pub fn planes(&self, tile: usize, out: &mut AttributePlanes) {
        let bounds = self.tile(tile);
        let mut runs = Runs::new(self, tile);
        let (mut groups, mut attributes) = (0, 0);
        out.linear.clear();
        while let Some(run) = runs.next() {
            groups += 1;
            out.linear.push(self.linear_of(run.draw));
            attributes = attributes.max(self.draw(run.draw as u32).attribute_count);
        }
        out.has_linear = out.linear.iter().any(|linear| *linear != 0);
        out.reset(groups, attributes, [bounds.x0, bounds.y0]);
        dispatch_simd!(self.level(), wide i => self.planes_lanes(i, tile, out));
        out.plain = out.setups.is_empty() && !out.has_linear;
        if self.is_sampled() {
            // The same operations at every level: only the compiler's vectors differ.
            dispatch_simd!(self.level(), wide _i => out.widen());
        }
    }

    #[inline(always)]
    fn planes_lanes<I: Isa>(&self, i: I, tile: usize, out: &mut AttributePlanes) {
        let bounds = self.tile(tile);
        let mut runs = Runs::new(self, tile);
        while let Some(run) = runs.next() {
            let mut care = (1u32 << run.ids.len()) - 1;
            if self.has_lanes(run.draw) {
                let named = Ids::new(run.ids, self.first(run.draw), self.whole());
                if named.pieces & care != care {
                    let mut odd = 0;
                    for at in (0..run.ids.len()).step_by(I::LANES) {
                        if !named.are_pieces(i, at) {
                            odd |= self.planes_group(i, run.draw, &named, run.first_slot + at, out);
                        }
                    }
                    care &= named.pieces | odd;
                }
            }
            while care != 0 {
                let lane = care.trailing_zeros() as usize;
                care &= care - 1;
                let setup = self.setup(run.ids[lane], bounds.x0 / TILE, bounds.y0 / TILE);
                out.set_triangle(run.first_slot + lane, &setup);
            }
        }
    }

    /// Draws of whole triangles whose attributes are exact per pixel, or linear on the screen.
    fn has_lanes(&self, draw: usize) -> bool {
        let interp = self.draw(draw as u32).interp;
        matches!(interp, Interp::Perspective | Interp::Affine)
    }

    /// The attributes of a draw that are linear on the screen, a bit each.
    fn linear_of(&self, draw: usize) -> u32 {
        let d = self.draw(draw as u32);
        let used = (1u64 << d.attribute_count.min(MAX_ATTRIBUTES)) - 1;
        let linear = match d.interp {
            Interp::Affine | Interp::Subdivided(_) => u32::MAX,
            _ => d.screen_linear,
        };
        linear & used as u32
    }

    /// The triangles from slot `slot` on, one in each lane. Returns the bits in the group of those that need a look of their own.
    #[inline(always)]
    fn planes_group<I: Isa>(
        &self,
        i: I,
        draw: usize,
        ids: &Ids,
        slot: usize,
        out: &mut AttributePlanes,
    ) -> u32 {
        let d = self.draw(draw as u32);
        let n = d.attribute_count;
        let (Some(arrays), limit) = (self.arrays(draw), i32::MAX as usize) else {
            return u32::MAX;
        };
        let values = GatherTable::new(bytemuck::cast_slice(d.attributes));
        if (n > 0 && values.is_none()) || d.attributes.len() > limit {
            return u32::MAX;
        }
        let at = slot % GROUP;
        let vertex = arrays.corners(i, ids.lanes(i, at));
        let middle = origin(out.corner[0] / TILE, out.corner[1] / TILE).map(f64::from);
        let transform = self.transform(draw);
        let exact = solve::<I, false>(i, &arrays, &vertex, transform, middle);
        let one = i.f64(1.0);
        let plane = exact.solver.plane([one; 3]);
        let range = hull(
            i,
            [
                i.narrow(one / exact.w[0]),
                i.narrow(one / exact.w[1]),
                i.narrow(one / exact.w[2]),
            ],
        );
        let mut fine = exact.solver.solvable & w_is_even(i, plane, i.widen(range[0]));
        fine = fine & store(i, plane, range, slot, 0, out);
        if let Some(values) = values {
            let of: [I::U32; 3] = [
                (vertex[0] * n as i32).to_u32(),
                (vertex[1] * n as i32).to_u32(),
                (vertex[2] * n as i32).to_u32(),
            ];
            let linear = self.linear_of(draw);
            let mut flat = None;
            if linear != 0 {
                let solved = solve::<I, true>(i, &arrays, &vertex, transform, middle);
                fine = fine & solved.solver.solvable;
                flat = Some(solved.solver);
            }
            let mut ahead = [[i.f32(0.0); 3]; AHEAD];
            let (mut start, mut end) = (0, 0);
            for k in 0..n {
                if k == end {
                    (start, end) = (k, k + read(i, values, of, k, n, &mut ahead));
                }
                let v = ahead[(k - start) % AHEAD];
                let solver = match &flat {
                    Some(flat) if linear >> k & 1 == 1 => flat,
                    _ => &exact.solver,
                };
                let plane = solver.plane([i.widen(v[0]), i.widen(v[1]), i.widen(v[2])]);
                fine = fine & store(i, plane, hull(i, v), slot, 1 + k, out);
            }
        }
        (!fine).to_bitmask() << at
    }
}

/// Attributes of the three corners that are read at once: they lie side by side.
const AHEAD: usize = 4;

/// Reads attribute `k` of `n` and some of those behind it; returns how many.
#[inline(always)]
fn read<I: Isa>(
    i: I,
    values: GatherTable<'_>,
    of: [I::U32; 3],
    k: usize,
    n: usize,
    ahead: &mut [[I::F32; 3]; AHEAD],
) -> usize {
    let k32 = k as u32;
    let [a, b, c] = [of[0] + k32, of[1] + k32, of[2] + k32];
    if n - k >= 4
        && let Some(a) = i.gather_quads(values, a)
        && let Some(b) = i.gather_quads(values, b)
        && let Some(c) = i.gather_quads(values, c)
    {
        for (k, ahead) in ahead.iter_mut().enumerate() {
            *ahead = [a[k].to_f32_bits(), b[k].to_f32_bits(), c[k].to_f32_bits()];
        }
        return 4;
    }
    if n - k < 2 {
        ahead[0] = [
            i.gather(values, a).to_f32_bits(),
            i.gather(values, b).to_f32_bits(),
            i.gather(values, c).to_f32_bits(),
        ];
        return 1;
    }
    let a = i.gather_pairs(values, a);
    let b = i.gather_pairs(values, b);
    let c = i.gather_pairs(values, c);
    for k in 0..2 {
        ahead[k] = [a[k].to_f32_bits(), b[k].to_f32_bits(), c[k].to_f32_bits()];
    }
    2
}

/// Stores planes with their hulls from slot `slot` on. True where their values are neither too large nor too small for f32.
#[inline(always)]
fn store<I: Isa>(
    i: I,
    plane: [I::F64; 3],
    hull: [I::F32; 2],
    slot: usize,
    k: usize,
    out: &mut AttributePlanes,
) -> I::Mask64 {
    let (group, at) = (slot / GROUP, slot % GROUP);
    let [a, b, c] = [i.narrow(plane[0]), i.narrow(plane[1]), i.narrow(plane[2])];
    for (c, v) in [a, b, c, hull[0], hull[1]].iter().enumerate() {
        v.store(&mut out.coefficients(group, k, c)[at..]);
    }
    is_moderate(i, plane, hull)
}
