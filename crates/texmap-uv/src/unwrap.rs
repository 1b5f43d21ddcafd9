//! Unwrapping of a whole mesh by the crate uvunwrap (region growing, LSCM with ARAP, packing by shape).

use alloc::string::ToString;
use alloc::vec::Vec;
use core::ops::ControlFlow;

use crate::islands::Islands;
use crate::mesh::Mesh;
use crate::pack::AtlasSize;
use crate::seam_edges::SeamEdges;
use crate::topology::Topology;
use crate::uv_set::UvSet;
use crate::{Origin, UvError};

/// Most corners of a face, and most triangles around a vertex. The unwrapper compares all triangles of a fan with one another,
/// and the time for one of these many is a few seconds.
const AROUND: usize = 2048;

/// Largest edge of an atlas in texels: the unwrapper takes at most 2^30 of them.
const LARGEST: u32 = 1 << 15;

/// Unwraps the mesh into islands in one atlas, without overlaps and inside [0, 1]. `cuts` are required seams, and the
/// polygons of the mesh stay whole. The same bytes on every platform and thread count.
///
/// Half of the gutter, rounded up, is kept around every island.
///
/// An island that winds around itself, such as a helicoid, takes time in the square of its faces (4,000 quads: 95 s), unless
/// `cuts` part its turns.
///
/// `progress` hears after each step how many of how many (if known) are done in the present stage: islands are found, flattened,
/// packed and written. It may be called from any thread, and ends the work by [`ControlFlow::Break`].
///
/// # Errors
/// [`UvError::Cancelled`] after a break; a cut that is no edge, a face of more than 2048 corners, more than 2048 triangles around a
/// vertex, an atlas of more than 32,768 texels a side, or of no more than its gutters, or whatever the unwrapper says.
pub fn unwrap(
    mesh: &Mesh<'_>,
    cuts: &SeamEdges<'_>,
    atlas_size: AtlasSize,
    origin: Origin,
    progress: &(dyn Fn(usize, Option<usize>) -> ControlFlow<()> + Sync),
) -> Result<UvSet, UvError> {
    let topology = Topology::new(mesh);
    check(mesh, &topology, atlas_size)?;
    let marks = cuts.marks(mesh, &topology)?;
    let triangles: Vec<(usize, [usize; 3])> = mesh.faces().triangles().collect();
    let corners = mesh.faces().corners();
    let indices: Vec<u32> = triangles
        .iter()
        .flat_map(|(_, c)| c.map(|k| corners[k]))
        .collect();
    let polygons: Vec<u32> = triangles.iter().map(|(f, _)| *f as u32).collect();
    // An edge of a triangle is an edge of the face only if its corners follow one another.
    let seams: Vec<[bool; 3]> = triangles
        .iter()
        .map(|(_, c)| {
            core::array::from_fn(|i| topology.next[c[i]] as usize == c[(i + 1) % 3] && marks[c[i]])
        })
        .collect();
    let input = uvunwrap::MeshInput {
        seams: Some(&seams),
        polygons: Some(&polygons),
        ..uvunwrap::MeshInput::new(mesh.positions(), &indices)
    };
    let options = uvunwrap::Options {
        density: uvunwrap::Density::Auto {
            page_size: atlas_size.size,
        },
        padding: padding(atlas_size),
        packing: uvunwrap::Packing::Fast,
        ..uvunwrap::Options::default()
    };
    let go_on = |p: uvunwrap::Progress| progress(p.done, p.total).is_continue();
    let atlas = uvunwrap::generate_with_progress(&[input], &options, go_on).map_err(|e| {
        match e {
            uvunwrap::Error::Cancelled => UvError::Cancelled,
            // With its padding alone a chart is larger than the atlas.
            uvunwrap::Error::ChartTooLarge { .. } => does_not_fit(1, atlas_size),
            e => UvError::Unwrap {
                reason: e.to_string(),
            },
        }
    })?;
    if atlas.page_count > 1 {
        return Err(does_not_fit(atlas.chart_count as usize, atlas_size));
    }
    let out = atlas.meshes.into_iter().next().unwrap_or_default();
    // The atlas is cropped in height; made square again, it keeps its texels.
    let height = f64::from(atlas.height) / f64::from(atlas_size.size);
    let width = f64::from(atlas.width) / f64::from(atlas_size.size);
    let mut values = alloc::vec![[0.0f32; 2]; corners.len()];
    for ((_, c), indices) in triangles.iter().zip(out.indices.as_chunks::<3>().0) {
        for (k, i) in c.iter().zip(indices) {
            let [u, v] = out.vertices[*i as usize].uv.map(f64::from);
            // The unwrapper's islands are counter-clockwise with v upward; for a top-left picture they are mirrored in v.
            let v = v * height;
            values[*k] = [
                (u * width) as f32,
                if origin == Origin::TopLeft {
                    (height - v) as f32
                } else {
                    v as f32
                },
            ];
        }
    }
    Ok(UvSet::shared(mesh, &values))
}

/// Texels around every island.
fn padding(atlas: AtlasSize) -> u32 {
    atlas.gutter.div_ceil(2)
}

fn does_not_fit(charts: usize, atlas: AtlasSize) -> UvError {
    UvError::DoesNotFit {
        charts,
        size: atlas.size,
        gutter: atlas.gutter,
    }
}

/// Refuses what the unwrapper has no room or no time for.
fn check(mesh: &Mesh<'_>, topology: &Topology, atlas: AtlasSize) -> Result<(), UvError> {
    if atlas.size > LARGEST {
        return Err(UvError::AtlasTooLarge {
            size: atlas.size,
            limit: LARGEST,
        });
    }
    let faces = mesh.faces();
    if atlas.size <= padding(atlas).saturating_mul(2) {
        let pieces = Islands::linked(faces.len(), topology, |_| true).count;
        return Err(does_not_fit(pieces, atlas));
    }
    let large = (0..faces.len()).find(|&f| faces.face(f).len() > AROUND);
    if let Some(face) = large {
        return Err(UvError::TooManyCorners {
            face,
            corners: faces.face(face).len(),
            limit: AROUND,
        });
    }
    let mut around = alloc::vec![0; mesh.positions().len()];
    for (_, corners) in faces.triangles() {
        for k in corners {
            around[topology.welded[faces.corners()[k] as usize] as usize] += 1;
        }
    }
    match around.iter().position(|count| *count > AROUND) {
        Some(vertex) => Err(UvError::TooManyAround {
            vertex: vertex as u32,
            triangles: around[vertex],
            limit: AROUND,
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faces;

    #[test]
    fn atlases_without_room_are_refused_by_their_size_and_gutter() {
        let positions = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [5.0; 3],
            [6.0, 5.0, 5.0],
        ];
        let faces = Faces::from_triangles(&[[0, 1, 2], [3, 4, 1]]);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let into = |size, gutter| {
            let go_on = |_, _| ControlFlow::Continue(());
            let atlas = AtlasSize { size, gutter };
            let cuts = SeamEdges::default();
            unwrap(&mesh, &cuts, atlas, Origin::TopLeft, &go_on).map(|_| ())
        };
        assert_eq!(into(LARGEST, 4), Ok(()));
        for size in [LARGEST + 1, 40_000, u32::MAX] {
            let limit = LARGEST;
            assert_eq!(into(size, 4), Err(UvError::AtlasTooLarge { size, limit }));
        }
        assert_eq!(into(16, 4), Ok(()));
        for (size, gutter) in [(8, 4096), (8, 8), (0, 0), (8, u32::MAX)] {
            let charts = 2;
            assert_eq!(
                into(size, gutter),
                Err(UvError::DoesNotFit {
                    charts,
                    size,
                    gutter
                })
            );
        }
    }
}
