//! Edges of a report: seams, the rim, edges of too many faces, T-junctions and the pieces they part.

use alloc::vec::Vec;

use super::ReportOptions;
use crate::islands::Islands;
use crate::mesh::{Mesh, length};
use crate::topology::{MANY, RIM, Topology, edge_length};
use crate::uv_set::UvSet;
use crate::{TJunctions, parallel, t_junction, views};

/// Figures of a report about edges.
pub(super) struct Edges {
    pub(super) seam_length: f64,
    pub(super) seam_seen: f64,
    pub(super) rim_length: f64,
    pub(super) non_manifold: usize,
    pub(super) islands: usize,
    pub(super) t_joints: TJunctions,
}

impl Edges {
    pub(super) fn new(mesh: &Mesh<'_>, set: &UvSet, options: &ReportOptions) -> Self {
        let topology = Topology::new(mesh);
        let seams = seams(mesh, set, &topology);
        let rim = (0..topology.twin.len()).filter(|&k| topology.twin[k] == RIM);
        Self {
            seam_length: lengths(mesh, &topology, seams.iter().copied()),
            seam_seen: if options.views {
                views::seen(mesh, &topology, &seams)
            } else {
                f64::NAN
            },
            rim_length: lengths(mesh, &topology, rim),
            non_manifold: non_manifold(mesh, &topology).len(),
            islands: islands(mesh, set, &topology),
            t_joints: t_junction::find(mesh, &topology),
        }
    }
}

/// Sum of the lengths of edges; a plain sum of none would be -0.
fn lengths(mesh: &Mesh<'_>, topology: &Topology, edges: impl Iterator<Item = usize>) -> f64 {
    edges.fold(0.0, |sum, k| sum + edge_length(mesh, topology, k))
}

/// The edges, each named by one corner, where two faces meet in space but not in the picture, or more than two meet.
fn seams(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology) -> Vec<usize> {
    let mut torn = parallel::collect_chunks(topology.twin.len(), |range| {
        let seam = |k: usize| match topology.twin[k] {
            RIM | MANY => None,
            twin => ((k as u32) < twin && !meets(mesh, set, topology, k)).then(|| topology.name(k)),
        };
        range.filter_map(seam).collect()
    });
    // Torn on both sides of a face without area, it is one seam.
    torn.sort_unstable();
    torn.dedup();
    torn.extend(non_manifold(mesh, topology));
    torn
}

/// As [`Topology::joined`], but equal coordinates count as one whatever their index. The picture goes on there.
fn meets(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology, k: usize) -> bool {
    let here = [k, topology.next[k] as usize].map(|c| set.at(c));
    topology
        .across(mesh, k)
        .is_some_and(|there| there.map(|c| set.at(c)) == here)
}

/// One corner of each edge of more than two faces.
fn non_manifold(mesh: &Mesh<'_>, topology: &Topology) -> Vec<usize> {
    let mut edges: Vec<([u32; 2], usize)> = (0..topology.twin.len())
        .filter(|&k| topology.twin[k] == MANY)
        .map(|k| (topology.ends(mesh, k), k))
        .collect();
    edges.sort_unstable();
    edges.dedup_by_key(|(ends, _)| *ends);
    edges.into_iter().map(|(_, k)| k).collect()
}

/// Pieces of the picture that have area in space.
fn islands(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology) -> usize {
    let islands = Islands::linked(mesh.faces().len(), topology, |k| {
        meets(mesh, set, topology, k)
    });
    let mut has_area = alloc::vec![false; islands.count];
    for (face, island) in islands.of_face.iter().enumerate() {
        let known = &mut has_area[*island as usize];
        *known = *known || length(mesh.face_normal(face)) > 0.0;
    }
    has_area.iter().filter(|has| **has).count()
}
