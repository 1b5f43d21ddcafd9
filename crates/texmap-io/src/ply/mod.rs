//! Polygon files (PLY): ASCII and binary in both orders.

mod ascii;
mod header;
mod records;
mod surface;
mod values;

use std::path::Path;

use header::{Element, Encoding, Header};
use records::Records;
use surface::{Fault, Points, Polygons};

use crate::models::Request;
use crate::obj::{self, Description, Group, Model, Part};
use crate::textures::Textures;
use crate::{IoError, SourceLocation, shortened, shown};

/// Reads a model and the textures that its comments name; gives the number of its bytes.
pub(crate) fn read(
    request: &Request<'_>,
    textures: &mut Textures,
) -> Result<(Model, usize), IoError> {
    let (path, named_by) = (request.path, request.named_by);
    let bytes = textures.bytes(path, named_by)?;
    let length = bytes.len();
    let header = header::parse(path, &bytes)?;
    refuse_points(request, &header)?;
    // The words of an ASCII body become bytes, and both become a surface.
    let what = format_args!("what the {length} bytes of {} say", path.display());
    textures
        .source
        .ask(4 * length as u64, what, "split the file", named_by)?;
    let (points, polygons) = surface(path, bytes, &header)?;
    if polygons.len() == 0 {
        return Err(IoError::EmptyMesh {
            path: path.to_path_buf(),
            named_by: named_by.cloned(),
        });
    }
    let corners = (polygons.corners.len() as u64) * 60;
    let what = format_args!("the {} faces of {}", polygons.len(), path.display());
    textures
        .source
        .ask(corners, what, "split the file", named_by)?;
    let mut warnings = left_out(path, &header);
    warnings.extend(obj::broken_normals(path, points.broken_normals));
    let mut materials = Vec::new();
    let mut descriptions: Vec<Description> = header
        .textures
        .iter()
        .zip(0..)
        .map(|((location, name), i)| {
            Description::of_texture(&format!("texture {i}"), location.clone(), name)
        })
        .collect();
    let colored = !points.colors.is_empty();
    let parts = parts(request, points, polygons, &descriptions, &mut warnings)?;
    obj::decode_maps(&mut descriptions, textures, &mut warnings);
    for description in descriptions {
        materials.push(obj::material(
            description,
            request.missing,
            textures,
            &mut warnings,
        )?);
    }
    let model = Model {
        parts,
        materials,
        colored,
        warnings,
    };
    Ok((model, length))
}

/// The parts of a model: one, or one for each texture.
fn parts(
    request: &Request<'_>,
    points: Points,
    polygons: Polygons,
    descriptions: &[Description],
    warnings: &mut Vec<String>,
) -> Result<Vec<Part>, IoError> {
    let path = request.path;
    let needs_uv = request.textured || !descriptions.is_empty();
    let simple = !points.partial
        && polygons.sizes.is_empty()
        && polygons.uvs.is_empty()
        && polygons.textures.is_empty()
        && points.normals.iter().all(|n| *n != [0.0; 3])
        && !(needs_uv && points.uvs.is_empty());
    if simple {
        return Ok(vec![Part {
            name: obj::UNNAMED.to_owned(),
            material: (!descriptions.is_empty()).then_some(0),
            triangles: polygons.corners.as_chunks().0.to_vec(),
            faces: (0..polygons.len() as u32).collect(),
            positions: points.positions,
            normals: points.normals,
            uvs: points.uvs,
            colors: points.colors,
            projected: None,
            uncut: None,
        }]);
    }
    let used = polygons
        .textures
        .iter()
        .max()
        .map_or(0, |last| *last as usize);
    if used > 0 && used >= descriptions.len() {
        let count = descriptions.len();
        return Err(broken(
            path,
            format!("a face names texture {used}; there are {count}, from 0"),
        ));
    }
    let mut sorted = polygons.textures.clone();
    sorted.sort_unstable();
    let (mut obj, numbers) = polygons.into_obj(points);
    if !descriptions.is_empty() {
        let textures = if sorted.is_empty() {
            vec![0]
        } else {
            sorted.clone()
        };
        let mut last = None;
        for (first_face, texture) in textures.into_iter().enumerate() {
            if last.replace(texture) != Some(texture) {
                let location = SourceLocation::new(path, 1, 1);
                obj.materials.push((location, format!("texture {texture}")));
                obj.groups.push(Group {
                    first_face,
                    name: None,
                });
            }
        }
    }
    let mut parts = obj::parts(&obj, descriptions, request.textured);
    for part in &mut parts {
        for face in &mut part.faces {
            *face = numbers[*face as usize];
        }
        if let Some((count, _)) = part.projected {
            warnings.push(format!(
                "{}: {count} faces without texture coordinates; box projection stands in",
                shown(path)
            ));
        }
        if let Some((corners, _)) = part.uncut {
            warnings.push(format!("{}: {}", shown(path), obj::drawn_as_fan(corners)));
        }
    }
    Ok(parts)
}

fn broken(path: &Path, problem: String) -> IoError {
    IoError::BrokenModel {
        path: path.to_path_buf(),
        problem,
    }
}

/// Refuses a file of points alone.
fn refuse_points(request: &Request<'_>, header: &Header) -> Result<(), IoError> {
    let count = |name: &str| {
        let element = header.elements.iter().find(|e| e.name == name);
        element.map_or(0, |element| element.count)
    };
    let (points, faces) = (count("vertex"), count("face") + count("tristrips"));
    if points == 0 || faces > 0 {
        return Ok(());
    }
    let splats = |e: &Element| e.properties.iter().any(|p| p.name == "f_dc_0");
    Err(IoError::PointCloud {
        path: request.path.to_path_buf(),
        named_by: request.named_by.cloned(),
        points,
        kind: match header.elements.iter().any(splats) {
            true => "Gaussian splats",
            false => "points",
        },
    })
}

/// Warnings of elements and properties that would change a picture and are not drawn.
fn left_out(path: &Path, header: &Header) -> Vec<String> {
    let mut warnings = Vec::new();
    for element in header.elements.iter().filter(|element| element.count > 0) {
        let has = |name: &str| element.properties.iter().any(|p| p.name == name);
        let what = match element.name.as_str() {
            "vertex" => continue,
            "face" if has("red") => format!("the colours of {} faces", element.count),
            "face" | "tristrips" => continue,
            name => format!("{} records of `{}`", element.count, shortened(name)),
        };
        warnings.push(format!("{}: {what} are not drawn", shown(path)));
    }
    warnings
}

/// The surface that the elements of a file are.
fn surface(path: &Path, bytes: Vec<u8>, header: &Header) -> Result<(Points, Polygons), IoError> {
    let ascii = match header.encoding {
        Encoding::Ascii => Some(ascii::body(path, &bytes, header)?),
        _ => None,
    };
    let body = ascii
        .as_ref()
        .map_or(&bytes[header.end..], |ascii| &ascii.bytes);
    let fault = |element: usize, record: usize, start: usize, problem: &str| {
        let name = shortened(&header.elements[element].name);
        match &ascii {
            None => {
                let byte = header.end + start;
                broken(path, format!("{name} {record} (byte {byte}) {problem}"))
            }
            Some(ascii) => {
                let at = ascii.places[element]
                    .get(record)
                    .map_or(bytes.len(), |at| *at as usize);
                ascii::fault(path, &bytes, at, format!("{name} {record} {problem}"))
            }
        }
    };
    let big = header.encoding == Encoding::BigEndian;
    let mut elements: Vec<Records<'_>> = Vec::new();
    for (number, element) in header.elements.iter().enumerate() {
        let first = elements.last().map_or(0, |records| records.end);
        let found = Records::find(body, big, element, first);
        elements
            .push(found.map_err(|(record, start, problem)| fault(number, record, start, problem))?);
    }
    let of = |name: &str| {
        let found = elements
            .iter()
            .zip(0..)
            .find(|(records, _)| records.element.name == name);
        found.filter(|(records, _)| records.element.count > 0)
    };
    let faulty = |element: usize| {
        let elements = &elements;
        move |Fault { record, problem }: Fault| {
            fault(element, record, elements[element].start(record), &problem)
        }
    };
    let points = match of("vertex") {
        Some((vertices, number)) => Points::of(vertices).map_err(faulty(number))?,
        None => Points::default(),
    };
    let vertices = points.positions.len();
    let polygons = match (of("face"), of("tristrips")) {
        (Some((faces, number)), _) => Polygons::of(faces, vertices).map_err(faulty(number))?,
        (None, Some((strips, number))) => {
            Polygons::of_strips(strips, vertices).map_err(faulty(number))?
        }
        (None, None) => Polygons::default(),
    };
    if let Some((_, number)) = of("vertex") {
        points.check(&polygons).map_err(faulty(number))?;
    }
    Ok((points, polygons))
}
