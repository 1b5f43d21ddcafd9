//! The look-ups of lit runs: what the packed filters give stays words until a block reads it, and places and levels are found once for all
//! textures that are read at the same coordinates.

mod map;
mod slide;

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, i32x16, prelude::*};
use texmap_math::simd::X16;
use texmap_raster::{
    BlockSink, BlockValues, RUN_ROOM, RunBlock, RunValues, TileBlocks, TilePlanes,
};
use texmap_sample::lanes::packed::{self, FootprintLanes};
use texmap_sample::lanes::{Kind, RGBA8, View};
use texmap_sample::sample_columns;

use crate::canvas::{Colors, LANES};
use crate::texel::{RunUv, places};
use crate::textures::Slot;
use crate::tile::ATTRIBUTES;
pub(crate) use map::MapTexels;
pub(crate) use slide::{SlideLookUp, SlideTexels};

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
        let [r, g, b, _] = self.premultiplied(s, i);
        [r, g, b]
    }

    /// The colours of a block with their alpha.
    #[inline(always)]
    fn premultiplied<S: Simd>(&self, s: S, i: usize) -> [f32x16<S>; 4] {
        if self.packed {
            packed::unpack_lanes(s, self.block(s, i))
        } else {
            self.colors.lanes(s, i)
        }
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
    (view.format == RGBA8 && view.kind.is_plain()).then_some(view)
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
            planes.each_block::<_, true, _>(X16(s), blocks, run, [0, 1], &mut sink);
        } else {
            let mut sink = Placed { spots };
            planes.each_block::<_, false, _>(X16(s), blocks, run, [0, 1], &mut sink);
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

impl<S: Simd> BlockSink<X16<S>> for Placed<'_> {
    #[inline(always)]
    fn pixels(&mut self, _: X16<S>, place: usize, _at: RunBlock, values: &BlockValues<X16<S>>) {
        self.spots.uv.put(place / LANES, values.value);
    }
}

struct Leveled<'a> {
    views: &'a [Option<View<'a>>; 2],
    spots: &'a mut Spots,
    /// The level in the first is that in the second.
    same: bool,
}

impl<S: Simd> BlockSink<X16<S>> for Leveled<'_> {
    #[inline(always)]
    fn pixels(
        &mut self,
        X16(s): X16<S>,
        place: usize,
        _at: RunBlock,
        values: &BlockValues<X16<S>>,
    ) {
        let ([ux, vx], [uy, vy]) = (values.ddx, values.ddy);
        self.spots.uv.put(place / LANES, values.value);
        let views = &self.views[..if self.same { 1 } else { 2 }];
        for (view, lods) in views.iter().zip(&mut self.spots.lods) {
            if let Some(view) = view {
                let footprint = FootprintLanes::new(s, view, ux, vx, uy, vy);
                let lod = packed::lod_lanes(s, view, &footprint);
                lod.store_slice(&mut lods[place..place + LANES]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Settings;
    use crate::textures::Chains;
    use texmap_math::camera::Camera;
    use texmap_math::glam::{DMat4, DVec3, DVec4};
    use texmap_math::on_wide_level;
    use texmap_raster::{Draw, NONE, NoAlphaTest, Prepared, RUN, TargetSize};
    use texmap_sample::{
        ColorSpace, Filter, Origin, Precision, Sampler, Texture2d, UvTransform, Wrap,
    };
    use texmap_scene::{ColorMode, Scene, TextureSlot};

    pub(super) fn noise(width: u32, height: u32) -> Texture2d<'static> {
        bordered(width, height, 0)
    }

    /// Within a black border.
    pub(super) fn bordered(width: u32, height: u32, border: u32) -> Texture2d<'static> {
        let mut seed = width * 31 + height;
        let within = |i: u32, n: u32| (border..n - border).contains(&i);
        let texels: Vec<u8> = (0..width * height)
            .flat_map(|i| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let [_, r, g, b] = seed.to_le_bytes();
                match within(i % width, width) && within(i / width, height) {
                    true => [r, g, b, 255],
                    false => [0, 0, 0, 255],
                }
            })
            .collect();
        let texture =
            Texture2d::from_rgba8(width, height, texels, ColorSpace::Linear, Origin::TopLeft);
        texture.unwrap().with_mips()
    }

    fn scene(textures: Vec<Texture2d<'static>>) -> Scene {
        Scene {
            background: [0.0; 4],
            color: ColorMode::Raw,
            depth_test: texmap_raster::DepthTest::Less,
            textures,
            ..Scene::new(Camera {
                eye: DVec3::Z,
                look: DVec3::ZERO,
                up: DVec3::Y,
                fov_x: 1.0,
                near: 0.1,
                far: 10.0,
            })
        }
    }

    pub(super) fn sampler(filter: Filter, wrap: Wrap) -> Sampler {
        Sampler {
            filter,
            wrap_u: wrap,
            precision: Precision::Fast,
            ..Sampler::default()
        }
    }

    pub(super) fn bits<S: Simd>(lanes: [f32x16<S>; 3]) -> [[u32; LANES]; 3] {
        lanes.map(|c| core::array::from_fn(|i| c[i].to_bits()))
    }

    /// Packed words are the texels that [`sample_columns`] gives, for each filter, wrap, origin and pair of sizes, with levels that both
    /// textures share and levels of their own, in perspective and over the edge of two triangles.
    #[test]
    fn packed_words_are_the_texels_of_the_general_look_ups() {
        let level = Level::new();
        let scene = scene(vec![noise(64, 64), noise(64, 64), noise(16, 32)]);
        let corners = [[-1.3, -1.3], [1.3, -1.3], [1.3, 1.3], [-1.3, 1.3]];
        let draw = Draw {
            positions: &corners.map(|[x, y]| [x, y, 0.0]),
            indices: &[[0, 1, 2], [0, 2, 3]],
            // w is 1 + 0.4 y.
            clip_from_object: DMat4::from_cols(
                DVec4::X,
                DVec4::new(0.0, 1.0, 0.0, 0.4),
                DVec4::ZERO,
                DVec4::new(0.0, 0.0, 0.3, 1.0),
            ),
            attributes: &[-0.4, 0.2, 3.3, -0.3, 1.1, 2.7, 0.1, 5.9],
            attribute_count: 2,
            ..Draw::default()
        };
        let size = TargetSize::new(64, 64).unwrap();
        let prepared = Prepared::with_level(size, &[draw], level, 1).unwrap();
        let (mut blocks, mut planes) = (TileBlocks::new(), TilePlanes::new());
        prepared.visible_blocks(0, &NoAlphaTest, &mut blocks);
        prepared.planes(0, &mut planes);
        let all = blocks.masks.iter().enumerate();
        let all = all
            .filter(|(_, mask)| **mask != 0)
            .map(|(i, mask)| RunBlock {
                block: i as u16,
                mask: *mask,
                slot: NONE,
            });
        let list: Vec<RunBlock> = all.collect();
        assert!(list.len() > 150, "{}", list.len());
        let settings = Settings::new(64, 64);
        let chains = Chains::new(&scene, &settings).unwrap();
        let (mut shared, mut compared) = (0, 0);
        for filter in [Filter::Nearest, Filter::Bilinear, Filter::Trilinear] {
            for wrap in [Wrap::Repeat, Wrap::ClampToEdge, Wrap::MirroredRepeat] {
                for (second, origin) in [
                    (1, Origin::TopLeft),
                    (1, Origin::BottomLeft),
                    (2, Origin::TopLeft),
                ] {
                    let slots = [0, second].map(|texture| TextureSlot {
                        texture,
                        sampler: sampler(filter, wrap),
                        transform: UvTransform::default(),
                    });
                    let slots = slots
                        .each_ref()
                        .map(|s| Slot::new(s, &scene, &settings, &chains, origin));
                    let packed = LookUps::new(slots.each_ref().map(Some));
                    let general = LookUps {
                        views: None,
                        ..LookUps::new(slots.each_ref().map(Some))
                    };
                    assert!(packed.views.is_some(), "{filter:?} {wrap:?}");
                    shared += u32::from(packed.same_levels);
                    let mut scratch = LookUpScratch::default();
                    let mut words: [Texels; 2] = Default::default();
                    let mut floats: [Texels; 2] = Default::default();
                    for run in list.chunks(RUN / LANES) {
                        on_wide_level!(level, s => {
                            packed.run(s, level, &planes, &blocks, run, &mut scratch, &mut words);
                            general.run(s, level, &planes, &blocks, run, &mut scratch, &mut floats);
                            for (words, floats) in words.iter().zip(&floats) {
                                assert!(words.packed && !floats.packed);
                                for (i, at) in run.iter().enumerate() {
                                    let (a, b) = (bits(words.lanes(s, i)), bits(floats.lanes(s, i)));
                                    for k in (0..LANES).filter(|k| at.mask >> k & 1 == 1) {
                                        let of = |c: &[[u32; LANES]; 3]| [c[0][k], c[1][k], c[2][k]];
                                        assert_eq!(of(&a), of(&b), "{filter:?} {wrap:?} {i} {k}");
                                        compared += 1;
                                    }
                                }
                            }
                        }, else {
                            // A level without lanes shades sample by sample.
                            return;
                        });
                    }
                }
            }
        }
        assert!(shared > 5 && compared > 100_000, "{shared} {compared}");
    }
}
