//! Memory layout of the planes of a block's pixels, and their loads into lanes. Plane 0 is that of 1/w, plane 1 + k that of
//! attribute k.

use texmap_math::lanes::CacheAligned;
use texmap_math::simd::{GatherTable, Isa, Scalar, prelude::*};

use super::BlockValues;
use crate::setup::group::GROUP;
use crate::setup::plane_table::AttributePlanes;
use crate::setup::planes::{COEFFICIENTS, RowPlane};

/// A plane of sixteen slots.
type GroupPlane = [[f32; GROUP]; COEFFICIENTS];

const NO_PLANE: &GroupPlane = &[[0.0; GROUP]; COEFFICIENTS];

/// Triangles of a block that are taken one by one, where eight neighbours do not share a register.
const FEW: usize = 5;

/// A plane's coefficients in lanes: a, b, c, lo, hi.
type Plane<I> = [<I as Isa>::F32; COEFFICIENTS];

/// Gives the planes of a block's pixels.
pub(super) trait PlaneSource<I: Isa> {
    /// Each lane's coefficients of a plane.
    fn plane(&self, i: I, index: usize) -> Plane<I>;

    /// 1 / clip w and its reciprocal, where they are the same at all pixels. Their division is the dearest step.
    fn constant_w(&self, _: I) -> Option<[I::F32; 2]> {
        None
    }

    /// True if an attribute is linear on the screen.
    fn is_linear(&self, _attribute: usize) -> bool {
        false
    }
}

/// The planes of one slot, where they lie. Each block spreads them again, since a load that spreads costs less than two registers'
/// worth of memory.
#[derive(Clone, Copy)]
pub(crate) struct One<'t> {
    words: &'t [[f32; GROUP]],
    lane: usize,
    constant_w: Option<[f32; 2]>,
    /// Attributes that are linear on the screen, a bit each.
    linear: u32,
}

impl<'t> One<'t> {
    pub(super) const NONE: Self = Self {
        words: &[],
        lane: 0,
        constant_w: None,
        linear: 0,
    };

    #[inline(always)]
    pub(crate) fn new(table: &'t AttributePlanes, slot: u32) -> Self {
        let mut one = Self {
            words: table.group_of(slot),
            lane: slot as usize % GROUP,
            constant_w: None,
            linear: table.linear(slot),
        };
        let [a, b, c, lo, hi] = one.own(0);
        if a == 0.0 && b == 0.0 {
            let w = RowPlane::<Scalar>::new([a, b, c, lo, hi], 0.0).value(0.0);
            one.constant_w = Some([w, 1.0 / w]);
        }
        one
    }

    /// The coefficients of one of the planes.
    #[inline(always)]
    pub(crate) fn own(&self, index: usize) -> [f32; COEFFICIENTS] {
        let plane = plane(self.words, index * COEFFICIENTS);
        plane.each_ref().map(|c| c[self.lane % GROUP])
    }

    /// True if an attribute is linear on the screen.
    pub(crate) fn has_linear(&self, attribute: usize) -> bool {
        self.linear >> attribute & 1 == 1
    }
}

/// 1/w and two attributes of [`One`], found once for all blocks of a slot.
pub(super) struct OnePair<'t> {
    planes: [&'t GroupPlane; 3],
    lane: usize,
    constant_w: Option<[f32; 2]>,
    linear: [bool; 2],
}

impl<'t> OnePair<'t> {
    pub(super) const NONE: Self = Self {
        planes: [NO_PLANE; 3],
        lane: 0,
        constant_w: None,
        linear: [false; 2],
    };

    #[inline(always)]
    pub(super) fn new(table: &'t AttributePlanes, slot: u32, [j, k]: [usize; 2]) -> Self {
        let one = One::new(table, slot);
        let of = |index: usize| plane(one.words, index * COEFFICIENTS);
        Self {
            planes: [of(0), of(1 + j), of(1 + k)],
            lane: one.lane,
            constant_w: one.constant_w,
            linear: [one.has_linear(j), one.has_linear(k)],
        }
    }

    /// Terms that the blocks of a row share.
    #[inline(always)]
    pub(super) fn on_row<I: Isa>(&self, i: I, py: I::F32) -> PairOnRow<I> {
        let [w, first, second] = self.planes;
        PairOnRow {
            w: RowPlane::new(spread(i, w, self.lane), py),
            pair: [
                RowPlane::new(spread(i, first, self.lane), py),
                RowPlane::new(spread(i, second, self.lane), py),
            ],
            constant_w: lanes_of(i, self.constant_w),
            linear: self.linear,
        }
    }
}

/// [`OnePair`] on a row of blocks.
pub(super) struct PairOnRow<I: Isa> {
    w: RowPlane<I>,
    pair: [RowPlane<I>; 2],
    constant_w: Option<[I::F32; 2]>,
    linear: [bool; 2],
}

impl<I: Isa> PairOnRow<I> {
    /// The values of a block.
    #[inline(always)]
    pub(super) fn values<const D: bool>(&self, i: I, px: I::F32) -> BlockValues<I> {
        let mut values = BlockValues::new::<D>(
            i,
            [&self.w, &self.pair[0], &self.pair[1]],
            self.constant_w,
            px,
        );
        if self.linear != [false; 2] {
            for k in 0..2 {
                if self.linear[k] {
                    let [u, dx, dy] = self.pair[k].linear(px);
                    (values.value[k], values.ddx[k], values.ddy[k]) = (u, dx, dy);
                }
            }
        }
        values
    }
}

impl<I: Isa> PlaneSource<I> for One<'_> {
    #[inline(always)]
    fn plane(&self, i: I, index: usize) -> Plane<I> {
        spread(i, plane(self.words, index * COEFFICIENTS), self.lane)
    }

    #[inline(always)]
    fn constant_w(&self, i: I) -> Option<[I::F32; 2]> {
        lanes_of(i, self.constant_w)
    }

    #[inline(always)]
    fn is_linear(&self, attribute: usize) -> bool {
        self.has_linear(attribute)
    }
}

/// The planes of each lane's own slot: eight neighbouring slots at a time where they share a register, else slot by slot, or by gathers
/// where a block has many.
pub(super) struct Own<'t, I: Isa> {
    rows: &'t [[f32; GROUP]],
    words: GatherTable<'t>,
    /// Coefficients a group.
    per_group: usize,
    slots: I::U32,
    /// The key that the slots of each part share, and the index of the part's planes.
    keys: [u32; GROUP],
    starts: [u32; GROUP],
    parts: usize,
    /// There are more parts.
    gathers: bool,
}

impl<'t, I: Isa> Own<'t, I> {
    #[inline(always)]
    pub(super) fn new(
        i: I,
        table: &'t AttributePlanes,
        words: GatherTable<'t>,
        slots: I::U32,
    ) -> Self {
        let (octets, per_group) = (i.is_wide(), table.per_group);
        let mut own = Self {
            rows: table.words.as_chunks().0,
            words,
            per_group,
            slots,
            keys: [0; GROUP],
            starts: [0; GROUP],
            parts: 0,
            gathers: false,
        };
        let (keys, most) = if octets {
            (slots >> 3, GROUP)
        } else {
            (slots, FEW)
        };
        let mut lanes = [0; GROUP];
        keys.store(&mut lanes);
        let mut left = every_lane(i);
        while left != 0 && own.parts < most {
            let key = lanes[left.trailing_zeros() as usize & 15];
            let group = if octets { key >> 1 } else { key >> 4 };
            own.keys[own.parts] = key;
            own.starts[own.parts] = group * per_group as u32;
            own.parts += 1;
            left &= !keys.simd_eq(key).to_bitmask();
        }
        own.gathers = left != 0;
        own
    }

    /// The parts after the first: what their slots share, and where their planes begin.
    #[inline(always)]
    fn others(&self) -> impl Iterator<Item = (u32, u32)> {
        let others = 1..self.parts.clamp(1, GROUP);
        let starts = &self.starts[others.clone()];
        self.keys[others]
            .iter()
            .copied()
            .zip(starts.iter().copied())
    }

    #[inline(always)]
    fn by_octets(&self, i: I, row: usize) -> Plane<I> {
        let (octets, within) = (self.slots >> 3, self.slots & 7);
        let first = plane(self.rows, self.starts[0] as usize + row);
        let mut out = pick(i, first, self.keys[0], within);
        for (key, start) in self.others() {
            let from = plane(self.rows, start as usize + row);
            put::<I>(octets.simd_eq(key), pick(i, from, key, within), &mut out);
        }
        out
    }

    #[inline(always)]
    fn by_slots(&self, i: I, row: usize) -> Plane<I> {
        let first = plane(self.rows, self.starts[0] as usize + row);
        let mut out = spread(i, first, self.keys[0] as usize);
        for (key, start) in self.others() {
            let from = plane(self.rows, start as usize + row);
            put::<I>(
                self.slots.simd_eq(key),
                spread(i, from, key as usize),
                &mut out,
            );
        }
        out
    }

    #[inline(always)]
    fn by_gathers(&self, i: I, row: usize) -> Plane<I> {
        let groups = (self.slots >> 4) * (self.per_group * GROUP) as u32;
        let start = groups + (self.slots & 15) + (row * GROUP) as u32;
        let mut out = [i.f32(0.0); COEFFICIENTS];
        for (c, out) in out.iter_mut().enumerate() {
            *out = i
                .gather(self.words, start + (c * GROUP) as u32)
                .to_f32_bits();
        }
        out
    }
}

impl<I: Isa> PlaneSource<I> for Own<'_, I> {
    #[inline(always)]
    fn plane(&self, i: I, index: usize) -> Plane<I> {
        let row = index * COEFFICIENTS;
        if i.is_wide() {
            self.by_octets(i, row)
        } else if self.gathers {
            self.by_gathers(i, row)
        } else {
            self.by_slots(i, row)
        }
    }
}

/// Three planes of each lane's own slot. If slots share registers, parts are found on the way: for so few planes a loop that finds
/// them beforehand costs more than it saves.
#[inline(always)]
pub(super) fn three_planes<I: Isa>(
    i: I,
    table: &AttributePlanes,
    words: GatherTable<'_>,
    slots: I::U32,
    indices: [usize; 3],
) -> [Plane<I>; 3] {
    if !i.is_wide() {
        let own = Own::new(i, table, words, slots);
        let [a, b, c] = indices;
        return [own.plane(i, a), own.plane(i, b), own.plane(i, c)];
    }
    let (octets, within) = (slots >> 3, slots & 7);
    let [a, b, c] = [
        indices[0] * COEFFICIENTS,
        indices[1] * COEFFICIENTS,
        indices[2] * COEFFICIENTS,
    ];
    let mut line = CacheAligned([0; GROUP]);
    octets.store(&mut line.0);
    let CacheAligned(lanes) = &line;
    let (key, rows) = (lanes[0], table.group_of(lanes[0] << 3));
    let mut out = [
        pick(i, plane(rows, a), key, within),
        pick(i, plane(rows, b), key, within),
        pick(i, plane(rows, c), key, within),
    ];
    let mut left = every_lane(i) & !octets.simd_eq(key).to_bitmask();
    while left != 0 {
        let key = lanes[left.trailing_zeros() as usize & 15];
        let (mine, rows) = (octets.simd_eq(key), table.group_of(key << 3));
        left &= !mine.to_bitmask();
        put::<I>(mine, pick(i, plane(rows, a), key, within), &mut out[0]);
        put::<I>(mine, pick(i, plane(rows, b), key, within), &mut out[1]);
        put::<I>(mine, pick(i, plane(rows, c), key, within), &mut out[2]);
    }
    out
}

/// A bit for each lane.
#[inline(always)]
fn every_lane<I: Isa>(_: I) -> u32 {
    (1 << I::LANES) - 1
}

/// The coefficients of the slots `within` an octet. (No closures: they would lose the level's instructions.)
#[inline(always)]
fn pick<I: Isa>(i: I, from: &GroupPlane, octet_index: u32, within: I::U32) -> Plane<I> {
    let half = octet_index as usize % 2;
    [
        i.table8(&from[0].as_chunks().0[half], within),
        i.table8(&from[1].as_chunks().0[half], within),
        i.table8(&from[2].as_chunks().0[half], within),
        i.table8(&from[3].as_chunks().0[half], within),
        i.table8(&from[4].as_chunks().0[half], within),
    ]
}

/// The coefficients of one slot in every lane.
#[inline(always)]
fn spread<I: Isa>(i: I, from: &GroupPlane, slot: usize) -> Plane<I> {
    let lane = slot % GROUP;
    [
        i.f32(from[0][lane]),
        i.f32(from[1][lane]),
        i.f32(from[2][lane]),
        i.f32(from[3][lane]),
        i.f32(from[4][lane]),
    ]
}

#[inline(always)]
fn lanes_of<I: Isa>(i: I, constant_w: Option<[f32; 2]>) -> Option<[I::F32; 2]> {
    let [w, r] = constant_w?;
    Some([i.f32(w), i.f32(r)])
}

/// Takes over the plane of some pixels.
#[inline(always)]
fn put<I: Isa>(pixels: I::Mask, from: Plane<I>, to: &mut Plane<I>) {
    for c in 0..COEFFICIENTS {
        to[c] = pixels.select(from[c], to[c]);
    }
}

/// The plane that begins at a row of the table.
#[inline(always)]
fn plane(rows: &[[f32; GROUP]], row: usize) -> &GroupPlane {
    let plane = rows.get(row..).and_then(|rows| rows.first_chunk());
    plane.unwrap_or(NO_PLANE)
}
