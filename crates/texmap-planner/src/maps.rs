//! Maps of one colour, which are numbers.

use texmap_sample::Wrap;

use super::textures::Textures;
use texmap_scene::{AlphaMode, Material, NormalDetail, TextureSlot};

/// Replaces maps of one colour by numbers, and says which maps are gone.
pub(super) fn drop_constant(textures: &Textures<'_>, material: &mut Material) -> Vec<&'static str> {
    let mut gone = Vec::new();
    let color = |slot: &TextureSlot| {
        let border = [slot.sampler.wrap_u, slot.sampler.wrap_v].contains(&Wrap::ClampToBorder);
        textures.constant(slot.texture).filter(|_| !border)
    };
    let opaque = |slot: &TextureSlot| color(slot).filter(|c| c[3] >= 1.0);
    if let Some(NormalDetail::Bump { slot, .. }) = &material.normal_detail
        && opaque(slot).is_some()
    {
        material.normal_detail = None;
        gone.push("bump map (of one height)");
    }
    if let Some([share, ..]) = material.maps.exponent.as_ref().and_then(opaque) {
        material.phong.ns *= share;
        material.maps.exponent = None;
        gone.push("exponent map (of one value)");
    }
    if material.maps.specular.as_ref().and_then(opaque) == Some([1.0; 4]) {
        material.maps.specular = None;
        gone.push("specular map (white)");
    }
    // At a threshold of 0 the filter of the map decides what is cut: it stays.
    let by_value = match material.alpha {
        AlphaMode::Blend => true,
        AlphaMode::Test(threshold) => threshold > 0.0,
        AlphaMode::Opaque => false,
    };
    if by_value
        && let Some(slot) = &material.opacity_map
        && let Some([red, _, _, alpha]) = color(slot)
    {
        let has_alpha = textures.has_alpha(slot.texture);
        material.opacity *= if has_alpha { alpha } else { red };
        material.opacity_map = None;
        gone.push("opacity map (of one value)");
    }
    gone
}

#[cfg(test)]
mod tests {
    use texmap_sample::{ColorSpace, Origin, Sampler, Texture2d};

    use super::*;
    use texmap_scene::SurfaceMaps;

    fn slot(texture: usize) -> TextureSlot {
        TextureSlot {
            sampler: Sampler::default(),
            ..TextureSlot::new(texture)
        }
    }

    #[test]
    fn maps_of_one_colour_become_numbers_and_others_stay() {
        let of = |texels: [[u8; 4]; 2]| {
            let bytes = texels.into_iter().flatten().collect();
            Texture2d::from_rgba8(2, 1, bytes, ColorSpace::Linear, Origin::TopLeft).unwrap()
        };
        let textures = [
            of([[51, 51, 51, 255]; 2]),
            of([[51, 51, 51, 255], [52, 51, 51, 255]]),
            of([[255; 4]; 2]),
            of([[255, 255, 255, 102]; 2]),
        ];
        let textures = Textures::new(&textures);
        let material = |map: usize, white: usize, alpha: usize| Material {
            normal_detail: Some(NormalDetail::Bump {
                slot: slot(map),
                height: 0.1,
            }),
            maps: SurfaceMaps {
                exponent: Some(slot(map)),
                specular: Some(slot(white)),
                ..SurfaceMaps::default()
            },
            opacity_map: Some(slot(alpha)),
            alpha: AlphaMode::Blend,
            ..Material::default()
        };
        let before = material(0, 2, 3);
        let mut after = before.clone();
        assert_eq!(drop_constant(&textures, &mut after).len(), 4);
        assert!(after.normal_detail.is_none() && after.opacity_map.is_none());
        assert_eq!(after.maps, SurfaceMaps::default());
        assert!((after.phong.ns / before.phong.ns - 0.2).abs() < 1e-6);
        assert!((after.opacity - 0.4).abs() < 1e-6, "{}", after.opacity);
        // Negative twins: one texel differs, a grey highlight, a threshold of 0, a border.
        let mut other = material(1, 0, 1);
        assert!(drop_constant(&textures, &mut other).is_empty());
        assert_eq!(other, material(1, 0, 1));
        let mut cut = Material {
            alpha: AlphaMode::Test(0.0),
            ..material(1, 0, 3)
        };
        assert!(drop_constant(&textures, &mut cut).is_empty());
        let mut bordered = material(1, 0, 3);
        if let Some(slot) = &mut bordered.opacity_map {
            slot.sampler.wrap_u = Wrap::ClampToBorder;
        }
        assert!(drop_constant(&textures, &mut bordered).is_empty());
    }
}
