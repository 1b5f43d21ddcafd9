//! Models far from the origin: their coordinates, which are held in f32, lose the details of their shape.

use texmap_scene::Scene;

/// Least number of steps of f32 across a model; 1/16 of a pixel in a picture of 1024 is one in 16,384.
const STEPS: f64 = 16_384.0;

/// A warning if the coordinates of a model have so few digits beside its size that its shape is coarse.
pub(super) fn coarse(scene: &Scene) -> Option<String> {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for mesh in &scene.meshes {
        for vertex in mesh.triangles.as_flattened() {
            let Some(p) = mesh.positions.get(*vertex as usize) else {
                continue;
            };
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k]));
            }
        }
    }
    let size = (0..3).fold(0.0_f32, |size, k| size.max(high[k] - low[k]));
    let (axis, most) = (0..3)
        .map(|k| (k, low[k].abs().max(high[k].abs())))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    if !most.is_finite() {
        return None;
    }
    let step = most.next_up() - most;
    // A model of no size may be a point, or have collapsed to one.
    let coarse = f64::from(size) < STEPS * f64::from(step) && (size > 0.0 || most > 4096.0);
    coarse.then(|| {
        let axis = ["x", "y", "z"][axis];
        format!(
            "the model is {size} wide and stands at {axis} = {most}, where 32-bit coordinates have steps of {step}: its shape is coarse; move it to the origin before it is written"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::camera::Camera;
    use texmap_scene::Mesh;

    #[test]
    fn models_far_from_the_origin_are_coarse() {
        let of = |shift: &dyn Fn(&mut [f32; 3])| {
            let mut mesh = Mesh::cube();
            mesh.positions.iter_mut().for_each(shift);
            coarse(&Scene {
                meshes: vec![mesh],
                ..Scene::new(Camera::look_at([0.0, 0.0, 5.0], [0.0; 3]))
            })
        };
        let warning = |offset: f32| of(&|p| p[1] += offset);
        assert_eq!(warning(0.0), None);
        assert_eq!(warning(500.0), None);
        let text = warning(4_649_776.0).unwrap();
        assert!(
            text.contains("y = 4649777") && text.contains("steps of 0.5"),
            "{text}"
        );
        assert!(warning(-3_000_000.0).is_some());
        let collapsed = of(&|p| *p = p.map(|c| c * 1e-3 + 1e6));
        assert!(collapsed.unwrap().contains("is 0 wide"));
    }
}
