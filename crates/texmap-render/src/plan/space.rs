//! Surfaces that stand for no mesh: the frame behind everything, and the far sides of the boxes of volumes.

use std::sync::LazyLock;

use texmap_math::glam::DMat4;
use texmap_raster::{Cull, DepthTest};

use super::Surface;
use crate::vertices::VertexData;
use texmap_scene::{AlphaMode, Material, Mesh, Shading, TextureRole, Volume};

/// The frame in clip space, at no depth.
static FRAME: LazyLock<Mesh> = LazyLock::new(|| Mesh {
    name: "backdrop".into(),
    positions: vec![
        [-1.0, 1.0, 0.0],
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
    ],
    uvs: vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]],
    triangles: vec![[0, 1, 2], [0, 2, 3]],
    ..Mesh::default()
});

static SKY_MATERIAL: LazyLock<Material> = LazyLock::new(|| Material {
    name: "backdrop".into(),
    shading: Shading::Unlit,
    texture_role: TextureRole::Decal,
    // Blended surfaces are drawn where nothing nearer is, and leave the arrays alone.
    alpha: AlphaMode::Blend,
    ..Material::default()
});

/// A surface over the whole frame, behind all others. It still lacks its color.
pub(crate) fn behind<'s>() -> Surface<'s> {
    let mesh = &*FRAME;
    let vertices = VertexData::of(mesh, mesh.uvs.as_flattened().to_vec(), 2);
    Surface::bare(
        mesh,
        &SKY_MATERIAL,
        vertices,
        DMat4::IDENTITY,
        DepthTest::LessOrEqual,
    )
}

/// The unit cube, fronts outwards.
static CUBE: LazyLock<Mesh> = LazyLock::new(|| Mesh {
    name: "volume".into(),
    positions: (0..8u8)
        .map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f32::from))
        .collect(),
    triangles: [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ]
    .into_iter()
    .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
    .collect(),
    ..Mesh::default()
});

static VOLUME_MATERIAL: LazyLock<Material> = LazyLock::new(|| Material {
    name: "volume".into(),
    shading: Shading::Unlit,
    alpha: AlphaMode::Blend,
    // The far sides cover the pixels of the box, also for an eye inside of it.
    cull: Cull::Front,
    ..Material::default()
});

/// The far sides of a volume's box, drawn behind all surfaces. They still lack their stage.
pub(crate) fn far_sides<'s>(volume: &Volume, clip_from_world: DMat4) -> Surface<'s> {
    let mesh = &*CUBE;
    let mut vertices = VertexData::of(mesh, Vec::new(), 0);
    if volume.world_from_volume.determinant() < 0.0 {
        vertices
            .triangles
            .to_mut()
            .iter_mut()
            .for_each(|t| t.swap(1, 2));
    }
    Surface::bare(
        mesh,
        &VOLUME_MATERIAL,
        vertices,
        clip_from_world * volume.world_from_volume,
        DepthTest::Always,
    )
}
