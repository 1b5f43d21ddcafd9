//! Texture coordinates of meshes of triangles.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use texmap_math::glam::DVec3;
use texmap_math::{Level, MemoryBudget};
use texmap_raster::{Atlas, AtlasMesh, AtlasOptions, TargetSize};
use texmap_uv::{
    AtlasSize, Faces, Mapping, Mesh, Origin, ProjectionSource, ReportOptions, SeamEdges, Shape,
    UvSet,
};

use crate::support::{Threads, go_on, interruptible, unlocked, value};

type F32s<'py> = PyReadonlyArray1<'py, f32>;
type U32s<'py> = PyReadonlyArray1<'py, u32>;

/// A new flat array.
type Flat<'py, T> = Bound<'py, PyArray1<T>>;

fn origin(bottom_up: bool) -> Origin {
    match bottom_up {
        true => Origin::BottomLeft,
        false => Origin::TopLeft,
    }
}

fn points<'a>(array: &'a F32s<'_>) -> PyResult<&'a [[f32; 3]]> {
    Ok(array.as_slice()?.as_chunks::<3>().0)
}

fn faces(array: &U32s<'_>) -> PyResult<Faces> {
    Ok(Faces::from_triangles(array.as_slice()?.as_chunks::<3>().0))
}

/// A set with one coordinate a vertex.
fn per_vertex(uvs: &F32s<'_>, faces: &Faces) -> PyResult<UvSet> {
    Ok(UvSet {
        uvs: uvs.as_slice()?.as_chunks::<2>().0.to_vec(),
        corners: faces.corners().to_vec(),
    })
}

/// Vertices split where their coordinates differ: (vertex of the mesh, faces, uvs).
type Split<'py> = (Flat<'py, u32>, Flat<'py, u32>, Flat<'py, f32>);

fn split<'py>(py: Python<'py>, mesh: &Mesh<'_>, set: &UvSet) -> PyResult<Split<'py>> {
    let buffer = set.split(mesh, &[]).map_err(value)?;
    Ok((
        PyArray1::from_vec(py, buffer.positions),
        PyArray1::from_slice(py, buffer.indices.as_flattened()),
        PyArray1::from_slice(py, buffer.uvs.as_flattened()),
    ))
}

/// Unwraps into islands without overlaps.
#[pyfunction]
#[pyo3(signature = (positions, triangles, size, gutter, bottom_up, seams, seam_angle, threads))]
pub(crate) fn unwrap<'py>(
    py: Python<'py>,
    positions: F32s<'py>,
    triangles: U32s<'py>,
    size: u32,
    gutter: u32,
    bottom_up: bool,
    seams: Vec<[u32; 2]>,
    seam_angle: Option<f64>,
    threads: Option<Threads>,
) -> PyResult<Split<'py>> {
    let (points, faces) = (points(&positions)?, faces(&triangles)?);
    let mesh = Mesh::new(points, &faces).map_err(value)?;
    let atlas = AtlasSize { size, gutter };
    let cuts = SeamEdges {
        pairs: &seams,
        angle: seam_angle,
    };
    let set = interruptible(py, threads, |stop| {
        let go_on = go_on(stop);
        let progress = |done, of: Option<usize>| go_on(done, of.unwrap_or(done));
        texmap_uv::unwrap(&mesh, &cuts, atlas, origin(bottom_up), &progress)
    })?
    .map_err(value)?;
    split(py, &mesh, &set)
}

/// Maps by a shape: the split vertices, and the faces around its axis.
#[pyfunction]
#[pyo3(signature = (positions, triangles, normals, shape, by, eye, repeat, fix_seams, bottom_up, simd))]
pub(crate) fn uv_map<'py>(
    py: Python<'py>,
    positions: F32s<'py>,
    triangles: U32s<'py>,
    normals: Option<F32s<'py>>,
    shape: &str,
    by: &str,
    eye: [f64; 3],
    repeat: [f64; 2],
    fix_seams: bool,
    bottom_up: bool,
    simd: Option<&str>,
) -> PyResult<(Split<'py>, Flat<'py, u32>)> {
    let shape = match shape {
        "plane" => Shape::Plane,
        "cylinder" => Shape::Cylinder,
        "cone" => Shape::Cone,
        "sphere" => Shape::Sphere,
        "box" => Shape::Box,
        other => {
            return Err(value(format!(
                "shape={other:?}: know plane, cylinder, cone, sphere, box"
            )));
        }
    };
    let by = match by {
        "position" => ProjectionSource::Position,
        "normal" => ProjectionSource::Normal,
        "centroid" => ProjectionSource::Centroid,
        "reflection" => ProjectionSource::Reflection {
            eye: DVec3::from(eye),
        },
        other => {
            return Err(value(format!(
                "by={other:?}: know position, normal, centroid, reflection"
            )));
        }
    };
    let mapping = Mapping {
        by,
        repeat,
        fix_seams,
        origin: origin(bottom_up),
        ..Mapping::new(shape)
    };
    let level: Level = crate::support::level(simd)?;
    let (points, faces) = (points(&positions)?, faces(&triangles)?);
    let normals = match &normals {
        Some(array) => array.as_slice()?.as_chunks::<3>().0,
        None => &[],
    };
    let mesh = Mesh::new(points, &faces).map_err(value)?;
    let mapped = unlocked(py, None, || mapping.map(level, &mesh, normals))?.map_err(value)?;
    let axis = PyArray1::from_vec(py, mapped.around_axis);
    Ok((split(py, &mesh, &mapped.set)?, axis))
}

/// Figures of the coordinates of a mesh, and arrays with one value a triangle.
#[pyfunction]
pub(crate) fn uv_report<'py>(
    py: Python<'py>,
    positions: F32s<'py>,
    triangles: U32s<'py>,
    uvs: F32s<'py>,
    texture_size: u32,
    views: bool,
    bottom_up: bool,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let (points, faces) = (points(&positions)?, faces(&triangles)?);
    let mesh = Mesh::new(points, &faces).map_err(value)?;
    let set = per_vertex(&uvs, &faces)?;
    let options = ReportOptions {
        origin: origin(bottom_up),
        texture_size,
        views,
    };
    let r = unlocked(py, None, || texmap_uv::report(&mesh, &set, &options))?.map_err(value)?;
    let all = PyDict::new(py);
    all.set_item("faces", r.faces)?;
    all.set_item("stretch_l2", r.stretch_l2)?;
    all.set_item("stretch_linf", r.stretch_linf)?;
    all.set_item("angle_mean", r.angle_mean)?;
    all.set_item("angle_max", r.angle_max)?;
    all.set_item("area_mean", r.area_mean)?;
    all.set_item("area_max", r.area_max)?;
    all.set_item("texels_per_unit", r.density)?;
    all.set_item("flipped", r.flipped)?;
    all.set_item("collapsed", r.collapsed)?;
    all.set_item("outside", r.outside)?;
    all.set_item("torn", r.wide)?;
    all.set_item("overlapping", r.overlapping)?;
    all.set_item("overlap_area", r.overlap_area)?;
    all.set_item("picture_area", r.picture_area)?;
    all.set_item("surface_area", r.surface_area)?;
    all.set_item("islands", r.islands)?;
    all.set_item("seam_length", r.seam_length)?;
    all.set_item("seam_seen", r.seam_seen)?;
    all.set_item("rim_length", r.rim_length)?;
    all.set_item("non_manifold_edges", r.non_manifold_edges)?;
    all.set_item("degenerate", r.degenerate)?;
    all.set_item("t_junctions", r.t_junctions.count)?;
    let each = PyDict::new(py);
    let numbers = |of: &dyn Fn(&texmap_uv::TriangleReport) -> f32| {
        PyArray1::from_vec(py, r.triangles.iter().map(of).collect())
    };
    let flags = |of: &dyn Fn(&texmap_uv::TriangleReport) -> bool| {
        PyArray1::from_vec(py, r.triangles.iter().map(of).collect())
    };
    each.set_item("stretch_l2", numbers(&|t| t.l2))?;
    each.set_item("stretch_linf", numbers(&|t| t.linf))?;
    each.set_item("angle", numbers(&|t| t.angle))?;
    each.set_item("area", numbers(&|t| t.area))?;
    each.set_item("texels_per_unit", numbers(&|t| t.density))?;
    each.set_item("flipped", flags(&|t| t.flipped))?;
    each.set_item("collapsed", flags(&|t| t.collapsed))?;
    each.set_item("overlapping", flags(&|t| t.overlapping))?;
    each.set_item("outside", flags(&|t| t.outside))?;
    Ok((all, each))
}

/// MikkTSpace tangents, four numbers a corner of the triangles.
#[pyfunction]
pub(crate) fn tangents<'py>(
    py: Python<'py>,
    positions: F32s<'py>,
    triangles: U32s<'py>,
    uvs: F32s<'py>,
    normals: Option<F32s<'py>>,
) -> PyResult<Flat<'py, f32>> {
    let (points, faces) = (points(&positions)?, faces(&triangles)?);
    let mesh = Mesh::new(points, &faces).map_err(value)?;
    let set = per_vertex(&uvs, &faces)?;
    let normals = match &normals {
        Some(array) => array.as_slice()?.as_chunks::<3>().0.to_vec(),
        None => mesh.smooth_normals(),
    };
    if normals.len() != points.len() {
        return Err(value(format!(
            "normals: {} for {} vertices",
            normals.len(),
            points.len()
        )));
    }
    let corners: Vec<[f32; 3]> = faces
        .corners()
        .iter()
        .map(|i| normals[*i as usize])
        .collect();
    let found = unlocked(py, None, || texmap_uv::tangents(&mesh, &set, &corners))?;
    Ok(PyArray1::from_slice(
        py,
        found.map_err(value)?.as_flattened(),
    ))
}

/// A mesh drawn into its texture space: a dictionary of flat arrays.
#[pyfunction]
#[pyo3(signature = (uvs, triangles, positions, normals, size, conservative, gutter, bottom_up, threads))]
pub(crate) fn uv_raster<'py>(
    py: Python<'py>,
    uvs: F32s<'py>,
    triangles: U32s<'py>,
    positions: Option<F32s<'py>>,
    normals: Option<F32s<'py>>,
    size: (u32, u32),
    conservative: bool,
    gutter: u32,
    bottom_up: bool,
    threads: Option<Threads>,
) -> PyResult<Bound<'py, PyDict>> {
    fn optional<'a>(array: &'a Option<F32s<'_>>) -> PyResult<&'a [[f32; 3]]> {
        match array {
            Some(array) => points(array),
            None => Ok(&[]),
        }
    }
    let mesh = AtlasMesh {
        uvs: uvs.as_slice()?.as_chunks::<2>().0,
        positions: optional(&positions)?,
        normals: optional(&normals)?,
        indices: triangles.as_slice()?.as_chunks::<3>().0,
        bottom_up,
    };
    let size = TargetSize::new(size.0, size.1).map_err(value)?;
    let atlas = interruptible(py, threads, |stop| {
        let options = AtlasOptions {
            conservative,
            gutter,
            threads: rayon::current_num_threads(),
            memory: MemoryBudget::of_process(),
        };
        Atlas::with_progress(size, &mesh, options, &go_on(stop))
    })?
    .map_err(value)?;
    let out = PyDict::new(py);
    out.set_item("face", PyArray1::from_vec(py, atlas.face))?;
    out.set_item(
        "barycentric",
        PyArray1::from_slice(py, atlas.barycentric.as_flattened()),
    )?;
    let coverage = atlas.coverage.iter().map(|c| *c as u8).collect();
    out.set_item("coverage", PyArray1::from_vec(py, coverage))?;
    if !atlas.position.is_empty() {
        out.set_item(
            "position",
            PyArray1::from_slice(py, atlas.position.as_flattened()),
        )?;
    }
    if !atlas.normal.is_empty() {
        out.set_item(
            "normal",
            PyArray1::from_slice(py, atlas.normal.as_flattened()),
        )?;
    }
    out.set_item("lost", PyArray1::from_vec(py, atlas.lost))?;
    Ok(out)
}
