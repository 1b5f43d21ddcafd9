//! Shadow maps prepared for look-ups in f32. [`ShadowMap::visibility`] is their reference in f64.

mod cube;
mod flat;
mod taps;

use alloc::vec::Vec;

use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, Scalar};

use crate::lanes::Vector;
use crate::shadow_bounds::ShadowBounds;
use crate::{ShadowBias, ShadowKind, ShadowMap};
use cube::Cube;
use flat::Flat;
use taps::{Bias, Taps};

/// A shadow map with the bias and the filter of its look-ups.
///
/// Look-ups are in f32, with the results of [`ShadowMap::visibility`] but for points within about 1e-6 of the map's width of a
/// texel's edge, or as near to the depth that they are compared with.
#[derive(Clone, Debug)]
pub struct ShadowSampler {
    map: ShadowMap,
    form: Form,
}

/// A map in the form that look-ups read.
#[derive(Clone, Debug)]
enum Form {
    Flat(Flat),
    Cube(Cube),
    /// A map without depths, which have been taken out.
    Empty,
}

impl ShadowSampler {
    /// A map with a bias and `taps` x `taps` comparisons a look-up, 1 or an odd number up to 15.
    #[must_use]
    pub fn new(map: ShadowMap, bias: ShadowBias, taps: u32) -> Self {
        Self::with_bounds(map, bias, taps, None)
    }

    /// [`new`](Self::new) with the bounds that were found as the map was drawn.
    #[doc(hidden)]
    #[must_use]
    pub fn with_bounds(
        map: ShadowMap,
        bias: ShadowBias,
        taps: u32,
        bounds: Option<ShadowBounds>,
    ) -> Self {
        let taps = Taps::new(&map, bias, taps, bounds);
        let form = match *map.kind() {
            ShadowKind::Directional {
                light_from_world,
                half,
            } => Form::Flat(Flat::new(light_from_world, half, false, taps)),
            ShadowKind::Spot {
                light_from_world,
                tan_half,
            } => Form::Flat(Flat::new(light_from_world, tan_half, true, taps)),
            ShadowKind::Point { position } => Form::Cube(Cube::new(position, taps)),
        };
        Self { map, form }
    }

    /// The kind of light that the map belongs to.
    #[must_use]
    pub fn kind(&self) -> &ShadowKind {
        self.map.kind()
    }

    /// The depths of the map, to be used again; everything is lit from then on.
    #[doc(hidden)]
    pub fn take_depths(&mut self) -> Vec<f32> {
        self.form = Form::Empty;
        self.map.take_depths()
    }

    /// True if look-ups read the normal of the receiver's plane.
    #[must_use]
    pub fn reads_normals(&self) -> bool {
        let taps = match &self.form {
            Form::Flat(flat) => flat.taps(),
            Form::Cube(cube) => cube.taps(),
            Form::Empty => return false,
        };
        !matches!(taps.bias, Bias::Constant(_))
    }

    /// Fraction of the light that reaches a point, 0..=1: see [`ShadowMap::visibility`].
    #[must_use]
    pub fn visibility(&self, point: [f32; 3], normal: [f32; 3]) -> f32 {
        self.visibility_lanes(Scalar, true, point, normal)
    }

    /// [`visibility`](Self::visibility) for the points of a block. Nothing is looked up if no lane in `asked` falls into the map.
    #[inline(always)]
    pub fn visibility_lanes<I: Isa>(
        &self,
        i: I,
        asked: I::Mask,
        point: Vector<I>,
        normal: Vector<I>,
    ) -> I::F32 {
        let words = GatherTable::new(bytemuck::cast_slice(self.map.depths()));
        match (&self.form, words) {
            (Form::Flat(flat), Some(words)) => flat.visibility(i, words, asked, point, normal),
            (Form::Cube(cube), Some(words)) => cube.visibility(i, words, asked, point, normal),
            _ => i.f32(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::glam::{DMat4, DVec3};

    use crate::vector::{columns, load, narrow};

    const BIASES: [(ShadowBias, u32); 5] = [
        (ShadowBias::Planes(1e-3), 1),
        (ShadowBias::Planes(1e-3), 5),
        (ShadowBias::Constant(0.05), 1),
        (ShadowBias::Slope(1e-3), 3),
        (ShadowBias::NormalOffset(1.5), 5),
    ];

    /// Numbers of -1..1.
    fn noise() -> impl FnMut() -> f64 {
        let mut seed = 1u32;
        move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / 8_388_608.0 - 1.0
        }
    }

    /// A map of each kind of light, all about (-0.1, 4, 0.2), of uneven depths about 4.
    fn maps() -> [ShadowMap; 3] {
        let down = DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.1, 0.2, -4.0, 1.0,
        ]);
        let mut noise = noise();
        let mut map = |kind, faces: usize| {
            let depths = (0..faces * 64 * 64).map(|_| (4.0 + noise()) as f32);
            ShadowMap::new(kind, 64, depths.collect()).unwrap()
        };
        let (light_from_world, half, tan_half) = (down, 1.1, 0.3);
        [
            map(
                ShadowKind::Directional {
                    light_from_world,
                    half,
                },
                1,
            ),
            map(
                ShadowKind::Spot {
                    light_from_world,
                    tan_half,
                },
                1,
            ),
            map(
                ShadowKind::Point {
                    position: DVec3::new(-0.1, 4.0, 0.2),
                },
                6,
            ),
        ]
    }

    /// Look-ups in f32 give the results of f64 ones at all but a few points. That holds under every bias, beyond the map and behind the
    /// light too.
    #[test]
    fn readers_agree_with_the_reference() {
        let mut noise = noise();
        for map in maps() {
            let around = matches!(map.kind(), ShadowKind::Point { .. });
            for (bias, taps) in BIASES {
                let reader = ShadowSampler::new(map.clone(), bias, taps);
                let (mut off, mut between) = (0, 0);
                for _ in 0..4_000 {
                    let wide = if around { 4.0 } else { 1.3 };
                    let point = DVec3::new(wide * noise(), 5.0 * noise(), wide * noise());
                    let normal = DVec3::new(noise(), 1.0 + noise(), noise()).normalize();
                    let got = reader.visibility(narrow(point), narrow(normal));
                    let expected = map.visibility(point, normal, bias, taps);
                    off += u32::from((got - expected).abs() > 1e-6);
                    between += u32::from(expected < 1.0);
                }
                assert!(off <= 8, "{:?} {bias:?}: {off} of 4000", map.kind());
                assert!(between > 400, "{between}");
            }
            let reader = ShadowSampler::new(map, ShadowBias::Slope(1e-3), 3);
            for bad in [[f32::NAN, 0.0, 0.0], [f32::INFINITY; 3]] {
                assert_eq!(reader.visibility(bad, [0.0, 1.0, 0.0]), 1.0, "{bad:?}");
            }
            // So far away that a point light's map holds nothing.
            let far = reader.visibility([1e30, -1e30, 0.0], [0.0, 1.0, 0.0]);
            assert_eq!(far, if around { 0.0 } else { 1.0 });
        }
    }

    /// Comparisons over the edges and corners of a cube's faces read the texels that the reference reads.
    #[test]
    fn taps_beyond_a_face_are_those_of_the_reference() {
        let [.., map] = maps();
        let ShadowKind::Point { position } = *map.kind() else {
            panic!("a point light");
        };
        let reader = ShadowSampler::new(map.clone(), ShadowBias::Constant(0.0), 15);
        let mut noise = noise();
        let (mut off, mut count) = (0, 0);
        for (x, y, z) in (0..27).map(|i| (i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)) {
            for _ in 0..40 {
                let near = DVec3::new(noise(), noise(), noise()) * 0.1;
                let d = DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + near;
                let point = position + d * (4.0 / d.length());
                let got = reader.visibility(narrow(point), [0.0, 1.0, 0.0]);
                let expected = map.visibility(point, DVec3::Y, ShadowBias::Constant(0.0), 15);
                // A comparison of equal depths may fall either way.
                off += u32::from((got - expected).abs() > 1.5 / 225.0);
                count += 1;
            }
        }
        assert!(off * 100 <= count, "{off} of {count}");
    }

    /// Every width gives the bits of [`ShadowSampler::visibility`], at points of one face and of many, in the light and not finite.
    #[test]
    fn widths_agree() {
        let mut noise = noise();
        let mut counts = [0; 2];
        for map in maps() {
            for (bias, taps) in BIASES {
                let reader = ShadowSampler::new(map.clone(), bias, taps);
                for round in 0..200 {
                    // Rays of all directions, and of nearly one: most of those blocks lie on one face.
                    let wide = if round % 2 == 0 { 4.0 } else { 0.2 };
                    let middle = DVec3::new(noise(), noise(), noise()) * (4.0 - wide);
                    let mut points: [_; 16] = core::array::from_fn(|_| {
                        narrow(middle + DVec3::new(noise(), noise(), noise()) * wide)
                    });
                    if round % 5 == 0 {
                        points[3] = [-0.1, 4.0, 0.2];
                        points[7] = [f32::NAN, 0.0, 1.0];
                        points[9] = [f32::INFINITY, -1e30, 1e30];
                        points[10] = [1e30, -1e30, 1e30];
                    }
                    let normals: [_; 16] = core::array::from_fn(|_| {
                        narrow(DVec3::new(noise(), 1.0 + noise(), noise()).normalize())
                    });
                    every_width!(i => check(i, &reader, &points, &normals, &mut counts));
                }
            }
        }
        assert!(counts.into_iter().all(|count| count > 10_000), "{counts:?}");
        fn check<I: Isa>(
            i: I,
            reader: &ShadowSampler,
            points: &[[f32; 3]; 16],
            normals: &[[f32; 3]; 16],
            counts: &mut [u32; 2],
        ) {
            for first in (0..16).step_by(I::LANES) {
                let (p, n) = (load(i, points, first), load(i, normals, first));
                let [got] = columns(i, [reader.visibility_lanes(i, i.mask(true), p, n)]);
                for (lane, at) in (first..first + I::LANES).enumerate() {
                    let one = reader.visibility(points[at], normals[at]);
                    assert_eq!(got[lane].to_bits(), one.to_bits(), "{:?}", points[at]);
                    counts[usize::from(one < 1.0)] += 1;
                }
            }
        }
    }

    /// Points beside the edge of a far face and a near one see both: the bounds of a face's own depths do not decide.
    #[test]
    fn lanes_beside_an_edge_see_the_neighbour() {
        // +X is near, the others are far.
        let depths = (0..6 * 64 * 64).map(|i| if i < 64 * 64 { 2.0 } else { 8.0 });
        let kind = ShadowKind::Point {
            position: DVec3::ZERO,
        };
        let map = ShadowMap::new(kind, 64, depths.collect()).unwrap();
        let reader = ShadowSampler::new(map, ShadowBias::Constant(0.0), 5);
        // On +Z, up to a texel from its edge with +X.
        let points: [_; 16] = core::array::from_fn(|i| [4.0 - 0.006 * i as f32, 0.3, 4.01]);
        let one = points.map(|p| reader.visibility(p, [0.0, 0.0, -1.0]));
        assert!(one.iter().all(|lit| *lit > 0.5 && *lit < 1.0), "{one:?}");
        every_width!(i => check(i, &reader, &points, &one));
        fn check<I: Isa>(i: I, reader: &ShadowSampler, points: &[[f32; 3]; 16], one: &[f32; 16]) {
            for first in (0..16).step_by(I::LANES) {
                let p = load(i, points, first);
                let [got] = columns(i, [reader.visibility_lanes(i, i.mask(true), p, p)]);
                assert_eq!(got[..I::LANES], one[first..first + I::LANES]);
            }
        }
    }

    /// Without depths nothing is in shadow.
    #[test]
    fn empty_readers_shadow_nothing() {
        for map in maps() {
            let mut reader = ShadowSampler::new(map, ShadowBias::Constant(0.0), 1);
            assert!(!reader.take_depths().is_empty());
            assert_eq!(reader.visibility([0.0, -9.0, 0.0], [0.0, 1.0, 0.0]), 1.0);
        }
    }
}
