//! Shares of meshes in a net, and the sort that finds them.

use crate::refine::{Net, Triangle};

/// Share of each mesh in a refined net. Walking through the whole net for every mesh would take time as the square of their number.
pub(super) struct Shares<'n> {
    pub(super) net: &'n Net,
    /// Vertices in the order of their meshes.
    by_mesh: Vec<u32>,
    /// Index of each mesh's first vertex in that order.
    start: Vec<usize>,
}

impl<'n> Shares<'n> {
    pub(super) fn new(net: &'n Net, meshes: usize) -> Self {
        let (start, by_mesh) = order(meshes, net.vertices.iter().map(|v| v.mesh));
        Self {
            net,
            by_mesh,
            start,
        }
    }

    /// Vertices of a mesh, in ascending order.
    pub(super) fn vertices(&self, mesh: u32) -> &[u32] {
        let mesh = mesh as usize;
        &self.by_mesh[self.start[mesh]..self.start[mesh + 1]]
    }

    /// Triangles of a mesh: a refined net has them in the order of their meshes.
    pub(super) fn triangles(&self, mesh: u32) -> &'n [Triangle] {
        let net = self.net;
        let start = |mesh: u32| {
            net.triangles
                .partition_point(|t| net.vertices[t.vertices[0] as usize].mesh < mesh)
        };
        &net.triangles[start(mesh)..start(mesh + 1)]
    }
}

/// Indices of these numbers, all below `count`, in the order of the numbers, and the place of each number's first one: a counting sort.
pub(super) fn order(
    count: usize,
    numbers: impl Iterator<Item = u32> + Clone,
) -> (Vec<usize>, Vec<u32>) {
    let mut start = vec![0; count + 1];
    numbers.clone().for_each(|n| start[n as usize + 1] += 1);
    for i in 1..start.len() {
        start[i] += start[i - 1];
    }
    let (mut next, mut sorted) = (start.clone(), vec![0; start[count]]);
    for (i, number) in (0..).zip(numbers) {
        let place = &mut next[number as usize];
        sorted[*place] = i;
        *place += 1;
    }
    (start, sorted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refine::Vertex;

    /// Triangles of five meshes, in no order of theirs; mesh 2 has vertices alone.
    fn net() -> Net {
        let mut net = Net::default();
        for (number, mesh) in (0..).zip([3, 0, 2, 1, 4, 1, 0]) {
            let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
            for (point, [x, y]) in (3 * number..).zip(corners) {
                net.points.push([x, y, number as f32]);
                net.vertices.push(Vertex {
                    point,
                    mesh,
                    normal: [0.0, 0.0, 1.0],
                    uv: [x, y],
                    lightmap_uv: [0.0; 2],
                    color: [0.0; 3],
                });
            }
            if mesh != 2 {
                net.triangles.push(Triangle {
                    vertices: [0, 1, 2].map(|k| 3 * number + k),
                    base: 7 - number,
                });
            }
        }
        net
    }

    #[test]
    fn shares_hold_every_vertex_and_triangle_of_a_net_once() {
        let mut net = net();
        // Some meshes are cut later than others, so that their vertices lie between each other.
        let long = |net: &Net, a: &Vertex, b: &Vertex| {
            (net.position(a) - net.position(b)).length() > 0.2 * f64::from(a.mesh + 1)
        };
        net.refine(long, 10_000).unwrap();
        let shares = Shares::new(&net, 5);
        let (mut vertices, mut triangles) = (0, 0);
        for mesh in 0..5 {
            let own = |v: &u32| net.vertices[*v as usize].mesh == mesh;
            let of_mesh = shares.vertices(mesh);
            assert!(of_mesh.iter().all(own) && of_mesh.is_sorted());
            vertices += of_mesh.len();
            let of_mesh = shares.triangles(mesh);
            assert!(of_mesh.iter().all(|t| t.vertices.iter().all(own)));
            assert_eq!(of_mesh.is_empty(), mesh == 2);
            triangles += of_mesh.len();
        }
        assert_eq!(vertices, net.vertices.len());
        assert_eq!(triangles, net.triangles.len());
    }
}
