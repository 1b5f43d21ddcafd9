//! Checks of displacements and billboards.

use texmap_math::glam::DVec3;

use crate::{EdgeBudget, Facing, Mesh, SceneError};

impl Mesh {
    pub(crate) fn check_shape(&self) -> Result<(), SceneError> {
        let value = |what: &str, value: String, expected| {
            Err(SceneError::Value {
                place: format!("mesh '{}'", self.name),
                what: what.to_owned(),
                value,
                expected,
            })
        };
        self.check_billboards()?;
        let Some(displacement) = &self.displacement else {
            return Ok(());
        };
        let (height, middle) = (displacement.height, displacement.middle);
        if !(height.is_finite() && middle.is_finite()) {
            return value(
                "height of the displacement",
                format!("{height} about {middle}"),
                "it must be finite",
            );
        }
        let (EdgeBudget::Texels(edge) | EdgeBudget::Pixels(edge)) = displacement.budget;
        if !(edge > 0.0 && edge.is_finite()) {
            return value(
                "longest edge of the displacement",
                edge.to_string(),
                "it must be finite and above 0",
            );
        }
        if self.uvs.is_empty() && !self.triangles.is_empty() {
            return value(
                "displacement",
                "without texture coordinates".to_owned(),
                "give the mesh uvs per vertex (`tf` faces or `vt` lines; Mesh::project_uvs)",
            );
        }
        Ok(())
    }

    fn check_billboards(&self) -> Result<(), SceneError> {
        for (i, board) in self.billboards.iter().enumerate() {
            let axis = match board.facing {
                Facing::Screen => DVec3::Y,
                Facing::Axis(axis) => axis,
            };
            let sized = board.size.iter().all(|s| *s > 0.0 && s.is_finite());
            let turns = axis.is_finite() && axis.length_squared() > 0.0;
            if !(sized && turns && board.position.is_finite()) {
                return Err(SceneError::Value {
                    place: format!("mesh '{}' billboard {i}", self.name),
                    what: "it".to_owned(),
                    value: format!("{board:?}"),
                    expected: "numbers must be finite, sizes above 0 and axes not zero",
                });
            }
        }
        if !self.billboards.is_empty() && self.displacement.is_some() {
            return Err(SceneError::Value {
                place: format!("mesh '{}'", self.name),
                what: "displacement".to_owned(),
                value: "that of billboards".to_owned(),
                expected: "billboards cannot be displaced: give the displacement to another mesh",
            });
        }
        Ok(())
    }
}
