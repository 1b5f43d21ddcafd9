//! Map shape times map entity: the entity chooses a vector at each vertex, the shape maps it.
//!
//! The table of R. Wolfe (SIGGRAPH 97 education slides), and Bier and Sloan (1986) for the useful pairs.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::glam::{DMat3, DVec3};
use texmap_math::{Level, float};

use crate::mesh::{Mesh, length, unit_or_zero};
use crate::placement::{PlacedFrame, Placement};
use crate::solid::{Origin, Shape, ShapeFace};
use crate::uv_set::UvSet;
use crate::{UvError, parallel, plane, seam_unwrap, spherical};

/// Magnitudes of factors that leave coordinates within 32-bit numbers.
pub(crate) const FACTORS: core::ops::RangeInclusive<f64> = 1e-30..=1e30;

/// The vector that a shape maps to texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ProjectionSource {
    /// The position in the frame, moved along the normals of the shape. A plane drops z, a cylinder the distance
    /// from its axis, and a box takes the side that each face's own normal is nearest to (Bier and Sloan's
    /// "intermediate surface normal").
    #[default]
    Position,
    /// The vertex normal, as a ray from the middle of the shape.
    Normal,
    /// The vector from the centroid of the surface (area-weighted) to the vertex, as a ray from the middle.
    Centroid,
    /// The direction in which an eye sees the surrounding reflected at the vertex, as a ray from the middle.
    Reflection {
        /// Position of the eye, in object space.
        eye: DVec3,
    },
}

/// A way to give a mesh texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// The shape around the object.
    pub shape: Shape,
    /// The vector that is mapped.
    pub by: ProjectionSource,
    /// Placement of the shape. `None` fits it to the bounding box: a plane and a box fill it, a cylinder and a cone
    /// keep their round section, a sphere stays round. An axis without extent maps to the middle. A plane by position
    /// turns to the surface: along the normal of a flat one, else along z, or along y or x where that sees it more than
    /// twice as squarely.
    pub frame: Option<Placement>,
    /// For a plane by position: the size of one picture in object units; u and v then count pictures from the
    /// frame's (or the object's) origin and are left unbounded, to be wrapped by the sampler. Without a frame the plane
    /// looks along z, y or x, as above.
    pub tile: Option<[f64; 2]>,
    /// Number of repeats of the picture on each part.
    pub repeat: [f64; 2],
    /// Unwrap faces across the seam and fan the poles. Without it every vertex has the u of its own formula.
    pub fix_seams: bool,
    /// The faces that a cylinder or cone sees from above or below are on its caps, each a picture of its own. Without caps they belong to
    /// the side, as those of a lathe or a label that runs over the edge do.
    pub caps: bool,
    /// The row at v = 0.
    pub origin: Origin,
}

/// A mapped mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedMesh {
    /// The coordinates.
    pub set: UvSet,
    /// Faces that enclose the axis of a round shape: no vertex coordinates map them right. Divide them there.
    pub around_axis: Vec<u32>,
}

impl Mapping {
    /// `shape` fitted to the object, by position, seams repaired, v = 0 at the top.
    #[must_use]
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            by: ProjectionSource::Position,
            frame: None,
            tile: None,
            repeat: [1.0; 2],
            fix_seams: true,
            caps: true,
            origin: Origin::TopLeft,
        }
    }

    /// Plane by its own normal: a picture projected onto the surface, along z where that sees enough of it.
    #[must_use]
    pub fn slide_projector() -> Self {
        Self::new(Shape::Plane)
    }

    /// Cylinder by its own normals: film shrunk onto the object.
    #[must_use]
    pub fn shrink_wrap() -> Self {
        Self::new(Shape::Cylinder)
    }

    /// Sphere by the vector from the centroid.
    #[must_use]
    pub fn sphere_by_centroid() -> Self {
        Self {
            by: ProjectionSource::Centroid,
            ..Self::new(Shape::Sphere)
        }
    }

    /// Box by its own normals.
    #[must_use]
    pub fn box_by_intermediate_normal() -> Self {
        Self::new(Shape::Box)
    }

    /// Box by the vector from the centroid.
    #[must_use]
    pub fn box_by_centroid() -> Self {
        Self {
            by: ProjectionSource::Centroid,
            ..Self::new(Shape::Box)
        }
    }

    /// The sphere around the bounding box: texture by the direction from its middle alone (SUSTech lecture 08).
    #[must_use]
    pub fn bounding_sphere() -> Self {
        Self::new(Shape::Sphere)
    }

    /// Maps the mesh. `normals` is empty (computed: area-weighted) or has one entry per position; only
    /// [`ProjectionSource::Normal`] and [`ProjectionSource::Reflection`] read it.
    ///
    /// A vertex whose vector is zero (at the centroid, without a normal) lies on the axis: with
    /// [`Mapping::fix_seams`] it takes the mean u of its face, else u = 0.5. The same bytes on every SIMD level and
    /// thread count.
    ///
    /// # Errors
    /// A frame without size, a repeat or tile that is not finite or zero, normals of a wrong number.
    pub fn map(
        &self,
        level: Level,
        mesh: &Mesh<'_>,
        normals: &[[f32; 3]],
    ) -> Result<MappedMesh, UvError> {
        self.check(mesh, normals)?;
        let placed = self.placed(mesh)?;
        let vectors = self.vectors(mesh, normals, &placed);
        let round = self.round(level, &vectors)?;
        let faces = mesh.faces();
        let mapped = parallel::map_chunks(faces.len(), |range| {
            let (mut values, mut around_axis) = (Vec::new(), Vec::new());
            let (mut us, mut poles) = (Vec::new(), Vec::new());
            for face in range {
                let part = self.part(mesh, &placed, &vectors, face);
                let corners = faces.face(face);
                let start = values.len();
                if self.is_round(part) {
                    values.extend(corners.iter().map(|&i| round[i as usize]));
                    if self.fix_seams {
                        us.clear();
                        us.extend(values[start..].iter().map(|uv| uv[0]));
                        poles.clear();
                        poles.extend(corners.iter().map(|&i| on_axis(vectors[i as usize])));
                        if !seam_unwrap::unwrap(&mut us, &poles) {
                            around_axis.push(face as u32);
                        }
                        for (value, u) in values[start..].iter_mut().zip(&us) {
                            value[0] = *u;
                        }
                    }
                } else {
                    values.extend(
                        corners
                            .iter()
                            .map(|&i| self.flat(part, vectors[i as usize])),
                    );
                }
                for value in &mut values[start..] {
                    *value =
                        core::array::from_fn(|i| (f64::from(value[i]) * self.repeat[i]) as f32);
                }
            }
            (values, around_axis)
        });
        let mut values = Vec::with_capacity(faces.corners().len());
        let mut around_axis = Vec::new();
        for (chunk, around) in mapped {
            values.extend(chunk);
            around_axis.extend(around);
        }
        Ok(MappedMesh {
            set: UvSet::shared(mesh, &values),
            around_axis,
        })
    }

    fn check(&self, mesh: &Mesh<'_>, normals: &[[f32; 3]]) -> Result<(), UvError> {
        let expected = mesh.positions().len();
        if !normals.is_empty() && normals.len() != expected {
            return Err(UvError::WrongLength {
                what: "the list of normals",
                found: normals.len(),
                expected,
            });
        }
        for (what, values) in [
            ("repeat", self.repeat),
            ("tile size", self.tile.unwrap_or([1.0; 2])),
        ] {
            // Coordinates are 32-bit numbers.
            let usable = |v: f64| FACTORS.contains(&v.abs());
            if let Some(value) = values.iter().find(|v| !usable(**v)) {
                return Err(UvError::BadParameter {
                    what,
                    value: *value,
                });
            }
        }
        match self.by {
            ProjectionSource::Reflection { eye } if !eye.is_finite() => {
                Err(UvError::BadParameter {
                    what: "eye",
                    value: eye.x + eye.y + eye.z,
                })
            }
            _ => Ok(()),
        }
    }

    fn placed(&self, mesh: &Mesh<'_>) -> Result<PlacedFrame, UvError> {
        if let Some(frame) = &self.frame {
            return frame.placed();
        }
        let rotation = if self.shape == Shape::Plane && self.by == ProjectionSource::Position {
            plane::view(mesh, self.tile.is_none())
        } else {
            DMat3::IDENTITY
        };
        if self.tile.is_some() {
            return Ok(PlacedFrame::fitted(DVec3::ZERO, DVec3::ONE, rotation));
        }
        let (low, high) = mesh.bounds(&rotation);
        let extent = high - low;
        let wide = extent.x.max(extent.z);
        let size = match self.shape {
            Shape::Plane | Shape::Box => extent,
            Shape::Cylinder | Shape::Cone => DVec3::new(wide, extent.y, wide),
            Shape::Sphere => DVec3::splat(wide.max(extent.y)),
        };
        let middle = rotation * ((low + high) * 0.5);
        Ok(PlacedFrame::fitted(middle, size, rotation))
    }

    /// The vector of every position, in the space of the unit solid.
    fn vectors(&self, mesh: &Mesh<'_>, normals: &[[f32; 3]], placed: &PlacedFrame) -> Vec<DVec3> {
        let positions = mesh
            .positions()
            .iter()
            .map(|p| DVec3::from(p.map(f64::from)));
        let normals = || -> Vec<DVec3> {
            if normals.is_empty() {
                return mesh.vertex_normals();
            }
            normals
                .iter()
                .map(|n| unit_or_zero(DVec3::from(n.map(f64::from))))
                .collect()
        };
        // A position that no face uses may be NaN; it must not reach the arithmetic.
        let clean = |v: DVec3| if v.is_finite() { v } else { DVec3::ZERO };
        match self.by {
            ProjectionSource::Position => positions.map(|p| clean(placed.point(p))).collect(),
            ProjectionSource::Normal => normals()
                .into_iter()
                .map(|n| clean(placed.turn(n)))
                .collect(),
            ProjectionSource::Centroid => {
                let centroid = centroid(mesh);
                positions
                    .map(|p| clean(placed.direction(p - centroid)))
                    .collect()
            }
            ProjectionSource::Reflection { eye } => {
                let reflected = positions.zip(normals()).map(|(p, n)| {
                    let seen = unit_or_zero(p - eye);
                    clean(placed.turn(seen - n * (2.0 * n.dot(seen))))
                });
                reflected.collect()
            }
        }
    }

    /// Coordinates of every vector on the round part of the shape, by the lane kernels.
    fn round(&self, level: Level, vectors: &[DVec3]) -> Result<Vec<[f32; 2]>, UvError> {
        if !self.is_round(ShapeFace::Side) && !self.is_round(ShapeFace::Whole) {
            return Ok(Vec::new());
        }
        let on_surface = |v: &DVec3| {
            let p = if self.by == ProjectionSource::Position
                || *v == DVec3::ZERO
                || self.shape == Shape::Sphere
            {
                *v
            } else {
                self.cast_side(*v)
            };
            p.to_array().map(|c| c as f32)
        };
        let points: Vec<[f32; 3]> = vectors.iter().map(on_surface).collect();
        let mut out = vec![[0.0; 2]; points.len()];
        match self.shape {
            Shape::Sphere => spherical::sphere_uv_batch(level, &points, self.origin, &mut out)?,
            _ => spherical::cylinder_uv_batch(level, &points, self.origin, &mut out)?,
        }
        Ok(out)
    }

    /// The ray along `d` on the side of a cylinder or cone, even where it would meet a cap first. Its height is
    /// kept within the solid.
    fn cast_side(&self, d: DVec3) -> DVec3 {
        let out = float::sqrt(d.x * d.x + d.z * d.z);
        let reach = if self.shape == Shape::Cone {
            2.0 * out + d.y
        } else {
            out
        };
        let h = if reach > 0.0 {
            0.5 * d.y / reach
        } else {
            d.y * f64::INFINITY
        };
        let h = if h > 0.5 {
            0.5
        } else if h >= -0.5 {
            h
        } else {
            -0.5
        };
        DVec3::new(d.x, h, d.z)
    }

    fn is_round(&self, part: ShapeFace) -> bool {
        match self.shape {
            Shape::Sphere => true,
            Shape::Cylinder | Shape::Cone => part == ShapeFace::Side,
            Shape::Plane | Shape::Box => false,
        }
    }

    /// The one part that a face is mapped to: by its normal where positions are mapped, else by its mean vector.
    fn part(
        &self,
        mesh: &Mesh<'_>,
        placed: &PlacedFrame,
        vectors: &[DVec3],
        face: usize,
    ) -> ShapeFace {
        if matches!(self.shape, Shape::Plane | Shape::Sphere) {
            return ShapeFace::Whole;
        }
        if !self.caps && self.is_round(ShapeFace::Side) {
            return ShapeFace::Side;
        }
        let mean: DVec3 = mesh
            .faces()
            .face(face)
            .iter()
            .map(|&i| vectors[i as usize])
            .sum();
        let normal = unit_or_zero(placed.normal(mesh.face_normal(face)));
        match (self.by, self.shape) {
            (ProjectionSource::Position, Shape::Box) => {
                ShapeFace::facing(if normal == DVec3::ZERO { mean } else { normal })
            }
            (ProjectionSource::Position, _)
                if normal.y > core::f64::consts::FRAC_1_SQRT_2 && self.shape == Shape::Cylinder =>
            {
                ShapeFace::Top
            }
            (ProjectionSource::Position, _) if normal.y < -core::f64::consts::FRAC_1_SQRT_2 => {
                ShapeFace::Bottom
            }
            (ProjectionSource::Position, _) => ShapeFace::Side,
            (_, shape) if mean == DVec3::ZERO => {
                if shape == Shape::Box {
                    ShapeFace::Front
                } else {
                    ShapeFace::Side
                }
            }
            (_, shape) => shape.cast(mean).0,
        }
    }

    /// Texture coordinates of a vector on a flat part.
    fn flat(&self, part: ShapeFace, v: DVec3) -> [f32; 2] {
        let place = if self.by == ProjectionSource::Position {
            let mut place = part.flat(v);
            if let Some([width, height]) = self.tile {
                place.u = v.x / width;
                place.h = v.y / height - 0.5;
            }
            place
        } else if self.shape == Shape::Plane {
            part.flat(if v == DVec3::ZERO {
                v
            } else {
                self.shape.cast(v).1
            })
        } else {
            // Onto the part's plane; a vector that hardly points there is held at 87 degrees.
            let (along, least) = (v.dot(part.outward()), 0.05 * length(v));
            let along = if along > least { along } else { least };
            part.flat(if along > 0.0 { v * (0.5 / along) } else { v })
        };
        place.uv(self.origin).map(|c| c as f32)
    }
}

/// Within a ten-millionth of its length of the y axis: no longitude that means anything.
fn on_axis(v: DVec3) -> bool {
    v.x * v.x + v.z * v.z <= 1e-14 * v.y * v.y
}

/// Area-weighted centroid of the surface; the mean of the corners where there is no area.
fn centroid(mesh: &Mesh<'_>) -> DVec3 {
    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
    for (_, corners) in mesh.faces().triangles() {
        let [a, b, c] = corners.map(|k| mesh.point(k));
        let area = length((b - a).cross(c - a));
        sum += (a + b + c) * (area / 3.0);
        total += area;
    }
    if total > 0.0 {
        return sum / total;
    }
    let corners = mesh.faces().corners();
    corners.iter().map(|&i| mesh.vertex(i)).sum::<DVec3>() / corners.len() as f64
}

/// The position of `x` within its tile of `size`, in [0, 1): floored modulo, also for negative `x`. `None` for a size
/// that is not positive, or values that are not finite.
#[must_use]
pub fn tile(x: f64, size: f64) -> Option<f64> {
    if !(size > 0.0 && size.is_finite() && x.is_finite()) {
        return None;
    }
    let share = x / size;
    let rest = share - float::floor(share);
    // A tiny negative share rounds up to a whole tile.
    Some(if rest < 1.0 { rest } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_use_the_floored_modulo() {
        assert_eq!(tile(-0.25, 1.0), Some(0.75));
        assert_eq!(tile(7.0, 2.0), Some(0.5));
        assert_eq!(tile(-1e-17, 1.0), Some(0.0));
        assert_eq!(tile(1.0, 0.0), None);
        assert_eq!(tile(f64::NAN, 1.0), None);
    }

    #[test]
    fn the_axis_is_told_from_its_surroundings() {
        assert!(on_axis(DVec3::ZERO) && on_axis(DVec3::new(1e-9, 1.0, 0.0)));
        assert!(!on_axis(DVec3::new(1e-6, 1.0, 0.0)) && !on_axis(DVec3::X));
    }
}
