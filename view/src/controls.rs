//! The methods that keys choose, and the buffer of the window.

use minifb::Key;
use texmap_io::scene_file::words;
use texmap_raster::Interp;
use texmap_render::{Aov, AovData, Frame};
use texmap_sample::{Filter, Wrap};

const FILTERS: [Filter; 5] = [
    Filter::Nearest,
    Filter::Bilinear,
    Filter::Trilinear,
    Filter::Anisotropic(16),
    Filter::ewa(16),
];
const INTERPS: [Interp; 4] = [
    Interp::Perspective,
    Interp::Affine,
    Interp::Subdivided(4),
    Interp::Span(16),
];
const WRAPS: [Wrap; 5] = [
    Wrap::Repeat,
    Wrap::MirroredRepeat,
    Wrap::ClampToEdge,
    Wrap::ClampToBorder,
    Wrap::MirrorClampToEdge,
];
const AOVS: [Aov; 6] = [
    Aov::Depth,
    Aov::Uv,
    Aov::Lod,
    Aov::Face,
    Aov::Normal,
    Aov::Position,
];

/// Overrides of the file; 0 keeps the file's own.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Methods {
    filter: usize,
    interp: usize,
    wrap: usize,
    aov: usize,
    samples: usize,
    /// Draw the edges of triangles.
    pub(crate) lines: bool,
}

impl Methods {
    /// Takes a key; true if it chose something.
    pub(crate) fn key(&mut self, key: Key) -> bool {
        let next = |choice: &mut usize, count: usize| *choice = (*choice + 1) % (count + 1);
        match key {
            Key::F => next(&mut self.filter, FILTERS.len()),
            Key::I => next(&mut self.interp, INTERPS.len()),
            Key::T => next(&mut self.wrap, WRAPS.len()),
            Key::O => next(&mut self.aov, AOVS.len()),
            Key::M => next(&mut self.samples, 2),
            Key::L => self.lines = !self.lines,
            _ => return false,
        }
        true
    }

    pub(crate) fn filter(&self) -> Option<Filter> {
        chosen(&FILTERS, self.filter)
    }

    pub(crate) fn interp(&self) -> Option<Interp> {
        chosen(&INTERPS, self.interp)
    }

    pub(crate) fn wrap(&self) -> Option<Wrap> {
        chosen(&WRAPS, self.wrap)
    }

    /// Samples of a pixel: those of `texmap render` unless chosen.
    pub(crate) fn msaa(&self, is_scene: bool) -> u32 {
        chosen(&[1, 4], self.samples).unwrap_or(if is_scene { 1 } else { 4 })
    }

    pub(crate) fn aovs(&self) -> Vec<Aov> {
        let shown = chosen(&AOVS, self.aov);
        let depth = self
            .lines
            .then_some(Aov::Depth)
            .filter(|depth| shown != Some(*depth));
        shown.into_iter().chain(depth).collect()
    }

    /// The choices in words, for the title.
    pub(crate) fn words(&self) -> String {
        let filter = self
            .filter()
            .and_then(words::filter)
            .unwrap_or_else(|| "the file's filter".into());
        let interp = self
            .interp()
            .map_or_else(|| "the file's interpolation".into(), words::interp);
        let aov = chosen(&AOVS, self.aov).map_or("picture", Aov::name);
        format!("{filter} · {interp} · {aov}")
    }

    /// The pixels of the window, 0x00RRGGBB: the picture over grey, or the chosen array.
    pub(crate) fn shown(&self, frame: &Frame) -> Vec<u32> {
        let array = chosen(&AOVS, self.aov)
            .and_then(|aov| frame.aovs.iter().find(|(kind, ..)| *kind == aov));
        match array {
            Some((aov, channels, data)) => colors(*aov, *channels, data),
            None => frame.rgba.chunks_exact(4).map(over_grey).collect(),
        }
    }
}

fn chosen<T: Copy>(all: &[T], choice: usize) -> Option<T> {
    choice.checked_sub(1).and_then(|i| all.get(i)).copied()
}

fn over_grey(pixel: &[u8]) -> u32 {
    let alpha = u32::from(pixel[3]);
    let channel = |c: u8| (u32::from(c) * alpha + 128 * (255 - alpha) + 127) / 255;
    channel(pixel[0]) << 16 | channel(pixel[1]) << 8 | channel(pixel[2])
}

/// Up to three channels as red, green and blue, each from its least to its largest value; ids as colours that differ.
fn colors(aov: Aov, channels: usize, data: &AovData) -> Vec<u32> {
    const HOLE: u32 = 0x0028_2a30;
    match data {
        AovData::U32(ids) => {
            let tint = |id: &u32| {
                if *id == u32::MAX {
                    HOLE
                } else {
                    id.wrapping_mul(0x9e37_79b1) >> 8 | 0x0040_4040
                }
            };
            ids.iter().map(tint).collect()
        }
        AovData::F32(values) => {
            let range = |channel: usize| {
                let finite = values
                    .iter()
                    .skip(channel)
                    .step_by(channels)
                    .filter(|v| v.is_finite());
                finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), v| {
                    (a.min(*v), b.max(*v))
                })
            };
            let ranges: Vec<(f32, f32)> = (0..channels).map(range).collect();
            let byte = |v: f32, (low, high): (f32, f32)| match aov {
                Aov::Normal => (127.5 * v + 127.5) as u32,
                Aov::Uv => ((v - v.floor()) * 255.0) as u32,
                _ => ((v - low) / (high - low).max(f32::MIN_POSITIVE) * 255.0) as u32,
            };
            let pixel = |pixel: &[f32]| {
                if pixel.iter().any(|v| v.is_nan()) {
                    return HOLE;
                }
                let at = |i: usize| {
                    byte(pixel[i.min(channels - 1)], ranges[i.min(channels - 1)]).min(255)
                };
                match channels {
                    2 => at(0) << 16 | at(1) << 8 | 0x40,
                    _ => at(0) << 16 | at(1) << 8 | at(2),
                }
            };
            values.chunks_exact(channels).map(pixel).collect()
        }
    }
}

/// Hash of the window's buffer, as `texmap hash` computes it of red, green, blue and an opaque alpha.
pub(crate) fn hash(buffer: &[u32], (width, height): (u32, u32)) -> String {
    let bytes: Vec<u8> = buffer
        .iter()
        .flat_map(|p| [(p >> 16) as u8, (p >> 8) as u8, *p as u8, 255])
        .collect();
    texmap_render::hash_pixels(width, height, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_go_round_and_others_do_nothing() {
        let mut methods = Methods::default();
        assert_eq!(methods.filter(), None);
        for filter in FILTERS {
            assert!(methods.key(Key::F));
            assert_eq!(methods.filter(), Some(filter));
        }
        methods.key(Key::F);
        assert_eq!(methods.filter(), None);
        assert!(!methods.key(Key::Z));
    }

    #[test]
    fn clear_pixels_are_grey() {
        assert_eq!(over_grey(&[255, 0, 0, 255]), 0x00ff_0000);
        assert_eq!(over_grey(&[255, 0, 0, 0]), 0x0080_8080);
    }
}
