//! The benchmark scenes: the yardstick for speed, drawn alike by texmap and by its peers.
//!
//! Colour target 1920 x 1080 RGBA8 cleared to (0.1, 0.2, 0.3, 1), depth cleared to the far plane,
//! test LESS. Each row with colours exists twice: raw, no sRGB anywhere, and sRGB, where pictures are decoded, filtered and blended as
//! light, and encoded into the target. Depth scenes draw into a 2048 x 2048 depth target. Window y is up
//! in clip space; row 0 of a picture is its top.

mod geometry;
mod lit;
mod matrices;
mod scene;
mod textures;

pub use geometry::{BenchMesh, HEIGHT, WIDTH, floor, layers, rects, sphere};
pub use lit::{
    LIGHT_AREA, METALLIC, METALLIC_LIGHT, METALLIC_LIGHTS, METALLIC_SUN, MIDDLE, ROUGHNESS,
    SHADOW_BIAS, light_matrix, lit_matrix, lit_meshes, metallic_environment, slide_matrix, turn,
};
pub use matrices::GlMatrix;
pub use scene::Hidden;
use texmap_scene::ColorMode;
pub use textures::{
    BASE_SIZE, FACE_SIZE, base, cube_face, hash, mip_chain, mip_chain_srgb, normal, slide,
};

/// Side of the depth target of the depth scenes and of the shadow map.
pub const DEPTH_SIZE: u32 = 2048;
/// The colour that every scene is cleared to.
pub const CLEAR: [f32; 4] = [0.1, 0.2, 0.3, 1.0];
/// The constant colour of `fill flat`.
pub const FLAT: [f32; 4] = [0.2, 0.4, 0.6, 1.0];
/// Eye of the scenes `lit` and `projective`; it looks at (0, 0.8, 0).
pub const LIT_EYE: [f64; 3] = [2.5, 2.2, 4.0];
/// Position of the light of `lit`.
pub const LIGHT: [f64; 3] = [3.0, 6.0, 3.0];
/// Position of the projector of `projective`.
pub const PROJECTOR: [f64; 3] = [-3.0, 5.0, 3.0];

/// Texture look-up of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lookup {
    /// No texture.
    None,
    /// A constant colour.
    Flat,
    /// Nearest texel of level 0.
    Nearest,
    /// Bilinear in level 0.
    Bilinear,
    /// Trilinear.
    Trilinear,
    /// Trilinear with anisotropy 16.
    Aniso16,
}

/// Content of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Clears only.
    Clear,
    /// The large floor.
    Floor,
    /// Eight full-screen layers, back to front; with or without blending (alpha 0.5) and depth.
    Layers {
        /// Alpha 0.5 over what is there.
        blend: bool,
        /// A depth buffer is tested and written.
        depth: bool,
    },
    /// The sphere of so many thousand triangles, back faces culled, with so many samples.
    Sphere {
        /// 20, 200 or 2000.
        thousands: u32,
        /// 1 or 4.
        samples: u32,
    },
    /// The sphere into the depth target.
    Depth {
        /// 200 or 2000.
        thousands: u32,
    },
    /// The sphere of 200 thousand triangles over a floor, under a light with a shadow map of the sphere.
    Lit {
        /// The map is drawn with each frame.
        shadow_pass: bool,
    },
    /// The sphere of 200 thousand triangles as a mirror.
    Mirror,
    /// Sphere and floor of `Lit` under a projector.
    Projective,
    /// The sphere of 200 thousand triangles, half metal, under a prefiltered environment and two lights.
    Metallic,
}

/// One row of the race.
#[derive(Clone, Copy, Debug)]
pub struct BenchScene {
    /// Scene name as in the table.
    pub name: &'static str,
    /// Filter name as in the table.
    pub filter: &'static str,
    /// The content.
    pub content: Content,
    /// The texture look-up.
    pub lookup: Lookup,
    /// Decoding and encoding of colours.
    pub color: ColorMode,
    /// True if a ratio to the peer is promised.
    pub has_goal: bool,
}

impl BenchScene {
    /// `name,filter,color`: the key that `--only` selects by substring.
    #[must_use]
    pub fn key(&self) -> String {
        format!("{},{},{}", self.name, self.filter, self.color_name())
    }

    /// `raw` or `srgb`.
    #[must_use]
    pub fn color_name(&self) -> &'static str {
        match self.color {
            ColorMode::Raw => "raw",
            ColorMode::Srgb => "srgb",
        }
    }

    /// Width and height of the target.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        match self.content {
            Content::Depth { .. } => (DEPTH_SIZE, DEPTH_SIZE),
            _ => (WIDTH, HEIGHT),
        }
    }

    /// Object (for scenes of several meshes, world) to GL clip space.
    #[must_use]
    pub fn matrix(&self) -> GlMatrix {
        let model = turn();
        match self.content {
            Content::Lit { .. } | Content::Projective => lit_matrix(),
            Content::Clear | Content::Layers { .. } => GlMatrix::IDENTITY,
            Content::Floor => {
                GlMatrix::perspective(60.0, f64::from(WIDTH) / f64::from(HEIGHT), 0.1, 300.0)
                    .then_after(&GlMatrix::look_at([0.0, 2.0, 8.0], [0.0, 0.0, 2.0]))
            }
            Content::Sphere { .. } | Content::Mirror | Content::Metallic => {
                GlMatrix::perspective(60.0, f64::from(WIDTH) / f64::from(HEIGHT), 0.1, 100.0)
                    .then_after(&GlMatrix::look_at([0.0, 0.0, 1.7344], [0.0; 3]))
                    .then_after(&model)
            }
            Content::Depth { .. } => GlMatrix::orthographic(1.1442, 1.1442, 0.5, 4.0)
                .then_after(&GlMatrix::look_at([0.0, 0.0, 2.0], [0.0; 3]))
                .then_after(&model),
        }
    }

    /// The mesh that the scene draws. Empty for `clear`, the sphere where there is a floor too ([`lit_meshes`]).
    #[must_use]
    pub fn mesh(&self) -> BenchMesh {
        match self.content {
            Content::Clear => BenchMesh::default(),
            Content::Floor => floor(200.0, 1.0 / 8.0),
            Content::Layers { .. } => layers(),
            Content::Lit { .. } | Content::Mirror | Content::Projective | Content::Metallic => {
                sphere(448, 224)
            }
            Content::Sphere { thousands, .. } | Content::Depth { thousands } => match thousands {
                20 => sphere(142, 71),
                200 => sphere(448, 224),
                _ => sphere(1416, 708),
            },
        }
    }

    /// True if back faces are culled.
    #[must_use]
    pub fn culls_back_faces(&self) -> bool {
        !matches!(
            self.content,
            Content::Clear | Content::Floor | Content::Layers { .. }
        )
    }
}

/// The scenes, in the order of the table: the raw rows, then those of them that have colours in sRGB.
pub const SCENES: &[BenchScene] = &{
    let mut all = [RAW[0]; 2 * RAW.len() - DEPTH_ROWS];
    let (mut i, mut count) = (0, RAW.len());
    while i < RAW.len() {
        all[i] = RAW[i];
        if !matches!(RAW[i].content, Content::Depth { .. }) {
            all[count] = BenchScene {
                color: ColorMode::Srgb,
                ..RAW[i]
            };
            count += 1;
        }
        i += 1;
    }
    all
};

const DEPTH_ROWS: usize = 2;

const RAW: [BenchScene; 24] = {
    const fn row(
        name: &'static str,
        filter: &'static str,
        content: Content,
        lookup: Lookup,
    ) -> BenchScene {
        BenchScene {
            name,
            filter,
            content,
            lookup,
            color: ColorMode::Raw,
            has_goal: !matches!(content, Content::Clear),
        }
    }
    const fn fill(blend: bool, depth: bool) -> Content {
        Content::Layers { blend, depth }
    }
    const fn ball(thousands: u32, samples: u32) -> Content {
        Content::Sphere { thousands, samples }
    }
    const fn lit(shadow_pass: bool) -> Content {
        Content::Lit { shadow_pass }
    }
    use Lookup::{Aniso16, Bilinear, Flat, Nearest, Trilinear};
    [
        row("clear", "none", Content::Clear, Lookup::None),
        row("floor", "nearest", Content::Floor, Nearest),
        row("floor", "bilinear", Content::Floor, Bilinear),
        row("floor", "trilinear", Content::Floor, Trilinear),
        row("floor", "aniso16", Content::Floor, Aniso16),
        row("fill", "flat", fill(false, true), Flat),
        row("fill", "nearest", fill(false, true), Nearest),
        row("fill", "bilinear", fill(false, true), Bilinear),
        row("fill", "trilinear", fill(false, true), Trilinear),
        row("fill_blend", "bilinear", fill(true, true), Bilinear),
        row("fill_nodepth", "bilinear", fill(false, false), Bilinear),
        row(
            "fill_blend_nodepth",
            "bilinear",
            fill(true, false),
            Bilinear,
        ),
        row("mesh20k", "trilinear", ball(20, 1), Trilinear),
        row("mesh200k", "trilinear", ball(200, 1), Trilinear),
        row("mesh2m", "trilinear", ball(2000, 1), Trilinear),
        row(
            "depth200k",
            "none",
            Content::Depth { thousands: 200 },
            Lookup::None,
        ),
        row(
            "depth2m",
            "none",
            Content::Depth { thousands: 2000 },
            Lookup::None,
        ),
        row("msaa4_200k", "trilinear", ball(200, 4), Trilinear),
        row("msaa4_2m", "trilinear", ball(2000, 4), Trilinear),
        row("lit", "pcf9-nearest", lit(false), Trilinear),
        row("lit+shadowpass", "pcf9-nearest", lit(true), Trilinear),
        row("env", "seamless", Content::Mirror, Lookup::None),
        row("projective", "trilinear", Content::Projective, Trilinear),
        row("pbr", "trilinear", Content::Metallic, Trilinear),
    ]
};
