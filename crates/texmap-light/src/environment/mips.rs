//! Mip levels of an environment, for look-ups that know their footprint.

use alloc::vec::Vec;

use super::Environment;
use super::level::{Level, LevelTable, bordered};
use crate::packed;

impl Environment {
    /// The environment with mip levels down to a height of 1. Each texel is the mean of four of the level before. Look-ups that know
    /// their footprint ([`radiance_filtered`](Self::radiance_filtered)) read the levels.
    ///
    /// If all texels are whole multiples of 1/1020 from 0 to 1, as raw 8-bit values are, the look-ups read a packed form with that
    /// step: the smaller levels, and the borders, are off by up to 1/2040.
    #[must_use]
    pub fn with_mips(mut self) -> Self {
        self.levels.truncate(1);
        let (width, height) = self.size();
        self.texels
            .truncate(self.layout.faces() * (width as usize + 2) * (height as usize + 2));
        let exact = self.inner_texels().all(packed::holds);
        let mut above = self.levels[0];
        while above.height > 1 {
            let (width, height) = (above.width / 2, above.height / 2);
            let mut inner =
                Vec::with_capacity(self.layout.faces() * width as usize * height as usize);
            for face in 0..self.layout.faces() {
                for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    let at = |dx: usize, dy: usize| {
                        let (x, y) = (2 * x as usize + 1 + dx, 2 * y as usize + 1 + dy);
                        self.texels[above.index(face, x, y)]
                    };
                    let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
                    inner.push([0, 1, 2].map(|i| ((a[i] + b[i]) + (c[i] + d[i])) * 0.25));
                }
            }
            above = Level {
                width,
                height,
                start: self.texels.len(),
            };
            self.levels.push(above);
            self.texels
                .extend(bordered(self.layout, (width, height), &inner));
        }
        self.table = LevelTable::new(&self.levels);
        self.packed.clear();
        if exact {
            self.packed.extend(self.texels.iter().map(packed::pack));
        }
        self
    }

    /// The texels of level 0 without borders.
    pub(super) fn inner_texels(&self) -> impl Iterator<Item = &[f32; 3]> {
        let (width, height) = self.size();
        let (w, h) = (width as usize + 2, height as usize + 2);
        let faces = self.texels.chunks_exact(w * h).take(self.layout.faces());
        let rows = faces.flat_map(move |face| face.chunks_exact(w).skip(1).take(h - 2));
        rows.flat_map(move |row| &row[1..w - 1])
    }
}
