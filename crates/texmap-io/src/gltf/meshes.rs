//! The meshes of a scene: each primitive of each node that draws it.

use std::collections::HashMap;

use texmap_math::glam::DMat4;
use texmap_scene::{AlphaMode, Material, Mesh, NormalDetail, Shading, UvSet};

use super::animation::Pose;
use super::geometry::{Geometry, Reads, Shape, geometry, joints, weights};
use super::json::{Instancing, Primitive};
use super::materials::{self, Described};
use super::model::Model;
use super::nodes::{Tree, Trs};
use super::topology;
use crate::{IoError, shortened};

/// Reads the meshes of all nodes that are drawn. A default material is added where one is needed.
pub(super) fn meshes(
    model: &mut Model<'_>,
    tree: &Tree,
    pose: &Pose,
    described: &mut Vec<Described>,
) -> Result<Vec<Mesh>, IoError> {
    let mut reader = Reader {
        default: None,
        told: HashMap::new(),
        meshes: Vec::new(),
    };
    let has_default = |model: &Model<'_>| {
        let mut primitives = model.document.meshes.iter().flat_map(|m| &m.primitives);
        primitives.any(|p| p.material.is_none())
    };
    if has_default(model) {
        reader.default = Some(described.len());
        described.push(materials::standard());
    }
    for n in &tree.shown {
        reader.node(model, *n, tree, pose, described)?;
    }
    for (what, (count, first)) in sorted(reader.told) {
        let more = if count > 1 {
            format!(", and {} more", count - 1)
        } else {
            String::new()
        };
        model.warn(format!("{first}{more}: {what}"));
    }
    Ok(reader.meshes)
}

struct Reader {
    /// Index of the default material, if primitives need one.
    default: Option<usize>,
    /// Parts that are not drawn as the file says, by their warning: their number and the first position.
    told: HashMap<&'static str, (usize, String)>,
    meshes: Vec<Mesh>,
}

/// In the order of their sentences, so that warnings have one order.
fn sorted(told: HashMap<&'static str, (usize, String)>) -> Vec<(&'static str, (usize, String))> {
    let mut told: Vec<_> = told.into_iter().collect();
    told.sort_unstable_by_key(|(what, _)| *what);
    told
}

impl Reader {
    fn tell(&mut self, what: &'static str, at: &str) {
        self.told
            .entry(what)
            .or_insert_with(|| (0, at.to_owned()))
            .0 += 1;
    }

    fn node(
        &mut self,
        model: &Model<'_>,
        n: usize,
        tree: &Tree,
        pose: &Pose,
        described: &[Described],
    ) -> Result<(), IoError> {
        let node = &model.document.nodes[n];
        let Some(index) = node.mesh else {
            return Ok(());
        };
        let at = format!("/nodes/{n}");
        let mesh = model.item(&model.document.meshes, index, &format!("{at}/mesh"), "mesh")?;
        let animated = pose.weights.get(&n);
        let shape = Shape {
            weights: weights(mesh, animated.or(node.weights.as_ref())),
            joints: match node.skin {
                Some(skin) => Some(joints(model, skin, &tree.world, &format!("{at}/skin"))?),
                None => None,
            },
        };
        let places = match &node.extensions.instancing {
            Some(instancing) => instances(
                model,
                instancing,
                &format!("{at}/extensions/EXT_mesh_gpu_instancing"),
            )?,
            None => vec![DMat4::IDENTITY],
        };
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let at = format!("/meshes/{index}/primitives/{p}");
            let Some((geometry, material)) =
                self.primitive(model, primitive, &shape, described, &at)?
            else {
                continue;
            };
            let bytes = 4
                * (3 * geometry.positions.len()
                    + 3 * geometry.normals.len()
                    + 4 * geometry.tangents.len()
                    + 2 * geometry.uvs.len()
                    + 3 * geometry.triangles.len());
            model.ask((bytes * places.len()) as u64, &at)?;
            let name = match (mesh.name.as_str(), node.name.as_str()) {
                ("", "") => format!("mesh {index}"),
                ("", name) | (name, _) => shortened(name).to_string(),
            };
            let world = |place: &DMat4| match geometry.in_world {
                true => DMat4::IDENTITY,
                false => tree.world[n] * *place,
            };
            if let Some((last, others)) = places.split_last() {
                for place in others {
                    self.place(geometry.clone(), &name, material, world(place), &at);
                }
                let world = world(last);
                self.place(geometry, &name, material, world, &at);
            }
        }
        Ok(())
    }

    /// The vertices of a primitive and the index of its material; `None` for one without triangles.
    fn primitive(
        &mut self,
        model: &Model<'_>,
        primitive: &Primitive,
        shape: &Shape,
        described: &[Described],
        at: &str,
    ) -> Result<Option<(Geometry, usize)>, IoError> {
        match topology::has_triangles(primitive.mode) {
            Some(true) => {}
            Some(false) => {
                self.tell("points and lines are not drawn", at);
                return Ok(None);
            }
            None => {
                let problem = format!("{} is none of 0 to 6", primitive.mode);
                return Err(model.broken(&format!("{at}/mode"), problem));
            }
        }
        let bare = primitive
            .attributes
            .get("POSITION")
            .and_then(|p| model.document.accessors.get(*p));
        if primitive.extensions.draco.is_some()
            && bare.is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none())
        {
            let name = "KHR_draco_mesh_compression";
            let help = super::extensions::DECODE.to_owned();
            return Err(model.unsupported(&format!("{at}/extensions/{name}"), name, help));
        }
        let index = match primitive.material {
            Some(index) => {
                let materials = &model.document.materials;
                model.item(materials, index, &format!("{at}/material"), "material")?;
                index
            }
            None => self.default.unwrap_or(0),
        };
        let Some(Described { material, sets }) = described.get(index) else {
            return Ok(None);
        };
        let reads = Reads {
            sets: *sets,
            lit: material.shading != Shading::Unlit,
            tangents: matches!(material.normal_detail, Some(NormalDetail::NormalMap { .. })),
        };
        let mut geometry = geometry(model, primitive, shape, reads, at)?;
        if geometry.triangles.is_empty() {
            self.tell("has no whole triangle", at);
            return Ok(None);
        }
        if geometry.tangents.iter().any(|t| t[..3] == [0.0; 3]) {
            self.tell(
                "has tangents of no length: they are computed from the coordinates instead",
                at,
            );
            geometry.tangents.clear();
        }
        if geometry.clear_colors && material.alpha != AlphaMode::Opaque {
            self.tell("the alpha of vertex colours is not drawn", at);
        }
        self.complete(&mut geometry, material, at);
        Ok(Some((geometry, index)))
    }

    /// Coordinates for textures on meshes that have none.
    fn complete(&mut self, geometry: &mut Geometry, material: &Material, at: &str) {
        let vertices = geometry.positions.len();
        let reads = |set: UvSet| material.slots().any(|slot| slot.uv_set == set);
        let (first, second) = (reads(UvSet::First), reads(UvSet::Second));
        if first && geometry.uvs.is_empty() || second && geometry.second.is_empty() {
            self.tell(
                "has textures but not the coordinates that they read: their texel at 0, 0 is drawn",
                at,
            );
        }
        if (first || second) && geometry.uvs.is_empty() {
            geometry.uvs = vec![[0.0; 2]; vertices];
        }
        if second && geometry.second.is_empty() {
            geometry.second = vec![[0.0; 2]; vertices];
        }
    }

    /// Adds a mesh under a transform to the world.
    fn place(&mut self, geometry: Geometry, name: &str, material: usize, world: DMat4, at: &str) {
        let size = world.determinant();
        if size == 0.0 || !size.is_finite() || !world.is_finite() {
            self.tell("is scaled to nothing and left out", at);
            return;
        }
        self.meshes.push(Mesh {
            name: name.to_owned(),
            positions: geometry.positions,
            normals: geometry.normals,
            tangents: geometry.tangents,
            uvs: geometry.uvs,
            lightmap_uvs: geometry.second,
            colors: geometry.colors,
            triangles: geometry.triangles,
            material,
            world_from_object: world,
            ..Mesh::default()
        });
    }
}

/// The matrices of instances (`EXT_mesh_gpu_instancing`).
fn instances(model: &Model<'_>, instancing: &Instancing, at: &str) -> Result<Vec<DMat4>, IoError> {
    let mut count = None;
    let mut accessor = |name: &str| {
        let Some(index) = instancing.attributes.get(name) else {
            return Ok(None);
        };
        let accessor = model.accessor(*index, &format!("{at}/attributes/{name}"))?;
        accessor.expect(*count.get_or_insert(accessor.count), "instances")?;
        Ok::<_, IoError>(Some(accessor))
    };
    let wide3 = |v: Vec<[f32; 3]>| v.into_iter().map(|v| v.map(f64::from)).collect::<Vec<_>>();
    let translations = accessor("TRANSLATION")?
        .map(|a| a.floats::<3>())
        .transpose()?
        .map(wide3);
    let scales = accessor("SCALE")?
        .map(|a| a.floats::<3>())
        .transpose()?
        .map(wide3);
    let rotations = accessor("ROTATION")?.map(|a| a.floats::<4>()).transpose()?;
    let rest = Trs::default();
    let place = |i: usize| Trs {
        translation: translations.as_ref().map_or(rest.translation, |t| t[i]),
        rotation: rotations
            .as_ref()
            .map_or(rest.rotation, |r| r[i].map(f64::from)),
        scale: scales.as_ref().map_or(rest.scale, |s| s[i]),
    };
    Ok((0..count.unwrap_or(1)).map(|i| place(i).matrix()).collect())
}
