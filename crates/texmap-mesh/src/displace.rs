//! Displacement: surfaces that are really moved, P' = P + (h - middle) height N (Cook 1984), so that outlines and shadows follow.
//!
//! Triangles are first cut fine enough for the map (`refine.rs`). Then every point is moved once: along the mean of the
//! different normals that meet in it, by the mean of the different heights, so that neither a hard edge nor a seam of the
//! coordinates opens. A point that a mesh without displacement shares stays where it is, and where such a mesh lies at an edge that
//! is cut, its triangles are cut there too.

use std::collections::HashMap;

use texmap_math::MemoryBudget;
use texmap_math::deterministic_f32;
use texmap_math::glam::{DMat4, DVec3};
use texmap_sample::{Sampler, Texture2d};

use crate::refine::{Net, Triangle, Vertex};

use crate::MeshError;
use texmap_scene::{EdgeBudget, Mesh, Scene};

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
    let maps: Vec<Option<HeightMap>> = members
        .iter()
        .map(|&i| HeightMap::new(scene, i, width))
        .collect();
    let limit = maps.iter().flatten().map(|m| m.limit).min().unwrap_or(0);
    let too_long = |net: &Net, a: &Vertex, b: &Vertex| {
        maps[a.mesh as usize]
            .as_ref()
            .is_some_and(|map| map.too_long(net, a, b))
    };
    let memory = MemoryBudget::of_process();
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
    for (number, &index) in (0..).zip(&members) {
        let mesh = &mut scene.meshes[index];
        if mesh.displacement.is_some() {
            scene
                .warnings
                .extend(field.warnings(&net, number, &mesh.name));
        }
        take(mesh, &net, &field, &normals, number);
    }
    Ok(())
}

/// The displaced meshes, and resting ones that share a point with them, over shared points; and their numbers in the scene.
fn join(scene: &Scene) -> (Net, Vec<usize>) {
    let mut places = Vec::new();
    let mut place = |mesh: &Mesh| {
        let bits = mesh
            .world_from_object
            .to_cols_array()
            .map(|c| (c + 0.0).to_bits());
        places
            .iter()
            .position(|known| *known == bits)
            .unwrap_or_else(|| {
                places.push(bits);
                places.len() - 1
            })
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

/// A displacement with what it is measured by.
struct HeightMap {
    texture: Texture2d<'static>,
    sampler: Sampler,
    /// Coordinates of the mesh to those of the map.
    rows: [[f32; 3]; 2],
    height: f64,
    middle: f64,
    budget: EdgeBudget,
    limit: u32,
    world_from_object: DMat4,
    /// `None` in a parallel projection.
    eye: Option<DVec3>,
    /// Pixels that a line of length 1 at distance 1 covers.
    pixels: f64,
}

impl HeightMap {
    fn new(scene: &Scene, mesh: usize, width: u32) -> Option<Self> {
        let mesh = &scene.meshes[mesh];
        let displacement = mesh.displacement.as_ref()?;
        let slot = &displacement.slot;
        let texture = scene.textures[slot.texture].clone();
        let texture = if texture.levels() == 1 {
            texture.with_mips()
        } else {
            texture
        };
        let camera = &scene.camera;
        let parallel = camera.lens.parallel_width.is_some();
        Some(Self {
            texture: texture.with_origin(mesh.uv_origin),
            sampler: slot.sampler.clone(),
            rows: slot.transform.rows(),
            height: displacement.height.into(),
            middle: displacement.middle.into(),
            budget: displacement.budget,
            limit: displacement.max_triangles,
            world_from_object: mesh.world_from_object,
            eye: (!parallel).then_some(camera.eye),
            pixels: f64::from(width) / (2.0 * camera.half_width(1.0)),
        })
    }

    fn place(&self, uv: [f32; 2]) -> [f32; 2] {
        self.rows.map(|[a, b, c]| a * uv[0] + b * uv[1] + c)
    }

    /// Squared length of an edge in texels of level 0.
    fn texels_squared(&self, a: &Vertex, b: &Vertex) -> f64 {
        let [p, q] = [a, b].map(|v| self.place(v.uv).map(f64::from));
        let x = (q[0] - p[0]) * f64::from(self.texture.width());
        let y = (q[1] - p[1]) * f64::from(self.texture.height());
        x * x + y * y
    }

    fn too_long(&self, net: &Net, a: &Vertex, b: &Vertex) -> bool {
        match self.budget {
            EdgeBudget::Texels(most) => {
                self.texels_squared(a, b) > f64::from(most) * f64::from(most)
            }
            EdgeBudget::Pixels(most) => {
                let [p, q] =
                    [a, b].map(|v| self.world_from_object.transform_point3(net.position(v)));
                let length = (q - p).length();
                let distance = self.eye.map_or(1.0, |eye| ((p + q) * 0.5 - eye).length());
                length * self.pixels > f64::from(most) * distance
                    && self.texels_squared(a, b) > 0.25
            }
        }
    }

    /// Distance that a vertex moves, `spacing` texels from its neighbours.
    fn rise(&self, vertex: &Vertex, spacing: f64) -> f64 {
        let level = if spacing > 1.0 {
            deterministic_f32::log2(spacing as f32)
        } else {
            0.0
        };
        let [h, ..] = self
            .sampler
            .sample_lod(&self.texture, self.place(vertex.uv), level);
        self.height * (f64::from(h) - self.middle)
    }
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
        let (start, by_point) = order(net);
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

    fn warnings(&self, net: &Net, mesh: u32, name: &str) -> Vec<String> {
        let mut warnings = Vec::new();
        let own = |v: u32| net.vertices[v as usize].mesh == mesh;
        let all = net.triangles.iter().filter(|t| own(t.vertices[0]));
        let (mut triangles, mut turned) = (0u32, 0u32);
        for t in all {
            let cross = self.cross(net, t, &self.after) * self.side(net, t);
            triangles += 1;
            turned += u32::from(cross.dot(out_of(net, t)) < 0.0);
        }
        if turned > 0 {
            warnings.push(format!(
                "mesh '{name}': {turned} of {triangles} displaced triangles turn over: the surface folds or cuts itself; lower the height of the displacement, or blur its map"
            ));
        }
        let lost = net
            .vertices
            .iter()
            .filter(|v| v.mesh == mesh && self.lost[v.point as usize])
            .count();
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

/// Vertices by their points: a counting sort.
fn order(net: &Net) -> (Vec<usize>, Vec<u32>) {
    let mut start = vec![0; net.points.len() + 1];
    net.vertices
        .iter()
        .for_each(|v| start[v.point as usize + 1] += 1);
    for i in 1..start.len() {
        start[i] += start[i - 1];
    }
    let (mut next, mut by_point) = (start.clone(), vec![0; net.vertices.len()]);
    for (v, vertex) in net.vertices.iter().enumerate() {
        let place = &mut next[vertex.point as usize];
        by_point[*place] = v as u32;
        *place += 1;
    }
    (start, by_point)
}

/// Gives a mesh its share of the net.
fn take(mesh: &mut Mesh, net: &Net, field: &Field, normals: &[[f32; 3]], number: u32) {
    let mut own = vec![u32::MAX; net.vertices.len()];
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
    for (v, vertex) in net
        .vertices
        .iter()
        .enumerate()
        .filter(|(_, v)| v.mesh == number)
    {
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
    for t in net
        .triangles
        .iter()
        .filter(|t| own[t.vertices[0] as usize] != u32::MAX)
    {
        mesh.triangles.push(t.vertices.map(|v| own[v as usize]));
        mesh.faces
            .push(old.get(t.base as usize).copied().unwrap_or(t.base));
    }
    mesh.displacement = None;
}
