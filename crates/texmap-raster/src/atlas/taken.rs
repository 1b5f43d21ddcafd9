//! Texels that no later face can have, skipped where many faces lie on each other.

use alloc::vec::Vec;
use core::ops::Range;

/// Rows of texels with, for each, a jump to one further right that may be free (Tarjan 1975, disjoint sets with halved paths).
pub(super) struct Taken {
    width: usize,
    /// For each texel itself, or one further right in its row; at most `width` away from the row's start.
    next: Vec<u32>,
}

/// The answer of a visit to a texel.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Visited {
    /// No later face can have the texel.
    Taken,
    /// The texel stays, and the row is done.
    Last,
}

impl Taken {
    /// With all texels free.
    pub(super) fn new(width: usize, rows: usize) -> Self {
        let row = 0..width as u32;
        let next = (0..rows).flat_map(|_| row.clone()).collect();
        Self { width, next }
    }

    /// Visits the texels of a part of a row that are not taken, from the left, by their index.
    pub(super) fn visit(
        &mut self,
        row: usize,
        part: &Range<i32>,
        mut visit: impl FnMut(usize) -> Visited,
    ) {
        let from = row * self.width;
        let end = (part.end.max(0) as usize).min(self.width);
        let row = &mut self.next[from..from + self.width];
        let mut x = free(row, part.start.max(0) as usize);
        while x < end {
            if visit(from + x) == Visited::Last {
                return;
            }
            row[x] = x as u32 + 1;
            x = free(row, x + 1);
        }
    }
}

/// The first free texel of a row from one on, or its end.
fn free(row: &mut [u32], mut x: usize) -> usize {
    while let Some(next) = row.get(x).map(|next| *next as usize) {
        if next == x {
            break;
        }
        let after = row.get(next).map_or(next, |after| *after as usize);
        row[x] = after as u32;
        x = after;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However many parts lie on each other, each texel is visited once after it is taken, and none is left out.
    #[test]
    fn taken_texels_are_not_visited_again() {
        let (width, rows) = (50, 3);
        let mut taken = Taken::new(width, rows);
        let mut visits = alloc::vec![0; width * rows];
        for k in 0..600i32 {
            let (row, start) = (k as usize % rows, k * 7 % 40 - 5);
            taken.visit(row, &(start..start + k % 13), |at| {
                assert!(at >= row * width && at < (row + 1) * width);
                visits[at] += 1;
                Visited::Taken
            });
        }
        assert!(visits.iter().all(|v| *v <= 1) && visits.iter().sum::<i32>() > 100);
        // A texel that stays is visited until it is taken.
        let mut taken = Taken::new(4, 1);
        for answer in [Visited::Last, Visited::Last, Visited::Taken] {
            let mut seen = Vec::new();
            taken.visit(0, &(1..3), |at| {
                seen.push(at);
                answer
            });
            assert_eq!(seen.first(), Some(&1));
        }
        taken.visit(0, &(0..9), |at| {
            assert!(at == 0 || at == 3);
            Visited::Taken
        });
    }
}
