//! Lists, strips and fans of indices to triangles.

use texmap_math::parallel;

use super::json::Primitive;
use super::model::Model;
use crate::IoError;

/// True if a primitive consists of triangles; `None` for a mode that does not exist.
pub(super) fn has_triangles(mode: u32) -> Option<bool> {
    match mode {
        0..=3 => Some(false),
        4..=6 => Some(true),
        _ => None,
    }
}

/// The triangles of a primitive of `vertices` vertices. Indices of a list beyond whole triangles are left out.
pub(super) fn triangles(
    model: &Model<'_>,
    primitive: &Primitive,
    vertices: usize,
    at: &str,
) -> Result<Vec<[u32; 3]>, IoError> {
    let corners = Corners {
        model,
        primitive,
        vertices,
        at,
    };
    Ok(match primitive.mode {
        5 => strip(corners.read::<1>()?.as_flattened()),
        6 => fan(corners.read::<1>()?.as_flattened()),
        _ => corners.read::<3>()?,
    })
}

/// The corners of a primitive, in the order of the file.
struct Corners<'p> {
    model: &'p Model<'p>,
    primitive: &'p Primitive,
    vertices: usize,
    at: &'p str,
}

impl Corners<'_> {
    /// In groups of `N`, all of them below the number of vertices.
    fn read<const N: usize>(&self) -> Result<Vec<[u32; N]>, IoError> {
        let Self { model, at, .. } = self;
        let Some(index) = self.primitive.indices else {
            model.ask(12 * self.vertices as u64, at)?;
            let group = |i: usize| std::array::from_fn(|n| (i * N + n) as u32);
            return Ok(parallel::list(self.vertices / N, [0; N], group));
        };
        let accessor = model.accessor(index, &format!("{at}/indices"))?;
        model.ask(12 * accessor.count as u64, at)?;
        let groups = accessor.indices::<N>()?;
        let all = groups.as_flattened();
        match parallel::first(all.len(), |i| all[i] as usize >= self.vertices) {
            None => Ok(groups),
            Some(bad) => {
                let problem = format!(
                    "index {bad} names vertex {}; there are {}",
                    all[bad], self.vertices
                );
                Err(model.broken(&format!("{at}/indices"), problem))
            }
        }
    }
}

/// Each further corner makes a triangle with the two before it; every second one is turned. Those that repeat a corner only join parts.
fn strip(all: &[u32]) -> Vec<[u32; 3]> {
    let triangle = |(i, w): (usize, &[u32])| match i % 2 {
        0 => [w[0], w[1], w[2]],
        _ => [w[0], w[2], w[1]],
    };
    let all = all.windows(3).enumerate().map(triangle);
    all.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

fn fan(all: &[u32]) -> Vec<[u32; 3]> {
    let Some((first, rest)) = all.split_first() else {
        return Vec::new();
    };
    rest.windows(2).map(|w| [w[0], w[1], *first]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All triangles of a square and of a pentagon are counter-clockwise, as their outlines are.
    #[test]
    fn strips_and_fans_keep_their_side() {
        let area = |points: &[[f64; 2]], [a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|i| points[i as usize]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        };
        let ladder = [
            [0.0, 1.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 0.0],
            [2.0, 1.0],
            [2.0, 0.0],
        ];
        let areas: Vec<f64> = strip(&[0, 1, 2, 3, 4, 5])
            .into_iter()
            .map(|t| area(&ladder, t))
            .collect();
        assert_eq!(areas, [0.5; 4]);
        // Joined with another strip by repeated corners.
        assert_eq!(strip(&[0, 1, 2, 2, 3, 3, 4, 5]), [[0, 1, 2], [3, 5, 4]]);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let areas: Vec<f64> = fan(&[0, 1, 2, 3])
            .into_iter()
            .map(|t| area(&square, t))
            .collect();
        assert_eq!(areas, [0.5; 2]);
        assert_eq!(
            (fan(&[]), strip(&[1, 2]), fan(&[1])),
            (vec![], vec![], vec![])
        );
    }
}
