//! Structural similarity of two images: do they show the same structures, whatever their mean difference.

use texmap_math::parallel;

use crate::metrics::Shape;

/// Values of the window along an axis.
const WINDOW: usize = 11;

/// The window of Wang et al.: a Gaussian of 1.5 pixels standard deviation, cut at 5 pixels, of sum one.
const WEIGHTS: [f64; WINDOW] = [
    0.001_028_380_084_479_11,
    0.007_598_758_135_239_185,
    0.036_000_772_128_430_83,
    0.109_360_689_509_700_02,
    0.213_005_537_711_253_7,
    0.266_011_724_861_794_36,
    0.213_005_537_711_253_7,
    0.109_360_689_509_700_02,
    0.036_000_772_128_430_83,
    0.007_598_758_135_239_185,
    0.001_028_380_084_479_11,
];

/// Rows of a thread's share.
const BAND: usize = 64;

/// Mean structural similarity over all windows of 11 x 11 pixels inside the image and over `channels`. 1 for equal images, about
/// 0 for unlike ones. Source: Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment: from error visibility to structural
/// similarity", 2004. `pair` gives both values at an index, `peak` is the range of the values (L of the paper).
///
/// Windows that hold a value that is not finite do not count. `None` for images narrower or lower than a window, and where no window
/// counts. The same bits on any number of threads.
pub fn ssim(
    shape: Shape,
    channels: usize,
    peak: f64,
    pair: impl Fn(usize) -> (f64, f64) + Sync,
) -> Option<f64> {
    let (width, height) = (shape.width, shape.height);
    if width < WINDOW || height < WINDOW || channels == 0 {
        return None;
    }
    // Equal images of nothing but 0 are alike too.
    let range = if peak > 0.0 { peak } else { 1.0 };
    let windows = height - (WINDOW - 1);
    let bands = parallel::map(0..channels * windows.div_ceil(BAND), |i| {
        let (channel, first) = (i % channels, i / channels * BAND);
        let rows = first..windows.min(first + BAND);
        let at = |x: usize, y: usize| pair((y * width + x) * shape.channels + channel);
        band(width, rows, range, at)
    });
    let (sum, count) = bands
        .iter()
        .fold((0.0, 0), |(sum, count), (s, c)| (sum + s, count + c));
    (count > 0).then(|| sum / count as f64)
}

/// Sum and number of the windows whose first rows are these.
///
/// With s = x + y and d = x - y the means and variances of s and d hold all that the formula asks for:
/// 2 mx my = (ms^2 - md^2) / 2, mx^2 + my^2 = (ms^2 + md^2) / 2, and the same for covariance and variances.
fn band(
    width: usize,
    rows: std::ops::Range<usize>,
    range: f64,
    at: impl Fn(usize, usize) -> (f64, f64),
) -> (f64, u64) {
    let across = width - (WINDOW - 1);
    let alike = |y: usize| {
        let mut pairs = (0..width).map(|x| at(x, y));
        pairs.all(|(a, b)| a == b && a.is_finite())
    };
    if (rows.start..rows.end + WINDOW - 1).all(alike) {
        let count = rows.len() * across;
        return (count as f64, count as u64);
    }
    let (c1, c2) = ((0.01 * range).powi(2), (0.03 * range).powi(2));
    // Rows of s, d, s^2 and d^2 blurred along the row, the last eleven of them.
    let mut blurred = vec![[const { Vec::new() }; 4]; WINDOW];
    let mut plain: [Vec<f64>; 4] = [const { Vec::new() }; 4];
    let mut means: [Vec<f64>; 4] = [const { Vec::new() }; 4];
    let (mut sum, mut count) = (0.0, 0);
    for y in rows.start..rows.end + WINDOW - 1 {
        plain.iter_mut().for_each(Vec::clear);
        for x in 0..width {
            let (a, b) = at(x, y);
            let (s, d) = (a + b, a - b);
            for (row, value) in plain.iter_mut().zip([s, d, s * s, d * d]) {
                row.push(value);
            }
        }
        for (row, out) in plain.iter().zip(&mut blurred[y % WINDOW]) {
            weighted(out, across, |k| &row[k..]);
        }
        if y + 1 < rows.start + WINDOW {
            continue;
        }
        let first = y + 1 - WINDOW;
        for (moment, out) in means.iter_mut().enumerate() {
            weighted(out, across, |k| &blurred[(first + k) % WINDOW][moment]);
        }
        let [s, d, ss, dd] = &means;
        for (((s, d), ss), dd) in s.iter().zip(d).zip(ss).zip(dd) {
            let (s2, d2) = (s * s, d * d);
            let (vs, vd) = (ss - s2, dd - d2);
            let light = (0.5 * (s2 - d2) + c1) / (0.5 * (s2 + d2) + c1);
            let structure = (0.5 * (vs - vd) + c2) / (0.5 * (vs + vd) + c2);
            let value = light * structure;
            if value.is_finite() {
                sum += value;
                count += 1;
            }
        }
    }
    (sum, count)
}

/// The weighted sum of eleven rows, of as many values as asked for: rows of equal weight first.
fn weighted<'a>(out: &mut Vec<f64>, count: usize, row: impl Fn(usize) -> &'a [f64]) {
    let rows: [&[f64]; WINDOW] = std::array::from_fn(|k| &row(k)[..count]);
    let [a, b, c, d, e, f, g, h, i, j, k] = rows;
    let [w0, w1, w2, w3, w4, w5, ..] = WEIGHTS;
    out.clear();
    out.extend((0..count).map(|x| {
        let near = w5 * f[x] + w4 * (e[x] + g[x]) + w3 * (d[x] + h[x]);
        near + w2 * (c[x] + i[x]) + w1 * (b[x] + j[x]) + w0 * (a[x] + k[x])
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape = Shape {
        width: 40,
        height: 80,
        channels: 3,
    };

    /// Values of a wave with an edge and some noise.
    fn wave() -> Vec<f64> {
        let mut seed = 7_u32;
        (0..40 * 80 * 3)
            .map(|i| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let (x, y) = ((i / 3 % 40) as f64, (i / 120) as f64);
                let noise = f64::from(seed >> 16) / 65536.0;
                let edge = if x + y > 60.0 { 0.5 } else { 0.0 };
                0.2 * (x * 0.7).sin().abs() + edge + 0.25 * noise
            })
            .collect()
    }

    /// The formula as it is printed, window by window.
    fn printed(a: &[f64], b: &[f64], range: f64) -> f64 {
        let gauss = |k: usize| (-(k as f64 - 5.0).powi(2) / 4.5).exp();
        let total: f64 = (0..11).map(gauss).sum();
        let (c1, c2) = ((0.01 * range).powi(2), (0.03 * range).powi(2));
        let (mut sum, mut count) = (0.0, 0.0);
        for (x0, y0, channel) in
            (0..3).flat_map(|c| (0..70).flat_map(move |y| (0..30).map(move |x| (x, y, c))))
        {
            let mean = |f: &dyn Fn(usize) -> f64| {
                let mut sum = 0.0;
                for (i, j) in (0..11).flat_map(|j| (0..11).map(move |i| (i, j))) {
                    let weight = gauss(i) * gauss(j) / (total * total);
                    sum += weight * f(((y0 + j) * 40 + x0 + i) * 3 + channel);
                }
                sum
            };
            let (ma, mb) = (mean(&|i| a[i]), mean(&|i| b[i]));
            let va = mean(&|i| (a[i] - ma).powi(2));
            let vb = mean(&|i| (b[i] - mb).powi(2));
            let cov = mean(&|i| (a[i] - ma) * (b[i] - mb));
            sum += (2.0 * ma * mb + c1) * (2.0 * cov + c2)
                / ((ma * ma + mb * mb + c1) * (va + vb + c2));
            count += 1.0;
        }
        sum / count
    }

    #[test]
    fn it_is_the_printed_formula() {
        let a = wave();
        let blurred: Vec<f64> = (0..a.len())
            .map(|i| 0.5 * (a[i] + a[(i + 3) % a.len()]))
            .collect();
        let inverse: Vec<f64> = a.iter().map(|v| 1.0 - v).collect();
        for b in [&blurred, &inverse] {
            let found = ssim(SHAPE, 3, 1.0, |i| (a[i], b[i])).unwrap();
            let expected = printed(&a, b, 1.0);
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        assert_eq!(ssim(SHAPE, 3, 1.0, |i| (a[i], a[i])), Some(1.0));
        // The unit of the values does not matter.
        let one = ssim(SHAPE, 3, 1.0, |i| (a[i], blurred[i])).unwrap();
        let large = ssim(SHAPE, 3, 200.0, |i| (200.0 * a[i], 200.0 * blurred[i])).unwrap();
        assert!((one - large).abs() < 1e-9);
    }

    #[test]
    fn holes_cost_their_windows_and_small_images_have_none() {
        let a = wave();
        // The values that differ lie under a hole.
        let b = |i: usize| if i == 4000 { f64::NAN } else { a[i] };
        assert_eq!(ssim(SHAPE, 3, 1.0, |i| (a[i], b(i))), Some(1.0));
        assert_eq!(ssim(SHAPE, 3, 1.0, |_| (f64::NAN, 0.0)), None);
        assert_eq!(ssim(SHAPE, 3, 0.0, |_| (0.0, 0.0)), Some(1.0));
        let small = Shape { width: 10, ..SHAPE };
        assert_eq!(ssim(small, 3, 1.0, |i| (a[i], a[i])), None);
    }
}
