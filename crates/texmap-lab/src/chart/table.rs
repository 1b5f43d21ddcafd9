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

/// The planner's table of prices: `filter,precision,ns`, from the noise chart (the least kind to caches), and the two
/// interpolations that it may choose, from the quad of w-ratio 1.02. Shortest runs, which a busy machine disturbs least.
pub fn prices(panels: &[Panel]) -> String {
    let charts = || panels.iter().flat_map(|p| &p.charts);
    let mut out = String::from("filter,precision,ns\n");
    for point in charts()
        .filter(|c| c.id == "filtering-noise")
        .flat_map(|c| &c.points)
    {
        let (name, precision) = match point.method.strip_suffix(", fast") {
            Some(name) => (name, "fast"),
            None => (point.method.as_str(), "exact"),
        };
        let known = point.source == Source::Texmap && name.parse::<texmap_sample::Filter>().is_ok();
        if let (true, Some(time)) = (known, point.time) {
            let _ = writeln!(out, "{name},{precision},{:.2}", time.best);
        }
    }
    for point in charts()
        .filter(|c| c.id == "interpolation-1.02")
        .flat_map(|c| &c.points)
    {
        if let ("perspective" | "affine", Some(time)) = (point.method.as_str(), point.time) {
            let _ = writeln!(out, "{},interp,{:.2}", point.method, time.best);
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
