//! Primitives to vertices and triangles: attributes, morph targets, skins.

use texmap_math::glam::{DMat3, DMat4, DVec3};
use texmap_math::parallel;

use super::json::{Mesh, Primitive};
use super::model::Model;
use super::slots::Sets;
use super::topology;
use crate::IoError;

/// The vertices and triangles of a primitive, in the space of its node or, with a skin, in the world.
#[derive(Debug, Clone, Default)]
pub(super) struct Geometry {
    pub(super) positions: Vec<[f32; 3]>,
    /// Empty where the file has none and none are needed.
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) second: Vec<[f32; 2]>,
    pub(super) colors: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Some vertex colour is not opaque.
    pub(super) clear_colors: bool,
    /// x, y, z and handedness, where the file has them.
    pub(super) tangents: Vec<[f32; 4]>,
    /// Positions are those of the world.
    pub(super) in_world: bool,
}

/// Deformation of a node's meshes: weights of morph targets and a skin.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    /// Weights of the morph targets.
    pub(super) weights: Vec<f64>,
    /// World from bind pose of each joint.
    pub(super) joints: Option<Vec<DMat4>>,
}

/// Selection of the coordinates and normals of a primitive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reads {
    pub(super) sets: Sets,
    pub(super) lit: bool,
    pub(super) tangents: bool,
}

/// Reads a primitive that consists of triangles; `at` is its pointer.
pub(super) fn geometry(
    model: &Model<'_>,
    primitive: &Primitive,
    shape: &Shape,
    reads: Reads,
    at: &str,
) -> Result<Geometry, IoError> {
    let attributes = Attributes {
        model,
        primitive,
        at,
    };
    let Some(positions) = attributes.read::<3>("POSITION", None)? else {
        return Err(model.broken(&format!("{at}/attributes"), "has no POSITION"));
    };
    let vertices = positions.len();
    let mut geometry = Geometry {
        positions,
        normals: attributes
            .read::<3>("NORMAL", Some(vertices))?
            .unwrap_or_default(),
        ..Geometry::default()
    };
    let set = |number: u32| attributes.read::<2>(&format!("TEXCOORD_{number}"), Some(vertices));
    geometry.uvs = set(reads.sets.first)?.unwrap_or_default();
    if let Some(second) = reads.sets.second {
        geometry.second = set(second)?.unwrap_or_default();
    }
    if reads.tangents {
        geometry.tangents = attributes
            .read::<4>("TANGENT", Some(vertices))?
            .unwrap_or_default();
    }
    colors(&attributes, &mut geometry)?;
    morph(&attributes, &shape.weights, &mut geometry)?;
    if let Some(joints) = &shape.joints {
        bend(&attributes, joints, &mut geometry)?;
    }
    geometry.triangles = topology::triangles(model, primitive, vertices, at)?;
    let mirrors = |joints: &Vec<DMat4>| joints.first().is_some_and(|j| j.determinant() < 0.0);
    if geometry.in_world && shape.joints.as_ref().is_some_and(mirrors) {
        geometry.turn_over();
    }
    if reads.lit && geometry.normals.is_empty() {
        model.ask(120 * geometry.triangles.len() as u64, at)?;
        geometry.facet();
    }
    Ok(geometry)
}

/// The attributes of a primitive.
struct Attributes<'p> {
    model: &'p Model<'p>,
    primitive: &'p Primitive,
    at: &'p str,
}

impl Attributes<'_> {
    fn read<const N: usize>(
        &self,
        name: &str,
        vertices: Option<usize>,
    ) -> Result<Option<Vec<[f32; N]>>, IoError> {
        let Some(index) = self.primitive.attributes.get(name) else {
            return Ok(None);
        };
        let accessor = self
            .model
            .accessor(*index, &format!("{}/attributes/{name}", self.at))?;
        if let Some(vertices) = vertices {
            accessor.expect(vertices, "vertices")?;
        }
        accessor.floats().map(Some)
    }
}

fn colors(attributes: &Attributes<'_>, geometry: &mut Geometry) -> Result<(), IoError> {
    let Some(index) = attributes.primitive.attributes.get("COLOR_0") else {
        return Ok(());
    };
    let accessor = attributes
        .model
        .accessor(*index, &format!("{}/attributes/COLOR_0", attributes.at))?;
    let vertices = geometry.positions.len();
    geometry.colors = match accessor.components() {
        3 => attributes
            .read::<3>("COLOR_0", Some(vertices))?
            .unwrap_or_default(),
        _ => {
            let four = attributes
                .read::<4>("COLOR_0", Some(vertices))?
                .unwrap_or_default();
            geometry.clear_colors = four.iter().any(|c| c[3] < 1.0);
            four.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
        }
    };
    // Light is not negative.
    geometry
        .colors
        .as_flattened_mut()
        .iter_mut()
        .for_each(|c| *c = c.max(0.0));
    Ok(())
}

/// Adds the displacements of morph targets by their weights.
fn morph(
    attributes: &Attributes<'_>,
    weights: &[f64],
    geometry: &mut Geometry,
) -> Result<(), IoError> {
    let vertices = geometry.positions.len();
    for (t, (target, weight)) in attributes.primitive.targets.iter().zip(weights).enumerate() {
        if *weight == 0.0 {
            continue;
        }
        let add = |name: &str, to: &mut [[f32; 3]]| {
            let Some(index) = target.get(name).filter(|_| !to.is_empty()) else {
                return Ok(());
            };
            let accessor = attributes
                .model
                .accessor(*index, &format!("{}/targets/{t}/{name}", attributes.at))?;
            accessor.expect(vertices, "vertices")?;
            for (value, moved) in to.iter_mut().zip(accessor.floats::<3>()?) {
                *value = std::array::from_fn(|i| {
                    (f64::from(value[i]) + weight * f64::from(moved[i])) as f32
                });
            }
            Ok(())
        };
        add("POSITION", &mut geometry.positions)?;
        add("NORMAL", &mut geometry.normals)?;
        let mut tangents: Vec<[f32; 3]> = geometry
            .tangents
            .iter()
            .map(|[x, y, z, _]| [*x, *y, *z])
            .collect();
        add("TANGENT", &mut tangents)?;
        for (to, [x, y, z]) in geometry.tangents.iter_mut().zip(tangents) {
            *to = [x, y, z, to[3]];
        }
    }
    Ok(())
}

/// Moves vertices by the weighted mean of the matrices of their joints.
fn bend(
    attributes: &Attributes<'_>,
    joints: &[DMat4],
    geometry: &mut Geometry,
) -> Result<(), IoError> {
    let vertices = geometry.positions.len();
    let bytes = 2 * size_of::<(DMat4, f64)>() * vertices;
    attributes.model.ask(bytes as u64, attributes.at)?;
    let mut sums = vec![(DMat4::ZERO, 0.0); vertices];
    let mut bound = false;
    for n in 0.. {
        let name = format!("JOINTS_{n}");
        let Some(indices) = attributes.read::<4>(&name, Some(vertices))? else {
            break;
        };
        let Some(weights) = attributes.read::<4>(&format!("WEIGHTS_{n}"), Some(vertices))? else {
            let problem = format!("has {name} but no WEIGHTS_{n}");
            return Err(attributes
                .model
                .broken(&format!("{}/attributes", attributes.at), problem));
        };
        bound = true;
        for ((sum, indices), weights) in sums.iter_mut().zip(indices).zip(weights) {
            for (index, weight) in indices.into_iter().zip(weights) {
                if !(weight > 0.0) {
                    continue;
                }
                let Some(joint) = joints.get(index as usize) else {
                    let pointer = format!("{}/attributes/{name}", attributes.at);
                    let problem = format!(
                        "joint {index} does not exist; the skin has {}",
                        joints.len()
                    );
                    return Err(attributes.model.broken(&pointer, problem));
                };
                sum.0 += *joint * f64::from(weight);
                sum.1 += f64::from(weight);
            }
        }
    }
    if !bound {
        return Ok(());
    }
    let first = joints.first().copied().unwrap_or(DMat4::IDENTITY);
    let matrices: Vec<DMat4> = sums
        .into_iter()
        .map(|(sum, weight)| {
            if weight > 0.0 {
                sum * (1.0 / weight)
            } else {
                first
            }
        })
        .collect();
    for (position, matrix) in geometry.positions.iter_mut().zip(&matrices) {
        let moved = matrix.transform_point3(wide(*position)).as_vec3();
        *position = moved.to_array();
    }
    for (normal, matrix) in geometry.normals.iter_mut().zip(&matrices) {
        let linear = DMat3::from_mat4(*matrix);
        // The inverse transpose times the determinant, which needs no division.
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let sign = if linear.determinant() < 0.0 {
            -1.0
        } else {
            1.0
        };
        let turned = cofactors * wide(*normal) * sign;
        *normal = turned.normalize_or_zero().as_vec3().to_array();
    }
    for ([x, y, z, _], matrix) in geometry.tangents.iter_mut().zip(&matrices) {
        let turned = matrix.transform_vector3(wide([*x, *y, *z]));
        [*x, *y, *z] = turned.normalize_or_zero().as_vec3().to_array();
    }
    geometry.in_world = true;
    if let Some(i) = geometry
        .positions
        .iter()
        .position(|p| p.iter().any(|x| !x.is_finite()))
    {
        return Err(attributes.model.broken(
            attributes.at,
            format!("the skin moves vertex {i} beyond 32-bit floats"),
        ));
    }
    Ok(())
}

impl Geometry {
    /// Exchanges fronts and backs.
    fn turn_over(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }

    /// Gives every triangle vertices and a normal of its own.
    fn facet(&mut self) {
        fn split<T: Copy + Default + Send + Sync>(values: &mut Vec<T>, triangles: &[[u32; 3]]) {
            if !values.is_empty() {
                let corners = triangles.as_flattened();
                *values =
                    parallel::list(corners.len(), T::default(), |i| values[corners[i] as usize]);
            }
        }
        split(&mut self.positions, &self.triangles);
        split(&mut self.uvs, &self.triangles);
        split(&mut self.second, &self.triangles);
        split(&mut self.colors, &self.triangles);
        // Tangents without normals are those of no surface.
        self.tangents.clear();
        let corners = self.positions.as_chunks::<3>().0;
        let normals = parallel::list(corners.len(), [[0.0; 3]; 3], |i| {
            let [a, b, c] = &corners[i];
            let normal = (wide(*b) - wide(*a)).cross(wide(*c) - wide(*a));
            [crate::obj::unit(normal)
                .unwrap_or(DVec3::ZERO)
                .as_vec3()
                .to_array(); 3]
        });
        self.normals = normals.into_flattened();
        self.triangles = parallel::list(self.triangles.len(), [0; 3], |t| {
            [3 * t, 3 * t + 1, 3 * t + 2].map(|i| i as u32)
        });
    }
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

/// The weights of the morph targets of a mesh, of its node or at rest.
pub(super) fn weights(mesh: &Mesh, node: Option<&Vec<f64>>) -> Vec<f64> {
    node.unwrap_or(&mesh.weights).clone()
}

/// World from bind pose for every joint of a skin.
pub(super) fn joints(
    model: &Model<'_>,
    skin: usize,
    world: &[DMat4],
    pointer: &str,
) -> Result<Vec<DMat4>, IoError> {
    let stated = model.item(&model.document.skins, skin, pointer, "skin")?;
    let at = format!("/skins/{skin}");
    let from_bind = match stated.inverse_bind_matrices {
        None => Vec::new(),
        Some(index) => {
            let accessor = model.accessor(index, &format!("{at}/inverseBindMatrices"))?;
            let matrices = accessor.floats::<16>()?;
            if matrices.len() < stated.joints.len() {
                let problem = format!(
                    "{} matrices for {} joints",
                    matrices.len(),
                    stated.joints.len()
                );
                return Err(model.broken(&format!("{at}/inverseBindMatrices"), problem));
            }
            matrices
        }
    };
    let joint = |(i, node): (usize, &usize)| {
        let place = model.item(world, *node, &format!("{at}/joints/{i}"), "node")?;
        Ok(match from_bind.get(i) {
            Some(matrix) => *place * DMat4::from_cols_array(&matrix.map(f64::from)),
            None => *place,
        })
    };
    stated.joints.iter().enumerate().map(joint).collect()
}
