//! The tree of nodes and their transforms to the world.

use texmap_math::glam::{DMat3, DMat4, DVec3};

use super::json::Node;
use super::model::Model;
use crate::IoError;

/// Translation, rotation and scale of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trs {
    pub(super) translation: [f64; 3],
    /// A quaternion x, y, z, w of any length.
    pub(super) rotation: [f64; 4],
    pub(super) scale: [f64; 3],
}

impl Default for Trs {
    fn default() -> Self {
        Self {
            translation: [0.0; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
            scale: [1.0; 3],
        }
    }
}

impl Trs {
    pub(super) fn of(node: &Node) -> Self {
        let rest = Self::default();
        Self {
            translation: node.translation.unwrap_or(rest.translation),
            rotation: node.rotation.unwrap_or(rest.rotation),
            scale: node.scale.unwrap_or(rest.scale),
        }
    }

    pub(super) fn matrix(&self) -> DMat4 {
        let scaled = rotation(self.rotation) * DMat3::from_diagonal(self.scale.into());
        let mut matrix = DMat4::from_mat3(scaled);
        matrix.w_axis = DVec3::from(self.translation).extend(1.0);
        matrix
    }
}

/// The rotation of a quaternion x, y, z, w of any length but 0, which turns nothing.
fn rotation(q: [f64; 4]) -> DMat3 {
    let squared = q.iter().map(|c| c * c).sum::<f64>();
    if !(squared > 0.0 && squared.is_finite()) {
        return DMat3::IDENTITY;
    }
    let [x, y, z, w] = q;
    let twice = 2.0 / squared;
    DMat3::from_cols(
        DVec3::new(
            1.0 - twice * (y * y + z * z),
            twice * (x * y + w * z),
            twice * (x * z - w * y),
        ),
        DVec3::new(
            twice * (x * y - w * z),
            1.0 - twice * (x * x + z * z),
            twice * (y * z + w * x),
        ),
        DVec3::new(
            twice * (x * z + w * y),
            twice * (y * z - w * x),
            1.0 - twice * (x * x + y * y),
        ),
    )
}

/// The nodes in the world.
#[derive(Debug)]
pub(super) struct Tree {
    /// World from node, for every node of the file.
    pub(super) world: Vec<DMat4>,
    /// The nodes of the scene that is drawn, parents before children, in the order of the file.
    pub(super) drawn: Vec<usize>,
    /// Those of them that are not hidden, nor below a hidden one.
    pub(super) shown: Vec<usize>,
}

impl Tree {
    /// Computes the world transforms of the nodes. `local` has their own matrices.
    pub(super) fn new(model: &Model<'_>, local: &[DMat4]) -> Result<Self, IoError> {
        let nodes = &model.document.nodes;
        let mut has_parent = vec![false; nodes.len()];
        for (n, node) in nodes.iter().enumerate() {
            for (c, child) in node.children.iter().enumerate() {
                let pointer = format!("/nodes/{n}/children/{c}");
                model.item(nodes, *child, &pointer, "node")?;
                if std::mem::replace(&mut has_parent[*child], true) {
                    return Err(
                        model.broken(&pointer, format!("node {child} has another parent already"))
                    );
                }
            }
        }
        let tops = || (0..nodes.len()).filter(|n| !has_parent[*n]);
        let mut world = local.to_vec();
        let mut placed = vec![false; nodes.len()];
        walk(nodes, tops(), &mut placed, |n, child| {
            world[child] = world[n] * local[child];
        });
        // A ring has no top.
        if let Some(n) = placed.iter().position(|placed| !placed) {
            return Err(model.broken(&format!("/nodes/{n}"), "is an ancestor of itself"));
        }
        let roots = match model.document.scenes.get(model.document.scene.unwrap_or(0)) {
            Some(scene) => scene.nodes.clone(),
            None => match model.document.scene {
                Some(scene) => {
                    model.item(&model.document.scenes, scene, "/scene", "scene")?;
                    Vec::new()
                }
                None => tops().collect(),
            },
        };
        let scene = model.document.scene.unwrap_or(0);
        for (i, root) in roots.iter().enumerate() {
            model.item(nodes, *root, &format!("/scenes/{scene}/nodes/{i}"), "node")?;
        }
        let mut seen = vec![false; nodes.len()];
        let drawn = walk(nodes, roots.into_iter(), &mut seen, |_, _| {});
        let mut hidden = vec![false; nodes.len()];
        for n in &drawn {
            let visibility = nodes[*n].extensions.visibility.as_ref();
            hidden[*n] |= visibility.is_some_and(|visibility| !visibility.visible);
            if hidden[*n] {
                nodes[*n].children.iter().for_each(|c| hidden[*c] = true);
            }
        }
        let shown = drawn.iter().copied().filter(|n| !hidden[*n]).collect();
        Ok(Self {
            world,
            drawn,
            shown,
        })
    }
}

/// The nodes below `roots` that were not seen before, in the order of the file. `step` is called with parent and child.
fn walk(
    nodes: &[Node],
    roots: impl Iterator<Item = usize>,
    seen: &mut [bool],
    mut step: impl FnMut(usize, usize),
) -> Vec<usize> {
    let mut order = Vec::new();
    let mut left: Vec<usize> = roots.collect();
    left.reverse();
    while let Some(n) = left.pop() {
        if std::mem::replace(&mut seen[n], true) {
            continue;
        }
        order.push(n);
        for child in nodes[n].children.iter().rev() {
            if !seen[*child] {
                step(n, *child);
                left.push(*child);
            }
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quaternions_turn_as_the_standard_says() {
        let half = 0.5_f64.sqrt();
        // A quarter turn about +Y takes +Z to +X.
        let turn = rotation([0.0, half, 0.0, half]);
        assert!((turn * DVec3::Z - DVec3::X).length() < 1e-15);
        assert!((turn * DVec3::X + DVec3::Z).length() < 1e-15);
        // Any length, and none.
        assert!((rotation([0.0, 2.0, 0.0, 2.0]) * DVec3::Z - DVec3::X).length() < 1e-15);
        assert_eq!(rotation([0.0; 4]), DMat3::IDENTITY);
        let moved = Trs {
            translation: [1.0, 2.0, 3.0],
            rotation: [0.0, half, 0.0, half],
            scale: [2.0, 3.0, 4.0],
        };
        // Scaled first, then turned, then moved.
        let point = moved.matrix().transform_point3(DVec3::new(1.0, 1.0, 1.0));
        assert!(
            (point - DVec3::new(5.0, 5.0, 1.0)).length() < 1e-14,
            "{point}"
        );
    }
}
