//! One ray of the eye: what it meets, in which order that is drawn, and the colour that it leaves.

use texmap_math::glam::{DVec3, DVec4};
use texmap_raster::{Cull, DepthTest};
use texmap_scene::{AlphaMode, Shading};

use super::color::over;
use super::environment::Ray;
use super::lighting::Point;
use super::world::World;
use crate::caster::{Hit, Pinhole};

/// Two distances along a ray closer than this part of their size are one depth: the resolution of the
/// renderer's f32 depth buffer, so that surfaces in one plane tie here too.
const SAME_DEPTH: f64 = 1.0 / (1u64 << 22) as f64;

/// The surfaces that one ray sees.
#[derive(Clone, Debug, Default)]
pub(super) struct Visible {
    /// The nearest opaque or cut-out surface: mesh, triangle.
    pub(super) solid: Option<((usize, u32), Hit)>,
    /// Blended surfaces before it, in the order in which they are drawn.
    pub(super) blended: Vec<((usize, u32), Hit)>,
}

impl World<'_> {
    /// The surfaces along the ray through (x, y).
    pub(super) fn look(&self, x: f64, y: f64) -> Visible {
        self.look_from(&self.pinhole, None, x, y)
    }

    /// The surfaces along a ray of a pinhole, but for one mesh.
    fn look_from(&self, pinhole: &Pinhole, but: Option<usize>, x: f64, y: f64) -> Visible {
        let (eye, direction) = (pinhole.eye, pinhole.direction(x, y));
        let (near, far) = (self.scene.camera.near, self.scene.camera.far);
        let mut met: Vec<((usize, u32), Hit)> = Vec::new();
        self.rays
            .candidates(eye, direction, (0.0, far), |owner, end| {
                let surface = &self.surfaces[owner.0];
                if but == Some(owner.0) {
                    return end;
                }
                let hit = pinhole.meet(x, y, &surface.corners(owner.1));
                let Some(hit) = hit.filter(|hit| hit.t >= near && hit.t <= far) else {
                    return end;
                };
                let front = surface.front(&hit);
                let culled = match surface.material().cull {
                    Cull::None => false,
                    Cull::Back => !front,
                    Cull::Front => front,
                };
                if culled || !surface.kept(owner.1, &hit, pinhole, x, y) {
                    return end;
                }
                met.push((owner, hit));
                let hides = surface.material().alpha != AlphaMode::Blend
                    && self.scene.depth_test != DepthTest::Always;
                // Surfaces at the same depth may be drawn over it.
                let behind = hit.t * (1.0 + 4.0 * SAME_DEPTH);
                if hides { end.min(behind) } else { end }
            });
        met.sort_by_key(|((mesh, triangle), hit)| {
            let front = self.surfaces[*mesh].front(hit);
            (self.ranks[*mesh][usize::from(front)], *triangle)
        });
        let mut visible = Visible::default();
        for (owner, hit) in &met {
            if self.surfaces[owner.0].material().alpha == AlphaMode::Blend {
                visible.blended.push((*owner, *hit));
            } else if self.passes(hit.t, visible.solid.map(|(_, solid)| solid.t)) {
                visible.solid = Some((*owner, *hit));
            }
        }
        let end = visible.solid.map(|(_, solid)| solid.t);
        visible.blended.retain(|(_, hit)| self.passes(hit.t, end));
        visible
    }

    /// The depth test against what was drawn before.
    fn passes(&self, t: f64, before: Option<f64>) -> bool {
        let Some(before) = before else { return true };
        let same = (t - before).abs() <= SAME_DEPTH * before;
        match self.scene.depth_test {
            DepthTest::Less => t < before && !same,
            DepthTest::LessOrEqual => t < before || same,
            DepthTest::Always => true,
        }
    }

    /// Colour of the ray through (x, y), premultiplied linear light. The flag is true if anything blended or a volume is in it.
    pub(super) fn color(&self, visible: &Visible, x: f64, y: f64) -> (DVec4, bool) {
        self.color_from(&self.pinhole, false, visible, x, y)
    }

    /// The light that a mirrored ray meets: the scene from a point of a surface. Mirrors in the mirror show their environments.
    pub(super) fn traced(&self, at: &Point, ray: &Ray) -> DVec3 {
        let [right, down] = ray.changes;
        let pinhole = Pinhole {
            eye: at.position + at.plane * (1e-7 * self.extent),
            corner: ray.direction,
            right,
            down,
        };
        // A normal between those of facets may send a ray into its own facet.
        let but = (ray.direction.dot(at.plane) <= 0.0).then_some(at.owner.0);
        let visible = self.look_from(&pinhole, but, 0.0, 0.0);
        let (color, _) = self.color_from(&pinhole, true, &visible, 0.0, 0.0);
        color.truncate()
    }

    fn color_from(
        &self,
        pinhole: &Pinhole,
        mirrored: bool,
        visible: &Visible,
        x: f64,
        y: f64,
    ) -> (DVec4, bool) {
        let shade = |owner: (usize, u32), hit: &Hit| {
            let surface = &self.surfaces[owner.0];
            let mut point = surface.point(owner, hit, pinhole, x, y);
            point.mirrored = mirrored;
            surface.shade(self, &point, hit)
        };
        let mut color = match &visible.solid {
            Some((owner, hit)) => shade(*owner, hit),
            None => self.behind.color(&self.environments, pinhole, x, y),
        };
        let mut mixed = !visible.blended.is_empty();
        for (owner, hit) in &visible.blended {
            color = over(shade(*owner, hit), color);
        }
        let ray = pinhole.direction(x, y);
        let end = visible
            .solid
            .map_or(f64::INFINITY, |(_, hit)| hit.t * ray.length());
        for matter in &self.volumes {
            let seen = matter.seen(pinhole.eye, ray.normalize(), end);
            mixed |= seen.w > 0.0;
            color = over(seen, color);
        }
        (color, mixed)
    }

    /// True if the pixel of `samples` samples a side about (x, y) lies at the edge of a shadow on what is seen there.
    pub(super) fn at_an_edge(&self, visible: &Visible, samples: u32, x: f64, y: f64) -> bool {
        let solid = visible.solid.iter();
        self.has_shadows()
            && solid.chain(&visible.blended).any(|(owner, hit)| {
                let surface = &self.surfaces[owner.0];
                if surface.material().shading != Shading::PerPixel {
                    return false;
                }
                let at = surface.point(*owner, hit, &self.pinhole, x, y);
                let step = at.moves[0].length().max(at.moves[1].length());
                self.near_an_edge(&at, step * f64::from(samples))
            })
    }
}
