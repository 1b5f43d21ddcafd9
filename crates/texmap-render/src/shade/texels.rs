//! Packed RGBA8 texels of a batch: uv and mip of its pixels, then one word a pixel. Textures whose filter gives bytes take this
//! kernel on levels with wide registers; others are read channel by channel.

use texmap_math::fearless_simd::{Simd, SimdBase, f32x16, i32x16};
use texmap_math::simd::X16;
use texmap_math::{Level, on_wide_level};
use texmap_raster::{BlockSink, BlockValues, NONE, RUN_ROOM, RunBlock, TileBlocks, TilePlanes};
use texmap_sample::lanes::packed::{self, FootprintLanes};
use texmap_sample::lanes::{Kind, RGBA8, View};
use texmap_sample::{Sampler, Texture2d};

use super::batch::{BatchUv, LANES};

/// A texture whose look-ups are RGBA8 words; `None` if they are not, or the level has no kernel for them.
pub(crate) fn packed_view<'a>(
    level: Level,
    sampler: &Sampler,
    texture: &'a Texture2d<'_>,
) -> Option<View<'a>> {
    let view = View::new(sampler, texture)?;
    let packed = view.format == RGBA8 && view.kind.is_plain();
    (packed && on_wide_level!(level, _s => true, else false)).then_some(view)
}

/// Coordinates and mips of the texels that a batch reads.
pub(crate) struct TexelAddresses {
    pub(crate) uv: BatchUv,
    /// In each of two textures, with 8 fraction bits.
    mips: [[i32; RUN_ROOM]; 2],
    /// Triangles in a row of which not all texels were magnified.
    refusals: u32,
}

impl Default for TexelAddresses {
    fn default() -> Self {
        Self {
            uv: BatchUv::default(),
            mips: [[0; RUN_ROOM]; 2],
            refusals: 0,
        }
    }
}

impl TexelAddresses {
    /// Stores the mips of 16 pixels from `at` on, by the changes of uv to the right and down.
    #[inline(always)]
    fn put_mips<S: Simd>(
        &mut self,
        s: S,
        (texture, view): (usize, &View<'_>),
        at: usize,
        [ux, vx]: [f32x16<S>; 2],
        [uy, vy]: [f32x16<S>; 2],
    ) {
        let footprint = FootprintLanes::new(s, view, ux, vx, uy, vy);
        let mip = packed::lod_lanes(s, view, &footprint);
        mip.store_slice(&mut self.mips[texture][at..at + LANES]);
    }
}

/// Pixels of a tile whose attributes 0 and 1 are the coordinates.
pub(crate) enum Pixels<'a> {
    /// The blocks of a tile.
    Blocks(&'a TilePlanes, &'a TileBlocks),
    /// Pixels anywhere in the tile, and the slot of each: see [`TilePlanes::each_sixteen`].
    Scattered(&'a TilePlanes, [&'a [u32]; 2]),
}

/// Reads the texels of a batch.
pub(crate) fn read_texels(
    level: Level,
    view: &View<'_>,
    pixels: &Pixels<'_>,
    batch: &[RunBlock],
    addresses: &mut TexelAddresses,
    out: &mut [u32; RUN_ROOM],
) {
    on_wide_level!(
        level,
        s => read(s, view, pixels, batch, addresses, out),
        else debug_assert!(false, "no view on this level")
    );
}

/// Reads the texels of two textures at the same coordinates; `same_mips` if their sizes, filters and mips are the same.
pub(crate) fn read_pair(
    level: Level,
    views: &[Option<View<'_>>; 2],
    same_mips: bool,
    pixels: &Pixels<'_>,
    batch: &[RunBlock],
    addresses: &mut TexelAddresses,
    out: [&mut [u32; RUN_ROOM]; 2],
) {
    if let [Some(view), None] = views {
        let [out, _] = out;
        return read_texels(level, view, pixels, batch, addresses, out);
    }
    on_wide_level!(
        level,
        s => {
            let [a, b] = views.each_ref().map(Option::as_ref);
            if a.into_iter().chain(b).any(reads_mips) {
                let own = [a, if same_mips { None } else { b }];
                pixels.each::<_, true, _>(s, batch, &mut Store::<true>::new(0, own, addresses));
            } else {
                pixels.each::<_, false, _>(s, batch, &mut Store::<false>::new(0, [None; 2], addresses));
            }
            for (k, (view, out)) in views.iter().zip(out).enumerate() {
                if let Some(view) = view {
                    let mips = if same_mips { 0 } else { k };
                    texels(s, view, addresses, mips, 0..batch.len(), out);
                }
            }
        },
        else debug_assert!(false, "no view on this level")
    );
}

/// Reads the texels at stored coordinates, which change by `changes` to the right and down.
pub(crate) fn read_placed(
    level: Level,
    view: &View<'_>,
    addresses: &mut TexelAddresses,
    [dx, dy]: &[BatchUv; 2],
    blocks: usize,
    out: &mut [u32; RUN_ROOM],
) {
    on_wide_level!(
        level,
        s => {
            if reads_mips(view) {
                for at in (0..blocks * LANES).step_by(LANES) {
                    let (dx, dy) = (dx.load(X16(s), at), dy.load(X16(s), at));
                    addresses.put_mips(s, (0, view), at, dx, dy);
                }
            }
            texels(s, view, addresses, 0, 0..blocks, out);
        },
        else debug_assert!(false, "no view on this level")
    );
}

impl Pixels<'_> {
    #[inline(always)]
    fn each<S: Simd, const D: bool, K: BlockSink<S>>(
        &self,
        s: S,
        batch: &[RunBlock],
        sink: &mut K,
    ) {
        match self {
            Self::Blocks(planes, blocks) => {
                if !self.each_named::<S, D, K>(s, batch, sink) {
                    planes.each_block::<_, D, _>(s, blocks, batch, [0, 1], sink);
                }
            }
            Self::Scattered(planes, of) => {
                planes.each_sixteen::<_, D, _>(s, *of, batch, [0, 1], sink);
            }
        }
    }

    /// [`each`](Self::each) in a loop that leaves more registers to the sink; false, with nothing done, where it does not serve.
    #[inline(always)]
    fn each_named<S: Simd, const D: bool, K: BlockSink<S>>(
        &self,
        s: S,
        batch: &[RunBlock],
        sink: &mut K,
    ) -> bool {
        let Self::Blocks(planes, _) = self else {
            return false;
        };
        let named = planes.is_plain() && batch.iter().all(|at| at.slot != NONE);
        if named {
            planes.each_named::<_, D, _>(s, batch, [0, 1], sink);
        }
        named
    }
}

#[inline(always)]
fn read<S: Simd>(
    s: S,
    view: &View<'_>,
    pixels: &Pixels<'_>,
    batch: &[RunBlock],
    addresses: &mut TexelAddresses,
    out: &mut [u32; RUN_ROOM],
) {
    if view.kind == Kind::Nearest
        && let Some(texels) = packed::Masked::new(s, view)
        && pixels.each_named::<_, false, _>(s, batch, &mut Nearest { texels, out })
    {
        return;
    }
    if !reads_mips(view) {
        let mut sink = Store::<false>::new(0, [None; 2], addresses);
        pixels.each::<_, false, _>(s, batch, &mut sink);
        return texels(s, view, addresses, 0, 0..batch.len(), out);
    }
    // Neither derivatives nor mips are asked for where the bits do not depend on them.
    let mut magnified = Magnified::new(addresses.refusals);
    let mut first = 0;
    while first < batch.len() {
        let near = magnified.covers(s, pixels, view, &batch[first..]);
        let mut end = first + 1;
        while end < batch.len() && magnified.covers(s, pixels, view, &batch[end..]) == near {
            end += 1;
        }
        let part = &batch[first..end];
        if near {
            let mut sink = Store::<false>::new(first, [None; 2], addresses);
            pixels.each::<_, false, _>(s, part, &mut sink);
            bilinear(s, view, addresses, first..end, out);
        } else {
            let mut sink = Store::<true>::new(first, [Some(view), None], addresses);
            pixels.each::<_, true, _>(s, part, &mut sink);
            texels(s, view, addresses, 0, first..end, out);
        }
        first = end;
    }
    addresses.refusals = magnified.refusals;
}

#[inline(always)]
fn texels<S: Simd>(
    s: S,
    view: &View<'_>,
    addresses: &TexelAddresses,
    mips: usize,
    blocks: core::ops::Range<usize>,
    out: &mut [u32; RUN_ROOM],
) {
    match view.kind {
        Kind::Nearest => {
            for k in blocks {
                let [u, v] = addresses.uv.load(X16(s), k * LANES);
                let word = packed::nearest_lanes(s, view, u, v);
                word.store_slice(&mut out[k * LANES..(k + 1) * LANES]);
            }
        }
        Kind::Bilinear => bilinear(s, view, addresses, blocks, out),
        _ => {
            for k in blocks {
                let [u, v] = addresses.uv.load(X16(s), k * LANES);
                let mip = i32x16::from_slice(s, &addresses.mips[mips][k * LANES..(k + 1) * LANES]);
                let word = packed::trilinear_lanes(s, view, u, v, mip);
                word.store_slice(&mut out[k * LANES..(k + 1) * LANES]);
            }
        }
    }
}

#[inline(always)]
fn bilinear<S: Simd>(
    s: S,
    view: &View<'_>,
    addresses: &TexelAddresses,
    blocks: core::ops::Range<usize>,
    out: &mut [u32; RUN_ROOM],
) {
    for k in blocks {
        let [u, v] = addresses.uv.load(X16(s), k * LANES);
        let word = packed::bilinear_lanes(s, view, u, v);
        word.store_slice(&mut out[k * LANES..(k + 1) * LANES]);
    }
}

/// So many refusals in a row, and only one block of so many is asked about: few surfaces of small triangles are that near.
const PATIENCE: u32 = 4;
const SELDOM: u16 = 8;
/// Blocks after the first that a slot must have alone to be asked about: that costs as much as the derivatives of a few blocks.
const ALIKE: usize = 3;

/// The triangle that was asked about last.
struct Magnified {
    slot: u32,
    near: bool,
    refusals: u32,
}

impl Magnified {
    fn new(refusals: u32) -> Self {
        Self {
            slot: NONE,
            near: false,
            refusals,
        }
    }

    /// True if all texels of the first block of `batch` are surely magnified, and it is worth knowing.
    #[inline(always)]
    fn covers<S: Simd>(
        &mut self,
        s: S,
        pixels: &Pixels<'_>,
        view: &View<'_>,
        batch: &[RunBlock],
    ) -> bool {
        let Pixels::Blocks(planes, blocks) = pixels else {
            return false;
        };
        let seldom = |at: &RunBlock| !at.block.is_multiple_of(SELDOM);
        if self.refusals >= PATIENCE && batch.first().is_none_or(seldom) {
            return false;
        }
        let Some(slot) = batch.first().and_then(
            #[inline(always)]
            |at| planes.only_slot(s, blocks, *at),
        ) else {
            return false;
        };
        if slot != self.slot {
            let later = batch.get(ALIKE).and_then(
                #[inline(always)]
                |at| planes.only_slot(s, blocks, *at),
            );
            if later != Some(slot) {
                return false;
            }
            let steepest = planes.steepest(slot, [0, 1]);
            self.near = steepest.is_some_and(
                #[inline(always)]
                |[u, v]| magnifies(s, view, u, v),
            );
            self.refusals = if self.near { 0 } else { self.refusals + 1 };
            self.slot = slot;
        }
        self.near
    }
}

/// True if a footprint within these changes of u and v to the right and down reads the finest mip alone.
#[inline(always)]
fn magnifies<S: Simd>(s: S, view: &View<'_>, [ux, uy]: [f32; 2], [vx, vy]: [f32; 2]) -> bool {
    let footprint = FootprintLanes::new(
        s,
        view,
        f32x16::splat(s, ux),
        f32x16::splat(s, vx),
        f32x16::splat(s, uy),
        f32x16::splat(s, vy),
    );
    packed::lod_lanes(s, view, &footprint)[0] <= 0
}

/// Nearest texels, from the coordinates in registers.
struct Nearest<'a, 'v, S: Simd> {
    texels: packed::Masked<'v, S>,
    out: &'a mut [u32; RUN_ROOM],
}

impl<S: Simd> BlockSink<S> for Nearest<'_, '_, S> {
    #[inline(always)]
    fn block(&mut self, s: S, k: usize, _: RunBlock, values: &BlockValues<S>) {
        let [u, v] = values.value;
        let word = self.texels.nearest(s, u, v);
        word.store_slice(&mut self.out[k * LANES..(k + 1) * LANES]);
    }
}

/// Stores coordinates, and mips in the views where `D` asks for them.
struct Store<'a, 'v, const D: bool> {
    /// The block of the batch that the first one shown is.
    first: usize,
    views: [Option<&'a View<'v>>; 2],
    addresses: &'a mut TexelAddresses,
}

impl<'a, 'v, const D: bool> Store<'a, 'v, D> {
    fn new(
        first: usize,
        views: [Option<&'a View<'v>>; 2],
        addresses: &'a mut TexelAddresses,
    ) -> Self {
        Self {
            first,
            views,
            addresses,
        }
    }
}

impl<S: Simd, const D: bool> BlockSink<S> for Store<'_, '_, D> {
    #[inline(always)]
    fn block(&mut self, s: S, k: usize, _: RunBlock, values: &BlockValues<S>) {
        let at = (self.first + k) * LANES;
        self.addresses.uv.store(X16(s), at, values.value);
        if D {
            for (texture, view) in self.views.iter().enumerate() {
                if let Some(view) = view {
                    let of = (texture, *view);
                    self.addresses.put_mips(s, of, at, values.ddx, values.ddy);
                }
            }
        }
    }
}

/// True if the filter of a view asks how large a pixel is.
fn reads_mips(view: &View<'_>) -> bool {
    view.kind == Kind::Trilinear
}
