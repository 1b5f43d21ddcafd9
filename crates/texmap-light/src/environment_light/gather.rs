//! Sums over the texels of a cube by a lobe around a direction: near texels one by one, far ones by the means of sixteen.

use alloc::vec::Vec;
use core::f64::consts::PI;

use texmap_math::glam::{DVec2, DVec3};
use texmap_math::lanes::LANES;
use texmap_math::progress::no_progress;
use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, deterministic_f64, dispatch_simd};

use crate::environment::Environment;
use crate::error::LightError;
use crate::lanes::Vector;
use crate::metallic_roughness::power5;
use crate::vector::{dot, narrow, splat};
use crate::{EnvironmentLayout, level};

/// Weights of directions by the cosine `c` of their angle from the lobe's axis.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kernel {
    /// GGX of this squared width, seen head on: `D(H) c`.
    Ggx(f32),
    /// `max(0, c)`.
    Cosine,
    /// `max(0, c) (1 - c)^5`: the light that Schlick's Fresnel takes more of than of light head on.
    Grazing,
    /// `exp(-(angle / sigma)^2 / 2)` for small angles, by `1 / sigma^2`: the blur of the studio, whose room is made by the tests.
    #[cfg(test)]
    Gaussian(f32),
}

impl Kernel {
    pub(super) fn ggx(alpha: f32) -> Self {
        Self::Ggx(alpha * alpha)
    }

    #[cfg(test)]
    pub(super) fn gaussian(sigma: f32) -> Self {
        Self::Gaussian(1.0 / (sigma * sigma))
    }

    /// Cosine of the angle from a patch within which its texels are weighted one by one: where the weight changes much over it.
    fn near(self, radius: f64) -> f32 {
        let width = match self {
            Self::Ggx(a2) => 2.0 * texmap_math::float::sqrt(f64::from(a2)),
            Self::Cosine | Self::Grazing => 1.0,
            #[cfg(test)]
            Self::Gaussian(scale) => {
                // Five times sigma; nothing lies beyond.
                let sigma = 1.0 / texmap_math::float::sqrt(f64::from(scale));
                return deterministic_f64::cos(radius + 5.0 * sigma) as f32;
            }
        };
        // A patch of a third of the weight's own scale is fine: that is the width and half the distance.
        let reach = 2.0 * (3.0 * radius - width);
        let reach = if reach > radius { reach } else { radius };
        deterministic_f64::cos(if reach < PI { reach } else { PI }) as f32
    }

    #[inline(always)]
    fn weight<I: Isa>(self, i: I, c: I::F32) -> I::F32 {
        let (zero, one) = (i.f32(0.0), i.f32(1.0));
        match self {
            Self::Ggx(a2) => {
                // The squared cosine of the half vector is (1 + c) / 2.
                let q = (one - c).above(zero) + (c + 1.0) * a2;
                c.above(zero) / (q * q)
            }
            Self::Cosine => c.above(zero),
            Self::Grazing => c.above(zero) * power5(i, one - c),
            #[cfg(test)]
            Self::Gaussian(scale) => {
                let x = (one - c).above(zero) * scale;
                let near = x.simd_lt(12.0);
                if !near.any_true() {
                    return zero;
                }
                let power =
                    texmap_math::deterministic_f32::exp2_lanes(i, x * -core::f32::consts::LOG2_E);
                near.select(power, zero)
            }
        }
    }
}

/// Sixteen texels or means: direction; light times solid angle, and solid angle.
#[derive(Clone, Copy, Debug)]
struct Sixteen {
    direction: [[f32; LANES]; 3],
    light: [[f32; LANES]; 4],
}

impl Default for Sixteen {
    fn default() -> Self {
        Self {
            direction: [[0.0; LANES]; 3],
            light: [[0.0; LANES]; 4],
        }
    }
}

impl Sixteen {
    fn put(&mut self, lane: usize, direction: [f32; 3], light: [f64; 4]) {
        for (column, c) in self.direction.iter_mut().zip(direction) {
            column[lane] = c;
        }
        for (column, c) in self.light.iter_mut().zip(light) {
            column[lane] = c as f32;
        }
    }

    #[inline(always)]
    fn directions<I: Isa>(&self, i: I, at: usize) -> Vector<I> {
        let [x, y, z] = &self.direction;
        [
            i.load_f32(&x[at..]),
            i.load_f32(&y[at..]),
            i.load_f32(&z[at..]),
        ]
    }

    /// Light and solid angle; of grey light red for all three colours, which are not looked at.
    #[inline(always)]
    fn light<I: Isa, const GREY: bool>(&self, i: I, at: usize) -> [I::F32; 4] {
        let [r, g, b, angle] = &self.light;
        let [r, angle] = [i.load_f32(&r[at..]), i.load_f32(&angle[at..])];
        match GREY {
            true => [r, r, r, angle],
            false => [r, i.load_f32(&g[at..]), i.load_f32(&b[at..]), angle],
        }
    }
}

/// Adds weighted light, of grey light red and solid angle alone.
#[inline(always)]
fn add<T: Number<f32>, const GREY: bool>(sums: &mut [T; 4], light: [T; 4], weight: T) {
    for k in if GREY { &[0, 3][..] } else { &[0, 1, 2, 3] } {
        sums[*k] = sums[*k] + light[*k] * weight;
    }
}

/// Directions that are gathered at once: they read the same patches, or nearly.
pub(super) const AT_ONCE: usize = 4;

/// Sixteen columns of sums of red, green, blue and weights.
type Sums = [[f32; LANES]; 4];

/// The first patch of a vector of patches, and those of them by their bits that are near to each direction.
type Near = (usize, [u32; AT_ONCE]);

/// The texels of a level of a cube in patches of four by four, and the patches' means.
#[derive(Debug)]
pub(super) struct Texels {
    patches: Vec<Sixteen>,
    means: Vec<Sixteen>,
    /// Largest angle between a patch's direction and one of its texels.
    radius: f64,
    /// Every texel is grey.
    grey: bool,
}

impl Texels {
    /// Texels a side of a patch.
    const SIDE: u32 = 4;

    pub(super) fn new(cube: &Environment, level: usize) -> Self {
        let level = cube.levels[level];
        let size = level.width;
        let mut this = Self {
            patches: Vec::new(),
            means: Vec::new(),
            radius: 0.0,
            grey: true,
        };
        let mut least = 1.0f64;
        // The faces are alike.
        let texels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
        let angles = texels.map(|at| EnvironmentLayout::Cube.solid_angle(0, at, (size, size)));
        let angles: Vec<f64> = angles.collect();
        for face in 0..6 {
            for y0 in (0..size).step_by(Self::SIDE as usize) {
                for x0 in (0..size).step_by(Self::SIDE as usize) {
                    let (mut patch, mut all) = (Sixteen::default(), [0.0; 4]);
                    let mut directions = [DVec3::ZERO; LANES];
                    for (lane, direction) in directions.iter_mut().enumerate() {
                        let (x, y) = (x0 + lane as u32 % 4, y0 + lane as u32 / 4);
                        if x >= size || y >= size {
                            continue;
                        }
                        let centre = |c: u32| (f64::from(c) + 0.5) / f64::from(size);
                        let uv = DVec2::new(centre(x), centre(y));
                        let d = EnvironmentLayout::Cube.direction(face, uv);
                        let angle = angles[(y * size + x) as usize];
                        let at = level.index(face, x as usize + 1, y as usize + 1);
                        let [r, g, b] = cube.texels[at].map(|c| f64::from(c) * angle);
                        this.grey &= r == g && g == b;
                        patch.put(lane, narrow(d), [r, g, b, angle]);
                        all = [all[0] + r, all[1] + g, all[2] + b, all[3] + angle];
                        *direction = d;
                    }
                    let axis = directions.iter().sum::<DVec3>().normalize_or_zero();
                    for d in directions.iter().filter(|d| **d != DVec3::ZERO) {
                        let c = d.dot(axis);
                        least = if c < least { c } else { least };
                    }
                    let lane = this.patches.len() % LANES;
                    if lane == 0 {
                        this.means.push(Sixteen::default());
                    }
                    if let Some(means) = this.means.last_mut() {
                        means.put(lane, narrow(axis), all);
                    }
                    this.patches.push(patch);
                }
            }
        }
        this.radius = deterministic_f64::acos(least);
        this
    }

    /// The light by a kernel around directions.
    pub(super) fn lobe(&self, kernel: Kernel) -> Lobe<'_> {
        Lobe {
            texels: self,
            kernel,
            near: kernel.near(self.radius),
            level: level(),
        }
    }
}

/// A kernel over the texels of a cube.
#[derive(Debug)]
pub(super) struct Lobe<'a> {
    texels: &'a Texels,
    kernel: Kernel,
    /// Cosine of the angle within which texels are weighted one by one.
    near: f32,
    level: Level,
}

impl Lobe<'_> {
    /// The environment whose texels hold the mean light around their directions.
    pub(super) fn environment(
        &self,
        layout: EnvironmentLayout,
        size: u32,
    ) -> Result<Environment, LightError> {
        Environment::from_groups(layout, size, &no_progress, |places, sides| {
            self.means(places.map(|(face, centre)| layout.direction(face, centre / sides)))
        })
    }

    /// The mean light around each direction.
    fn means(&self, directions: [DVec3; AT_ONCE]) -> [[f32; 3]; AT_ONCE] {
        let mut sums = [[[0.0; LANES]; 4]; AT_ONCE];
        let to = directions.map(narrow);
        if self.texels.grey {
            dispatch_simd!(self.level, i => self.sum::<_, true>(i, to, &mut sums));
            for [r, g, b, _] in &mut sums {
                (*g, *b) = (*r, *r);
            }
        } else {
            dispatch_simd!(self.level, i => self.sum::<_, false>(i, to, &mut sums));
        }
        sums.map(|sums| {
            let [r, g, b, weight] = sums.map(|lanes| lanes.into_iter().map(f64::from).sum::<f64>());
            [r, g, b].map(|c| (c / weight) as f32)
        })
    }

    /// The sums of sixteen columns: far patches, then the texels of near ones.
    #[inline(always)]
    fn sum<I: Isa, const GREY: bool>(
        &self,
        i: I,
        to: [[f32; 3]; AT_ONCE],
        sums: &mut [Sums; AT_ONCE],
    ) {
        let (kernel, zero) = (self.kernel, i.f32(0.0));
        let mut axes = [[zero; 3]; AT_ONCE];
        for (axis, to) in axes.iter_mut().zip(to) {
            *axis = splat(i, to);
        }
        let all = u32::MAX >> (32 - I::LANES);
        let mut near: Vec<Near> = Vec::new();
        for at in (0..LANES).step_by(I::LANES) {
            let mut lanes = [[zero; 4]; AT_ONCE];
            for (k, means) in self.texels.means.iter().enumerate() {
                let d = means.directions(i, at);
                let mut cosines = [zero; AT_ONCE];
                let (mut far, mut bits) = ([i.mask(false); AT_ONCE], [0; AT_ONCE]);
                let (mut some, mut weighs) = (0, i.mask(false));
                for n in 0..AT_ONCE {
                    cosines[n] = dot(d, axes[n]);
                    far[n] = cosines[n].simd_lt(self.near);
                    bits[n] = !far[n].to_bitmask() & all;
                    some |= bits[n];
                    weighs = weighs | (far[n] & cosines[n].simd_gt(0.0));
                }
                if some != 0 {
                    near.push((k * LANES + at, bits));
                }
                // Half of all patches lie behind the axis, where no kernel weighs anything.
                if weighs.any_true() {
                    let light = means.light::<I, GREY>(i, at);
                    for n in 0..AT_ONCE {
                        let weight = far[n].select(kernel.weight(i, cosines[n]), zero);
                        add::<_, GREY>(&mut lanes[n], light, weight);
                    }
                }
            }
            for (lanes, sums) in lanes.iter().zip(&mut *sums) {
                for (lanes, sum) in lanes.iter().zip(sums) {
                    lanes.store(&mut sum[at..]);
                }
            }
        }
        // Near patches in the order of their numbers, which is the same at every width.
        near.sort_unstable();
        for at in (0..LANES).step_by(I::LANES) {
            let mut lanes = [[zero; 4]; AT_ONCE];
            for (lanes, sums) in lanes.iter_mut().zip(&*sums) {
                for (lanes, sum) in lanes.iter_mut().zip(sums) {
                    *lanes = i.load_f32(&sum[at..]);
                }
            }
            for (first, bits) in &near {
                let mut some = bits[0] | bits[1] | bits[2] | bits[3];
                while some != 0 {
                    let lane = some.trailing_zeros();
                    some &= some - 1;
                    let Some(patch) = self.texels.patches.get(first + lane as usize) else {
                        continue;
                    };
                    let d = patch.directions(i, at);
                    let light = patch.light::<I, GREY>(i, at);
                    for n in 0..AT_ONCE {
                        // Far from this direction it is counted already.
                        if (bits[n] >> lane) & 1 == 1 {
                            let weight = kernel.weight(i, dot(d, axes[n]));
                            add::<_, GREY>(&mut lanes[n], light, weight);
                        }
                    }
                }
            }
            for (lanes, sums) in lanes.iter().zip(&mut *sums) {
                for (lanes, sum) in lanes.iter().zip(sums) {
                    lanes.store(&mut sum[at..]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::simd::Scalar;

    fn noise(size: u32) -> Environment {
        let mut seed = 1u32;
        let texel = |_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [8, 12, 16].map(|shift| f32::from((seed >> shift) as u8))
        };
        Environment::from_fn(EnvironmentLayout::Cube, size, texel).unwrap()
    }

    const KERNELS: [Kernel; 6] = [
        Kernel::Ggx(1e-4),
        Kernel::Ggx(0.04),
        Kernel::Ggx(1.0),
        Kernel::Cosine,
        Kernel::Grazing,
        Kernel::Gaussian(625.0),
    ];

    /// Four directions side by side, as texels of one row lie, or far apart, as at the end of a row.
    fn groups() -> [[DVec3; AT_ONCE]; 2] {
        let near = [0.0, 0.03, 0.06, 0.09].map(|x| DVec3::new(0.4 + x, -0.48, 0.8).normalize());
        [
            near,
            [DVec3::X, DVec3::Y, DVec3::NEG_Z, DVec3::ONE.normalize()],
        ]
    }

    #[test]
    fn widths_agree() {
        for size in [3, 16, 22] {
            let texels = Texels::new(&noise(size), 0);
            for kernel in KERNELS {
                for to in groups().map(|group| group.map(narrow)) {
                    let lobe = texels.lobe(kernel);
                    let mut plain = [[[0.0; LANES]; 4]; AT_ONCE];
                    lobe.sum::<_, false>(Scalar, to, &mut plain);
                    every_width!(i => {
                        let mut sums = [[[0.0; LANES]; 4]; AT_ONCE];
                        lobe.sum::<_, false>(i, to, &mut sums);
                        assert_eq!(sums, plain, "{size} {kernel:?}");
                    });
                }
            }
        }
    }

    #[test]
    fn directions_do_not_depend_on_those_beside_them() {
        let texels = Texels::new(&noise(16), 0);
        for kernel in KERNELS {
            let lobe = texels.lobe(kernel);
            for group in groups() {
                let together = lobe.means(group);
                let alone = group.map(|d| lobe.means([d; AT_ONCE])[0]);
                assert_eq!(together, alone, "{kernel:?}");
                assert_ne!(together[0], together[3], "{kernel:?}");
            }
        }
    }

    /// Noise, the worst of environments, against the sum of its texels one by one; and near texels matter.
    #[test]
    fn far_patches_stand_for_their_texels() {
        let environment = noise(32);
        let texels = Texels::new(&environment, 0);
        let mut blind = 0.0f64;
        for kernel in KERNELS {
            for d in [
                DVec3::X,
                DVec3::new(0.36, -0.48, 0.8),
                DVec3::ONE.normalize(),
            ] {
                let mut exact = [0.0f64; 4];
                let mut coarse = [0.0f64; 4];
                for (sixteen, sum) in texels
                    .patches
                    .iter()
                    .map(|p| (p, true))
                    .chain(texels.means.iter().map(|p| (p, false)))
                {
                    let to = if sum { &mut exact } else { &mut coarse };
                    for lane in 0..LANES {
                        let at = sixteen.direction.map(|c| c[lane]);
                        let c = dot(at, narrow(d));
                        let weight = f64::from(kernel.weight(Scalar, c));
                        for (to, light) in to.iter_mut().zip(sixteen.light) {
                            *to += weight * f64::from(light[lane]);
                        }
                    }
                }
                let got = f64::from(texels.lobe(kernel).means([d; AT_ONCE])[0][1]);
                let off = (got / (exact[1] / exact[3]) - 1.0).abs();
                assert!(off < 0.02, "{kernel:?} {d}: {off}");
                blind = blind.max((coarse[1] / coarse[3] / (exact[1] / exact[3]) - 1.0).abs());
            }
        }
        assert!(blind > 0.05, "{blind}");
    }
}
