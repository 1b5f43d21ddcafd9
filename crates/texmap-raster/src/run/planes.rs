//! Where the planes of a block's pixels lie, and how they come into lanes. Plane 0 is that of 1/w, plane 1 + k that of attribute k.

use texmap_math::fearless_simd::{Simd, f32x16, mask32x16, prelude::*, u32x16};
use texmap_math::lanes::{LANES, Line, Words, clamp, clamp_scalar, gather, is_wide, octet};

use super::BlockValues;
use crate::plane_table::{COEFFICIENTS, TilePlanes};

/// A plane of sixteen slots.
type Plane16 = [[f32; LANES]; COEFFICIENTS];

const NO_PLANE: &Plane16 = &[[0.0; LANES]; COEFFICIENTS];

/// Triangles of a block that are taken one by one, where eight neighbours do not share a register.
const FEW: usize = 5;

/// A plane's coefficients in lanes: a, b, c, lo, hi.
pub(super) type Plane<S> = [f32x16<S>; COEFFICIENTS];

/// Gives the planes of a block's pixels.
pub(super) trait PlaneSource<S: Simd> {
    /// Each lane's coefficients of a plane.
    fn plane(&self, s: S, index: usize) -> Plane<S>;

    /// 1 / clip w and its reciprocal, where they are the same at all pixels: their division is the dearest step.
    fn level(&self, _s: S) -> Option<[f32x16<S>; 2]> {
        None
    }

    /// Whether an attribute is linear on the screen.
    fn is_linear(&self, _attribute: usize) -> bool {
        false
    }
}

/// The planes of one slot, where they lie: each block spreads them anew, since a load that spreads costs less than two registers'
/// worth of memory.
#[derive(Clone, Copy)]
pub(crate) struct One<'t> {
    words: &'t [[f32; LANES]],
    lane: usize,
    level: Option<[f32; 2]>,
    /// Attributes that are linear on the screen, a bit each.
    linear: u32,
}

impl<'t> One<'t> {
    pub(super) const NONE: Self = Self {
        words: &[],
        lane: 0,
        level: None,
        linear: 0,
    };

    #[inline(always)]
    pub(crate) fn new(table: &'t TilePlanes, slot: u32) -> Self {
        let mut one = Self {
            words: table.group_of(slot),
            lane: slot as usize % LANES,
            level: None,
            linear: table.linear(slot),
        };
        let [a, b, c, lo, hi] = one.own(0);
        if a == 0.0 && b == 0.0 {
            let w = clamp_scalar((c + b * 0.0) + a * 0.0, lo, hi);
            one.level = Some([w, 1.0 / w]);
        }
        one
    }

    /// The coefficients of one of the planes.
    #[inline(always)]
    pub(crate) fn own(&self, index: usize) -> [f32; COEFFICIENTS] {
        let plane = plane(self.words, index * COEFFICIENTS);
        plane.each_ref().map(|c| c[self.lane % LANES])
    }

    /// Whether an attribute is linear on the screen.
    pub(crate) fn has_linear(&self, attribute: usize) -> bool {
        self.linear >> attribute & 1 == 1
    }
}

/// 1/w and two attributes of [`One`], found once for all blocks of a slot.
pub(super) struct OnePair<'t> {
    planes: [&'t Plane16; 3],
    lane: usize,
    level: Option<[f32; 2]>,
    linear: [bool; 2],
}

impl<'t> OnePair<'t> {
    pub(super) const NONE: Self = Self {
        planes: [NO_PLANE; 3],
        lane: 0,
        level: None,
        linear: [false; 2],
    };

    #[inline(always)]
    pub(super) fn new(table: &'t TilePlanes, slot: u32, [j, k]: [usize; 2]) -> Self {
        let one = One::new(table, slot);
        let of = |index: usize| plane(one.words, index * COEFFICIENTS);
        Self {
            planes: [of(0), of(1 + j), of(1 + k)],
            lane: one.lane,
            level: one.level,
            linear: [one.has_linear(j), one.has_linear(k)],
        }
    }

    /// What the blocks of a row share.
    #[inline(always)]
    pub(super) fn on_row<S: Simd>(&self, s: S, py: f32x16<S>) -> PairOnRow<S> {
        let [w, first, second] = self.planes;
        PairOnRow {
            w: OnRow::new(spread(s, w, self.lane), py),
            pair: [
                OnRow::new(spread(s, first, self.lane), py),
                OnRow::new(spread(s, second, self.lane), py),
            ],
            level: lanes_of(s, self.level),
            linear: self.linear,
        }
    }
}

/// [`OnePair`] on a row of blocks.
pub(super) struct PairOnRow<S: Simd> {
    w: OnRow<S>,
    pair: [OnRow<S>; 2],
    level: Option<[f32x16<S>; 2]>,
    linear: [bool; 2],
}

impl<S: Simd> PairOnRow<S> {
    /// The values of a block.
    #[inline(always)]
    pub(super) fn values<const D: bool>(&self, s: S, px: f32x16<S>) -> BlockValues<S> {
        let mut values =
            BlockValues::new::<D>(s, [&self.w, &self.pair[0], &self.pair[1]], self.level, px);
        if self.linear != [false; 2] {
            for k in 0..2 {
                if self.linear[k] {
                    let [u, dx, dy] = self.pair[k].straight(px);
                    (values.value[k], values.ddx[k], values.ddy[k]) = (u, dx, dy);
                }
            }
        }
        values
    }
}

impl<S: Simd> PlaneSource<S> for One<'_> {
    #[inline(always)]
    fn plane(&self, s: S, index: usize) -> Plane<S> {
        spread(s, plane(self.words, index * COEFFICIENTS), self.lane)
    }

    #[inline(always)]
    fn level(&self, s: S) -> Option<[f32x16<S>; 2]> {
        lanes_of(s, self.level)
    }

    #[inline(always)]
    fn is_linear(&self, attribute: usize) -> bool {
        self.has_linear(attribute)
    }
}

/// The planes of each lane's own slot: eight neighbouring slots at a time where they share a register, else slot by slot, or by gathers
/// where a block has many.
pub(super) struct Own<'t, S: Simd> {
    rows: &'t [[f32; LANES]],
    words: Words<'t>,
    /// Coefficients a group.
    per_group: usize,
    slots: u32x16<S>,
    /// What the slots of a part share, and where its planes begin.
    keys: [u32; LANES],
    starts: [u32; LANES],
    parts: usize,
    /// There are more parts.
    gathers: bool,
}

impl<'t, S: Simd> Own<'t, S> {
    #[inline(always)]
    pub(super) fn new(s: S, table: &'t TilePlanes, words: Words<'t>, slots: u32x16<S>) -> Self {
        let (octets, per_group) = (is_wide(s), table.per_group);
        let mut own = Self {
            rows: table.words.as_chunks().0,
            words,
            per_group,
            slots,
            keys: [0; LANES],
            starts: [0; LANES],
            parts: 0,
            gathers: false,
        };
        let (keys, most) = if octets {
            (slots >> 3, LANES)
        } else {
            (slots, FEW)
        };
        let mut lanes = [0; LANES];
        keys.store_slice(&mut lanes);
        let mut left = u16::MAX;
        while left != 0 && own.parts < most {
            let key = lanes[left.trailing_zeros() as usize & 15];
            let group = if octets { key >> 1 } else { key >> 4 };
            own.keys[own.parts] = key;
            own.starts[own.parts] = group * per_group as u32;
            own.parts += 1;
            left &= !(keys.simd_eq(key).to_bitmask() as u16);
        }
        own.gathers = left != 0;
        own
    }

    /// The parts after the first: what their slots share, and where their planes begin.
    #[inline(always)]
    fn others(&self) -> impl Iterator<Item = (u32, u32)> {
        let others = 1..self.parts.clamp(1, LANES);
        let starts = &self.starts[others.clone()];
        self.keys[others]
            .iter()
            .copied()
            .zip(starts.iter().copied())
    }

    #[inline(always)]
    fn by_octets(&self, s: S, row: usize) -> Plane<S> {
        let (octets, within) = (self.slots >> 3, self.slots & 7);
        let first = plane(self.rows, self.starts[0] as usize + row);
        let mut out = pick(s, first, self.keys[0], within);
        for (key, start) in self.others() {
            let from = plane(self.rows, start as usize + row);
            put(octets.simd_eq(key), pick(s, from, key, within), &mut out);
        }
        out
    }

    #[inline(always)]
    fn by_slots(&self, s: S, row: usize) -> Plane<S> {
        let first = plane(self.rows, self.starts[0] as usize + row);
        let mut out = spread(s, first, self.keys[0] as usize);
        for (key, start) in self.others() {
            let from = plane(self.rows, start as usize + row);
            put(
                self.slots.simd_eq(key),
                spread(s, from, key as usize),
                &mut out,
            );
        }
        out
    }

    #[inline(always)]
    fn by_gathers(&self, s: S, row: usize) -> Plane<S> {
        let groups = (self.slots >> 4) * (self.per_group * LANES) as u32;
        let start = groups + (self.slots & 15) + (row * LANES) as u32;
        let mut out = [f32x16::splat(s, 0.0); COEFFICIENTS];
        for (c, out) in out.iter_mut().enumerate() {
            *out = gather(s, self.words, start + (c * LANES) as u32).bitcast();
        }
        out
    }
}

impl<S: Simd> PlaneSource<S> for Own<'_, S> {
    #[inline(always)]
    fn plane(&self, s: S, index: usize) -> Plane<S> {
        let row = index * COEFFICIENTS;
        if is_wide(s) {
            self.by_octets(s, row)
        } else if self.gathers {
            self.by_gathers(s, row)
        } else {
            self.by_slots(s, row)
        }
    }
}

/// Three planes of each lane's own slot. Where slots share registers, parts are found on the way: for so few planes a loop that finds
/// them beforehand costs more than it saves.
#[inline(always)]
pub(super) fn three_planes<S: Simd>(
    s: S,
    table: &TilePlanes,
    words: Words<'_>,
    slots: u32x16<S>,
    [i, j, k]: [usize; 3],
) -> [Plane<S>; 3] {
    if !is_wide(s) {
        let own = Own::new(s, table, words, slots);
        return [own.plane(s, i), own.plane(s, j), own.plane(s, k)];
    }
    let (octets, within) = (slots >> 3, slots & 7);
    let [i, j, k] = [i * COEFFICIENTS, j * COEFFICIENTS, k * COEFFICIENTS];
    let mut line = Line([0; LANES]);
    octets.store_slice(&mut line.0);
    let Line(lanes) = &line;
    let (key, rows) = (lanes[0], table.group_of(lanes[0] << 3));
    let mut out = [
        pick(s, plane(rows, i), key, within),
        pick(s, plane(rows, j), key, within),
        pick(s, plane(rows, k), key, within),
    ];
    let mut left = !octets.simd_eq(key).to_bitmask() as u16;
    while left != 0 {
        let key = lanes[left.trailing_zeros() as usize & 15];
        let (mine, rows) = (octets.simd_eq(key), table.group_of(key << 3));
        left &= !(mine.to_bitmask() as u16);
        put(mine, pick(s, plane(rows, i), key, within), &mut out[0]);
        put(mine, pick(s, plane(rows, j), key, within), &mut out[1]);
        put(mine, pick(s, plane(rows, k), key, within), &mut out[2]);
    }
    out
}

/// The coefficients of the slots `within` an octet. (No closures: they would lose the level's instructions.)
#[inline(always)]
fn pick<S: Simd>(s: S, from: &Plane16, octet_index: u32, within: u32x16<S>) -> Plane<S> {
    let half = octet_index as usize % 2;
    [
        octet(s, &from[0].as_chunks().0[half], within),
        octet(s, &from[1].as_chunks().0[half], within),
        octet(s, &from[2].as_chunks().0[half], within),
        octet(s, &from[3].as_chunks().0[half], within),
        octet(s, &from[4].as_chunks().0[half], within),
    ]
}

/// The coefficients of one slot in every lane.
#[inline(always)]
fn spread<S: Simd>(s: S, from: &Plane16, slot: usize) -> Plane<S> {
    let lane = slot % LANES;
    [
        f32x16::splat(s, from[0][lane]),
        f32x16::splat(s, from[1][lane]),
        f32x16::splat(s, from[2][lane]),
        f32x16::splat(s, from[3][lane]),
        f32x16::splat(s, from[4][lane]),
    ]
}

#[inline(always)]
fn lanes_of<S: Simd>(s: S, level: Option<[f32; 2]>) -> Option<[f32x16<S>; 2]> {
    let [w, r] = level?;
    Some([f32x16::splat(s, w), f32x16::splat(s, r)])
}

/// A plane on a row of blocks.
#[derive(Clone, Copy)]
pub(super) struct OnRow<S: Simd> {
    a: f32x16<S>,
    b: f32x16<S>,
    /// Its value at the tile's middle column.
    start: f32x16<S>,
    lo: f32x16<S>,
    hi: f32x16<S>,
}

impl<S: Simd> OnRow<S> {
    #[inline(always)]
    pub(super) fn new([a, b, c, lo, hi]: Plane<S>, py: f32x16<S>) -> Self {
        let start = c + b * py;
        Self {
            a,
            b,
            start,
            lo,
            hi,
        }
    }

    #[inline(always)]
    fn at(&self, px: f32x16<S>) -> f32x16<S> {
        self.start + self.a * px
    }

    /// As if the attribute were linear on the screen: value, and change to the right and down.
    #[inline(always)]
    pub(super) fn straight(&self, px: f32x16<S>) -> [f32x16<S>; 3] {
        [clamp(self.at(px), self.lo, self.hi), self.a, self.b]
    }
}

/// Takes over the plane of some pixels.
#[inline(always)]
fn put<S: Simd>(pixels: mask32x16<S>, from: Plane<S>, to: &mut Plane<S>) {
    for c in 0..COEFFICIENTS {
        to[c] = pixels.select(from[c], to[c]);
    }
}

/// The plane that begins at a row of the table.
#[inline(always)]
fn plane(rows: &[[f32; LANES]], row: usize) -> &Plane16 {
    let plane = rows.get(row..).and_then(|rows| rows.first_chunk());
    plane.unwrap_or(NO_PLANE)
}

/// The pixels of a block, with 1 / clip w and its reciprocal.
pub(super) struct Pixels<S: Simd> {
    px: f32x16<S>,
    /// Change of 1/w to the right and down.
    slope: [f32x16<S>; 2],
    pub(super) w: f32x16<S>,
    r: f32x16<S>,
}

impl<S: Simd> Pixels<S> {
    #[inline(always)]
    pub(super) fn new(
        s: S,
        plane: &OnRow<S>,
        level: Option<[f32x16<S>; 2]>,
        px: f32x16<S>,
    ) -> Self {
        let [w, r] = match level {
            Some(level) => level,
            None => {
                let w = clamp(plane.at(px), plane.lo, plane.hi);
                [w, f32x16::splat(s, 1.0) / w]
            }
        };
        Self {
            px,
            slope: [plane.a, plane.b],
            w,
            r,
        }
    }

    /// An attribute of a plane, and if `D` its change to the right and down.
    #[inline(always)]
    pub(super) fn attribute<const D: bool>(&self, plane: &OnRow<S>) -> [f32x16<S>; 3] {
        let (OnRow { a, b, .. }, [wa, wb]) = (*plane, self.slope);
        let u = clamp(plane.at(self.px) * self.r, plane.lo, plane.hi);
        if !D {
            return [u, a, b];
        }
        [u, (a - u * wa) * self.r, (b - u * wb) * self.r]
    }
}
