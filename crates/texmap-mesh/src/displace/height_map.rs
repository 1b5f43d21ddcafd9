//! Height maps of displaced meshes: the length of edges in texels or pixels, and the distance that a vertex rises.

use std::collections::HashMap;

use texmap_math::glam::{DMat4, DVec3};
use texmap_math::{MemoryBudget, OverBudget, deterministic_f32};
use texmap_sample::{Filter, Sampler, Texture2d};
use texmap_scene::{EdgeBudget, Scene};

use crate::refine::{Net, Vertex};

/// A displacement with what it is measured by.
pub(super) struct HeightMap {
    texture: Texture2d<'static>,
    sampler: Sampler,
    /// Coordinates of the mesh to those of the map.
    rows: [[f32; 3]; 2],
    height: f64,
    middle: f64,
    budget: EdgeBudget,
    pub(super) limit: u32,
    world_from_object: DMat4,
    /// `None` in a parallel projection.
    eye: Option<DVec3>,
    /// Pixels that a line of length 1 at distance 1 covers.
    pixels: f64,
}

impl HeightMap {
    /// Of each of these meshes of a scene, for a picture of `width` pixels; `None` of one that rests. Meshes that read one texture
    /// share its texels and its mip levels.
    pub(super) fn of_meshes(
        scene: &Scene,
        meshes: &[usize],
        width: u32,
        memory: MemoryBudget,
    ) -> Result<Vec<Option<Self>>, OverBudget> {
        let mut levels = Levels {
            scene,
            memory,
            made: HashMap::new(),
        };
        let maps = meshes
            .iter()
            .map(|&mesh| Self::new(&mut levels, mesh, width));
        maps.collect()
    }

    fn new(levels: &mut Levels<'_>, mesh: usize, width: u32) -> Result<Option<Self>, OverBudget> {
        let mesh = &levels.scene.meshes[mesh];
        let Some(displacement) = &mesh.displacement else {
            return Ok(None);
        };
        let slot = &displacement.slot;
        let texture = levels.texture(slot.texture, slot.sampler.filter, &mesh.name)?;
        let camera = &levels.scene.camera;
        let parallel = camera.lens.parallel_width.is_some();
        Ok(Some(Self {
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
        }))
    }

    fn place(&self, uv: [f32; 2]) -> [f32; 2] {
        self.rows.map(|[a, b, c]| a * uv[0] + b * uv[1] + c)
    }

    /// Squared length of an edge in texels of level 0.
    pub(super) fn texels_squared(&self, a: &Vertex, b: &Vertex) -> f64 {
        let [p, q] = [a, b].map(|v| self.place(v.uv).map(f64::from));
        let x = (q[0] - p[0]) * f64::from(self.texture.width());
        let y = (q[1] - p[1]) * f64::from(self.texture.height());
        x * x + y * y
    }

    pub(super) fn too_long(&self, net: &Net, a: &Vertex, b: &Vertex) -> bool {
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
    pub(super) fn rise(&self, vertex: &Vertex, spacing: f64) -> f64 {
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

/// Textures of a scene with their mip levels, each made when the first mesh reads it: a copy for every mesh would take as much memory
/// as meshes times texels.
struct Levels<'s> {
    scene: &'s Scene,
    memory: MemoryBudget,
    /// By their index in the scene.
    made: HashMap<usize, Texture2d<'static>>,
}

impl Levels<'_> {
    /// A texture with all that a filter reads of it; `mesh` is for the error only.
    fn texture(
        &mut self,
        index: usize,
        filter: Filter,
        mesh: &str,
    ) -> Result<Texture2d<'static>, OverBudget> {
        let texture = &self.scene.textures[index];
        // A summed area is trilinear on a texture without its table.
        let reads_levels = filter.reads_mips() || filter.reads_summed_area();
        if texture.levels() > 1 || !reads_levels {
            return Ok(texture.clone());
        }
        if let Some(made) = self.made.get(&index) {
            return Ok(made.clone());
        }
        self.memory.ask(
            texture.bytes_to_prepare(Filter::Trilinear),
            format_args!(
                "the mip levels of the height map of mesh '{mesh}', {} x {} texels",
                texture.width(),
                texture.height()
            ),
            "take a smaller map, or a filter that reads one level",
        )?;
        let made = texture.clone().with_mips();
        self.made.insert(index, made.clone());
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use texmap_math::Camera;
    use texmap_sample::{ColorSpace, Origin};
    use texmap_scene::{Displacement, Material, Mesh, TextureSlot};

    use super::*;

    /// Side of a map with levels that are large enough to be asked for.
    const SIDE: u32 = 2048;

    fn scene(filter: Filter, meshes: usize) -> Scene {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]));
        scene.materials = vec![Material::default()];
        let bytes = vec![99; (4 * SIDE * SIDE) as usize];
        let (space, origin) = (ColorSpace::Linear, Origin::TopLeft);
        scene.textures = vec![Texture2d::from_rgba8(SIDE, SIDE, bytes, space, origin).unwrap()];
        let mut slot = TextureSlot::new(0);
        slot.sampler.filter = filter;
        let origin = |i| [Origin::TopLeft, Origin::BottomLeft][i % 2];
        let mesh = |i| Mesh {
            displacement: (i > 0).then(|| Displacement::new(slot.clone(), 0.1)),
            uv_origin: origin(i),
            ..Mesh::default()
        };
        scene.meshes = (0..=meshes).map(mesh).collect();
        scene
    }

    /// Levels of each mesh's map.
    fn levels(scene: &Scene, memory: MemoryBudget) -> Result<Vec<Option<u32>>, OverBudget> {
        let meshes: Vec<usize> = (0..scene.meshes.len()).collect();
        let maps = HeightMap::of_meshes(scene, &meshes, 64, memory)?;
        let levels = |map: &Option<HeightMap>| map.as_ref().map(|map| map.texture.levels());
        Ok(maps.iter().map(levels).collect())
    }

    #[test]
    fn meshes_of_one_texture_ask_for_its_levels_once() {
        static ASKED: AtomicU64 = AtomicU64::new(0);
        let counted = |limit| {
            MemoryBudget::measured(limit, || {
                ASKED.fetch_add(1, Ordering::Relaxed);
                0
            })
        };
        let mut scene = scene(Filter::Trilinear, 20);
        assert_eq!(
            levels(&scene, counted(u64::MAX)).unwrap()[..3],
            [None, Some(12), Some(12)]
        );
        assert_eq!(ASKED.load(Ordering::Relaxed), 1);
        // The negative twin: another texture has levels of its own.
        scene.textures.push(scene.textures[0].clone());
        for mesh in &mut scene.meshes[15..] {
            mesh.displacement.as_mut().unwrap().slot.texture = 1;
        }
        levels(&scene, counted(u64::MAX)).unwrap();
        assert_eq!(ASKED.load(Ordering::Relaxed), 3);
        let refused = levels(&scene, counted(1 << 20)).unwrap_err();
        assert!(refused.what.contains("2048 x 2048"), "{refused}");
    }

    #[test]
    fn filters_of_one_level_ask_for_nothing() {
        let none = MemoryBudget::new(0);
        let read = levels(&scene(Filter::Bilinear, 2), none);
        assert_eq!(read.unwrap(), [None, Some(1), Some(1)]);
        assert!(levels(&scene(Filter::SummedArea, 2), none).is_err());
    }
}
