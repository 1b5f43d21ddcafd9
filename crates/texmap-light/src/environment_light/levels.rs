//! Levels of a cube in one word a texel, for look-ups by level.

use alloc::vec::Vec;

use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, One, Scalar};

use crate::environment::Environment;
use crate::environment::level::{Level, LevelTable};
use crate::lanes::Vector;
use crate::shared_exponent;

/// The texels of cubes, packed: the levels of one light.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Levels {
    table: LevelTable,
    count: usize,
    words: Vec<u32>,
}

impl Levels {
    /// The first levels of cubes. One that is missing reads as the next, the last ones as the last that there is.
    pub(super) fn new(first: &Environment, others: &[Option<&Environment>]) -> Self {
        let mut words = Vec::new();
        let made = core::iter::once(Some(first)).chain(others.iter().copied());
        let made = made.map(|environment| {
            let environment = environment?;
            let start = words.len();
            words.extend(environment.first_level().iter().map(shared_exponent::pack));
            let (width, height) = environment.size();
            Some(Level {
                width,
                height,
                start,
            })
        });
        let made: Vec<_> = made.collect();
        let mut next = made.iter().copied().rev().flatten().next();
        let levels = made.into_iter().rev().filter_map(|level| {
            next = level.or(next);
            next
        });
        let mut levels: Vec<Level> = levels.collect();
        levels.reverse();
        Self {
            table: LevelTable::new(&levels),
            count: levels.len(),
            words,
        }
    }

    /// Texels a side of level 0.
    pub(super) fn size(&self) -> u32 {
        self.table.width[0]
    }

    /// A texel of a face of level 0.
    pub(super) fn texel(&self, face: usize, x: u32, y: u32) -> [f32; 3] {
        let side = self.size() as usize + 2;
        let at = (face * side + y as usize + 1) * side + x as usize + 1;
        let word = self.words.get(at).copied().unwrap_or(0);
        shared_exponent::unpack(Scalar, One(word))
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    #[cfg(test)]
    pub(super) fn texels(&self) -> usize {
        self.words.len()
    }

    /// True if level 0 is that of the other.
    pub(super) fn has_first_level_of(&self, other: &Self) -> bool {
        let side = self.size() as usize + 2;
        let first = 0..6 * side * side;
        self.size() == other.size() && self.words.get(first.clone()) == other.words.get(first)
    }

    /// Bilinear on the levels around `lod`, within 0 to the last. Zero and non-finite directions read as +Z.
    #[inline(always)]
    pub(super) fn radiance<I: Isa>(&self, i: I, lod: I::F32, direction: Vector<I>) -> Vector<I> {
        match GatherTable::new(&self.words) {
            Some(words) => self.table.level_lanes(i, words, lod, direction),
            None => [i.f32(1.0); 3],
        }
    }

    /// Bilinear on the first level and, if it is asked for, on the second of the same size, else the first again.
    #[inline(always)]
    pub(super) fn first_two<I: Isa>(
        &self,
        i: I,
        direction: Vector<I>,
        second: bool,
    ) -> [Vector<I>; 2] {
        match GatherTable::new(&self.words) {
            Some(words) => self.table.first_two_lanes(i, words, direction, second),
            None => [[i.f32(1.0); 3]; 2],
        }
    }
}
