//! Attribute planes of a tile's triangles, set up sixteen at a time.
use alloc::vec::Vec;

use texmap_math::fearless_simd::{Simd, f32x16, f64x8, mask64x8, prelude::*, u32x16};
use texmap_math::lanes::{LANES, Words, above, gather, gather_pairs, gather_quads};
use texmap_math::on_level;

use crate::blocks::Runs;
use crate::group::{Ids, extent_x8, hull_x16, solve_x16};
use crate::setup::{
    LARGEST, Ranged, SMALLEST, TILE, TriangleSetup, W_RATIO, origin, widen_attribute, widen_w,
};
use crate::visible::NONE;
use crate::{Interp, MAX_ATTRIBUTES, Prepared};

/// Coefficients of a plane with its hull: a, b, c, lo, hi.
pub(crate) const COEFFICIENTS: usize = 5;

/// Planes of 1/w and of every attribute for each slot of a tile (see [`TileBlocks::slot`](crate::TileBlocks)),
/// coefficient by coefficient in groups of sixteen slots.
#[derive(Debug, Clone, Default)]
pub struct TilePlanes {
    pub(crate) words: Vec<f32>,
    /// Coefficients a group.
    pub(crate) per_group: usize,
    /// Slots that f32 planes cannot serve, by the index of their set-up; [`NONE`] for the others.
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

impl TilePlanes {
    /// Without planes.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Where the coefficients of a slot begin; each is [`LANES`] words from the one before.
    #[inline(always)]
    pub(crate) fn start_of(&self, slot: u32) -> usize {
        (slot as usize / LANES) * self.per_group * LANES + slot as usize % LANES
    }

    /// The coefficients of the sixteen slots that a slot lies among.
    #[inline(always)]
    pub(crate) fn group_of(&self, slot: u32) -> &[[f32; LANES]] {
        let start = slot as usize / LANES * self.per_group * LANES;
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
        let group = self.linear.get(slot as usize / LANES);
        group.copied().unwrap_or(0)
    }

    /// Room for `groups` groups with `attributes` attributes.
    fn reset(&mut self, groups: usize, attributes: usize, corner: [u32; 2]) {
        self.per_group = (1 + attributes) * COEFFICIENTS;
        // What an earlier tile left stands only where no triangle is, and for attributes that a draw lacks.
        self.words.resize(groups * self.per_group * LANES, 0.0);
        self.odd.clear();
        self.odd.resize(groups * LANES, NONE);
        self.setups.clear();
        self.corner = corner;
    }

    fn slot_of(&mut self, group: usize, k: usize, c: usize) -> &mut [f32] {
        let at = (group * self.per_group + k * COEFFICIENTS + c) * LANES;
        &mut self.words[at..at + LANES]
    }

    fn set(&mut self, slot: usize, k: usize, plane: &Ranged) {
        let (group, lane) = (slot / LANES, slot % LANES);
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
            self.slot_of(group, k, c)[lane] = v;
        }
    }

    /// Widens the hulls of all slots.
    fn widen(&mut self) {
        let group_words = self.per_group * LANES;
        let groups = self.words.chunks_exact_mut(group_words.max(1));
        for (group, linear) in groups.zip(&self.linear) {
            let (planes, _) = group.as_chunks_mut::<LANES>();
            let mut planes = planes.chunks_exact_mut(COEFFICIENTS);
            let Some([wa, wb, _, w_lo, w_hi]) = planes.next() else {
                return;
            };
            let mut w_slope = [0.0; LANES];
            for lane in 0..LANES {
                w_slope[lane] = wa[lane].abs() + wb[lane].abs();
                widen_w(w_slope[lane], &mut w_lo[lane], &mut w_hi[lane]);
            }
            for (k, plane) in planes.enumerate() {
                let [a, b, _, lo, hi] = plane else {
                    return;
                };
                let is_linear = linear >> k & 1 == 1;
                for lane in 0..LANES {
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

    /// A triangle that came the plain way.
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

impl Prepared<'_> {
    /// Sets up the attribute planes of every triangle in a tile's bin. Values are clamped to the triangle's; of what was prepared
    /// [`with_samples`](Self::with_samples), where a pixel's centre may lie outside of the triangle, to those within half a pixel
    /// of it.
    pub fn planes(&self, tile: usize, out: &mut TilePlanes) {
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
        match self.level() {
            Some(level) => {
                on_level!(level, s => self.planes_lanes(s, tile, out), else self.planes_plain(tile, out));
            }
            None => self.planes_plain(tile, out),
        }
        out.plain = out.setups.is_empty() && !out.has_linear;
        if self.is_sampled() {
            out.widen();
        }
    }

    fn planes_plain(&self, tile: usize, out: &mut TilePlanes) {
        let bounds = self.tile(tile);
        let mut runs = Runs::new(self, tile);
        while let Some(run) = runs.next() {
            for (lane, &id) in run.ids.iter().enumerate() {
                out.set_triangle(
                    run.first_slot + lane,
                    &self.setup(id, bounds.x0 / TILE, bounds.y0 / TILE),
                );
            }
        }
    }

    #[inline(always)]
    fn planes_lanes<S: Simd>(&self, s: S, tile: usize, out: &mut TilePlanes) {
        let bounds = self.tile(tile);
        let mut runs = Runs::new(self, tile);
        while let Some(run) = runs.next() {
            let mut care = (1u32 << run.ids.len()) - 1;
            if self.has_lanes(run.draw) {
                let named = Ids::new(run.ids, self.first(run.draw), self.whole());
                if named.pieces & care != care {
                    care &= named.pieces
                        | self.planes_x16(s, run.draw, &named, run.first_slot / LANES, out);
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

    /// A group in lanes; returns the lanes that need the plain way.
    #[inline(always)]
    fn planes_x16<S: Simd>(
        &self,
        s: S,
        draw: usize,
        ids: &Ids,
        group: usize,
        out: &mut TilePlanes,
    ) -> u32 {
        let d = self.draw(draw as u32);
        let n = d.attribute_count;
        let (Some(arrays), limit) = (self.arrays(draw), i32::MAX as usize) else {
            return u32::MAX;
        };
        let values = Words::new(bytemuck::cast_slice(d.attributes));
        if (n > 0 && values.is_none()) || d.attributes.len() > limit {
            return u32::MAX;
        }
        let vertex = arrays.corners(s, ids.lanes(s));
        let middle = origin(out.corner[0] / TILE, out.corner[1] / TILE).map(f64::from);
        let transform = self.transform(draw);
        let exact = solve_x16::<S, false>(s, &arrays, &vertex, transform, middle);
        let [low, high] = &exact;
        let one = f64x8::splat(s, 1.0);
        let (low_w, high_w) = (low.plane([one; 3]), high.plane([one; 3]));
        let hull = hull_x16([
            s.narrow_f64x8(one / low.w[0], one / high.w[0]),
            s.narrow_f64x8(one / low.w[1], one / high.w[1]),
            s.narrow_f64x8(one / low.w[2], one / high.w[2]),
        ]);
        let lo = hull.0.widen();
        let mut fine = [
            low.solvable & w_is_even(low_w, lo.0),
            high.solvable & w_is_even(high_w, lo.1),
        ];
        fine = store(s, low_w, high_w, hull, fine, group, 0, out);
        if let Some(values) = values {
            let at: [u32x16<S>; 3] = [
                (vertex[0] * n as i32).bitcast(),
                (vertex[1] * n as i32).bitcast(),
                (vertex[2] * n as i32).bitcast(),
            ];
            let linear = self.linear_of(draw);
            let mut flat = None;
            if linear != 0 {
                let [low, high] = solve_x16::<S, true>(s, &arrays, &vertex, transform, middle);
                fine = [fine[0] & low.solvable, fine[1] & high.solvable];
                flat = Some([low, high]);
            }
            let mut ahead = [[f32x16::splat(s, 0.0); 3]; AHEAD];
            let (mut start, mut end) = (0, 0);
            for k in 0..n {
                if k == end {
                    (start, end) = (k, k + read(s, values, at, k, n, &mut ahead));
                }
                let v = ahead[(k - start) % AHEAD];
                let (v0, v1, v2) = (v[0].widen(), v[1].widen(), v[2].widen());
                let [low, high] = match &flat {
                    Some(flat) if linear >> k & 1 == 1 => flat,
                    _ => &exact,
                };
                let (low_plane, high_plane) = (
                    low.plane([v0.0, v1.0, v2.0]),
                    high.plane([v0.1, v1.1, v2.1]),
                );
                fine = store(
                    s,
                    low_plane,
                    high_plane,
                    hull_x16(v),
                    fine,
                    group,
                    1 + k,
                    out,
                );
            }
        }
        !((fine[0].to_bitmask() | fine[1].to_bitmask() << 8) as u32)
    }
}

/// Attributes of the three corners that are read at once: they lie side by side.
const AHEAD: usize = 4;

/// Reads attribute `k` of `n` and some of those behind it; returns how many.
#[inline(always)]
fn read<S: Simd>(
    s: S,
    values: Words<'_>,
    at: [u32x16<S>; 3],
    k: usize,
    n: usize,
    ahead: &mut [[f32x16<S>; 3]; AHEAD],
) -> usize {
    let k32 = k as u32;
    let [a, b, c] = [at[0] + k32, at[1] + k32, at[2] + k32];
    if n - k >= 4
        && let Some(a) = gather_quads(s, values, a)
        && let Some(b) = gather_quads(s, values, b)
        && let Some(c) = gather_quads(s, values, c)
    {
        for (i, ahead) in ahead.iter_mut().enumerate() {
            *ahead = [a[i].bitcast(), b[i].bitcast(), c[i].bitcast()];
        }
        return 4;
    }
    if n - k < 2 {
        ahead[0] = [
            gather(s, values, a).bitcast(),
            gather(s, values, b).bitcast(),
            gather(s, values, c).bitcast(),
        ];
        return 1;
    }
    let a = gather_pairs(s, values, a);
    let b = gather_pairs(s, values, b);
    let c = gather_pairs(s, values, c);
    for i in 0..2 {
        ahead[i] = [a[i].bitcast(), b[i].bitcast(), c[i].bitcast()];
    }
    2
}

/// As [`TriangleSetup`] decides where f32 planes of 1/w will do.
#[inline(always)]
fn w_is_even<S: Simd>(plane: [f64x8<S>; 3], lo: f64x8<S>) -> mask64x8<S> {
    let (largest, smallest) = extent_x8(plane);
    let lowest = smallest.simd_gt(lo).select(smallest, lo);
    largest.simd_le(lowest * W_RATIO)
}

/// Stores a plane with its hull; returns the lanes of `fine` whose values are neither too large nor too small for f32.
#[inline(always)]
fn store<S: Simd>(
    s: S,
    low: [f64x8<S>; 3],
    high: [f64x8<S>; 3],
    hull: (f32x16<S>, f32x16<S>),
    fine: [mask64x8<S>; 2],
    group: usize,
    k: usize,
    out: &mut TilePlanes,
) -> [mask64x8<S>; 2] {
    for c in 0..3 {
        s.narrow_f64x8(low[c], high[c])
            .store_slice(out.slot_of(group, k, c));
    }
    hull.0.store_slice(out.slot_of(group, k, 3));
    hull.1.store_slice(out.slot_of(group, k, 4));
    let size = above(hull.0.abs(), hull.1.abs()).widen();
    [
        fine[0] & is_moderate(low, size.0),
        fine[1] & is_moderate(high, size.1),
    ]
}

#[inline(always)]
fn is_moderate<S: Simd>(plane: [f64x8<S>; 3], size: f64x8<S>) -> mask64x8<S> {
    let in_range = size.simd_eq(0.0) | (size.simd_ge(SMALLEST) & size.simd_le(LARGEST));
    in_range & extent_x8(plane).0.simd_le(LARGEST)
}
