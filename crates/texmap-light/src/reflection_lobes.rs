//! The reflection of an environment by a rough surface that is seen aslant.
//!
//! Its lobe is longer than wide there, and ends at the horizon. Levels of an [`EnvironmentLight`](crate::EnvironmentLight) hold lobes as they
//! are seen head on; three of these in the plane of view and normal, and the light of a diffuse surface, together have nearly its form:
//! `examples/reflection_lobes.rs` fits them. Seven by seven spheres in the studio are off by 0.009 of display light, root mean square;
//! by 0.022 with one lobe.

mod table;

use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::albedo::{bilinear, high, low, split};

/// Entries of the table a side.
const SIDE: usize = 16;
/// Least roughness of a lobe, as a factor of the surface's; none is rougher than the surface.
pub(crate) const LEAST_FACTOR: f32 = 0.5;

/// A lobe as it is seen head on. Its axis is `mirrored + (normal - mirrored) lean` for the unit vectors of the mirrored view and of the
/// normal, of any length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectionLobeLanes<I: Isa> {
    /// -1.5 (away from the normal) to 1 (about the normal).
    pub lean: I::F32,
    /// Perceptual roughness: 0.5 to 1 times that of the surface.
    pub roughness: I::F32,
    /// 0 to 1.
    pub weight: I::F32,
}

/// The lobes of a surface, whose weights and `diffuse` add up to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectionLobesLanes<I: Isa> {
    /// In no order.
    pub lobes: [ReflectionLobeLanes<I>; 3],
    /// Weight of the light of a diffuse surface of the same normal: its irradiance over pi.
    pub diffuse: I::F32,
}

/// The lobes of one surface.
pub type ReflectionLobes = ReflectionLobesLanes<Scalar>;

impl ReflectionLobes {
    /// Of a perceptual roughness, seen at a cosine between view and normal; both cut to 0 to 1, NaN to 0.
    ///
    /// ```
    /// use texmap_light::ReflectionLobes;
    /// let seen = ReflectionLobes::new(0.5, 0.2);
    /// let sum: f32 = seen.lobes.iter().map(|lobe| lobe.weight).sum();
    /// assert!((sum + seen.diffuse - 1.0).abs() < 1e-6);
    /// assert!(seen.lobes.iter().all(|lobe| lobe.roughness <= 0.5));
    /// ```
    #[must_use]
    pub fn new(roughness: f32, cosine: f32) -> Self {
        let unit = |x: f32| F32s::<Scalar>::clamp(if x.is_nan() { 0.0 } else { x }, 0.0, 1.0);
        lobes(Scalar, unit(roughness), unit(cosine))
    }
}

/// Both arguments within 0 to 1.
#[inline(always)]
pub(crate) fn lobes<I: Isa>(i: I, roughness: I::F32, cosine: I::F32) -> ReflectionLobesLanes<I> {
    let (zero, one) = (i.f32(0.0), i.f32(1.0));
    let (row, y) = split(i, roughness, SIDE);
    let (column, x) = split(i, cosine.sqrt(), SIDE);
    let at = (row * SIDE as i32 + column).to_u32();
    let around = |words: &'static [u32; SIDE * SIDE]| match GatherTable::new(words) {
        Some(words) => {
            let [p, q] = i.gather_pairs(words, at);
            let [r, s] = i.gather_pairs(words, at + SIDE as u32);
            [p, q, r, s]
        }
        None => [i.u32(0); 4],
    };
    let [a, b, c, d] = around(&table::LOBES[3]);
    let mut diffuse = one;
    let mut lobes = [ReflectionLobeLanes {
        lean: zero,
        roughness: zero,
        weight: zero,
    }; 3];
    for (k, lobe) in lobes.iter_mut().enumerate() {
        let [p, q, r, s] = around(&table::LOBES[k]);
        let lean = bilinear::<I>([low::<I>(p), low::<I>(q), low::<I>(r), low::<I>(s)], x, y);
        let factor = bilinear::<I>(
            [high::<I>(p), high::<I>(q), high::<I>(r), high::<I>(s)],
            x,
            y,
        );
        let shift = 10 * k as u32;
        let weights = [
            weight::<I>(a >> shift),
            weight::<I>(b >> shift),
            weight::<I>(c >> shift),
            weight::<I>(d >> shift),
        ];
        lobe.lean = lean * (1.0 / 16384.0) - 2.0;
        lobe.roughness = factor * (1.0 / 32768.0) * roughness;
        lobe.weight = bilinear::<I>(weights, x, y) * (1.0 / 1023.0);
        diffuse = diffuse - lobe.weight;
    }
    ReflectionLobesLanes { lobes, diffuse }
}

#[inline(always)]
fn weight<I: Isa>(word: I::U32) -> I::F32 {
    (word & 1023).to_i32().to_f32()
}
