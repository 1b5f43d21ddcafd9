//! Solid textures, ramps and labels on surfaces.

use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::Font;
use texmap_sample::{ColorSpace, Origin, Sampler, Texture2d, UvTransform, Wrap};
use texmap_scene::{ColorMode, Material, Scene, SolidTexture, SolidTextureSource, TextureSlot};

use super::build::Builder;
use super::effects::pattern;
use super::settings::{Settings, WHITE, surface};
use crate::IoError;
use crate::scene_file::Line;
use crate::textures::Content;

/// Solid, ramps, label and font of later faces.
#[derive(Debug, Clone, Default)]
pub(super) struct MaterialSettings {
    pub(super) solid: Option<(SolidTexture, Option<TextureSlot>)>,
    pub(super) ramp: Option<TextureSlot>,
    pub(super) cel: Option<TextureSlot>,
    pub(super) decal: Option<TextureSlot>,
    pub(super) font: Option<(usize, Font)>,
}

impl MaterialSettings {
    /// A material under these settings.
    pub(super) fn apply(
        &self,
        settings: &Settings,
        scene: &Scene,
        mut material: Material,
    ) -> Material {
        if let Some((solid, own)) = &self.solid {
            material.solid = Some(solid.clone());
            material.color_ramp = self.ramp.clone().or_else(|| own.clone());
            if settings.surf.is_none() {
                material.phong = surface(&WHITE, scene.color);
            }
        } else {
            material.color_ramp = self.ramp.clone().filter(|_| material.base_color.is_some());
        }
        material.light_ramp = self.cel.clone();
        material.decal = self.decal.clone().filter(|_| material.base_color.is_some());
        material
    }
}

/// `solid`.
pub(super) fn solid(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    if line.takes("none") {
        b.settings.materials.solid = None;
        return Ok(());
    }
    let formula = line.word();
    let grid = match formula {
        Some(_) => None,
        None => {
            let path = b.beside(line);
            Some(b.textures.grid(&path, &line.location, b.settings.missing)?)
        }
    };
    let placed = placed(line.numbers(), line.numbers(), grid.is_some());
    let (mut octaves, mut fold) = (4, None);
    while let Some(word) = line.word() {
        match word {
            "octaves" => octaves = line.whole() as u8,
            _ => fold = Some(line.float()),
        }
    }
    let source = match grid {
        Some(grid) => SolidTextureSource::Grid {
            grid,
            sampler: sampler(&b.settings),
            wrap_w: b.settings.wrap[1],
        },
        None => SolidTextureSource::Pattern(pattern(formula, octaves, fold)),
    };
    let own = match formula {
        Some("marble") => Some(("marble", &MARBLE)),
        Some("wood") => Some(("wood", &WOOD)),
        _ => None,
    };
    let color = b.scene.color;
    let own = own.map(|(name, colors)| {
        let texture = b.textures.made(name, || ramp_of(colors, color));
        b.settings
            .slot(texture, UvTransform::default(), true, color)
    });
    let solid = SolidTexture {
        source,
        world_from_solid: b.settings.transform * placed,
    };
    b.settings.materials.solid = Some((solid, own));
    Ok(())
}

/// The picture of `ramp` or `cel`.
pub(super) fn ramp(b: &mut Builder, line: &mut Line<'_>) -> Result<Option<TextureSlot>, IoError> {
    if line.takes("none") {
        return Ok(None);
    }
    let texture = b.load(line, Content::Color)?;
    let slot = b
        .settings
        .slot(texture, UvTransform::default(), true, b.scene.color);
    Ok(Some(slot))
}

/// `decal`.
pub(super) fn decal(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    if line.takes("none") {
        b.settings.materials.decal = None;
        return Ok(());
    }
    let texture = b.load(line, Content::Color)?;
    let [u, v, width, height] = match line.left() {
        0 => [0.0, 0.0, 1.0, 1.0],
        _ => line.floats(),
    };
    let transform = UvTransform {
        offset: [-u / width, -v / height],
        scale: [1.0 / width, 1.0 / height],
        rotation: 0.0,
    };
    let mut slot = b.settings.slot(texture, transform, true, b.scene.color);
    let clear = (Wrap::ClampToBorder, Wrap::ClampToBorder);
    (slot.sampler.wrap_u, slot.sampler.wrap_v) = clear;
    slot.sampler.border = [0.0; 4];
    b.settings.materials.decal = Some(slot);
    Ok(())
}

/// The unit cube, its middle or its corner at a position.
pub(super) fn placed(at: [f64; 3], size: [f64; 3], centred: bool) -> DMat4 {
    let (at, size) = (DVec3::from(at), DVec3::from(size));
    let corner = if centred { at - 0.5 * size } else { at };
    DMat4::from_translation(corner) * DMat4::from_scale(size)
}

pub(super) fn sampler(settings: &Settings) -> Sampler {
    Sampler {
        filter: settings.filter,
        wrap_u: settings.wrap[0],
        wrap_v: settings.wrap[1],
        ..Sampler::default()
    }
}

/// sRGB colours in even steps.
const MARBLE: [[u8; 3]; 5] = [
    [58, 62, 74],
    [148, 150, 158],
    [214, 212, 208],
    [236, 234, 229],
    [247, 246, 243],
];
const WOOD: [[u8; 3]; 5] = [
    [214, 166, 106],
    [205, 154, 92],
    [190, 135, 74],
    [158, 102, 50],
    [104, 60, 28],
];

fn ramp_of(colors: &[[u8; 3]], color: ColorMode) -> Texture2d<'static> {
    let texels = colors
        .iter()
        .flat_map(|[r, g, b]| [*r, *g, *b, 255])
        .collect();
    let space = match color {
        ColorMode::Srgb => ColorSpace::Srgb,
        ColorMode::Raw => ColorSpace::Linear,
    };
    Texture2d::from_rgba8(colors.len() as u32, 1, texels, space, Origin::TopLeft)
        .expect("a row of a few texels")
}

#[cfg(test)]
mod tests {
    use crate::scene_file::{assert_faults, assert_reads_back};

    #[test]
    fn every_line_reads_back() {
        assert_reads_back(&[
            "solid marble 0 0 0 1 1 1\n",
            "solid wood 0 1 0 0.5 0.5 2 fold 0.25\n",
            "solid noise 0 0 0 1 1 1 octaves 7\n",
            "solid grid.npy 0 0 0 2 2 2\n",
            "solid \"wood\" 0 0 0 2 2 2\n",
            "solid none\n",
            "ramp heat.png\n",
            "ramp none\n",
            "cel bands.png\n",
            "cel \"none\"\n",
            "decal label.png\n",
            "decal label.png 0.25 0.5 0.5 0.25\n",
            "decal none\n",
        ]);
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("solid", "argument-count", 1),
            ("solid marble 0 0 0 1 1", "argument-count", 1),
            ("solid marble 0 0 0 1 0 1", "out-of-range", 22),
            ("solid marble 0 0 0 1 1 1 octaves 0", "out-of-range", 34),
            ("solid marble 0 0 0 1 1 1 octaves 17", "out-of-range", 34),
            ("solid marble 0 0 0 1 1 1 veins 3", "unknown-word", 26),
            ("solid marble 0 0 0 1 1 1 fold nan", "not-finite", 31),
            ("ramp a.png 3", "argument-count", 12),
            ("cel", "argument-count", 1),
            ("decal a.png 0 0 1", "argument-count", 1),
            ("decal a.png 0 0 0 1", "out-of-range", 17),
        ]);
    }
}
