//! Metallic-roughness surfaces in f64: the lobes, their directional albedos by quadrature, and the whole BRDF.
//!
//! Microfacets are glTF 2.0's (appendix B: GGX, height-correlated Smith, Schlick). Layers are scaled by directional albedos, so that
//! the BRDF is reciprocal, returns no more light than it gets, and all of it where the base is white:
//! - light that scatters more than once between facets (Kulla and Conty 2017) is added to the specular lobe,
//! - a diffuse base gets the light that the dielectric lobe leaves, on the way in and on the way out,
//! - sheen and clearcoat leave to the layers below the lesser of the fractions that they pass on both ways (`KHR_materials_sheen`).

mod visibility;

use alloc::vec::Vec;
use core::f64::consts::{FRAC_1_PI, TAU};

use texmap_math::deterministic_f64;
use texmap_math::float::sqrt;
use texmap_math::glam::DVec3;

use crate::metallic_roughness::MIN_SHARE;
use crate::{MIN_ROUGHNESS, MetallicRoughnessSurface, SHEEN_MIN_ROUGHNESS};

/// GGX distribution of half vectors (Trowbridge and Reitz) for a width `alpha` and the cosine `nh` to the normal.
#[must_use]
pub fn ggx(alpha: f64, nh: f64) -> f64 {
    let k = alpha / (1.0 - nh * nh + nh * nh * alpha * alpha);
    k * k * FRAC_1_PI
}

/// Smith's height-correlated masking and shadowing over `4 (N.V) (N.L)`.
#[must_use]
pub fn smith(alpha: f64, nv: f64, nl: f64) -> f64 {
    let a2 = alpha * alpha;
    let v = nl * sqrt(nv * nv * (1.0 - a2) + a2);
    let l = nv * sqrt(nl * nl * (1.0 - a2) + a2);
    0.5 / (v + l)
}

/// Charlie's distribution of cloth (Estevez and Kulla 2017).
#[must_use]
pub fn charlie(alpha: f64, nh: f64) -> f64 {
    let inverse = 1.0 / alpha;
    let sine = (1.0 - nh * nh).max(0.0);
    (2.0 + inverse) * deterministic_f64::pow(sine, inverse * 0.5) / TAU
}

/// Masking and shadowing of Charlie's cloth over `4 (N.V) (N.L)`, at most 1.
#[must_use]
pub fn cloth(alpha: f64, nv: f64, nl: f64) -> f64 {
    let fit = |x: f64| {
        let t = (1.0 - alpha) * (1.0 - alpha);
        let mix = |a: f64, b: f64| a + (b - a) * t;
        let power = deterministic_f64::pow(x, mix(0.198_23, 0.168_01));
        mix(21.5473, 25.3245) / (1.0 + mix(3.829_87, 3.324_35) * power)
            + mix(-1.977_60, -1.273_93) * x
            + mix(-4.320_54, -4.859_67)
    };
    let lambda = |x: f64| {
        let exponent = if x < 0.5 {
            fit(x)
        } else {
            2.0 * fit(0.5) - fit(1.0 - x)
        };
        deterministic_f64::pow(core::f64::consts::E, exponent)
    };
    (1.0 / ((1.0 + lambda(nv) + lambda(nl)) * 4.0 * nv * nl)).clamp(0.0, 1.0)
}

/// Directional albedo of the GGX lobe under Schlick's Fresnel, as factors of the reflectances head on and at grazing incidence: the
/// mean over `steps x steps / 2` half vectors that the eye sees (Heitz 2018), whose weights vary little at every cosine.
#[must_use]
pub fn ggx_albedo(alpha: f64, nv: f64, steps: u32) -> [f64; 2] {
    let n = f64::from(steps);
    let view = DVec3::new(sqrt((1.0 - nv * nv).max(0.0)), 0.0, nv);
    // The eye from the hemisphere that the microfacets are stretched to, and an axis of the disk that it sees of it.
    let stretched = DVec3::new(alpha * view.x, 0.0, nv).normalize();
    let up = DVec3::new(-stretched.z, 0.0, stretched.x);
    let masking = 2.0 * nv / (nv + sqrt(alpha * alpha + (1.0 - alpha * alpha) * nv * nv));
    let mut sum = [0.0; 2];
    for j in 0..steps / 2 {
        // The other half mirrors this one.
        let angle = ((f64::from(j) + 0.5) / n - 0.25) * TAU;
        let (sin, cos) = deterministic_f64::sin_cos(angle);
        for i in 0..steps {
            let r = sqrt((f64::from(i) + 0.5) / n);
            let x = r * cos;
            let whole = sqrt((1.0 - x * x).max(0.0));
            let seen = 0.5 * (1.0 + stretched.z);
            let y = whole + (r * sin - whole) * seen;
            let z = sqrt((1.0 - x * x - y * y).max(0.0));
            let half = up * y + stretched * z + DVec3::Y * x;
            let half = DVec3::new(alpha * half.x, alpha * half.y, half.z.max(0.0)).normalize();
            let vh = view.dot(half).max(0.0);
            let nl = 2.0 * vh * half.z - nv;
            if nl > 0.0 {
                let weight = smith(alpha, nv, nl) * 4.0 * nv * nl / masking;
                let fresnel = power5(1.0 - vh);
                sum[0] += weight * (1.0 - fresnel);
                sum[1] += weight * fresnel;
            }
        }
    }
    sum.map(|s| s * 2.0 / (n * n))
}

/// Directional albedo of white sheen: an integral over `steps x steps / 2` directions of light, even in the cosine's square root.
#[must_use]
pub fn sheen_albedo(alpha: f64, nv: f64, steps: u32) -> f64 {
    let n = f64::from(steps);
    let view = DVec3::new(sqrt((1.0 - nv * nv).max(0.0)), 0.0, nv);
    let mut sum = 0.0;
    for i in 0..steps {
        let t = (f64::from(i) + 0.5) / n;
        let (nl, step) = (t * t, 2.0 * t / n);
        let s = sqrt(1.0 - nl * nl);
        let shadowing = cloth(alpha, nv, nl);
        for j in 0..steps / 2 {
            let (sin, cos) = deterministic_f64::sin_cos((f64::from(j) + 0.5) / n * TAU);
            let half = (view + DVec3::new(s * cos, s * sin, nl)).normalize();
            sum += charlie(alpha, half.z) * shadowing * nl * step;
        }
    }
    sum * 2.0 * TAU / n
}

fn power5(x: f64) -> f64 {
    let square = x * x;
    square * square * x
}

/// Mean and variance of `(1 - c)^5` over a hemisphere, weighted by the cosine `c`.
pub const GRAZING_MEAN: f64 = 1.0 / 21.0;
/// See [`GRAZING_MEAN`].
pub const GRAZING_VARIANCE: f64 = 1.0 / 66.0 - 1.0 / 441.0;

/// A function of the cosine from its values at even steps of the cosine's square root.
#[derive(Clone, Debug)]
struct Curve<const N: usize>(Vec<[f64; N]>);

impl<const N: usize> Curve<N> {
    const STEPS: usize = 96;

    fn new(mut value: impl FnMut(f64) -> [f64; N]) -> Self {
        let at = |k: usize| {
            let t = k as f64 / Self::STEPS as f64;
            value((t * t).max(1e-5))
        };
        Self((0..=Self::STEPS).map(at).collect())
    }

    fn at(&self, cosine: f64) -> [f64; N] {
        let x = sqrt(cosine.clamp(0.0, 1.0)) * Self::STEPS as f64;
        let low = (x as usize).min(Self::STEPS - 1);
        let k = x - low as f64;
        let (p, q) = (self.0[low], self.0[low + 1]);
        core::array::from_fn(|i| p[i] + (q[i] - p[i]) * k)
    }

    /// Between this and another: 0 is this.
    fn mix(&self, other: &Self, t: f64) -> Self {
        let pairs = self.0.iter().zip(&other.0);
        let mean =
            |(p, q): (&[f64; N], &[f64; N])| core::array::from_fn(|i| p[i] + (q[i] - p[i]) * t);
        Self(pairs.map(mean).collect())
    }

    /// The mean over a hemisphere, weighted by the cosine.
    fn average(&self) -> [f64; N] {
        self.sum(|_| 1.0)
    }

    /// The slope by `(1 - c)^5` of least squares over a hemisphere, weighted by the cosine.
    fn slope(&self) -> [f64; N] {
        self.sum(|c| (power5(1.0 - c) - GRAZING_MEAN) / GRAZING_VARIANCE)
    }

    /// The integral over a hemisphere with a weight beside the cosine, over pi.
    fn sum(&self, weight: impl Fn(f64) -> f64) -> [f64; N] {
        let mut sum = [0.0; N];
        let n = 8 * Self::STEPS;
        for k in 0..n {
            let t = (k as f64 + 0.5) / n as f64;
            let value = self.at(t * t);
            // 2 c dc for c = t^2.
            let weight = 4.0 * t * t * t / n as f64 * weight(t * t);
            for (sum, value) in sum.iter_mut().zip(value) {
                *sum += value * weight;
            }
        }
        sum
    }
}

/// Directional albedos of the GGX lobe of a roughness, by the cosine to the eye, their mean, and their slope by `(1 - c)^5`.
#[derive(Clone, Debug)]
pub struct GgxAlbedo {
    curve: Curve<2>,
    average: [f64; 2],
    slope: [f64; 2],
}

impl GgxAlbedo {
    /// By quadrature, which takes some milliseconds. Perceptual roughness, at least [`MIN_ROUGHNESS`].
    #[must_use]
    pub fn new(roughness: f32) -> Self {
        let alpha = width(roughness);
        let curve = Curve::new(|nv| ggx_albedo(alpha, nv, 128));
        Self {
            average: curve.average(),
            slope: curve.slope(),
            curve,
        }
    }

    /// Between this and another: 0 is this.
    #[must_use]
    pub fn mix(&self, other: &Self, t: f64) -> Self {
        let mean = |p: [f64; 2], q: [f64; 2]| [0, 1].map(|k| p[k] + (q[k] - p[k]) * t);
        Self {
            curve: self.curve.mix(&other.curve, t),
            average: mean(self.average, other.average),
            slope: mean(self.slope, other.slope),
        }
    }
}

/// Directional albedo of white sheen of a roughness, by the cosine to the eye.
#[derive(Clone, Debug)]
pub struct SheenAlbedo(Curve<1>);

impl SheenAlbedo {
    /// By quadrature, which takes some milliseconds. Perceptual roughness, at least [`SHEEN_MIN_ROUGHNESS`].
    #[must_use]
    pub fn new(roughness: f32) -> Self {
        let alpha = sheen_width(roughness);
        Self(Curve::new(|nv| [sheen_albedo(alpha, nv, 64)]))
    }

    /// Between this and another: 0 is this.
    #[must_use]
    pub fn mix(&self, other: &Self, t: f64) -> Self {
        Self(self.0.mix(&other.0, t))
    }
}

/// A surface with the albedos of its lobes.
pub struct Reflectance {
    surface: MetallicRoughnessSurface,
    base: GgxAlbedo,
    coat: Option<GgxAlbedo>,
    sheen: Option<SheenAlbedo>,
}

impl core::fmt::Debug for Reflectance {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Reflectance").field(&self.surface).finish()
    }
}

/// Light as the lobes of a surface gather it. Within each it counts as even.
#[derive(Clone, Copy, Debug)]
pub struct Gathered {
    /// Of a hemisphere: irradiance over pi.
    pub irradiance: DVec3,
    /// Of a hemisphere at grazing incidence: the mean with the weight `(N.L) (1 - N.L)^5`.
    pub grazing: DVec3,
    /// Of the GGX lobe.
    pub glossy: DVec3,
    /// Of the clear layer.
    pub coating: DVec3,
}

impl Gathered {
    /// The same from all directions.
    #[must_use]
    pub fn even(light: DVec3) -> Self {
        Self {
            irradiance: light,
            grazing: light,
            glossy: light,
            coating: light,
        }
    }
}

/// The base of a surface without the directions.
struct Base {
    f0: DVec3,
    f90: f64,
    /// Fraction of the light lost at the first bounce that leaves after further ones.
    more: DVec3,
    /// Reflectance head on of the dielectric's brightest channel, and that fraction of it.
    most: f64,
    once_more: f64,
}

impl Reflectance {
    /// The reflectance of a surface; takes some 10 ms.
    #[must_use]
    pub fn new(surface: &MetallicRoughnessSurface) -> Self {
        let coat = surface.clearcoat.map(|coat| GgxAlbedo::new(coat.roughness));
        let sheen = surface.sheen.map(|sheen| SheenAlbedo::new(sheen.roughness));
        Self::of_albedos(surface, GgxAlbedo::new(surface.roughness), coat, sheen)
    }

    /// The reflectance of a surface by the albedos of its lobes. Those of layers that it has not are not read; it needs those of layers that
    /// it has.
    #[must_use]
    pub fn of_albedos(
        surface: &MetallicRoughnessSurface,
        base: GgxAlbedo,
        coat: Option<GgxAlbedo>,
        sheen: Option<SheenAlbedo>,
    ) -> Self {
        Self {
            surface: *surface,
            base,
            coat,
            sheen,
        }
    }

    /// The BRDF, 1 / steradian, for unit vectors: the normal of the base, that of the clearcoat, to the eye and to the light. 0 where
    /// the light or the eye is behind the surface.
    #[must_use]
    pub fn brdf(&self, normal: DVec3, smooth: DVec3, view: DVec3, light: DVec3) -> DVec3 {
        let (nv, nl) = (normal.dot(view), normal.dot(light));
        if nv <= 0.0 || nl <= 0.0 {
            return DVec3::ZERO;
        }
        let surface = &self.surface;
        let half = (view + light).normalize_or_zero();
        let (nh, vh) = (normal.dot(half).min(1.0), view.dot(half));
        let mut sum = self.base(nv, nl, nh, vh);
        if let Some(sheen) = surface.sheen {
            let color = wide(sheen.color);
            let left = |c: f64| 1.0 - color.max_element() * self.sheen_at(c);
            let alpha = sheen_width(sheen.roughness);
            sum = sum * left(nv).min(left(nl)) + color * charlie(alpha, nh) * cloth(alpha, nv, nl);
        }
        if let Some(coat) = surface.clearcoat {
            let factor = f64::from(coat.factor);
            let (cv, cl) = (smooth.dot(view), smooth.dot(light));
            let left = |c: f64| 1.0 - factor * self.coat_at(c);
            sum *= left(cv).min(left(cl));
            if cv > 0.0 && cl > 0.0 {
                let alpha = width(coat.roughness);
                let fresnel = 0.04 + 0.96 * power5(1.0 - vh);
                let lobe = ggx(alpha, smooth.dot(half).min(1.0)) * smith(alpha, cv, cl);
                sum += DVec3::splat(factor * fresnel * lobe);
            }
        }
        sum
    }

    /// Radiance towards the eye of gathered light, for the cosines of the eye to the normal and to that of the clearcoat.
    #[must_use]
    pub fn under_gathered(&self, (nv, cv): (f64, f64), light: &Gathered) -> DVec3 {
        let (base, [a, b]) = (self.terms(), self.base.curve.at(nv));
        let diffuse = self.scattered() * self.left(&base, [a, b]);
        let again = base.more * (1.0 - a - b);
        let once = base.f0 * a + DVec3::splat(base.f90 * b);
        // Light at grazing incidence that is left, over that of even light.
        let GgxAlbedo { average, slope, .. } = &self.base;
        let grazing = [0, 1].map(|k| average[k] + slope[k] * GRAZING_MEAN);
        let left = self.left(&base, *average);
        let part = (self.left(&base, grazing) - left) / left.max(MIN_SHARE.into());
        let arriving = light.irradiance + (light.grazing - light.irradiance) * part;
        self.layered(
            (nv, cv),
            light.irradiance,
            arriving * diffuse + light.irradiance * again + light.glossy * once,
            light.coating,
        )
    }

    /// Radiance towards the eye of diffuse light alone: irradiance over pi, as light maps hold it. The cosines are those of
    /// [`under_gathered`](Self::under_gathered).
    #[must_use]
    pub fn under_irradiance(&self, (nv, cv): (f64, f64), irradiance: DVec3) -> DVec3 {
        let left = self.left(&self.terms(), self.base.curve.at(nv));
        let base = irradiance * self.scattered() * left;
        // The layers take light, and give none back of it.
        self.layered((nv, cv), DVec3::ZERO, base, DVec3::ZERO)
    }

    /// Fraction of the light from behind that passes the surface towards the eye:
    /// [`ReflectanceLanes::transmitted`](crate::lanes::ReflectanceLanes::transmitted). The cosines are those of
    /// [`under_gathered`](Self::under_gathered).
    #[must_use]
    pub fn transmitted(&self, (nv, cv): (f64, f64)) -> f64 {
        let metallic = f64::from(self.surface.metallic);
        let left = self.left(&self.terms(), self.base.curve.at(nv));
        let passing = DVec3::splat(self.passing() * (1.0 - metallic) * left);
        // The layers take light, and add none.
        self.layered((nv, cv), DVec3::ZERO, passing, DVec3::ZERO).x
    }

    /// The part of a base without reflection that light passes.
    fn passing(&self) -> f64 {
        let surface = &self.surface;
        let mean = (wide(surface.base_color).element_sum() / 3.0).clamp(0.0, 1.0);
        let smooth = 1.0 - f64::from(surface.roughness.max(MIN_ROUGHNESS));
        surface
            .transmission
            .map_or(0.0, |t| mean * smooth * f64::from(t))
    }

    /// Colour of the diffuse base without reflection.
    fn scattered(&self) -> DVec3 {
        let surface = &self.surface;
        let color = (wide(surface.base_color) - DVec3::splat(self.passing())).max(DVec3::ZERO);
        color * (1.0 - f64::from(surface.metallic))
    }

    /// The light of the base under its layers.
    fn layered(
        &self,
        (nv, cv): (f64, f64),
        irradiance: DVec3,
        base: DVec3,
        coating: DVec3,
    ) -> DVec3 {
        let mut sum = base;
        if let Some(sheen) = self.surface.sheen {
            let (color, albedo) = (wide(sheen.color), self.sheen_at(nv));
            sum = sum * (1.0 - color.max_element() * albedo) + irradiance * color * albedo;
        }
        if let Some(coat) = self.surface.clearcoat {
            let albedo = f64::from(coat.factor) * self.coat_at(cv);
            sum = sum * (1.0 - albedo) + coating * albedo;
        }
        sum
    }

    /// Directional albedo of the clear layer.
    fn coat_at(&self, c: f64) -> f64 {
        let coat = self.coat.as_ref();
        coat.map_or(0.0, |coat| {
            let [a, b] = coat.curve.at(c);
            0.04 * a + b
        })
    }

    /// Directional albedo of white sheen.
    fn sheen_at(&self, c: f64) -> f64 {
        self.sheen.as_ref().map_or(0.0, |sheen| sheen.0.at(c)[0])
    }

    fn terms(&self) -> Base {
        let surface = &self.surface;
        let metallic = f64::from(surface.metallic);
        let color = wide(surface.base_color);
        let dielectric = (wide(surface.f0), f64::from(surface.f90));
        let [a, b] = self.base.average;
        let mean = a + b;
        let often = |f0: DVec3, f90: f64| {
            let average = f0 + (DVec3::splat(f90) - f0) / 21.0;
            average * average * mean / (DVec3::ONE - average * (1.0 - mean))
        };
        let most = dielectric.0.max_element();
        Base {
            f0: dielectric.0.lerp(color, metallic),
            f90: dielectric.1 + (1.0 - dielectric.1) * metallic,
            more: often(dielectric.0, dielectric.1).lerp(often(color, 1.0), metallic),
            most,
            once_more: often(DVec3::splat(most), dielectric.1).x,
        }
    }

    /// Light that the dielectric lobe leaves to the diffuse base, of the lobe's albedo.
    fn left(&self, base: &Base, [a, b]: [f64; 2]) -> f64 {
        let f90 = f64::from(self.surface.f90);
        1.0 - (base.most * a + f90 * b + base.once_more * (1.0 - a - b))
    }

    /// The base without its layers.
    fn base(&self, nv: f64, nl: f64, nh: f64, vh: f64) -> DVec3 {
        let surface = &self.surface;
        let base = self.terms();
        let [a, b] = self.base.average;
        let lost = 1.0 - a - b;
        let missing = |c: f64| {
            let [a, b] = self.base.curve.at(c);
            1.0 - a - b
        };
        let alpha = width(surface.roughness);
        let fresnel = base.f0 + (DVec3::splat(base.f90) - base.f0) * power5(1.0 - vh);
        let once = fresnel * ggx(alpha, nh) * smith(alpha, nv, nl);
        let again =
            base.more * (missing(nv) * missing(nl) / lost.max(MIN_SHARE.into()) * FRAC_1_PI);
        let left = |c: f64| self.left(&base, self.base.curve.at(c));
        let left_average = self.left(&base, self.base.average).max(MIN_SHARE.into());
        let share = left(nv) * left(nl) / left_average;
        once + again + self.scattered() * (share * FRAC_1_PI)
    }
}

fn sheen_width(roughness: f32) -> f64 {
    let roughness = f64::from(roughness.max(SHEEN_MIN_ROUGHNESS));
    roughness * roughness
}

fn width(roughness: f32) -> f64 {
    let roughness = f64::from(roughness.max(MIN_ROUGHNESS));
    roughness * roughness
}

fn wide(a: [f32; 3]) -> DVec3 {
    DVec3::from(a.map(f64::from))
}
