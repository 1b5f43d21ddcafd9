//! Bumps by a formula of the position (Perlin 1985).

use std::f64::consts::TAU;

use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec3};
use texmap_scene::ProceduralHeight;

use super::bump::raised;
use super::lighting::Point;
use super::pattern::{noise, value};

/// Heights by a formula.
pub(super) struct Formula {
    heights: ProceduralHeight,
    /// World units of a height of 1.
    height: f64,
    solid_from_world: DMat4,
    /// World units of the shortest side of the formula's unit.
    side: f64,
}

impl Formula {
    pub(super) fn new(heights: ProceduralHeight, world_from_solid: DMat4, height: f64) -> Self {
        let sides = [0, 1, 2].map(|k| world_from_solid.col(k).truncate().length());
        Self {
            heights,
            height,
            solid_from_world: world_from_solid.inverse(),
            side: sides[0].min(sides[1]).min(sides[2]),
        }
    }

    /// The unit normal n turned by the slope of the heights along the surface. The slope is measured over half a sample to each
    /// side, or a 512th of the unit if that is more.
    pub(super) fn normal(&self, at: &Point, n: DVec3) -> DVec3 {
        let width = at.moves[0].length().max(at.moves[1].length());
        let step = (0.5 * width).max(self.side / 512.0);
        if n == DVec3::ZERO || !step.is_finite() {
            return n;
        }
        let t = n.any_orthonormal_vector();
        let b = n.cross(t);
        let slope = |axis: DVec3| {
            let rise = self.rise(at.position + axis * step, width)
                - self.rise(at.position - axis * step, width);
            self.height * rise / (2.0 * step)
        };
        raised(n, t, b, slope(t), slope(b))
    }

    /// The height, 0 to 1, at a point of the world as a sample of this width sees it.
    fn rise(&self, point: DVec3, width: f64) -> f64 {
        let p = self.solid_from_world.transform_point3(point);
        let width = width / self.side;
        match self.heights {
            ProceduralHeight::Pattern(pattern) => value(pattern, p, width),
            ProceduralHeight::Waves { around, fold } => {
                let (around, fold) = (f64::from(around), f64::from(fold));
                let turns = deterministic_f64::atan2(p.z, p.x) / TAU * around + fold * noise(p, 1);
                let radius = p.x.hypot(p.z);
                let across =
                    seen(width * around / (TAU * radius)) * deterministic_f64::cos(TAU * turns);
                let along = seen(width) * deterministic_f64::cos(TAU * (p.y + fold * noise(p, 2)));
                0.5 + 0.5 * across * along
            }
        }
    }
}

/// The part of a wave of length 1 that a sample of this width leaves: all up to a quarter, nothing from three quarters on.
fn seen(width: f64) -> f64 {
    let left = 1.5 - 2.0 * width;
    // NaN, on the axis itself, leaves nothing.
    if left > 0.0 { left.min(1.0) } else { 0.0 }
}
