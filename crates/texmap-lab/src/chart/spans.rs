//! Ways to interpolate a row of pixels that the product does not use, as plain loops that the compiler turns into
//! lanes at the best level of the machine.

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, dispatch};

/// A row of pixels: planes of u/w, v/w and 1/w along it. The value at pixel x is `start + step (x + 1/2)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) u: Plane,
    pub(super) v: Plane,
    pub(super) inv_w: Plane,
}

/// A line over the pixels of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) start: f32,
    pub(super) step: f32,
}

impl Plane {
    /// Through a value at each end of a row of `pixels`.
    pub(super) fn between(a: f64, b: f64, pixels: usize) -> Self {
        Self {
            start: a as f32,
            step: ((b - a) / pixels as f64) as f32,
        }
    }

    #[inline(always)]
    fn at(self, x: f32) -> f32 {
        self.start + self.step * x
    }
}

/// A method that fills a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// One IEEE divide a pixel.
    Divide,
    /// The divide in f64: as good as the truth.
    Double,
    /// A reciprocal from an integer subtraction (0x7ef311c7 - bits) and this many Newton steps, 1 to 3.
    Newton(u32),
    /// Linear over the whole row.
    Affine,
    /// Parabolas through three exact points, one to this many pixels.
    Quadratic(usize),
    /// u/w, v/w and 1/w summed along the row: no multiplication, and the rounding adds up.
    Stepped,
}

impl Method {
    pub(super) const ALL: [Self; 9] = [
        Self::Divide,
        Self::Affine,
        Self::Double,
        Self::Newton(1),
        Self::Newton(2),
        Self::Newton(3),
        Self::Quadratic(16),
        Self::Quadratic(64),
        Self::Stepped,
    ];

    pub(super) fn name(self) -> String {
        match self {
            Self::Divide => "row: divide".to_owned(),
            Self::Double => "row: divide in f64".to_owned(),
            Self::Newton(n) => format!("row: reciprocal, {n} Newton"),
            Self::Affine => "row: affine".to_owned(),
            Self::Quadratic(n) => format!("row: quadratic:{n}"),
            Self::Stepped => "row: stepped".to_owned(),
        }
    }

    /// Fills `u` and `v`, which have one length, at the best level.
    pub(super) fn fill(self, level: Level, row: &Row, u: &mut [f32], v: &mut [f32]) {
        dispatch!(level, s => s.vectorize(
            #[inline(always)]
            || self.fill_plain(row, u, v),
        ));
    }

    #[inline(always)]
    fn fill_plain(self, row: &Row, u: &mut [f32], v: &mut [f32]) {
        match self {
            Self::Divide => {
                for (x, (u, v)) in u.iter_mut().zip(v).enumerate() {
                    let x = x as u32 as f32 + 0.5;
                    let w = 1.0 / row.inv_w.at(x);
                    (*u, *v) = (row.u.at(x) * w, row.v.at(x) * w);
                }
            }
            Self::Double => {
                let at = |p: Plane, x: f64| f64::from(p.start) + f64::from(p.step) * x;
                for (x, (u, v)) in u.iter_mut().zip(v).enumerate() {
                    let x = f64::from(x as u32) + 0.5;
                    let w = 1.0 / at(row.inv_w, x);
                    (*u, *v) = ((at(row.u, x) * w) as f32, (at(row.v, x) * w) as f32);
                }
            }
            Self::Newton(1) => newton::<1>(row, u, v),
            Self::Newton(2) => newton::<2>(row, u, v),
            Self::Newton(_) => newton::<3>(row, u, v),
            Self::Affine => {
                // Exact at both ends, linear between them.
                let end = u.len() as u32 as f32;
                let line = |p: Plane| {
                    let (a, b) = (p.at(0.0) / row.inv_w.at(0.0), p.at(end) / row.inv_w.at(end));
                    Plane {
                        start: a,
                        step: (b - a) / end,
                    }
                };
                let (pu, pv) = (line(row.u), line(row.v));
                for (x, (u, v)) in u.iter_mut().zip(v).enumerate() {
                    let x = x as u32 as f32 + 0.5;
                    (*u, *v) = (pu.at(x), pv.at(x));
                }
            }
            Self::Quadratic(n) => {
                for (index, (u, v)) in u.chunks_mut(n).zip(v.chunks_mut(n)).enumerate() {
                    let (first, length) = ((index * n) as f32, u.len() as f32);
                    let exact = |x: f32| {
                        let w = 1.0 / row.inv_w.at(x);
                        [row.u.at(x) * w, row.v.at(x) * w]
                    };
                    let ends = [
                        exact(first),
                        exact(first + 0.5 * length),
                        exact(first + length),
                    ];
                    let parabola = |k: usize| {
                        let [a, m, b] = [ends[0][k], ends[1][k], ends[2][k]];
                        [a, 4.0 * m - 3.0 * a - b, 2.0 * a - 4.0 * m + 2.0 * b]
                    };
                    let (pu, pv, scale) = (parabola(0), parabola(1), 1.0 / length);
                    for (x, (u, v)) in u.iter_mut().zip(v).enumerate() {
                        let t = (x as u32 as f32 + 0.5) * scale;
                        *u = pu[0] + t * (pu[1] + t * pu[2]);
                        *v = pv[0] + t * (pv[1] + t * pv[2]);
                    }
                }
            }
            Self::Stepped => {
                let (mut nu, mut nv, mut d) = (row.u.at(0.5), row.v.at(0.5), row.inv_w.at(0.5));
                for (u, v) in u.iter_mut().zip(v) {
                    let w = 1.0 / d;
                    (*u, *v) = (nu * w, nv * w);
                    nu += row.u.step;
                    nv += row.v.step;
                    d += row.inv_w.step;
                }
            }
        }
    }
}

/// A count of steps that the compiler knows, or the loop is no lanes.
#[inline(always)]
fn newton<const STEPS: u32>(row: &Row, u: &mut [f32], v: &mut [f32]) {
    for (x, (u, v)) in u.iter_mut().zip(v).enumerate() {
        let x = x as u32 as f32 + 0.5;
        let d = row.inv_w.at(x);
        let mut w = f32::from_bits(0x7ef3_11c7_u32.wrapping_sub(d.to_bits()));
        for _ in 0..STEPS {
            w *= 2.0 - d * w;
        }
        (*u, *v) = (row.u.at(x) * w, row.v.at(x) * w);
    }
}

/// Pixels of hostile rows (w-ratios to 1e6 both ways) whose value is not finite or leaves the hull of the row's ends
/// by more than a thousandth of their range.
pub(super) fn failures(method: Method) -> Vec<String> {
    const PIXELS: usize = 256;
    let (mut bad, mut outside) = (0u32, 0u32);
    for ratio in [1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6f64] {
        let row = Row {
            u: Plane::between(0.0, 1024.0 / ratio, PIXELS),
            v: Plane::between(-512.0, 512.0 / ratio, PIXELS),
            inv_w: Plane::between(1.0, 1.0 / ratio, PIXELS),
        };
        let (mut u, mut v) = ([0.0f32; PIXELS], [0.0f32; PIXELS]);
        method.fill(Level::new(), &row, &mut u, &mut v);
        for (u, v) in u.into_iter().zip(v) {
            bad += u32::from(!(u.is_finite() && v.is_finite()));
            let off = (u - 512.0).abs().max(v.abs());
            outside += u32::from(off > 513.0);
        }
    }
    let mut out = Vec::new();
    if bad > 0 {
        out.push(format!("{bad} values that are not finite"));
    }
    if outside > 0 {
        out.push(format!("{outside} pixels outside the hull of the ends"));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_leaves_the_hull_and_a_divide_does_not() {
        assert!(!failures(Method::Quadratic(64)).is_empty());
        assert_eq!(failures(Method::Divide), [""; 0]);
        assert_eq!(failures(Method::Double), [""; 0]);
    }
}
