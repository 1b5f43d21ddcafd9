//! Meshes: triangles of one material.

use texmap_math::glam::{DMat3, DMat4, DVec3};
use texmap_math::texture_frame::TextureFrame;
use texmap_math::wide;
use texmap_sample::Origin;
use texmap_uv::{PerPixelProjection, Projection};

use crate::{Billboard, Displacement};

/// Triangles of one material.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// For messages.
    pub name: String,
    /// Vertices, object space.
    pub positions: Vec<[f32; 3]>,
    /// Empty, or one per vertex: object space, any length, out of the counter-clockwise side. If empty and
    /// needed, the area-weighted mean of the triangles at each vertex is used.
    pub normals: Vec<[f32; 3]>,
    /// Empty, or one per vertex: x, y, z of the tangent in object space, any length, and a sign so that `sign (N x T)` points up the picture
    /// of a normal map, whatever its origin (the TANGENT of glTF). If empty and needed, MikkTSpace's are computed from the coordinates.
    pub tangents: Vec<[f32; 4]>,
    /// Empty, or one per vertex: the file's own values.
    pub uvs: Vec<[f32; 2]>,
    /// Empty, or one per vertex: the second set, in which no two triangles overlap, for light maps.
    pub lightmap_uvs: Vec<[f32; 2]>,
    /// Empty, or one per vertex: linear light, multiplies the surface colour.
    pub colors: Vec<[f32; 3]>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Empty, or the source face of each triangle (for the `face` AOV and for errors). Empty: the
    /// triangle's own index.
    pub faces: Vec<u32>,
    /// Index into [`Scene::materials`](crate::Scene::materials).
    pub material: usize,
    /// Object to world space; may scale unevenly and mirror.
    pub world_from_object: DMat4,
    /// The row at which v = 0 lies in the pictures that this mesh's uv speak of: overrides the origin of the texture.
    pub uv_origin: Origin,
    /// Object-space O, U, V. If given, uv is computed at every pixel as A.W/C.W, B.W/C.W (Brackeen 2003,
    /// chapter 8) and `uvs` is not read.
    pub texture_frame: Option<TextureFrame>,
    /// A sphere or cylinder in world space. If given, uv is computed at every pixel from its position, exact also
    /// across the seam and around the axis, and neither `frame` nor `uvs` is read.
    pub uv_projection: Option<PerPixelProjection>,
    /// Casts no shadow: shadow maps and the depth maps of projectors do not show it.
    pub casts_no_shadow: bool,
    /// Bounds a solid, its fronts outwards and no hole in it. Maps of parallel and spot lights show its fronts alone, which is half of the
    /// work and the same shadow. Lights that stand inside of it shine through.
    pub watertight: bool,
    /// A height map that moves the surface, by `texmap_mesh::tessellate`.
    pub displacement: Option<Displacement>,
    /// If not empty, the mesh is these rectangles, four vertices each: see `texmap_mesh::billboards`.
    pub billboards: Vec<Billboard>,
}

impl Default for Mesh {
    /// No triangles, first material, identity transform, top-left uv.
    fn default() -> Self {
        Self {
            name: String::new(),
            positions: Vec::new(),
            normals: Vec::new(),
            tangents: Vec::new(),
            uvs: Vec::new(),
            lightmap_uvs: Vec::new(),
            colors: Vec::new(),
            triangles: Vec::new(),
            faces: Vec::new(),
            material: 0,
            world_from_object: DMat4::IDENTITY,
            uv_origin: Origin::TopLeft,
            texture_frame: None,
            uv_projection: None,
            casts_no_shadow: false,
            watertight: false,
            displacement: None,
            billboards: Vec::new(),
        }
    }
}

impl Mesh {
    /// Its vertices in world space.
    pub fn world_positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        let points = self.positions.iter();
        points.map(|p| self.world_from_object.transform_point3(wide(*p)))
    }

    /// Source face of a triangle, see [`faces`](Self::faces).
    #[must_use]
    pub fn face(&self, triangle: u32) -> u32 {
        self.faces
            .get(triangle as usize)
            .copied()
            .unwrap_or(triangle)
    }

    /// Replaces `uvs` by a projection of the positions onto a plane, box or sphere around them: the named
    /// fallback for a mesh that came without coordinates. Follows `uv_origin`. Tangents of the mesh are dropped: they are those of
    /// other coordinates.
    pub fn project_uvs(&mut self, projection: Projection) {
        let origin = match self.uv_origin {
            Origin::TopLeft => texmap_uv::Origin::TopLeft,
            Origin::BottomLeft => texmap_uv::Origin::BottomLeft,
        };
        self.uvs = texmap_uv::project(&self.positions, &self.normals, projection, origin);
        self.tangents.clear();
    }

    /// True if the mesh is triangles alone: without a displacement or billboards that `texmap_mesh::tessellate` must turn into
    /// triangles first.
    #[must_use]
    pub fn is_tessellated(&self) -> bool {
        self.displacement.is_none() && self.billboards.is_empty()
    }

    /// Angle between the plane of [`texture_frame`](Self::texture_frame) and that of the mesh's first triangle. The first
    /// with an area counts; radians, 0 to pi/2. `None` without a frame or without such a triangle. Beyond 0 the texture
    /// lies in another plane than the polygon (Brackeen 2003: "at an angle when seen head on").
    #[must_use]
    pub fn frame_tilt(&self) -> Option<f64> {
        let frame = self.texture_frame?.normal().normalize_or_zero();
        let normal = self
            .triangles
            .iter()
            .map(|t| self.cross(*t).normalize_or_zero())
            .find(|n| *n != DVec3::ZERO)?;
        Some(texmap_math::deterministic_f64::atan2(
            frame.cross(normal).length(),
            frame.dot(normal).abs(),
        ))
    }

    /// Cross product of two edges: the normal, twice the area long. Zero if an index is out of range.
    #[must_use]
    pub fn cross(&self, triangle: [u32; 3]) -> DVec3 {
        let vertex = |i: u32| {
            self.positions
                .get(i as usize)
                .map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into()))
        };
        match triangle.map(vertex) {
            [Some(a), Some(b), Some(c)] => (b - a).cross(c - a),
            _ => DVec3::ZERO,
        }
    }

    /// Normals of the vertices in object space, of any length: those of the mesh, or else the area-weighted mean of the triangles at each
    /// vertex, 0 where a vertex has none.
    #[must_use]
    pub fn object_normals(&self) -> Vec<DVec3> {
        if !self.normals.is_empty() {
            return self.normals.iter().map(|n| wide(*n)).collect();
        }
        let mut normals = vec![DVec3::ZERO; self.positions.len()];
        for triangle in &self.triangles {
            // Twice the area long.
            let normal = self.cross(*triangle);
            for vertex in triangle {
                normals[*vertex as usize] += normal;
            }
        }
        normals
    }

    /// Unit normals of the vertices in world space by the inverse transpose; 0 where a vertex has none.
    #[must_use]
    pub fn world_normals(&self) -> Vec<DVec3> {
        let count = match self.normals.len() {
            0 => self.positions.len(),
            count => count,
        };
        (0..count).map(self.world_normal()).collect()
    }

    /// [`world_normals`](Self::world_normals) one by one: a function of the vertex, which has to be one of the mesh.
    pub fn world_normal(&self) -> impl Fn(usize) -> DVec3 + Sync {
        let matrix = self.normal_matrix();
        let means = match self.normals.is_empty() {
            true => self.object_normals(),
            false => Vec::new(),
        };
        move |vertex| {
            let given = self.normals.get(vertex).map(|n| wide(*n));
            let normal = given.unwrap_or_else(|| means[vertex]);
            (matrix * normal.normalize_or_zero()).normalize_or_zero()
        }
    }

    /// Unit normals of the triangles' planes in world space, 0 for triangles without area: what the bias of a shadow is measured against.
    #[must_use]
    pub fn triangle_normals(&self) -> Vec<DVec3> {
        let matrix = self.normal_matrix();
        self.triangles
            .iter()
            .map(|t| (matrix * self.cross(*t)).normalize_or_zero())
            .collect()
    }

    /// A function that takes a tangent from object to world space: unit length, 0 for one of no length. The sign turns where the
    /// transform mirrors, for normals keep their side.
    pub fn world_tangent(&self) -> impl Fn([f32; 4]) -> (DVec3, f64) + Sync + use<> {
        let linear = DMat3::from_mat4(self.world_from_object);
        let mirror = if linear.determinant() < 0.0 {
            -1.0
        } else {
            1.0
        };
        move |[x, y, z, sign]| {
            let tangent = (linear * wide([x, y, z])).normalize_or_zero();
            (tangent, f64::from(sign) * mirror)
        }
    }

    fn normal_matrix(&self) -> DMat3 {
        DMat3::from_mat4(self.world_from_object)
            .inverse()
            .transpose()
    }
}
