//! Perspective-correct interpolation of single points, for teaching.

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use texmap_math::{bary, interpolation};

use crate::support::{expect_length, value};

/// Attributes at screen positions: of a span (`corners` 2, one `t` a point) or of a triangle (`corners` 3, three weights a point).
#[pyfunction]
pub(crate) fn perspective_interpolate(
    values: PyReadonlyArray1<'_, f64>,
    w: PyReadonlyArray1<'_, f64>,
    screen: PyReadonlyArray1<'_, f64>,
    mut out: PyReadwriteArray1<'_, f64>,
    mut weights: PyReadwriteArray1<'_, f64>,
) -> PyResult<()> {
    let (values, w, screen) = (values.as_slice()?, w.as_slice()?, screen.as_slice()?);
    let (out, weights) = (out.as_slice_mut()?, weights.as_slice_mut()?);
    let corners = w.len();
    if corners != 2 && corners != 3 {
        return Err(value(format!("w holds {corners} values, expected 2 or 3")));
    }
    if !w.iter().all(|w| *w > 0.0 && w.is_finite()) {
        return Err(value("w must be finite and above 0: clip before dividing"));
    }
    let channels = values.len() / corners;
    expect_length("values", values.len(), channels * corners)?;
    expect_length("screen", screen.len(), weights.len())?;
    let points = screen.len() / corners;
    expect_length("out", out.len(), points * channels)?;
    for point in 0..points {
        let at = point * corners..(point + 1) * corners;
        let found: Vec<f64> = match (&screen[at.clone()], w) {
            (&[_, t], &[a, b]) => {
                let s = interpolation::world_from_screen_z(t, a, b);
                vec![1.0 - s, s]
            }
            (&[x, y, z], &[a, b, c]) => bary::perspective([x, y, z], [a, b, c].map(f64::recip))
                .ok_or_else(|| value(format!("screen[{point}]: the weights have no sum")))?
                .to_vec(),
            _ => return Err(value("screen: one weight a corner")),
        };
        for channel in 0..channels {
            let terms = found.iter().enumerate();
            out[point * channels + channel] =
                terms.map(|(k, s)| s * values[k * channels + channel]).sum();
        }
        weights[at].copy_from_slice(&found);
    }
    Ok(())
}
