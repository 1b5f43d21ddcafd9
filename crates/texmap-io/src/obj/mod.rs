//! Wavefront OBJ models with their material libraries.

mod edit;
mod materials;
mod model;
mod mtl;
mod normals;
mod not_drawn;
mod parts;
mod pieces;
mod polygon;
mod read;
mod source;
mod vertices;
mod written;

use texmap_sample::UvTransform;

pub use edit::ObjText;
pub(crate) use materials::{decode_maps, material};
pub(crate) use model::{broken_normals, drawn_as_fan, read};
pub(crate) use mtl::Description;
pub(crate) use normals::unit;
pub(crate) use parts::parts;
pub(crate) use read::{Corner, Face, Group, NONE, Obj};
pub(crate) use source::{are_finite, spells_nan};

/// The name of a part that has none.
pub(crate) const UNNAMED: &str = "unnamed_object";

/// A model as its files describe it, not yet dressed for a scene.
#[derive(Debug, Clone, Default)]
pub(crate) struct Model {
    pub(crate) parts: Vec<Part>,
    pub(crate) materials: Vec<Material>,
    /// Colours of vertices are given (sRGB).
    pub(crate) colored: bool,
    pub(crate) warnings: Vec<String>,
}

/// The faces of one object or group with one material.
#[derive(Debug, Clone, Default)]
pub(crate) struct Part {
    pub(crate) name: String,
    /// Into the materials of the model; `None` for faces without `usemtl`.
    pub(crate) material: Option<usize>,
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    /// v grows upwards. Empty, or one per vertex.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// sRGB. Empty, or one per vertex.
    pub(crate) colors: Vec<[f32; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Face of each triangle, counted through the file from 0.
    pub(crate) faces: Vec<u32>,
    /// Faces without coordinates and the line of the first; theirs were projected.
    pub(crate) projected: Option<(u32, u32)>,
    /// Corners and line of the first concave face that has too many for another cut than a fan.
    pub(crate) uncut: Option<(u32, u32)>,
}

/// A material with its maps loaded.
#[derive(Debug, Clone)]
pub(crate) struct Material {
    pub(crate) name: String,
    /// sRGB.
    pub(crate) kd: [f32; 3],
    pub(crate) ks: f32,
    pub(crate) ns: f32,
    pub(crate) opacity: f32,
    pub(crate) map_kd: Option<Map>,
    pub(crate) map_d: Option<Map>,
    pub(crate) map_ka: Option<Map>,
    pub(crate) map_ks: Option<Map>,
    pub(crate) map_ns: Option<Map>,
    /// Light of its own: sRGB up to 1, a linear factor above; black is none.
    pub(crate) ke: [f32; 3],
    pub(crate) map_ke: Option<Map>,
    pub(crate) relief: Option<(Map, ReliefKind)>,
    /// Heights, and the distance from black to white in units of the model (`-bm`).
    pub(crate) displacement: Option<(Map, f32)>,
    /// Of the metallic-roughness extension, if some word of it is there.
    pub(crate) pbr: Option<Pbr>,
}

/// Numbers and maps of the metallic-roughness model. A map stands in place of its number, which is 1 then.
#[derive(Debug, Clone)]
pub(crate) struct Pbr {
    /// 0 to 1; `None`: that of the exponent.
    pub(crate) roughness: Option<f32>,
    pub(crate) metallic: f32,
    pub(crate) sheen: f32,
    pub(crate) coat: f32,
    pub(crate) coat_roughness: f32,
    /// Roughness in green, metalness in blue.
    pub(crate) map: Option<Map>,
    pub(crate) sheen_map: Option<Map>,
    pub(crate) coat_map: Option<Map>,
    pub(crate) coat_roughness_map: Option<Map>,
}

/// Content of a map of normal detail.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ReliefKind {
    /// Heights; white over black in units of the model (`-bm`).
    Bump(f32),
    /// Normals in tangent space, green up.
    Normals,
}

/// A texture and the options of its MTL line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Map {
    pub(crate) texture: usize,
    pub(crate) transform: UvTransform,
    pub(crate) clamp: bool,
}
