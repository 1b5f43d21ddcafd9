//! Pictures of a difference: `expected | difference | actual` for a failing golden test, and a heat map.

use crate::picture::{Picture, Rgba};

/// Pixels between the parts of a strip.
const GAP: u32 = 8;
const GAP_COLOR: Rgba = [128, 128, 128, 255];

/// The two pictures side by side with their difference between them. Pictures of unlike size are aligned at
/// the top left; a pixel that only one of them has counts as the largest difference.
pub fn strip(expected: &Picture, actual: &Picture) -> Picture {
    let width = expected.width().max(actual.width());
    let height = expected.height().max(actual.height());
    let mut out = Picture::new(width * 3 + GAP * 2, height, GAP_COLOR);
    let step = i64::from(width + GAP);
    out.blit(0, 0, expected);
    out.blit(step, 0, &difference(expected, actual));
    out.blit(2 * step, 0, actual);
    out
}

/// The difference of two pictures as heat: black where they are equal, then through red and yellow to white
/// with the largest difference of a channel. One code value is already well visible.
pub fn difference(expected: &Picture, actual: &Picture) -> Picture {
    let width = expected.width().max(actual.width());
    let height = expected.height().max(actual.height());
    let mut out = Picture::new(width, height, [0, 0, 0, 255]);
    let inside =
        |p: &Picture, x: i64, y: i64| x < i64::from(p.width()) && y < i64::from(p.height());
    for y in 0..i64::from(height) {
        for x in 0..i64::from(width) {
            let (e, a) = (expected.get(x, y), actual.get(x, y));
            let both = inside(expected, x, y) && inside(actual, x, y);
            let most = e
                .iter()
                .zip(a)
                .map(|(&e, a)| e.abs_diff(a))
                .max()
                .unwrap_or(0);
            out.set(x, y, heat(if both { f64::from(most) / 255.0 } else { 1.0 }));
        }
    }
    out
}

/// Colour of a value in 0..=1: 0 is black, every other value at least dark red, 1 is white. Values outside
/// are clamped; NaN is magenta.
pub fn heat(value: f64) -> Rgba {
    if value.is_nan() {
        return [255, 0, 255, 255];
    }
    if value <= 0.0 {
        return [0, 0, 0, 255];
    }
    let level = (0.2 + 0.8 * value.min(1.0).sqrt()) * 3.0;
    let ramp = |from: f64| ((level - from).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    [ramp(0.0), ramp(1.0), ramp(2.0), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_have_a_black_middle() {
        let a = Picture::new(3, 2, [10, 20, 30, 255]);
        let s = strip(&a, &a);
        assert_eq!((s.width(), s.height()), (3 * 3 + 16, 2));
        assert_eq!(s.get(0, 0), [10, 20, 30, 255]);
        assert_eq!(s.get(3 + 8, 1), [0, 0, 0, 255]);
        assert_eq!(s.get(2 * (3 + 8), 1), [10, 20, 30, 255]);
    }

    #[test]
    fn one_code_value_and_another_size_are_seen() {
        let a = Picture::new(3, 2, [10, 20, 30, 255]);
        let mut b = Picture::new(4, 2, [10, 20, 30, 255]);
        b.set(1, 1, [11, 20, 30, 255]);
        let d = difference(&a, &b);
        assert!(d.get(1, 1)[0] > 100, "{:?}", d.get(1, 1));
        assert_eq!(d.get(3, 0), [255, 255, 255, 255]);
        assert_eq!(d.get(0, 0), [0, 0, 0, 255]);
    }

    #[test]
    fn heat_rises_and_marks_nan() {
        let sums: Vec<u32> = (0..=100)
            .map(|i| {
                heat(f64::from(i) / 100.0)[..3]
                    .iter()
                    .map(|&c| u32::from(c))
                    .sum()
            })
            .collect();
        assert!(sums.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(heat(2.0), [255, 255, 255, 255]);
        assert_eq!(heat(f64::NAN), [255, 0, 255, 255]);
    }
}
