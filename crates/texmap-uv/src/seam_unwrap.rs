//! Seams and poles: u unwrapped per face, so that no face runs backwards across the picture.

/// Longitudes of one face's corners, in place.
///
/// Going around the face each corner gets the whole turns that bring it within half a turn of the one before, so u
/// may leave [0, 1]; a corner on the axis (`pole`) then gets the mean of its neighbours ("fan"). Afterwards the
/// lowest u lies in [0, 1). Only whole numbers are added, so neighbours keep the same bits.
///
/// Returns false for a face around the axis itself: it meets all longitudes, no choice of turns can be right.
pub(crate) fn unwrap(u: &mut [f32], pole: &[bool]) -> bool {
    let Some(first) = pole.iter().position(|p| !p) else {
        u.fill(0.5);
        return true;
    };
    let n = u.len();
    // Whole turns of the corner that is visited, from the first one on.
    let raw_first = u[first];
    let (mut turns, mut previous, mut lowest) = (0.0, raw_first, raw_first);
    let step_to = |raw: f32, turns: f32, previous: f32| match raw + turns - previous {
        step if step > 0.5 => turns - 1.0,
        step if step < -0.5 => turns + 1.0,
        _ => turns,
    };
    for i in (first + 1..first + n).map(|k| k % n).filter(|&i| !pole[i]) {
        turns = step_to(u[i], turns, previous);
        previous = u[i] + turns;
        lowest = if previous < lowest { previous } else { lowest };
    }
    // Back at the first corner, which must stand where it began.
    let closes = step_to(raw_first, turns, previous) == 0.0;
    let shift = texmap_math::float::floor_f32(lowest);
    // Again, adding once: u + 1 - 1 would lose the last bits of u, and a vertex its neighbours' coordinate.
    (turns, previous) = (0.0, raw_first);
    for i in (first..first + n).map(|k| k % n).filter(|&i| !pole[i]) {
        turns = step_to(u[i], turns, previous);
        previous = u[i] + turns;
        u[i] += turns - shift;
    }
    // The neighbour before each pole corner, then the mean with the one behind it: once around in either direction.
    let mut near = u[first];
    for i in (first..first + n).map(|k| k % n) {
        if pole[i] {
            u[i] = near;
        } else {
            near = u[i];
        }
    }
    near = u[first];
    for i in (first..first + n).rev().map(|k| k % n) {
        if pole[i] {
            u[i] = (near + u[i]) * 0.5;
        } else {
            near = u[i];
        }
    }
    // A pole corner closes a face that spans up to half a turn; without one a face must come back to itself.
    closes || pole.contains(&true)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run<const N: usize>(mut u: [f32; N], poles: &[usize]) -> ([f32; N], bool) {
        let pole: [bool; N] = core::array::from_fn(|i| poles.contains(&i));
        let closes = unwrap(&mut u, &pole);
        (u, closes)
    }

    #[test]
    fn a_face_across_the_seam_is_not_torn() {
        assert_eq!(
            run([0.9375, 0.0625, 1.0], &[]),
            ([0.9375, 1.0625, 1.0], true)
        );
        assert_eq!(
            run([0.0625, 0.9375, 0.125], &[]),
            ([1.0625, 0.9375, 1.125], true)
        );
        assert_eq!(run([1.0, 0.125, 0.125], &[]), ([0.0, 0.125, 0.125], true));
        assert_eq!(run([0.25, 0.5, 0.375], &[]), ([0.25, 0.5, 0.375], true));
        // A quad, starting on either side.
        assert_eq!(
            run([0.96875, 0.03125, 0.03125, 0.96875], &[]).0,
            [0.96875, 1.03125, 1.03125, 0.96875]
        );
    }

    #[test]
    fn a_corner_keeps_its_bits_whichever_face_it_is_seen_from() {
        let odd = 1.0 / 24.0;
        assert_eq!(run([1.0, odd, 2.0 * odd], &[]).0, [0.0, odd, 2.0 * odd]);
        assert_eq!(run([odd, 2.0 * odd, 1.0], &[]).0, [odd, 2.0 * odd, 0.0]);
        assert_eq!(run([0.95, odd, 1.0], &[]).0, [0.95, 1.0 + odd, 1.0]);
    }

    #[test]
    fn poles_stand_between_their_neighbours() {
        assert_eq!(run([0.5, 0.25, 0.375], &[0]).0, [0.3125, 0.25, 0.375]);
        assert_eq!(
            run([0.96875, 0.5, 0.03125], &[1]).0,
            [0.96875, 1.0, 1.03125]
        );
        assert_eq!(run([0.5, 0.5, 0.125], &[0, 1]).0, [0.125; 3]);
        assert_eq!(run([0.7, 0.7, 0.7], &[0, 1, 2]).0, [0.5; 3]);
        // Several in a row lie between the ends of the row.
        assert_eq!(
            run([0.25, 0.0, 0.0, 0.5, 0.0], &[1, 2, 4]).0,
            [0.25, 0.375, 0.375, 0.5, 0.375]
        );
    }

    #[test]
    fn a_face_around_the_axis_is_told() {
        assert!(!run([0.1, 0.43, 0.77], &[]).1);
        assert!(run([0.1, 0.43, 0.27], &[]).1);
    }
}
