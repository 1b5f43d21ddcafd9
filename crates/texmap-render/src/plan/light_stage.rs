//! The choice of a lighting stage, and the attributes that it reads.

use texmap_light::Light;

use crate::vertices::{Values, Vertices};
use texmap_scene::{Material, Shading, VertexColorInterp};
use texmap_shade::lighting::LightStage;

pub(super) fn light_stage(
    material: &Material,
    shows_surface: bool,
    has_texel: bool,
    vertices: &mut Vertices,
) -> LightStage {
    let screen = material.vertex_color_interp == VertexColorInterp::ScreenLinear;
    match material.shading {
        Shading::PerPixel if shows_surface => LightStage::PerPixel,
        // A texel multiplies the diffuse term only; without one, colours are finished at the vertices.
        Shading::PerVertex if has_texel => {
            let diffuse = vertices.push(Values::Diffuse, screen);
            let shiny = material.phong.ks > 0.0;
            let highlight = shiny.then(|| vertices.push(Values::Highlight, screen));
            LightStage::Terms { diffuse, highlight }
        }
        Shading::PerVertex if shows_surface => {
            LightStage::Colors(vertices.push(Values::Lit, screen))
        }
        _ => LightStage::None,
    }
}

/// True if light differs between points of one normal.
pub(super) fn lights_depend_on_place(lights: &[Light], material: &Material) -> bool {
    lights.iter().any(|light| match light {
        Light::Ambient { .. } => false,
        Light::Directional { .. } => material.phong.ks > 0.0,
        _ => true,
    })
}
