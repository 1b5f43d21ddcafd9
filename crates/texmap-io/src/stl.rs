//! Stereolithography files (STL), ASCII and binary: flat triangles.
//!
//! Source of the format: 3D Systems, "StereoLithography Interface Specification" (1989).

use std::path::Path;

use memchr::memchr_iter;
use texmap_math::glam::DVec3;
use texmap_math::parallel;

use crate::models::Request;
use crate::obj::{Model, Part, UNNAMED, unit};
use crate::textures::Textures;
use crate::{IoError, SourceLocation, shortened, shown};

/// Bytes before the triangles of a binary file, with their number.
const HEAD: usize = 84;

/// Bytes of a triangle: a normal, three corners and two bytes more.
const TRIANGLE: usize = 50;

/// Reads a model; gives the number of its bytes.
pub(crate) fn read(
    request: &Request<'_>,
    textures: &mut Textures,
) -> Result<(Model, usize), IoError> {
    let (path, named_by) = (request.path, request.named_by);
    let bytes = textures.bytes(path, named_by)?;
    let length = bytes.len();
    // Corners and normals of three vertices, triangle and face take 88 bytes; triangles of words have 60 bytes or more.
    let what = format_args!("what the {length} bytes of {} say", path.display());
    textures
        .source
        .ask(2 * length as u64, what, "split the file", named_by)?;
    let binary_file = is_binary(&bytes);
    let corners = match binary_file {
        true => binary(path, &bytes)?,
        false => ascii(path, &bytes)?,
    };
    drop(bytes);
    if corners.is_empty() {
        return Err(IoError::EmptyMesh {
            path: path.to_path_buf(),
            named_by: named_by.cloned(),
        });
    }
    let count = corners.len() as u32 / 3;
    // Normals of the file are often wrong or zero; the order of the corners gives them too.
    let triangles = corners.as_chunks::<3>().0;
    let normals = parallel::list(triangles.len(), [[0.0; 3]; 3], |i| {
        let [a, b, c] = triangles[i].map(|p| DVec3::from(p.map(f64::from)));
        let normal = unit((b - a).cross(c - a)).unwrap_or(DVec3::Z);
        [normal.as_vec3().to_array(); 3]
    });
    let part = Part {
        name: UNNAMED.to_owned(),
        normals: normals.into_flattened(),
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        faces: (0..count).collect(),
        positions: corners,
        ..Part::default()
    };
    let mut model = Model {
        parts: vec![part],
        ..Model::default()
    };
    let rest = length.saturating_sub(HEAD + TRIANGLE * count as usize);
    if binary_file && rest > 0 {
        model.warnings.push(format!(
            "{}: {rest} bytes after the {count} triangles that it states are not read",
            shown(path)
        ));
    }
    if request.textured {
        project(&mut model.parts[0]);
    }
    Ok((model, length))
}

/// Gives a part coordinates of a box around it.
fn project(part: &mut Part) {
    use texmap_uv::{Origin, Projection, project};
    part.uvs = project(
        &part.positions,
        &part.normals,
        Projection::Box,
        Origin::BottomLeft,
    );
}

/// True if a file is binary. It has the length that its number of triangles demands, or is no text. Binary files may begin with
/// `solid`, as text does.
fn is_binary(bytes: &[u8]) -> bool {
    let said = stated(bytes).map(|count| HEAD as u64 + TRIANGLE as u64 * u64::from(count));
    if said == Some(bytes.len() as u64) {
        return true;
    }
    let start = bytes.trim_ascii_start();
    let text = start
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    !text || bytes.iter().take(1000).any(|b| *b == 0)
}

/// The number of triangles that a binary file states.
fn stated(bytes: &[u8]) -> Option<u32> {
    bytes
        .get(HEAD - 4..)?
        .first_chunk()
        .copied()
        .map(u32::from_le_bytes)
}

/// The corners of a binary file.
fn binary(path: &Path, bytes: &[u8]) -> Result<Vec<[f32; 3]>, IoError> {
    let broken = |problem: String| IoError::BrokenModel {
        path: path.to_path_buf(),
        problem,
    };
    let Some(count) = stated(bytes) else {
        return Err(broken(
            "neither text that begins with `solid` nor a binary STL, which has 84 bytes or more"
                .into(),
        ));
    };
    let body = &bytes[HEAD..];
    let (count, whole) = (count as usize, body.len() / TRIANGLE);
    if whole < count {
        return Err(broken(format!(
            "the file ends within triangle {whole} of {count} (byte {})",
            HEAD + whole * TRIANGLE
        )));
    }
    let corner = |triangle: &[u8], corner: usize| {
        let mut xyz = [0.0; 3];
        let values = triangle[12 + 12 * corner..].as_chunks::<4>().0;
        for (x, bytes) in xyz.iter_mut().zip(values) {
            *x = f32::from_le_bytes(*bytes);
        }
        xyz
    };
    let corners = parallel::list(count, [[0.0; 3]; 3], |t| {
        let triangle = &body[TRIANGLE * t..][..TRIANGLE];
        [0, 1, 2].map(|i| corner(triangle, i))
    });
    let corners = corners.into_flattened();
    match corners
        .iter()
        .position(|p| !p.iter().all(|x| x.is_finite()))
    {
        None => Ok(corners),
        Some(bad) => Err(broken(format!(
            "triangle {} (byte {}) has a corner that is not finite",
            bad / 3,
            HEAD + bad / 3 * TRIANGLE
        ))),
    }
}

/// The corners of a text: the numbers after each `vertex`, three in each `facet`.
fn ascii(path: &Path, text: &[u8]) -> Result<Vec<[f32; 3]>, IoError> {
    let mut corners = Vec::new();
    // Corners of the facet that is open.
    let mut open: Option<usize> = None;
    let mut start = 0;
    for (end, line) in memchr_iter(b'\n', text).chain([text.len()]).zip(1..) {
        let content = &text[start..end];
        start = end + 1;
        let column = content.len() - content.trim_ascii_start().len() + 1;
        let broken = |problem: String| IoError::BrokenModelLine {
            location: SourceLocation::new(path, line, column as u32),
            problem,
        };
        let mut words = content
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        let word = words.next().unwrap_or(b"").to_ascii_lowercase();
        match (&word[..], open) {
            (b"solid" | b"endsolid" | b"", None) | (b"outer" | b"endloop" | b"", Some(_)) => {}
            (b"facet", None) => open = Some(0),
            (b"vertex", Some(count)) => {
                let mut xyz = [f32::NAN; 3];
                for x in &mut xyz {
                    let word = words.next().unwrap_or(b"");
                    *x = fast_float2::parse::<f32, _>(word).unwrap_or(f32::NAN);
                }
                if !xyz.iter().all(|x| x.is_finite()) || words.next().is_some() {
                    return Err(broken("`vertex` takes three finite numbers".into()));
                }
                corners.push(xyz);
                open = Some(count + 1);
            }
            (b"endfacet", Some(3)) => open = None,
            (b"endfacet", Some(count)) => {
                return Err(broken(format!("a facet of {count} corners, which needs 3")));
            }
            _ => {
                let word = String::from_utf8_lossy(&word).into_owned();
                return Err(broken(format!(
                    "`{}` has no place here in an ASCII STL file",
                    shortened(&word)
                )));
            }
        }
    }
    match open {
        None => Ok(corners),
        Some(_) => Err(IoError::BrokenModel {
            path: path.to_path_buf(),
            problem: "the file ends within a facet".into(),
        }),
    }
}
