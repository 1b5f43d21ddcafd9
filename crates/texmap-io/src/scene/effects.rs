//! Effect lines to the scene: what they add, and the settings that they are.

use std::collections::HashMap;
use std::path::PathBuf;

use texmap_light::{Chart, Green, Highlight, Light, ShadowBias};
use texmap_math::Projector;
use texmap_math::glam::{DMat4, DVec3};
use texmap_sample::{Pattern, UvTransform};
use texmap_scene::{
    Carving, Emission, LightMapSlot, Material, Mesh, Reflection, Relief, Scene, Shadow,
    SlideProjector, SlideRole,
};

use super::classics;
use super::settings::{Settings, emitted};
use crate::scene_file::{Bias, CarveLine, Effect, Formula, Missing, ProjectorLine, ReliefLine};
use crate::textures::{Content, Textures};
use crate::{FileSource, IoError, Place, environment_io, obj, shortened};

/// The effects that later faces are under.
#[derive(Debug, Clone, Default)]
pub(super) struct EffectSettings {
    highlight: Highlight,
    reflection: Option<Reflection>,
    specular_map: Option<usize>,
    light_map: Option<(usize, f32)>,
    /// Linear light and the texture that multiplies it.
    emission: Option<([f32; 3], Option<usize>)>,
    relief: Option<ReliefSetting>,
    /// Normals beyond the horizon stay there.
    horizon_open: bool,
    /// Meshes throw no shadow.
    pub(super) shadowless: bool,
    /// The model with the second set of coordinates, and the line that names it.
    pub(super) lightmap_uv: Option<(PathBuf, Place)>,
}

#[derive(Debug, Clone)]
enum ReliefSetting {
    Bump(usize, f32),
    Offsets(usize, f32, Green),
    Carved(Relief),
    NormalMap(usize, crate::scene_file::NormalMapLine),
}

impl ReliefSetting {
    fn reads_uv(&self) -> bool {
        !matches!(self, Self::Carved(_))
    }
}

/// Effects of a material that faces do not show whose texel covers the surface.
pub(super) fn covered(material: &Material) -> Vec<&'static str> {
    let has = [
        (material.relief.is_some(), BUMPS),
        (material.highlight != Highlight::Phong, "`highlight`"),
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

const BUMPS: &str = "`bump`, `offsetmap`, `carve`, `emboss` or `normalmap`";

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

/// Environments that are read once.
pub(super) type Known = HashMap<(PathBuf, &'static str, Use), usize>;

/// What an environment is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Use {
    /// What it shows, with smaller levels or without.
    Shown { mips: bool },
    /// Gathered with the exponent of these bits.
    Gathered(u32),
}

impl EffectSettings {
    /// Whether some effect reads the coordinates of textures.
    pub(super) fn reads_uv(&self) -> bool {
        !self
            .out_of_reach(Coordinates {
                first: false,
                second: true,
            })
            .is_empty()
    }

    /// The effects that do not reach faces with these coordinates, and why.
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
        if !coordinates.second && self.light_map.is_some() {
            out.push(("`lightmap`", SECOND));
        }
        out
    }

    /// A material under these effects, for faces with these coordinates; what it brings itself stays.
    pub(super) fn apply(
        &self,
        settings: &Settings,
        scene: &Scene,
        mut material: Material,
        coordinates: Coordinates,
    ) -> Material {
        let data = |texture| settings.slot(texture, UvTransform::default(), false, scene.color);
        material.highlight = self.highlight;
        material.reflection = self.reflection;
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
        if material.relief.is_none() {
            let relief = self.relief.as_ref();
            let relief = relief.filter(|relief| coordinates.first || !relief.reads_uv());
            material.relief = relief.map(|relief| match relief {
                ReliefSetting::Bump(texture, height) => Relief::Bump {
                    slot: data(*texture),
                    height: *height,
                },
                ReliefSetting::Offsets(texture, slope, green) => Relief::Offsets {
                    slot: data(*texture),
                    slope: *slope,
                    green: *green,
                },
                ReliefSetting::Carved(relief) => relief.clone(),
                ReliefSetting::NormalMap(texture, line) => Relief::NormalMap {
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

/// Does what an effect line says.
pub(super) fn statement(
    effect: &Effect,
    place: &Place,
    scene: &mut Scene,
    textures: &mut Textures,
    settings: &mut Settings,
    known: &mut Known,
) -> Result<(), IoError> {
    let missing = settings.missing;
    let source = textures.source.clone();
    let beside = |name: &str| source.beside(&place.file, name);
    let mut texture = |name: &str, content| textures.load(&beside(name), place, content, missing);
    match effect {
        &Effect::SpotLight {
            color,
            position,
            direction,
            inner,
            outer,
        } => scene.lights.push(Light::spot(
            color,
            position,
            direction,
            inner.to_radians(),
            outer.to_radians(),
        )),
        Effect::LightName(name) => light_name(scene, name, place)?,
        Effect::Shadow {
            size,
            taps,
            bias,
            area,
        } => {
            let light = scene
                .lights
                .iter()
                .rposition(|light| !matches!(light, Light::Ambient { .. }))
                .ok_or_else(|| IoError::NeedsAbove {
                    place: place.clone(),
                    command: "shadow",
                    needs: "ld, lp or ls",
                })?;
            let bias = bias.map(|bias| match bias {
                Bias::Slope(x) => ShadowBias::Slope(x),
                Bias::Constant(x) => ShadowBias::Constant(x),
                Bias::NormalOffset(x) => ShadowBias::NormalOffset(x),
            });
            scene.effects.shadows.push(Shadow {
                light,
                size: *size,
                bias,
                taps: *taps,
                area: area.map(|(middle, half)| (DVec3::from(middle), half)),
            });
        }
        Effect::Projector(line) => {
            let index = texture(&line.file, Content::Color)?;
            let slide = &textures.textures[index];
            let aspect = f64::from(slide.width()) / f64::from(slide.height());
            let slide = projector(line, index, aspect, settings).map_err(|problem| {
                IoError::BadProjector {
                    place: place.clone(),
                    problem,
                }
            })?;
            scene.effects.projectors.push(slide);
        }
        Effect::Highlight(highlight) => settings.effects.highlight = *highlight,
        Effect::Environment(line) => {
            settings.effects.reflection = match line {
                None => None,
                Some(line) => {
                    let (path, shown) = (beside(&line.file), Use::Shown { mips: line.mips });
                    Some(Reflection {
                        environment: environment(
                            scene, known, &source, &path, place, line.chart, shown,
                        )?,
                        reflectivity: line.share,
                    })
                }
            };
        }
        Effect::SpecularMap(line) => {
            settings.effects.specular_map = match line {
                None => None,
                Some((name, chart, exponent)) => {
                    let (path, gathered) = (beside(name), Use::Gathered(exponent.to_bits()));
                    Some(environment(
                        scene, known, &source, &path, place, *chart, gathered,
                    )?)
                }
            };
        }
        Effect::Shadowless(shadowless) => settings.effects.shadowless = *shadowless,
        Effect::Horizon { clamp } => settings.effects.horizon_open = !clamp,
        Effect::LightMap(line) => {
            settings.effects.light_map = match line {
                None => None,
                Some((name, scale)) => Some((texture(name, Content::Light)?, *scale)),
            };
        }
        Effect::LightMapUv(name) => {
            settings.effects.lightmap_uv = name.as_ref().map(|name| (beside(name), place.clone()));
        }
        Effect::Emission(line) => {
            settings.effects.emission = match line {
                None => None,
                Some((rgb, file)) => {
                    let file = file.as_ref().map(|name| texture(name, Content::Color));
                    Some((emitted(*rgb, scene.color), file.transpose()?))
                }
            };
        }
        Effect::Bump(line) => {
            settings.effects.relief = match line {
                None => None,
                Some((name, height)) => {
                    Some(ReliefSetting::Bump(texture(name, Content::Data)?, *height))
                }
            };
        }
        Effect::Relief(ReliefLine::Offsets { file, slope, green }) => {
            let texture = texture(file, Content::Data)?;
            settings.effects.relief = Some(ReliefSetting::Offsets(texture, *slope, *green));
        }
        Effect::Relief(ReliefLine::Emboss { words, height }) => {
            let (atlas, font) = classics::font(settings, textures);
            let atlas = &textures.textures[atlas];
            let [across, down] = font.heights_size(words, atlas);
            // Bytes, then words with a third more for the mip chain.
            textures.source.ask(
                u64::from(across) * u64::from(down) * 7,
                format_args!("the words of `emboss` as {across} x {down} texels"),
                "write fewer words, or take a smaller font",
                Some(place),
            )?;
            let heights = font.heights(words, atlas);
            let heights = heights.map_err(|e| IoError::BadShape {
                place: place.clone(),
                problem: format!("the words of `emboss` make no map: {e}"),
            })?;
            textures.textures.push(heights);
            let texture = textures.textures.len() - 1;
            settings.effects.relief = Some(ReliefSetting::Bump(texture, *height));
        }
        Effect::Relief(ReliefLine::Carve(line)) => {
            settings.effects.relief = Some(ReliefSetting::Carved(carved(line, settings)));
        }
        Effect::NormalMap(line) => {
            settings.effects.relief = match line {
                None => None,
                Some(line) => Some(ReliefSetting::NormalMap(
                    texture(&line.file, Content::Data)?,
                    line.clone(),
                )),
            };
        }
    }
    Ok(())
}

/// Names the light above.
fn light_name(scene: &mut Scene, name: &str, place: &Place) -> Result<(), IoError> {
    let Some(last) = scene.lights.len().checked_sub(1) else {
        return Err(IoError::NeedsAbove {
            place: place.clone(),
            command: "name",
            needs: "la, ld, lp or ls",
        });
    };
    let names = &mut scene.effects.light_names;
    if let Some(other) = names.iter().position(|known| known == name) {
        return Err(IoError::BadShape {
            place: place.clone(),
            problem: format!("`name`: light {other} is called `{name}` already"),
        });
    }
    names.resize(last + 1, String::new());
    name.clone_into(&mut names[last]);
    Ok(())
}

fn carved(line: &CarveLine, settings: &Settings) -> Relief {
    let octaves = line.octaves;
    let heights = match line.formula {
        Formula::Waves => Carving::Waves {
            around: line.around,
            fold: line.fold.unwrap_or(0.0),
        },
        Formula::Noise => Carving::Pattern(Pattern::Noise { octaves }),
        Formula::Marble => Carving::Pattern(Pattern::Marble {
            octaves,
            turbulence: line.fold.unwrap_or(1.0),
        }),
        Formula::Wood => Carving::Pattern(Pattern::Wood {
            grain: line.fold.unwrap_or(0.2),
        }),
    };
    let (origin, size) = (DVec3::from(line.origin), DVec3::from(line.size));
    let placed = DMat4::from_translation(origin) * DMat4::from_scale(size);
    Relief::Carved {
        heights,
        world_from_solid: settings.transform * placed,
        height: line.height,
    }
}

fn projector(
    line: &ProjectorLine,
    texture: usize,
    aspect: f64,
    settings: &Settings,
) -> Result<SlideProjector, String> {
    let [position, look, up] = [line.position, line.look, line.up].map(DVec3::from);
    let projector =
        Projector::new(position, look, up, line.fov.to_radians(), aspect).map_err(|e| {
            e.to_string()
                .replace("camera: ", "")
                .replace("eye", "position")
        })?;
    let sampler = settings
        .slot(
            texture,
            UvTransform::default(),
            true,
            texmap_scene::ColorMode::Raw,
        )
        .sampler;
    Ok(SlideProjector {
        projector,
        position,
        texture,
        sampler,
        border: line.border,
        softness: line.softness,
        role: if line.paint {
            SlideRole::Paint
        } else {
            SlideRole::Light(line.color)
        },
        shadow: line.shadow,
    })
}

pub(super) fn environment(
    scene: &mut Scene,
    known: &mut Known,
    source: &FileSource,
    path: &std::path::Path,
    place: &Place,
    chart: Chart,
    purpose: Use,
) -> Result<usize, IoError> {
    let key = (path.to_path_buf(), chart.name(), purpose);
    if let Some(&index) = known.get(&key) {
        return Ok(index);
    }
    let read = environment_io::read_named(source, path, chart, Some(place))?;
    let light = match purpose {
        Use::Shown { mips: false } => read,
        Use::Shown { mips: true } => read.with_mips(),
        Use::Gathered(bits) => {
            let exponent = f32::from_bits(bits);
            let size = texmap_light::Environment::blurred_size(exponent);
            read.specular_map(Chart::Cube, size, exponent)
                .map_err(|e| IoError::BrokenImage {
                    path: path.to_path_buf(),
                    named_by: Some(place.clone()),
                    problem: e.to_string(),
                })?
        }
    };
    scene.effects.environments.push(light);
    let index = scene.effects.environments.len() - 1;
    known.insert(key, index);
    Ok(index)
}

/// Gives the meshes of a model the coordinates of another model of the same faces as their second set. Vertices whose corners
/// differ there are split.
pub(super) fn second_uvs(
    meshes: &mut [Mesh],
    textures: &mut Textures,
    path: &std::path::Path,
    place: &Place,
) -> Result<(), IoError> {
    let mut unused = textures.for_coordinates();
    let other = obj::read(path, Some(place), Missing::Warn, false, &mut unused);
    textures.take_counts(unused);
    let other = other?;
    let broken = |problem: String| IoError::BrokenModel {
        path: path.to_path_buf(),
        problem,
    };
    // The triangles of each face of the file, in their order.
    let mut faces: HashMap<u32, Vec<[[f32; 2]; 3]>> = HashMap::new();
    for part in &other.parts {
        if part.uvs.is_empty() {
            return Err(broken(format!(
                "`lightmapuv`: the part `{}` has no `vt`",
                shortened(&part.name)
            )));
        }
        for (triangle, face) in part.triangles.iter().zip(&part.faces) {
            faces
                .entry(*face)
                .or_default()
                .push(triangle.map(|v| part.uvs[v as usize]));
        }
    }
    let mut next: HashMap<u32, usize> = HashMap::new();
    for mesh in meshes {
        let mut split: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        let mut out = Mesh {
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            triangles: Vec::new(),
            lightmap_uvs: Vec::new(),
            ..mesh.clone()
        };
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let face = mesh.face(t as u32);
            let at = next.entry(face).or_default();
            let uvs = faces.get(&face).and_then(|all| all.get(*at)).ok_or_else(|| {
                broken(format!(
                    "`lightmapuv`: face {} of the model has no like in it; both files must have the same faces in the same order",
                    face + 1
                ))
            })?;
            *at += 1;
            let mirrored = mesh.world_from_object.determinant() < 0.0;
            let corner = |k: usize| {
                // A mirrored model has its second and third corners swapped.
                let uv = uvs[if mirrored && k > 0 { 3 - k } else { k }];
                (triangle[k], uv)
            };
            let mut corners = [0; 3];
            for (k, place) in corners.iter_mut().enumerate() {
                let (vertex, uv) = corner(k);
                *place = *split
                    .entry((vertex, uv.map(f32::to_bits)))
                    .or_insert_with(|| {
                        let v = vertex as usize;
                        out.positions.push(mesh.positions[v]);
                        out.normals.extend(mesh.normals.get(v));
                        out.uvs.extend(mesh.uvs.get(v));
                        out.colors.extend(mesh.colors.get(v));
                        out.lightmap_uvs.push(uv);
                        out.positions.len() as u32 - 1
                    });
            }
            out.triangles.push(corners);
        }
        *mesh = out;
    }
    Ok(())
}
