//! Islands: faces that are connected in the picture, and the texture coordinates that they share.

use alloc::vec;
use alloc::vec::Vec;

use crate::mesh::Mesh;
use crate::parallel;
use crate::topology::{MANY, RIM, Topology};
use crate::uv_set::UvSet;

/// Faces grouped into connected pieces of the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Islands {
    /// Island of each face; islands are numbered by their lowest face.
    pub(crate) of_face: Vec<u32>,
    pub(crate) count: usize,
}

impl Islands {
    pub(crate) fn new(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology) -> Self {
        Self::linked(mesh.faces().len(), topology, |k| {
            topology.joined(mesh, set, k)
        })
    }

    /// Groups faces over the edges for which `link` holds.
    pub(crate) fn linked(
        faces: usize,
        topology: &Topology,
        link: impl Fn(usize) -> bool + Sync + Send,
    ) -> Self {
        let links = parallel::collect_chunks(topology.twin.len(), |range| {
            let pairs = range
                .filter(|&k| topology.twin[k] < MANY && (k as u32) < topology.twin[k] && link(k));
            pairs
                .map(|k| [topology.face[k], topology.face[topology.twin[k] as usize]])
                .collect()
        });
        let mut parent: Vec<u32> = (0..faces as u32).collect();
        for [a, b] in links {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            // The lower face leads, so numbers do not depend on the order.
            parent[a.max(b) as usize] = a.min(b);
        }
        let (mut of_face, mut count) = (vec![0; faces], 0);
        for f in 0..faces {
            let r = root(&mut parent, f as u32) as usize;
            of_face[f] = if r == f {
                count += 1;
                count - 1
            } else {
                of_face[r]
            };
        }
        Self {
            of_face,
            count: count as usize,
        }
    }
}

pub(crate) fn root(parent: &mut [u32], mut f: u32) -> u32 {
    while parent[f as usize] != f {
        parent[f as usize] = parent[parent[f as usize] as usize];
        f = parent[f as usize];
    }
    f
}

/// Gives every island its own coordinates where two islands share one (they touch in a point).
pub(crate) fn separate(topology: &Topology, islands: &Islands, set: &mut UvSet) {
    let mut owner = vec![RIM; set.uvs.len()];
    let mut copies = alloc::collections::BTreeMap::new();
    for k in 0..set.corners.len() {
        let (island, index) = (islands.of_face[topology.face[k] as usize], set.corners[k]);
        if owner[index as usize] == RIM {
            owner[index as usize] = island;
        } else if owner[index as usize] != island {
            set.corners[k] = *copies.entry((island, index)).or_insert_with(|| {
                set.uvs.push(set.uvs[index as usize]);
                set.uvs.len() as u32 - 1
            });
        }
    }
}

/// Drops coordinates that no corner uses.
pub(crate) fn compact(set: &UvSet) -> UvSet {
    let mut place = vec![RIM; set.uvs.len()];
    let mut out = UvSet {
        uvs: Vec::new(),
        corners: Vec::with_capacity(set.corners.len()),
    };
    for &index in &set.corners {
        let slot = &mut place[index as usize];
        if *slot == RIM {
            *slot = out.uvs.len() as u32;
            out.uvs.push(set.uvs[index as usize]);
        }
        out.corners.push(*slot);
    }
    out
}
