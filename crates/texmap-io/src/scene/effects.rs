//! Settings of the light of surfaces beyond their colours.

use std::path::PathBuf;

use texmap_light::{NormalMapGreen, SpecularModel};
use texmap_math::glam::{DMat4, DVec3};
use texmap_sample::{Pattern, UvTransform};
use texmap_scene::{
    Emission, LightMapSlot, Material, NormalDetail, ProceduralHeight, Reflection, Scene,
};

use super::build::Builder;
use super::settings::Settings;
use crate::scene_file::Line;
use crate::textures::Content;
use crate::{IoError, SourceLocation};

/// The effects that later faces are under.
#[derive(Debug, Clone, Default)]
pub(super) struct EffectSettings {
    pub(super) highlight: SpecularModel,
    pub(super) reflection: Option<Reflection>,
    /// The texture that multiplies the share of the reflection.
    pub(super) reflectivity: Option<usize>,
    pub(super) specular_map: Option<usize>,
    pub(super) light_map: Option<(usize, f32)>,
    /// Linear light and the texture that multiplies it.
    pub(super) emission: Option<([f32; 3], Option<usize>)>,
    pub(super) relief: Option<ReliefSetting>,
    /// Normals beyond the horizon stay there.
    pub(super) horizon_open: bool,
    /// Meshes cast no shadow.
    pub(super) shadowless: bool,
    /// The model with the second set of coordinates, and the line that names it.
    pub(super) lightmap_uv: Option<(PathBuf, SourceLocation)>,
}

/// The last line of `bump` and its like, with its map read.
#[derive(Debug, Clone)]
pub(super) enum ReliefSetting {
    Bump(usize, f32),
    Offsets(usize, f32, NormalMapGreen),
    Carved(NormalDetail),
    NormalMap(usize, NormalMapSetting),
}

/// Interpretation of the colours of a normal map.
#[derive(Debug, Clone, Copy)]
pub(super) struct NormalMapSetting {
    object_space: bool,
    green: NormalMapGreen,
    rebuild_z: bool,
}

impl ReliefSetting {
    fn reads_uv(&self) -> bool {
        !matches!(self, Self::Carved(_))
    }
}

/// Effects of a material that faces do not show whose texel covers the surface.
pub(super) fn covered(material: &Material) -> Vec<&'static str> {
    let has = [
        (material.normal_detail.is_some(), BUMPS),
        (material.specular_model != SpecularModel::Phong, HIGHLIGHT),
        (material.reflection.is_some(), "`env`"),
        (material.specular_map.is_some(), "`specmap`"),
        (material.light_map.is_some(), "`lightmap`"),
        (material.emission.is_some(), "`emission`"),
        (material.light_ramp.is_some(), "`cel`"),
        (material.solid.is_some(), "`solid`"),
    ];
    has.into_iter()
        .filter_map(|(has, name)| has.then_some(name))
        .collect()
}

const BUMPS: &str = "`bump`, `offsetmap`, `procedural-bump`, `emboss` or `normalmap`";

const HIGHLIGHT: &str = "`highlight`";

/// True for effects of [`covered`] that the light of projectors shows on texels.
pub(super) fn turns_projected_light(effect: &str) -> bool {
    [BUMPS, HIGHLIGHT].contains(&effect)
}

/// The coordinates that faces have.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coordinates {
    /// Those of textures: per vertex, from a frame, or by a shape.
    pub(super) first: bool,
    /// Those of light maps.
    pub(super) second: bool,
}

impl Coordinates {
    /// Those of textures alone.
    pub(super) const FIRST: Self = Self {
        first: true,
        second: false,
    };
}

impl EffectSettings {
    /// True if some effect reads the coordinates of textures.
    pub(super) fn reads_uv(&self) -> bool {
        !self
            .out_of_reach(Coordinates {
                first: false,
                second: true,
            })
            .is_empty()
    }

    /// The effects that do not reach faces with these coordinates, and the reasons.
    pub(super) fn out_of_reach(
        &self,
        coordinates: Coordinates,
    ) -> Vec<(&'static str, &'static str)> {
        const FIRST: &str = "has no texture coordinates";
        const SECOND: &str = "has no second coordinates (`lightmapuv` gives them to an `obj`)";
        let mut out = Vec::new();
        let relief = self.relief.as_ref();
        if !coordinates.first && relief.is_some_and(ReliefSetting::reads_uv) {
            out.push((BUMPS, FIRST));
        }
        if !coordinates.first && self.emission.is_some_and(|(_, map)| map.is_some()) {
            out.push(("`emission` with a map", FIRST));
        }
        if !coordinates.first && self.reflection.is_some() && self.reflectivity.is_some() {
            out.push(("`env` with a map", FIRST));
        }
        if !coordinates.second && self.light_map.is_some() {
            out.push(("`lightmap`", SECOND));
        }
        out
    }

    /// A material under these effects, for faces with these coordinates; effects of its own stay.
    pub(super) fn apply(
        &self,
        settings: &Settings,
        scene: &Scene,
        mut material: Material,
        coordinates: Coordinates,
    ) -> Material {
        let data = |texture| settings.slot(texture, UvTransform::default(), false, scene.color);
        material.specular_model = self.highlight;
        material.reflection = self.reflection;
        if self.reflection.is_some() && coordinates.first {
            material.maps.reflectivity = self.reflectivity.map(data);
        }
        material.specular_map = self.specular_map;
        material.horizon_clamp = !self.horizon_open;
        let light_map = self.light_map.filter(|_| coordinates.second);
        material.light_map = light_map.map(|(texture, scale)| LightMapSlot {
            slot: settings.slot(texture, UvTransform::default(), true, scene.color),
            scale,
            baked: None,
        });
        if material.emission.is_none() {
            let reaches = |map: Option<usize>| coordinates.first || map.is_none();
            let emission = self.emission.filter(|(_, map)| reaches(*map));
            material.emission = emission.map(|(color, map)| Emission {
                color,
                map: map.map(data),
            });
        }
        if material.normal_detail.is_none() {
            let relief = self.relief.as_ref();
            let relief = relief.filter(|relief| coordinates.first || !relief.reads_uv());
            material.normal_detail = relief.map(|relief| match relief {
                ReliefSetting::Bump(texture, height) => NormalDetail::Bump {
                    slot: data(*texture),
                    height: *height,
                },
                ReliefSetting::Offsets(texture, slope, green) => NormalDetail::Offsets {
                    slot: data(*texture),
                    slope: *slope,
                    green: *green,
                },
                ReliefSetting::Carved(relief) => relief.clone(),
                ReliefSetting::NormalMap(texture, line) => NormalDetail::NormalMap {
                    slot: data(*texture),
                    green: line.green,
                    rebuild_z: line.rebuild_z,
                    object_space: line.object_space,
                    strength: 1.0,
                },
            });
        }
        material
    }
}

/// The direction of the green channel.
pub(super) fn green(word: Option<&str>) -> NormalMapGreen {
    match word {
        Some("down") => NormalMapGreen::Down,
        _ => NormalMapGreen::Up,
    }
}

impl Builder {
    /// The normal detail of a line, or none; every `none` ends any normal detail.
    pub(super) fn set_relief(
        &mut self,
        line: &mut Line<'_>,
        read: impl Fn(&mut Self, &mut Line<'_>) -> Result<ReliefSetting, IoError>,
    ) -> Result<(), IoError> {
        self.settings.effects.relief = match line.takes("none") {
            true => None,
            false => Some(read(self, line)?),
        };
        Ok(())
    }
}

/// `normalmap`.
pub(super) fn normal_map(b: &mut Builder, line: &mut Line<'_>) -> Result<ReliefSetting, IoError> {
    let texture = b.load(line, Content::Data)?;
    let mut setting = NormalMapSetting {
        object_space: false,
        green: NormalMapGreen::Up,
        rebuild_z: false,
    };
    while let Some(word) = line.word() {
        match word {
            "tangent" | "object" => setting.object_space = word == "object",
            "up" | "down" => setting.green = green(Some(word)),
            _ => setting.rebuild_z = word == "xy",
        }
    }
    Ok(ReliefSetting::NormalMap(texture, setting))
}

/// `procedural-bump`.
pub(super) fn carved(b: &mut Builder, line: &mut Line<'_>) -> Result<ReliefSetting, IoError> {
    let (formula, height) = (line.word(), line.float());
    let (origin, size) = (DVec3::from(line.numbers()), DVec3::from(line.numbers()));
    let (mut around, mut octaves, mut fold) = (12, 4, None);
    while let Some(word) = line.word() {
        match word {
            "around" => around = line.whole() as u16,
            "octaves" => octaves = line.whole() as u8,
            _ => fold = Some(line.float()),
        }
    }
    let heights = match formula {
        Some("waves") => ProceduralHeight::Waves {
            around,
            fold: fold.unwrap_or(0.0),
        },
        formula => ProceduralHeight::Pattern(pattern(formula, octaves, fold)),
    };
    let placed = DMat4::from_translation(origin) * DMat4::from_scale(size);
    Ok(ReliefSetting::Carved(NormalDetail::Procedural {
        heights,
        world_from_solid: b.settings.transform * placed,
        height,
    }))
}

/// The pattern that a word names.
pub(super) fn pattern(word: Option<&str>, octaves: u8, fold: Option<f32>) -> Pattern {
    match word {
        Some("marble") => Pattern::Marble {
            octaves,
            turbulence: fold.unwrap_or(1.0),
        },
        Some("wood") => Pattern::Wood {
            grain: fold.unwrap_or(0.2),
        },
        _ => Pattern::Noise { octaves },
    }
}

#[cfg(test)]
mod tests {
    use crate::scene_file::{assert_faults, assert_reads_back};

    #[test]
    fn every_line_reads_back() {
        assert_reads_back(&[
            "shadowless yes\n",
            "shadowless no\n",
            "horizon clamp\n",
            "horizon open\n",
            "highlight blinn\n",
            "lightmap room.png 2\n",
            "lightmap none\n",
            "lightmapuv room2.obj\n",
            "lightmapuv none\n",
            "emission 0.5 2 0\n",
            "emission 1 1 1 glow.png\n",
            "emission 1 1 1 \"none\"\n",
            "emission none\n",
            "bump bricks.png 0.02\n",
            "bump none\n",
            "bump \"none\" 0.02\n",
            "normalmap n.png object down xy\n",
            "normalmap none\n",
            "offsetmap dudv.png 0.5\n",
            "offsetmap dudv.png -0.5 down\n",
            "offsetmap \"none\" 1\n",
            "offsetmap none\n",
            "procedural-bump waves 0.02 0 1 0 1 0.25 1\n",
            "procedural-bump waves 0.02 0 1 0 1 0.25 1 around 20 fold 0.2\n",
            "procedural-bump noise -0.1 0 0 0 1 1 1 octaves 7\n",
            "procedural-bump marble 0.1 0 0 0 1 1 1 fold 2\n",
            "procedural-bump wood 0.1 0 0 0 1 1 1\n",
            "procedural-bump none\n",
            "emboss \"CS 184\" 0.01\n",
            "emboss none\n",
        ]);
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("shadowless maybe", "unknown-word", 12),
            ("shadowless", "argument-count", 1),
            ("horizon far", "unknown-word", 9),
            ("lightmap a.png -1", "out-of-range", 16),
            ("bump a.png", "argument-count", 1),
            ("highlight shiny", "unknown-word", 11),
            ("emission 1 1", "argument-count", 1),
            ("emission 1 -1 0", "out-of-range", 12),
            ("emission 1 1 0 a.png b.png", "argument-count", 22),
            ("emission 1 1 0 \"\"", "out-of-range", 16),
            ("normalmap a.png left", "unknown-word", 17),
            ("offsetmap a.png", "argument-count", 1),
            ("offsetmap a.png 1 left", "unknown-word", 19),
            ("procedural-bump dots 1 0 0 0 1 1 1", "unknown-word", 17),
            ("procedural-bump waves 1 0 0 0 1 0 1", "out-of-range", 33),
            ("procedural-bump waves 1 0 0 0 1 1", "argument-count", 1),
            (
                "procedural-bump waves 1 0 0 0 1 1 1 around 0",
                "out-of-range",
                44,
            ),
            (
                "procedural-bump noise 1 0 0 0 1 1 1 octaves 2.5",
                "out-of-range",
                45,
            ),
            (
                "procedural-bump noise 1 0 0 0 1 1 1 bend 2",
                "unknown-word",
                37,
            ),
            ("emboss \" \" 1", "out-of-range", 8),
            ("emboss A", "argument-count", 1),
        ]);
    }
}
