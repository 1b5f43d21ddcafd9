//! Watertight meshes: the sides of their faces that a shadow map leaves out.

use texmap_light::ShadowKind;
use texmap_raster::Cull;

use texmap_scene::Mesh;

/// Sides of a mesh's faces that a shadow map leaves out. The fronts of a watertight mesh hide its backs.
pub(super) fn hidden_sides(mesh: &Mesh, kind: &ShadowKind) -> Cull {
    let (ShadowKind::Directional {
        light_from_world, ..
    }
    | ShadowKind::Spot {
        light_from_world, ..
    }) = kind
    else {
        return Cull::None;
    };
    let turns = light_from_world.determinant() * mesh.world_from_object.determinant();
    if mesh.watertight && turns > 0.0 {
        Cull::Back
    } else if mesh.watertight && turns < 0.0 {
        Cull::Front
    } else {
        Cull::None
    }
}

#[cfg(test)]
mod tests {
    use super::super::shadow_map;
    use super::super::tests::scene;
    use texmap_math::glam::DVec3;
    use texmap_scene::shadow_fit::shadow_kind;

    use texmap_light::{Light, ShadowMap};
    use texmap_math::glam::DMat4;
    use texmap_scene::Scene;

    /// A watertight mesh casts the shadow of an open one, mirrored too. Only texels at its outline may lie deeper. The negative twin
    /// has its fronts inwards.
    #[test]
    fn fronts_of_watertight_meshes_cast_the_whole_shadow() {
        let spot = Light::spot([1.0; 3], [0.3, 4.0, 0.5], [0.0, -1.0, -0.1], 0.5, 0.7);
        let down = [0.1, -1.0, 0.2];
        let sun = Light::Directional {
            color: [1.0; 3],
            direction: down,
        };
        for (light, mirrored) in [(spot, 1.0), (spot, -1.0), (sun, 1.0), (sun, -1.0)] {
            let mut scene = scene(light);
            scene.meshes.remove(0);
            scene.meshes[0].world_from_object = DMat4::from_scale(DVec3::new(mirrored, 1.0, 1.0));
            let kind = shadow_kind(&scene, 0, Some((DVec3::Y, 1.0))).unwrap();
            let size = 200;
            let map = |scene: &Scene| shadow_map(scene, &kind, size, 1).unwrap();
            let open = map(&scene);
            scene.meshes[0].watertight = true;
            let closed = map(&scene);
            scene.meshes[0]
                .triangles
                .iter_mut()
                .for_each(|t| t.reverse());
            let inside_out = map(&scene);
            let (mut met, mut deeper, mut backs) = (0, 0, 0);
            for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
                let at = |map: &ShadowMap| map.depth_at(0, x, y).unwrap();
                let (a, b) = (at(&open), at(&closed));
                assert!(b >= a && b.is_finite() == a.is_finite(), "{x} {y}: {a} {b}");
                met += u32::from(a.is_finite());
                deeper += u32::from(b > a);
                backs += u32::from(at(&inside_out) > a);
            }
            assert!(
                met > 500 && deeper * 100 < met,
                "{mirrored}: {met} {deeper}"
            );
            assert!(backs * 2 > met, "{mirrored}: {met} {backs}");
        }
    }
}
