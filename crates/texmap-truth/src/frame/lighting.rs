//! The light that a surface returns at a point, light by light. Sources: Phong 1975, Blinn 1977; MIT 6.837, Fall 2000,
//! lecture 19.

use texmap_light::{Light, PhongMaterial as Numbers, SpecularModel};
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_scene::{ProjectorMode, UvSet};

use super::color::wide;
use super::environment::Ray;
use super::slot::{Place, Slot};
use super::surface::Surface;
use super::world::World;

/// Light that a point returns: what the base colour multiplies, and what is added to it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Terms {
    pub(super) diffuse: DVec3,
    pub(super) specular: DVec3,
}

impl Terms {
    /// The light of a base colour, not clipped.
    pub(super) fn color(&self, base: DVec3) -> DVec3 {
        base * self.diffuse + self.specular
    }
}

/// A point of a surface, as a sample sees it. Vectors look to the side that is seen.
pub(super) struct Point {
    /// Mesh and triangle.
    pub(super) owner: (usize, u32),
    pub(super) front: bool,
    /// World space, and its change for one sample to the right and one down.
    pub(super) position: DVec3,
    pub(super) moves: [DVec3; 2],
    /// The interpolated normal, of any length, and its change.
    pub(super) normal: DVec3,
    pub(super) turns: [DVec3; 2],
    /// Unit normal of the triangle.
    pub(super) plane: DVec3,
    /// Texture coordinates.
    pub(super) place: Place,
    /// Coordinates of the light map, and of textures that read the second set.
    pub(super) baked_place: Place,
    /// Tangent and the sign of the bitangent; zero without.
    pub(super) tangent: (DVec3, f64),
    /// To the eye.
    pub(super) view: Ray,
    /// Seen in a mirror.
    pub(super) mirrored: bool,
}

impl Point {
    /// The coordinates that a slot reads.
    pub(super) fn read(&self, slot: &Slot<'_>) -> Place {
        match slot.uv_set {
            UvSet::First => self.place,
            UvSet::Second => self.baked_place,
        }
    }
}

/// One light on a point, with nothing in its way: colour, and the shares of it that go into the two terms. `view` has unit length.
pub(super) fn contribution(
    numbers: &Numbers,
    model: SpecularModel,
    light: &Light,
    point: DVec3,
    normal: DVec3,
    view: DVec3,
) -> (DVec3, f64, f64) {
    let dark = (DVec3::ZERO, 0.0, 0.0);
    if let Light::Ambient { color } = *light {
        return (wide(color), f64::from(numbers.ka), 0.0);
    }
    let (color, toward) = arriving(light, point);
    let facing = normal.dot(toward);
    if facing <= 0.0 {
        return dark;
    }
    let along = match model {
        SpecularModel::Phong => view.dot(2.0 * facing * normal - toward),
        SpecularModel::Blinn => normal.dot((view + toward).normalize_or_zero()),
    };
    let highlight = if along > 0.0 && numbers.ks > 0.0 {
        f64::from(numbers.ks) * deterministic_f64::pow(along, f64::from(numbers.ns))
    } else {
        0.0
    };
    (color, f64::from(numbers.kd) * facing, highlight)
}

/// The colour in which a light arrives at a point, with nothing in its way, and the unit vector to it. Black for light from everywhere.
pub(super) fn arriving(light: &Light, point: DVec3) -> (DVec3, DVec3) {
    let (color, toward) = match *light {
        Light::Directional { color, direction } => (wide(color), -wide(direction)),
        Light::Point { color, position } => (wide(color), wide(position) - point),
        Light::Spot {
            color,
            position,
            direction,
            cos_inner,
            cos_outer,
        } => {
            let toward = wide(position) - point;
            let along = -wide(direction)
                .normalize_or_zero()
                .dot(toward.normalize_or_zero());
            let (inner, outer) = (f64::from(cos_inner), f64::from(cos_outer));
            let x = match along >= inner {
                true => 1.0,
                false => ((along - outer) / (inner - outer)).max(0.0),
            };
            (wide(color) * (x * x * (3.0 - 2.0 * x)), toward)
        }
        Light::Punctual {
            intensity,
            position,
            range,
            ref cone,
        } => {
            let toward = wide(position) - point;
            let share = texmap_light::reference::falloff(range, cone.as_ref(), toward);
            (wide(intensity) * share, toward)
        }
        _ => (DVec3::ZERO, DVec3::ZERO),
    };
    (color, toward.normalize_or_zero())
}

/// The light at a point of a surface that is lit per pixel.
pub(super) fn terms(world: &World<'_>, surface: &Surface<'_>, at: &Point) -> Terms {
    let material = surface.material();
    let lit = Lit::new(surface, at);
    let ambient = surface.ambient.as_ref();
    let ambient = ambient.map(|slot| slot.straight(at.read(slot)));
    let mut sum = Terms::default();
    let mut own_ambient = DVec3::ZERO;
    for (index, light) in world.scene.lights.iter().enumerate() {
        if material.bakes(index) {
            continue;
        }
        let (color, diffuse, highlight) = lit.by(light, at);
        match (light, ambient) {
            // A colour of its own, which does not multiply the base colour.
            (Light::Ambient { .. }, Some(texel)) => own_ambient += color * texel * diffuse,
            _ if diffuse == 0.0 && highlight == 0.0 => {}
            _ if !world.light_reaches(index, at) => {}
            _ => {
                sum.diffuse += color * diffuse;
                sum.specular += color * highlight;
            }
        }
    }
    lit.add_projectors(world, at, &mut sum);
    if let (Some(map), Some(slot)) = (&material.light_map, &surface.light_map) {
        let texel = slot.straight(at.baked_place);
        sum.diffuse += texel * f64::from(lit.numbers.kd) * f64::from(map.scale);
    }
    sum.specular = sum.specular * lit.tint + own_ambient;
    mirror(world, surface, at, lit.normal, &mut sum);
    sum
}

/// The light of the projectors alone, which texels that cover their surface are under.
pub(super) fn projected(world: &World<'_>, surface: &Surface<'_>, at: &Point) -> Terms {
    let lit = Lit::new(surface, at);
    let mut sum = Terms::default();
    lit.add_projectors(world, at, &mut sum);
    sum.specular *= lit.tint;
    sum
}

/// A point as lights meet it.
struct Lit {
    numbers: Numbers,
    model: SpecularModel,
    normal: DVec3,
    view: DVec3,
    /// Multiplies highlights.
    tint: DVec3,
}

impl Lit {
    fn new(surface: &Surface<'_>, at: &Point) -> Self {
        let material = surface.material();
        let map = |slot: &Option<Slot<'_>>| slot.as_ref().map(|s| s.straight(at.read(s)));
        let mut numbers = material.phong;
        if let Some(texel) = map(&surface.exponent) {
            numbers.ns = (f64::from(numbers.ns) * texel.x) as f32;
        }
        Self {
            numbers,
            model: material.specular_model,
            normal: surface.turned_normal(at),
            view: at.view.direction.normalize_or_zero(),
            tint: map(&surface.specular).unwrap_or(DVec3::ONE),
        }
    }

    /// See [`contribution`].
    fn by(&self, light: &Light, at: &Point) -> (DVec3, f64, f64) {
        let (normal, view) = (self.normal, self.view);
        contribution(&self.numbers, self.model, light, at.position, normal, view)
    }

    fn add_projectors(&self, world: &World<'_>, at: &Point, sum: &mut Terms) {
        for (index, cast) in world.projectors.iter().enumerate() {
            let ProjectorMode::Light(color) = cast.projector.mode else {
                continue;
            };
            let position = cast.projector.position.as_vec3().to_array();
            let (color, diffuse, highlight) = self.by(&Light::Point { color, position }, at);
            let picture = cast.texel(at.position, at.moves).truncate();
            if diffuse > 0.0 && picture != DVec3::ZERO && world.projector_reaches(index, at) {
                sum.diffuse += color * picture * diffuse;
                sum.specular += color * picture * highlight;
            }
        }
    }
}

/// The light of mirrored environments and of specular maps.
fn mirror(world: &World<'_>, surface: &Surface<'_>, at: &Point, normal: DVec3, sum: &mut Terms) {
    let material = surface.material();
    if material.reflection.is_none() && material.specular_map.is_none() {
        return;
    }
    // A bump turns the normal; its bends are left to its own texels.
    let mirrored = at.view.mirrored(normal, at.normal.length(), at.turns);
    let light = |index: usize, ray: &Ray| {
        let sphere = world.environments[index].as_ref();
        sphere.map_or(DVec3::ZERO, |sphere| sphere.light(ray))
    };
    if let Some(reflection) = material.reflection {
        let map = surface.reflectivity.as_ref();
        let share = map.map_or(1.0, |slot| slot.straight(at.read(slot)).x);
        let led = match &reflection.within {
            Some(walls) => mirrored.led_to(walls, at.position, at.moves),
            None => mirrored,
        };
        let seen = match world.traces && !at.mirrored {
            true => world.traced(at, &mirrored),
            false => light(reflection.environment, &led),
        };
        sum.specular += seen * share * f64::from(reflection.reflectivity);
    }
    if let Some(map) = material.specular_map {
        sum.specular += light(map, &mirrored) * f64::from(material.phong.ks);
    }
}
