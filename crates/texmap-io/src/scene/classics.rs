//! Solid textures, ramps, decals, words, skies and volumes: lines to the scene.

use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::Font;
use texmap_sample::{ColorSpace, Origin, Pattern, Sampler, Texture2d, UvTransform, Wrap};
use texmap_scene::{
    AlphaMode, Backdrop, Material, Scene, Shading, Solid, SolidSource, TextureSlot, Volume,
};

use super::effects::{Coordinates, Known, Use, environment};
use super::settings::{CurrentTexture, Settings, WHITE, surface};
use crate::font::built_in_font;
use crate::scene_file::{Classic, Role, SolidLine, SolidSource as Source};
use crate::textures::{Content, Textures};
use crate::{IoError, Place};

/// The classics that later faces are under.
#[derive(Debug, Clone, Default)]
pub(super) struct ClassicSettings {
    solid: Option<(Solid, Option<TextureSlot>)>,
    ramp: Option<TextureSlot>,
    cel: Option<TextureSlot>,
    decal: Option<TextureSlot>,
    font: Option<(usize, Font)>,
}

impl ClassicSettings {
    /// A material under these classics.
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
                material.surface = surface(&WHITE, scene.color);
            }
        } else {
            material.color_ramp = self.ramp.clone().filter(|_| material.base_color.is_some());
        }
        material.light_ramp = self.cel.clone();
        material.decal = self.decal.clone().filter(|_| material.base_color.is_some());
        material
    }
}

/// Does what a line says.
pub(super) fn statement(
    classic: &Classic,
    place: &Place,
    scene: &mut Scene,
    textures: &mut Textures,
    settings: &mut Settings,
    known: &mut Known,
) -> Result<(), IoError> {
    let missing = settings.missing;
    let source = textures.source.clone();
    let beside = |name: &str| source.beside(&place.file, name);
    let color = scene.color;
    let mut load = |name: &str| textures.load(&beside(name), place, Content::Color, missing);
    match classic {
        Classic::Solid(None) => settings.classics.solid = None,
        Classic::Solid(Some(line)) => {
            let source = match &line.source {
                Source::File(name) => SolidSource::Grid {
                    grid: textures.grid(&beside(name), place, missing)?,
                    sampler: sampler(settings),
                    wrap_w: settings.wrap[1],
                },
                _ => SolidSource::Pattern(pattern(line)),
            };
            let centred = matches!(source, SolidSource::Grid { .. });
            let placed = placed(line.middle, line.size, centred);
            let solid = Solid {
                source,
                world_from_solid: settings.transform * placed,
            };
            let own = match &line.source {
                Source::Marble => Some(("marble", &MARBLE)),
                Source::Wood => Some(("wood", &WOOD)),
                _ => None,
            };
            let own = own.map(|(name, stops)| {
                let texture = textures.made(name, || ramp_of(stops, color));
                settings.slot(texture, UvTransform::default(), true, color)
            });
            settings.classics.solid = Some((solid, own));
        }
        Classic::Ramp(name) | Classic::Cel(name) => {
            let slot = match name {
                None => None,
                Some(name) => {
                    let texture = load(name)?;
                    Some(settings.slot(texture, UvTransform::default(), true, color))
                }
            };
            match classic {
                Classic::Ramp(_) => settings.classics.ramp = slot,
                _ => settings.classics.cel = slot,
            }
        }
        Classic::Decal(None) => settings.classics.decal = None,
        Classic::Decal(Some((name, [u, v, width, height]))) => {
            let texture = load(name)?;
            let transform = UvTransform {
                offset: [-u / width, -v / height],
                scale: [1.0 / width, 1.0 / height],
                rotation: 0.0,
            };
            let mut slot = settings.slot(texture, transform, true, color);
            let clear = (Wrap::ClampToBorder, Wrap::ClampToBorder);
            (slot.sampler.wrap_u, slot.sampler.wrap_v) = clear;
            slot.sampler.border = [0.0; 4];
            settings.classics.decal = Some(slot);
        }
        Classic::Font(None) => settings.classics.font = None,
        Classic::Font(Some((name, [columns, rows, first]))) => {
            let texture = load(name)?;
            settings.classics.font = Some((texture, Font::whole(*columns, *rows, *first)));
        }
        Classic::Text {
            words,
            origin,
            right,
            up,
        } => {
            let (texture, font) = font(settings, textures);
            let to_world = settings.transform;
            let [right, up] = [right, up].map(|v| to_world.transform_vector3(DVec3::from(*v)));
            let origin = to_world.transform_point3(DVec3::from(*origin));
            let mut material = written(settings, texture, scene);
            material.name = format!("text from {place}");
            // Of each letter: four vertices of position and coordinates, two triangles of indices and a face.
            textures.source.ask(
                words.len() as u64 * (4 * (12 + 8) + 2 * (12 + 4)),
                format_args!("a text of {} letters", words.len()),
                "write fewer words",
                Some(place),
            )?;
            material = settings
                .effects
                .apply(settings, scene, material, Coordinates::FIRST);
            scene.materials.push(material);
            let material = scene.materials.len() - 1;
            scene
                .meshes
                .push(font.mesh(words, origin, right, up, material));
        }
        Classic::Sky(None) => scene.effects.backdrop = None,
        Classic::Sky(Some((name, None))) => {
            let texture = load(name)?;
            let slot = settings.slot(texture, UvTransform::default(), true, color);
            scene.effects.backdrop = Some(Backdrop::Picture(slot));
        }
        Classic::Sky(Some((name, Some(chart)))) => {
            let shown = Use::Shown { mips: false };
            let index = environment(scene, known, &source, &beside(name), place, *chart, shown)?;
            scene.effects.backdrop = Some(Backdrop::Environment(index));
        }
        Classic::Volume {
            file,
            middle,
            size,
            density,
            step,
        } => {
            let grid = textures.grid(&beside(file), place, missing)?;
            let world_from_volume = settings.transform * placed(*middle, *size, true);
            let voxels = textures.grids[grid].level_size(0).unwrap_or([1; 3]);
            let sides = [0, 1, 2].map(|k| {
                let side = world_from_volume.col(k).truncate().length();
                side / f64::from(voxels[k])
            });
            let voxel = sides.into_iter().fold(f64::INFINITY, f64::min);
            scene.effects.volumes.push(Volume {
                grid,
                sampler: sampler(settings),
                transfer: settings.classics.ramp.clone(),
                density: *density,
                step: step.unwrap_or((0.5 * voxel) as f32),
                world_from_volume,
            });
        }
    }
    Ok(())
}

/// The unit cube, its middle or its corner at a place.
fn placed(at: [f64; 3], size: [f64; 3], centred: bool) -> DMat4 {
    let (at, size) = (DVec3::from(at), DVec3::from(size));
    let corner = if centred { at - 0.5 * size } else { at };
    DMat4::from_translation(corner) * DMat4::from_scale(size)
}

fn sampler(settings: &Settings) -> Sampler {
    Sampler {
        filter: settings.filter,
        wrap_u: settings.wrap[0],
        wrap_v: settings.wrap[1],
        ..Sampler::default()
    }
}

fn pattern(line: &SolidLine) -> Pattern {
    let octaves = line.octaves;
    match line.source {
        Source::Wood => Pattern::Wood {
            grain: line.fold.unwrap_or(0.2),
        },
        Source::Marble => Pattern::Marble {
            octaves,
            turbulence: line.fold.unwrap_or(1.0),
        },
        _ => Pattern::Noise { octaves },
    }
}

/// Letters in the colour of the surface, unlit unless a `shade modulate` line says otherwise.
fn written(settings: &Settings, texture: usize, scene: &Scene) -> Material {
    let current = CurrentTexture {
        index: texture,
        name: String::new(),
        has_alpha: true,
    };
    let material = settings.textured(&current, Role::Modulate, scene.color);
    let lit = settings.role == Some(Role::Modulate);
    Material {
        texture_role: texmap_scene::TextureRole::Modulate,
        shading: if lit {
            material.shading
        } else {
            Shading::Unlit
        },
        crisp: true,
        alpha: match settings.alpha {
            crate::scene_file::Alpha::Auto => AlphaMode::Blend,
            _ => material.alpha,
        },
        ..material
    }
}

/// The current font and its atlas.
pub(super) fn font(settings: &Settings, textures: &mut Textures) -> (usize, Font) {
    match settings.classics.font {
        Some(font) => font,
        None => built_in(textures),
    }
}

fn built_in(textures: &mut Textures) -> (usize, Font) {
    let (texture, font) = built_in_font().expect("the atlas has a size that textures may have");
    (textures.made("font", || texture), font)
}

/// sRGB colours at even places.
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

fn ramp_of(stops: &[[u8; 3]], color: texmap_scene::ColorMode) -> Texture2d<'static> {
    let texels = stops
        .iter()
        .flat_map(|[r, g, b]| [*r, *g, *b, 255])
        .collect();
    let space = match color {
        texmap_scene::ColorMode::Srgb => ColorSpace::Srgb,
        texmap_scene::ColorMode::Raw => ColorSpace::Linear,
    };
    Texture2d::from_rgba8(stops.len() as u32, 1, texels, space, Origin::TopLeft)
        .expect("a row of a few texels")
}
