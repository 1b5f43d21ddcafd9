//! Tangents of a file, held against those that follow from its texture coordinates.

use texmap_math::glam::DVec3;
use texmap_scene::UvSet;

use super::geometry::Geometry;

/// Largest angle (its cosine: 30 degrees) to which a tangent is that of its triangle.
const COS: f64 = 0.866;

/// True if more than a twentieth of the tangents differ from those of their triangles' coordinates. A normal map that was baked for
/// the file's tangents looks different with computed ones. False without tangents.
pub(super) fn differ(geometry: &Geometry, set: UvSet) -> bool {
    let uvs = match set {
        UvSet::First => &geometry.uvs,
        UvSet::Second => &geometry.second,
    };
    if geometry.tangents.is_empty() || geometry.normals.is_empty() || uvs.is_empty() {
        return false;
    }
    let wide = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
    let (mut all, mut other) = (0_usize, 0_usize);
    for triangle in &geometry.triangles {
        let [a, b, c] = triangle.map(|i| i as usize);
        let position = |i: usize| wide(&geometry.positions[i]);
        let uv = |i: usize| uvs[i].map(f64::from);
        let (right, up) = (position(b) - position(a), position(c) - position(a));
        let [[u0, v0], [u1, v1], [u2, v2]] = [uv(a), uv(b), uv(c)];
        let (du1, dv1, du2, dv2) = (u1 - u0, v1 - v0, u2 - u0, v2 - v0);
        let area = du1 * dv2 - du2 * dv1;
        let along = (right * dv2 - up * dv1) * area.signum();
        if area == 0.0 || along == DVec3::ZERO {
            continue;
        }
        for i in [a, b, c] {
            let normal = wide(&geometry.normals[i]).normalize_or_zero();
            let [x, y, z, handed] = geometry.tangents[i].map(f64::from);
            let computed = (along - normal * normal.dot(along)).normalize_or_zero();
            // v grows downwards, so a picture that is not mirrored has a negative area where its triangle has a positive one.
            let hand = -area.signum() * right.cross(up).dot(normal).signum();
            all += 1;
            let turned = computed.dot(DVec3::new(x, y, z).normalize_or_zero()) < COS;
            other += usize::from(turned || hand * handed < 0.0);
        }
    }
    20 * other > all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(tangent: [f32; 4]) -> Geometry {
        Geometry {
            positions: vec![
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
            ],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            tangents: vec![tangent; 4],
            ..Geometry::default()
        }
    }

    #[test]
    fn only_other_tangents_differ() {
        assert!(!differ(&square([1.0, 0.0, 0.0, 1.0]), UvSet::First));
        assert!(!differ(&square([0.9, 0.1, 0.0, 1.0]), UvSet::First));
        assert!(differ(&square([0.0, 1.0, 0.0, 1.0]), UvSet::First));
        assert!(differ(&square([1.0, 0.0, 0.0, -1.0]), UvSet::First));
        let bare = Geometry {
            tangents: Vec::new(),
            ..square([0.0; 4])
        };
        assert!(!differ(&bare, UvSet::First));
    }
}
