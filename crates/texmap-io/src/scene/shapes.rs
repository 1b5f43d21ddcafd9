//! Shape lines to the scene: terrain, billboards, and the bones that meshes follow when all lines are read.

use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::{Bone, MeshError, Skeleton, SkinBlend};

use texmap_scene::{Billboard, Displacement, EdgeBudget, Facing, Mesh, TextureRole, TextureSlot};

use super::build::Builder;
use super::effects::Coordinates;
use super::settings::rotation;
use crate::scene_file::Line;
use crate::textures::Content;
use crate::{IoError, SourceLocation};

/// A `displace` line with its map read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DisplaceSetting {
    pub(super) texture: usize,
    pub(super) height: f32,
    pub(super) middle: f32,
    pub(super) budget: EdgeBudget,
    pub(super) triangles: u32,
}

impl DisplaceSetting {
    pub(super) fn displacement(&self, slot: TextureSlot) -> Displacement {
        Displacement {
            slot,
            height: self.height,
            middle: self.middle,
            budget: self.budget,
            max_triangles: self.triangles,
        }
    }
}

/// The bones of a scene, their rotations, and the meshes that follow them.
#[derive(Debug, Default)]
pub(super) struct Bones {
    skeleton: Skeleton,
    turns: Vec<DMat4>,
    /// Mesh, blend, and the `skin` line.
    followers: Vec<(usize, SkinBlend, SourceLocation)>,
}

impl Bones {
    /// The bone of a line.
    fn add(&mut self, line: &mut Line<'_>, transform: &DMat4) -> Result<(), IoError> {
        let [head, tail] = [line.numbers(), line.numbers()].map(DVec3::from);
        let (mut parent, mut turn) = (None, DMat4::IDENTITY);
        while let Some(word) = line.word() {
            match word {
                "parent" => parent = Some(line.whole() as usize),
                _ => {
                    let (degrees, axis) = (line.number(), DVec3::from(line.numbers()));
                    // A mirror turns the sense of a turn about.
                    let sense = transform.determinant().signum();
                    turn = rotation(sense * degrees, transform.transform_vector3(axis));
                }
            }
        }
        let count = self.skeleton.bones.len();
        let out_of_range = |text: String, allowed| IoError::OutOfRange {
            location: line.location.clone(),
            command: "bone",
            text,
            allowed,
        };
        if let Some(parent) = parent.filter(|parent| *parent >= count) {
            return Err(out_of_range(
                parent.to_string(),
                "a bone above this line, counted from 0",
            ));
        }
        if count >= Skeleton::MAX_BONES {
            return Err(out_of_range(count.to_string(), "65536 bones at most"));
        }
        self.skeleton.bones.push(Bone {
            head: transform.transform_point3(head),
            tail: transform.transform_point3(tail),
            parent,
        });
        self.turns.push(turn);
        Ok(())
    }

    pub(super) fn follow(&mut self, mesh: usize, skin: Option<(SkinBlend, SourceLocation)>) {
        self.followers
            .extend(skin.map(|(blend, location)| (mesh, blend, location)));
    }

    /// Bends every mesh that follows.
    pub(super) fn bend(self, meshes: &mut [Mesh]) -> Result<(), IoError> {
        let Some((_, _, first)) = self.followers.first() else {
            return Ok(());
        };
        if self.skeleton.bones.is_empty() {
            return Err(IoError::NeedsAbove {
                location: first.clone(),
                command: "skin",
                needs: "a `bone` line",
            });
        }
        let pose = self
            .skeleton
            .pose(&self.turns)
            .map_err(|e| bad_shape(first, &e))?;
        for (index, blend, location) in &self.followers {
            let mesh = &mut meshes[*index];
            let (to_world, from_world) = (mesh.world_from_object, mesh.world_from_object.inverse());
            let world: Vec<[f32; 3]> = mesh
                .positions
                .iter()
                .map(|p| {
                    to_world
                        .transform_point3(DVec3::from(p.map(f64::from)))
                        .as_vec3()
                        .to_array()
                })
                .collect();
            let pose: Vec<DMat4> = pose.iter().map(|m| from_world * *m * to_world).collect();
            *mesh = self
                .skeleton
                .skin(&world, *blend)
                .bend(mesh, &pose)
                .map_err(|e| bad_shape(location, &e))?;
        }
        Ok(())
    }
}

/// `displace`.
pub(super) fn displace(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    if line.takes("none") {
        b.settings.displace = None;
        return Ok(());
    }
    let mut setting = DisplaceSetting {
        texture: b.load(line, Content::Data)?,
        height: line.float(),
        middle: 0.0,
        budget: EdgeBudget::Pixels(2.0),
        triangles: Displacement::MAX_TRIANGLES,
    };
    while let Some(word) = line.word() {
        match word {
            "middle" => setting.middle = line.float(),
            "texels" => setting.budget = EdgeBudget::Texels(line.float()),
            "pixels" => setting.budget = EdgeBudget::Pixels(line.float()),
            _ => setting.triangles = line.whole(),
        }
    }
    b.settings.displace = Some(setting);
    Ok(())
}

/// `bone`.
pub(super) fn bone(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    b.bones.add(line, &b.settings.transform)
}

/// `skin`.
pub(super) fn skin(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    let blend = match line.word() {
        Some("rigid") => Some(SkinBlend::Rigid),
        Some("smooth") => Some(SkinBlend::Smooth(line.number())),
        _ => None,
    };
    b.settings.skin = blend.map(|blend| (blend, line.location.clone()));
    Ok(())
}

/// `terrain`: a height field about a point.
pub(super) fn terrain(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    let heights = b.load(line, Content::Data)?;
    let (middle, size) = (DVec3::from(line.numbers()), line.floats());
    let step = if line.takes("step") { line.whole() } else { 1 };
    let location = &line.location;
    let name = format!("terrain from {}:{}", location.file.display(), location.line);
    let mut ground = texmap_mesh::height_field(&name, &b.textures.textures[heights], size, step)
        .map_err(|e| bad_shape(location, &e))?;
    ground.world_from_object = b.settings.transform * DMat4::from_translation(middle);
    let color = b.scene.color;
    let material = match &b.settings.texture {
        Some(texture) => b.settings.textured(texture, TextureRole::Modulate, color),
        None => b.settings.plain(color),
    };
    ground.material = b.material(material, Coordinates::FIRST, location);
    ground.uv_projection = b.settings.round;
    let cells = ground.faces.last().map_or(0, |last| last + 1);
    ground.faces.iter_mut().for_each(|f| *f += b.faces);
    b.faces += cells;
    b.bones
        .follow(b.scene.meshes.len(), b.settings.skin.clone());
    b.scene.meshes.push(ground);
    Ok(())
}

/// `billboard`: a card that the transform moves and scales, but does not turn.
pub(super) fn billboard(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    let material = b.textured(line)?;
    let material = b.material(material, Coordinates::FIRST, &line.location);
    let transform = &b.settings.transform;
    let (position, [width, height]) = (DVec3::from(line.numbers()), line.numbers());
    let card = Billboard {
        position: transform.transform_point3(position),
        size: [
            width * transform.x_axis.truncate().length(),
            height * transform.y_axis.truncate().length(),
        ],
        facing: match line.takes("axis") {
            false => Facing::Screen,
            true => Facing::Axis(transform.transform_vector3(line.numbers().into())),
        },
    };
    let number = b.faces;
    b.faces += 1;
    let location = &line.location;
    let name = format!(
        "billboard from {}:{}",
        location.file.display(),
        location.line
    );
    let mut mesh = texmap_mesh::billboards(&name, vec![card], material);
    mesh.faces = vec![number; 2];
    b.scene.meshes.push(mesh);
    Ok(())
}

fn bad_shape(location: &SourceLocation, error: &MeshError) -> IoError {
    if let MeshError::Memory(refused) = error {
        return IoError::memory(refused.clone(), Some(location));
    }
    IoError::BadShape {
        location: location.clone(),
        problem: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use crate::scene_file::{assert_faults, assert_reads_back};

    #[test]
    fn lines_print_back_and_faults_are_placed() {
        assert_reads_back(&[
            "displace h.png 0.5 middle 0.25 texels 2 triangles 5000\n",
            "displace none\n",
            "displace \"none\" -1 middle 0 pixels 4 triangles 4000000\n",
            "terrain h.png 1 2 3 40 5 60 step 2\n",
            "billboard 0 1 2 3 4\n",
            "billboard 0 1 2 3 4 axis 0 1 0\n",
            "bone 0 0 0 1 0 0\n",
            "bone 1 0 0 2 0 0 parent 0 turn 30 0 0 1\n",
            "skin rigid\n",
            "skin smooth 0.5\n",
            "skin none\n",
        ]);
        assert_faults(&[
            ("displace h.png", "argument-count", 1),
            ("displace h.png 1 texels 0", "out-of-range", 25),
            ("displace h.png 1 pixels nan", "not-finite", 25),
            ("displace h.png 1 inches 2", "unknown-word", 18),
            ("displace h.png 1 triangles 0", "out-of-range", 28),
            ("displace h.png 1 texels", "argument-count", 1),
            ("terrain h.png 0 0 0 1 1", "argument-count", 1),
            ("terrain h.png 0 0 0 1 1 0", "out-of-range", 25),
            ("terrain h.png 0 0 0 1 1 1 step 0.5", "out-of-range", 32),
            ("billboard 0 0 0 1", "argument-count", 1),
            ("billboard 0 0 0 1 0", "out-of-range", 19),
            ("billboard 0 0 0 1 1 axis 0 0 0", "out-of-range", 26),
            ("bone 0 0 0 1 0", "argument-count", 1),
            ("bone 0 0 0 1 0 0 turn 3 0 0 0", "out-of-range", 25),
            ("bone 0 0 0 1 0 0 parent -1", "out-of-range", 25),
            ("skin smooth 0", "out-of-range", 13),
            ("skin stiff", "unknown-word", 6),
        ]);
    }
}
