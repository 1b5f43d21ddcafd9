//! Where the light of a surface comes from: its vertices, its pixels, or nowhere.

use texmap_light::Light;

use crate::vertices::{Values, Vertices};
use texmap_scene::{Gouraud, Material, Shading};

/// The lighting stage of a surface; numbers are attribute indices.
pub(crate) enum LightStage {
    /// The base colour is the colour.
    None,
    /// Finished colours at the vertices: the base colour is in them.
    Colors(usize),
    /// Terms at the vertices (vertex colours in the diffuse one), a texel between them.
    Terms {
        diffuse: usize,
        highlight: Option<usize>,
    },
    /// Computed per pixel.
    PerPixel,
}

pub(super) fn light_stage(
    material: &Material,
    shows_surface: bool,
    has_texel: bool,
    vertices: &mut Vertices,
) -> LightStage {
    let screen = material.gouraud == Gouraud::ScreenLinear;
    match material.shading {
        Shading::PerPixel if shows_surface => LightStage::PerPixel,
        // A texel multiplies the diffuse term only; without one, colours are finished at the vertices.
        Shading::PerVertex if has_texel => {
            let diffuse = vertices.push(Values::Diffuse, screen);
            let shiny = material.surface.ks > 0.0;
            let highlight = shiny.then(|| vertices.push(Values::Highlight, screen));
            LightStage::Terms { diffuse, highlight }
        }
        Shading::PerVertex if shows_surface => {
            LightStage::Colors(vertices.push(Values::Lit, screen))
        }
        _ => LightStage::None,
    }
}

/// Whether light differs between points of one normal.
pub(super) fn lights_depend_on_place(lights: &[Light], material: &Material) -> bool {
    lights.iter().any(|light| match light {
        Light::Ambient { .. } => false,
        Light::Directional { .. } => material.surface.ks > 0.0,
        _ => true,
    })
}
