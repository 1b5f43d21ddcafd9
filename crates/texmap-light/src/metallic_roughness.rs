//! Metallic-roughness surfaces (glTF 2.0, appendix B, and its extensions `KHR_materials_ior`, `_specular`, `_clearcoat` and
//! `_sheen`) under lights and environments. [`reference::metallic_roughness`](crate::reference::metallic_roughness) says what is
//! computed.

mod lobes;
mod visibility;

use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::lanes::Vector;
use crate::share::arriving;
use crate::vector::{add, cross, dot, scale, splat, unit};
use crate::{EnvironmentLight, Light, albedo, reflection_lobes};
pub(crate) use lobes::power5;
pub use visibility::EnvironmentVisibilityLanes;
use visibility::GatheredLanes;

/// Least perceptual roughness; lower ones count as this. Lights have no size, and a mirror would not show them.
pub const MIN_ROUGHNESS: f32 = 0.03;
/// Least perceptual roughness of sheen. The formula of smoother cloth returns more light than the cloth receives.
pub const SHEEN_MIN_ROUGHNESS: f32 = 0.2;
/// Least cosine to the eye; lower ones count as this.
const MIN_COSINE: f32 = 1e-4;
/// Least fraction of light that is divided by; lower ones count as this. Smooth surfaces (of a roughness up to 0.25) scatter a
/// smaller fraction more than once, and get less than all of that light back.
pub(crate) const MIN_SHARE: f32 = 0.01;

/// A surface at the points of a block. Colours are linear; all numbers are within 0 to 1 but colours of metals, which may be above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetallicRoughnessLanes<I: Isa> {
    /// Colour of the diffuse base, and of a metal head on.
    pub base_color: [I::F32; 3],
    /// 0 (dielectric) to 1 (metal).
    pub metallic: I::F32,
    /// Perceptual roughness: the square root of the GGX width.
    pub roughness: I::F32,
    /// Reflectance of the dielectric head on: see [`dielectric_f0`].
    pub f0: [I::F32; 3],
    /// Reflectance of the dielectric at grazing incidence: the strength of its reflection.
    pub f90: I::F32,
    /// Fraction of the light of a dielectric base that passes through instead of being scattered; `None` for an opaque base. See
    /// [`ReflectanceLanes::transmitted`].
    pub transmission: Option<I::F32>,
    /// A clear layer over everything.
    pub clearcoat: Option<ClearcoatLanes<I>>,
    /// Cloth between clear layer and base.
    pub sheen: Option<SheenLanes<I>>,
}

/// A clear layer of index 1.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearcoatLanes<I: Isa> {
    /// Strength.
    pub factor: I::F32,
    /// Perceptual roughness.
    pub roughness: I::F32,
}

/// Back-scattering fibres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheenLanes<I: Isa> {
    /// Linear colour.
    pub color: [I::F32; 3],
    /// Perceptual roughness.
    pub roughness: I::F32,
}

/// A surface at one point.
pub type MetallicRoughnessSurface = MetallicRoughnessLanes<Scalar>;

/// Reflectance head on of a dielectric: `min(((ior - 1) / (ior + 1))^2 color, 1) strength`.
#[must_use]
pub fn dielectric_f0(ior: f32, strength: f32, color: [f32; 3]) -> [f32; 3] {
    let root = (ior - 1.0) / (ior + 1.0);
    color.map(|c| (root * root * c).below(1.0) * strength)
}

impl<I: Isa> MetallicRoughnessLanes<I> {
    /// A dielectric of index 1.5 without layers.
    #[inline(always)]
    pub fn new(i: I, base_color: [I::F32; 3], metallic: I::F32, roughness: I::F32) -> Self {
        Self {
            base_color,
            metallic,
            roughness,
            f0: splat(i, [0.04; 3]),
            f90: i.f32(1.0),
            transmission: None,
            clearcoat: None,
            sheen: None,
        }
    }
}

/// A surface as one eye sees it, ready for any number of lights: outside of semantic versioning.
#[derive(Clone, Copy, Debug)]
pub struct ReflectanceLanes<I: Isa> {
    normal: Vector<I>,
    smooth: Vector<I>,
    view: Vector<I>,
    nv: I::F32,
    /// Perceptual roughness, at least [`MIN_ROUGHNESS`].
    roughness: I::F32,
    alpha: I::F32,
    f0: Vector<I>,
    f90: I::F32,
    /// Directional albedo of the GGX lobe at the first bounce, and at further ones.
    once: Vector<I>,
    again: Vector<I>,
    /// Directional albedo of the diffuse base, and 1 over the fraction of even light that reaches it.
    diffuse: Vector<I>,
    per_left: I::F32,
    /// Fraction of the light from behind that passes the base.
    transmitted: Option<I::F32>,
    /// Reflectance of further bounces and of the base for one light, without the factors of its direction.
    again_of_light: Vector<I>,
    diffuse_of_light: Vector<I>,
    /// Reflectances of the dielectric's brightest channel, head on and at grazing incidence. The third value is the fraction of its
    /// further scattered light that leaves.
    dielectric: [I::F32; 3],
    coat: Option<Coat<I>>,
    sheen: Option<Sheen<I>>,
}

#[derive(Clone, Copy, Debug)]
struct Coat<I: Isa> {
    factor: I::F32,
    roughness: I::F32,
    alpha: I::F32,
    nv: I::F32,
    /// The eye is in front of the layer.
    seen: I::Mask,
    /// Directional albedo, and the fraction of light left for the layers below.
    albedo: I::F32,
    left: I::F32,
}

#[derive(Clone, Copy, Debug)]
struct Sheen<I: Isa> {
    color: Vector<I>,
    most: I::F32,
    roughness: I::F32,
    alpha: I::F32,
    albedo: I::F32,
    left: I::F32,
}

impl<I: Isa> ReflectanceLanes<I> {
    /// The reflectance of a surface seen along a unit vector to the eye. `normal` is its unit normal (bent by maps), `smooth` that of
    /// its clear layer. Normals that look away from the eye count as seen at grazing incidence.
    #[inline(always)]
    pub fn new(
        i: I,
        surface: &MetallicRoughnessLanes<I>,
        normal: Vector<I>,
        smooth: Vector<I>,
        view: Vector<I>,
    ) -> Self {
        let (one, least) = (i.f32(1.0), i.f32(MIN_SHARE));
        let nv = dot(normal, view).clamp(i.f32(MIN_COSINE), one);
        let roughness = surface.roughness.clamp(i.f32(MIN_ROUGHNESS), one);
        let metallic = surface.metallic;
        let f90 = surface.f90 + (one - surface.f90) * metallic;
        let [a, b] = albedo::ggx(i, roughness, nv);
        let [mean_a, mean_b] = albedo::ggx_average(i, roughness);
        let mean = mean_a + mean_b;
        let (missing, lost) = (one - a - b, one - mean);
        let per_lost = one / lost.above(least);
        let bounces = Bounces::<I> { mean, lost, least };
        let most = surface.f0[0].above(surface.f0[1]).above(surface.f0[2]);
        let more: I::F32 = bounces.share(one, most, surface.f90);
        let left = one - (most * a + surface.f90 * b + more * missing);
        let left_average: I::F32 = one - (most * mean_a + surface.f90 * mean_b + more * lost);
        let per_left = one / left_average.above(least);
        let dielectric = (one - metallic) * left;
        let (mut scattered, mut transmitted) = (surface.base_color, None);
        if let Some(transmission) = surface.transmission {
            let [r, g, b] = surface.base_color;
            let mean = ((r + g + b) * (1.0 / 3.0)).clamp(i.f32(0.0), one);
            let passing = mean * transmission * (one - roughness);
            for color in &mut scattered {
                *color = (*color - passing).above(i.f32(0.0));
            }
            transmitted = Some(passing * dielectric);
        }
        let diffuse = scale(scattered, dielectric);
        let mut f0 = surface.f0;
        let (mut once, mut again, mut again_of_light) = (f0, f0, f0);
        for k in 0..3 {
            let more = bounces.share(one, f0[k], surface.f90);
            let more = more + (bounces.share(one, surface.base_color[k], one) - more) * metallic;
            let more = more * missing;
            f0[k] = f0[k] + (surface.base_color[k] - f0[k]) * metallic;
            once[k] = f0[k] * a + f90 * b;
            again[k] = more;
            again_of_light[k] = more * per_lost;
        }
        Self {
            normal,
            smooth,
            view,
            nv,
            roughness,
            alpha: roughness * roughness,
            f0,
            f90,
            once,
            again,
            diffuse,
            per_left,
            transmitted,
            again_of_light,
            diffuse_of_light: scale(diffuse, per_left),
            dielectric: [most, surface.f90, more],
            coat: match &surface.clearcoat {
                Some(coat) => Some(Coat::new(i, coat, dot(smooth, view))),
                None => None,
            },
            sheen: match &surface.sheen {
                Some(sheen) => Some(Sheen::new(i, sheen, nv)),
                None => None,
            },
        }
    }

    /// Fraction of the light from behind that reaches the eye straight through the surface; `None` for an opaque one.
    ///
    /// The surface counts as a thin sheet of one grey: it passes the mean of its base color in all channels, and scatters what its color has
    /// above that. Rough sheets blur the light behind them, so that they scatter the fraction `roughness` of what they would pass.
    #[inline(always)]
    pub fn transmitted(&self) -> Option<I::F32> {
        let mut passing = self.transmitted?;
        if let Some(sheen) = &self.sheen {
            passing = passing * sheen.left;
        }
        if let Some(coat) = &self.coat {
            passing = passing * coat.left;
        }
        Some(passing)
    }

    /// Radiance towards the eye of a light at the points of a block, and the lanes that it reaches; the values of the others have no
    /// meaning.
    #[inline(always)]
    pub fn under_light(&self, i: I, light: &Light, point: Vector<I>) -> (Vector<I>, I::Mask) {
        if let Light::Ambient { color } = *light {
            let light = splat(i, color);
            let light = GatheredLanes {
                diffuse: light,
                irradiance: light,
                glossy: light,
                coating: light,
            };
            return (self.under_gathered(i, &light), i.mask(true));
        }
        let (color, toward, lit) = arriving(i, light, point);
        let nl = dot(self.normal, toward);
        let lit = lit & nl.simd_gt(0.0);
        if !lit.any_true() {
            return (splat(i, [0.0; 3]), lit);
        }
        let part = self.of_direction(i, toward, nl.above(i.f32(1e-6)));
        let mut out = part;
        for k in 0..3 {
            out[k] = part[k] * color[k];
        }
        (out, lit)
    }

    /// `pi f (N.L)` for a unit vector to the light and its cosine to the normal, which is above 0.
    #[inline(always)]
    fn of_direction(&self, i: I, toward: Vector<I>, nl: I::F32) -> Vector<I> {
        let (zero, one, pi) = (i.f32(0.0), i.f32(1.0), core::f32::consts::PI);
        let half = unit(i, add(self.view, toward));
        let (nh, sine) = cosine_and_sine(self.normal, half);
        let fresnel = power5(i, (one - dot(self.view, half)).clamp(zero, one));
        let lobe = lobes::ggx(i, self.alpha, nh, sine, self.nv, nl) * pi;
        let [a, b] = albedo::ggx(i, self.roughness, nl.below(one));
        let missing = one - a - b;
        let [most, f90, more] = self.dielectric;
        let left = (one - (most * a + f90 * b + more * missing)) * nl;
        let missing = missing * nl;
        let mut out = self.f0;
        for (k, out) in out.iter_mut().enumerate() {
            let f = *out + (self.f90 - *out) * fresnel;
            *out = f * lobe + self.again_of_light[k] * missing + self.diffuse_of_light[k] * left;
        }
        if let Some(sheen) = &self.sheen {
            let albedo = albedo::sheen(i, sheen.roughness, nl.below(one));
            let left = sheen.left.below(one - sheen.most * albedo);
            let lobe = lobes::charlie(i, sheen.alpha, sine, self.nv, nl) * pi;
            for (out, color) in out.iter_mut().zip(sheen.color) {
                *out = *out * left + color * lobe;
            }
        }
        if let Some(coat) = &self.coat {
            let cl = dot(self.smooth, toward);
            let [a, b] = albedo::ggx(i, coat.roughness, cl.clamp(zero, one));
            let left = coat.left.below(one - coat.factor * (a * 0.04 + b));
            let (ch, sine) = cosine_and_sine(self.smooth, half);
            let lobe = lobes::ggx(i, coat.alpha, ch, sine, coat.nv, cl.above(i.f32(1e-6)));
            // The lobe has the cosine to its own normal; all layers take that to the base, which keeps eye and light exchangeable.
            let lobe = lobe * (nl / cl.above(i.f32(1e-6)));
            let lobe = coat.factor * (fresnel * 0.96 + 0.04) * lobe * pi;
            let lobe = (coat.seen & cl.simd_gt(0.0)).select(lobe, zero);
            for out in &mut out {
                *out = *out * left + lobe;
            }
        }
        out
    }

    /// Radiance towards the eye from an environment. The fraction `share` of its light reaches the points, and of this the fractions
    /// `visible` the diffuse base, the GGX lobe and the clear layer: see [`EnvironmentVisibilityLanes`].
    #[inline(always)]
    pub fn under_environment(
        &self,
        i: I,
        light: &EnvironmentLight,
        share: I::F32,
        visible: Option<Vector<I>>,
    ) -> Vector<I> {
        // Metals have no diffuse base.
        let base = some(i, self.diffuse);
        let [irradiance, grazing] = light.diffuse_lanes(i, self.normal, base);
        let mut diffuse = irradiance;
        if base {
            let weight = self.grazing_weight(i);
            for k in 0..3 {
                diffuse[k] = irradiance[k] + (grazing[k] - irradiance[k]) * weight;
            }
        }
        // Matte surfaces have no lobe.
        let glossy = if some(i, self.once) {
            self.glossy(i, light, irradiance)
        } else {
            splat(i, [0.0; 3])
        };
        let coating = match &self.coat {
            Some(coat) => {
                let mirrored = crate::reflect::reflect(self.view, self.smooth);
                light.radiance_lanes(i, coat.roughness, mirrored)
            }
            None => glossy,
        };
        let mut light = GatheredLanes {
            diffuse,
            irradiance,
            glossy,
            coating,
        };
        if let Some(visible) = visible {
            light.shadow(visible);
        }
        scale(self.under_gathered(i, &light), share)
    }

    /// Weight of light at grazing incidence in the light of the base, 0 or less: the albedo of the dielectric lobe rises there, and leaves less.
    #[inline(always)]
    fn grazing_weight(&self, i: I) -> I::F32 {
        let [most, f90, more] = self.dielectric;
        let [a, b] = albedo::ggx_grazing(i, self.roughness);
        let rise = most * a + f90 * b - more * (a + b);
        -rise * self.per_left
    }

    /// Mean light of an environment over the GGX lobe.
    #[inline(always)]
    fn glossy(&self, i: I, light: &EnvironmentLight, irradiance: Vector<I>) -> Vector<I> {
        let mirrored = crate::reflect::reflect(self.view, self.normal);
        let seen = reflection_lobes::lobes(i, self.roughness, self.nv);
        let mut glossy = scale(irradiance, seen.diffuse);
        for lobe in seen.lobes {
            // Rough surfaces have fewer.
            if !lobe.weight.simd_gt(0.0).any_true() {
                continue;
            }
            let mut axis = mirrored;
            for k in 0..3 {
                axis[k] = mirrored[k] + (self.normal[k] - mirrored[k]) * lobe.lean;
            }
            let light = light.radiance_lanes(i, lobe.roughness, axis);
            for k in 0..3 {
                glossy[k] = glossy[k] + light[k] * lobe.weight;
            }
        }
        glossy
    }

    /// Radiance towards the eye of diffuse light alone: irradiance over pi, as light maps hold it.
    #[inline(always)]
    pub fn under_irradiance(&self, light: Vector<I>) -> Vector<I> {
        let mut out = light;
        for k in 0..3 {
            out[k] = light[k] * self.diffuse[k];
            if let Some(sheen) = &self.sheen {
                out[k] = out[k] * sheen.left;
            }
            if let Some(coat) = &self.coat {
                out[k] = out[k] * coat.left;
            }
        }
        out
    }

    /// Radiance towards the eye of light as lobes gather it.
    #[inline(always)]
    fn under_gathered(&self, _: I, light: &GatheredLanes<I>) -> Vector<I> {
        let mut sum = light.irradiance;
        for (k, sum) in sum.iter_mut().enumerate() {
            let even = *sum;
            *sum = light.diffuse[k] * self.diffuse[k]
                + even * self.again[k]
                + light.glossy[k] * self.once[k];
            if let Some(sheen) = &self.sheen {
                *sum = *sum * sheen.left + even * sheen.color[k] * sheen.albedo;
            }
            if let Some(coat) = &self.coat {
                *sum = *sum * coat.left + light.coating[k] * coat.albedo;
            }
        }
        sum
    }
}

/// True if a channel is above 0 in a lane.
#[inline(always)]
fn some<I: Isa>(_: I, [r, g, b]: Vector<I>) -> bool {
    r.above(g).above(b).simd_gt(0.0).any_true()
}

/// Light that leaves a rough surface after more than one bounce (Kulla and Conty 2017).
struct Bounces<I: Isa> {
    /// Mean albedo of the lobe, 1 less that albedo, and the least divisor.
    mean: I::F32,
    lost: I::F32,
    least: I::F32,
}

impl<I: Isa> Bounces<I> {
    /// Fraction of the light lost at the first bounce that leaves after further ones. `f0` and `f90` are the reflectances head on and at
    /// grazing incidence.
    #[inline(always)]
    fn share(&self, one: I::F32, f0: I::F32, f90: I::F32) -> I::F32 {
        let average = f0 + (f90 - f0) * (1.0 / 21.0);
        average * average * self.mean / (one - average * self.lost).above(self.least)
    }
}

impl<I: Isa> Coat<I> {
    #[inline(always)]
    fn new(i: I, coat: &ClearcoatLanes<I>, cosine: I::F32) -> Self {
        let one = i.f32(1.0);
        let roughness = coat.roughness.clamp(i.f32(MIN_ROUGHNESS), one);
        let nv = cosine.clamp(i.f32(MIN_COSINE), one);
        let [a, b] = albedo::ggx(i, roughness, nv);
        let albedo = coat.factor * (a * 0.04 + b);
        Self {
            factor: coat.factor,
            roughness,
            alpha: roughness * roughness,
            nv,
            seen: cosine.simd_gt(0.0),
            albedo,
            left: one - albedo,
        }
    }
}

impl<I: Isa> Sheen<I> {
    #[inline(always)]
    fn new(i: I, sheen: &SheenLanes<I>, nv: I::F32) -> Self {
        let one = i.f32(1.0);
        let roughness = sheen.roughness.clamp(i.f32(SHEEN_MIN_ROUGHNESS), one);
        let albedo = albedo::sheen(i, roughness, nv);
        let [r, g, b] = sheen.color;
        let most = r.above(g).above(b);
        Self {
            color: sheen.color,
            most,
            roughness,
            alpha: roughness * roughness,
            albedo,
            left: one - most * albedo,
        }
    }
}

/// Cosine between unit vectors, at least 0, and the square of the sine without cancellation.
#[inline(always)]
fn cosine_and_sine<T: Number<f32>>(a: [T; 3], b: [T; 3]) -> (T, T) {
    let across = cross(a, b);
    (dot(a, b), dot(across, across))
}

#[cfg(test)]
mod tests;
