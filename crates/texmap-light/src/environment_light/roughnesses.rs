//! Sets of roughnesses: the levels of an environment's light that surfaces read.

use core::ops::BitOr;

use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::metallic_roughness::MIN_ROUGHNESS;
use crate::reflection_lobes::LEAST_FACTOR;

/// Levels of roughness but the first.
pub(super) const STEPS: usize = 11;

/// The level of a roughness within 0 to 1: steps of 0.1, and one of 0.15, as the widths of lobes are squares of roughnesses. Below the
/// first it is a cube: the share of that level's light that is about as wide as the lobe.
#[inline(always)]
pub(super) fn level<I: Isa>(i: I, roughness: I::F32) -> I::F32 {
    let (zero, one) = (i.f32(0.0), i.f32(1.0));
    let tenths = roughness * 10.0;
    let smooth = tenths.below(one);
    smooth * smooth * smooth + (tenths - 1.0).clamp(zero, one) * 2.0 + (tenths - 2.0).above(zero)
}

/// The roughness of a level.
pub(super) fn roughness_of(level: usize) -> f32 {
    match level {
        0 | 1 => level as f32 / 10.0,
        2 => 0.15,
        _ => (level - 1) as f32 / 10.0,
    }
}

/// The levels of an [`EnvironmentLight`](crate::EnvironmentLight) that surfaces of some roughnesses read. The environment itself belongs
/// to every set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Roughnesses {
    /// Bit k - 1 is level k.
    levels: u16,
}

impl Roughnesses {
    /// None: light that is seen, and that diffuse surfaces receive.
    pub const NONE: Self = Self { levels: 0 };
    /// All.
    pub const ALL: Self = Self {
        levels: (1 << STEPS) - 1,
    };

    /// Those of surfaces from one perceptual roughness to another, at least [`MIN_ROUGHNESS`] and at most 1; NaN is the least.
    #[must_use]
    pub fn between(low: f32, high: f32) -> Self {
        let level =
            |roughness: f32| level(Scalar, F32s::<Scalar>::clamp(roughness, MIN_ROUGHNESS, 1.0));
        let (low, high) = (level(low), level(high));
        let first = F32s::<Scalar>::floor(low) as usize;
        let below = F32s::<Scalar>::floor(high) as usize;
        // Between two levels both are read.
        let last = below + usize::from(high > below as f32);
        let levels = (first.max(1)..=last).fold(0, |levels, level| levels | (1 << (level - 1)));
        Self { levels }
    }

    /// Those of the lobes by which a surface of a perceptual roughness reflects: see
    /// [`ReflectionLobes`](crate::ReflectionLobes).
    #[must_use]
    pub fn of_surface(roughness: f32) -> Self {
        let roughness = F32s::<Scalar>::clamp(roughness, MIN_ROUGHNESS, 1.0);
        Self::between(roughness * LEAST_FACTOR, roughness)
    }

    /// True if every roughness of `others` is one of these, or lies between levels of these.
    #[must_use]
    pub fn contains(self, others: Self) -> bool {
        others.levels & !self.levels == 0
    }

    /// The levels but the first, in order.
    pub(super) fn levels(self) -> impl Iterator<Item = usize> {
        (1..=STEPS).filter(move |level| (self.levels >> (level - 1)) & 1 == 1)
    }
}

/// Those of either.
impl BitOr for Roughnesses {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self {
            levels: self.levels | other.levels,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn levels(low: f32, high: f32) -> Vec<usize> {
        Roughnesses::between(low, high).levels().collect()
    }

    #[test]
    fn a_roughness_reads_the_levels_around_it() {
        assert_eq!(levels(0.55, 0.55), [6, 7]);
        assert_eq!(levels(0.5, 0.5), [6]);
        assert_eq!(levels(0.16, 0.17), [2, 3]);
        assert_eq!(levels(1.0, 7.0), [11]);
        // A mirror counts as a little rough: levels 0 and 1.
        assert_eq!(levels(0.0, 0.0), [1]);
        assert_eq!(levels(f32::NAN, f32::NAN), [1]);
        assert_eq!(levels(0.0, 1.0), Vec::from_iter(1..=STEPS));
        assert_eq!(Roughnesses::between(0.0, 1.0), Roughnesses::ALL);
        assert_eq!(Roughnesses::NONE.levels().count(), 0);
    }

    #[test]
    fn levels_have_the_roughnesses_that_are_read_from_them() {
        for k in 0..=STEPS {
            let read = level(Scalar, roughness_of(k));
            assert!((read - k as f32).abs() < 1e-5, "{k}: {read}");
        }
        assert_eq!(level(Scalar, 0.125), 1.5);
    }

    #[test]
    fn sets_contain_their_parts_alone() {
        let (smooth, rough) = (
            Roughnesses::between(0.1, 0.25),
            Roughnesses::between(0.7, 0.7),
        );
        let both = smooth | rough;
        assert!(both.contains(smooth) && both.contains(rough) && both.contains(Roughnesses::NONE));
        assert!(!smooth.contains(rough) && !smooth.contains(both));
        assert!(!both.contains(Roughnesses::between(0.1, 0.7)) && Roughnesses::ALL.contains(both));
    }
}
