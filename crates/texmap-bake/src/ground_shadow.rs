//! The shadow of a scene on the ground under it, as a texture of opacity: a shadow catcher.

mod sky;

use texmap_light::Roughnesses;
use texmap_math::camera::{Camera, Lens};
use texmap_math::glam::{DVec2, DVec3};
use texmap_math::parallel;
use texmap_render::{RenderError, RenderSettings, no_progress, render};
use texmap_sample::{ColorSpace, Filter, Origin, Texture2d};
use texmap_scene::{
    AlphaMode, BlendOrder, Material, Mesh, Scene, SceneError, Shading, TextureSlot,
};

use sky::{LOBE, sky};

/// Texels a side of the shadow.
const SIDE: u32 = 256;
/// Pixels a side of the outline that the scene has from a direction.
const OUTLINE: u32 = 256;
/// Share of the way from the middle of the ground to its edge at which the shadow begins to fade.
const FADE: f64 = 0.6;

/// The shadow of a scene on the ground under it: the missing share of the environment light, else of an even sky, and of directional
/// lights. Other lights cast none.
///
/// The share of the light is summed over directions, by the outlines of the scene along each: a shadow is dark and sharp where something
/// touches the ground, and pale and wide under what is far above it. It fades out towards the edge of a square that is wider than the
/// scene by three quarters of its height.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundShadow {
    /// Of the square, counter-clockwise from above, the first texel of the shadow first.
    corners: [DVec3; 4],
    /// Share of the light that is missing, row by row, [`SIDE`] squared.
    opacity: Vec<f32>,
}

/// A scene above its ground.
struct Place {
    /// Right, back and up.
    axes: [DVec3; 3],
    /// Of the box, in the directions of `axes`.
    middle: DVec3,
    /// Around the middle, of all vertices.
    radius: f64,
    /// Height of the ground along the third axis.
    ground: f64,
    /// Half the side of the square.
    half: f64,
}

impl Place {
    fn new(scene: &Scene, up: DVec3) -> Option<Self> {
        let up = up.try_normalize()?;
        let right = across(up, DVec3::Z);
        let axes = [right, up.cross(right), up];
        let points = || {
            let casting = scene.meshes.iter().filter(|mesh| !mesh.casts_no_shadow);
            casting.flat_map(|mesh| {
                let used = mesh.triangles.as_flattened().iter();
                used.filter_map(|i| {
                    let p = DVec3::from(mesh.positions.get(*i as usize)?.map(f64::from));
                    let p = mesh.world_from_object.transform_point3(p);
                    let p = DVec3::from(axes.map(|axis| axis.dot(p)));
                    p.is_finite().then_some(p)
                })
            })
        };
        let first = points().next()?;
        let (low, high) = points().fold((first, first), |(l, h), p| (l.min(p), h.max(p)));
        let middle = (low + high) * 0.5;
        let square = points().fold(0.0_f64, |r, p| r.max((p - middle).length_squared()));
        let radius = square.sqrt();
        let sides = high - low;
        let foot = 0.5 * sides.truncate().length();
        // Of a mast, the shadow reaches no farther than three times its foot, or a third of its height.
        let height = sides.z.min((2.5 * foot).max(0.3 * sides.z));
        let place = Self {
            axes,
            middle,
            radius,
            // A little lower, so that it never fights with what stands on it.
            ground: low.z - 1e-3 * radius,
            half: foot + 0.75 * height,
        };
        (radius > 0.0).then_some(place)
    }

    /// From the directions of the axes to the world.
    fn world(&self, p: DVec3) -> DVec3 {
        let [right, back, up] = self.axes;
        right * p.x + back * p.y + up * p.z
    }

    /// The centre of a texel on the ground, in the directions of the axes.
    fn texel(&self, x: u32, y: u32) -> DVec3 {
        let at = |i: u32| (2.0 * (f64::from(i) + 0.5) / f64::from(SIDE) - 1.0) * self.half;
        DVec3::new(self.middle.x + at(x), self.middle.y + at(y), self.ground)
    }
}

impl GroundShadow {
    /// The shadow of a scene of triangles on the plane under its lowest point, `up` pointing away from it. `None` for a scene without
    /// triangles that cast shadows.
    ///
    /// # Errors
    /// Those of [`render`]; [`SceneError::Value`] for environment light that was not made for [`roughnesses`](Self::roughnesses).
    pub fn new(scene: &Scene, up: DVec3) -> Result<Option<Self>, RenderError> {
        scene.check()?;
        let Some(place) = Place::new(scene, up) else {
            return Ok(None);
        };
        if let Some(light) = &scene.effects.environment_light
            && !light.roughnesses().contains(Self::roughnesses())
        {
            return Err(RenderError::Scene(SceneError::Value {
                place: "ground shadow".to_owned(),
                what: "its roughness".to_owned(),
                value: "not among those that the environment light was made for".to_owned(),
                expected: "make the light for `GroundShadow::roughnesses` too",
            }));
        }
        let sky = sky(scene, &place);
        let all: f64 = sky.iter().map(|(_, weight)| weight).sum();
        let mut lost = vec![0.0_f64; (SIDE * SIDE) as usize];
        let mut caster = caster(scene);
        for (direction, weight) in sky.iter().filter(|(_, weight)| *weight > 0.0) {
            let outline = Outline::new(&mut caster, &place, *direction)?;
            let share = weight / all;
            let rows = lost.chunks_mut(SIDE as usize).enumerate();
            parallel::for_each(rows, |(y, row)| {
                for (lost, x) in row.iter_mut().zip(0..) {
                    *lost += share * outline.opacity(place.texel(x, y as u32) - place.middle);
                }
            });
        }
        let fade = |i: u32| {
            let (x, y) = (i % SIDE, i / SIDE);
            let way = (place.texel(x, y) - place.middle).truncate().length() / place.half;
            let t = ((1.0 - way) / (1.0 - FADE)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
            let (x, y) = (x * place.half, y * place.half);
            place.world(DVec3::new(
                place.middle.x + x,
                place.middle.y + y,
                place.ground,
            ))
        });
        Ok(Some(Self {
            corners,
            opacity: (0..)
                .zip(lost)
                .map(|(i, lost)| (lost * fade(i)) as f32)
                .collect(),
        }))
    }

    /// The levels of environment light that are read.
    #[must_use]
    pub fn roughnesses() -> Roughnesses {
        Roughnesses::between(LOBE, LOBE)
    }

    /// Opacity of the shadow at a place of its square, u and v from 0 to 1: 0 where all of the light arrives.
    #[must_use]
    pub fn opacity(&self, u: f64, v: f64) -> f32 {
        let texel = |x: f64| (x * f64::from(SIDE)).clamp(0.0, f64::from(SIDE - 1)) as usize;
        let at = texel(v) * SIDE as usize + texel(u);
        self.opacity.get(at).copied().unwrap_or(0.0)
    }

    /// Corners of the square in the world, (u, v) = (0, 0), (1, 0), (1, 1), (0, 1).
    #[must_use]
    pub fn corners(&self) -> [DVec3; 4] {
        self.corners
    }

    /// Adds the shadow to a scene: a black square that blends, seen from above alone, before all other surfaces that blend. It leaves
    /// no trace in output arrays. Where meshes are [drawn in their order](texmap_scene::BlendOrder::OfMeshes) those that blend get the
    /// next number.
    pub fn add_to(&self, scene: &mut Scene) {
        let code = |opacity: f32| (opacity.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let texels = self.opacity.iter().flat_map(|o| [0, 0, 0, code(*o)]);
        let texture = Texture2d::from_rgba8(
            SIDE,
            SIDE,
            texels.collect(),
            ColorSpace::Linear,
            Origin::TopLeft,
        );
        let texture = texture.expect("the shadow is a picture of its size");
        scene.textures.push(texture.with_mips());
        let mut slot = TextureSlot::new(scene.textures.len() - 1);
        slot.sampler.filter = Filter::Anisotropic(8);
        let mut material = Material {
            name: "ground shadow".into(),
            shading: Shading::Unlit,
            base_color: Some(slot),
            alpha: AlphaMode::Blend,
            cull: texmap_raster::Cull::Back,
            ..Material::default()
        };
        material.phong.color = [1.0; 3];
        scene.materials.push(material);
        let mesh = Mesh {
            name: "ground shadow".into(),
            positions: self
                .corners
                .map(|c| c.to_array().map(|x| x as f32))
                .to_vec(),
            uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            faces: vec![0, 0],
            material: scene.materials.len() - 1,
            casts_no_shadow: true,
            ..Mesh::default()
        };
        let blends = |mesh: &Mesh| {
            let material = scene.materials.get(mesh.material);
            material.is_some_and(|material| material.alpha == AlphaMode::Blend)
        };
        let first = match scene.blend_order {
            BlendOrder::OfMeshes => scene.meshes.iter().position(blends),
            // It casts no shadow, and so comes first.
            BlendOrder::FarthestFirst => None,
        };
        scene
            .meshes
            .insert(first.unwrap_or(scene.meshes.len()), mesh);
    }
}

/// The triangles of a scene that cast shadows, as they cover pixels.
fn caster(scene: &Scene) -> Scene {
    let covers = |material: &Material| Material {
        opacity: material.opacity,
        base_color: material.base_color.clone(),
        opacity_map: material.opacity_map.clone(),
        antialiased_alpha: material.antialiased_alpha,
        alpha: material.alpha,
        interp: material.interp,
        shading: Shading::Unlit,
        ..Material::default()
    };
    let casting = scene.meshes.iter().filter(|mesh| !mesh.casts_no_shadow);
    let meshes = casting.map(|mesh| {
        let opaque = scene.materials[mesh.material].alpha == AlphaMode::Opaque;
        let uvs = |uvs: &Vec<[f32; 2]>| if opaque { Vec::new() } else { uvs.clone() };
        Mesh {
            positions: mesh.positions.clone(),
            triangles: mesh.triangles.clone(),
            uvs: uvs(&mesh.uvs),
            lightmap_uvs: uvs(&mesh.lightmap_uvs),
            texture_frame: mesh.texture_frame.filter(|_| !opaque),
            uv_projection: mesh.uv_projection.filter(|_| !opaque),
            uv_origin: mesh.uv_origin,
            material: mesh.material,
            world_from_object: mesh.world_from_object,
            ..Mesh::default()
        }
    });
    let mut caster = Scene {
        background: [0.0; 4],
        color: scene.color,
        textures: scene.textures.clone(),
        meshes: meshes.collect(),
        materials: scene.materials.iter().map(covers).collect(),
        ..Scene::new(Camera::look_at([0.0, 0.0, 1.0], [0.0; 3]))
    };
    // Opaque surfaces cover all of their pixels, whatever their textures.
    for material in &mut caster.materials {
        if material.alpha == AlphaMode::Opaque {
            (material.base_color, material.opacity_map) = (None, None);
        }
    }
    caster
}

/// A unit vector across a unit direction, towards +X or, for directions near to that axis, towards `other`.
fn across(direction: DVec3, other: DVec3) -> DVec3 {
    let side = if direction.x * direction.x < 0.5 {
        DVec3::X
    } else {
        other
    };
    (side - direction * side.dot(direction)).normalize()
}

/// Coverage of the scene as seen from a direction, from far away.
struct Outline {
    right: DVec3,
    up: DVec3,
    /// Of the picture, in the world.
    width: f64,
    alpha: Vec<u8>,
}

impl Outline {
    fn new(caster: &mut Scene, place: &Place, direction: DVec3) -> Result<Self, RenderError> {
        let toward = direction.normalize();
        let right = across(toward, DVec3::Y);
        let up = toward.cross(right);
        let (middle, width) = (place.world(place.middle), 2.02 * place.radius);
        let eye = middle + place.world(toward) * (2.0 * place.radius);
        caster.camera = Camera {
            up: place.world(up),
            near: 0.5 * place.radius,
            far: 4.0 * place.radius,
            lens: Lens {
                parallel_width: Some(width),
                ..Lens::default()
            },
            ..Camera::look_at(eye, middle)
        };
        let frame = render(caster, &RenderSettings::new(OUTLINE, OUTLINE), &no_progress)?;
        let alpha = frame.rgba.as_chunks::<4>().0.iter().map(|[.., a]| *a);
        Ok(Self {
            right,
            up,
            width,
            alpha: alpha.collect(),
        })
    }

    /// Opacity before a point, by its way from the middle in the directions of the axes. Bilinear; nothing beyond the picture.
    fn opacity(&self, p: DVec3) -> f64 {
        let place = DVec2::new(p.dot(self.right), -p.dot(self.up)) / self.width + 0.5;
        let place = place * f64::from(OUTLINE) - 0.5;
        let first = place.floor();
        let part = place - first;
        let alpha = |x: f64, y: f64| {
            let inside = 0.0..f64::from(OUTLINE);
            if !(inside.contains(&x) && inside.contains(&y)) {
                return 0.0;
            }
            let at = y as usize * OUTLINE as usize + x as usize;
            self.alpha.get(at).map_or(0.0, |a| f64::from(*a) / 255.0)
        };
        let row = |y: f64| {
            let (a, b) = (alpha(first.x, y), alpha(first.x + 1.0, y));
            a + (b - a) * part.x
        };
        let (a, b) = (row(first.y), row(first.y + 1.0));
        a + (b - a) * part.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_light::{Environment, EnvironmentLayout, EnvironmentLight, Light, Prefilter};
    use texmap_math::deterministic_f64;

    fn scene(mesh: Mesh) -> Scene {
        Scene {
            materials: vec![Material::default()],
            meshes: vec![mesh],
            ..Scene::new(Camera::look_at([0.0, 2.0, 5.0], [0.0; 3]))
        }
    }

    /// A square of side 2 at this height, and a small triangle that marks the ground far below one of its corners.
    fn board(height: f32) -> Mesh {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let mut mesh = Mesh::quad(corners.map(|[x, z]| [x, height, z]));
        mesh.positions
            .extend([[3.0, 0.0, 3.0], [3.001, 0.0, 3.0], [3.0, 0.0, 3.001]]);
        mesh.positions
            .extend([[-3.0, 0.0, -3.0], [-3.001, 0.0, -3.0], [-3.0, 0.0, -3.001]]);
        mesh.uvs.extend([[0.0; 2]; 6]);
        mesh.triangles.extend([[4, 5, 6], [7, 8, 9]]);
        mesh.faces.clear();
        mesh
    }

    /// Share of the cosine-weighted sky that a square of side 2 at height `h` hides from the ground below its middle: four times the
    /// view factor of a rectangle with a corner over the point (Howell, C-11).
    fn hidden(h: f64) -> f64 {
        let x = 1.0 / h;
        let root = (1.0 + x * x).sqrt();
        4.0 * 2.0 * (x / root) * deterministic_f64::atan(x / root) / (2.0 * std::f64::consts::PI)
    }

    #[test]
    fn an_even_sky_is_hidden_by_the_view_factor() {
        for height in [0.5, 1.0, 2.0] {
            let scene = scene(board(height));
            let shadow = GroundShadow::new(&scene, DVec3::Y).unwrap().unwrap();
            let got = f64::from(shadow.opacity(0.5, 0.5));
            let right = hidden(f64::from(height));
            assert!((got - right).abs() < 0.03, "{height}: {got} {right}");
        }
    }

    /// A sky with a window, of three quarters of the light, before which the board hides the ground in part.
    fn window() -> EnvironmentLight {
        let toward = DVec3::new(1.0, 1.2, 0.0).normalize();
        let light = |d: DVec3| match d.dot(toward) > 0.98 {
            true => [60.0; 3],
            false => [0.5; 3],
        };
        let sky = Environment::from_fn(EnvironmentLayout::Cube, 64, light).unwrap();
        let light = Prefilter::new(&sky, 64).and_then(|mut sky| sky.light(Roughnesses::ALL));
        light.unwrap()
    }

    /// Along a line through the penumbra of a window: the share of its light by 512 x 512 rays. Of 128 shares in compact parts of the
    /// sky some 4 sqrt(128) = 45 are cut by the outline of the board, each right to half of itself: sqrt(45) / 2 / 128 = 0.026 is one
    /// standard deviation, the pixels of the outlines and the lobe of a cell add 0.03.
    #[test]
    fn a_window_has_a_soft_shadow() {
        let mut scene = scene(board(1.0));
        let light = window();
        scene.effects.environment_light = Some(light.clone());
        let shadow = GroundShadow::new(&scene, DVec3::Y).unwrap().unwrap();
        let [first, right, _, back] = shadow.corners();
        let at = |p: DVec3| {
            let along = |side: DVec3| (p - first).dot(side) / side.length_squared();
            f64::from(shadow.opacity(along(right - first), along(back - first)))
        };
        let rays: Vec<(DVec3, f64)> = (0..512 * 512)
            .map(|k| {
                let c = |k: u32| 2.0 * (f64::from(k) + 0.5) / 512.0 - 1.0;
                let (x, z) = (c(k % 512), c(k / 512));
                let d = DVec3::new(x, (1.0 - x * x - z * z).max(0.0).sqrt(), z);
                let light = light.radiance(0.0, d.to_array().map(|c| c as f32))[0];
                (d, if d.y > 0.0 { f64::from(light) } else { 0.0 })
            })
            .collect();
        let all: f64 = rays.iter().map(|(_, light)| light).sum();
        let (mut last, mut most, mut worst, mut steepest) = (None, 0.0_f64, 0.0_f64, 0.0_f64);
        for step in 0..60 {
            let p = DVec3::new(-2.4 + 0.04 * f64::from(step), first.y, 0.1);
            let hits = |d: DVec3| {
                let hit = p + d * ((1.0 - p.y) / d.y);
                hit.x.abs() < 1.0 && hit.z.abs() < 1.0
            };
            let hidden: f64 = rays.iter().filter(|(d, _)| hits(*d)).map(|(_, w)| w).sum();
            let got = at(p);
            worst = worst.max((got - hidden / all).abs());
            steepest = steepest.max((got - last.unwrap_or(got)).abs());
            most = most.max(hidden / all);
            last = Some(got);
        }
        assert!(most > 0.7, "{most}");
        assert!(worst < 0.08, "{worst}");
        // A direction with a quarter of the light would make a step of that much.
        assert!(steepest < 0.12, "{steepest}");
    }

    /// Light that was made for other roughnesses is not read.
    #[test]
    fn levels_that_are_missing_are_refused() {
        let mut scene = scene(board(1.0));
        let sky = Environment::from_fn(EnvironmentLayout::Cube, 16, |_| [1.0; 3]).unwrap();
        let mut sky = Prefilter::new(&sky, 16).unwrap();
        scene.effects.environment_light = sky.light(Roughnesses::NONE).ok();
        let error = GroundShadow::new(&scene, DVec3::Y).unwrap_err().to_string();
        assert!(error.starts_with("ground shadow: its roughness"), "{error}");
        scene.effects.environment_light = sky.light(GroundShadow::roughnesses()).ok();
        assert!(GroundShadow::new(&scene, DVec3::Y).is_ok());
    }

    /// Light of one direction alone throws the board sideways by its height.
    #[test]
    fn a_sun_throws_the_shadow_aside() {
        let mut scene = scene(board(1.0));
        scene.lights = vec![Light::Directional {
            color: [1.0; 3],
            direction: [1.0, -1.0, 0.0],
        }];
        let shadow = GroundShadow::new(&scene, DVec3::Y).unwrap().unwrap();
        let [first, right, _, back] = shadow.corners();
        let at = |x: f64, z: f64| {
            let p = DVec3::new(x, first.y, z) - first;
            let along = |side: DVec3| p.dot(side) / side.length_squared();
            shadow.opacity(along(right - first), along(back - first))
        };
        assert!(at(1.0, 0.0) > 0.9, "{}", at(1.0, 0.0));
        assert!(at(-0.5, 0.0) < 0.1 && at(1.0, 1.5) < 0.1);
    }

    #[test]
    fn the_square_lies_under_the_scene_along_either_axis() {
        for up in [DVec3::Y, DVec3::Z, DVec3::new(0.0, 3.0, 0.0)] {
            let mut scene = scene(Mesh::cube());
            let shadow = GroundShadow::new(&scene, up).unwrap().unwrap();
            let [a, b, c, _] = shadow.corners();
            let up = up.normalize();
            assert!((b - a).cross(c - a).normalize().dot(up) > 0.999_999);
            assert!((a.dot(up) + 1.0).abs() < 0.01 && (b - a).length() > 4.0);
            // Dark at the foot, clear at the edge.
            assert!(shadow.opacity(0.5, 0.5) > 0.9 && shadow.opacity(0.0, 0.0) == 0.0);
            shadow.add_to(&mut scene);
            scene.check().unwrap();
            assert_eq!((scene.meshes.len(), scene.textures.len()), (2, 1));
        }
        let none = scene(Mesh::default());
        assert!(GroundShadow::new(&none, DVec3::Y).unwrap().is_none());
    }

    #[test]
    fn scenes_with_wrong_indices_are_refused() {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 4.0], [0.0; 3]));
        scene.meshes = vec![Mesh {
            material: 7,
            ..Mesh::cube()
        }];
        assert!(GroundShadow::new(&scene, DVec3::Y).is_err());
    }
}
