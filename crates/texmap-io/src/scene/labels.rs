//! Fonts, and words that are written or embossed.

use std::sync::LazyLock;

use texmap_math::glam::DVec3;
use texmap_mesh::Font;
use texmap_sample::Texture2d;
use texmap_scene::{AlphaMode, Material, Scene, Shading, TextureRole};

use super::build::Builder;
use super::effects::{Coordinates, ReliefSetting};
use super::settings::{CurrentTexture, Settings};
use crate::IoError;
use crate::font::built_in_font;
use crate::scene_file::Line;
use crate::textures::Content;

/// `font`.
pub(super) fn font(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    b.settings.materials.font = match line.takes("none") {
        true => None,
        false => {
            let texture = b.load(line, Content::Color)?;
            let [columns, rows, first] = [line.whole(), line.whole(), line.whole()];
            Some((texture, Font::whole(columns, rows, first)))
        }
    };
    Ok(())
}

/// `text`.
pub(super) fn text(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    let (texture, font) = current_font(b);
    let (words, to_world) = (line.name(), b.settings.transform);
    let origin = to_world.transform_point3(DVec3::from(line.numbers()));
    let [right, up] =
        [line.numbers(), line.numbers()].map(|v| to_world.transform_vector3(DVec3::from(v)));
    let mut material = written(&b.settings, texture, &b.scene);
    material.name = format!("text from {}", line.location);
    // Of each letter: four vertices of position and coordinates, two triangles of indices and a face.
    b.textures.source.ask(
        words.len() as u64 * (4 * (12 + 8) + 2 * (12 + 4)),
        format_args!("a text of {} letters", words.len()),
        "write fewer words",
        Some(&line.location),
    )?;
    let (settings, scene) = (&b.settings, &mut b.scene);
    let effects = &settings.effects;
    let material = effects.apply(settings, scene, material, Coordinates::FIRST);
    scene.materials.push(material);
    let material = scene.materials.len() - 1;
    let mesh = font.mesh(words, origin, right, up, material);
    scene.meshes.push(mesh);
    Ok(())
}

/// `emboss`.
pub(super) fn emboss(b: &mut Builder, line: &mut Line<'_>) -> Result<ReliefSetting, IoError> {
    let (words, height) = (line.name(), line.float());
    let (atlas, font) = current_font(b);
    let atlas = &b.textures.textures[atlas];
    let [across, down] = font.heights_size(words, atlas);
    // Bytes, then words with a third more for the mip chain.
    b.textures.source.ask(
        u64::from(across) * u64::from(down) * 7,
        format_args!("the words of `emboss` as {across} x {down} texels"),
        "write fewer words, or take a smaller font",
        Some(&line.location),
    )?;
    let heights = font.heights(words, atlas);
    let heights = heights.map_err(|e| IoError::BadShape {
        location: line.location.clone(),
        problem: format!("the words of `emboss` make no map: {e}"),
    })?;
    b.textures.textures.push(heights);
    Ok(ReliefSetting::Bump(b.textures.textures.len() - 1, height))
}

/// Letters in the colour of the surface, unlit unless a `shade modulate` line says otherwise.
fn written(settings: &Settings, texture: usize, scene: &Scene) -> Material {
    let current = CurrentTexture {
        index: texture,
        name: String::new(),
        has_alpha: true,
    };
    let material = settings.textured(&current, TextureRole::Modulate, scene.color);
    let lit = settings.role == Some(TextureRole::Modulate);
    Material {
        texture_role: TextureRole::Modulate,
        shading: if lit {
            material.shading
        } else {
            Shading::Unlit
        },
        antialiased_alpha: true,
        alpha: match settings.alpha {
            None => AlphaMode::Blend,
            _ => material.alpha,
        },
        ..material
    }
}

/// The current font and its atlas.
fn current_font(b: &mut Builder) -> (usize, Font) {
    // Drawn once, whatever number of texts there are.
    static BUILT_IN: LazyLock<(Texture2d<'static>, Font)> =
        LazyLock::new(|| built_in_font().expect("the atlas has a size that textures may have"));
    b.settings.materials.font.unwrap_or_else(|| {
        let (texture, font) = &*BUILT_IN;
        (b.textures.made("font", || texture.clone()), *font)
    })
}

#[cfg(test)]
mod tests {
    use crate::scene_file::{assert_faults, assert_reads_back};

    #[test]
    fn every_line_reads_back() {
        assert_reads_back(&[
            "font letters.png 16 6 32\n",
            "font none\n",
            "text \"No. 7\" 0 1 0 0.2 0 0 0 0.4 0\n",
            "text \"\" 0 1 0 0.2 0 0 0 0.4 0\n",
        ]);
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("font a.png 16 6", "argument-count", 1),
            ("font a.png 0 6 32", "out-of-range", 12),
            ("font a.png 2048 2048 32", "out-of-range", 17),
            ("text A B 0 0 0 1 0 0 0 1 0", "argument-count", 26),
            ("text A 0 0 0 0 0 0 0 1 0", "out-of-range", 14),
        ]);
    }
}
