//! Shape lines to the scene: terrain, billboards, and the bones that meshes follow when all lines are read.

use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::MeshError;
use texmap_mesh::{Bone, Skeleton, SkinBlend};
use texmap_sample::Texture2d;
use texmap_scene::{Billboard, Displacement, EdgeBudget, Facing, Mesh, TextureSlot};

use super::settings::rotation;
use crate::scene_file::{BoneLine, TerrainLine};
use crate::{IoError, Place};

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

/// The bones of a scene, how each is turned, and the meshes that follow them.
#[derive(Debug, Default)]
pub(super) struct Bones {
    skeleton: Skeleton,
    turns: Vec<DMat4>,
    /// Mesh, blend, and the `skin` line.
    followers: Vec<(usize, SkinBlend, Place)>,
}

impl Bones {
    pub(super) fn add(
        &mut self,
        line: &BoneLine,
        transform: &DMat4,
        place: &Place,
    ) -> Result<(), IoError> {
        let count = self.skeleton.bones.len();
        let out_of_range = |text: String, allowed| IoError::OutOfRange {
            place: place.clone(),
            command: "bone",
            text,
            allowed,
        };
        if let Some(parent) = line.parent.filter(|parent| *parent as usize >= count) {
            return Err(out_of_range(
                parent.to_string(),
                "a bone above this line, counted from 0",
            ));
        }
        if count > usize::from(u16::MAX) {
            return Err(out_of_range(count.to_string(), "65536 bones at most"));
        }
        self.skeleton.bones.push(Bone {
            head: transform.transform_point3(line.head.into()),
            tail: transform.transform_point3(line.tail.into()),
            parent: line.parent.map(|parent| parent as usize),
        });
        self.turns
            .push(line.turn.map_or(DMat4::IDENTITY, |(degrees, axis)| {
                rotation(degrees, transform.transform_vector3(DVec3::from(axis)))
            }));
        Ok(())
    }

    pub(super) fn follow(&mut self, mesh: usize, skin: Option<(SkinBlend, Place)>) {
        self.followers
            .extend(skin.map(|(blend, place)| (mesh, blend, place)));
    }

    /// Bends every mesh that follows.
    pub(super) fn bend(self, meshes: &mut [Mesh]) -> Result<(), IoError> {
        let Some((_, _, first)) = self.followers.first() else {
            return Ok(());
        };
        if self.skeleton.bones.is_empty() {
            return Err(IoError::NeedsAbove {
                place: first.clone(),
                command: "skin",
                needs: "bone",
            });
        }
        let pose = self
            .skeleton
            .pose(&self.turns)
            .map_err(|e| bad_shape(first, &e))?;
        for (index, blend, place) in &self.followers {
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
                .map_err(|e| bad_shape(place, &e))?;
        }
        Ok(())
    }
}

/// The ground of a `terrain` line, in the space of the line.
pub(super) fn terrain(
    line: &TerrainLine,
    heights: &Texture2d<'_>,
    place: &Place,
) -> Result<Mesh, IoError> {
    let name = format!("terrain from {}:{}", place.file.display(), place.line);
    texmap_mesh::height_field(&name, heights, line.size, line.step)
        .map_err(|e| bad_shape(place, &e))
}

/// A billboard of a `billboard` line. It is scaled by the lengths of the transform's sides and turned to the camera.
pub(super) fn billboard(
    position: [f64; 3],
    [width, height]: [f64; 2],
    axis: Option<[f64; 3]>,
    transform: &DMat4,
) -> Billboard {
    Billboard {
        position: transform.transform_point3(position.into()),
        size: [
            width * transform.x_axis.truncate().length(),
            height * transform.y_axis.truncate().length(),
        ],
        facing: match axis {
            None => Facing::Screen,
            Some(axis) => Facing::Axis(transform.transform_vector3(axis.into())),
        },
    }
}

fn bad_shape(place: &Place, error: &MeshError) -> IoError {
    if let MeshError::Memory(refused) = error {
        return IoError::memory(refused.clone(), Some(place));
    }
    IoError::BadShape {
        place: place.clone(),
        problem: error.to_string(),
    }
}
