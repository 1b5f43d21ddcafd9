//! Skinning: a mesh that follows bones, by linear blends of their matrices. Source: Magnenat-Thalmann, Laperriere and
//! Thalmann 1988.
//!
//! `P' = sum(w_i M_i) P`, with weights that sum to one. It is what every graphics processor's vertex stage does, and it loses
//! volume where bones bend: blending two rotations shrinks. For a bend by an angle `a` whose weights change linearly over a
//! band of width `b`, a limb of constant symmetric section `s` loses the volume `s b (1 - cos a) / 6`.

use texmap_math::glam::{DMat3, DMat4, DVec3};
use texmap_math::{deterministic_f64, narrow, wide};

use crate::{MeshError, map_vertices};
use texmap_scene::Mesh;
use texmap_scene::SceneError;

/// Up to four bones and their weights for each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Bones of each vertex; those of weight 0 are not read.
    pub bones: Vec<[u16; 4]>,
    /// Weights of each vertex: not negative, and of sum 1 within [`Skin::TOLERANCE`].
    pub weights: Vec<[f32; 4]>,
}

/// A bone at rest, in the space of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bone {
    /// The joint of the bone with its parent, about which the bone turns.
    pub head: DVec3,
    /// The other end of the bone.
    pub tail: DVec3,
    /// The bone that it follows: one before it in the list.
    pub parent: Option<usize>,
}

/// Assignment of vertices to bones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SkinBlend {
    /// Each follows its nearest bone alone: parts stay rigid, and joints open or overlap.
    Rigid,
    /// Within a band of this width about each joint, along the child, weights change linearly from parent to child.
    Smooth(f64),
}

/// Bones, parents first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// The bones.
    pub bones: Vec<Bone>,
}

impl Skin {
    /// Largest difference of the sum of a vertex's weights from 1; what is left of it is divided out.
    pub const TOLERANCE: f32 = 1e-3;

    /// With every vertex's weights divided by their sum: for files whose weights do not sum to one. Weights that sum to nothing
    /// finite and positive stay as they are, for [`bend`](Self::bend) to name.
    #[must_use]
    pub fn normalized(mut self) -> Self {
        for weights in &mut self.weights {
            let sum: f32 = weights.iter().sum();
            if sum > 0.0 && sum.is_finite() {
                *weights = weights.map(|w| w / sum);
            }
        }
        self
    }

    /// The mesh in a pose: `pose[i]` moves what follows bone i from where it rests, in object space.
    ///
    /// Tangents go by the blended matrix, normals by its cofactors, so they stay right under uneven scales, and zero where it is
    /// flattened to a line. The same bytes for any number of threads.
    ///
    /// # Errors
    /// Names the mesh and the first vertex whose weights are negative, not finite or do not sum to one, or whose bone does not
    /// exist; and bones whose matrix is not finite.
    pub fn bend(&self, mesh: &Mesh, pose: &[DMat4]) -> Result<Mesh, MeshError> {
        self.check(mesh, pose)?;
        map_vertices(mesh, |index, mut vertex| {
            let v = index as usize;
            let (bones, weights) = (self.bones[v], self.weights[v].map(f64::from));
            let sum: f64 = weights.iter().sum();
            let mut matrix = DMat4::ZERO;
            for (bone, weight) in bones.iter().zip(weights).filter(|(_, w)| *w != 0.0) {
                matrix += pose[usize::from(*bone)] * (weight / sum);
            }
            vertex.position = narrow(matrix.transform_point3(wide(vertex.position)));
            let linear = DMat3::from_mat4(matrix);
            if vertex.normal != [0.0; 3] {
                vertex.normal =
                    narrow((cofactors(linear) * wide(vertex.normal)).normalize_or_zero());
            }
            let [x, y, z, sign] = vertex.tangent;
            let [x, y, z] = narrow((linear * wide([x, y, z])).normalize_or_zero());
            vertex.tangent = [x, y, z, sign];
            vertex
        })
    }

    fn check(&self, mesh: &Mesh, pose: &[DMat4]) -> Result<(), MeshError> {
        for (what, found) in [
            ("bone lists", self.bones.len()),
            ("weight lists", self.weights.len()),
        ] {
            if found != mesh.positions.len() {
                return Err(SceneError::Count {
                    mesh: mesh.name.clone(),
                    what,
                    found,
                    of: "vertices",
                    expected: mesh.positions.len(),
                }
                .into());
            }
        }
        let value = |place: String, what: &str, value: String, expected| {
            Err(SceneError::Value {
                place,
                what: what.to_owned(),
                value,
                expected,
            }
            .into())
        };
        if let Some(i) = pose.iter().position(|m| !m.is_finite()) {
            return value(
                format!("bone {i}"),
                "matrix",
                pose[i].to_string(),
                "it must be finite",
            );
        }
        for (v, (bones, weights)) in self.bones.iter().zip(&self.weights).enumerate() {
            let place = || format!("mesh '{}' vertex {v}", mesh.name);
            if !weights.iter().all(|w| *w >= 0.0 && w.is_finite()) {
                return value(
                    place(),
                    "weights",
                    format!("{weights:?}"),
                    "they must be finite and not negative",
                );
            }
            let sum: f32 = weights.iter().sum();
            if (sum - 1.0).abs() > Self::TOLERANCE {
                return value(
                    place(),
                    "sum of the weights",
                    sum.to_string(),
                    "it must be 1, or the vertex is drawn towards the origin: Skin::normalized divides by it",
                );
            }
            for (bone, _) in bones.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
                if usize::from(*bone) >= pose.len() {
                    return Err(SceneError::Index {
                        place: place(),
                        what: "bone",
                        index: u64::from(*bone),
                        count: pose.len(),
                    }
                    .into());
                }
            }
        }
        Ok(())
    }
}

impl Skeleton {
    /// Bones that a vertex can name.
    pub const MAX_BONES: usize = 1 << 16;

    /// The matrices of a pose for [`Skin::bend`]. `turns[i]` is applied to bone i about its head, and to all that follow it.
    ///
    /// # Errors
    /// As many turns as bones are needed, and parents must come before their children.
    pub fn pose(&self, turns: &[DMat4]) -> Result<Vec<DMat4>, MeshError> {
        let mut pose: Vec<DMat4> = Vec::with_capacity(self.bones.len());
        for (i, bone) in self.bones.iter().enumerate() {
            let index = |what, index: usize, count| SceneError::Index {
                place: format!("bone {i}"),
                what,
                index: index as u64,
                count,
            };
            let turn = turns.get(i).ok_or_else(|| index("turn", i, turns.len()))?;
            let about =
                DMat4::from_translation(bone.head) * *turn * DMat4::from_translation(-bone.head);
            pose.push(match bone.parent {
                None => about,
                Some(parent) => {
                    *pose.get(parent).ok_or_else(|| index("parent", parent, i))? * about
                }
            });
        }
        Ok(pose)
    }

    /// Weights from where the vertices lie: the nearest bone, softened about the joints as `blend` says. Of several near joints
    /// the one that mixes most counts. Bones beyond [`MAX_BONES`](Self::MAX_BONES) have no vertices.
    #[must_use]
    pub fn skin(&self, positions: &[[f32; 3]], blend: SkinBlend) -> Skin {
        let mut skin = Skin::default();
        for position in positions {
            let p = wide(*position);
            let (own, other, share) = self.nearest(p).map_or((0, 0, 0.0), |own| match blend {
                SkinBlend::Rigid => (own, own, 0.0),
                SkinBlend::Smooth(width) => self.mixed(p, own, width),
            });
            skin.bones.push([own as u16, other as u16, 0, 0]);
            skin.weights
                .push([(1.0 - share) as f32, share as f32, 0.0, 0.0]);
        }
        skin
    }

    /// The first of the nearest bones.
    fn nearest(&self, p: DVec3) -> Option<usize> {
        let distance = |bone: &Bone| {
            let along = bone.tail - bone.head;
            let t = ((p - bone.head).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            // A bone of no length is a point.
            let t = if t.is_nan() { 0.0 } else { t };
            (p - bone.head - along * t).length_squared()
        };
        (0..self.bones.len().min(Self::MAX_BONES))
            .min_by(|&a, &b| distance(&self.bones[a]).total_cmp(&distance(&self.bones[b])))
    }

    /// A vertex's bone, the one at the other side of its nearest joint, and the share of that one.
    fn mixed(&self, p: DVec3, own: usize, width: f64) -> (usize, usize, f64) {
        let mut best = (own, own, 0.0);
        for (child, bone) in self.bones.iter().take(Self::MAX_BONES).enumerate() {
            let Some(parent) = bone.parent.filter(|parent| child == own || *parent == own) else {
                continue;
            };
            let past = (p - bone.head).dot((bone.tail - bone.head).normalize_or_zero());
            let of_child = (0.5 + past / width).clamp(0.0, 1.0);
            let (other, share) = if child == own {
                (parent, 1.0 - of_child)
            } else {
                (child, of_child)
            };
            if share > best.2 {
                best = (own, other, share);
            }
        }
        best
    }
}

/// A turn by an angle (radians) about an axis through the origin, counter-clockwise when the axis points at the
/// viewer. The identity for an axis of no length. Source: Rodrigues 1840.
#[must_use]
pub fn rotation(axis: DVec3, angle: f64) -> DMat4 {
    // The square of the length of some vectors is beyond the numbers.
    let sized = || (axis / axis.abs().max_element()).try_normalize();
    let Some(axis) = axis.try_normalize().or_else(sized) else {
        return DMat4::IDENTITY;
    };
    rotation_about(axis, deterministic_f64::sin_cos(angle))
}

/// [`rotation`] about an axis of unit length, by the sine and cosine of the angle.
#[must_use]
pub fn rotation_about(axis: DVec3, (sin, cos): (f64, f64)) -> DMat4 {
    let column = |e: DVec3| e * cos + axis.cross(e) * sin + axis * (axis.dot(e) * (1.0 - cos));
    DMat4::from_mat3(DMat3::from_cols(
        column(DVec3::X),
        column(DVec3::Y),
        column(DVec3::Z),
    ))
}

/// The inverse transpose times the determinant: there is one for every matrix.
fn cofactors(m: DMat3) -> DMat3 {
    DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arm() -> Skeleton {
        let bone = |from: f64, to: f64, parent| Bone {
            head: DVec3::X * from,
            tail: DVec3::X * to,
            parent,
        };
        Skeleton {
            bones: vec![bone(-2.0, 0.0, None), bone(0.0, 2.0, Some(0))],
        }
    }

    fn rod() -> Mesh {
        Mesh {
            name: "rod".into(),
            positions: (-4..=4).map(|i| [i as f32 * 0.5, 0.25, 0.0]).collect(),
            normals: vec![[0.0, 1.0, 0.0]; 9],
            ..Mesh::default()
        }
    }

    #[test]
    fn weights_run_from_bone_to_bone_and_the_end_turns() {
        let skin = arm().skin(&rod().positions, SkinBlend::Smooth(2.0));
        let of_child: Vec<f32> = skin
            .bones
            .iter()
            .zip(&skin.weights)
            .map(|(b, w)| (0..4).filter(|&i| b[i] == 1).map(|i| w[i]).sum())
            .collect();
        assert_eq!(of_child, [0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0]);
        let quarter = [
            DMat4::IDENTITY,
            rotation(DVec3::Z, std::f64::consts::FRAC_PI_2),
        ];
        let bent = skin.bend(&rod(), &arm().pose(&quarter).unwrap()).unwrap();
        let close = |a: [f32; 3], b: [f32; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 1e-6);
        assert!(
            close(bent.positions[8], [-0.25, 2.0, 0.0]),
            "{:?}",
            bent.positions[8]
        );
        assert!(
            close(bent.normals[8], [-1.0, 0.0, 0.0]),
            "{:?}",
            bent.normals[8]
        );
        assert!(close(bent.positions[0], rod().positions[0]));
        // Half of each: half way along the chord, not on the arc.
        assert!(
            close(bent.positions[4], [-0.125, 0.125, 0.0]),
            "{:?}",
            bent.positions[4]
        );
        let rigid = arm().skin(&rod().positions, SkinBlend::Rigid);
        assert!(rigid.weights.iter().all(|w| *w == [1.0, 0.0, 0.0, 0.0]));
    }

    #[test]
    fn normals_are_square_to_the_bent_surface() {
        let skin = Skin {
            bones: vec![[0; 4]; 9],
            weights: vec![[1.0, 0.0, 0.0, 0.0]; 9],
        };
        let mut mesh = rod();
        mesh.normals = vec![[0.6, 0.8, 0.0]; 9];
        let uneven = DMat4::from_scale(DVec3::new(4.0, 1.0, 1.0));
        let bent = skin.bend(&mesh, &[uneven]).unwrap();
        let n = bent.normals[3];
        // The tangent (0.8, -0.6) becomes (3.2, -0.6).
        assert!((n[0] * 3.2 - n[1] * 0.6).abs() < 1e-6, "{n:?}");
        let flat = skin
            .bend(&mesh, &[DMat4::from_scale(DVec3::new(1.0, 0.0, 0.0))])
            .unwrap();
        assert!(flat.normals.is_empty() || flat.normals[0] == [0.0; 3]);
    }

    #[test]
    fn bad_weights_and_bones_are_named() {
        let good = arm().skin(&rod().positions, SkinBlend::Smooth(1.0));
        let pose = [DMat4::IDENTITY; 2];
        let with = |weights: [f32; 4], bones: [u16; 4]| {
            let mut skin = good.clone();
            (skin.weights[5], skin.bones[5]) = (weights, bones);
            skin
        };
        for (skin, word) in [
            (
                with([0.5, 0.6, 0.0, 0.0], [0, 1, 0, 0]),
                "sum of the weights is 1.1",
            ),
            (with([0.0; 4], [0; 4]), "sum of the weights is 0"),
            (with([f32::NAN, 0.0, 0.0, 0.0], [0; 4]), "finite"),
            (with([1.5, -0.5, 0.0, 0.0], [0, 1, 0, 0]), "not negative"),
            (
                with([0.5, 0.5, 0.0, 0.0], [0, 7, 0, 0]),
                "bone 7 does not exist",
            ),
        ] {
            let error = skin.bend(&rod(), &pose).unwrap_err().to_string();
            assert!(
                error.contains("'rod' vertex 5") && error.contains(word),
                "{error}"
            );
        }
        let heavy = with([2.0, 2.0, 0.0, 0.0], [0, 1, 0, 0]).normalized();
        assert_eq!(heavy.weights[5], [0.5, 0.5, 0.0, 0.0]);
        assert!(heavy.bend(&rod(), &pose).is_ok());
        // A bone that nobody weighs need not exist.
        assert!(
            with([1.0, 0.0, 0.0, 0.0], [0, 9, 9, 9])
                .bend(&rod(), &pose)
                .is_ok()
        );
        assert!(good.bend(&rod(), &[DMat4::NAN; 2]).is_err());
        assert!(
            Skin::default()
                .bend(&rod(), &pose)
                .unwrap_err()
                .to_string()
                .contains("bone lists")
        );
        let mut cycle = arm();
        cycle.bones[0].parent = Some(1);
        assert!(cycle.pose(&pose).is_err() && arm().pose(&pose[..1]).is_err());
    }

    #[test]
    fn axes_of_any_length_turn() {
        let quarter = core::f64::consts::FRAC_PI_2;
        let right = rotation(DVec3::new(1.0, 2.0, -0.5), quarter);
        for length in [1e-200, 1e200] {
            let turned = rotation(DVec3::new(1.0, 2.0, -0.5) * length, quarter);
            assert!(turned.abs_diff_eq(right, 1e-12), "{length}");
        }
        assert_eq!(rotation(DVec3::ZERO, quarter), DMat4::IDENTITY);
    }
}
