//! Reports on files: meshes, maps, ranges of coordinates, and missing files.

use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};
use texmap_scene::{Mesh, Scene};
use texmap_uv::TJunctions;

use crate::files::is_called;
use crate::framing::Bounds;
use crate::scene::{self, LoadOptions};
use crate::textures::Textures;
use crate::{FileSource, IoError, image_io};

/// A file in figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FileInfo {
    /// The file; in JSON with U+FFFD for bytes that are no Unicode.
    #[serde(serialize_with = "lossy")]
    pub file: PathBuf,
    /// `scene`, `obj`, `gltf`, `ply`, `stl` or `image`.
    pub kind: &'static str,
    /// In the order of drawing.
    pub meshes: Vec<MeshInfo>,
    /// Images that it is or names, and models and libraries that it names in vain.
    pub files: Vec<NamedFile>,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Cameras that may be chosen, numbered from 0.
    pub cameras: Vec<CameraInfo>,
    /// Animations, numbered from 0.
    pub animations: Vec<AnimationInfo>,
    /// Extensions that a glTF names, and their treatment.
    pub extensions: Vec<ExtensionInfo>,
    /// Number of lights; a model by itself has none, but for those of a glTF.
    pub lights: usize,
    /// Centre and radius of a sphere around all meshes, world units.
    pub sphere: Option<([f64; 3], f64)>,
    /// Vertices that lie inside an edge of a face that does not have them, over all meshes together: pixels may be
    /// missing along such edges.
    pub t_joints: usize,
    /// Too many vertices lie along too many edges to find them all: there may be more T-junctions.
    pub t_joints_at_least: bool,
    /// Warnings that a picture of the file would give.
    pub warnings: Vec<String>,
}

impl FileInfo {
    /// The named files that cannot be used.
    pub fn problems(&self) -> impl Iterator<Item = &NamedFile> {
        self.files.iter().filter(|f| f.problem.is_some())
    }
}

/// A mesh in figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MeshInfo {
    /// Object or group, or the line where its faces begin.
    pub name: String,
    /// Vertices, split where coordinates or normals differ.
    pub vertices: usize,
    /// Faces as the file counts them.
    pub faces: usize,
    /// Triangles that are drawn for them.
    pub triangles: usize,
    /// Name of its material.
    pub material: String,
    /// Smallest and largest u and v, the file's own values; of a framed face, at its corners.
    pub uv: Option<[[f32; 2]; 2]>,
}

/// A camera of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct CameraInfo {
    /// Its name or that of its node; may be empty.
    pub name: String,
    /// Its view is parallel.
    pub orthographic: bool,
}

/// An animation of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AnimationInfo {
    /// Its name; may be empty.
    pub name: String,
    /// Time of its last key, seconds.
    pub seconds: f64,
    /// Number of values that it moves.
    pub channels: usize,
}

/// An extension that a glTF file names.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ExtensionInfo {
    /// Its name.
    pub name: String,
    /// The file cannot be read without.
    pub required: bool,
    /// Treatment of the extension, in words.
    pub support: &'static str,
}

/// A file that the scene names.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct NamedFile {
    /// The file as it was looked for; in JSON with U+FFFD for bytes that are no Unicode.
    #[serde(serialize_with = "lossy")]
    pub path: PathBuf,
    /// `file:line:column` of the line that names it first; empty for an image by itself.
    pub named_by: String,
    /// Width and height of an image.
    pub size: Option<[u32; 2]>,
    /// Bits a channel of an image.
    pub bits: Option<u32>,
    /// Reason for which the file cannot be used.
    pub problem: Option<String>,
}

/// Reads a scene, model or image file and everything that it names. Named files that are missing or broken do not
/// stop it; they are listed.
///
/// # Errors
/// As [`crate::load`], for faults of the file itself and of the scene files that it includes.
pub fn info(path: &Path) -> Result<FileInfo, IoError> {
    info_with(path, &LoadOptions::default())
}

/// As [`info`], with options of loading.
///
/// # Errors
/// As [`info`], and [`IoError::OutsideRoot`] for the file itself.
pub fn info_with(path: &Path, options: &LoadOptions) -> Result<FileInfo, IoError> {
    let format = match scene::format(path, &options.files) {
        Ok(format) => format,
        Err(error @ IoError::UnknownFormat { .. }) => return image(path, &options.files, error),
        Err(error) => return Err(error),
    };
    let (scene, contents) = (format.read)(path, options, true)?;
    let t_joints = t_joints(&scene);
    Ok(FileInfo {
        file: path.to_path_buf(),
        kind: format.kind,
        meshes: scene.meshes.iter().map(|m| mesh(m, &scene)).collect(),
        files: contents.files,
        materials: scene.materials.iter().map(|m| m.name.clone()).collect(),
        cameras: contents.cameras,
        animations: contents.animations,
        extensions: contents.extensions,
        lights: contents.lights,
        t_joints: t_joints.count,
        t_joints_at_least: t_joints.at_least,
        sphere: Bounds::of(&scene).map(|b| (b.center.to_array(), b.radius)),
        warnings: scene.warnings,
    })
}

/// Contents of a file beside its scene.
#[derive(Debug, Default)]
pub(crate) struct Contents {
    pub(crate) files: Vec<NamedFile>,
    pub(crate) cameras: Vec<CameraInfo>,
    pub(crate) animations: Vec<AnimationInfo>,
    pub(crate) extensions: Vec<ExtensionInfo>,
    /// Lights of the file; a model without them has others.
    pub(crate) lights: usize,
}

/// The contents of a file whose maps were read by [`Textures`].
pub(crate) fn contents(textures: Textures, lights: usize) -> Contents {
    let files = textures.files.into_iter().map(|f| {
        let (found, problem) = match f.found {
            Ok(found) => (Some(found), None),
            Err(problem) => (None, Some(problem)),
        };
        NamedFile {
            path: f.path,
            named_by: f.location.to_string(),
            size: found.map(|(width, height, _)| [width, height]),
            bits: found.map(|(_, _, bits)| bits),
            problem,
        }
    });
    Contents {
        files: files.collect(),
        lights,
        ..Contents::default()
    }
}

fn lossy<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&path.display())
}

fn mesh(mesh: &Mesh, scene: &Scene) -> MeshInfo {
    let mut faces = mesh.faces.clone();
    faces.dedup();
    let framed = mesh.texture_frame.map(|frame| {
        let uv = |p: &[f32; 3]| frame.uv(p.map(f64::from).into()).as_vec2().to_array();
        mesh.positions.iter().map(uv).collect::<Vec<_>>()
    });
    MeshInfo {
        name: mesh.name.clone(),
        vertices: mesh.positions.len(),
        faces: match faces.len() {
            0 => mesh.triangles.len(),
            faces => faces,
        },
        triangles: mesh.triangles.len(),
        material: scene
            .materials
            .get(mesh.material)
            .map_or_else(String::new, |m| m.name.clone()),
        uv: range(framed.as_deref().unwrap_or(&mesh.uvs)),
    }
}

/// T-junctions of all meshes as one, in world space; none where a vertex is not finite.
fn t_joints(scene: &Scene) -> TJunctions {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let base = positions.len() as u32;
        let world = |p: &[f32; 3]| {
            let moved = mesh
                .world_from_object
                .transform_point3(p.map(f64::from).into());
            moved.as_vec3().to_array()
        };
        positions.extend(mesh.positions.iter().map(world));
        triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + base)));
    }
    let faces = texmap_uv::Faces::from_triangles(&triangles);
    texmap_uv::Mesh::new(&positions, &faces)
        .map_or_else(|_| TJunctions::default(), |m| texmap_uv::t_junctions(&m))
}

fn range(uvs: &[[f32; 2]]) -> Option<[[f32; 2]; 2]> {
    let first = *uvs.first()?;
    Some(uvs.iter().fold([first, first], |[low, high], uv| {
        [
            [low[0].min(uv[0]), low[1].min(uv[1])],
            [high[0].max(uv[0]), high[1].max(uv[1])],
        ]
    }))
}

fn image(path: &Path, files: &FileSource, unknown: IoError) -> Result<FileInfo, IoError> {
    if !image_io::ENDINGS
        .iter()
        .any(|ending| is_called(path, ending))
    {
        return Err(unknown);
    }
    let image = image_io::read_named(files, path, None)?;
    let file = NamedFile {
        path: path.to_path_buf(),
        named_by: String::new(),
        size: Some(image.size.into()),
        bits: Some(image.texels.bits()),
        problem: None,
    };
    Ok(FileInfo {
        file: path.to_path_buf(),
        kind: "image",
        meshes: Vec::new(),
        files: vec![file],
        materials: Vec::new(),
        cameras: Vec::new(),
        animations: Vec::new(),
        extensions: Vec::new(),
        lights: 0,
        sphere: None,
        t_joints: 0,
        t_joints_at_least: false,
        warnings: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn missing_and_broken_files_are_listed_and_do_not_stop() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        image_io::write_png(&at("a.png"), 2, 3, &[255; 24]).unwrap();
        fs::write(at("broken.png"), b"not a picture").unwrap();
        fs::write(
            at("m.obj"),
            "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n",
        )
        .unwrap();
        fs::write(
            at("s.scene"),
            "la 1 1 1\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ntexture a.png\ntf 0 -1 0 1 2 0 2 2 3 3 0 1\n\
             texture gone.png\ntexture broken.png\nobj gone.obj\nobj m.obj\n",
        )
        .unwrap();
        let info = info(&at("s.scene")).unwrap();
        assert_eq!((info.kind, info.lights, info.meshes.len()), ("scene", 1, 2));
        assert_eq!(info.t_joints, 0);
        let first = &info.meshes[0];
        assert_eq!((first.vertices, first.faces, first.triangles), (4, 1, 2));
        assert_eq!(first.uv, Some([[-1.0, 0.0], [2.0, 3.0]]));
        let found: Vec<_> = info
            .files
            .iter()
            .map(|f| (f.path.file_name().unwrap().to_str().unwrap(), f.size))
            .collect();
        assert_eq!(
            found,
            [
                ("a.png", Some([2, 3])),
                ("gone.png", None),
                ("broken.png", None),
                ("gone.obj", None),
                ("gone.mtl", None)
            ]
        );
        assert_eq!(info.problems().count(), 4);
        assert!(info.files[1].named_by.ends_with("s.scene:8:1"));
    }

    #[test]
    fn images_and_unknown_kinds() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        image_io::write_png(&path, 2, 3, &[255; 24]).unwrap();
        assert_eq!(info(&path).unwrap().files[0].size, Some([2, 3]));
        fs::write(dir.path().join("a.txt"), "eye").unwrap();
        assert_eq!(
            info(&dir.path().join("a.txt")).unwrap_err().code(),
            "unknown-format"
        );
        assert_eq!(
            info(&dir.path().join("no.txt")).unwrap_err().code(),
            "file-missing"
        );
    }
}
