//! The way of a ray through the tree of boxes.

use bvh::aabb::Aabb;
use bvh::bvh::BvhNode;
use texmap_math::glam::DVec3;

use super::RayScene;
use super::body::Body;

impl RayScene {
    /// Visits the bodies whose boxes a ray meets within a range of t, nearer boxes first. The visitor gets the range that is left and
    /// returns its new end, or nothing to stop.
    pub(super) fn walk(
        &self,
        origin: DVec3,
        direction: DVec3,
        range: (f64, f64),
        mut visit: impl FnMut(&Body, (f64, f64)) -> Option<f64>,
    ) {
        let Some(tree) = &self.tree else { return };
        if !(origin.is_finite() && direction.is_finite()) || direction == DVec3::ZERO {
            return;
        }
        let inverse = 1.0 / direction;
        let mut end = range.1;
        let mut waiting = vec![(range.0, 0usize)];
        while let Some((entry, index)) = waiting.pop() {
            if entry > end {
                continue;
            }
            match &tree.nodes[index] {
                BvhNode::Leaf { shape_index, .. } => {
                    match visit(&self.bodies[*shape_index], (range.0, end)) {
                        Some(new) => end = new,
                        None => return,
                    }
                }
                BvhNode::Node {
                    child_l_index,
                    child_l_aabb,
                    child_r_index,
                    child_r_aabb,
                    ..
                } => {
                    let left = entry_of(child_l_aabb, origin, inverse, (range.0, end));
                    let right = entry_of(child_r_aabb, origin, inverse, (range.0, end));
                    let left = left.map(|t| (t, *child_l_index));
                    let right = right.map(|t| (t, *child_r_index));
                    match (left, right) {
                        (Some(left), Some(right)) if left.0 <= right.0 => {
                            waiting.extend([right, left]);
                        }
                        (left, right) => waiting.extend(left.into_iter().chain(right)),
                    }
                }
            }
        }
    }
}

/// Where a ray enters a box within a range of t (Kay and Kajiya 1986: slabs). Along a face of the box the slab of that axis says nothing.
fn entry_of(
    bounds: &Aabb<f64, 3>,
    origin: DVec3,
    inverse: DVec3,
    (mut near, mut far): (f64, f64),
) -> Option<f64> {
    for axis in 0..3 {
        let a = (bounds.min[axis] - origin[axis]) * inverse[axis];
        let b = (bounds.max[axis] - origin[axis]) * inverse[axis];
        if a.is_nan() || b.is_nan() {
            continue;
        }
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (near <= far).then_some(near)
}
