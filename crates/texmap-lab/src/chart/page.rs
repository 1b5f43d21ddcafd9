//! The whole chart as one HTML page that needs nothing else.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::svg::escape;
use super::{Machine, Panel, Point, SceneChart, dominator, front, svg};
use crate::LabError;
use crate::cases::Outcome;
use texmap_truth::metrics::figure;
use texmap_truth::picture::Picture;

const STYLE: &str = "body{font:15px/1.45 sans-serif;color:#222;max-width:1160px;margin:2em auto;padding:0 1em}\
h1{margin-bottom:.2em}h2{margin-top:2em;border-bottom:1px solid #ccc}h3{margin:1.6em 0 .2em}\
nav a{margin-right:1em}figure{margin:.6em 0}svg{max-width:100%;height:auto}.point{cursor:pointer}.point:hover{stroke:#000}\
table{border-collapse:collapse;font-size:13px}td,th{border:1px solid #ddd;padding:2px 8px;text-align:left}\
td.n{text-align:right;font-variant-numeric:tabular-nums}.note{color:#555;font-size:13px}.bad{color:#a00}\
dialog{max-width:90vw;border:1px solid #888}dialog img{image-rendering:pixelated;width:774px;max-width:100%;display:block}\
.key span{margin-right:1.4em}details{margin:.4em 0}";

const SCRIPT: &str = "const box=document.querySelector('dialog'),img=box.querySelector('img'),words=box.querySelector('p');\
document.addEventListener('click',e=>{const p=e.target.closest('.point');if(!p)return;\
const chart=p.closest('figure').id,data=document.getElementById('pictures-'+chart);\
const src=JSON.parse(data.textContent)[p.dataset.point];\
words.textContent=p.querySelector('title').textContent;img.hidden=!src;if(src)img.src='data:image/png;base64,'+src;\
box.showModal()});box.addEventListener('click',()=>box.close());document.body.dataset.ready='yes';";

/// The page: charts, the picture behind each point, the stability table if there are outcomes, the machine.
///
/// # Errors
/// If a chart cannot be drawn or a picture not encoded, which would be a bug.
pub fn page(
    panels: &[Panel],
    outcomes: &[Outcome],
    machine: &Machine,
    how: &str,
) -> Result<String, LabError> {
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>texmap: speed against accuracy</title>\
         <style>{STYLE}</style></head><body>\n<h1>Speed against accuracy</h1>\n<p class=\"note\">{}. {}</p>\n<nav>",
        escape(&machine.to_string()),
        escape(how),
    );
    for panel in panels {
        let _ = write!(out, "<a href=\"#{}\">{}</a>", panel.id, panel.title);
    }
    if !outcomes.is_empty() {
        out.push_str("<a href=\"#stability\">Stability</a>");
    }
    out.push_str(
        "</nav>\n<p class=\"key\"><span style=\"color:#1f5fbf\">&#9679; texmap</span>\
         <span style=\"color:#b06a00\">&#9679; only in the lab</span><span style=\"color:#7a2f8f\">&#9670; another program; at the right edge \
         where this run did not time it</span><span>&#9675; hollow: fails a stability input</span>\
         <span style=\"color:#14783c\">&#9473; Pareto front</span></p>\n<p>Dots are medians, whiskers reach to the 95th \
         percentile of the runs, which take turns. Both axes are logarithmic; an error of 0 stands at 1e-9. Click a point \
         for its picture and, beside it, its error.</p>\n",
    );
    for panel in panels {
        let _ = writeln!(
            out,
            "<h2 id=\"{}\">{}</h2>\n<p>{}</p>",
            panel.id,
            panel.title,
            escape(panel.about)
        );
        for chart in &panel.charts {
            one(&mut out, chart)?;
        }
    }
    if !outcomes.is_empty() {
        stability(&mut out, outcomes);
    }
    let _ = write!(
        out,
        "<dialog><p></p><img alt=\"the result and its error\"><p class=\"note\">Left: the result. Right: the error, black for none, \
         through red and yellow to white. Click to close.</p></dialog>\n<script>{SCRIPT}</script></body></html>\n"
    );
    Ok(out)
}

fn one(out: &mut String, chart: &SceneChart) -> Result<(), LabError> {
    let best = front(chart);
    let names: Vec<String> = best
        .iter()
        .map(|&i| escape(&chart.points[i].method))
        .collect();
    let dominated: Vec<String> = chart
        .points
        .iter()
        .filter_map(|p| {
            let by = dominator(chart, p)?;
            Some(format!("{} (by {})", escape(&p.method), escape(&by.method)))
        })
        .collect();
    let _ = write!(
        out,
        "<h3>{}</h3>\n<p class=\"note\">Truth: {}.</p>\n<figure id=\"{}\">{}</figure>\n\
         <p class=\"note\"><b>Front:</b> {}. <b>Dominated:</b> {}.</p>\n<details><summary>Figures</summary><table><tr>\
         <th>method</th><th>from</th><th>ns median</th><th>ns p95</th><th>bytes</th><th>RMSE</th><th>p99.9</th><th>max</th>\
         <th>failures</th></tr>\n",
        escape(&chart.title),
        escape(&chart.truth),
        chart.id,
        svg(chart)?,
        or_none(&names),
        or_none(&dominated),
    );
    for point in &chart.points {
        row(out, point);
    }
    let _ = writeln!(out, "</table></details>");
    let pictures: Vec<String> = chart
        .points
        .iter()
        .map(|p| p.picture.as_ref().map_or(Ok(String::new()), encode))
        .collect::<Result<_, _>>()?;
    // Base64 has no character that JSON or HTML would need to escape.
    let quoted: Vec<String> = pictures.iter().map(|p| format!("\"{p}\"")).collect();
    let _ = writeln!(
        out,
        "<script type=\"application/json\" id=\"pictures-{}\">[{}]</script>",
        chart.id,
        quoted.join(",")
    );
    Ok(())
}

fn or_none(names: &[String]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

fn row(out: &mut String, point: &Point) {
    let number = |v: Option<f64>| v.filter(|v| !v.is_nan()).map_or(String::new(), figure);
    let _ = writeln!(
        out,
        "<tr><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
         <td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"bad\">{}</td></tr>",
        escape(&point.method),
        point.source.name(),
        number(point.time.map(|t| t.median)),
        number(point.time.map(|t| t.p95)),
        point.bytes.map_or(String::new(), |b| b.to_string()),
        number(Some(point.error.rmse)),
        number(Some(point.error.p999)),
        number(Some(point.error.max)),
        escape(&point.failures.join("; ")),
    );
}

fn stability(out: &mut String, outcomes: &[Outcome]) {
    let _ = write!(
        out,
        "<h2 id=\"stability\">Stability</h2>\n<p>Inputs on which methods fail. Naive methods must fail, and do so here, now.</p>\n\
         <table><tr><th>case</th><th>method</th><th>measured is</th><th>demanded</th><th>measured</th><th>verdict</th></tr>\n"
    );
    for outcome in outcomes {
        for verdict in &outcome.verdicts {
            let check = &verdict.check;
            let _ = writeln!(
                out,
                "<tr title=\"{}\"><td>{}</td><td>{}{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td{}>{}</td></tr>",
                escape(&format!(
                    "{}. {}.",
                    outcome.case.input, outcome.case.expected
                )),
                outcome.case.id,
                escape(&check.method),
                if check.must_fail {
                    " <i>(naive)</i>"
                } else {
                    ""
                },
                escape(&check.measure),
                escape(&check.demand()),
                verdict.measured.map_or(String::new(), figure),
                if verdict.passes() && !check.must_fail {
                    ""
                } else {
                    " class=\"bad\""
                },
                verdict.word(),
            );
        }
    }
    out.push_str("</table>\n");
}

/// A PNG without alpha, in base64.
fn encode(picture: &Picture) -> Result<String, LabError> {
    let rgb: Vec<u8> = picture
        .rgba()
        .chunks_exact(4)
        .flat_map(|p| [p[0], p[1], p[2]])
        .collect();
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::NoFilter)
        .write_image(
            &rgb,
            picture.width(),
            picture.height(),
            ExtendedColorType::Rgb8,
        )
        .map_err(|e| LabError::Chart(e.to_string()))?;
    Ok(STANDARD.encode(&bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_becomes_a_png() {
        let text = encode(&Picture::new(3, 2, [1, 2, 3, 255])).unwrap();
        assert!(text.starts_with("iVBORw0KGgo"), "the signature of PNG");
    }
}
