//! The unwrapped picture as SVG: triangles over the unit square, overlapping ones in pink.

use alloc::format;
use alloc::string::String;
use core::fmt::Write;

use crate::uv_set::UvSet;
use crate::{Origin, Report};

/// An SVG of `size` x `size` pixels that shows the layout: the unit square with a frame, triangles grey, overlapping
/// ones pink, flipped ones blue. The view grows to hold coordinates outside of [0, 1], up to 4 squares each way.
#[must_use]
pub fn layout_svg(set: &UvSet, report: &Report, origin: Origin, size: u32) -> String {
    let (mut low, mut high) = ([0.0f64; 2], [1.0f64; 2]);
    for uv in &set.uvs {
        for i in 0..2 {
            let c = f64::from(uv[i]);
            low[i] = if c < low[i] {
                if c < -4.0 { -4.0 } else { c }
            } else {
                low[i]
            };
            high[i] = if c > high[i] {
                if c > 5.0 { 5.0 } else { c }
            } else {
                high[i]
            };
        }
    }
    let side = (high[0] - low[0]).max(high[1] - low[1]);
    let scale = f64::from(size) / (side * 1.04);
    let margin = f64::from(size) * 0.02;
    let at = |u: f64, v: f64| {
        let down = if origin == Origin::TopLeft {
            v - low[1]
        } else {
            high[1] - v
        };
        ((u - low[0]) * scale + margin, down * scale + margin)
    };
    let mut paths = [const { String::new() }; 3];
    for t in &report.triangles {
        let path = &mut paths[if t.overlapping {
            2
        } else {
            usize::from(t.flipped)
        }];
        for (k, corner) in t.corners.iter().enumerate() {
            let [u, v] = set.at(*corner as usize).map(f64::from);
            let (x, y) = at(u, v);
            let _ = write!(path, "{}{x:.2} {y:.2}", if k == 0 { 'M' } else { 'L' });
        }
        path.push('Z');
    }
    let (x0, y0) = at(0.0, if origin == Origin::TopLeft { 0.0 } else { 1.0 });
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{size}\" height=\"{size}\" viewBox=\"0 0 {size} {size}\">\n\
         <rect width=\"{size}\" height=\"{size}\" fill=\"#ffffff\"/>\n\
         <rect x=\"{x0:.2}\" y=\"{y0:.2}\" width=\"{scale:.2}\" height=\"{scale:.2}\" fill=\"#f4f4f6\" stroke=\"#404048\"/>\n"
    );
    for (path, fill) in paths.iter().zip(["#9aa4b2", "#6a8fe0", "#ff6ab4"]) {
        if !path.is_empty() {
            let _ = writeln!(
                svg,
                "<path d=\"{path}\" fill=\"{fill}\" fill-opacity=\"0.75\" stroke=\"#303038\" stroke-width=\"0.4\"/>"
            );
        }
    }
    svg.push_str("</svg>\n");
    svg
}
