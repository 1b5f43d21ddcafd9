use texmap_math::float;

/// What happens to coordinates outside `[0, 1)`, per axis.
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
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) wrap: Wrap,
    /// Repeat over a power of two: scaling is exact, so it comes first and the wrap is a mask.
    pub(crate) scaled_first: bool,
}

impl Axis {
    /// `n` is the side of level 0; all levels of a power of two are powers of two.
    pub(crate) fn new(wrap: Wrap, n: i32) -> Self {
        Self {
            wrap,
            scaled_first: wrap == Wrap::Repeat && n.count_ones() == 1,
        }
    }

    /// [`Axis::index`] of an index and the next.
    #[inline(always)]
    pub(crate) fn pair(self, i: i32, n: i32) -> [i32; 2] {
        if self.scaled_first {
            [i & (n - 1), (i + 1) & (n - 1)]
        } else if i >= 0 && i + 1 < n {
            // Inside, every wrap leaves an index as it is.
            [i, i + 1]
        } else {
            [self.index(i, n), self.index(i + 1, n)]
        }
    }

    /// The coordinate in texels of a level of `n`, whose floor is a texel for [`Axis::index`]. Unless
    /// scaling is exact, the range reduction comes before it, so that `u = 65536.25` loses nothing.
    #[inline(always)]
    pub(crate) fn place(self, u: f32, n: i32) -> f32 {
        if self.scaled_first {
            let x = u * n as f32;
            if x.abs() < REACH {
                return x;
            }
        }
        match self.wrap {
            Wrap::Repeat => fraction(u) * n as f32,
            Wrap::MirroredRepeat => centred(u) * n as f32,
            // Wide kernels still reach the image from outside, so the coordinate is only kept small.
            Wrap::ClampToEdge | Wrap::ClampToBorder | Wrap::MirrorClampToEdge => {
                clamp(u) * n as f32
            }
        }
    }

    /// Texel of an index on an axis of `n` texels; [`OUTSIDE`] a border.
    pub(crate) fn index(self, i: i32, n: i32) -> i32 {
        match self.wrap {
            Wrap::Repeat if self.scaled_first => i & (n - 1),
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::MirroredRepeat => {
                let m = i.rem_euclid(2 * n);
                if m < n { m } else { 2 * n - 1 - m }
            }
            Wrap::ClampToEdge => i.clamp(0, n - 1),
            Wrap::ClampToBorder => {
                if i < 0 || i >= n {
                    OUTSIDE
                } else {
                    i
                }
            }
            Wrap::MirrorClampToEdge => (if i < 0 { -1 - i } else { i }).min(n - 1),
        }
    }
}

/// `u - floor(u)` in `[0, 1)`; NaN and infinities give 0.
fn fraction(u: f32) -> f32 {
    let f = u - float::floor_f32(u);
    // The negated test also catches NaN.
    #[allow(
        clippy::neg_cmp_op_on_partial_ord,
        reason = "NaN must take the first branch"
    )]
    if !(f > 0.0) {
        0.0
    } else if f > BELOW_ONE {
        BELOW_ONE
    } else {
        f
    }
}

/// `u` less the even number next to it, in `[-1, 1]`: a coordinate of the image (from 0 on) or of its mirror image (below 0). Exact, so
/// that a mirrored image keeps every bit of the coordinate; NaN and infinities give 0.
fn centred(u: f32) -> f32 {
    let half = u * 0.5;
    let whole = float::floor_f32(half);
    // Beyond 2^24 all numbers are even.
    if half.abs() < 8_388_608.0 {
        let nearest = if half - whole >= 0.5 {
            whole + 1.0
        } else {
            whole
        };
        u - 2.0 * nearest
    } else {
        0.0
    }
}

/// To `[-64, 65]`, past the reach of any kernel on any level; NaN gives 0.
fn clamp(u: f32) -> f32 {
    if u > 65.0 {
        65.0
    } else if u > -64.0 {
        u
    } else if u.is_nan() {
        0.0
    } else {
        -64.0
    }
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
                    Axis::new(wrap, n).index(k as i32 - 6, n),
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
                    let x = Axis::new(wrap, n).place(u, n);
                    assert!(x.abs() < REACH, "{u} {wrap:?} -> {x}");
                }
            }
        }
        assert_eq!(Axis::new(Wrap::Repeat, 64).place(65536.25 * 64.0, 64), 0.0);
        assert_eq!(Axis::new(Wrap::Repeat, 63).place(65536.25, 63), 15.75);
        assert!(Axis::new(Wrap::Repeat, 63).place(-1e-30, 63) < 63.0);
        let mirrored = Axis::new(Wrap::MirroredRepeat, 63);
        assert_eq!(mirrored.place(65537.25, 63), -0.75 * 63.0);
        assert_eq!(mirrored.place(-0.1, 63), -0.1 * 63.0);
    }
}
