//! Displacement: surfaces that are really moved, P' = P + (h - middle) height N (Cook 1984), so that outlines and shadows follow.
//!
//! Triangles are first cut fine enough for the map (`refine.rs`). Then every point is moved once: along the mean of the
//! different normals that meet in it, by the mean of the different heights, so that neither a hard edge nor a seam of the
//! coordinates opens. A point that a mesh without displacement shares stays where it is, and where such a mesh lies at an edge that
//! is cut, its triangles are cut there too.

mod height_map;
mod shares;

use std::collections::HashMap;

use texmap_math::MemoryBudget;
use texmap_math::glam::DVec3;
use texmap_scene::{Mesh, Scene};

use crate::MeshError;
use crate::refine::{Net, Triangle, Vertex};
use height_map::HeightMap;
use shares::{Shares, order};

/// Memory that displacement takes at its peak for each triangle that it makes, measured: cut triangles with their vertices and
/// edges, then points before and after with their normals, then the finished mesh.
const TRIANGLE_BYTES: u64 = 400;

/// Displaces every mesh that says so, all together, for a picture of `width` pixels by the scene's camera.
pub(crate) fn displace(scene: &mut Scene, width: u32) -> Result<(), MeshError> {
    let moves = |mesh: &&Mesh| mesh.displacement.is_some();
    let Some(first) = scene.meshes.iter().find(moves) else {
        return Ok(());
    };
    let name = first.name.clone();
    let (mut net, members) = join(scene);
    let memory = MemoryBudget::of_process();
    let maps = HeightMap::of_meshes(scene, &members, width, memory)?;
    let limit = maps.iter().flatten().map(|m| m.limit).min().unwrap_or(0);
    let too_long = |net: &Net, a: &Vertex, b: &Vertex| {
        maps[a.mesh as usize]
            .as_ref()
            .is_some_and(|map| map.too_long(net, a, b))
    };
    let affordable = usize::try_from(memory.available() / TRIANGLE_BYTES).unwrap_or(usize::MAX);
    let refined = net.refine(too_long, affordable.min(limit as usize));
    refined.map_err(|triangles| {
        let triangles = triangles as u64;
        let asked = memory.ask(
            triangles * TRIANGLE_BYTES,
            format_args!(
                "the displacement of mesh '{name}' into {triangles} triangles and counting"
            ),
            "allow longer edges (texels or pixels), or take a smaller map",
        );
        match asked {
            Err(refused) if triangles <= u64::from(limit) => MeshError::Memory(refused),
            _ => MeshError::TooManyTriangles {
                mesh: name,
                triangles,
                limit,
            },
        }
    })?;
    let field = Field::new(&net, &maps);
    let normals = field.normals(&net, &maps);
    let shares = Shares::new(&net, members.len());
    let mut own = vec![0; net.vertices.len()];
    for (number, &index) in (0..).zip(&members) {
        let mesh = &mut scene.meshes[index];
        if mesh.displacement.is_some() {
            scene
                .warnings
                .extend(field.warnings(&shares, number, &mesh.name));
        }
        take(mesh, &shares, number, &field, &normals, &mut own);
    }
    Ok(())
}

/// The displaced meshes, and resting ones that share a point with them, over shared points; and their numbers in the scene.
fn join(scene: &Scene) -> (Net, Vec<usize>) {
    let mut places = HashMap::new();
    let mut place = |mesh: &Mesh| {
        let bits = mesh
            .world_from_object
            .to_cols_array()
            .map(|c| (c + 0.0).to_bits());
        let next = places.len();
        *places.entry(bits).or_insert(next)
    };
    // Adding 0 makes one zero of both.
    let key = |place: usize, p: &[f32; 3]| (place, p.map(|c| (c + 0.0).to_bits()));
    let mut points: HashMap<(usize, [u32; 3]), u32> = HashMap::new();
    let mut net = Net::default();
    let add =
        |net: &mut Net, points: &mut HashMap<_, u32>, place: usize, mesh: &Mesh, number: usize| {
            let first = net.vertices.len() as u32;
            for (v, (p, n)) in mesh.positions.iter().zip(mesh.object_normals()).enumerate() {
                let vertex = Vertex {
                    point: *points.entry(key(place, p)).or_insert_with(|| {
                        net.points.push(*p);
                        net.points.len() as u32 - 1
                    }),
                    mesh: number as u32,
                    normal: n.normalize_or_zero().as_vec3().to_array(),
                    uv: mesh.uvs.get(v).copied().unwrap_or_default(),
                    lightmap_uv: mesh.lightmap_uvs.get(v).copied().unwrap_or_default(),
                    color: mesh.colors.get(v).copied().unwrap_or_default(),
                };
                net.vertices.push(vertex);
            }
            net.triangles
                .extend(mesh.triangles.iter().zip(0..).map(|(t, base)| Triangle {
                    vertices: t.map(|v| v + first),
                    base,
                }));
        };
    let (mut members, resting): (Vec<usize>, Vec<usize>) =
        (0..scene.meshes.len()).partition(|&i| scene.meshes[i].displacement.is_some());
    for (number, &index) in members.iter().enumerate() {
        let mesh = &scene.meshes[index];
        add(&mut net, &mut points, place(mesh), mesh, number);
    }
    let moving = net.points.len() as u32;
    for index in resting {
        let mesh = &scene.meshes[index];
        let place = place(mesh);
        let touches = |p: &[f32; 3]| points.get(&key(place, p)).is_some_and(|p| *p < moving);
        // A mesh that touches none of them has nothing to do with them.
        if mesh.positions.iter().any(touches) {
            add(&mut net, &mut points, place, mesh, members.len());
            members.push(index);
        }
    }
    (net, members)
}

/// Position of every point before and after the displacement.
struct Field {
    /// Object space, before and after.
    before: Vec<DVec3>,
    after: Vec<DVec3>,
    /// Points that have no direction to go.
    lost: Vec<bool>,
    /// Vertices in the order of their points.
    by_point: Vec<u32>,
    /// Index of each point's first vertex in that order.
    start: Vec<usize>,
}

impl Field {
    fn new(net: &Net, maps: &[Option<HeightMap>]) -> Self {
        let (start, by_point) = order(net.points.len(), net.vertices.iter().map(|v| v.point));
        let mut spacing = vec![f64::INFINITY; net.points.len()];
        for t in &net.triangles {
            for k in 0..3 {
                let [a, b] = [k, (k + 1) % 3].map(|k| &net.vertices[t.vertices[k] as usize]);
                let Some(map) = &maps[a.mesh as usize] else {
                    continue;
                };
                let texels = map.texels_squared(a, b);
                for end in [a, b] {
                    let least = &mut spacing[end.point as usize];
                    *least = if texels < *least { texels } else { *least };
                }
            }
        }
        let mut lost = vec![false; net.points.len()];
        let before: Vec<DVec3> = net
            .points
            .iter()
            .map(|p| DVec3::from(p.map(f64::from)))
            .collect();
        let mut after = before.clone();
        let (mut normals, mut rises) = (Vec::new(), Vec::new());
        for point in 0..net.points.len() {
            let here = &by_point[start[point]..start[point + 1]];
            let map = |v: &u32| maps[net.vertices[*v as usize].mesh as usize].as_ref();
            // Without a triangle, or held by a mesh that rests.
            if spacing[point] == f64::INFINITY || here.iter().any(|v| map(v).is_none()) {
                continue;
            }
            normals.clear();
            rises.clear();
            for v in here {
                let vertex = &net.vertices[*v as usize];
                normals.push(vertex.normal);
                rises.extend(map(v).map(|m| m.rise(vertex, spacing[point].sqrt())));
            }
            // Each different one once, in an order that is theirs, not the mesh's.
            normals.sort_unstable_by_key(|n| n.map(f32::to_bits));
            normals.dedup();
            rises.sort_unstable_by(f64::total_cmp);
            rises.dedup();
            let sum: DVec3 = normals
                .iter()
                .map(|n| DVec3::from(n.map(f64::from)).normalize_or_zero())
                .sum();
            lost[point] = sum.length_squared() < 1e-12;
            if !lost[point] {
                let rise = rises.iter().sum::<f64>() / rises.len() as f64;
                after[point] += sum.normalize() * rise;
            }
        }
        Self {
            before,
            after,
            lost,
            by_point,
            start,
        }
    }

    /// Of each vertex: the area-weighted mean of the moved triangles at its point whose vertices have its own old normal, so
    /// that hard edges stay hard and seams stay smooth.
    fn normals(&self, net: &Net, maps: &[Option<HeightMap>]) -> Vec<[f32; 3]> {
        let mut sums = vec![DVec3::ZERO; net.vertices.len()];
        for t in &net.triangles {
            let cross = self.cross(net, t, &self.after) * self.side(net, t);
            t.vertices.iter().for_each(|v| sums[*v as usize] += cross);
        }
        let mut normals: Vec<[f32; 3]> = net.vertices.iter().map(|v| v.normal).collect();
        for point in 0..net.points.len() {
            let mut here = self.by_point[self.start[point]..self.start[point + 1]].to_vec();
            let bits = |v: &u32| net.vertices[*v as usize].normal.map(f32::to_bits);
            here.sort_by_key(|v| bits(v));
            for alike in here.chunk_by(|a, b| bits(a) == bits(b)) {
                let sum: DVec3 = alike.iter().map(|v| sums[*v as usize]).sum();
                let unit = sum.normalize_or_zero();
                let moved = |v: &&u32| maps[net.vertices[**v as usize].mesh as usize].is_some();
                if unit != DVec3::ZERO {
                    let moved = alike.iter().filter(moved);
                    moved.for_each(|v| normals[*v as usize] = unit.as_vec3().to_array());
                }
            }
        }
        normals
    }

    fn cross(&self, net: &Net, t: &Triangle, at: &[DVec3]) -> DVec3 {
        let [a, b, c] = t
            .vertices
            .map(|v| at[net.vertices[v as usize].point as usize]);
        (b - a).cross(c - a)
    }

    /// 1 where the normals lie on the counter-clockwise side of the resting triangle, else -1.
    fn side(&self, net: &Net, t: &Triangle) -> f64 {
        if self.cross(net, t, &self.before).dot(out_of(net, t)) < 0.0 {
            -1.0
        } else {
            1.0
        }
    }

    fn warnings(&self, shares: &Shares<'_>, mesh: u32, name: &str) -> Vec<String> {
        let mut warnings = Vec::new();
        let net = shares.net;
        let all = shares.triangles(mesh);
        let turns = |t: &&Triangle| {
            let cross = self.cross(net, t, &self.after) * self.side(net, t);
            cross.dot(out_of(net, t)) < 0.0
        };
        let (triangles, turned) = (all.len(), all.iter().filter(turns).count());
        if turned > 0 {
            warnings.push(format!(
                "mesh '{name}': {turned} of {triangles} displaced triangles turn over: the surface folds or cuts itself; lower the height of the displacement, or blur its map"
            ));
        }
        let stays = |v: &&u32| self.lost[net.vertices[**v as usize].point as usize];
        let lost = shares.vertices(mesh).iter().filter(stays).count();
        if lost > 0 {
            warnings.push(format!(
                "mesh '{name}': {lost} vertices stay where they are: their normals are zero or cancel out"
            ));
        }
        warnings
    }
}

/// The mean direction of a triangle's own normals, before it moved.
fn out_of(net: &Net, t: &Triangle) -> DVec3 {
    let normal = |v: u32| DVec3::from(net.vertices[v as usize].normal.map(f64::from));
    t.vertices.map(normal).into_iter().sum()
}

/// Gives a mesh its share of the net. `own` has a place for every vertex of the net; those of this mesh are written before they are
/// read, so that all meshes can use one.
fn take(
    mesh: &mut Mesh,
    shares: &Shares<'_>,
    number: u32,
    field: &Field,
    normals: &[[f32; 3]],
    own: &mut [u32],
) {
    let (uvs, second, colors) = (
        !mesh.uvs.is_empty(),
        !mesh.lightmap_uvs.is_empty(),
        !mesh.colors.is_empty(),
    );
    let old = std::mem::take(&mut mesh.faces);
    mesh.positions.clear();
    mesh.normals.clear();
    // Those of the new surface follow from its coordinates.
    mesh.tangents.clear();
    mesh.uvs.clear();
    mesh.lightmap_uvs.clear();
    mesh.colors.clear();
    for &v in shares.vertices(number) {
        let (v, vertex) = (v as usize, &shares.net.vertices[v as usize]);
        own[v] = mesh.positions.len() as u32;
        mesh.positions
            .push(field.after[vertex.point as usize].as_vec3().to_array());
        mesh.normals.push(normals[v]);
        mesh.uvs.extend(uvs.then_some(vertex.uv));
        mesh.lightmap_uvs
            .extend(second.then_some(vertex.lightmap_uv));
        mesh.colors.extend(colors.then_some(vertex.color));
    }
    mesh.triangles.clear();
    for t in shares.triangles(number) {
        mesh.triangles.push(t.vertices.map(|v| own[v as usize]));
        mesh.faces
            .push(old.get(t.base as usize).copied().unwrap_or(t.base));
    }
    mesh.displacement = None;
}

#[cfg(test)]
mod tests {
    use texmap_math::Camera;
    use texmap_math::glam::DMat4;
    use texmap_sample::{Alpha, ColorSpace, Filter, Image, Origin, TexelData, Texture2d};
    use texmap_scene::{Displacement, EdgeBudget, Material, TextureSlot};

    use super::*;

    const FILTERS: [Filter; 6] = [
        Filter::Nearest,
        Filter::Bilinear,
        Filter::Trilinear,
        Filter::BilinearMipNearest,
        Filter::ewa(4),
        Filter::SummedArea,
    ];

    /// Uneven heights that repeat nowhere.
    fn map(side: u32) -> Texture2d<'static> {
        let heights: Vec<f32> = (0..side * side)
            .map(|i| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32)
            .collect();
        let image = Image {
            width: side,
            height: side,
            channels: 1,
            texels: TexelData::F32(&heights),
            color: ColorSpace::Linear,
            alpha: Alpha::Data,
            origin: Origin::TopLeft,
        };
        Texture2d::new(&image).unwrap()
    }

    /// Quads in a row, `gap` between them, each cut, moved and seen in its own way. Some have no normal to go along, some fold.
    fn quads(count: usize, gap: f32) -> Scene {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]));
        scene.materials = vec![Material::default()];
        scene.textures = vec![map(16), map(9), map(16).with_mips()];
        let quad = |i: usize| {
            let left = i as f32 * (1.0 + gap);
            let mut slot = TextureSlot::new(i % 3);
            slot.sampler.filter = FILTERS[i % 6];
            let budget = match i % 4 {
                0 => EdgeBudget::Pixels(9.0),
                k => EdgeBudget::Texels(k as f32 + 1.0),
            };
            let up = if i % 7 == 3 { 0.0 } else { 1.0 };
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            Mesh {
                name: format!("quad {i}"),
                positions: corners.map(|[x, y]| [left + x, y, 0.0]).to_vec(),
                normals: corners
                    .map(|[x, _]| [(i % 5) as f32 * (0.5 - x), 0.0, up])
                    .to_vec(),
                uvs: corners.to_vec(),
                colors: corners[..4 * (i % 2)]
                    .iter()
                    .map(|[x, y]| [*x, *y, 0.5])
                    .collect(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                faces: vec![7, i as u32],
                uv_origin: [Origin::TopLeft, Origin::BottomLeft][i / 3 % 2],
                world_from_object: DMat4::from_translation(DVec3::Z * (i % 3) as f64),
                displacement: Some(Displacement {
                    budget,
                    ..Displacement::new(slot, 0.5 * (i % 4) as f32)
                }),
                ..Mesh::default()
            }
        };
        scene.meshes = (0..count).map(quad).collect();
        scene
    }

    /// Meshes and warnings, the second time mesh by mesh. Meshes are written out, so that no two different numbers are equal.
    fn together_and_alone(mut scene: Scene) -> [(String, Vec<String>); 2] {
        let (mut meshes, mut warnings) = (Vec::new(), Vec::new());
        for mesh in &scene.meshes {
            let mut alone = scene.clone();
            alone.meshes = vec![mesh.clone()];
            displace(&mut alone, 64).unwrap();
            meshes.append(&mut alone.meshes);
            warnings.append(&mut alone.warnings);
        }
        displace(&mut scene, 64).unwrap();
        [
            (format!("{:?}", scene.meshes), scene.warnings),
            (format!("{meshes:?}"), warnings),
        ]
    }

    #[test]
    fn many_meshes_at_once_are_those_that_each_is_alone() {
        let [together, alone] = together_and_alone(quads(48, 0.5));
        assert!(together == alone);
        for told in ["turn over", "stay where they are"] {
            assert!(alone.1.iter().any(|w| w.contains(told)), "{told}");
        }
        // The negative twin: neighbours that share an edge agree on it.
        let mut touching = quads(48, 0.0);
        for mesh in &mut touching.meshes {
            mesh.world_from_object = DMat4::IDENTITY;
        }
        let [together, alone] = together_and_alone(touching);
        assert!(together.0 != alone.0);
    }
}
