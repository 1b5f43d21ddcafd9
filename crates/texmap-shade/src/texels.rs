//! Packed RGBA8 texels of a batch: uv and mip of its pixels, then one word a pixel. Textures whose filter gives bytes take this
//! kernel; others are read channel by channel.

use texmap_math::simd::{ByteIsa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{
    AttributePlanes, BATCH_STRIDE, BlockSink, BlockValues, FragmentBlock, NO_PRIMITIVE,
    TileVisibility,
};
use texmap_sample::lanes::packed::{self, FootprintLanes};
use texmap_sample::lanes::{BoundTexture, Kernel, RGBA8};
use texmap_sample::{Sampler, Texture2d};

use crate::batch::{Columns, LANES};

/// A texture whose look-ups are RGBA8 words; `None` if they are not.
pub(crate) fn packed_view<'a>(
    sampler: &Sampler,
    texture: &'a Texture2d<'_>,
) -> Option<BoundTexture<'a>> {
    let view = BoundTexture::new(sampler, texture)?;
    (view.format == RGBA8 && view.kind.is_plain()).then_some(view)
}

/// Coordinates and mips of the texels that a batch reads.
pub struct TexelAddresses {
    pub(crate) uv: Columns<2>,
    /// Mips in each of two textures, with 8 fraction bits.
    mips: [[i32; BATCH_STRIDE]; 2],
    /// Triangles in a row of which not all texels were magnified.
    refusals: u32,
}

impl Default for TexelAddresses {
    fn default() -> Self {
        Self {
            uv: Columns::default(),
            mips: [[0; BATCH_STRIDE]; 2],
            refusals: 0,
        }
    }
}

impl TexelAddresses {
    /// Stores the mips of the pixels from `at` on, by the changes of uv to the right and down.
    #[inline(always)]
    fn put_mips<I: ByteIsa>(
        &mut self,
        i: I,
        (texture, view): (usize, &BoundTexture<'_>),
        at: usize,
        [ux, vx]: [I::F32; 2],
        [uy, vy]: [I::F32; 2],
    ) {
        let footprint = FootprintLanes::new(i, view, ux, vx, uy, vy);
        let mip = packed::lod_lanes(i, view, &footprint);
        mip.store(&mut self.mips[texture][at..at + I::LANES]);
    }
}

/// Pixels of a tile whose attributes 0 and 1 are the coordinates.
pub enum Pixels<'a> {
    /// The blocks of a tile.
    Blocks(&'a AttributePlanes, &'a TileVisibility),
    /// Pixels anywhere in the tile, and the slot of each: see [`AttributePlanes::each_sixteen`].
    Scattered(&'a AttributePlanes, [&'a [u32]; 2]),
}

/// Reads the texels of a batch.
pub fn read_texels(
    level: Level,
    view: &BoundTexture<'_>,
    pixels: &Pixels<'_>,
    batch: &[FragmentBlock],
    addresses: &mut TexelAddresses,
    out: &mut [u32; BATCH_STRIDE],
) {
    dispatch_simd!(level, wide i => read(i, view, pixels, batch, addresses, out));
}

/// Hands the nearest texels of a batch to `store`, some pixels of a block at a time, as they leave the registers; false, with nothing
/// done, where another kernel must serve. `store` must be `#[inline(always)]`.
pub fn read_nearest(
    level: Level,
    view: &BoundTexture<'_>,
    pixels: &Pixels<'_>,
    batch: &[FragmentBlock],
    store: impl FnMut(FragmentBlock, usize, &[u32]),
) -> bool {
    view.kind == Kernel::Nearest
        && dispatch_simd!(level, wide i => nearest(i, view, pixels, batch, store))
}

#[inline(always)]
fn nearest<I: ByteIsa>(
    i: I,
    view: &BoundTexture<'_>,
    pixels: &Pixels<'_>,
    batch: &[FragmentBlock],
    store: impl FnMut(FragmentBlock, usize, &[u32]),
) -> bool {
    let Some(texels) = packed::PowerOfTwoTexture::new(i, view) else {
        return false;
    };
    pixels.each_named::<_, false, _>(i, batch, &mut Nearest { texels, store })
}

/// Reads the texels of two textures at the same coordinates; `same_mips` if their sizes, filters and mips are the same.
pub(crate) fn read_pair(
    level: Level,
    views: &[Option<BoundTexture<'_>>; 2],
    same_mips: bool,
    pixels: &Pixels<'_>,
    batch: &[FragmentBlock],
    addresses: &mut TexelAddresses,
    out: [&mut [u32; BATCH_STRIDE]; 2],
) {
    if let [Some(view), None] = views {
        let [out, _] = out;
        return read_texels(level, view, pixels, batch, addresses, out);
    }
    let views = views.each_ref().map(Option::as_ref);
    dispatch_simd!(level, i => pair(i, views, same_mips, pixels, batch, addresses, out));
}

#[inline(always)]
fn pair<I: ByteIsa>(
    i: I,
    views: [Option<&BoundTexture<'_>>; 2],
    same_mips: bool,
    pixels: &Pixels<'_>,
    batch: &[FragmentBlock],
    addresses: &mut TexelAddresses,
    out: [&mut [u32; BATCH_STRIDE]; 2],
) {
    let [a, b] = views;
    if a.into_iter().chain(b).any(reads_mips) {
        let own = [a, if same_mips { None } else { b }];
        pixels.each::<_, true, _>(i, batch, &mut Store::<true>::new(0, own, addresses));
    } else {
        pixels.each::<_, false, _>(i, batch, &mut Store::<false>::new(0, [None; 2], addresses));
    }
    for (k, (view, out)) in views.into_iter().zip(out).enumerate() {
        if let Some(view) = view {
            let mips = if same_mips { 0 } else { k };
            texels(i, (view, view.kind), addresses, mips, 0..batch.len(), out);
        }
    }
}

/// Reads the texels at stored coordinates, which change by `changes` to the right and down.
pub(crate) fn read_placed(
    level: Level,
    view: &BoundTexture<'_>,
    addresses: &mut TexelAddresses,
    changes: &[Columns<2>; 2],
    blocks: usize,
    out: &mut [u32; BATCH_STRIDE],
) {
    dispatch_simd!(level, i => placed(i, view, addresses, changes, blocks, out));
}

#[inline(always)]
fn placed<I: ByteIsa>(
    i: I,
    view: &BoundTexture<'_>,
    addresses: &mut TexelAddresses,
    [dx, dy]: &[Columns<2>; 2],
    blocks: usize,
    out: &mut [u32; BATCH_STRIDE],
) {
    if reads_mips(view) {
        for at in (0..blocks * LANES).step_by(I::LANES) {
            addresses.put_mips(i, (0, view), at, dx.load(i, at), dy.load(i, at));
        }
    }
    texels(i, (view, view.kind), addresses, 0, 0..blocks, out);
}

impl Pixels<'_> {
    #[inline(always)]
    fn each<I: ByteIsa, const D: bool, K: BlockSink<I>>(
        &self,
        i: I,
        batch: &[FragmentBlock],
        sink: &mut K,
    ) {
        match self {
            Self::Blocks(planes, blocks) => {
                if !self.each_named::<I, D, K>(i, batch, sink) {
                    planes.each_block::<_, D, _>(i, blocks, batch, [0, 1], sink);
                }
            }
            Self::Scattered(planes, of) => {
                planes.each_sixteen::<_, D, _>(i, *of, batch, [0, 1], sink);
            }
        }
    }

    /// [`each`](Self::each) in a loop that leaves more registers to the sink; false, with nothing done, where it does not serve.
    #[inline(always)]
    fn each_named<I: ByteIsa, const D: bool, K: BlockSink<I>>(
        &self,
        i: I,
        batch: &[FragmentBlock],
        sink: &mut K,
    ) -> bool {
        let Self::Blocks(planes, _) = self else {
            return false;
        };
        let named = planes.is_branch_free() && batch.iter().all(|at| at.slot != NO_PRIMITIVE);
        if named {
            planes.each_named::<_, D, _>(i, batch, [0, 1], sink);
        }
        named
    }
}

#[inline(always)]
fn read<I: ByteIsa>(
    i: I,
    view: &BoundTexture<'_>,
    pixels: &Pixels<'_>,
    batch: &[FragmentBlock],
    addresses: &mut TexelAddresses,
    out: &mut [u32; BATCH_STRIDE],
) {
    if view.kind == Kernel::Nearest {
        let words = &mut *out;
        let done = nearest(
            i,
            view,
            pixels,
            batch,
            #[inline(always)]
            |_, at, from: &[u32]| words[at..at + from.len()].copy_from_slice(from),
        );
        if done {
            return;
        }
    }
    if !reads_mips(view) {
        let mut sink = Store::<false>::new(0, [None; 2], addresses);
        pixels.each::<_, false, _>(i, batch, &mut sink);
        return texels(i, (view, view.kind), addresses, 0, 0..batch.len(), out);
    }
    // Neither derivatives nor mips are computed where the bits do not depend on them.
    let mut magnified = Magnified::new(addresses.refusals);
    let mut first = 0;
    while first < batch.len() {
        let near = magnified.covers(i, pixels, view, &batch[first..]);
        let mut end = first + 1;
        while end < batch.len() && magnified.covers(i, pixels, view, &batch[end..]) == near {
            end += 1;
        }
        let part = &batch[first..end];
        if near {
            let mut sink = Store::<false>::new(first, [None; 2], addresses);
            pixels.each::<_, false, _>(i, part, &mut sink);
            // As trilinear filters are on level 0.
            texels(i, (view, Kernel::Bilinear), addresses, 0, first..end, out);
        } else {
            let mut sink = Store::<true>::new(first, [Some(view), None], addresses);
            pixels.each::<_, true, _>(i, part, &mut sink);
            texels(i, (view, view.kind), addresses, 0, first..end, out);
        }
        first = end;
    }
    addresses.refusals = magnified.refusals;
}

/// The texels of blocks whose coordinates and mips are stored. Out of line: filters are much code, and every reader has them.
#[inline(never)]
fn texels<I: ByteIsa>(
    i: I,
    (view, kind): (&BoundTexture<'_>, Kernel),
    addresses: &TexelAddresses,
    mips: usize,
    blocks: core::ops::Range<usize>,
    out: &mut [u32; BATCH_STRIDE],
) {
    let pixels = blocks.start * LANES..blocks.end * LANES;
    i.vectorize(
        #[inline(always)]
        || match kind {
            Kernel::Nearest => {
                for at in pixels.step_by(I::LANES) {
                    let [u, v] = addresses.uv.load(i, at);
                    let word = packed::nearest_lanes(i, view, u, v);
                    word.store(&mut out[at..at + I::LANES]);
                }
            }
            Kernel::Bilinear => {
                for at in pixels.step_by(I::LANES) {
                    let [u, v] = addresses.uv.load(i, at);
                    let word = packed::bilinear_lanes(i, view, u, v);
                    word.store(&mut out[at..at + I::LANES]);
                }
            }
            _ => {
                for at in pixels.step_by(I::LANES) {
                    let [u, v] = addresses.uv.load(i, at);
                    let mip = i.load_i32(&addresses.mips[mips][at..at + I::LANES]);
                    let word = packed::trilinear_lanes(i, view, u, v, mip);
                    word.store(&mut out[at..at + I::LANES]);
                }
            }
        },
    );
}

/// Number of refusals in a row after which only one block of [`SELDOM`] is tested. Few surfaces of small triangles are that near.
const PATIENCE: u32 = 4;
const SELDOM: u16 = 8;
/// Blocks after the first that a slot must have alone to be tested. The test costs as much as the derivatives of a few blocks.
const ALIKE: usize = 3;

/// The triangle that was tested last.
struct Magnified {
    slot: u32,
    near: bool,
    refusals: u32,
}

impl Magnified {
    fn new(refusals: u32) -> Self {
        Self {
            slot: NO_PRIMITIVE,
            near: false,
            refusals,
        }
    }

    /// True if all texels of the first block of `batch` are surely magnified, and the test pays.
    #[inline(always)]
    fn covers<I: ByteIsa>(
        &mut self,
        i: I,
        pixels: &Pixels<'_>,
        view: &BoundTexture<'_>,
        batch: &[FragmentBlock],
    ) -> bool {
        let Pixels::Blocks(planes, blocks) = pixels else {
            return false;
        };
        let seldom = |at: &FragmentBlock| !at.block.is_multiple_of(SELDOM);
        if self.refusals >= PATIENCE && batch.first().is_none_or(seldom) {
            return false;
        }
        let Some(at) = batch.first() else {
            return false;
        };
        let Some(slot) = planes.single_primitive(i, blocks, *at) else {
            return false;
        };
        if slot != self.slot {
            let Some(later) = batch.get(ALIKE) else {
                return false;
            };
            if planes.single_primitive(i, blocks, *later) != Some(slot) {
                return false;
            }
            self.near = match planes.max_gradient(slot, [0, 1]) {
                Some([u, v]) => magnifies(i, view, u, v),
                None => false,
            };
            self.refusals = if self.near { 0 } else { self.refusals + 1 };
            self.slot = slot;
        }
        self.near
    }
}

/// True if a footprint within these changes of u and v to the right and down reads the finest mip alone.
#[inline(always)]
fn magnifies<I: ByteIsa>(
    i: I,
    view: &BoundTexture<'_>,
    [ux, uy]: [f32; 2],
    [vx, vy]: [f32; 2],
) -> bool {
    let footprint = FootprintLanes::new(i, view, i.f32(ux), i.f32(vx), i.f32(uy), i.f32(vy));
    i.first(packed::lod_lanes(i, view, &footprint)) <= 0
}

/// True if each block of a batch lies on one triangle, and all of these surely read level 0 of a texture alone.
pub(crate) fn is_near(
    level: Level,
    view: &BoundTexture<'_>,
    pixels: &Pixels<'_>,
    batch: &[FragmentBlock],
) -> bool {
    let Pixels::Blocks(planes, blocks) = pixels else {
        return false;
    };
    dispatch_simd!(level, wide i => all_near(i, view, planes, blocks, batch))
}

#[inline(always)]
fn all_near<I: ByteIsa>(
    i: I,
    view: &BoundTexture<'_>,
    planes: &AttributePlanes,
    blocks: &TileVisibility,
    batch: &[FragmentBlock],
) -> bool {
    let mut last = NO_PRIMITIVE;
    for at in batch {
        let Some(slot) = planes.single_primitive(i, blocks, *at) else {
            return false;
        };
        if slot != last {
            last = slot;
            match planes.max_gradient(slot, [0, 1]) {
                Some([u, v]) if view.is_magnified_by(u, v) => {}
                _ => return false,
            }
        }
    }
    true
}

/// Nearest texels, from the coordinates in registers.
struct Nearest<'v, I: ByteIsa, F> {
    texels: packed::PowerOfTwoTexture<'v, I>,
    /// Block, pixel of the batch, words.
    store: F,
}

impl<I: ByteIsa, F: FnMut(FragmentBlock, usize, &[u32])> BlockSink<I> for Nearest<'_, I, F> {
    #[inline(always)]
    fn pixels(&mut self, i: I, at: usize, block: FragmentBlock, values: &BlockValues<I>) {
        let [u, v] = values.value;
        let mut words = [0; LANES];
        self.texels.nearest(i, u, v).store(&mut words);
        (self.store)(block, at, &words[..I::LANES]);
    }
}

/// Stores coordinates, and mips in the views where `D` asks for them.
struct Store<'a, 'v, const D: bool> {
    /// The block of the batch that the first one shown is.
    first: usize,
    views: [Option<&'a BoundTexture<'v>>; 2],
    addresses: &'a mut TexelAddresses,
}

impl<'a, 'v, const D: bool> Store<'a, 'v, D> {
    fn new(
        first: usize,
        views: [Option<&'a BoundTexture<'v>>; 2],
        addresses: &'a mut TexelAddresses,
    ) -> Self {
        Self {
            first,
            views,
            addresses,
        }
    }
}

impl<I: ByteIsa, const D: bool> BlockSink<I> for Store<'_, '_, D> {
    #[inline(always)]
    fn pixels(&mut self, i: I, at: usize, _: FragmentBlock, values: &BlockValues<I>) {
        let at = self.first * LANES + at;
        self.addresses.uv.store(i, at, values.value);
        if D {
            for (texture, view) in self.views.iter().enumerate() {
                if let Some(view) = view {
                    let of = (texture, *view);
                    self.addresses.put_mips(i, of, at, values.ddx, values.ddy);
                }
            }
        }
    }
}

/// True if the filter of a view reads derivatives.
fn reads_mips(view: &BoundTexture<'_>) -> bool {
    view.kind == Kernel::Trilinear
}
