//! Checks of displacements and billboards.

use texmap_math::glam::DVec3;
use texmap_math::texture_frame::TextureFrame;

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
        if let Some(frame) = &self.texture_frame
            && let Err(error) = TextureFrame::new(frame.o, frame.u, frame.v)
        {
            return value(
                "texture frame",
                error.to_string(),
                "it must be finite, U and V neither zero nor parallel",
            );
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Billboard;

    /// Frames whose numbers are not finite or that span no plane, by the public fields.
    #[test]
    fn bad_texture_frames_are_named() {
        let (o, u, v) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        let of = |o, u, v| {
            let mesh = Mesh {
                name: "wall".to_owned(),
                texture_frame: Some(TextureFrame { o, u, v }),
                ..Mesh::default()
            };
            mesh.check_shape().map_err(|error| error.to_string())
        };
        assert_eq!(of(o, u, v), Ok(()));
        for (o, u, v) in [
            (DVec3::NAN, u, v),
            (o, u * f64::INFINITY, v),
            (o, DVec3::ZERO, v),
            (o, u, u * -2.0),
        ] {
            let error = of(o, u, v).unwrap_err();
            assert!(
                error.contains("mesh 'wall'") && error.contains("texture frame"),
                "{error}"
            );
        }
    }

    #[test]
    fn bad_billboards_are_named() {
        let good = Billboard {
            position: DVec3::ZERO,
            size: [1.0; 2],
            facing: Facing::Screen,
        };
        for bad in [
            Billboard {
                size: [0.0, 1.0],
                ..good
            },
            Billboard {
                size: [1.0, f64::NAN],
                ..good
            },
            Billboard {
                position: DVec3::NAN,
                ..good
            },
            Billboard {
                facing: Facing::Axis(DVec3::ZERO),
                ..good
            },
        ] {
            let mesh = Mesh {
                name: "trees".to_owned(),
                billboards: vec![good, bad],
                ..Mesh::default()
            };
            let error = mesh.check_shape().unwrap_err();
            assert!(error.to_string().contains("'trees' billboard 1"), "{error}");
        }
    }
}
