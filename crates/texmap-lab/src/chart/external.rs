//! Other programs: their errors on the scenes of the panels, measured by the benches' program `chart-peers` and committed as
//! `external.csv`, so that a chart needs none of them. They have no time here: a time counts only beside those of the same run.

use std::fmt::Write;

use super::{Error, Point, Source};

/// Lines of `chart,method,rmse,p99.9,max,failures`.
const TABLE: &str = include_str!("external.csv");

const HEADING: &str = "chart,method,rmse,p99.9,max,failures\n";

/// A scene drawn by another program.
#[derive(Clone, Debug, PartialEq)]
pub struct ExternalPoint {
    /// [`SceneChart::id`](super::SceneChart::id).
    pub chart: String,
    /// Program, version, and filter if it has a choice; without commas.
    pub method: String,
    /// In the unit of the chart.
    pub error: Error,
    /// Failures; without commas.
    pub failures: Vec<String>,
}

/// The table that [`panels`](super::panels) reads.
pub fn external_csv(points: &[ExternalPoint]) -> String {
    let mut out = HEADING.to_owned();
    for point in points {
        let Error { rmse, p999, max } = point.error;
        let _ = writeln!(
            out,
            "{},{},{rmse:.6e},{p999:.6e},{max:.6e},{}",
            point.chart,
            point.method,
            point.failures.join("; "),
        );
    }
    out
}

/// The points of a chart.
pub(super) fn points(chart: &str) -> impl Iterator<Item = Point> {
    let rows = TABLE.lines().skip(1).filter_map(parse);
    rows.filter(move |row| row.chart == chart).map(|row| Point {
        method: row.method,
        source: Source::External,
        time: None,
        error: row.error,
        bytes: None,
        failures: row.failures,
        picture: None,
    })
}

fn parse(line: &str) -> Option<ExternalPoint> {
    let fields: Vec<&str> = line.split(',').collect();
    let [chart, method, rmse, p999, max, failures] = fields[..] else {
        return None;
    };
    let failures = failures.split("; ").filter(|f| !f.is_empty());
    Some(ExternalPoint {
        chart: chart.to_owned(),
        method: method.to_owned(),
        error: Error {
            rmse: rmse.parse().ok()?,
            p999: p999.parse().ok()?,
            max: max.parse().ok()?,
        },
        failures: failures.map(str::to_owned).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::{PlaneScene, QuadScene};
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let points = [
            ExternalPoint {
                chart: "filtering-noise".into(),
                method: "llvmpipe 1.2.3 bilinear".into(),
                error: Error {
                    rmse: 0.125,
                    p999: 0.5,
                    max: 1.0,
                },
                failures: Vec::new(),
            },
            ExternalPoint {
                chart: "interpolation-8".into(),
                method: "other 1".into(),
                error: Error::default(),
                failures: vec!["3 pixels on one side only".into(), "1 NaN".into()],
            },
        ];
        let text = external_csv(&points);
        let read: Vec<ExternalPoint> = text.lines().skip(1).filter_map(parse).collect();
        assert_eq!(read, points);
        assert_eq!(parse("filtering-noise,x,0.1,0.2"), None);
        assert_eq!(parse("filtering-noise,x,none,0.2,0.3,"), None);
    }

    #[test]
    fn every_line_of_the_table_stands_in_a_chart() {
        let planes = PlaneScene::all(1).into_iter().map(|s| s.id);
        let charts: Vec<String> = planes
            .chain(QuadScene::all().into_iter().map(|s| s.id))
            .collect();
        assert!(TABLE.starts_with(HEADING));
        let lines = TABLE.lines().skip(1);
        for line in lines.clone() {
            let point = parse(line).unwrap_or_else(|| panic!("{line}"));
            assert!(charts.contains(&point.chart), "{line}");
            assert!(point.error.rmse <= point.error.max, "{line}");
        }
        let read: usize = charts.iter().map(|c| points(c).count()).sum();
        assert_eq!(read, lines.count());
        for program in ["llvmpipe", "euc", "retrofire"] {
            let mut methods = points("filtering-noise").map(|p| p.method);
            assert!(methods.any(|m| m.starts_with(program)), "{program}");
        }
        assert_eq!(points("no such chart").count(), 0);
    }
}
