//! The vertices and faces of one scene file: runs of faces of one material become meshes.

use std::collections::HashMap;

use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_math::texture_frame::TextureFrame;
use texmap_mesh::SkinBlend;
use texmap_scene::{Displacement, Mesh, Scene};
use texmap_uv::PerPixelProjection;

use super::shapes::Bones;
use crate::SourceLocation;
use crate::obj::unit;

/// Vertices of a file, and the meshes that its faces have made.
#[derive(Debug, Default)]
pub(super) struct Facets {
    vertices: Vec<Vertex>,
    /// Sum of the area normals of the lit faces at each vertex, and the first of them.
    normals: Vec<[DVec3; 2]>,
    meshes: Vec<Run>,
}

/// A `v` line.
#[derive(Debug)]
struct Vertex {
    /// In the world.
    position: DVec3,
    /// The transform of its line mirrors.
    mirrored: bool,
}

/// A mesh in the making.
#[derive(Debug)]
struct Run {
    mesh: usize,
    /// It has a name: later faces do not belong to it.
    closed: bool,
    lit: bool,
    frame: Option<TextureFrame>,
    round: Option<PerPixelProjection>,
    skin: Option<(SkinBlend, SourceLocation)>,
    /// Vertex of the file behind each vertex of the mesh.
    sources: Vec<u32>,
    known: HashMap<(u32, [u32; 2]), u32>,
}

/// A face as its line describes it.
#[derive(Debug)]
pub(super) struct Facet<'a> {
    /// Vertex and, for `tf`, coordinates of each corner.
    pub(super) corners: &'a [(u32, [f32; 2])],
    pub(super) has_uv: bool,
    pub(super) frame: Option<TextureFrame>,
    pub(super) round: Option<PerPixelProjection>,
    pub(super) displacement: Option<Displacement>,
    pub(super) skin: Option<(SkinBlend, SourceLocation)>,
    pub(super) shadowless: bool,
    pub(super) lit: bool,
    pub(super) material: usize,
    /// Counted through the scene from 0.
    pub(super) number: u32,
}

impl Facets {
    pub(super) fn vertex(&mut self, position: DVec3, mirrored: bool) {
        self.vertices.push(Vertex { position, mirrored });
        self.normals.push([DVec3::ZERO; 2]);
    }

    /// Ends the last mesh.
    pub(super) fn close(&mut self) {
        if let Some(run) = self.meshes.last_mut() {
            run.closed = true;
        }
    }

    /// Cuts a face into its fan and adds it to the last mesh, or to a new one where the settings differ.
    pub(super) fn add(&mut self, scene: &mut Scene, facet: &Facet<'_>, location: &SourceLocation) {
        let fits = |run: &Run| {
            let mesh = &scene.meshes[run.mesh];
            !run.closed
                && run.mesh + 1 == scene.meshes.len()
                && mesh.material == facet.material
                && mesh.uvs.is_empty() != facet.has_uv
                && run.lit == facet.lit
                && run.frame == facet.frame
                && run.round == facet.round
                && run.skin == facet.skin
                && mesh.displacement == facet.displacement
                && mesh.casts_no_shadow == facet.shadowless
        };
        if !self.meshes.last().is_some_and(fits) {
            scene.meshes.push(Mesh {
                name: format!("faces from {}:{}", location.file.display(), location.line),
                material: facet.material,
                texture_frame: facet.frame,
                uv_projection: facet.round,
                displacement: facet.displacement.clone(),
                ..Mesh::default()
            });
            self.meshes.push(Run {
                mesh: scene.meshes.len() - 1,
                closed: false,
                lit: facet.lit,
                frame: facet.frame,
                round: facet.round,
                skin: facet.skin.clone(),
                sources: Vec::new(),
                known: HashMap::new(),
            });
        }
        let mirrored = facet
            .corners
            .iter()
            .all(|&(vertex, _)| self.vertices[vertex as usize].mirrored);
        let (Some(run), Some(mesh)) = (self.meshes.last_mut(), scene.meshes.last_mut()) else {
            return;
        };
        let corners: Vec<u32> = facet
            .corners
            .iter()
            .map(|&(vertex, uv)| {
                *run.known
                    .entry((vertex, uv.map(f32::to_bits)))
                    .or_insert_with(|| {
                        mesh.positions
                            .push(self.vertices[vertex as usize].position.as_vec3().to_array());
                        if facet.has_uv {
                            mesh.uvs.push(uv);
                        }
                        run.sources.push(vertex);
                        run.sources.len() as u32 - 1
                    })
            })
            .collect();
        for (k, pair) in corners[1..].windows(2).enumerate() {
            // A mirror reverses the turn of the corners; the front stays the front.
            let [a, b] = if mirrored { [1, 0] } else { [0, 1] }.map(|k| pair[k]);
            mesh.triangles.push([corners[0], a, b]);
            mesh.faces.push(facet.number);
            if facet.lit {
                self.add_normal(facet.corners, k, mirrored);
            }
        }
    }

    /// World position of a vertex of the file.
    fn position(&self, vertex: u32) -> DVec3 {
        self.vertices[vertex as usize].position
    }

    /// The course's rule: corners 0 and 1 of a face take the area normal of its first triangle, each later corner that
    /// of the triangle which it closes.
    fn add_normal(&mut self, corners: &[(u32, [f32; 2])], k: usize, mirrored: bool) {
        let [first, a, b] = [0, k + 1, k + 2].map(|i| corners[i].0);
        let [p, q, r] = [first, a, b].map(|i| self.position(i));
        let area = (q - p).cross(r - p) * if mirrored { -1.0 } else { 1.0 };
        let takers = [Some(b), (k == 0).then_some(first), (k == 0).then_some(a)];
        for vertex in takers.into_iter().flatten() {
            let [sum, first] = &mut self.normals[vertex as usize];
            *sum += area;
            if *first == DVec3::ZERO {
                *first = area;
            }
        }
    }

    /// Gives every lit mesh its normals, and those that follow bones to the bones; call it when all faces of the file are known.
    pub(super) fn finish(self, scene: &mut Scene, bones: &mut Bones) {
        for run in &self.meshes {
            bones.follow(run.mesh, run.skin.clone());
        }
        for run in self.meshes.iter().filter(|run| run.lit) {
            let normal = |&source: &u32| {
                let [sum, first] = self.normals[source as usize];
                // Two faces back to back cancel out: the first decides.
                let small = sum.length_squared() <= 1e-24 * first.length_squared();
                let normal = if small { unit(first) } else { unit(sum) };
                normal.unwrap_or(DVec3::Z).as_vec3().to_array()
            };
            scene.meshes[run.mesh].normals = run.sources.iter().map(normal).collect();
        }
    }

    /// The angle or distance of a frame from the plane of a face, in words, if it is not 0. Such a picture moves over the face with the
    /// eye.
    pub(super) fn out_of_plane(
        &self,
        corners: &[(u32, [f32; 2])],
        frame: &TextureFrame,
    ) -> Option<String> {
        let points: Vec<DVec3> = corners.iter().map(|&(i, _)| self.position(i)).collect();
        let area: DVec3 = points[1..]
            .windows(2)
            .map(|w| (w[0] - points[0]).cross(w[1] - points[0]))
            .sum();
        let (face, plane) = (unit(area)?, unit(frame.normal())?);
        let angle = deterministic_f64::atan2(face.cross(plane).length(), face.dot(plane).abs())
            .to_degrees();
        if angle > 1e-4 {
            return Some(format!("{angle:.4} degrees out of the plane of the face"));
        }
        let size = points
            .iter()
            .fold(0.0_f64, |s, p| s.max((*p - points[0]).length()));
        let distance = points
            .iter()
            .fold(0.0_f64, |d, p| d.max((*p - frame.o).dot(plane).abs()));
        (distance > 1e-6 * size).then(|| format!("{distance} units beside the plane of the face"))
    }
}
