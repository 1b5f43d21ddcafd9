//! Light per pixel: the sum over lights of their contribution times their visibility.

use texmap_light::lanes::{SpecularExponentLanes, TermsLanes, Vector, evaluate_light};
use texmap_light::{Light, PhongMaterial, ShadowSampler, SpecularExponent, SpecularModel};
use texmap_math::simd::{Isa, prelude::*};

use crate::Slot;
use crate::batch::{Part, columns, load_vector, parts};
use crate::projector::Projected;
use crate::stage::{Inputs, Kernel, ShadeColumns};

/// The source of the light of a surface; numbers are attribute indices.
#[derive(Clone, Copy)]
pub enum LightStage {
    /// The base color is the color.
    None,
    /// Finished colors at the vertices: the base color is in them.
    Colors(usize),
    /// Terms at the vertices (vertex colors in the diffuse one), a texel between them.
    Terms {
        /// First of three attributes: light that multiplies the base color.
        diffuse: usize,
        /// First of three attributes: light in its own color.
        highlight: Option<usize>,
    },
    /// Computed per pixel.
    PerPixel,
}

/// Light by Phong's terms.
pub struct PhongLights<'a> {
    /// Numbers of the material.
    pub numbers: PhongMaterial,
    /// Exponent of the highlight.
    pub power: SpecularExponent,
    /// A texture that multiplies the exponent.
    pub exponents: Option<&'a Slot<'a>>,
    /// Phong or Blinn-Phong highlights.
    pub model: SpecularModel,
    /// The lights in the order of the scene.
    pub lights: Vec<LitBy<'a>>,
}

/// A light, its shadow maps and its projected texture.
#[derive(Clone, Copy)]
pub struct LitBy<'a> {
    /// The light.
    pub light: Light,
    /// Its shadow maps; empty without shadows.
    pub shadows: &'a [ShadowSampler],
    /// The projected texture, and its index among the projectors of the surface.
    pub projector: Option<(&'a Projected<'a>, usize)>,
}

impl LitBy<'_> {
    /// True if the light is the same for all normals.
    pub fn is_ambient(&self) -> bool {
        matches!(self.light, Light::Ambient { .. })
    }

    /// Every shadow map that its light passes.
    pub fn shadow_maps(&self) -> impl Iterator<Item = &ShadowSampler> {
        let of_projector = self.projector.as_ref();
        let of_projector = of_projector.and_then(|(projected, _)| projected.shadow.as_ref());
        self.shadows.iter().chain(of_projector)
    }

    /// The texels that the light projects on a part, if it projects some; `None` if its projector does not reach the part.
    #[inline(always)]
    pub(crate) fn texel<I: Isa>(
        &self,
        i: I,
        inputs: &Inputs<'_>,
        part: &Part,
    ) -> Option<Option<[I::F32; 4]>> {
        match self.projector {
            None => Some(None),
            Some((_, k)) => match inputs.projectors[k].load(i, part.index, part.pixel) {
                None => None,
                some => Some(some),
            },
        }
    }

    /// Visibility of the light in the lanes of `lit`, times the projected texels.
    #[inline(always)]
    pub(crate) fn received<I: Isa>(
        &self,
        i: I,
        (inputs, at): (&Inputs<'_>, usize),
        texel: Option<[I::F32; 4]>,
        lit: I::Mask,
        point: Vector<I>,
    ) -> Vector<I> {
        let plane = &inputs.sides.plane;
        let mut share = i.f32(1.0);
        for shadow in self.shadows {
            share = share * visibility(i, shadow, lit, point, plane.load(i, at));
        }
        let (Some([r, g, b, _]), Some((projected, _))) = (texel, &self.projector) else {
            return [share; 3];
        };
        if let Some(shadow) = &projected.shadow {
            let some = r.simd_gt(0.0) | g.simd_gt(0.0) | b.simd_gt(0.0);
            let left = share * visibility(i, shadow, lit & some, point, plane.load(i, at));
            share = some.select(left, share);
        }
        [r * share, g * share, b * share]
    }
}

/// Visibility of a light by a shadow map in the lanes of `lit`. Out of line: look-ups are as much code as the rest of a stage.
#[inline(never)]
pub(crate) fn visibility<I: Isa>(
    i: I,
    shadow: &ShadowSampler,
    lit: I::Mask,
    point: Vector<I>,
    plane: Vector<I>,
) -> I::F32 {
    i.vectorize(
        #[inline(always)]
        || shadow.visibility_lanes(i, lit, point, plane),
    )
}

impl Kernel for PhongLights<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        if let Some(slot) = self.exponents {
            columns.fetch(inputs, slot);
        }
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let at = part.at;
            let pixels = part.mask(i, part.block.mask);
            let point = match inputs.vectors.position {
                Some(position) => load_vector(i, position, at),
                None => [i.f32(0.0); 3],
            };
            let (normal, toward_eye) = (columns.normal.load(i, at), columns.toward_eye.load(i, at));
            let power = match self.exponents {
                None => SpecularExponentLanes::Same(self.power),
                Some(_) => {
                    let [factor, ..] = columns.texels.straight(i, at);
                    SpecularExponentLanes::Each(factor * self.numbers.ns)
                }
            };
            let mut sum = TermsLanes::dark(i);
            for by in &self.lights {
                let Some(texel) = by.texel(i, inputs, &part) else {
                    continue;
                };
                let given = evaluate_light(
                    i,
                    &self.numbers,
                    power,
                    self.model,
                    &by.light,
                    point,
                    normal,
                    toward_eye,
                );
                let lit = given.lit & pixels;
                if lit.any_true() {
                    sum.add(&given, lit, by.received(i, (inputs, at), texel, lit, point));
                }
            }
            columns.diffuse.store(i, at, sum.diffuse);
            columns.highlight.store(i, at, sum.highlight);
        }
    }
}

/// Terms that were computed at the vertices; numbers are first attributes.
pub struct VertexTerms {
    /// First of three attributes: light that multiplies the base color.
    pub diffuse: usize,
    /// First of three attributes: light in its own color.
    pub highlight: Option<usize>,
}

impl Kernel for VertexTerms {
    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, out: &mut ShadeColumns) {
        let values = inputs.batch.values;
        for part in parts(i, inputs.batch.list) {
            let diffuse = load_vector(i, columns(values, self.diffuse), part.at);
            out.diffuse.store(i, part.at, diffuse);
            let highlight = match self.highlight {
                Some(first) => load_vector(i, columns(values, first), part.at),
                None => [i.f32(0.0); 3],
            };
            out.highlight.store(i, part.at, highlight);
        }
    }
}
