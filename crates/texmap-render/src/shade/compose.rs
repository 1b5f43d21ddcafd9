//! The colors of a part: base color under its light, emission, decals that cover their surface.

use texmap_light::lanes::{TermsLanes, Vector, splat};
use texmap_math::color::luminance;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use super::batch::{Batch, LANES, Part, columns, load_vector, set_bits, straight};
use super::facing::Side;
use super::lighting::LightStage;
use super::normal::Vectors;
use super::surface::{SurfaceShader, SurfaceTexels};
use crate::textures::Slot;
use texmap_scene::AlphaMode;

/// What the kernel of a surface reads.
pub(super) struct Inputs<'a> {
    pub(super) shader: &'a SurfaceShader<'a>,
    pub(super) batch: &'a Batch<'a>,
    pub(super) vectors: Vectors<'a>,
    pub(super) read: &'a SurfaceTexels,
}

impl Inputs<'_> {
    /// The colors of a part of a surface that is opaque and lit per pixel, by texels of the pair.
    #[inline(always)]
    pub(super) fn short<I: Isa>(&self, i: I, part: &Part, side: &Side) -> [I::F32; 4] {
        let terms = self.terms::<I, false>(i, part, side);
        let base = self.shader.base.of_pair(i, &self.read.pair[0], part.at);
        let [r, g, b] = lit(i, base, &terms);
        [r, g, b, i.f32(1.0)]
    }

    /// The colors of a part of any surface. Out of line, so that the short form stays short.
    #[inline(never)]
    pub(super) fn any<I: Isa>(&self, i: I, part: &Part, side: &Side) -> [I::F32; 4] {
        i.vectorize(
            #[inline(always)]
            || self.any_inline(i, part, side),
        )
    }

    #[inline(always)]
    fn any_inline<I: Isa>(&self, i: I, part: &Part, side: &Side) -> [I::F32; 4] {
        let (base, values) = (&self.shader.base, self.batch.values);
        if self.shader.covers {
            return self.covered(i, part, side);
        }
        let (color, alpha) = if base.paired {
            (base.of_pair(i, &self.read.pair[0], part.at), i.f32(1.0))
        } else {
            base.load(i, &self.read.base, values, part.at)
        };
        let [r, g, b] = self.under_light(i, part, side, color);
        [r * alpha, g * alpha, b * alpha, alpha]
    }

    /// A decal that covers its surface, which shows where an opaque decal is transparent.
    #[inline(always)]
    fn covered<I: Isa>(&self, i: I, part: &Part, side: &Side) -> [I::F32; 4] {
        let (base, read, one) = (&self.shader.base, &self.read.base, i.f32(1.0));
        let texel = base.texel(i, read, part.at);
        let texel = base.under_decal(i, read, part.at, texel);
        let [mut r, mut g, mut b, mut alpha] = texel;
        match base.alpha {
            AlphaMode::Opaque => {
                let clear = alpha.simd_lt(1.0);
                if clear.any_true() {
                    let color = base.material_color(i, self.batch.values, part.at);
                    let under = self.under_light(i, part, side, color);
                    let keep = one - alpha;
                    r = clear.select(r + keep * under[0], r);
                    g = clear.select(g + keep * under[1], g);
                    b = clear.select(b + keep * under[2], b);
                }
                return [r.below(one), g.below(one), b.below(one), one];
            }
            AlphaMode::Test(_) => alpha = one,
            AlphaMode::Blend => alpha = alpha * base.opacity(i, read, part.at),
        }
        let [r, g, b] = straight(i, texel);
        let (r, g, b) = (r.below(one), g.below(one), b.below(one));
        [r * alpha, g * alpha, b * alpha, alpha]
    }

    /// Base colors under the light of the surface and its own, clipped at 1.
    #[inline(always)]
    fn under_light<I: Isa>(&self, i: I, part: &Part, side: &Side, base: Vector<I>) -> Vector<I> {
        let (shader, values) = (self.shader, self.batch.values);
        let emitted = self.emitted(i, part.at);
        let mut terms = match shader.light {
            LightStage::PerPixel => self.terms::<I, true>(i, part, side),
            LightStage::Terms { diffuse, highlight } => TermsLanes {
                diffuse: load_vector(i, columns(values, diffuse), part.at),
                highlight: match highlight {
                    Some(first) => load_vector(i, columns(values, first), part.at),
                    None => [i.f32(0.0); 3],
                },
            },
            LightStage::Colors(first) => {
                let color = load_vector(i, columns(values, first), part.at);
                // Without emission they are clipped at the vertices.
                return match emitted {
                    Some(emitted) => clipped(i, add(color, emitted)),
                    None => color,
                };
            }
            LightStage::None => {
                return match emitted {
                    Some(emitted) => clipped(i, add(base, emitted)),
                    None => clipped(i, base),
                };
            }
        };
        if let Some(ramp) = shader.light_ramp {
            terms.diffuse = along_ramp(i, ramp, part, terms.diffuse);
        }
        if let Some(emitted) = emitted {
            terms.highlight = add(terms.highlight, emitted);
        }
        let (lighting, read) = (&shader.lighting, &self.read.light);
        let base = lighting.painted(i, part, &self.vectors, side, read, base);
        lit(i, base, &terms)
    }

    #[inline(always)]
    fn terms<I: Isa, const ALL: bool>(&self, i: I, part: &Part, side: &Side) -> TermsLanes<I> {
        let (shader, read) = (self.shader, self.read);
        shader.lighting.terms::<I, ALL>(
            i,
            (self.batch, part),
            &self.vectors,
            side,
            (&shader.normal, &shader.reflections),
            (&read.pair[1], &read.normal, &read.light),
        )
    }

    /// The light that a part emits.
    #[inline(always)]
    fn emitted<I: Isa>(&self, i: I, at: usize) -> Option<Vector<I>> {
        let (color, map) = self.shader.emission?;
        let color = splat(i, color);
        if map.is_none() {
            return Some(color);
        }
        let [r, g, b] = self.read.emission.straight(i, at);
        Some([r * color[0], g * color[1], b * color[2]])
    }
}

/// `base * diffuse + highlight`, clipped at 1.
#[inline(always)]
fn lit<I: Isa>(i: I, base: Vector<I>, terms: &TermsLanes<I>) -> Vector<I> {
    let mut out = base;
    for k in 0..3 {
        out[k] = base[k] * terms.diffuse[k] + terms.highlight[k];
    }
    clipped(i, out)
}

#[inline(always)]
fn clipped<I: Isa>(i: I, [r, g, b]: Vector<I>) -> Vector<I> {
    let one = i.f32(1.0);
    [r.below(one), g.below(one), b.below(one)]
}

#[inline(always)]
fn add<F: Number<f32>>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Light along a ramp by its luminance, pixel by pixel.
#[inline(never)]
fn along_ramp<I: Isa>(i: I, ramp: &Slot<'_>, part: &Part, light: Vector<I>) -> Vector<I> {
    let mut lanes = [[0.0; LANES]; 3];
    for (lanes, light) in lanes.iter_mut().zip(light) {
        light.store(lanes);
    }
    for bit in set_bits(part.block.mask >> part.pixel).take_while(|bit| *bit < I::LANES) {
        let along = ramp.along(luminance(lanes.map(|c| c[bit])));
        for (lanes, c) in lanes.iter_mut().zip(straight(Scalar, along)) {
            lanes[bit] = c;
        }
    }
    let [r, g, b] = &lanes;
    [i.load_f32(r), i.load_f32(g), i.load_f32(b)]
}
