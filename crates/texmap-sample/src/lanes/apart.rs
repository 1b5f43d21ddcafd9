//! Texels that lanes cannot gather.

use crate::{
    encoded::Encoded,
    texels::{Chain, Format, Level},
};

/// Texels that are fetched one by one, counted through all levels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Apart<'a> {
    words: &'a [u32],
    format: Format,
    encoded: Option<&'a Encoded>,
    /// Texels that are encoded: those of level 0.
    kept: usize,
    last: usize,
}

impl<'a> Apart<'a> {
    pub(super) fn new(chain: &'a Chain<'_>) -> Self {
        let base = &chain.levels[0];
        let kept = match chain.encoded {
            Some(_) => base.width as usize * base.height as usize,
            None => 0,
        };
        let count = kept + chain.words().len() / chain.format.words();
        Self {
            words: chain.words(),
            format: chain.format,
            encoded: chain.encoded.as_ref(),
            kept,
            last: count.saturating_sub(1),
        }
    }

    pub(super) fn first_of(&self, level: &Level) -> usize {
        match level.offset {
            Level::ENCODED => 0,
            offset => self.kept + offset / self.format.words(),
        }
    }

    /// Unscaled texels, channel by channel; of those beyond the end, the last. One compiled form serves all filters and levels.
    #[inline(never)]
    pub(super) fn fetch(&self, at: &[u32; 16]) -> [[f32; 16]; 4] {
        let (words, kept) = (self.words, self.kept);
        // The kind of texel is asked once.
        match (self.encoded, self.format) {
            (Some(encoded), _) => self.each(at, |i| match i.checked_sub(kept) {
                None => encoded.decode(i),
                Some(i) => Format::Rgba16.fetch(words, 2 * i),
            }),
            (None, Format::Rgba32) => {
                let texels = words.as_chunks::<4>().0;
                self.each(at, |i| texels[i].map(f32::from_bits))
            }
            (None, format) => self.each(at, |i| format.fetch(words, i * format.words())),
        }
    }

    #[inline(always)]
    fn each(&self, at: &[u32; 16], texel: impl Fn(usize) -> [f32; 4]) -> [[f32; 16]; 4] {
        let mut out = [[0.0; 16]; 4];
        for (i, at) in at.iter().enumerate() {
            let [r, g, b, a] = texel((*at as usize).min(self.last));
            (out[0][i], out[1][i], out[2][i], out[3][i]) = (r, g, b, a);
        }
        out
    }
}
