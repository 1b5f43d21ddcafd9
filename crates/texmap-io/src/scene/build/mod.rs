//! Statements to a scene, in one pass.

mod known;
mod models;

use std::path::PathBuf;

use texmap_math::camera::{Camera, CameraError};
use texmap_math::glam::DVec3;
use texmap_math::texture_frame::TextureFrame;
use texmap_scene::{AlphaMode, Material, ProjectorMode, Scene, Shading, TextureRole};
use texmap_uv::{CurvedShape, PerPixelProjection};

use super::effects::{self, Coordinates};
use super::environments;
use super::facets::{Facet, Facets};
use super::settings::{CurrentTexture, Settings};
use super::shapes::Bones;
use super::tree::Tree;
use crate::scene_file::{Line, Value};
use crate::textures::{Content, Textures};
use crate::{IoError, SourceLocation};

/// The last that was added to the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Added {
    Nothing,
    Light,
    /// The meshes of a face, a model or a shape.
    Meshes(std::ops::Range<usize>),
}

pub(super) struct Builder {
    pub(super) scene: Scene,
    pub(super) textures: Textures,
    pub(super) settings: Settings,
    pub(super) kept: Vec<Settings>,
    /// The last line that set the camera.
    camera_line: Option<SourceLocation>,
    /// Faces of the scene so far.
    pub(super) faces: u32,
    pub(super) environments: environments::Known,
    pub(super) bones: Bones,
    /// Vertices and faces of the file that is read.
    facets: Facets,
    /// The light, faces or model that a `name` line names.
    pub(super) added: Added,
    /// Materials of the scene.
    known: known::Known,
    /// Effects that some face has in vain, reported once each.
    reported: Vec<(&'static str, &'static str)>,
    /// Effects of faces whose texel covers the surface, with the line of the first and true if pixels of one are lit.
    covered: Vec<(&'static str, SourceLocation, bool)>,
}

impl Builder {
    pub(super) fn new(scene: Scene, textures: Textures, settings: Settings) -> Self {
        Self {
            scene,
            textures,
            settings,
            kept: Vec::new(),
            camera_line: None,
            faces: 0,
            environments: environments::Known::default(),
            bones: Bones::default(),
            facets: Facets::default(),
            added: Added::Nothing,
            known: known::Known::default(),
            reported: Vec::new(),
            covered: Vec::new(),
        }
    }

    pub(super) fn finish(mut self) -> Result<(Scene, Textures), IoError> {
        if let Some(location) = self.camera_line.take()
            && let Err(error) = check_camera(&self.scene.camera)
        {
            return Err(IoError::BadCamera {
                location,
                problem: error.to_string(),
            });
        }
        self.warn_of_covered();
        self.warn_of_unlit();
        self.bones.bend(&mut self.scene.meshes)?;
        self.scene.textures.clone_from(&self.textures.textures);
        self.scene.effects.grids.clone_from(&self.textures.grids);
        self.scene.warnings.append(&mut self.textures.warnings);
        Ok((self.scene, self.textures))
    }

    /// All statements of a file. Its settings end with it; its meshes, lights and camera stay.
    pub(super) fn file(&mut self, tree: &Tree) -> Result<(), IoError> {
        let settings = self.settings.clone();
        let outer = std::mem::take(&mut self.facets);
        self.textures
            .decode_ahead(named_textures(tree, &self.textures));
        let mut included = tree.included.iter();
        for statement in &tree.file.statements {
            let command = &statement.command;
            if command.word() == "include" {
                if let Some(below) = included.next() {
                    self.file(below)?;
                }
                continue;
            }
            let location = SourceLocation::new(&tree.path, statement.line, statement.column);
            let first = self.scene.meshes.len();
            let (lights, faces) = (self.scene.lights.len(), self.faces);
            command.spec().set(self, &mut command.line(location))?;
            let meshes = self.scene.meshes.len();
            if self.scene.lights.len() > lights {
                self.added = Added::Light;
            } else if meshes > first || self.faces > faces {
                self.added = Added::Meshes(first.min(meshes - 1)..meshes);
            }
            for mesh in &mut self.scene.meshes[first..] {
                mesh.casts_no_shadow = self.settings.effects.shadowless;
            }
        }
        let facets = std::mem::replace(&mut self.facets, outer);
        facets.finish(&mut self.scene, &mut self.bones);
        self.settings = settings;
        Ok(())
    }

    /// Names meshes: one as it is called, those of a model with parts `NAME.PART`. Later faces make a mesh of their own.
    pub(super) fn name_meshes(&mut self, name: &str, meshes: std::ops::Range<usize>) {
        let meshes = &mut self.scene.meshes[meshes];
        let single = meshes.len() == 1;
        for mesh in meshes {
            mesh.name = match single {
                true => name.to_owned(),
                false => format!("{name}.{}", mesh.name),
            };
        }
        self.facets.close();
    }

    /// A line about the camera.
    pub(super) fn set_camera(
        &mut self,
        line: &mut Line<'_>,
        set: impl Fn(&mut Camera, &mut Line<'_>),
    ) {
        set(&mut self.scene.camera, line);
        self.camera_line = Some(line.location.clone());
    }

    /// The path of a file that a line names.
    pub(super) fn beside(&self, line: &mut Line<'_>) -> PathBuf {
        let name = line.name();
        self.textures.source.beside(&line.location.file, name)
    }

    /// The texture of a file that a line names.
    pub(super) fn load(&mut self, line: &mut Line<'_>, content: Content) -> Result<usize, IoError> {
        let path = self.beside(line);
        let missing = self.settings.missing;
        self.textures.load(&path, &line.location, content, missing)
    }

    /// `v`.
    pub(super) fn vertex(&mut self, line: &mut Line<'_>) -> Result<(), IoError> {
        let position = DVec3::from(line.numbers());
        let transform = self.settings.transform;
        let position = transform.transform_point3(position);
        if !position.as_vec3().is_finite() {
            return Err(IoError::NotFinite {
                location: line.location.clone(),
                command: "v",
                text: position.to_string(),
            });
        }
        self.facets.vertex(position, transform.determinant() < 0.0);
        Ok(())
    }

    /// `texture`.
    pub(super) fn texture(&mut self, line: &mut Line<'_>) -> Result<(), IoError> {
        self.settings.texture = match line.takes("none") {
            true => None,
            false => {
                let name = line.clone().name();
                let index = self.load(line, Content::Color)?;
                Some(CurrentTexture {
                    index,
                    name: name.to_owned(),
                    has_alpha: self.textures.textures[index].has_alpha(),
                })
            }
        };
        Ok(())
    }

    /// `uv-projection`.
    pub(super) fn round(&mut self, line: &mut Line<'_>) -> Result<(), IoError> {
        let shape = match line.word() {
            Some("sphere") => CurvedShape::Sphere,
            Some("cylinder") => CurvedShape::Cylinder,
            _ => {
                self.settings.round = None;
                return Ok(());
            }
        };
        let position = line.numbers().into();
        let [yaw, pitch, roll] = line.numbers().map(f64::to_radians);
        let frame = texmap_uv::Placement {
            position,
            yaw,
            pitch,
            roll,
            scale: line.numbers().into(),
        };
        let repeat = match line.left() {
            0 => [1.0; 2],
            _ => line.numbers(),
        };
        let mapping = PerPixelProjection::new(shape, &frame, repeat, texmap_uv::Origin::TopLeft);
        let mapping = mapping.map_err(|e| IoError::DegenerateFrame {
            location: line.location.clone(),
            problem: e.to_string(),
        })?;
        self.settings.round = Some(mapping.moved(&self.settings.transform));
        Ok(())
    }

    /// `f`.
    pub(super) fn face(&mut self, line: &mut Line<'_>) {
        let material = self.settings.plain(self.scene.color);
        let corners = line.corners();
        self.facet(&line.location, material, &corners, None, false);
    }

    /// `tf`.
    pub(super) fn textured_face(&mut self, line: &mut Line<'_>) -> Result<(), IoError> {
        let material = self.textured(line)?;
        let corners = line.corners();
        self.facet(&line.location, material, &corners, None, true);
        Ok(())
    }

    /// `ff`.
    pub(super) fn framed_face(&mut self, line: &mut Line<'_>) -> Result<(), IoError> {
        let material = self.textured(line)?;
        let settings = &self.settings;
        let frame = settings.frame.filter(|_| settings.round.is_none());
        if frame.is_none() && settings.round.is_none() {
            return Err(line.needs("a `frame` line"));
        }
        let corners = line.corners();
        if let Some(how) = frame.and_then(|frame| self.facets.out_of_plane(&corners, &frame)) {
            self.scene.warnings.push(format!(
                "{}: the frame is {how}: the texture slides over it as the eye moves",
                line.location
            ));
        }
        self.facet(&line.location, material, &corners, frame, false);
        Ok(())
    }

    /// The material of a line that needs a texture.
    pub(super) fn textured(&self, line: &Line<'_>) -> Result<Material, IoError> {
        let texture = self.settings.texture.as_ref();
        let texture = texture.ok_or_else(|| line.needs("a `texture` line"))?;
        let color = self.scene.color;
        Ok(self.settings.textured(texture, TextureRole::Decal, color))
    }

    fn facet(
        &mut self,
        location: &SourceLocation,
        material: Material,
        corners: &[(u32, [f32; 2])],
        frame: Option<TextureFrame>,
        has_uv: bool,
    ) {
        let lit = material.base_color.is_none() || material.texture_role == TextureRole::Modulate;
        let framed = material.base_color.is_some() && !has_uv;
        let coordinates = Coordinates {
            first: has_uv || framed,
            second: false,
        };
        let material = self.material(material, coordinates, location);
        let facet = Facet {
            corners,
            has_uv,
            frame,
            // A face of `f` or `tf` has no use for a shape.
            round: self.settings.round.filter(|_| framed),
            // Faces without coordinates rest.
            displacement: self
                .settings
                .displacement(self.scene.color)
                .filter(|_| has_uv),
            skin: self.settings.skin.clone(),
            shadowless: self.settings.effects.shadowless,
            lit,
            material,
            number: self.faces,
        };
        self.faces += 1;
        self.facets.add(&mut self.scene, &facet, location);
    }

    /// Index of a material under the current effects, a new one or an equal one. `place` draws faces of it.
    pub(super) fn material(
        &mut self,
        material: Material,
        coordinates: Coordinates,
        location: &SourceLocation,
    ) -> usize {
        let effects = &self.settings.effects;
        let out_of_reach = effects.out_of_reach(coordinates);
        let material = effects.apply(&self.settings, &self.scene, material, coordinates);
        let material = self
            .settings
            .materials
            .apply(&self.settings, &self.scene, material);
        for (effect, why) in out_of_reach {
            self.tell(location, effect, why);
        }
        if self.is_covered(&material) {
            let per_pixel = material.shading == Shading::PerPixel;
            for effect in effects::covered(&material) {
                let known = |of: &(&str, SourceLocation, bool)| of.0 == effect && of.2 == per_pixel;
                if !self.covered.iter().any(known) {
                    self.covered.push((effect, location.clone(), per_pixel));
                }
            }
        }
        let materials = &mut self.scene.materials;
        self.known.find(materials, &material).unwrap_or_else(|| {
            materials.push(material);
            materials.len() - 1
        })
    }
}

impl Builder {
    /// True if the texels of a material hide the surface under them.
    fn is_covered(&self, material: &Material) -> bool {
        let Some(slot) = &material.base_color else {
            return false;
        };
        let ramp = material.color_ramp.iter();
        let mut read = std::iter::once(slot).chain(ramp.filter(|_| material.solid.is_none()));
        let clear = read.any(|slot| self.textures.textures[slot.texture].has_alpha());
        material.texture_role == TextureRole::Decal
            && !(material.alpha == AlphaMode::Opaque && clear)
    }

    /// Warns, the first time, of an effect that the meshes of a line do not show.
    fn tell(&mut self, location: &SourceLocation, effect: &'static str, why: &'static str) {
        if self.reported.contains(&(effect, why)) {
            return;
        }
        self.reported.push((effect, why));
        self.scene.warnings.push(format!(
            "{location}: {effect} is not drawn here: what this line draws {why}"
        ));
    }

    /// Warns of effects that texels hide. Light of projectors shows some.
    fn warn_of_covered(&mut self) {
        let mut projectors = self.scene.effects.projectors.iter();
        let projected = projectors.any(|p| p.mode != ProjectorMode::Decal);
        let why = "copies its texel, whatever the light (`shade modulate` lights it)";
        for (effect, location, per_pixel) in std::mem::take(&mut self.covered) {
            if !(projected && per_pixel && effects::turns_projected_light(effect)) {
                self.tell(&location, effect, why);
            }
        }
    }

    /// Warns of shadows and projectors without a surface that reads them.
    fn warn_of_unlit(&mut self) {
        let materials = || self.scene.meshes.iter().map(|mesh| mesh.material);
        let materials = || materials().map(|material| &self.scene.materials[material]);
        let per_pixel = || materials().filter(|material| material.shading == Shading::PerPixel);
        let effects = &self.scene.effects;
        let unlit = [
            // Texels that cover a surface hide shadows, and are under projectors.
            (
                !effects.shadows.is_empty() && !per_pixel().any(|m| !self.is_covered(m)),
                "`shadow`",
            ),
            (
                !effects.projectors.is_empty() && per_pixel().next().is_none(),
                "`projector`",
            ),
        ];
        for (_, word) in unlit.into_iter().filter(|(unlit, _)| *unlit) {
            self.scene.warnings.push(format!(
                "{word} is not drawn: no surface of the scene is lit at its pixels"
            ));
        }
    }
}

/// The files of `texture` lines.
fn named_textures(tree: &Tree, textures: &Textures) -> Vec<(PathBuf, SourceLocation, Content)> {
    let lines = tree.file.statements.iter();
    let named = lines.filter(|statement| statement.command.word() == "texture");
    let named = named.filter_map(|statement| match statement.command.values() {
        [Value::File(name)] => {
            let location = SourceLocation::new(&tree.path, statement.line, statement.column);
            let path = textures.source.beside(&tree.path, name);
            Some((path, location, Content::Color))
        }
        _ => None,
    });
    named.collect()
}

fn check_camera(camera: &Camera) -> Result<(), CameraError> {
    camera.view().map(|_| ())
}
