//! L1: light per pixel, along interpolated light vectors, and at the vertices.

use texmap_math::glam::DVec3;

use super::Measurement;
use crate::LabError;
use crate::shading::{Floor, Method};

pub(super) fn l1() -> Result<Vec<Measurement>, LabError> {
    let floor = Floor {
        cells: 1,
        light: DVec3::new(0.5, 0.5, -0.25),
        waves: 0.0,
    };
    let measure = "largest error of diffuse light";
    let one = |method: Method| Measurement::new(method.name(), measure, floor.measure(method).max);
    Ok(Method::ALL.map(one).to_vec())
}
