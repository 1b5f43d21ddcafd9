//! The values that a mesh carries per vertex: those that its stages read, and no others.

use std::borrow::Cow;

use texmap_math::narrow;
use texmap_math::parallel;
use texmap_math::wide;

use texmap_light::{Lighting, PhongMaterial, lighting, reflect};
use texmap_math::glam::DVec3;
use texmap_raster::Cull;
use texmap_sample::Origin;

use texmap_scene::{Mesh, Scene};

/// A group of attributes.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Values {
    Uv,
    /// The mesh's own colours.
    Color,
    /// Lit and clipped colours.
    Lit,
    /// Diffuse light times the vertex colour.
    Diffuse,
    /// The light's highlights.
    Highlight,
    /// World space, unit length, on the counter-clockwise side.
    Normal,
    /// World space.
    Position,
    /// World-space tangent and the sign of the bitangent: the mesh's own, or those of the material's normal map by corners, which split
    /// vertices where they differ.
    Tangent,
    /// The second set of coordinates.
    LightMapUv,
}

impl Values {
    fn len(self) -> usize {
        match self {
            Self::Uv | Self::LightMapUv => 2,
            Self::Tangent => 4,
            _ => 3,
        }
    }

    fn is_light(self) -> bool {
        matches!(self, Self::Lit | Self::Diffuse | Self::Highlight)
    }
}

/// Collects groups of attributes.
#[derive(Default)]
pub(crate) struct Vertices {
    groups: Vec<Values>,
    attribute_count: usize,
    screen_linear: u32,
}

/// Vertex data of a mesh for the rasterizer.
pub(crate) struct VertexData<'s> {
    pub(crate) positions: Cow<'s, [[f32; 3]]>,
    pub(crate) triangles: Cow<'s, [[u32; 3]]>,
    pub(crate) attributes: Vec<f32>,
    pub(crate) attribute_count: usize,
    pub(crate) screen_linear: u32,
}

impl<'s> VertexData<'s> {
    /// A mesh as it is, with attributes as they are.
    pub(crate) fn of(mesh: &'s Mesh, attributes: Vec<f32>, attribute_count: usize) -> Self {
        Self {
            positions: Cow::Borrowed(&mesh.positions),
            triangles: Cow::Borrowed(&mesh.triangles),
            attributes,
            attribute_count,
            screen_linear: 0,
        }
    }
}

impl Vertices {
    /// Adds a group and returns the index of its first attribute.
    pub(crate) fn push(&mut self, values: Values, screen_linear: bool) -> usize {
        let first = self.attribute_count;
        self.groups.push(values);
        self.attribute_count += values.len();
        if screen_linear {
            self.screen_linear |= ((1 << values.len()) - 1) << first;
        }
        first
    }

    pub(crate) fn attribute_count(&self) -> usize {
        self.attribute_count
    }

    pub(crate) fn finish<'s>(self, scene: &Scene, mesh: &'s Mesh) -> VertexData<'s> {
        let lit = self.groups.iter().any(|g| g.is_light());
        let needs = |group| self.groups.contains(&group);
        let world_from_object = mesh.world_from_object;
        let mut triangles = Cow::Borrowed(mesh.triangles.as_slice());
        let mut positions = Cow::Borrowed(mesh.positions.as_slice());
        let mut groups = self.groups.iter();
        let split = groups.find_map(|group| match group {
            Values::Tangent if mesh.tangents.is_empty() => {
                let detail = scene.materials[mesh.material].normal_detail.as_ref()?;
                Some(Split::new(mesh, &detail.slot()?.tangent_uvs(mesh)))
            }
            _ => None,
        });
        if let Some(split) = &split {
            let at = |v: &u32| mesh.positions[*v as usize];
            positions = Cow::Owned(split.vertices.iter().map(at).collect());
            triangles = Cow::Owned(split.triangles.clone());
        }
        // A mirroring transform reverses the winding of triangles; their fronts stay fronts.
        if world_from_object.determinant() < 0.0 {
            triangles.to_mut().iter_mut().for_each(|t| t.swap(1, 2));
        }
        let point = |v: usize| world_from_object.transform_point3(wide(mesh.positions[v]));
        let mut back_from = usize::MAX;
        // Triangles that show their back are lit on the other side of their vertices: a second set.
        if lit && scene.materials[mesh.material].cull != Cull::Back {
            let away = facing_away(point, &triangles, scene.camera.viewpoint());
            if away.contains(&true) {
                back_from = positions.len();
                positions.to_mut().extend_from_within(..);
                for (triangle, _) in triangles
                    .to_mut()
                    .iter_mut()
                    .zip(&away)
                    .filter(|(_, away)| **away)
                {
                    *triangle = triangle.map(|v| v + back_from as u32);
                }
            }
        }
        let normal = (lit || needs(Values::Normal)).then(|| mesh.world_normal());
        let source = Source {
            scene,
            mesh,
            normal: |v: usize| normal.as_ref().map_or(DVec3::ZERO, |normal| normal(v)),
            point,
            tangent: mesh.world_tangent(),
            back_from,
            split,
        };
        let mut attributes = vec![0.0; positions.len() * self.attribute_count];
        if self.attribute_count > 0 {
            let blocks = attributes.chunks_mut(VERTICES * self.attribute_count);
            parallel::for_each(blocks.enumerate(), |(block, values)| {
                let vertices = values.chunks_exact_mut(self.attribute_count);
                for (vertex, values) in (block * VERTICES..).zip(vertices) {
                    source.fill(&self.groups, vertex, lit, values);
                }
            });
        }
        let (attribute_count, screen_linear) = (self.attribute_count, self.screen_linear);
        VertexData {
            positions,
            triangles,
            attributes,
            attribute_count,
            screen_linear,
        }
    }
}

/// Vertices that a thread takes at once.
const VERTICES: usize = 4096;

/// A mesh with its normals and positions in world space, by vertex.
struct Source<'s, N, P, T> {
    scene: &'s Scene,
    mesh: &'s Mesh,
    normal: N,
    point: P,
    tangent: T,
    /// Vertices from here are those of back sides.
    back_from: usize,
    /// The vertices split by tangents, if tangents are among the values and the mesh has none.
    split: Option<Split>,
}

/// Vertices split where the tangents of their corners differ.
struct Split {
    /// The mesh's vertex of each split vertex.
    vertices: Vec<u32>,
    tangents: Vec<[f32; 4]>,
    triangles: Vec<[u32; 3]>,
}

impl Split {
    fn new(mesh: &Mesh, uvs: &[[f32; 2]]) -> Self {
        const NONE: u32 = u32::MAX;
        let of_corners = corner_tangents(mesh, uvs, &mesh.object_normals());
        let (mut vertices, mut tangents) = (Vec::new(), Vec::<[f32; 4]>::new());
        // The first part of each vertex, and the next part after each part.
        let mut first = vec![NONE; mesh.positions.len()];
        let mut next = Vec::new();
        let mut part_of = |vertex: u32, tangent: [f32; 4]| {
            let bits = tangent.map(f32::to_bits);
            let mut part = first[vertex as usize];
            while part != NONE {
                if tangents[part as usize].map(f32::to_bits) == bits {
                    return part;
                }
                part = next[part as usize];
            }
            let part = vertices.len() as u32;
            vertices.push(vertex);
            tangents.push(tangent);
            next.push(std::mem::replace(&mut first[vertex as usize], part));
            part
        };
        let mut of_corners = of_corners.into_iter();
        let triangles = mesh
            .triangles
            .iter()
            .map(|t| t.map(|vertex| part_of(vertex, of_corners.next().unwrap_or_default())))
            .collect();
        Self {
            vertices,
            tangents,
            triangles,
        }
    }
}

impl<N, P, T> Source<'_, N, P, T>
where
    N: Fn(usize) -> DVec3,
    P: Fn(usize) -> DVec3,
    T: Fn([f32; 4]) -> (DVec3, f64),
{
    /// Writes the values of a vertex.
    fn fill(&self, groups: &[Values], vertex: usize, lit: bool, out: &mut [f32]) {
        let back = vertex >= self.back_from;
        let part = vertex;
        let vertex = match &self.split {
            Some(split) => split.vertices[vertex] as usize,
            None if back => vertex - self.back_from,
            None => vertex,
        };
        let surface = &self.scene.materials[self.mesh.material].phong;
        let tint = self.mesh.colors.get(vertex).copied().unwrap_or([1.0; 3]);
        let terms = if lit {
            self.terms(surface, vertex, back)
        } else {
            Lighting::default()
        };
        let mut rest = out;
        for group in groups {
            rest = match group {
                Values::Uv => put(rest, self.mesh.uvs[vertex]),
                Values::Color => put(rest, tint),
                Values::Lit => put(rest, terms.color(times(surface.color, tint))),
                Values::Diffuse => put(rest, times(terms.diffuse, tint)),
                Values::Highlight => put(rest, terms.highlight),
                Values::Normal => put(rest, narrow((self.normal)(vertex))),
                Values::Position => put(rest, narrow((self.point)(vertex))),
                Values::Tangent => {
                    let of_corners = self.split.as_ref().map(|split| split.tangents[part]);
                    let tangent = of_corners
                        .or_else(|| self.mesh.tangents.get(vertex).copied())
                        .unwrap_or_default();
                    let (direction, sign) = (self.tangent)(tangent);
                    let [x, y, z] = narrow(direction);
                    put(rest, [x, y, z, sign as f32])
                }
                Values::LightMapUv => put(rest, self.mesh.lightmap_uvs[vertex]),
            };
        }
    }

    fn terms(&self, surface: &PhongMaterial, vertex: usize, back: bool) -> Lighting {
        let (normal, point) = ((self.normal)(vertex), (self.point)(vertex));
        let normal = if back { -normal } else { normal };
        let eye = narrow(self.scene.camera.viewpoint());
        let mut terms = lighting(
            surface,
            &self.scene.lights,
            narrow(point),
            narrow(normal),
            eye,
        );
        if let Some(map) = self.scene.materials[self.mesh.material].specular_map {
            let view = (self.scene.camera.viewpoint() - point).normalize_or_zero();
            let light = self.scene.effects.environments[map]
                .radiance(reflect(narrow(view), narrow(normal)));
            for (sum, c) in terms.highlight.iter_mut().zip(light) {
                *sum += surface.ks * c;
            }
        }
        terms
    }
}

/// Writes a group and gives what is left: of a length that the compiler knows, which takes no call.
fn put<const N: usize>(out: &mut [f32], values: [f32; N]) -> &mut [f32] {
    match out.split_first_chunk_mut() {
        Some((group, rest)) => {
            *group = values;
            rest
        }
        None => &mut [],
    }
}

fn facing_away(point: impl Fn(usize) -> DVec3, triangles: &[[u32; 3]], eye: DVec3) -> Vec<bool> {
    triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|v| point(v as usize));
            (b - a).cross(c - a).dot(eye - a) < 0.0
        })
        .collect()
}

fn times(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// Tangents of a mesh's corners for normal maps whose y points up the picture: object-space vectors and the sign of the bitangent.
fn corner_tangents(mesh: &Mesh, uvs: &[[f32; 2]], normals: &[DVec3]) -> Vec<[f32; 4]> {
    let faces = texmap_uv::Faces::from_triangles(&mesh.triangles);
    let corners: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    let set = texmap_uv::UvSet {
        uvs: uvs.to_vec(),
        corners: corners.clone(),
    };
    let normal = |v: &u32| normals[*v as usize].normalize_or_zero().to_array();
    let at_corners: Vec<[f32; 3]> = corners
        .iter()
        .map(|v| normal(v).map(|c| c as f32))
        .collect();
    let fallback = || vec![[0.0; 4]; corners.len()];
    let Ok(shape) = texmap_uv::Mesh::new(&mesh.positions, &faces) else {
        return fallback();
    };
    let Ok(tangents) = texmap_uv::tangents(&shape, &set, &at_corners) else {
        return fallback();
    };
    // The bitangent follows growing v, which runs down the picture from a top-left origin.
    let down = if mesh.uv_origin == Origin::TopLeft {
        -1.0
    } else {
        1.0
    };
    tangents
        .into_iter()
        .map(|[x, y, z, sign]| [x, y, z, sign * down])
        .collect()
}
