//! The look-ups of lit runs: what the packed filters give stays words until a block reads it, and places and levels are found once for all
//! textures that are read at the same coordinates.

use texmap_light::SlideView;
use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, i32x16, prelude::*};
use texmap_raster::{
    BlockSink, BlockValues, RUN_ROOM, RunBlock, RunValues, TileBlocks, TilePlanes,
};
use texmap_sample::lanes::packed::{self, FootprintLanes};
use texmap_sample::lanes::{Kind, RGBA8, View};
use texmap_sample::{Places, sample_columns};

use crate::canvas::{Colors, LANES};
use crate::texel::{RunUv, places};
use crate::textures::Slot;
use crate::tile::ATTRIBUTES;

/// Texels of a run: packed bytes, or channel by channel.
pub(crate) struct Texels {
    words: [u32; RUN_ROOM],
    colors: Colors,
    packed: bool,
}

impl Default for Texels {
    fn default() -> Self {
        Self {
            words: [0; RUN_ROOM],
            colors: Colors::new(),
            packed: false,
        }
    }
}

impl Texels {
    /// The colours of a block.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, s: S, i: usize) -> [f32x16<S>; 3] {
        let [r, g, b, _] = if self.packed {
            packed::unpack_lanes(s, self.block(s, i))
        } else {
            self.colors.lanes(s, i)
        };
        [r, g, b]
    }

    #[inline(always)]
    fn block<S: Simd>(&self, s: S, i: usize) -> texmap_math::fearless_simd::u32x16<S> {
        SimdBase::from_slice(s, &self.words[i * LANES..(i + 1) * LANES])
    }
}

/// Where a run is looked up.
pub(crate) struct Spots {
    uv: RunUv,
    /// Levels of detail in each texture.
    lods: [[i32; RUN_ROOM]; 2],
}

impl Default for Spots {
    fn default() -> Self {
        Self {
            uv: RunUv::default(),
            lods: [[0; RUN_ROOM]; 2],
        }
    }
}

/// A packed texture's texels at places, and at levels of detail if its filter asks for them.
#[inline(always)]
fn look_up_words<S: Simd>(
    s: S,
    view: &View<'_>,
    spots: &Spots,
    lods: &[i32; RUN_ROOM],
    blocks: usize,
    out: &mut Texels,
) {
    out.packed = true;
    for i in 0..blocks {
        let at = i * LANES..(i + 1) * LANES;
        let [u, v] = spots.uv.at(s, i);
        let word = match view.kind {
            Kind::Nearest => packed::nearest_lanes(s, view, u, v),
            Kind::Bilinear => packed::bilinear_lanes(s, view, u, v),
            _ => {
                let lod = i32x16::from_slice(s, &lods[at.clone()]);
                packed::trilinear_lanes(s, view, u, v, lod)
            }
        };
        word.store_slice(&mut out.words[at]);
    }
}

/// A texture whose filter gives bytes, from a level of detail or without.
fn packed_view<'a>(
    sampler: &texmap_sample::Sampler,
    texture: &'a texmap_sample::Texture2d<'_>,
) -> Option<View<'a>> {
    let view = View::new(sampler, texture)?;
    (view.format == RGBA8 && view.kind != Kind::Anisotropic).then_some(view)
}

/// The look-ups of a surface at the coordinates of its mesh: base colour, normal map.
pub(crate) struct LookUps<'a> {
    slots: [Option<&'a Slot<'a>>; 2],
    /// All of them, if all are packed.
    views: Option<[Option<View<'a>>; 2]>,
    /// Levels in both are the same.
    same_levels: bool,
    /// Some filter asks how large a pixel is.
    derivatives: bool,
}

impl<'a> LookUps<'a> {
    pub(crate) fn new(slots: [Option<&'a Slot<'a>>; 2]) -> Self {
        let views = slots.map(|slot| slot.map(|slot| packed_view(&slot.sampler, &slot.texture)));
        // A slot without a view spoils it.
        let views = match views {
            [Some(None), _] | [_, Some(None)] => None,
            [base, bumps] => Some([base.flatten(), bumps.flatten()]),
        };
        let same_levels = match (slots, &views) {
            ([Some(base), Some(bumps)], Some([Some(a), Some(b)])) => {
                a.kind == b.kind && a.size() == b.size() && base.sampler.lod == bumps.sampler.lod
            }
            _ => false,
        };
        let derivatives = slots.into_iter().flatten().any(Slot::reads_derivatives);
        Self {
            slots,
            views,
            same_levels,
            derivatives,
        }
    }

    /// The texels of a run.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(
        &self,
        s: S,
        level: Level,
        planes: &TilePlanes,
        blocks: &TileBlocks,
        run: &[RunBlock],
        scratch: &mut LookUpScratch,
        out: &mut [Texels; 2],
    ) {
        if self.slots.iter().all(Option::is_none) {
            return;
        }
        let LookUpScratch { values, spots } = scratch;
        let Some(views) = &self.views else {
            planes.values(
                level,
                blocks,
                run,
                &ATTRIBUTES[..2],
                self.derivatives,
                values,
            );
            let count = run.len() * LANES;
            for (slot, out) in self.slots.iter().zip(out) {
                if let Some(slot) = slot {
                    out.packed = false;
                    let columns = out.colors.0.each_mut().map(|c| &mut c[..count]);
                    let at = places(slot, values, count);
                    sample_columns(level, &slot.sampler, &slot.texture, &at, columns)
                        .expect("the columns have one length");
                }
            }
            return;
        };
        if self.derivatives {
            let mut sink = Leveled {
                views,
                spots,
                same: self.same_levels,
            };
            planes.each_block::<_, 2, true, _>(s, blocks, run, [0, 1], &mut sink);
        } else {
            let mut sink = Placed { spots };
            planes.each_block::<_, 2, false, _>(s, blocks, run, [0, 1], &mut sink);
        }
        for (k, (view, out)) in views.iter().zip(out).enumerate() {
            if let Some(view) = view {
                let lods = &spots.lods[if self.same_levels { 0 } else { k }];
                look_up_words(s, view, spots, lods, run.len(), out);
            }
        }
    }
}

/// Columns of a run's look-ups.
#[derive(Default)]
pub(crate) struct LookUpScratch {
    values: RunValues,
    spots: Spots,
}

struct Placed<'a> {
    spots: &'a mut Spots,
}

impl<S: Simd> BlockSink<S, 2> for Placed<'_> {
    #[inline(always)]
    fn block(&mut self, _s: S, i: usize, _at: RunBlock, values: &BlockValues<S, 2>) {
        self.spots.uv.put(i, values.value);
    }
}

struct Leveled<'a> {
    views: &'a [Option<View<'a>>; 2],
    spots: &'a mut Spots,
    /// The level in the first is that in the second.
    same: bool,
}

impl<S: Simd> BlockSink<S, 2> for Leveled<'_> {
    #[inline(always)]
    fn block(&mut self, s: S, i: usize, _at: RunBlock, values: &BlockValues<S, 2>) {
        let ([ux, vx], [uy, vy]) = (values.ddx, values.ddy);
        self.spots.uv.put(i, values.value);
        let views = &self.views[..if self.same { 1 } else { 2 }];
        for (view, lods) in views.iter().zip(&mut self.spots.lods) {
            if let Some(view) = view {
                let footprint = FootprintLanes::new(s, view, ux, vx, uy, vy);
                let lod = packed::lod_lanes(s, view, &footprint);
                lod.store_slice(&mut lods[i * LANES..(i + 1) * LANES]);
            }
        }
    }
}

/// The look-ups of a slide.
pub(crate) struct SlideLookUp<'a> {
    slide: &'a SlideView<'a>,
    view: Option<View<'a>>,
}

/// Texels of a slide over a run: those blocks that it reaches.
#[derive(Default)]
pub(crate) struct SlideTexels {
    spots: Spots,
    fade: Fade,
    texels: Texels,
    /// Where each block of the run stands among those; `None` for blocks that it does not reach.
    place: [Option<u8>; RUN_ROOM / LANES],
}

struct Fade([f32; RUN_ROOM]);

impl Default for Fade {
    fn default() -> Self {
        Self([0.0; RUN_ROOM])
    }
}

impl SlideTexels {
    /// The colours of a block, 0 where the slide does not reach; `None` if it reaches no pixel.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, s: S, i: usize) -> Option<[f32x16<S>; 3]> {
        let i = usize::from(self.place[i]?);
        let share = f32x16::from_slice(s, &self.fade.0[i * LANES..(i + 1) * LANES]);
        let [r, g, b] = self.texels.lanes(s, i);
        Some([r * share, g * share, b * share])
    }
}

impl<'a> SlideLookUp<'a> {
    pub(crate) fn new(slide: &'a SlideView<'a>) -> Self {
        Self {
            slide,
            view: packed_view(&slide.sampler, slide.texture),
        }
    }

    /// Looks a run up at the points of its blocks.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(
        &self,
        s: S,
        level: Level,
        blocks: usize,
        points: [&[f32; RUN_ROOM]; 3],
        out: &mut SlideTexels,
    ) {
        let mut reached = 0;
        for i in 0..blocks {
            let at = i * LANES..(i + 1) * LANES;
            let point = [
                f32x16::from_slice(s, &points[0][at.clone()]),
                f32x16::from_slice(s, &points[1][at.clone()]),
                f32x16::from_slice(s, &points[2][at]),
            ];
            let places = self.slide.place_lanes(s, point);
            out.place[i] = None;
            if places.reached.any_true() {
                out.place[i] = Some(reached as u8);
                out.spots.uv.put(reached, places.uv);
                let share = places.reached.select(places.fade, f32x16::splat(s, 0.0));
                share.store_slice(&mut out.fade.0[reached * LANES..(reached + 1) * LANES]);
                reached += 1;
            }
        }
        if reached == 0 {
            return;
        }
        let SlideTexels { spots, texels, .. } = out;
        if let Some(view) = &self.view {
            return look_up_words(s, view, spots, &spots.lods[0], reached, texels);
        }
        texels.packed = false;
        let count = reached * LANES;
        let at = Places {
            u: &spots.uv.u[..count],
            v: &spots.uv.v[..count],
            gradients: None,
        };
        let columns = texels.colors.0.each_mut().map(|c| &mut c[..count]);
        sample_columns(level, &self.slide.sampler, self.slide.texture, &at, columns)
            .expect("the columns have one length");
    }
}
