//! Traversal of the tree of boxes by a ray.

use rstar::{AABB, RTreeNode, RTreeObject};
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
        if !(origin.is_finite() && direction.is_finite()) || direction == DVec3::ZERO {
            return;
        }
        let inverse = 1.0 / direction;
        let mut end = range.1;
        // The nearest box of the last node is on top.
        let mut waiting: Vec<(f64, &RTreeNode<Body>)> = Vec::new();
        let mut node = Some(self.tree.root());
        loop {
            if let Some(parent) = node.take() {
                let first = waiting.len();
                waiting.extend(parent.children().iter().filter_map(|child| {
                    let entry = entry_of(&child.envelope(), origin, inverse, (range.0, end))?;
                    Some((entry, child))
                }));
                waiting[first..].sort_by(|a, b| b.0.total_cmp(&a.0));
            }
            match waiting.pop() {
                None => return,
                Some((entry, _)) if entry > end => {}
                Some((_, RTreeNode::Parent(parent))) => node = Some(parent),
                Some((_, RTreeNode::Leaf(body))) => match visit(body, (range.0, end)) {
                    Some(new) => end = new,
                    None => return,
                },
            }
        }
    }
}

/// Entry of a ray into a box within a range of t (Kay and Kajiya 1986: slabs). Along a face of the box the slab of that axis says nothing.
fn entry_of(
    bounds: &AABB<[f64; 3]>,
    origin: DVec3,
    inverse: DVec3,
    (mut near, mut far): (f64, f64),
) -> Option<f64> {
    let (lower, upper) = (bounds.lower(), bounds.upper());
    for axis in 0..3 {
        let a = (lower[axis] - origin[axis]) * inverse[axis];
        let b = (upper[axis] - origin[axis]) * inverse[axis];
        if a.is_nan() || b.is_nan() {
            continue;
        }
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (near <= far).then_some(near)
}
