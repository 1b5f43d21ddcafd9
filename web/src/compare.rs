//! The difference of two pictures: figures and a map of heat.

use texmap_render::{Aov, AovData, Frame};
use texmap_truth::Truth;
use texmap_truth::picture::Picture;
use texmap_truth::strip::heat;

use crate::answer::Answer;

/// Differences of a picture from the one that counts as right.
#[derive(Debug)]
pub(crate) struct Compared {
    map: Picture,
    /// Root mean square and largest difference of a channel, of 1.
    rmse: f64,
    most: f64,
    /// Largest and mean distance of the coordinates, texels.
    shift: Option<(f64, f64)>,
}

impl Compared {
    pub(crate) fn tell(&self, answer: &mut Answer, shift: Option<f64>, color: Option<f64>) {
        let mut figure = |name: &str, value, expected: Option<f64>, unit| match expected {
            Some(expected) => answer.expected(name, value, expected, unit),
            None => answer.figure(name, value, unit),
        };
        if let Some((most, mean)) = self.shift {
            figure("largest shift of the texture", most, shift, "texels");
            figure("mean shift of the texture", mean, None, "texels");
        }
        figure("RMSE of the colours", self.rmse, None, "of 1");
        figure("largest difference of a colour", self.most, color, "of 1");
        let name = match self.shift {
            Some(_) => "shift of the texture, white from a quarter on",
            None => "difference of the colours, white from a quarter on",
        };
        answer.picture(name, &self.map);
    }
}

/// Compares with a frame of the same size; shifts in texels of a texture of this width and height, where both have coordinates.
pub(crate) fn with_frame(drawn: &Frame, right: &Frame, texels: Option<[f64; 2]>) -> Compared {
    let codes = |frame: &Frame| frame.rgba.iter().map(|b| f64::from(*b)).collect::<Vec<_>>();
    let mut compared = of_codes((drawn.width, drawn.height), &codes(drawn), &codes(right));
    let shifts = texels.zip(uv(drawn).zip(uv(right)));
    if let Some((texels, (a, b))) = shifts {
        let (mut most, mut sum, mut count) = (0.0f64, 0.0, 0u32);
        let width = drawn.width;
        for (i, (a, b)) in a.chunks_exact(2).zip(b.chunks_exact(2)).enumerate() {
            let apart = [0, 1].map(|k| f64::from(a[k] - b[k]));
            let distance = length(apart);
            let shift = length([0, 1].map(|k| apart[k] * texels[k]));
            let at = (i64::from(i as u32 % width), i64::from(i as u32 / width));
            if distance.is_nan() {
                compared.map.set(at.0, at.1, [70, 74, 82, 255]);
                continue;
            }
            most = most.max(shift);
            sum += shift;
            count += 1;
            // A hundredth of a texel is rounding.
            let shown = if shift < 0.01 { 0.0 } else { distance };
            compared.map.set(at.0, at.1, heat(4.0 * shown));
        }
        compared.shift = Some((most, sum / f64::from(count.max(1))));
    }
    compared
}

/// Compares with the f64 reference.
pub(crate) fn with_truth(drawn: &Frame, truth: &Truth) -> Compared {
    let codes: Vec<f64> = drawn.rgba.iter().map(|b| f64::from(*b)).collect();
    of_codes((drawn.width, drawn.height), &codes, &truth.codes())
}

/// Compares code values of four channels, 0..=255.
fn of_codes((width, height): (u32, u32), drawn: &[f64], right: &[f64]) -> Compared {
    let mut map = Picture::new(width, height, [0, 0, 0, 255]);
    let (mut sum, mut most) = (0.0, 0.0f64);
    for (i, (a, b)) in drawn.chunks_exact(4).zip(right.chunks_exact(4)).enumerate() {
        let mut worst = 0.0f64;
        for (a, b) in a.iter().zip(b).take(3) {
            let difference = (a - b).abs() / 255.0;
            sum += difference * difference;
            worst = worst.max(difference);
        }
        most = most.max(worst);
        let (x, y) = (i as u32 % width, i as u32 / width);
        // Half a code is rounding.
        let shown = if worst * 255.0 <= 0.51 { 0.0 } else { worst };
        map.set(x.into(), y.into(), heat(4.0 * shown));
    }
    let channels = 3.0 * f64::from(width) * f64::from(height);
    Compared {
        map,
        rmse: (sum / channels.max(1.0)).sqrt(),
        most,
        shift: None,
    }
}

/// Without `hypot`, whose bits are those of the platform.
fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

fn uv(frame: &Frame) -> Option<&[f32]> {
    let found = frame.aovs.iter().find(|(aov, ..)| *aov == Aov::Uv);
    match found {
        Some((_, _, AovData::F32(values))) => Some(values),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One channel of one of two pixels is 51 of 255 off.
    #[test]
    fn figures_are_those_of_the_difference() {
        let right = [0.0; 8];
        let mut drawn = right;
        drawn[1] = 51.0;
        let compared = of_codes((2, 1), &drawn, &right);
        assert!((compared.most - 0.2).abs() < 1e-12);
        assert!((compared.rmse - (0.04f64 / 6.0).sqrt()).abs() < 1e-12);
        assert_eq!(of_codes((2, 1), &right, &right).rmse, 0.0);
    }
}
