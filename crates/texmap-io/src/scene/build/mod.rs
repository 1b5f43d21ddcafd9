//! Statements to a scene, in one pass.

mod models;

use texmap_light::Light;
use texmap_math::camera::{Camera, CameraError};
use texmap_math::frame::TextureFrame;
use texmap_math::glam::{DMat4, DVec3};
use texmap_scene::{AlphaMode, Material, Scene, Shading, TextureRole};
use texmap_uv::{PixelMapping, UvError};

use super::classics;
use super::effects::{self, Coordinates};
use super::facets::{Facet, Facets};
use super::settings::{CurrentTexture, Settings};
use super::shapes::{self, Bones, DisplaceSetting};
use super::tree::Tree;
use crate::scene_file::{Command, Role, RoundShape, Shape, Statement};
use crate::textures::{Content, Textures};
use crate::{IoError, Place};

pub(super) struct Builder {
    scene: Scene,
    textures: Textures,
    settings: Settings,
    kept: Vec<Settings>,
    /// The last line that set the camera.
    camera_line: Option<Place>,
    /// Faces of the scene so far.
    faces: u32,
    environments: effects::Known,
    bones: Bones,
    /// Effects that some face has in vain, told once each.
    told: Vec<(&'static str, &'static str)>,
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
            environments: effects::Known::default(),
            bones: Bones::default(),
            told: Vec::new(),
        }
    }

    pub(super) fn finish(mut self) -> Result<(Scene, Textures), IoError> {
        if let Some(place) = self.camera_line.take()
            && let Err(error) = check_camera(&self.scene.camera)
        {
            return Err(IoError::BadCamera {
                place,
                problem: error.to_string(),
            });
        }
        self.warn_of_unlit();
        self.bones.bend(&mut self.scene.meshes)?;
        self.scene.textures.clone_from(&self.textures.textures);
        self.scene.effects.grids.clone_from(&self.textures.grids);
        self.scene.warnings.append(&mut self.textures.warnings);
        Ok((self.scene, self.textures))
    }

    /// All statements of a file. What it sets ends with it; what it draws, its lights and its camera stay.
    pub(super) fn file(&mut self, tree: &Tree) -> Result<(), IoError> {
        let settings = self.settings.clone();
        let mut facets = Facets::default();
        let mut included = tree.included.iter();
        for statement in &tree.file.statements {
            let place = Place::new(&tree.path, statement.line, statement.column);
            match &statement.command {
                Command::Include(_) => {
                    if let Some(below) = included.next() {
                        self.file(below)?;
                    }
                }
                _ => {
                    let first = self.scene.meshes.len();
                    self.statement(statement, &place, &mut facets)?;
                    for mesh in &mut self.scene.meshes[first..] {
                        mesh.shadowless = self.settings.effects.shadowless;
                    }
                }
            }
        }
        facets.finish(&mut self.scene, &mut self.bones);
        self.settings = settings;
        Ok(())
    }

    fn statement(
        &mut self,
        statement: &Statement,
        place: &Place,
        facets: &mut Facets,
    ) -> Result<(), IoError> {
        let camera = &mut self.scene.camera;
        match &statement.command {
            Command::Eye(p) => camera.eye = DVec3::from(*p),
            Command::Look(p) => camera.look = DVec3::from(*p),
            Command::Up(p) => camera.up = DVec3::from(*p),
            Command::Fov(degrees) => camera.fov_x = degrees.to_radians(),
            Command::Near(distance) => camera.near = *distance,
            Command::Far(distance) => camera.far = *distance,
            other => return self.after_camera(other, place, facets),
        }
        self.camera_line = Some(place.clone());
        Ok(())
    }

    fn after_camera(
        &mut self,
        command: &Command,
        place: &Place,
        facets: &mut Facets,
    ) -> Result<(), IoError> {
        let lights = &mut self.scene.lights;
        match command {
            Command::Background(color) => self.scene.background = *color,
            &Command::AmbientLight(color) => lights.push(Light::Ambient { color }),
            &Command::DirectionalLight { color, direction } => {
                lights.push(Light::Directional { color, direction });
            }
            &Command::PointLight { color, position } => {
                lights.push(Light::Point { color, position });
            }
            Command::Vertex(p) => {
                let position = self.settings.transform.transform_point3(DVec3::from(*p));
                if !position.as_vec3().is_finite() {
                    let text = position.to_string();
                    return Err(IoError::NotFinite {
                        place: place.clone(),
                        command: "v",
                        text,
                    });
                }
                facets.vertex(position);
            }
            Command::Face(corners) => {
                let corners: Vec<_> = corners.iter().map(|&i| (i, [0.0; 2])).collect();
                let material = self.settings.plain(self.scene.color);
                self.facet(facets, place, material, &corners, None, false);
            }
            Command::TexturedFace(corners) => {
                let corners: Vec<_> = corners.iter().map(|c| (c.vertex, c.uv)).collect();
                let material = self.textured("tf", place)?;
                self.facet(facets, place, material, &corners, None, true);
            }
            Command::FramedFace(indices) => {
                let material = self.textured("ff", place)?;
                let frame = self
                    .settings
                    .frame
                    .filter(|_| self.settings.round.is_none());
                if frame.is_none() && self.settings.round.is_none() {
                    return Err(needs("ff", place, "frame"));
                }
                if let Some(how) = frame.and_then(|frame| facets.out_of_plane(indices, &frame)) {
                    self.scene.warnings.push(format!(
                        "{place}: the frame is {how}: the texture slides over it as the eye moves"
                    ));
                }
                let corners: Vec<_> = indices.iter().map(|&i| (i, [0.0; 2])).collect();
                self.facet(facets, place, material, &corners, frame, false);
            }
            Command::Obj(name) => self.obj(name, place)?,
            Command::Classic(classic) => classics::statement(
                classic,
                place,
                &mut self.scene,
                &mut self.textures,
                &mut self.settings,
                &mut self.environments,
            )?,
            Command::Effect(effect) => effects::statement(
                effect,
                place,
                &mut self.scene,
                &mut self.textures,
                &mut self.settings,
                &mut self.environments,
            )?,
            Command::Shape(shape) => self.shape(shape, place)?,
            Command::Texture(None) => self.settings.texture = None,
            Command::Texture(Some(name)) => {
                let path = self.textures.source.beside(&place.file, name);
                let index =
                    self.textures
                        .load(&path, place, Content::Color, self.settings.missing)?;
                let has_alpha = self.textures.textures[index].has_alpha();
                self.settings.texture = Some(CurrentTexture {
                    index,
                    name: name.clone(),
                    has_alpha,
                });
            }
            Command::Push => self.kept.push(self.settings.clone()),
            // The parser has matched each `pop` with a `push`.
            Command::Pop => self.settings = self.kept.pop().unwrap_or_default(),
            Command::Round(shape) => {
                let moved = |r| round(r).map(|m| m.moved(&self.settings.transform));
                self.settings.round = shape.as_ref().map(moved).transpose().map_err(|e| {
                    IoError::DegenerateFrame {
                        place: place.clone(),
                        problem: e.to_string(),
                    }
                })?;
            }
            other => self.settings.set(other),
        }
        Ok(())
    }

    fn textured(&self, command: &'static str, place: &Place) -> Result<Material, IoError> {
        let texture = self
            .settings
            .texture
            .as_ref()
            .ok_or_else(|| needs(command, place, "texture"))?;
        Ok(self
            .settings
            .textured(texture, Role::Decal, self.scene.color))
    }

    fn facet(
        &mut self,
        facets: &mut Facets,
        place: &Place,
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
        let material = self.material(material, coordinates, place);
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
        facets.add(&mut self.scene, &facet, place);
    }

    fn shape(&mut self, shape: &Shape, place: &Place) -> Result<(), IoError> {
        let missing = self.settings.missing;
        let mut data = |name: &str| {
            let path = self.textures.source.beside(&place.file, name);
            self.textures.load(&path, place, Content::Data, missing)
        };
        match shape {
            Shape::Displace(None) => self.settings.displace = None,
            Shape::Displace(Some(line)) => {
                self.settings.displace = Some(DisplaceSetting {
                    texture: data(&line.file)?,
                    height: line.height,
                    middle: line.middle,
                    budget: line.budget,
                    triangles: line.triangles,
                });
            }
            Shape::Bone(line) => self.bones.add(line, &self.settings.transform, place)?,
            Shape::Skin(skin) => {
                self.settings.skin = skin.map(|blend| (blend, place.clone()));
            }
            Shape::Terrain(line) => {
                let heights = data(&line.file)?;
                let mut ground = shapes::terrain(line, &self.textures.textures[heights], place)?;
                let middle = DMat4::from_translation(line.position.into());
                ground.world_from_object = self.settings.transform * middle;
                if self.settings.transform.determinant() < 0.0 {
                    ground.triangles.iter_mut().for_each(|t| t.swap(1, 2));
                }
                let color = self.scene.color;
                let material = match &self.settings.texture {
                    Some(texture) => self.settings.textured(texture, Role::Modulate, color),
                    None => self.settings.plain(color),
                };
                ground.material = self.material(material, Coordinates::FIRST, place);
                ground.round = self.settings.round;
                let cells = ground.faces.last().map_or(0, |last| last + 1);
                ground.faces.iter_mut().for_each(|f| *f += self.faces);
                self.faces += cells;
                self.bones
                    .follow(self.scene.meshes.len(), self.settings.skin.clone());
                self.scene.meshes.push(ground);
            }
            &Shape::Billboard {
                position,
                size,
                axis,
            } => {
                let material = self.textured("billboard", place)?;
                let material = self.material(material, Coordinates::FIRST, place);
                let board = shapes::billboard(position, size, axis, &self.settings.transform);
                let number = self.faces;
                self.faces += 1;
                let name = format!("billboard from {}:{}", place.file.display(), place.line);
                let mut mesh = texmap_mesh::billboards(&name, vec![board], material);
                mesh.faces = vec![number; 2];
                self.scene.meshes.push(mesh);
            }
        }
        Ok(())
    }

    /// Index of a material under the current effects, a new one or an equal one. `place` draws faces of it.
    fn material(&mut self, material: Material, coordinates: Coordinates, place: &Place) -> usize {
        let effects = &self.settings.effects;
        let out_of_reach = effects.out_of_reach(coordinates);
        let material = effects.apply(&self.settings, &self.scene, material, coordinates);
        let material = self
            .settings
            .classics
            .apply(&self.settings, &self.scene, material);
        for (effect, why) in out_of_reach {
            self.tell(place, effect, why);
        }
        if self.is_covered(&material) {
            for effect in effects::covered(&material) {
                let why = "copies its texel, whatever the light (`shade modulate` lights it)";
                self.tell(place, effect, why);
            }
        }
        let materials = &mut self.scene.materials;
        // Faces of one kind follow each other, so the end is the place to look first.
        match materials.iter().rposition(|m| *m == material) {
            Some(index) => index,
            None => {
                materials.push(material);
                materials.len() - 1
            }
        }
    }
}

impl Builder {
    /// Whether the texels of a material hide the surface under them.
    fn is_covered(&self, material: &Material) -> bool {
        let Some(slot) = &material.base_color else {
            return false;
        };
        let clear = self.textures.textures[slot.texture].has_alpha();
        material.texture_role == TextureRole::Decal
            && !(material.alpha == AlphaMode::Opaque && clear)
    }

    /// Warns of an effect that what this line draws does not show, the first time.
    fn tell(&mut self, place: &Place, effect: &'static str, why: &'static str) {
        if self.told.contains(&(effect, why)) {
            return;
        }
        self.told.push((effect, why));
        self.scene.warnings.push(format!(
            "{place}: {effect} is not drawn here: what this line draws {why}"
        ));
    }

    /// Warns of shadows and projectors without a surface that reads them.
    fn warn_of_unlit(&mut self) {
        let lit = self.scene.meshes.iter().any(|mesh| {
            let material = &self.scene.materials[mesh.material];
            material.shading == Shading::PerPixel && !self.is_covered(material)
        });
        let effects = &self.scene.effects;
        let words = [
            (effects.shadows.is_empty(), "`shadow`"),
            (effects.projectors.is_empty(), "`projector`"),
        ];
        for (_, word) in words.into_iter().filter(|(none, _)| !none && !lit) {
            self.scene.warnings.push(format!(
                "{word} is not drawn: no surface of the scene is lit at its pixels"
            ));
        }
    }
}

fn needs(command: &'static str, place: &Place, needs: &'static str) -> IoError {
    IoError::NeedsAbove {
        place: place.clone(),
        command,
        needs,
    }
}

fn check_camera(camera: &Camera) -> Result<(), CameraError> {
    camera.view().map(|_| ())
}

/// A shape in the space of its line.
fn round(shape: &RoundShape) -> Result<PixelMapping, UvError> {
    let [yaw, pitch, roll] = shape.angles.map(f64::to_radians);
    let frame = texmap_uv::Frame {
        position: shape.position.into(),
        yaw,
        pitch,
        roll,
        scale: shape.size.into(),
    };
    PixelMapping::new(
        shape.shape,
        &frame,
        shape.repeat,
        texmap_uv::Origin::TopLeft,
    )
}
