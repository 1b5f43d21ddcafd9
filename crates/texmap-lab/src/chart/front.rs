//! The Pareto front of a chart.

use super::{Across, Point, SceneChart};

/// Coordinates of a point in the chart: its cost and its error.
fn place(chart: &SceneChart, point: &Point) -> Option<(f64, f64)> {
    let cost = match chart.across {
        Across::Time => point.time?.median,
        Across::Bytes => point.bytes? as f64,
    };
    (cost.is_finite() && point.error.rmse.is_finite()).then_some((cost, point.error.rmse))
}

/// The method that makes a point needless: sound, not dearer, not less accurate, and better in one of the two. Of
/// several the most accurate.
pub fn dominator<'c>(chart: &'c SceneChart, point: &Point) -> Option<&'c Point> {
    let (cost, error) = place(chart, point)?;
    let better = |other: &&Point| {
        other.failures.is_empty()
            && place(chart, other)
                .is_some_and(|(c, e)| c <= cost && e <= error && (c < cost || e < error))
    };
    chart
        .points
        .iter()
        .filter(better)
        .min_by(|a, b| a.error.rmse.total_cmp(&b.error.rmse))
}

/// Indices of the points that nothing dominates and that have no failure, from cheap to dear.
pub fn front(chart: &SceneChart) -> Vec<usize> {
    let mut indices: Vec<(usize, f64)> = chart
        .points
        .iter()
        .enumerate()
        .filter(|(_, p)| p.failures.is_empty() && dominator(chart, p).is_none())
        .filter_map(|(i, p)| Some((i, place(chart, p)?.0)))
        .collect();
    indices.sort_by(|a, b| a.1.total_cmp(&b.1));
    indices.into_iter().map(|(i, _)| i).collect()
}

#[cfg(test)]
mod tests {
    use super::super::time::Time;
    use super::super::{Error, Source};
    use super::*;

    fn point(method: &str, ns: f64, rmse: f64, failures: &[&str]) -> Point {
        Point {
            method: method.into(),
            source: Source::Texmap,
            time: (ns > 0.0).then_some(Time {
                median: ns,
                p95: ns,
                best: ns,
            }),
            error: Error {
                rmse,
                ..Error::default()
            },
            bytes: None,
            failures: failures.iter().map(|f| (*f).to_owned()).collect(),
            picture: None,
        }
    }

    #[test]
    fn the_front_has_no_dominated_and_no_broken_method() {
        let chart = SceneChart {
            id: "x".into(),
            title: String::new(),
            truth: String::new(),
            item: "pixel",
            unit: "texels",
            across: Across::Time,
            points: vec![
                point("dear and exact", 9.0, 0.1, &[]),
                point("cheap and rough", 1.0, 5.0, &[]),
                point("dear and rough", 8.0, 6.0, &[]),
                point("best but broken", 0.5, 0.0, &["3 cracks"]),
                point("not timed", 0.0, 0.01, &[]),
            ],
        };
        assert_eq!(front(&chart), [1, 0]);
        let names = |i: usize| dominator(&chart, &chart.points[i]).map(|p| p.method.as_str());
        assert_eq!(names(2), Some("cheap and rough"));
        assert_eq!(names(3), None);
        assert_eq!(names(4), None);
    }
}
