//! View rays: the rays of a camera through a grid of samples, and texture frames seen along them.

use glam::DVec3;

use crate::{Footprint, PlanarTexgen, TextureFrame};

/// The rays of a grid of samples, camera space.
#[derive(Clone, Copy, Debug)]
pub struct ViewRays {
    /// Half the step of a ray from sample to sample.
    half_step: [f64; 2],
    /// Samples.
    size: [f64; 2],
}

impl ViewRays {
    /// `half` is half the width and height of the picture at distance 1, `size` its samples.
    #[must_use]
    pub fn new(half: [f64; 2], size: [f64; 2]) -> Self {
        Self {
            half_step: [half[0] / size[0], half[1] / size[1]],
            size,
        }
    }

    /// The ray through the centre of a sample; z = -1.
    #[must_use]
    pub fn through(&self, [x, y]: [u32; 2]) -> DVec3 {
        let right = 2.0 * f64::from(x) + 1.0 - self.size[0];
        let up = self.size[1] - 2.0 * f64::from(y) - 1.0;
        DVec3::new(right * self.half_step[0], up * self.half_step[1], -1.0)
    }

    /// Half the step from sample to sample, across and down, at distance 1.
    #[must_use]
    pub fn half_step(&self) -> [f64; 2] {
        self.half_step
    }

    /// Width and height in samples.
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        self.size
    }

    /// The step from sample to sample across, at distance 1.
    #[must_use]
    pub fn step(&self) -> f64 {
        2.0 * self.half_step[0]
    }
}

/// A texture frame in camera space and the rays of a grid of samples.
#[derive(Clone, Copy, Debug)]
pub struct CameraFrame {
    magic: PlanarTexgen,
    rays: ViewRays,
}

impl CameraFrame {
    /// `half` is half the width and height of the picture at distance 1, `size` its samples.
    #[must_use]
    pub fn new(frame: TextureFrame, half: [f64; 2], size: [f64; 2]) -> Self {
        Self {
            magic: frame.texgen(),
            rays: ViewRays::new(half, size),
        }
    }

    /// The planes of A.W, B.W and C.W over the picture. Their scalar product with (x, y, 1), x and y in samples from the top left
    /// corner.
    #[must_use]
    pub fn planes(&self) -> [DVec3; 3] {
        let [right, up] = self.rays.half_step;
        let [width, height] = self.rays.size;
        [self.magic.a, self.magic.b, self.magic.c].map(|m| {
            let (x, y) = (m.x * right, m.y * up);
            DVec3::new(2.0 * x, -2.0 * y, y * height - x * width - m.z)
        })
    }

    /// uv = (A.W / C.W, B.W / C.W) for the ray W through the sample's centre, and its analytic derivatives
    /// `du/dx = (A.W_x - u C.W_x) / C.W`. `None` where the ray never meets the frame's plane.
    #[must_use]
    pub fn uv(&self, x: u32, y: u32) -> Option<([f32; 2], Footprint)> {
        let ray = self.rays.through([x, y]);
        let uv = self.magic.uv(ray)?;
        let PlanarTexgen { a, b, c } = self.magic;
        let w = c.dot(ray);
        let [dx, dy] = self.rays.half_step.map(|half| 2.0 * half);
        let dy = -dy;
        let footprint = Footprint {
            du_dx: ((a.x - uv.x * c.x) * dx / w) as f32,
            dv_dx: ((b.x - uv.y * c.x) * dx / w) as f32,
            du_dy: ((a.y - uv.x * c.y) * dy / w) as f32,
            dv_dy: ((b.y - uv.y * c.y) * dy / w) as f32,
        };
        Some(([uv.x as f32, uv.y as f32], footprint))
    }
}
