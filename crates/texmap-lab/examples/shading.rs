//! Writes docs/generated/shading.md: `cargo run --release -p texmap-lab --example shading > docs/generated/shading.md`.

use std::io::Write;

use texmap_lab::shading::{Floor, Method};
use texmap_math::glam::DVec3;

const CELLS: [u32; 5] = [1, 2, 4, 8, 16];

fn main() -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "# Light per vertex, along light vectors, per pixel\n\n\
         Written by `cargo run --release -p texmap-lab --example shading > docs/generated/shading.md`. A square of side 2 under a point light\n\
         at (0.5, 0.5, -0.25) above it, cut into N x N squares of two triangles; the error of its diffuse light against f64 light at\n\
         160 x 160 points, in 255ths of full light: largest (RMS). The second table gives it the normals of waves (slope up to 0.3,\n\
         five a side), which every method but Gouraud's reads at the pixel, as from a normal map.\n"
    )?;
    for (title, waves) in [("A flat floor", 0.0), ("Under a normal map", 0.3)] {
        writeln!(out, "## {title}\n")?;
        let head = CELLS.map(|n| format!("{n} x {n}")).join(" | ");
        writeln!(
            out,
            "| interpolated | {head} |\n|---|{}",
            "---|".repeat(CELLS.len())
        )?;
        for method in Method::ALL {
            let cells = CELLS.map(|cells| {
                let floor = Floor {
                    cells,
                    light: DVec3::new(0.5, 0.5, -0.25),
                    waves,
                };
                let found = floor.measure(method);
                let codes = |x: f64| format!("{:.2}", 255.0 * x);
                format!("{} ({})", codes(found.max), codes(found.rmse))
            });
            writeln!(out, "| {} | {} |", method.name(), cells.join(" | "))?;
        }
        writeln!(out)?;
    }
    writeln!(
        out,
        "Unit vectors at the vertices are too short between them, so light sinks towards the middle of each triangle (under a light\n\
         above the middle by 1 - h/d on the diagonal, h its height and d its distance from the corners); brought back to length 1 they\n\
         still point a little wrong, unless all corners are as far from the light. The plain difference of light and vertex is linear on\n\
         the surface: interpolated in perspective and brought to length 1 at the pixel it is exact, for the same price. On a flat floor\n\
         Gouraud's colours are the unit vectors' light; under a normal map they lose its detail on any mesh that is coarser.\n\
         `shade vertex` in a scene is Gouraud's way, `shade pixel` light per pixel from the interpolated position."
    )
}
