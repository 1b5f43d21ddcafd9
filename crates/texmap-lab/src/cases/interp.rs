//! I1 to I6: the error of interpolation, near the eye's plane and at the ends of the number range.

use texmap_math::affine_error;
use texmap_math::interpolation::world_from_screen_z;
use texmap_raster::{DrawCall, Interp};

use super::probe::{Mesh, place, vertex, visit};
use super::{Measurement, naive};
use crate::LabError;
use crate::scenes::UvScene;

/// Texels across the span.
const TEXELS: f64 = 1024.0;

/// A span fills the picture from the left (w = 1) to the right (w = ratio), 1024 texels, one to a pixel.
const SPAN: (u32, u32) = (1024, 64);

fn quad(ratio: f64) -> Mesh {
    let corners = [
        (0.0, 1.0, 0.0),
        (1024.0, ratio, 1.0),
        (1024.0, ratio, 1.0),
        (0.0, 1.0, 0.0),
    ];
    let mut mesh = Mesh {
        indices: vec![[0, 3, 2], [0, 2, 1]],
        ..Mesh::default()
    };
    for (index, (x, w, s)) in corners.into_iter().enumerate() {
        mesh.positions.push(vertex(
            SPAN,
            x,
            if index < 2 { 0.0 } else { f64::from(SPAN.1) },
            w,
        ));
        mesh.values.push((s * TEXELS) as f32);
    }
    mesh
}

/// The same span as one triangle whose tip is so far above that every row reaches (almost) from end to end.
fn row(ratio: f64) -> Mesh {
    let low = f64::from(SPAN.1);
    let tip = world_from_screen_z(0.5, 1.0, ratio);
    Mesh {
        positions: vec![
            vertex(SPAN, 0.0, low, 1.0),
            vertex(SPAN, 1024.0, low, ratio),
            vertex(SPAN, 512.0, low - 30_000.0, 1.0 + tip * (ratio - 1.0)),
        ],
        indices: vec![[0, 1, 2]],
        values: vec![0.0, TEXELS as f32, (tip * TEXELS) as f32],
    }
}

/// The largest error in texels over the pixels.
fn span_error(mesh: &Mesh, interp: Interp) -> Result<f64, LabError> {
    // The w that the rasterizer receives are rounded to f32; the truth takes those.
    let (near, far) = mesh
        .positions
        .iter()
        .map(|p| f64::from(p[2]))
        .fold((f64::INFINITY, 0.0), |(low, high), w| {
            (f64::min(low, w), f64::max(high, w))
        });
    let mut most = 0.0f64;
    visit(
        SPAN,
        &[DrawCall {
            interp,
            ..mesh.draw()
        }],
        |x, _, fragment| {
            let t = (f64::from(x) + 0.5) / f64::from(SPAN.0);
            let truth = TEXELS * world_from_screen_z(t, near, far);
            most = most.max((f64::from(fragment.values[0]) - truth).abs());
        },
    )?;
    Ok(most)
}

/// I1: affine is wrong by the closed form, perspective not at all.
pub(super) fn i1() -> Result<Vec<Measurement>, LabError> {
    let mut out = Vec::new();
    for ratio in [2.0, 4.0, 8.0, 16.0] {
        let perspective = span_error(&quad(ratio), Interp::Perspective)? / TEXELS;
        out.push(Measurement::new(
            "perspective",
            format!("w-ratio {ratio}: error, of the range"),
            perspective,
        ));
        let affine = span_error(&quad(ratio), Interp::Affine)?;
        out.push(Measurement::new(
            "affine",
            format!("w-ratio {ratio}: error in texels"),
            affine,
        ));
        let closed = TEXELS * affine_error::max_error(ratio);
        out.push(Measurement::new(
            "affine",
            format!("w-ratio {ratio}: error, of the closed form"),
            affine / closed,
        ));
    }
    Ok(out)
}

/// I2: sixteen equal spans have the error that they have. Spans chosen by the closed form keep the budget.
pub(super) fn i2() -> Result<Vec<Measurement>, LabError> {
    let mut out = Vec::new();
    for ratio in [2.0, 4.0, 8.0, 16.0] {
        let fixed = span_error(&row(ratio), Interp::Span(SPAN.0 / 16))?;
        out.push(Measurement::new(
            "span:64",
            format!("w-ratio {ratio}: error in texels"),
            fixed,
        ));
        for budget in [0.25f32, 0.5, 1.0] {
            let error = span_error(&quad(ratio), Interp::WithinError(budget))?;
            out.push(Measurement::new(
                &format!("within:{budget}"),
                format!("w-ratio {ratio}: error in texels"),
                error,
            ));
        }
    }
    Ok(out)
}

/// I3: a parabola through three exact points.
pub(super) fn i3() -> Result<Vec<Measurement>, LabError> {
    let error = |ratio: f64| {
        let middle = world_from_screen_z(0.5, 1.0, ratio);
        let at = |t: f64| {
            TEXELS * (naive::quadratic(t, middle) - world_from_screen_z(t, 1.0, ratio)).abs()
        };
        (0..=100_000)
            .map(|i| at(f64::from(i) / 100_000.0))
            .fold(0.0, f64::max)
    };
    Ok([1.1, 2.0, 4.0]
        .map(|ratio| {
            Measurement::new(
                "quadratic",
                format!("w-ratio {ratio}: error in texels"),
                error(ratio),
            )
        })
        .to_vec())
}

/// I4: one vertex close to the eye's plane.
pub(super) fn i4() -> Result<Vec<Measurement>, LabError> {
    let mut out = Vec::new();
    for (w, name) in [
        (1e-3, "1e-3"),
        (1e-4, "1e-4"),
        (1e-5, "1e-5"),
        (1e-6, "1e-6"),
    ] {
        let size = (256, 256);
        let mesh = Mesh {
            positions: vec![
                vertex(size, 3.0, 5.0, 1.0),
                vertex(size, 250.0, 20.0, 1.0),
                vertex(size, 90.0, 251.0, w),
            ],
            indices: vec![[0, 1, 2]],
            values: vec![0.0, TEXELS as f32, 512.0],
        };
        let truth = Truth::new(size, &mesh);
        let (mut most, mut planes, mut steps) = (0.0f64, 0.0f64, 0.0f64);
        let mut stepped = None;
        visit(size, &[mesh.draw()], |x, y, fragment| {
            let expected = truth.at(x, y);
            most = most.max((f64::from(fragment.values[0]) - expected).abs());
            planes = planes.max((truth.planes_f32(x, y) - expected).abs());
            // Stepping: numerator and denominator are summed along the row from its first pixel.
            let (row, value) = truth.step_f32(x, y, stepped);
            stepped = Some(row);
            steps = steps.max((value - expected).abs());
        })?;
        out.extend(measured![
            "perspective", format!("w {name}: error in texels") => most;
            "f32 planes", format!("w {name}: error in texels") => planes;
            "f32 stepping", format!("w {name}: error in texels") => steps;
        ]);
    }
    Ok(out)
}

/// A row being stepped: its number, the next column, and the sums of u/w and 1/w.
type Row = (u32, u32, f32, f32);

/// The exact interpolant of one triangle as planes of u/w and 1/w over the picture.
struct Truth {
    numerator: [f64; 3],
    denominator: [f64; 3],
}

impl Truth {
    fn new(size: (u32, u32), mesh: &Mesh) -> Self {
        let corners = [0, 1, 2].map(|i| place(size, mesh.positions[i]));
        let plane = |values: [f64; 3]| {
            let [a, b, c] = corners;
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
            let dx = ((values[1] - values[0]) * (c[1] - a[1])
                - (values[2] - values[0]) * (b[1] - a[1]))
                / area;
            let dy = ((values[2] - values[0]) * (b[0] - a[0])
                - (values[1] - values[0]) * (c[0] - a[0]))
                / area;
            [dx, dy, values[0] - dx * a[0] - dy * a[1]]
        };
        let inv_w = corners.map(|c| 1.0 / c[2]);
        let numerator = plane([0, 1, 2].map(|i| f64::from(mesh.values[i]) * inv_w[i]));
        Self {
            numerator,
            denominator: plane(inv_w),
        }
    }

    fn at(&self, x: u32, y: u32) -> f64 {
        let value = |p: &[f64; 3]| p[0] * (f64::from(x) + 0.5) + p[1] * (f64::from(y) + 0.5) + p[2];
        value(&self.numerator) / value(&self.denominator)
    }

    fn planes_f32(&self, x: u32, y: u32) -> f64 {
        let value = |p: &[f64; 3]| {
            let [a, b, c] = p.map(|v| v as f32);
            a * (x as f32 + 0.5) + b * (y as f32 + 0.5) + c
        };
        f64::from(value(&self.numerator) / value(&self.denominator))
    }

    fn step_f32(&self, x: u32, y: u32, before: Option<Row>) -> (Row, f64) {
        let start = |p: &[f64; 3]| (p[1] * (f64::from(y) + 0.5) + p[2] + p[0] * 0.5) as f32;
        let (mut column, mut n, mut d) = match before {
            Some((row, column, n, d)) if row == y && column <= x => (column, n, d),
            _ => (0, start(&self.numerator), start(&self.denominator)),
        };
        while column < x {
            n += self.numerator[0] as f32;
            d += self.denominator[0] as f32;
            column += 1;
        }
        ((y, column, n, d), f64::from(n / d))
    }
}

/// I5: the plane through the eye's plane, and one wholly behind.
pub(super) fn i5() -> Result<Vec<Measurement>, LabError> {
    let plane = UvScene::ground(200.0);
    let error = plane.error(&plane.by_raster(Interp::Perspective)?)?;
    let naive = plane.error(&plane.by_projected_vertices()?)?;
    let behind = UvScene::behind();
    let seen = behind
        .by_raster(Interp::Perspective)?
        .iter()
        .filter(|uv| uv.is_some())
        .count();
    Ok(measured![
        "clip at w > 0", "pixels on one side only" => error.mismatches;
        "clip at w > 0", "error, of what is allowed" => error.of_allowed;
        "clip at w > 0", "pixels of a plane behind the eye" => seen as f64;
        "projected vertices", "pixels on one side only" => naive.mismatches;
    ])
}

/// I6: attributes of 2^125, denormals, and constants.
pub(super) fn i6() -> Result<Vec<Measurement>, LabError> {
    let huge = 2f32.powi(125);
    let tiny = 2f32.powi(-140);
    let swing = [huge, -huge, huge, -huge];
    let cts = [1.3, 0.8, 0.6, 2.0];
    let large = Corners {
        w: cts,
        values: swing,
    }
    .error()?
    .max(
        Corners {
            w: [1.3, 0.8, 0.01, 2.0],
            values: swing,
        }
        .error()?,
    );
    let denormal = Corners {
        w: cts,
        values: [tiny, 2.0 * tiny, 3.0 * tiny, 4.0 * tiny],
    }
    .error()?;
    let constant = Corners {
        w: cts,
        values: [0.3; 4],
    }
    .error()?
        / f64::from(f32::EPSILON);
    // The textbook sum of b f / w in f32: its terms at the corners, where b is 1.
    let overflow = swing
        .iter()
        .zip([1.3, 0.8, 0.01, 2.0f32])
        .filter(|(f, w)| !(**f / w).is_finite())
        .count();
    Ok(measured![
        "perspective", "+-2^125: error, of the range" => large;
        "perspective", "denormals: error, of the range" => denormal;
        "perspective", "a constant: error in units of its last place" => constant;
        "f32 sum of b f / w", "+-2^125 at w = 0.01: terms that overflow" => overflow as f64;
    ])
}

/// A quad that fills a small picture: w and one attribute at its corners.
#[derive(Clone, Copy)]
struct Corners {
    w: [f64; 4],
    values: [f32; 4],
}

impl Corners {
    /// The largest error over the pixels, as a part of the largest attribute.
    fn error(self) -> Result<f64, LabError> {
        let size = (128, 128);
        let places = [(0.0, 0.0), (128.0, 0.0), (128.0, 128.0), (0.0, 128.0)];
        let mesh = |corners: &[usize]| Mesh {
            positions: corners
                .iter()
                .map(|&i| vertex(size, places[i].0, places[i].1, self.w[i]))
                .collect(),
            indices: (2..corners.len() as u32).map(|i| [0, i, i - 1]).collect(),
            values: corners.iter().map(|&i| self.values[i]).collect(),
        };
        // The diagonal runs from the top left to the bottom right.
        let (below, above) = (
            Truth::new(size, &mesh(&[0, 2, 3])),
            Truth::new(size, &mesh(&[0, 1, 2])),
        );
        let range = self
            .values
            .iter()
            .fold(0.0f64, |m, &v| m.max(f64::from(v).abs()));
        let (mut most, mut seen) = (0.0f64, 0);
        visit(size, &[mesh(&[0, 1, 2, 3]).draw()], |x, y, fragment| {
            // On the diagonal both are right.
            let truth = if y >= x { &below } else { &above };
            let error = (f64::from(fragment.values[0]) - truth.at(x, y)).abs() / range;
            most = if error.is_nan() {
                f64::INFINITY
            } else {
                most.max(error)
            };
            seen += 1;
        })?;
        Ok(if seen == size.0 * size.1 {
            most
        } else {
            f64::INFINITY
        })
    }
}
