//! The look-ups of slides, where they reach.

use texmap_light::SlideView;
use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_math::simd::X16;
use texmap_raster::RUN_ROOM;
use texmap_sample::lanes::View;
use texmap_sample::lanes::packed::{self, FootprintLanes};
use texmap_sample::{Places, sample_columns};

use super::{Spots, Texels, look_up_words, packed_view};
use crate::canvas::{LANES, vector};
use crate::texel::RunUv;

/// The look-ups of a slide.
pub(crate) struct SlideLookUp<'a> {
    slide: &'a SlideView<'a>,
    /// Where the filter gives packed bytes.
    view: Option<View<'a>>,
}

/// Texels of a slide over a run: those blocks that it reaches.
#[derive(Default)]
pub(crate) struct SlideTexels {
    spots: Spots,
    fade: Fade,
    /// Changes of the coordinates, where the filter reads them and gives no packed bytes: of u and v to the right, and down.
    changes: [RunUv; 2],
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
    /// Whether the slide reaches some pixel of a block.
    pub(crate) fn reaches(&self, i: usize) -> bool {
        self.place[i].is_some()
    }

    /// The colours of a block, 0 where the slide does not reach; `None` if it reaches no pixel.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, s: S, i: usize) -> Option<[f32x16<S>; 3]> {
        let i = usize::from(self.place[i]?);
        let share = f32x16::from_slice(s, &self.fade.0[i * LANES..(i + 1) * LANES]);
        let [r, g, b] = self.texels.lanes(s, i);
        Some([r * share, g * share, b * share])
    }

    /// [`lanes`](Self::lanes) with their alpha.
    #[inline(always)]
    pub(crate) fn premultiplied<S: Simd>(&self, s: S, i: usize) -> Option<[f32x16<S>; 4]> {
        let i = usize::from(self.place[i]?);
        let share = f32x16::from_slice(s, &self.fade.0[i * LANES..(i + 1) * LANES]);
        let [r, g, b, a] = self.texels.premultiplied(s, i);
        Some([r * share, g * share, b * share, a * share])
    }
}

impl<'a> SlideLookUp<'a> {
    pub(crate) fn new(slide: &'a SlideView<'a>) -> Self {
        Self {
            slide,
            view: packed_view(&slide.sampler_within(), slide.texture),
        }
    }

    /// Looks a run up at the points of its blocks; `changes` of these to the right and down are there if the filter reads derivatives.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(
        &self,
        s: S,
        level: Level,
        blocks: usize,
        points: [&[f32; RUN_ROOM]; 3],
        changes: Option<[[&[f32; RUN_ROOM]; 3]; 2]>,
        out: &mut SlideTexels,
    ) {
        let mut reached = 0;
        for i in 0..blocks {
            let places = self.slide.place(X16(s), vector(s, points, i));
            out.place[i] = None;
            if places.reached.any_true() {
                out.place[i] = Some(reached as u8);
                out.spots.uv.put(reached, places.uv);
                let share = places.reached.select(places.fade, f32x16::splat(s, 0.0));
                let at = reached * LANES..(reached + 1) * LANES;
                share.store_slice(&mut out.fade.0[at.clone()]);
                if let Some([dx, dy]) = changes {
                    let [ux, vx] = self.slide.changes(X16(s), &places, vector(s, dx, i));
                    let [uy, vy] = self.slide.changes(X16(s), &places, vector(s, dy, i));
                    if let Some(view) = &self.view {
                        let footprint = FootprintLanes::new(s, view, ux, vx, uy, vy);
                        let lod = packed::lod_lanes(s, view, &footprint);
                        lod.store_slice(&mut out.spots.lods[0][at]);
                    } else {
                        out.changes[0].put(reached, [ux, vx]);
                        out.changes[1].put(reached, [uy, vy]);
                    }
                }
                reached += 1;
            }
        }
        if reached == 0 {
            return;
        }
        let SlideTexels {
            spots,
            texels,
            changes: stored,
            ..
        } = out;
        if let Some(view) = &self.view {
            return look_up_words(s, view, spots, &spots.lods[0], reached, texels);
        }
        texels.packed = false;
        let count = reached * LANES;
        let at = Places {
            u: &spots.uv.u[..count],
            v: &spots.uv.v[..count],
            gradients: changes.is_some().then(|| {
                let [x, y] = &*stored;
                [&x.u[..count], &x.v[..count], &y.u[..count], &y.v[..count]]
            }),
        };
        let columns = texels.colors.0.each_mut().map(|c| &mut c[..count]);
        sample_columns(level, &self.slide.sampler, self.slide.texture, &at, columns)
            .expect("the columns have one length");
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bits, bordered, noise, sampler};
    use super::*;
    use texmap_light::{Slide, SlideBorder};
    use texmap_math::Projector;
    use texmap_math::glam::DVec3;
    use texmap_math::on_wide_level;
    use texmap_raster::RUN;
    use texmap_sample::{Filter, Wrap};

    /// A slide's packed words are its texels, and blocks that it does not reach have none.
    #[test]
    fn packed_words_of_slides_are_their_texels() {
        let level = Level::new();
        let textures = [noise(32, 32), bordered(32, 32, 1)];
        let projector = Projector::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.2, 1.0).unwrap();
        let points: [[f32; RUN_ROOM]; 3] = [
            core::array::from_fn(|i| (i % 37) as f32 * 0.09 - 0.6),
            core::array::from_fn(|i| (i % 23) as f32 * 0.13 - 1.4),
            // The first lie behind the projector.
            core::array::from_fn(|i| {
                if i < 32 {
                    2.0
                } else {
                    -1.0 - (i % 5) as f32 * 0.3
                }
            }),
        ];
        // The last reaches no further than its picture, which is then read as if it were repeated.
        let borders = [
            (0, SlideBorder::Black, 0.2),
            (0, SlideBorder::Clamp, 0.0),
            (1, SlideBorder::Clamp, 0.0),
        ];
        // Steps of a fraction of a texel up to several.
        let steps: [[f32; RUN_ROOM]; 3] =
            [0.003, -0.001, 0.004].map(|k| core::array::from_fn(|i| k * (1 + i % 29) as f32));
        for filter in [Filter::Nearest, Filter::Bilinear, Filter::Trilinear] {
            for (texture, border, softness) in borders {
                let texture = &textures[texture];
                let sampler = sampler(filter, Wrap::Repeat);
                let slide = SlideView::new(&Slide {
                    projector,
                    texture,
                    sampler: &sampler,
                    border,
                    softness,
                });
                let packed = SlideLookUp::new(&slide);
                let general = SlideLookUp {
                    slide: &slide,
                    view: None,
                };
                let (mut words, mut floats) = (SlideTexels::default(), SlideTexels::default());
                let mut reached = 0;
                on_wide_level!(level, s => {
                    assert!(packed.view.is_some());
                    let (count, points) = (RUN / LANES, points.each_ref());
                    let [x, y, z] = steps.each_ref();
                    let changes = filter.reads_derivatives().then_some([[x, y, z], [z, x, y]]);
                    packed.run(s, level, count, points, changes, &mut words);
                    general.run(s, level, count, points, changes, &mut floats);
                    for i in 0..count {
                        let (a, b) = (words.lanes(s, i).map(bits), floats.lanes(s, i).map(bits));
                        assert_eq!(a, b, "{filter:?} {border:?} {i}");
                        reached += usize::from(a.is_some());
                    }
                    // The first two lie behind the projector.
                    assert!(reached > 4 && reached < count - 1, "{reached}");
                }, else { return; });
            }
        }
    }
}
