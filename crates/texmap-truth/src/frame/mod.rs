//! A whole frame in f64: what the renderer must draw, computed without any of its code paths.
//!
//! One ray for each sample meets the triangles through a tree of boxes ([`crate::rays`]); coordinates, colours, normals and positions come
//! from its barycentrics ([`crate::caster`]), texels from `texmap_sample::reference`, light from its definition, shadows from hard
//! rays. Each effect is a file of its own, from the formula that the scene types and the scene language give for it. Nothing is
//! snapped, clipped or binned. The interpolation that a material names is not followed: the truth is perspective.
//!
//! [`ASSUMPTIONS`] says what is taken for true without being derived.

mod backdrop;
mod bump;
mod carving;
mod color;
mod emission;
mod environment;
mod grid;
mod lighting;
mod metallic;
mod pattern;
mod projector;

mod shadow;
mod slot;

mod space;
mod surface;
mod tangents;
mod visible;
mod volume;
mod world;

use texmap_math::glam::{DVec3, DVec4};
use texmap_math::parallel;
use texmap_scene::{ColorMode, Mesh, Scene, Shading};

use crate::TruthError;
use crate::picture::Picture;
use color::encode;
pub(crate) use color::wide;
use visible::Visible;
use world::World;

/// Assumptions of the reference that are not derived.
pub const ASSUMPTIONS: &str = "perspective coordinates, bilinear texels, hard shadows by rays, environments and specular maps as their \
     texels are, environment light as its prefiltered levels are (even within each lobe) and its shadows as their maps are, displaced meshes and billboards as the triangles that are drawn, light that is clipped at white in each sample";

/// A frame computed in f64.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Premultiplied linear light (raw values under [`ColorMode::Raw`]), rows top to bottom.
    pub color: Vec<DVec4>,
    /// Mesh and triangle of the nearest opaque or cut-out surface at the centre of each pixel.
    pub seen: Vec<Option<(usize, u32)>>,
    /// The mesh that is drawn last at the centre of each pixel, blended ones too.
    pub top: Vec<Option<usize>>,
    /// A number for the meshes that are drawn over each other at the centre of each pixel: where neighbours have another, an outline
    /// runs between them.
    pub layers: Vec<u64>,
    /// Pixels beside whose centre the edge of a shadow lies: within a texel more than the PCF comparisons of its map, or within
    /// the pixel.
    pub shadow_edges: Vec<bool>,
    /// Pixels in which some sample sees more than a background of one colour.
    pub drawn: Vec<bool>,
    mode: ColorMode,
}

/// One pixel of the truth.
#[derive(Default)]
struct Pixel {
    color: DVec4,
    centre: Visible,
    shadow_edge: bool,
    drawn: bool,
}

impl Truth {
    /// The picture in 8-bit code values without rounding: straight alpha, sRGB (or raw), each 0..=255.
    pub fn codes(&self) -> Vec<f64> {
        let code = |c: f64| match self.mode {
            ColorMode::Srgb => encode(c),
            ColorMode::Raw => c,
        };
        let pixel = |p: &DVec4| {
            let straight = if p.w > 0.0 {
                p.truncate() / p.w
            } else {
                DVec3::ZERO
            };
            [code(straight.x), code(straight.y), code(straight.z), p.w]
                .map(|c| c.clamp(0.0, 1.0) * 255.0)
        };
        self.color.iter().flat_map(pixel).collect()
    }

    /// The picture rounded to bytes.
    pub fn picture(&self) -> Picture {
        let bytes = self
            .codes()
            .into_iter()
            .map(|c| (c + 0.5).floor() as u8)
            .collect();
        Picture::from_rgba(self.width, self.height, bytes)
            .unwrap_or_else(|| Picture::new(self.width, self.height, [0; 4]))
    }
}

/// Refuses what would be drawn wrongly.
fn known(scene: &Scene, traces: bool) -> Result<(), TruthError> {
    if scene.effects.tone_mapping.is_identity() {
        return Ok(());
    }
    let unsupported = |place: String, what| Err(TruthError::Unsupported { place, what });
    if traces {
        // Light in a mirror would be mapped twice.
        let place = "scene".to_owned();
        return unsupported(place, "exposure or tone mapping in mirrors");
    }
    let mut used = scene
        .meshes
        .iter()
        .map(|mesh| &scene.materials[mesh.material]);
    match used.find(|material| material.shading == Shading::PerVertex) {
        None => Ok(()),
        Some(material) => unsupported(
            format!("material '{}'", material.name),
            "exposure or tone mapping of light at the vertices",
        ),
    }
}

/// Computes a frame with `samples` x `samples` samples a pixel, on all threads of rayon's pool. The result does not depend on their
/// number. Displaced meshes and billboards are taken as the triangles that [`texmap_mesh::tessellate`] makes of them.
///
/// # Errors
/// If the scene does not pass its own check; [`TruthError::Unsupported`] for tone mapping of surfaces that are lit at their vertices.
pub fn frame(scene: &Scene, width: u32, height: u32, samples: u32) -> Result<Truth, TruthError> {
    computed(scene, (width, height), samples, false)
}

/// As [`frame`], but mirrors (materials with a reflection) show what their rays meet: one bounce, after which mirrors show their
/// environments. The light that a ray meets ends at 1, as that of surfaces does.
///
/// # Errors
/// As [`frame`], and for any tone mapping.
pub fn frame_by_rays(
    scene: &Scene,
    width: u32,
    height: u32,
    samples: u32,
) -> Result<Truth, TruthError> {
    computed(scene, (width, height), samples, true)
}

fn computed(
    scene: &Scene,
    (width, height): (u32, u32),
    samples: u32,
    traces: bool,
) -> Result<Truth, TruthError> {
    scene.check()?;
    known(scene, traces)?;
    let scene = &*texmap_mesh::tessellate(scene, width)?;
    let samples = samples.max(1);
    let mut world = World::new(scene, (width, height), samples)?;
    world.traces = traces;
    let mut pixels = Vec::new();
    pixels.resize_with(width as usize * height as usize, Pixel::default);
    let rows = pixels.chunks_mut(width.max(1) as usize).zip(0..height);
    parallel::for_each(rows, |(row, y)| {
        for (place, x) in row.iter_mut().zip(0..) {
            *place = pixel(&world, x, y, samples);
        }
    });
    let layers = |pixel: &Pixel| {
        let blended = pixel.centre.blended.iter().map(|(owner, _)| owner.0);
        let solid = pixel.centre.solid.map(|(owner, _)| owner.0);
        let mut meshes: Vec<usize> = solid.into_iter().chain(blended).collect();
        meshes.dedup();
        // FNV-1a over the numbers.
        meshes
            .iter()
            .fold(0xcbf2_9ce4_8422_2325, |hash: u64, mesh| {
                (hash ^ (*mesh as u64 + 1)).wrapping_mul(0x0100_0000_01b3)
            })
    };
    let top = |pixel: &Pixel| {
        let centre = &pixel.centre;
        let top = centre.blended.last().or(centre.solid.as_ref());
        top.map(|(owner, _)| owner.0)
    };
    Ok(Truth {
        width,
        height,
        color: pixels.iter().map(|p| p.color).collect(),
        seen: pixels
            .iter()
            .map(|p| p.centre.solid.map(|(owner, _)| owner))
            .collect(),
        top: pixels.iter().map(top).collect(),
        layers: pixels.iter().map(layers).collect(),
        shadow_edges: pixels.iter().map(|p| p.shadow_edge).collect(),
        drawn: pixels.iter().map(|p| p.drawn).collect(),
        mode: scene.color,
    })
}

fn pixel(world: &World<'_>, x: u32, y: u32, samples: u32) -> Pixel {
    let corner = [x, y].map(|c| f64::from(c * samples));
    let mut pixel = Pixel::default();
    for j in 0..samples {
        for i in 0..samples {
            let (x, y) = (
                corner[0] + f64::from(i) + 0.5,
                corner[1] + f64::from(j) + 0.5,
            );
            let visible = world.look(x, y);
            let (color, mixed) = world.color(&visible, x, y);
            pixel.color += color;
            pixel.drawn |= mixed || visible.solid.is_some() || world.behind.has_sky();
        }
    }
    pixel.color /= f64::from(samples * samples);
    // An even number of samples has none at the centre.
    let [x, y] = corner.map(|c| c + 0.5 * f64::from(samples));
    pixel.centre = world.look(x, y);
    pixel.shadow_edge = world.at_an_edge(&pixel.centre, samples, x, y);
    pixel
}

/// The world positions of a mesh's vertices.
pub(crate) fn world(mesh: &Mesh) -> Vec<DVec3> {
    mesh.world_positions().collect()
}
