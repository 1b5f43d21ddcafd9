//! Coordinates as euc and retrofire interpolate them, pixel by pixel.

use std::cell::RefCell;

use euc::Target as _;
use euc::buffer::Buffer2d;
use retrofire_core::math::rgba;
use texmap_lab::scenes::UvImage;
use texmap_math::glam::DVec2;
use texmap_scene::Scene;

use crate::registry::{Given, Outcome, Place, RetrofireMesh, draw_euc};

struct Places<'g>(&'g Given);

impl euc::Pipeline for Places<'_> {
    type Vertex = u32;
    type VsOut = Place;
    type Pixel = Option<[f32; 2]>;

    fn vert(&self, vertex: &u32) -> ([f32; 4], Place) {
        let (position, uv) = self.0.vertices[*vertex as usize];
        (self.0.clip(position), Place(uv))
    }

    fn frag(&self, Place(uv): &Place) -> Option<[f32; 2]> {
        Some(*uv)
    }
}

/// Of the first mesh.
pub(crate) fn by_euc(scene: &Scene, size: [u32; 2]) -> Outcome<UvImage> {
    let given = Given::new(scene, size)?;
    let size = size.map(|c| c as usize);
    let (mut color, mut depth) = (Buffer2d::new(size, None), Buffer2d::new(size, 1.0));
    depth.clear(1.0);
    draw_euc(&Places(&given), &given, &mut color, &mut depth);
    let wide = |[u, v]: [f32; 2]| DVec2::new(f64::from(u), f64::from(v));
    Ok(color.as_ref().iter().map(|uv| uv.map(wide)).collect())
}

/// Of the first mesh.
pub(crate) fn by_retrofire(scene: &Scene, size: [u32; 2]) -> Outcome<UvImage> {
    let made = RetrofireMesh::new(Given::new(scene, size)?);
    let image = RefCell::new(vec![None; (size[0] * size[1]) as usize]);
    made.draw(&mut made.target(), |frag| {
        // The centre of the pixel, up to rounding.
        let [x, y] = [frag.pos.x(), frag.pos.y()].map(|c| c.floor() as usize);
        let uv = DVec2::new(f64::from(frag.var.u()), f64::from(frag.var.v()));
        image.borrow_mut()[y * size[0] as usize + x] = Some(uv);
        rgba(0, 0, 0, 255)
    });
    Ok(image.into_inner())
}
