//! Projectors: pictures cast as light or as paint (MIT 6.837, Fall 2001, lecture 18, slides 21 to 26).

use texmap_light::ProjectorBorder;
use texmap_math::Projector;
use texmap_math::glam::{DVec2, DVec3, DVec4};
use texmap_sample::{Sampler, Texture2d, Wrap};
use texmap_scene::{ProjectorLight, ProjectorMode, Shading};

use super::color::{over, straight};
use super::lighting::{Point, projected};
use super::slot::{Place, Textures, sample};
use super::surface::Surface;
use super::world::World;

/// A projector with its picture.
pub(super) struct Cast<'s> {
    pub(super) projector: &'s ProjectorLight,
    texture: Texture2d<'static>,
    sampler: Sampler,
}

impl<'s> Cast<'s> {
    pub(super) fn new(projector: &'s ProjectorLight, textures: &mut Textures<'s>) -> Self {
        let wrap = match projector.border {
            ProjectorBorder::Repeat => Wrap::Repeat,
            ProjectorBorder::Black | ProjectorBorder::Clamp => Wrap::ClampToEdge,
        };
        Self {
            projector,
            texture: textures.picture(projector.texture),
            sampler: Sampler {
                wrap_u: wrap,
                wrap_v: wrap,
                ..projector.sampler.clone()
            },
        }
    }

    /// The premultiplied texel at a point that moves so from sample to sample. Nothing behind the projector and beyond its picture.
    pub(super) fn texel(&self, point: DVec3, moves: [DVec3; 2]) -> DVec4 {
        let Projector { q, s, t } = self.projector.projector;
        let at = |v: DVec4| DVec3::new(q.dot(v), s.dot(v), t.dot(v));
        let qst = at(point.extend(1.0));
        let uv = qst.truncate() / qst.z;
        if !(qst.z > 0.0 && uv.is_finite()) {
            return DVec4::ZERO;
        }
        let mut fade = 1.0;
        if self.projector.border == ProjectorBorder::Black {
            if uv.min_element() < 0.0 || uv.max_element() > 1.0 {
                return DVec4::ZERO;
            }
            fade = self.fade(uv.x) * self.fade(uv.y);
        }
        // d(q/t) = (dq - (q/t) dt) / t.
        let change = |d: DVec3| -> DVec2 {
            let d = at(d.extend(0.0));
            (d.truncate() - uv * d.z) / qst.z
        };
        let place = Place {
            uv,
            dx: change(moves[0]),
            dy: change(moves[1]),
        };
        sample(&self.sampler, &self.texture, place) * fade
    }

    /// Light near the edge of a soft picture.
    fn fade(&self, c: f64) -> f64 {
        let (softness, inside) = (f64::from(self.projector.softness), c.min(1.0 - c));
        if inside >= softness {
            return 1.0;
        }
        let x = inside / softness;
        x * x * (3.0 - 2.0 * x)
    }
}

/// The paint of all projectors on a point, premultiplied, the later over the earlier: on what faces them and is not behind something.
pub(super) fn paint(world: &World<'_>, at: &Point) -> DVec4 {
    let mut sum = DVec4::ZERO;
    for (index, cast) in world.projectors.iter().enumerate() {
        let projector = cast.projector;
        let toward = projector.position - at.position;
        if projector.mode != ProjectorMode::Decal || at.plane.dot(toward) <= 0.0 {
            continue;
        }
        let texel = cast.texel(at.position, at.moves);
        if texel.w > 0.0 && world.projector_reaches(index, at) {
            sum = over(texel, sum);
        }
    }
    sum
}

/// A texel that covers its surface under all projectors: paint over it, then their light added, `texel + display(texel * diffuse +
/// specular)`. The texel is display light before.
pub(super) fn onto(world: &World<'_>, surface: &Surface<'_>, at: &Point, texel: DVec4) -> DVec4 {
    if world.projectors.is_empty() || surface.material().shading != Shading::PerPixel {
        return texel;
    }
    let paint = paint(world, at);
    let color = paint.truncate() + straight(texel) * (1.0 - paint.w);
    let light = world.display(projected(world, surface, at).color(color));
    ((color + light).min(world.limit()) * texel.w).extend(texel.w)
}
