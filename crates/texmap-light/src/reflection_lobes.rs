//! The reflection of an environment by a rough surface that is seen aslant.
//!
//! Its lobe is longer than wide there, and ends at the horizon. Levels of an [`EnvironmentLight`](crate::EnvironmentLight) hold lobes as they
//! are seen head on; up to four of these in the plane of view and normal, and the light of a diffuse surface, together have nearly its form:
//! `examples/reflection_lobes.rs` fits them. Seven by seven spheres in the studio are off by 0.0074 of display light, root mean
//! square over 25 x 25 points of each; by 0.021 with one lobe.

mod table;

use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::roughness_table::TablePosition;

/// Lobes of a surface, at most.
const LOBES: usize = 4;
/// Steps of roughness, which every tenth is one of, and of the cosine's square root.
const ROWS: usize = 31;
const COLUMNS: usize = 16;
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
    /// In no order; that of no weight is not read.
    pub lobes: [ReflectionLobeLanes<I>; LOBES],
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
    let position = TablePosition::new(i, roughness, cosine, [ROWS, COLUMNS]);
    let mut diffuse = one;
    let mut lobes = [ReflectionLobeLanes {
        lean: zero,
        roughness: zero,
        weight: zero,
    }; LOBES];
    for (k, lobe) in lobes.iter_mut().enumerate() {
        let words = match GatherTable::new(&table::LOBES[k]) {
            Some(words) => position.read(i, words),
            None => [i.u32(0); 4],
        };
        let lean = field(&position, words, 0, 4095);
        let factor = field(&position, words, 12, 1023);
        lobe.lean = lean * (2.5 / 4095.0) - 1.5;
        lobe.roughness = (factor * ((1.0 - LEAST_FACTOR) / 1023.0) + LEAST_FACTOR) * roughness;
        lobe.weight = field(&position, words, 22, 1023) * (1.0 / 1023.0);
        diffuse = diffuse - lobe.weight;
    }
    ReflectionLobesLanes { lobes, diffuse }
}

/// Bits of four words of the table, and the value between them.
#[inline(always)]
fn field<I: Isa>(
    position: &TablePosition<I>,
    [p, q, r, s]: [I::U32; 4],
    shift: u32,
    mask: u32,
) -> I::F32 {
    position.mean([
        ((p >> shift) & mask).to_i32().to_f32(),
        ((q >> shift) & mask).to_i32().to_f32(),
        ((r >> shift) & mask).to_i32().to_f32(),
        ((s >> shift) & mask).to_i32().to_f32(),
    ])
}
