//! A chart as SVG: axes and front by plotters, points as shapes that a page can answer clicks on.

use std::fmt::Write;
use std::ops::Range;

use plotters::prelude::*;

use super::{Across, Point, SceneChart, Source, front};
use crate::LabError;
use texmap_truth::metrics::figure;

const SIZE: (u32, u32) = (760, 470);

/// Errors below this are drawn at the bottom: a logarithm has no zero.
const FLOOR: f64 = 1e-9;

/// Width of the band at the right where points without a cost stand.
const BAND: i32 = 46;

/// Draws a chart. Points that were not timed stand in a band of their own at the right edge. Each carries `data-point`, its index.
///
/// # Errors
/// If plotters cannot draw, which would be a bug.
pub fn svg(chart: &SceneChart) -> Result<String, LabError> {
    let bug = |e: &dyn std::fmt::Display| LabError::Chart(format!("{}: {e}", chart.id));
    let costs: Vec<f64> = chart.points.iter().filter_map(|p| cost(chart, p)).collect();
    let errors: Vec<f64> = chart.points.iter().map(error).collect();
    let (xs, ys) = (decades(&costs), decades(&errors));
    let band = if costs.len() < errors.len() { BAND } else { 0 };
    let mut text = String::new();
    let places: Vec<(i32, i32)>;
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(|e| bug(&e))?;
        let mut drawing = ChartBuilder::on(&root)
            .margin(12)
            .margin_right(12 + band)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(xs.clone().log_scale(), ys.log_scale())
            .map_err(|e| bug(&e))?;
        let across = match chart.across {
            Across::Time => format!("ns a {}", chart.item),
            Across::Bytes => "bytes".to_owned(),
        };
        drawing
            .configure_mesh()
            .x_desc(across)
            .y_desc(format!("RMSE, {}", chart.unit))
            .x_label_formatter(&|v| figure(*v))
            .y_label_formatter(&|v| figure(*v))
            .axis_desc_style(("sans-serif", 15))
            .label_style(("sans-serif", 13))
            .bold_line_style(RGBColor(205, 205, 205))
            .light_line_style(RGBColor(238, 238, 238))
            .draw()
            .map_err(|e| bug(&e))?;
        let best = front(chart);
        let place = |p: &Point| (cost(chart, p).unwrap_or(xs.start), error(p));
        let line: Vec<(f64, f64)> = best.iter().map(|&i| place(&chart.points[i])).collect();
        drawing
            .draw_series(std::iter::once(PathElement::new(
                line,
                RGBColor(20, 120, 60).stroke_width(2),
            )))
            .map_err(|e| bug(&e))?;
        let area = drawing.plotting_area();
        places = chart
            .points
            .iter()
            .map(|p| {
                let (x, y) = area.map_coordinate(&place(p));
                let known = cost(chart, p).is_some();
                (
                    if known {
                        x
                    } else {
                        SIZE.0 as i32 - BAND / 2 - 6
                    },
                    y,
                )
            })
            .collect();
        let x_of = |v: f64| {
            area.map_coordinate(&(v, errors.first().copied().unwrap_or(1.0)))
                .0
        };
        let ends: Vec<Option<i32>> = chart
            .points
            .iter()
            .map(|p| {
                (chart.across == Across::Time)
                    .then_some(p.time?.p95)
                    .map(x_of)
            })
            .collect();
        root.present().map_err(|e| bug(&e))?;
        drop(drawing);
        drop(root);
        let mut marks = marks(chart, &places, &ends, band);
        if band > 0 {
            let word = match chart.across {
                Across::Time => "not timed",
                Across::Bytes => "no size",
            };
            let _ = writeln!(
                marks,
                "<path d=\"M{0} 12V{1}\" stroke=\"#999\" stroke-dasharray=\"3 3\"/>\
                 <text x=\"{2}\" y=\"{3}\" text-anchor=\"middle\" font-family=\"sans-serif\" font-size=\"11\" fill=\"#777\">{word}</text>",
                SIZE.0 as i32 - band - 8,
                SIZE.1 - 56,
                SIZE.0 as i32 - band / 2 - 6,
                SIZE.1 - 40,
            );
        }
        // The document ends with its closing tag.
        let end = text.rfind("</svg>").unwrap_or(text.len());
        text.insert_str(end, &marks);
    }
    Ok(text)
}

fn cost(chart: &SceneChart, point: &Point) -> Option<f64> {
    match chart.across {
        Across::Time => point.time.map(|t| t.median),
        Across::Bytes => point.bytes.map(|b| b as f64),
    }
}

fn error(point: &Point) -> f64 {
    point.error.rmse.clamp(FLOOR, 1e9)
}

/// A range of whole or half decades around positive values.
fn decades(values: &[f64]) -> Range<f64> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(0.0, f64::max);
    if !(low > 0.0 && low.is_finite() && high.is_finite()) {
        return 0.1..10.0;
    }
    let half = |v: f64, up: f64| {
        10f64.powf(((v.log10() * 2.0 + up * 0.15).floor() + f64::from(u8::from(up > 0.0))) / 2.0)
    };
    half(low, -1.0)..half(high, 1.0)
}

/// Whiskers, shapes and labels.
fn marks(chart: &SceneChart, places: &[(i32, i32)], ends: &[Option<i32>], band: i32) -> String {
    let best = front(chart);
    let mut out = String::new();
    for (index, ((point, (x, y)), end)) in chart.points.iter().zip(places).zip(ends).enumerate() {
        let color = match point.source {
            Source::Texmap => "#1f5fbf",
            Source::Lab => "#b06a00",
            Source::External => "#7a2f8f",
        };
        let inside = SIZE.0 as i32 - 12 - band;
        if let Some(end) = end.map(|end| end.min(inside)).filter(|end| end > x) {
            let _ = writeln!(
                out,
                "<path d=\"M{x} {y}H{end}m0 -3v6\" stroke=\"{color}\" stroke-opacity=\"0.5\" fill=\"none\"/>"
            );
        }
        let fill = if point.failures.is_empty() {
            color
        } else {
            "white"
        };
        let radius = if best.contains(&index) { 6 } else { 4 };
        let shape = match point.source {
            Source::External => format!("<path d=\"M{} {y}l6 -6l6 6l-6 6z\"", x - 6),
            _ => format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\""),
        };
        let _ = writeln!(
            out,
            "{shape} fill=\"{fill}\" stroke=\"{color}\" stroke-width=\"1.5\" class=\"point\" data-point=\"{index}\"><title>{}</title></{}>",
            escape(&describe(chart, point)),
            if point.source == Source::External {
                "path"
            } else {
                "circle"
            },
        );
    }
    // Labels where there is room, the front's first.
    let mut taken: Vec<[i32; 4]> = places
        .iter()
        .map(|&(x, y)| [x - 5, y - 5, x + 5, y + 5])
        .collect();
    let others = (0..chart.points.len()).filter(|i| !best.contains(i));
    for index in best.iter().copied().chain(others) {
        let (point, (x, y)) = (&chart.points[index], places[index]);
        let width = 6 * point.method.chars().count() as i32;
        let bold = best.contains(&index);
        let spots = [
            (8, 4),
            (8, -8),
            (8, 16),
            (-8 - width, 4),
            (-8 - width, -8),
            (-8 - width, 16),
        ];
        for (dx, dy) in spots {
            let frame = [x + dx, y + dy - 9, x + dx + width, y + dy + 2];
            let clear = |t: &[i32; 4]| {
                frame[2] < t[0] || t[2] < frame[0] || frame[3] < t[1] || t[3] < frame[1]
            };
            let inside = frame[0] > 84
                && frame[2] < SIZE.0 as i32 - 6
                && frame[1] > 8
                && frame[3] < SIZE.1 as i32 - 58;
            if inside && taken.iter().all(clear) {
                taken.push(frame);
                let weight = if bold { " font-weight=\"bold\"" } else { "" };
                let _ = writeln!(
                    out,
                    "<text x=\"{}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"11\" fill=\"#333\"{weight}>{}</text>",
                    x + dx,
                    y + dy,
                    escape(&point.method),
                );
                break;
            }
        }
    }
    out
}

/// All figures of a point in words.
fn describe(chart: &SceneChart, point: &Point) -> String {
    let mut out = point.method.clone();
    if let Some(time) = point.time {
        let _ = write!(
            out,
            ": {} ns a {} (p95 {})",
            figure(time.median),
            chart.item,
            figure(time.p95)
        );
    }
    if let (Across::Bytes, Some(bytes)) = (chart.across, point.bytes) {
        let _ = write!(out, ": {bytes} bytes");
    }
    let _ = write!(out, "; RMSE {} {}", figure(point.error.rmse), chart.unit);
    if !point.error.p999.is_nan() {
        let _ = write!(
            out,
            ", p99.9 {}, max {}",
            figure(point.error.p999),
            figure(point.error.max)
        );
    }
    for failure in &point.failures {
        let _ = write!(out, "; FAILS: {failure}");
    }
    out
}

/// Text inside of markup.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::super::Error;
    use super::super::time::Time;
    use super::*;

    #[test]
    fn every_point_is_drawn_and_a_broken_one_is_hollow() {
        let point = |method: &str, ns: Option<f64>, rmse, failures: &[&str]| Point {
            method: method.into(),
            source: if ns.is_some() {
                Source::Texmap
            } else {
                Source::External
            },
            time: ns.map(|ns| Time {
                median: ns,
                p95: ns * 1.2,
                best: ns,
            }),
            error: Error {
                rmse,
                p999: rmse,
                max: rmse,
            },
            bytes: None,
            failures: failures.iter().map(|f| (*f).to_owned()).collect(),
            picture: None,
        };
        let chart = SceneChart {
            id: "x".into(),
            title: "x".into(),
            truth: "x".into(),
            item: "pixel",
            unit: "texels",
            across: Across::Time,
            points: vec![
                point("exact", Some(2.0), 0.0, &[]),
                point("a < b", Some(1.0), 3.0, &["4 cracks"]),
                point("elsewhere", None, 0.5, &[]),
            ],
        };
        let text = svg(&chart).unwrap();
        assert_eq!(text.matches("data-point=").count(), 3);
        assert!(text.contains("a &lt; b") && !text.contains("a < b"));
        let hollow = text
            .lines()
            .find(|l| l.contains("data-point=\"1\""))
            .unwrap();
        assert!(hollow.contains("fill=\"white\"") && hollow.contains("4 cracks"));
        assert!(text.trim_end().ends_with("</svg>"));
        // Points without a time stand in the band, those with one do not.
        let left = |index: usize| -> i32 {
            let at = format!("data-point=\"{index}\"");
            let line = text.lines().find(|l| l.contains(&at)).unwrap();
            let (_, number) = line
                .split_once("cx=\"")
                .or_else(|| line.split_once("d=\"M"))
                .unwrap();
            let digits = number.split(|c: char| !c.is_ascii_digit()).next();
            digits.unwrap().parse().unwrap()
        };
        let edge = SIZE.0 as i32 - BAND - 8;
        assert!(text.contains("not timed") && left(2) > edge, "{text}");
        assert!(left(0) < edge && left(1) < edge, "{text}");
        let all_timed = svg(&SceneChart {
            points: chart.points[..2].to_vec(),
            ..chart
        });
        assert!(!all_timed.unwrap().contains("not timed"));
    }

    #[test]
    fn ranges_hold_their_values() {
        for values in [vec![1.0], vec![3e-9, 250.0], vec![0.3, 0.9]] {
            let range = decades(&values);
            assert!(
                values.iter().all(|v| range.contains(v)),
                "{values:?} {range:?}"
            );
        }
        assert_eq!(decades(&[]), 0.1..10.0);
    }
}
