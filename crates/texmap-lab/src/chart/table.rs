//! The points as comma-separated values.

use std::fmt::Write;

use super::{Panel, Source, dominator, front};

impl Source {
    /// `texmap`, `lab` or `external`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Texmap => "texmap",
            Self::Lab => "lab",
            Self::External => "external",
        }
    }
}

/// One line a point, with a heading. Empty fields were not measured.
pub fn csv(panels: &[Panel]) -> String {
    let mut out = String::from(
        "panel,chart,method,source,ns_median,ns_p95,bytes,rmse,p99.9,max,error_unit,failures,on_front,dominated_by\n",
    );
    let number = |value: Option<f64>| {
        value
            .filter(|v| !v.is_nan())
            .map_or(String::new(), |v| format!("{v:.6e}"))
    };
    for panel in panels {
        for chart in &panel.charts {
            let best = front(chart);
            for (index, point) in chart.points.iter().enumerate() {
                let _ = writeln!(
                    out,
                    "{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                    panel.id,
                    chart.id,
                    quoted(&point.method),
                    point.source.name(),
                    number(point.time.map(|t| t.median)),
                    number(point.time.map(|t| t.p95)),
                    point.bytes.map_or(String::new(), |b| b.to_string()),
                    number(Some(point.error.rmse)),
                    number(Some(point.error.p999)),
                    number(Some(point.error.max)),
                    quoted(chart.unit),
                    quoted(&point.failures.join("; ")),
                    best.contains(&index),
                    dominator(chart, point).map_or(String::new(), |p| quoted(&p.method)),
                );
            }
        }
    }
    out
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn commas_are_quoted() {
        assert_eq!(super::quoted("a"), "a");
        assert_eq!(super::quoted("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
