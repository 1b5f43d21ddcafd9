//! Names and shadows of the lights above a line, and projectors.

use texmap_light::{Light, ProjectorBorder, ShadowBias};
use texmap_math::Projector;
use texmap_math::glam::DVec3;
use texmap_sample::UvTransform;
use texmap_scene::{ColorMode, ProjectorLight, ProjectorMode, Shadow, shadow_kind};

use super::build::{Added, Builder};
use crate::IoError;
use crate::scene_file::Line;
use crate::textures::Content;

/// `name`: of the light, faces or model above.
pub(super) fn name(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    let name = line.name();
    if let Added::Meshes(meshes) = b.added.clone() {
        b.name_meshes(name, meshes);
        return Ok(());
    }
    let Some(last) = b.scene.lights.len().checked_sub(1) else {
        return Err(line.needs("a light (`la`, `ld`, `lp` or `ls`), a face or a model"));
    };
    let names = &mut b.scene.effects.light_names;
    if let Some(other) = names.iter().position(|known| known == name) {
        return Err(IoError::BadShape {
            location: line.location.clone(),
            problem: format!("`name`: light {other} is called `{name}` already"),
        });
    }
    names.resize(last + 1, String::new());
    name.clone_into(&mut names[last]);
    Ok(())
}

/// `shadow`: of the light above that is not ambient.
pub(super) fn shadow(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    let cast = |light: &Light| !matches!(light, Light::Ambient { .. });
    let light = b.scene.lights.iter().rposition(cast);
    let light = light.ok_or_else(|| line.needs("a light (`ld`, `lp` or `ls`)"))?;
    if matches!(b.scene.lights[light], Light::Spot { .. }) {
        shadow_kind(&b.scene, light, None).map_err(|_| IoError::BadShape {
            location: line.location.clone(),
            problem: "`shadow`: the `ls` above lights more than 85 degrees from its axis, which no shadow map holds; narrow it, or make it an `lp`".into(),
        })?;
    }
    line.takes("auto");
    let mut shadow = Shadow {
        light,
        size: line.optional_number().map(|size| size as u32),
        bias: None,
        pcf_size: 3,
        area: None,
    };
    while let Some(word) = line.word() {
        match word {
            "taps" => shadow.pcf_size = line.whole(),
            "slope" => shadow.bias = Some(ShadowBias::Slope(line.number())),
            "constant" => shadow.bias = Some(ShadowBias::Constant(line.number())),
            "normal-offset" => shadow.bias = Some(ShadowBias::NormalOffset(line.number())),
            _ => shadow.area = Some((DVec3::from(line.numbers()), line.number())),
        }
    }
    b.scene.effects.shadows.push(shadow);
    Ok(())
}

/// `projector`.
pub(super) fn projector(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    let texture = b.load(line, Content::Color)?;
    let picture = &b.textures.textures[texture];
    let aspect = f64::from(picture.width()) / f64::from(picture.height());
    let paint = line.takes("paint") || !line.takes("light");
    let [position, look, up] = [line.numbers(), line.numbers(), line.numbers()].map(DVec3::from);
    let fov = line.number().to_radians();
    let projector = Projector::new(position, look, up, fov, aspect);
    let projector = projector.map_err(|e| IoError::BadProjector {
        location: line.location.clone(),
        problem: e
            .to_string()
            .replace("camera: ", "")
            .replace("eye", "position"),
    })?;
    let slot = b
        .settings
        .slot(texture, UvTransform::default(), true, ColorMode::Raw);
    let mut light = ProjectorLight {
        projector,
        position,
        texture,
        sampler: slot.sampler,
        border: ProjectorBorder::Black,
        softness: 0.0,
        mode: ProjectorMode::Decal,
        shadow: None,
    };
    let mut color = [1.0; 3];
    while let Some(word) = line.word() {
        match word {
            "black" => light.border = ProjectorBorder::Black,
            "clamp" => light.border = ProjectorBorder::Clamp,
            "repeat" => light.border = ProjectorBorder::Repeat,
            "soft" => light.softness = line.float(),
            "color" => color = line.floats(),
            _ => light.shadow = Some(line.whole()),
        }
    }
    if !paint {
        light.mode = ProjectorMode::Light(color);
    }
    b.scene.effects.projectors.push(light);
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::scene_file::{assert_faults, assert_reads_back};

    #[test]
    fn every_line_reads_back() {
        assert_reads_back(&[
            "ls 1 0.5 0 1 2 3 0 -1 0 20 30\n",
            "name sun-2\n",
            "shadow\n",
            "shadow auto taps 3\n",
            "shadow 512 taps 5 slope 0.001\n",
            "shadow 512 taps 1 constant 0.01\n",
            "shadow auto taps 1 normal-offset 1.5\n",
            "shadow taps 1 normal-offset 1.5 area 0 1 -2 3.5\n",
            "projector slide.png light 0 1 2 0 0 0 0 1 0 40 black soft 0.1 color 1 1 0.5 shadow 512\n",
            "projector \"my slide.png\" paint 0 1 2 0 0 0 0 1 0 40 repeat soft 0 color 1 1 1\n",
            "projector \"paint\" paint 0 1 2 0 0 0 0 1 0 40\n",
        ]);
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("ls 1 1 1 0 0 0 0 0 0 10 20", "out-of-range", 16),
            ("ls 1 1 1 0 0 0 0 1 0 30 20", "out-of-range", 25),
            ("ls 1 1 1", "argument-count", 1),
            ("name 12", "out-of-range", 6),
            ("name a/b", "out-of-range", 6),
            ("name", "argument-count", 1),
            ("shadow 0", "out-of-range", 8),
            ("shadow 512 taps 4", "out-of-range", 17),
            ("shadow 512 soft 4", "unknown-word", 12),
            ("shadow auto taps", "argument-count", 1),
            ("shadow auto area 0 0 0 0", "out-of-range", 24),
            ("shadow area 0 0 x 1", "not-a-number", 17),
            (
                "projector a.png beam 0 0 0 0 0 1 0 1 0 40",
                "unknown-word",
                17,
            ),
            (
                "projector a.png light 0 0 0 0 0 1 0 1 0 180",
                "out-of-range",
                41,
            ),
            ("projector a.png light 0 0 0", "argument-count", 1),
            (
                "projector a.png light 0 0 0 0 0 1 0 1 0 40 soft 2",
                "out-of-range",
                49,
            ),
        ]);
    }
}
