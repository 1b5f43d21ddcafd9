//! Arrays beside a picture as colours.

use texmap_render::{Aov, AovData, Frame};
use texmap_truth::picture::{Picture, Rgba};
use texmap_truth::strip::heat;

const HOLE: Rgba = [40, 42, 48, 255];

/// An array of a frame as colours: directions and coordinates as red, green and blue, numbers as heat from the least to the
/// largest, ids as colours that differ. `None` if the frame lacks it.
pub(crate) fn picture(frame: &Frame, aov: Aov) -> Option<Picture> {
    let (_, channels, data) = frame.aovs.iter().find(|(kind, ..)| *kind == aov)?;
    let (width, channels) = (frame.width, *channels);
    let at = |x: u32, y: u32| (y * width + x) as usize * channels;
    Some(match data {
        AovData::U32(ids) => Picture::from_fn(width, frame.height, |x, y| match ids[at(x, y)] {
            u32::MAX => HOLE,
            id => tint(id),
        }),
        AovData::F32(values) => {
            let finite = || values.iter().copied().filter(|v| v.is_finite());
            let (low, high) = finite().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), v| {
                (a.min(v), b.max(v))
            });
            let share =
                |v: f32| f64::from(v - low) / f64::from((high - low).max(f32::MIN_POSITIVE));
            let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
            Picture::from_fn(width, frame.height, |x, y| {
                let pixel = &values[at(x, y)..at(x, y) + channels];
                match (aov, pixel) {
                    (_, pixel) if pixel.iter().any(|v| v.is_nan()) => HOLE,
                    (Aov::Normal, [x, y, z]) => {
                        let [r, g, b] = [*x, *y, *z].map(|c| byte(0.5 * c + 0.5));
                        [r, g, b, 255]
                    }
                    (Aov::Uv, [u, v]) => [byte(u - u.floor()), byte(v - v.floor()), 64, 255],
                    (_, [r, g, b]) => {
                        let [r, g, b] = [*r, *g, *b].map(|c| byte(share(c) as f32));
                        [r, g, b, 255]
                    }
                    (_, [r, g, b, _]) => [byte(*r), byte(*g), byte(*b), 255],
                    (_, pixel) => heat(share(pixel.first().copied().unwrap_or(low))),
                }
            })
        }
    })
}

/// A colour for an id: the golden angle around the circle of hues.
fn tint(id: u32) -> Rgba {
    let hue = f64::from(id) * 0.618_033_988_749_895 % 1.0 * 6.0;
    let channel = |shift: f64| {
        let h = (hue + shift) % 6.0;
        let level = (h - 3.0).abs().clamp(1.0, 2.0) - 1.0;
        (70.0 + 170.0 * level) as u8
    };
    [channel(0.0), channel(4.0), channel(2.0), 255]
}
