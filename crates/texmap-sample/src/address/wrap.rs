use texmap_math::simd::{Isa, One, Scalar, prelude::*};

/// Treatment of coordinates outside `[0, 1)`, per axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// The image repeats, every second copy mirrored.
    MirroredRepeat,
    /// The border texel continues.
    ClampToEdge,
    /// Outside lies the sampler's border colour.
    ClampToBorder,
    /// Mirrored once about 0, then clamped.
    MirrorClampToEdge,
}

/// Index of a texel that lies outside under [`Wrap::ClampToBorder`].
pub(crate) const OUTSIDE: i32 = -1;

/// Largest f32 below one: keeps `u - floor(u)` of a tiny negative u inside the last texel.
pub(crate) const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Scaled coordinates below this are used as they are; they still have two fraction bits.
pub(crate) const REACH: f32 = 4_194_304.0;

/// One axis of a texture under a wrap mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Axis {
    pub(crate) wrap: Wrap,
    /// Repeat over a power of two: scaling is exact, so it comes first and the wrap is a mask.
    pub(crate) scaled_first: bool,
}

impl Axis {
    /// `n` is the side of level 0; all levels of a power of two are powers of two.
    #[inline(always)]
    pub(crate) fn new(wrap: Wrap, n: i32) -> Self {
        Self {
            wrap,
            scaled_first: wrap == Wrap::Repeat && n.count_ones() == 1,
        }
    }

    /// The coordinate in `units` of a level, whose floor is a texel for [`index`](Self::index). Unless scaling is exact, the
    /// range reduction comes before it, so that `u = 65536.25` loses nothing. Scaled coordinates below `reach` are used as they are.
    #[inline(always)]
    pub(crate) fn scale<I: Isa>(self, i: I, u: I::F32, units: I::F32, reach: f32) -> I::F32 {
        match self.wrap {
            Wrap::Repeat if self.scaled_first => {
                let x = u * units;
                let inside = x.abs().simd_lt(reach);
                if inside.all_true() {
                    return x;
                }
                inside.select(x, fraction(i, u) * units)
            }
            _ => self.reduced(i, u) * units,
        }
    }

    /// The floor of the coordinate in `units`, `1 << shift` of which are a texel: an index of texels for [`index`](Self::index). No product
    /// that is rounded up to the next texel counts there: the texel is that of real numbers.
    #[inline(always)]
    pub(crate) fn texel<I: Isa>(
        self,
        i: I,
        u: I::F32,
        units: I::F32,
        (shift, reach): (u32, f32),
    ) -> I::I32 {
        let x = self.scale(i, u, units, reach);
        let floor = x.floor_to_i32();
        let texel = floor >> shift;
        if self.scaled_first {
            return texel;
        }
        let whole = (texel << shift).to_f32().simd_eq(x);
        if !whole.any_true() {
            return texel;
        }
        // Rare: u is on a border between texels, or nearer to it than f32 can tell.
        let below = rounding(i, self.reduced(i, u), units, x).simd_lt(0.0) & whole;
        below.select(texel - 1, texel)
    }

    /// The coordinate that [`scale`](Self::scale) multiplies.
    #[inline(always)]
    fn reduced<I: Isa>(self, i: I, u: I::F32) -> I::F32 {
        match self.wrap {
            Wrap::Repeat => fraction(i, u),
            Wrap::MirroredRepeat => centred(i, u),
            // Wide kernels still reach the image from outside, so the coordinate is only kept small.
            Wrap::ClampToEdge | Wrap::ClampToBorder | Wrap::MirrorClampToEdge => {
                let u = u.simd_eq(u).select(u, i.f32(0.0));
                let u = u.simd_gt(65.0).select(i.f32(65.0), u);
                u.simd_gt(-64.0).select(u, i.f32(-64.0))
            }
        }
    }

    /// Texel of an index that [`scale`](Self::scale) leads to, on an axis of `n` texels. [`OUTSIDE`] a border.
    #[inline(always)]
    pub(crate) fn index<I: Isa>(self, i: I, x: I::I32, n: I::I32) -> I::I32 {
        match self.wrap {
            Wrap::Repeat if self.scaled_first => x & (n - 1),
            // Fractions keep the index within a texel of 0..n.
            Wrap::Repeat => {
                let x = x.simd_lt(0).select(x + n, x);
                x.simd_ge(n).select(x - n, x)
            }
            // Two indices beyond -n..n, which cubics reach, come back as well.
            Wrap::MirroredRepeat => {
                let x = mirrored(i, x);
                let back = n + n - 1 - x;
                let x = x.simd_lt(back).select(x, back);
                let x = mirrored(i, x);
                x.simd_lt(n).select(x, n - 1)
            }
            Wrap::ClampToEdge => {
                let x = x.simd_gt(0).select(x, i.i32(0));
                x.simd_lt(n).select(x, n - 1)
            }
            Wrap::ClampToBorder => {
                let inside = x.simd_lt(n) & x.simd_ge(0);
                inside.select(x, i.i32(OUTSIDE))
            }
            Wrap::MirrorClampToEdge => {
                let x = mirrored(i, x);
                x.simd_lt(n).select(x, n - 1)
            }
        }
    }

    /// [`index`](Self::index) of any index, however far outside.
    #[inline(always)]
    pub(crate) fn far_index<I: Isa>(self, i: I, x: I::I32, n: I::I32) -> I::I32 {
        match self.wrap {
            Wrap::Repeat if !self.scaled_first => remainder::<I>(x, n),
            Wrap::MirroredRepeat => {
                let m = remainder::<I>(x, n + n);
                m.simd_lt(n).select(m, n + n - 1 - m)
            }
            _ => self.index(i, x, n),
        }
    }

    /// One coordinate in texels.
    #[inline(always)]
    pub(crate) fn texels(self, u: f32, n: i32) -> f32 {
        self.scale(Scalar, u, n as f32, REACH)
    }

    /// The texel of one coordinate.
    #[inline(always)]
    pub(crate) fn nearest(self, u: f32, n: i32) -> i32 {
        let x = self.texel(Scalar, u, n as f32, (0, REACH));
        self.index(Scalar, x, One(n)).0
    }

    /// The two texels around one coordinate and the weight of the second.
    #[inline(always)]
    pub(crate) fn around(self, u: f32, n: i32) -> ([i32; 2], f32) {
        let x = self.texels(u, n) - 0.5;
        let first = x.floor_to_i32();
        let texels = [first, first + 1].map(|x| self.index(Scalar, x, One(n)).0);
        (texels, x - first.to_f32())
    }
}

/// `a * b - product` of real numbers, but for rounding that keeps its sign, for a `product` that is `a * b` rounded and a whole `b` of at
/// most 16 significant bits (Dekker 1971, "A floating-point technique for extending the available precision").
#[inline(always)]
fn rounding<I: Isa>(_: I, a: I::F32, b: I::F32, product: I::F32) -> I::F32 {
    // Parts of 8 bits: products with b are exact, and so are sums, but for the last.
    let bits = a.to_bits();
    let high = (bits & 0xffff_0000).to_f32_bits();
    let upper = (bits & 0xffff_ff00).to_f32_bits();
    ((high * b - product) + (upper - high) * b) + (a - upper) * b
}

/// An index, or its mirror image from 0 on.
#[inline(always)]
fn mirrored<I: Isa>(i: I, x: I::I32) -> I::I32 {
    x.simd_lt(0).select(i.i32(-1) - x, x)
}

/// `x` modulo `n`, from 0 on. Below 2^17 the quotient in f32 is on the right side of every integer.
#[inline(always)]
fn remainder<I: Isa>(x: I::I32, n: I::I32) -> I::I32 {
    x - n * (x.to_f32() / n.to_f32()).floor_to_i32()
}

/// `u - floor(u)` in `[0, 1)`; NaN and infinities give 0.
#[inline(always)]
pub(crate) fn fraction<I: Isa>(i: I, u: I::F32) -> I::F32 {
    let u = u.abs().simd_lt(WHOLE).select(u, i.f32(0.0));
    let f = u - u.floor_to_i32().to_f32();
    let f = f.simd_gt(0.0).select(f, i.f32(0.0));
    f.simd_gt(BELOW_ONE).select(i.f32(BELOW_ONE), f)
}

/// Floats from here on have no fraction, and half of them is at most the next whole number.
const WHOLE: f32 = 8_388_608.0;

/// `u` less the even number next to it, in `[-1, 1]`: a coordinate of the image (from 0 on) or of its mirror image (below 0). Exact, so
/// that a mirrored image keeps every bit of the coordinate; NaN and infinities give 0.
#[inline(always)]
fn centred<I: Isa>(i: I, u: I::F32) -> I::F32 {
    let half = u * 0.5;
    // Beyond 2^24 all numbers are even.
    let near = half.abs().simd_lt(WHOLE);
    let (u, half) = (near.select(u, i.f32(0.0)), near.select(half, i.f32(0.0)));
    let whole = half.floor_to_i32().to_f32();
    let upper = (half - whole).simd_ge(0.5);
    u - upper.select(whole + 1.0, whole) * 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integer_wraps_follow_the_definitions() {
        let n = 3;
        let expect = |wrap, list: [i32; 13]| {
            for (k, want) in list.into_iter().enumerate() {
                assert_eq!(
                    Axis::new(wrap, n)
                        .far_index(Scalar, One(k as i32 - 6), One(n))
                        .0,
                    want,
                    "{wrap:?} {}",
                    k as i32 - 6
                );
            }
        };
        expect(Wrap::Repeat, [0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        expect(
            Wrap::MirroredRepeat,
            [0, 1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0],
        );
        expect(Wrap::ClampToEdge, [0, 0, 0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2]);
        expect(
            Wrap::ClampToBorder,
            [-1, -1, -1, -1, -1, -1, 0, 1, 2, -1, -1, -1, -1],
        );
        expect(
            Wrap::MirrorClampToEdge,
            [2, 2, 2, 2, 1, 0, 0, 1, 2, 2, 2, 2, 2],
        );
    }

    #[test]
    fn places_stay_near_and_survive_anything() {
        for n in [63, 64] {
            for u in [
                0.0,
                -0.0,
                -1e-30,
                -1.0,
                0.999_999_94,
                1.0,
                1e30,
                -1e30,
                f32::NAN,
                f32::INFINITY,
                f32::NEG_INFINITY,
            ] {
                for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
                    let x = Axis::new(wrap, n).texels(u, n);
                    assert!(x.abs() < REACH, "{u} {wrap:?} -> {x}");
                }
            }
        }
        assert_eq!(Axis::new(Wrap::Repeat, 64).texels(65536.25 * 64.0, 64), 0.0);
        assert_eq!(Axis::new(Wrap::Repeat, 63).texels(65536.25, 63), 15.75);
        assert!(Axis::new(Wrap::Repeat, 63).texels(-1e-30, 63) < 63.0);
        assert_eq!(
            Axis::new(Wrap::MirroredRepeat, 63).texels(65537.25, 63),
            -0.75 * 63.0
        );
        assert_eq!(
            Axis::new(Wrap::MirroredRepeat, 63).texels(-0.1, 63),
            -0.1 * 63.0
        );
    }

    /// Coordinates on the borders of texels and a few bits beside them, in copies of the image to both sides: the texel is that of real
    /// numbers, counted in texels and in 256ths, on every width. Repeat rounds its own reduction below 0 and is judged from there on.
    #[test]
    fn no_texel_is_lost_to_a_rounded_product() {
        let mut coordinates = Vec::new();
        for n in [3, 130, 255, 1000, 32_767] {
            for k in (0..=n).step_by(1 + n as usize / 300) {
                for copy in [-3, -2, -1, 0, 1, 2, 5] {
                    let border = (f64::from(k) / f64::from(n) + f64::from(copy)) as f32;
                    let bits = border.to_bits();
                    let near = (bits.saturating_sub(2)..bits + 3).map(f32::from_bits);
                    coordinates.extend(near.map(|u| (n, u)));
                }
            }
        }
        let wrong = |found: &dyn Fn(Axis, i32, f32) -> i32| {
            let mut wrong = 0;
            for &(n, u) in &coordinates {
                let texel = (f64::from(u) * f64::from(n)).floor() as i32;
                for wrap in [
                    Wrap::Repeat,
                    Wrap::MirroredRepeat,
                    Wrap::ClampToEdge,
                    Wrap::ClampToBorder,
                    Wrap::MirrorClampToEdge,
                ] {
                    let axis = Axis::new(wrap, n);
                    let want = axis.far_index(Scalar, One(texel), One(n)).0;
                    let judged = wrap != Wrap::Repeat || u >= 0.0;
                    wrong += usize::from(judged && found(axis, n, u) != want);
                }
            }
            wrong
        };
        let index = |axis: Axis, n: i32, texel: i32| axis.index(Scalar, One(texel), One(n)).0;
        let level = texmap_math::Level::new();
        assert_eq!(wrong(&|axis, n, u| axis.nearest(u, n)), 0);
        for shift in [0, 8] {
            let units = |n: i32| (n << shift) as f32;
            let in_lanes = |axis: Axis, n: i32, u: f32| texmap_math::dispatch_simd!(level, i => first(i, axis, u, units(n), shift));
            assert_eq!(wrong(&|axis, n, u| index(axis, n, in_lanes(axis, n, u))), 0);
            // Negative twin: the floor of the rounded product.
            let rounded = |axis: Axis, n: i32, u: f32| {
                let x = axis.scale(Scalar, u, units(n), REACH * 256.0);
                index(axis, n, x.floor_to_i32().0 >> shift)
            };
            assert!(wrong(&rounded) > 100);
        }
        fn first<I: Isa>(i: I, axis: Axis, u: f32, units: f32, shift: u32) -> i32 {
            let texel = axis.texel(i, i.f32(u), i.f32(units), (shift, REACH * 256.0));
            let mut out = [0; 16];
            texel.store(&mut out[..I::LANES]);
            out[0]
        }
    }
}
