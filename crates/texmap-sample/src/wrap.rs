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
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Brings a coordinate into the few periods where the integer wrap is one compare away.
/// The range reduction comes before the scaling by the size, so that `u = 65536.25` loses nothing.
pub(crate) fn reduce(u: f32, wrap: Wrap) -> f32 {
    match wrap {
        Wrap::Repeat => fraction(u),
        Wrap::MirroredRepeat => 2.0 * fraction(0.5 * u),
        // Wide kernels still reach the image from outside, so the coordinate is only kept small.
        Wrap::ClampToEdge | Wrap::ClampToBorder | Wrap::MirrorClampToEdge => clamp(u),
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

/// Texel of index `i` on an axis of `n` texels. `i` comes from a [`reduce`]d coordinate with taps at
/// most two texels away, but any `i32` is handled.
pub(crate) fn index(i: i32, n: i32, wrap: Wrap) -> i32 {
    match wrap {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integer_wraps_follow_the_definitions() {
        let n = 3;
        let expect = |wrap, list: [i32; 13]| {
            for (k, want) in list.into_iter().enumerate() {
                assert_eq!(
                    index(k as i32 - 6, n, wrap),
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
    fn reduction_stays_inside_and_survives_anything() {
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
            let f = reduce(u, Wrap::Repeat);
            assert!((0.0..1.0).contains(&f), "{u} -> {f}");
            let f = reduce(u, Wrap::MirroredRepeat);
            assert!((0.0..2.0).contains(&f), "{u} -> {f}");
            let f = reduce(u, Wrap::ClampToEdge);
            assert!((-64.0..=65.0).contains(&f), "{u} -> {f}");
        }
        assert_eq!(reduce(65536.25, Wrap::Repeat), 0.25);
        assert!(reduce(-1e-30, Wrap::Repeat) * 63.0 < 63.0);
    }
}
