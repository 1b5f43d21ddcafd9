//! Hard shadows by rays: what reaches a point, and where the edge of a shadow is near.

use texmap_light::{Light, ShadowKind};
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat3, DMat4, DVec2, DVec3};
use texmap_scene::{AlphaMode, ProjectorLight, Scene};

use super::color::wide;
use super::lighting::Point;
use super::world::World;

/// The source of light.
#[derive(Clone, Copy)]
pub(super) enum Origin {
    /// Along a direction, from infinity.
    Toward(DVec3),
    Place(DVec3),
}

/// A shadow of a light or a projector.
pub(super) struct Shadow {
    pub(super) origin: Origin,
    /// Area of the shadow map: everything outside is lit.
    kind: ShadowKind,
    /// Texels of the map around a true edge in which the map may say something else.
    reach: f64,
    /// Of the map's sides.
    texels: f64,
}

impl Shadow {
    /// The shadow of a light of the scene.
    pub(super) fn of_light(
        scene: &Scene,
        shadow: &texmap_scene::Shadow,
        width: u32,
    ) -> Result<Self, texmap_render::RenderError> {
        let kind = texmap_scene::shadow_kind(scene, shadow.light, shadow.area)?;
        let origin = match scene.lights[shadow.light] {
            Light::Directional { direction, .. } => Origin::Toward(-wide(direction).normalize()),
            Light::Point { position, .. }
            | Light::Spot { position, .. }
            | Light::Punctual { position, .. } => Origin::Place(wide(position)),
            _ => Origin::Toward(DVec3::ZERO),
        };
        let texels = shadow
            .size
            .map_or_else(|| automatic(scene, &kind, width), f64::from);
        Ok(Self {
            origin,
            kind,
            reach: f64::from(shadow.pcf_size + 1),
            texels,
        })
    }

    /// The shadow of a projector that has a depth map.
    pub(super) fn of_projector(projector: &ProjectorLight) -> Option<Self> {
        let t = projector.projector.t.truncate();
        let right = projector.projector.q.truncate() - t * 0.5;
        let down = projector.projector.s.truncate() - t * 0.5;
        let axes = DMat3::from_cols(right.normalize(), -down.normalize(), -t.normalize());
        Some(Self {
            origin: Origin::Place(projector.position),
            kind: ShadowKind::Spot {
                light_from_world: DMat4::from_mat3(axes.transpose())
                    * DMat4::from_translation(-projector.position),
                tan_half: 0.5 / right.length().min(down.length()),
            },
            reach: 4.0,
            texels: f64::from(projector.shadow?),
        })
    }

    /// Width of a texel of the map where a point stands, and whether the map shows it.
    fn texel(&self, point: DVec3) -> (f64, bool) {
        match &self.kind {
            ShadowKind::Directional {
                light_from_world,
                half,
            } => {
                let p = light_from_world.transform_point3(point).truncate();
                (2.0 * half / self.texels, p.abs().max_element() <= *half)
            }
            ShadowKind::Spot {
                light_from_world,
                tan_half,
            } => {
                let p = light_from_world.transform_point3(point);
                let side = -p.z * tan_half;
                let within = p.z < 0.0 && DVec2::new(p.x, p.y).abs().max_element() <= side;
                (2.0 * side.abs() / self.texels, within)
            }
            ShadowKind::Point { position } => {
                let way = (point - *position).abs().max_element();
                (2.0 * way / self.texels, true)
            }
        }
    }
}

/// Texels a side of an automatic map: about one for each pixel at the middle of the scene.
fn automatic(scene: &Scene, kind: &ShadowKind, width: u32) -> f64 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in scene.meshes.iter().flat_map(super::world) {
        (low, high) = (low.min(p), high.max(p));
    }
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low).length());
    let way = |from: DVec3| (from - centre).length().max(0.5 * half);
    let camera = &scene.camera;
    let pixel =
        2.0 * deterministic_f64::tan(0.5 * camera.fov_x) * way(camera.eye) / f64::from(width);
    let side = match kind {
        ShadowKind::Directional { half, .. } => 2.0 * half,
        ShadowKind::Spot {
            light_from_world,
            tan_half,
        } => 2.0 * tan_half * way(light_from_world.inverse().transform_point3(DVec3::ZERO)),
        ShadowKind::Point { position } => 2.0 * way(*position),
    };
    (side / pixel).clamp(256.0, 4096.0)
}

impl World<'_> {
    /// True if a light of the scene reaches a point, by the shadows that it has.
    pub(super) fn light_reaches(&self, light: usize, at: &Point) -> bool {
        self.shadows[light]
            .iter()
            .all(|shadow| self.lit(shadow, at.position, at.owner))
    }

    /// True if a projector reaches a point, by the shadow that it has.
    pub(super) fn projector_reaches(&self, projector: usize, at: &Point) -> bool {
        let shadow = self.projector_shadows[projector].as_ref();
        shadow.is_none_or(|shadow| self.lit(shadow, at.position, at.owner))
    }

    fn lit(&self, shadow: &Shadow, point: DVec3, owner: (usize, u32)) -> bool {
        let (_, shown) = shadow.texel(point);
        !shown || !self.blocked(shadow, point, owner)
    }

    /// True if anything that casts shadows stands between a point of a triangle and a light. The triangle itself does not.
    fn blocked(&self, shadow: &Shadow, point: DVec3, owner: (usize, u32)) -> bool {
        let (toward, end) = match shadow.origin {
            Origin::Toward(direction) => (direction, f64::INFINITY),
            Origin::Place(place) => {
                let way = place - point;
                (way.normalize_or_zero(), way.length())
            }
        };
        // Nearer lies only what touches the point.
        let start = 1e-9 * self.extent;
        self.rays.meets_any(point, toward, (start, end), |hit| {
            let (object, triangle) = (hit.object, hit.triangle);
            (object, triangle) != owner && self.casts(object, triangle, hit.weights, toward, shadow)
        })
    }

    /// True if a triangle blocks light at these weights of its corners.
    fn casts(
        &self,
        object: usize,
        triangle: u32,
        weights: DVec3,
        toward: DVec3,
        shadow: &Shadow,
    ) -> bool {
        let surface = &self.surfaces[object];
        let material = surface.material();
        if surface.mesh.casts_no_shadow || material.alpha == AlphaMode::Blend {
            return false;
        }
        // Lights inside of a closed mesh shine through its backs; a map all around shows both sides.
        let around = matches!(shadow.kind, ShadowKind::Point { .. });
        if surface.mesh.watertight && !around && surface.flat(triangle).dot(toward) <= 0.0 {
            return false;
        }
        surface.holds_light(triangle, weights)
    }

    /// True if the edge of some shadow is near to a point. Near means that the shadow's map, with its texels and its filter, may
    /// differ from rays, or that a pixel of this width holds the edge.
    pub(super) fn near_an_edge(&self, at: &Point, pixel: f64) -> bool {
        let lights = self.shadows.iter().flatten();
        let cast = self.projector_shadows.iter().flatten();
        let mut all = lights.chain(cast);
        all.any(|shadow| self.near_edge_of(shadow, at, pixel))
    }

    fn near_edge_of(&self, shadow: &Shadow, at: &Point, pixel: f64) -> bool {
        let (texel, _) = shadow.texel(at.position);
        let radius = shadow.reach * texel + 0.75 * pixel;
        let here = self.lit(shadow, at.position, at.owner);
        let toward = |point: DVec3| match shadow.origin {
            Origin::Toward(direction) => direction,
            Origin::Place(place) => (place - point).normalize_or_zero(),
        };
        let direction = toward(at.position);
        if direction == DVec3::ZERO {
            return false;
        }
        let a = direction.any_orthonormal_vector();
        let b = direction.cross(a);
        // Eight points around, and eight between them half as far.
        (0..16).any(|k| {
            let (turn, way) = if k < 8 { (0.0, 1.0) } else { (0.5, 0.5) };
            let angle = (f64::from(k) + turn) * std::f64::consts::FRAC_PI_4;
            let (sin, cos) = deterministic_f64::sin_cos(angle);
            let beside = at.position + (a * cos + b * sin) * (way * radius);
            let Some((point, owner)) = self.surface_near(beside, toward(beside)) else {
                return true;
            };
            self.lit(shadow, point, owner) != here
        })
    }

    /// The surface on a light's ray through a point, nearest to it. A receiver's own plane would run into the body beside it.
    fn surface_near(&self, place: DVec3, toward: DVec3) -> Option<(DVec3, (usize, u32))> {
        let range = (0.0, f64::INFINITY);
        let up = self.rays.nearest(place, toward, range);
        let down = self.rays.nearest(place, -toward, range);
        let hit = match (up, down) {
            (Some(up), Some(down)) if up.t < down.t => up,
            (up, down) => down.or(up)?,
        };
        Some((hit.point, (hit.object, hit.triangle)))
    }
}
