//! Masks from afar: mip levels that keep the share of texels at or above the cutoff, where means of alpha would lose leaves and wires.

use texmap_math::{MemoryBudget, parallel};
use texmap_scene::{AlphaMode, Material, Scene, TextureSlot};

/// Use of a texture by the materials of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Use {
    Unread,
    /// As the base color of masks of one cutoff, through a filter that reads levels.
    Mask(f32),
    Otherwise,
}

/// Builds the levels of textures that are masks alone. Where there is no memory for them they are left to the renderer.
pub(super) fn keep_coverage(scene: &mut Scene, memory: MemoryBudget) {
    let mut uses = vec![Use::Unread; scene.textures.len()];
    for material in &scene.materials {
        let base = material.base_color.as_ref();
        for slot in material.slots() {
            let own = match base.is_some_and(|base| std::ptr::eq(base, slot)) {
                true => of_base(material, slot),
                false => Use::Otherwise,
            };
            if let Some(found) = uses.get_mut(slot.texture) {
                *found = match *found {
                    Use::Unread => own,
                    same if same == own => same,
                    _ => Use::Otherwise,
                };
            }
        }
    }
    let textures = std::mem::take(&mut scene.textures).into_iter().zip(uses);
    scene.textures = parallel::map(textures, |(texture, found)| {
        let Use::Mask(cutoff) = found else {
            return texture;
        };
        if texture.levels() > 1 || !texture.has_alpha() {
            return texture;
        }
        let bytes = texture.bytes_to_prepare(texmap_sample::Filter::Trilinear);
        match memory.ask(bytes, format_args!("the levels of a mask"), "") {
            Ok(()) => texture.with_coverage_mips(cutoff),
            Err(_) => texture,
        }
    });
}

fn of_base(material: &Material, slot: &TextureSlot) -> Use {
    match material.alpha {
        AlphaMode::Test(cutoff) if slot.sampler.filter.reads_mips() => {
            let cutoff = cutoff / material.opacity;
            match cutoff > 0.0 && cutoff <= 1.0 {
                true => Use::Mask(cutoff),
                false => Use::Otherwise,
            }
        }
        _ => Use::Otherwise,
    }
}

#[cfg(test)]
mod tests {
    use texmap_math::camera::Camera;
    use texmap_sample::{ColorSpace, Filter, Origin, Texture2d};

    use super::*;

    /// Leaves of some texels with soft edges under a mask, and a material beside it.
    fn leaves(other: AlphaMode) -> Scene {
        let texels = (0..64 * 64).flat_map(|i| {
            let (x, y) = (f64::from(i % 64), f64::from(i / 64));
            let sin = |turn| texmap_math::deterministic_f64::sin_cos(turn).0;
            let wave = sin(0.8 * x + 0.3 * y) * sin(0.37 * x - 0.7 * y);
            [40, 200, 30, (wave * 500.0) as u8]
        });
        let texture =
            Texture2d::from_rgba8(64, 64, texels.collect(), ColorSpace::Srgb, Origin::TopLeft);
        let mut slot = TextureSlot::new(0);
        slot.sampler.filter = Filter::Trilinear;
        let material = |alpha| Material {
            base_color: Some(slot.clone()),
            alpha,
            ..Material::default()
        };
        Scene {
            textures: vec![texture.unwrap()],
            materials: vec![material(AlphaMode::Test(0.5)), material(other)],
            ..Scene::new(Camera::look_at([0.0, 0.0, 5.0], [0.0; 3]))
        }
    }

    fn kept(texture: &Texture2d<'_>, level: u32) -> f64 {
        let side = 64 >> level;
        let texels = (0..side * side).filter_map(|i| texture.texel(level, i % side, i / side));
        texels.filter(|texel| texel[3] >= 0.5).count() as f64 / f64::from(side * side)
    }

    #[test]
    fn masks_keep_their_coverage() {
        let mut scene = leaves(AlphaMode::Test(0.5));
        let plain = scene.textures[0].clone().with_mips();
        keep_coverage(&mut scene, MemoryBudget::of_process());
        let texture = &scene.textures[0];
        let share = kept(texture, 0);
        assert!((share - 0.3).abs() < 0.1, "{share}");
        for level in 1..=3 {
            let kept = kept(texture, level);
            assert!((kept - share).abs() < 0.08, "{level}: {kept}");
        }
        let lost = kept(&plain, 3);
        assert!(lost < 0.05, "means lose the leaves: {lost}");
        // Nothing is built for a texture that is also seen through, or under another cutoff.
        for other in [AlphaMode::Blend, AlphaMode::Test(0.25)] {
            let mut scene = leaves(other);
            keep_coverage(&mut scene, MemoryBudget::of_process());
            assert_eq!(scene.textures[0].levels(), 1);
        }
    }
}
