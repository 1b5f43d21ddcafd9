//! Lighting per pixel: the sum over lights of their contribution times their visibility, light maps, and maps of the material's numbers.

use texmap_light::lanes::{
    SpecularExponentLanes, TermsLanes, Vector, dot, evaluate_light, splat, unit,
};
use texmap_light::{Light, PhongMaterial, ShadowSampler, SpecularExponent, SpecularModel};
use texmap_math::simd::{Isa, prelude::*};

use super::batch::{Batch, Part, flip, load_vector};
use super::environment::Reflections;
use super::facing::Side;
use super::fetch::{PackedTexels, Texels};
use super::normal::{NormalStage, NormalTexels, Vectors};
use super::projector::{ProjectorStage, ProjectorTexels};
use crate::textures::Slot;

/// The source of the light of a surface; numbers are attribute indices.
#[derive(Clone, Copy)]
pub(crate) enum LightStage {
    /// The base color is the color.
    None,
    /// Finished colors at the vertices: the base color is in them.
    Colors(usize),
    /// Terms at the vertices (vertex colors in the diffuse one), a texel between them.
    Terms {
        diffuse: usize,
        highlight: Option<usize>,
    },
    /// Computed per pixel.
    PerPixel,
}

/// The lighting stage of a surface that is lit per pixel.
pub(crate) struct Lighting<'a> {
    pub(crate) numbers: PhongMaterial,
    pub(crate) power: SpecularExponent,
    pub(crate) model: SpecularModel,
    pub(crate) lights: Vec<LitBy<'a>>,
    /// Baked light: the factor of its texels, its map, and the first attribute of the coordinates.
    pub(crate) light_map: Option<(f32, &'a Slot<'a>, usize)>,
    /// Projectors that paint, the later over the earlier.
    pub(crate) paints: Vec<ProjectorStage<'a>>,
    /// Textures in place of numbers: ambient color, specular color, exponent, reflectivity.
    pub(crate) maps: [Option<&'a Slot<'a>>; MAPS],
    pub(crate) eye: [f32; 3],
    /// Highlights or the horizon of a normal detail ask for the direction to the eye.
    pub(crate) sees_eye: bool,
    /// Every block asks for the normal: a light other than the projectors' reaches it, or something is mirrored.
    pub(crate) needs_normal: bool,
}

/// A light, its shadow maps and its projected texture.
pub(crate) struct LitBy<'a> {
    pub(crate) light: Light,
    pub(crate) shadows: &'a [ShadowSampler],
    pub(crate) projector: Option<ProjectorStage<'a>>,
}

const AMBIENT: usize = 0;
const SPECULAR: usize = 1;
const EXPONENT: usize = 2;
const REFLECTIVITY: usize = 3;
pub(crate) const MAPS: usize = 4;

/// Texels that lighting reads.
#[derive(Default)]
pub(crate) struct LightTexels {
    /// Projectors of the lights, then those that paint.
    pub(crate) projectors: Vec<ProjectorTexels>,
    pub(crate) light_map: Texels,
    pub(crate) maps: [Texels; MAPS],
}

impl LitBy<'_> {
    /// True if it shines on all normals alike.
    pub(crate) fn is_ambient(&self) -> bool {
        matches!(self.light, Light::Ambient { .. })
    }

    /// Every shadow map that its light passes.
    pub(crate) fn shadow_maps(&self) -> impl Iterator<Item = &ShadowSampler> {
        let of_projector = self.projector.as_ref();
        let of_projector = of_projector.and_then(|stage| stage.projected.shadow.as_ref());
        self.shadows.iter().chain(of_projector)
    }

    /// The share of the light that reaches the lanes of `lit`, times the projected texels.
    #[inline(always)]
    fn visibility<I: Isa>(
        &self,
        i: I,
        texel: Option<[I::F32; 4]>,
        lit: I::Mask,
        point: Vector<I>,
        plane: Vector<I>,
    ) -> Vector<I> {
        let mut share = i.f32(1.0);
        for shadow in self.shadows {
            share = share * shadow.visibility_lanes(i, lit, point, plane);
        }
        let (Some([r, g, b, _]), Some(stage)) = (texel, &self.projector) else {
            return [share; 3];
        };
        if let Some(shadow) = &stage.projected.shadow {
            let some = r.simd_gt(0.0) | g.simd_gt(0.0) | b.simd_gt(0.0);
            let left = share * shadow.visibility_lanes(i, lit & some, point, plane);
            share = some.select(left, share);
        }
        [r * share, g * share, b * share]
    }
}

impl<'a> Lighting<'a> {
    /// The projectors of the lights, then those that paint.
    pub(crate) fn projectors(&self) -> impl Iterator<Item = &ProjectorStage<'a>> {
        let of_lights = self.lights.iter().filter_map(|by| by.projector.as_ref());
        of_lights.chain(&self.paints)
    }

    /// The light of a part. Without `ALL`, there are no maps but that of baked light.
    #[inline(always)]
    pub(crate) fn terms<I: Isa, const ALL: bool>(
        &self,
        i: I,
        (batch, part): (&Batch<'_>, &Part),
        vectors: &Vectors<'_>,
        side: &Side,
        (normals, reflections): (&NormalStage<'_>, &Reflections<'_>),
        (pair, of_normals, read): (&PackedTexels, &NormalTexels, &LightTexels),
    ) -> TermsLanes<I> {
        let at = part.at;
        let pixels = part.mask(i, part.block.mask);
        let back = part.mask(i, side.back);
        let point = match vectors.position {
            Some(position) => load_vector(i, position, at),
            None => [i.f32(0.0); 3],
        };
        let (mut smooth, mut normal, mut toward_eye) = (point, point, point);
        // Without a light that asks for the normal nothing shows it.
        if self.needs_normal
            || read
                .projectors
                .iter()
                .any(|texels| texels.reaches(part.index))
        {
            smooth = flip(i, back, load_vector(i, vectors.normal, at));
            if self.sees_eye {
                for k in 0..3 {
                    toward_eye[k] = i.f32(self.eye[k]) - point[k];
                }
                toward_eye = unit(i, toward_eye);
            }
            let texels = (pair, of_normals);
            let unit_smooth = unit(i, smooth);
            normal =
                normals.normal::<I, ALL>(i, at, vectors, texels, back, unit_smooth, toward_eye);
        }
        let mut sum = TermsLanes::dark(i);
        // Ambient light of an ambient map: a color of its own, which multiplies neither the base color nor that of the highlight.
        let mut ambient = [i.f32(0.0); 3];
        let power = match self.maps[EXPONENT] {
            Some(_) if ALL => {
                let [factor, ..] = read.maps[EXPONENT].straight(i, at);
                SpecularExponentLanes::Each(factor * self.numbers.ns)
            }
            _ => SpecularExponentLanes::Same(self.power),
        };
        let mut projectors = read.projectors.iter();
        for by in &self.lights {
            let texel = match by.projector.as_ref().and_then(|_| projectors.next()) {
                None => None,
                Some(texels) => match texels.load(i, part.index, part.pixel) {
                    None => continue,
                    some => some,
                },
            };
            let (numbers, light) = (&self.numbers, &by.light);
            let given = evaluate_light(
                i, numbers, power, self.model, light, point, normal, toward_eye,
            );
            let lit = given.lit & pixels;
            if !lit.any_true() {
                continue;
            }
            if ALL && by.is_ambient() && self.maps[AMBIENT].is_some() {
                let texel = read.maps[AMBIENT].straight(i, at);
                for k in 0..3 {
                    ambient[k] = ambient[k] + given.color[k] * given.diffuse * texel[k];
                }
                continue;
            }
            let plane = side.plane(i, part);
            sum.add(&given, lit, by.visibility(i, texel, lit, point, plane));
        }
        if let Some((factor, ..)) = self.light_map {
            let light = read.light_map.straight(i, at);
            for (sum, light) in sum.diffuse.iter_mut().zip(light) {
                *sum = *sum + light * factor;
            }
        }
        if ALL && self.maps[SPECULAR].is_some() {
            let tint = read.maps[SPECULAR].straight(i, at);
            for (sum, tint) in sum.highlight.iter_mut().zip(tint) {
                *sum = *sum * tint;
            }
        }
        if ALL && self.maps[AMBIENT].is_some() {
            for (sum, ambient) in sum.highlight.iter_mut().zip(ambient) {
                *sum = *sum + ambient;
            }
        }
        if !reflections.is_empty() {
            let factor = match self.maps[REFLECTIVITY] {
                Some(_) if ALL => Some(read.maps[REFLECTIVITY].straight(i, at)[0]),
                _ => None,
            };
            let of = (batch, part);
            reflections.add::<I, ALL>(i, of, vectors, back, [smooth, normal], factor, &mut sum);
        }
        sum
    }

    /// The paint of all projectors, premultiplied, over base colors.
    #[inline(always)]
    pub(crate) fn painted<I: Isa>(
        &self,
        i: I,
        part: &Part,
        vectors: &Vectors<'_>,
        side: &Side,
        read: &LightTexels,
        base: Vector<I>,
    ) -> Vector<I> {
        let Some(position) = vectors.position else {
            return base;
        };
        if self.paints.is_empty() {
            return base;
        }
        let mut sum = [i.f32(0.0); 4];
        let (point, plane) = (load_vector(i, position, part.at), side.plane(i, part));
        let of_lights = read.projectors.len() - self.paints.len();
        for (stage, texels) in self.paints.iter().zip(&read.projectors[of_lights..]) {
            let Some(texel) = texels.load(i, part.index, part.pixel) else {
                continue;
            };
            let mut toward = splat(i, stage.projected.position);
            for k in 0..3 {
                toward[k] = toward[k] - point[k];
            }
            let on = dot(plane, toward).simd_gt(0.0) & texel[3].simd_gt(0.0);
            let on = on & part.mask(i, part.block.mask);
            let share = match &stage.projected.shadow {
                Some(shadow) => shadow.visibility_lanes(i, on, point, plane),
                None => i.f32(1.0),
            };
            let keep = i.f32(1.0) - texel[3] * share;
            for k in 0..4 {
                sum[k] = on.select(texel[k] * share + keep * sum[k], sum[k]);
            }
        }
        let [r, g, b, a] = sum;
        let keep = i.f32(1.0) - a;
        [r + keep * base[0], g + keep * base[1], b + keep * base[2]]
    }
}
