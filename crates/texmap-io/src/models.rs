//! Models by the endings of their names.

use std::path::Path;

use crate::files::is_called;
use crate::obj::{Model, ObjText};
use crate::scene_file::Missing;
use crate::textures::Textures;
use crate::{FileSource, IoError, SourceLocation, obj, ply, stl};

/// A model that a line or a user asks for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Request<'a> {
    pub(crate) path: &'a Path,
    pub(crate) named_by: Option<&'a SourceLocation>,
    /// Treatment of an absent library, material or map.
    pub(crate) missing: Missing,
    /// True if faces without a material will get a texture and so need coordinates.
    pub(crate) textured: bool,
}

/// Reads a model with the files that it names; gives the number of bytes of its own file.
type Reader = fn(&Request<'_>, &mut Textures) -> Result<(Model, usize), IoError>;

/// The reader for each ending.
const READERS: [(&str, Reader); 3] = [("obj", obj::read), ("ply", ply::read), ("stl", stl::read)];

/// Reads a model with the files that it names; a file with an unknown ending is taken for an OBJ.
pub(crate) fn read(request: &Request<'_>, textures: &mut Textures) -> Result<Model, IoError> {
    let Request { path, named_by, .. } = *request;
    let key = (path.to_path_buf(), request.missing, request.textured);
    if let Some((known, bytes)) = textures.models.get(&key) {
        let (model, bytes) = (known.clone(), *bytes);
        textures.read_again(path, named_by, "obj", bytes)?;
        return Ok(model);
    }
    let again = textures.was_read(path);
    let reader = READERS.iter().find(|(ending, _)| is_called(path, ending));
    let reader = reader.map_or(obj::read as Reader, |(_, reader)| *reader);
    // On a thread of the pool: each of a reader's parallel loops, of which every mesh has some, would wake and await it from outside.
    let (model, bytes) = texmap_math::parallel::within(|| reader(request, textures))?;
    if again {
        // It will be named a third time; its warnings were reported.
        let silent = Model {
            warnings: Vec::new(),
            ..model.clone()
        };
        textures.models.insert(key, (silent, bytes));
    }
    Ok(model)
}

/// A mesh whose texture coordinates are to be changed: an OBJ as it is, a PLY or STL as the text of an OBJ without materials, in which
/// equal positions are one vertex. A file with an unknown ending is taken for an OBJ.
///
/// ```
/// use std::path::Path;
/// use texmap_io::{FileSource, obj_text};
///
/// let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
/// let file = format!("solid a\n{facet}{facet}endsolid a\n");
/// let files = FileSource::in_memory([("a.stl".into(), file.into())]);
/// let mesh = obj_text(Path::new("a.stl"), &files)?;
/// assert_eq!((mesh.positions().len(), mesh.faces().len()), (3, 2));
/// # Ok::<(), texmap_io::IoError>(())
/// ```
///
/// # Errors
/// As [`ObjText::read`], those of the format, and [`IoError::UnknownFormat`] for glTF and scenes.
pub fn obj_text(path: &Path, files: &FileSource) -> Result<ObjText, IoError> {
    let is = |ending: &str| is_called(path, ending);
    if is("gltf") || is("glb") || is("scene") {
        return Err(IoError::UnknownFormat {
            path: path.to_path_buf(),
        });
    }
    if !(is("ply") || is("stl")) {
        return ObjText::read(path, files);
    }
    let mut textures = Textures::new(files.clone(), true, true);
    let request = Request {
        path,
        named_by: None,
        missing: Missing::Grey,
        textured: false,
    };
    let model = read(&request, &mut textures)?;
    // The normals of an STL are those of its facets.
    ObjText::of_model(path, &model, is("ply"), files)
}
