//! The Hilbert curve: an order of the cells of a square in which neighbours stay together.

/// Column and row of cell `at` of the curve through a square of `side` cells a side, a power of two. Cells from `side` squared on repeat the
/// curve.
///
/// ```
/// let cells: Vec<_> = (0..4).map(|at| texmap_math::hilbert::cell(at, 2)).collect();
/// assert_eq!(cells, [(0, 0), (0, 1), (1, 1), (1, 0)]);
/// ```
#[must_use]
pub fn cell(at: u32, side: u32) -> (u32, u32) {
    let (mut x, mut y, mut rest, mut size) = (0, 0, at, 1);
    while size < side {
        let (right, down) = ((rest / 2) & 1, (rest ^ (rest / 2)) & 1);
        if down == 0 {
            if right == 1 {
                (x, y) = (size - 1 - x, size - 1 - y);
            }
            (x, y) = (y, x);
        }
        (x, y) = (x + size * right, y + size * down);
        (rest, size) = (rest / 4, size * 2);
    }
    (x, y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every cell is met once, a step from the one before.
    #[test]
    fn the_curve_meets_every_cell_by_single_steps() {
        for side in [1, 2, 8, 64] {
            let mut met = alloc::vec![false; (side * side) as usize];
            let mut last = cell(0, side);
            for at in 0..side * side {
                let (x, y) = cell(at, side);
                assert!(!core::mem::replace(&mut met[(y * side + x) as usize], true));
                let step = x.abs_diff(last.0) + y.abs_diff(last.1);
                assert_eq!(step, u32::from(at > 0), "{side}: {at}");
                last = (x, y);
            }
        }
    }
}
