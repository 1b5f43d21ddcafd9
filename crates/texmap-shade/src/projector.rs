//! Texture fetches of projectors, both lights and paint, for the blocks that they reach.

use texmap_light::lanes::Vector;
use texmap_light::{BoundProjectorTexture, ShadowSampler};
use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{BATCH_STRIDE, Varying};
use texmap_sample::lanes::BoundTexture;
use texmap_sample::{Places, sample_soa};

use crate::batch::{Columns, LANES, load_changes, load_vector};
use crate::fetch::PackedTexels;
use crate::texels::{TexelAddresses, packed_view, read_placed};

/// A projected texture, and the shadow map of its projector.
#[derive(Debug)]
pub struct Projected<'s> {
    /// Matrix and texture.
    pub view: BoundProjectorTexture<'s>,
    /// Position of the projector.
    pub position: [f32; 3],
    /// Depths seen from the projector, where it does not shine through.
    pub shadow: Option<ShadowSampler>,
}

impl Projected<'_> {
    /// True if the filter reads derivatives.
    pub(crate) fn reads_derivatives(&self) -> bool {
        self.view.sampler.filter.reads_derivatives()
    }
}

/// The texture fetch of a projector.
pub struct ProjectorStage<'a> {
    pub(crate) projected: &'a Projected<'a>,
    /// The picture, bound, if its filter gives packed bytes.
    view: Option<BoundTexture<'a>>,
}

/// Texels of a projector over a batch: those blocks that it reaches.
#[derive(Default)]
pub struct ProjectorTexels {
    addresses: TexelAddresses,
    /// Changes of the coordinates, where the filter reads them: to the right, and down.
    changes: [Columns<2>; 2],
    fade: Columns<1>,
    texels: PackedTexels,
    /// The index of each block of the batch among those that are reached; `None` for the others.
    place: [Option<u8>; BATCH_STRIDE / LANES],
}

impl ProjectorTexels {
    /// True if the projector reaches some pixel of a block.
    pub fn reaches(&self, block: usize) -> bool {
        self.place[block].is_some()
    }

    /// The premultiplied texels of a block from `pixel` on, 0 where the projector does not reach; `None` if it reaches no pixel.
    #[inline(always)]
    pub fn load<I: Isa>(&self, i: I, block: usize, pixel: usize) -> Option<[I::F32; 4]> {
        let at = usize::from(self.place[block]?) * LANES + pixel;
        let [fade] = self.fade.load(i, at);
        let [r, g, b, a] = self.texels.load(i, at);
        Some([r * fade, g * fade, b * fade, a * fade])
    }
}

impl<'a> ProjectorStage<'a> {
    /// A stage that reads the texture of a projector.
    pub fn new(projected: &'a Projected<'a>) -> Self {
        let view = &projected.view;
        Self {
            projected,
            view: packed_view(&view.sampler_within(), view.texture),
        }
    }

    /// The same stage, read by [`sample_soa`] whatever the filter is: it gives the same bits in more time.
    pub fn unpacked(self) -> Self {
        Self { view: None, ..self }
    }

    /// Reads the texels of `blocks` blocks at positions, whose changes are there if the filter reads derivatives.
    pub fn fetch(
        &self,
        level: Level,
        position: &[Varying; 3],
        blocks: usize,
        out: &mut ProjectorTexels,
    ) {
        let leveled = self.projected.reads_derivatives();
        let reached = dispatch_simd!(level, i => self.place(i, position, blocks, leveled, out));
        if reached == 0 {
            return;
        }
        let ProjectorTexels {
            addresses,
            changes,
            texels,
            ..
        } = out;
        if let Some(view) = &self.view {
            texels.packed = true;
            return read_placed(level, view, addresses, changes, reached, &mut texels.words);
        }
        texels.packed = false;
        let count = reached * LANES;
        let [u, v] = addresses.uv.columns(count);
        let gradients = leveled.then(|| {
            let [[ux, vx], [uy, vy]] = changes.each_ref().map(|axis| axis.columns(count));
            [ux, vx, uy, vy]
        });
        let at = Places { u, v, gradients };
        let (view, columns) = (&self.projected.view, texels.colors.columns_mut(count));
        sample_soa(level, &view.sampler, view.texture, &at, columns)
            .expect("the columns have one length");
    }

    /// The coordinates of the blocks that are reached, and their number.
    #[inline(always)]
    fn place<I: Isa>(
        &self,
        i: I,
        position: &[Varying; 3],
        blocks: usize,
        leveled: bool,
        out: &mut ProjectorTexels,
    ) -> usize {
        let view = &self.projected.view;
        let mut count = 0;
        for block in 0..blocks {
            let mut reached = false;
            for pixel in (0..LANES).step_by(I::LANES) {
                let (from, to) = (block * LANES + pixel, count * LANES + pixel);
                let places = view.uv_at(i, load_vector(i, position, from));
                let fade = places.reached.select(places.fade, i.f32(0.0));
                out.fade.store(i, to, [fade]);
                if !places.reached.any_true() {
                    continue;
                }
                reached = true;
                out.addresses.uv.store(i, to, places.uv);
                if leveled {
                    let [dx, dy]: [Vector<I>; 2] = load_changes(i, position, from);
                    let [right, down] = &mut out.changes;
                    right.store(i, to, view.changes(i, &places, dx));
                    down.store(i, to, view.changes(i, &places, dy));
                }
            }
            out.place[block] = reached.then_some(count as u8);
            count += usize::from(reached);
        }
        count
    }
}
