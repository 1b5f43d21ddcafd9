//! A flat mirror: the scene seen from behind it, laid over it by the pixels of the picture.

use texmap_light::PhongMaterial;
use texmap_math::MemoryBudget;
use texmap_math::camera::{Camera, Lens};
use texmap_math::glam::DVec3;
use texmap_math::texture_frame::TextureFrame;
use texmap_raster::DepthTest;
use texmap_render::{Aov, AovData, RenderError, RenderSettings, no_progress, render};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Sampler, TexelData, Texture2d, Wrap,
};
use texmap_scene::{AlphaMode, Emission, Material, Mesh, Scene, SceneError, Shading, TextureSlot};

/// Part of the size of a mesh by which its points may lie beside one plane.
const FLAT: f64 = 1e-5;

/// A flat mesh that mirrors the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarMirror {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Share of the mirrored light in what is seen, 0 to 1; the rest is the surface's own.
    pub share: f32,
}

/// The scene with meshes that mirror it, for pictures of `width` x `height` pixels by its present camera.
///
/// The camera is reflected in the plane of each mesh, whatever lies behind that is cut away, and the picture that it sees is a layer over the
/// mesh, laid there by the pixels of the frame (projected reflection): `(1 - share) own + share mirrored`, whatever the surface's own
/// textures and light are. It is exact in every pixel centre, has the picture's resolution, and shows
/// other mirrors as surfaces without theirs. The mirror, and what is cut away, cast no shadow in it. A camera that moves needs it again.
///
/// Layers are meshes of their own before the first mesh that blends, and the scene's depth test lets the last of two surfaces at one depth be
/// seen ([`DepthTest::LessOrEqual`]).
///
/// # Errors
/// [`SceneError::Index`] for a mesh that does not exist; [`SceneError::Value`] for one that is not flat, not opaque, still to be tessellated,
/// or has the camera in its plane, for a share beyond 0 to 1, and for a parallel projection; those of [`render`].
pub fn with_planar_mirrors(
    scene: &Scene,
    mirrors: &[PlanarMirror],
    (width, height): (u32, u32),
) -> Result<Scene, RenderError> {
    let mut out = scene.clone();
    let blends = |mesh: &Mesh| {
        let material = scene.materials.get(mesh.material);
        material.is_some_and(|material| material.alpha == AlphaMode::Blend)
    };
    let before = scene.meshes.iter().position(blends);
    let before = before.unwrap_or(scene.meshes.len());
    for mirror in mirrors {
        let texture = mirrored_light(scene, mirror, (width, height))?;
        out.textures.push(texture);
        let layer = layer(scene, mirror, out.textures.len() - 1);
        out.materials.push(layer);
        let own = &scene.meshes[mirror.mesh];
        let frame = of_picture(&scene.camera, (width, height))?;
        let layer = Mesh {
            name: format!("{}, mirrored", own.name),
            material: out.materials.len() - 1,
            texture_frame: Some(frame.transform(own.world_from_object.inverse())),
            uv_projection: None,
            uv_origin: Origin::TopLeft,
            casts_no_shadow: true,
            ..own.clone()
        };
        out.meshes.insert(before, layer);
    }
    if !mirrors.is_empty() && out.depth_test == DepthTest::Less {
        out.depth_test = DepthTest::LessOrEqual;
    }
    Ok(out)
}

/// The light that a mirror shows, a texel for each pixel, its columns from right to left.
fn mirrored_light(
    scene: &Scene,
    mirror: &PlanarMirror,
    (width, height): (u32, u32),
) -> Result<Texture2d<'static>, RenderError> {
    let own = scene.meshes.get(mirror.mesh).ok_or(SceneError::Index {
        place: "mirror".to_owned(),
        what: "mesh",
        index: mirror.mesh as u64,
        count: scene.meshes.len(),
    })?;
    let refused = |what: &str, value: String, expected: &'static str| -> RenderError {
        SceneError::Value {
            place: format!("mirror '{}'", own.name),
            what: what.to_owned(),
            value,
            expected,
        }
        .into()
    };
    if !(0.0..=1.0).contains(&mirror.share) {
        let share = mirror.share.to_string();
        return Err(refused("share", share, "a share of 0 to 1"));
    }
    let camera = scene.camera;
    if camera.lens.parallel_width.is_some() {
        let expected = "a central projection: a texture frame has rays from one eye";
        return Err(refused("camera", "parallel".to_owned(), expected));
    }
    let material = scene.materials.get(own.material);
    let material = material.ok_or(SceneError::Index {
        place: format!("mirror '{}'", own.name),
        what: "material",
        index: own.material as u64,
        count: scene.materials.len(),
    })?;
    if material.alpha != AlphaMode::Opaque {
        let expected = "an opaque surface: its mirror covers all of it";
        return Err(refused(
            "material",
            format!("'{}'", material.name),
            expected,
        ));
    }
    if !own.is_tessellated() {
        let expected = "triangles: texmap_mesh::tessellate makes them";
        return Err(refused(
            "shape",
            "a displacement or billboards".to_owned(),
            expected,
        ));
    }
    let plane = Plane::of(own, camera.eye).map_err(|problem| {
        refused(
            "shape",
            problem.to_owned(),
            "points in one plane, the camera not in it",
        )
    })?;
    let mut behind = scene.clone();
    behind.camera = plane.mirrored(&camera);
    behind.meshes.remove(mirror.mesh);
    for mesh in &mut behind.meshes {
        *mesh = plane.before(mesh);
    }
    behind.effects.tone_mapping = Default::default();
    let mut settings = RenderSettings::new(width, height);
    settings.aovs.push(Aov::Color);
    let frame = render(&behind, &settings, &no_progress)?;
    let light = frame.aovs.iter().find_map(|(_, _, values)| match values {
        AovData::F32(values) => Some(values),
        AovData::U32(_) => None,
    });
    let texels: Vec<f32> = light
        .into_iter()
        .flat_map(|values| values.as_chunks::<4>().0)
        .flat_map(|[r, g, b, _]| [*r, *g, *b])
        .collect();
    MemoryBudget::of_process().ask(
        u64::from(width) * u64::from(height) * 28,
        format_args!("a mirror of {width} x {height} pixels"),
        "draw a smaller picture",
    )?;
    let picture = Texture2d::new(&Image {
        width,
        height,
        channels: 3,
        texels: TexelData::F32(&texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::TopLeft,
    });
    picture.map_err(|e| refused("light", e.to_string(), "finite light"))
}

/// A surface of mirrored light alone, blended by its share.
fn layer(scene: &Scene, mirror: &PlanarMirror, texture: usize) -> Material {
    let own = &scene.materials[scene.meshes[mirror.mesh].material];
    Material {
        name: format!("{}, mirrored", own.name),
        phong: PhongMaterial {
            color: [0.0; 3],
            ..PhongMaterial::default()
        },
        shading: Shading::Unlit,
        opacity: mirror.share,
        alpha: AlphaMode::Blend,
        cull: own.cull,
        emission: Some(Emission {
            color: [1.0; 3],
            map: Some(TextureSlot {
                sampler: Sampler {
                    filter: Filter::Bilinear,
                    wrap_u: Wrap::ClampToEdge,
                    wrap_v: Wrap::ClampToEdge,
                    ..Sampler::default()
                },
                ..TextureSlot::new(texture)
            }),
        }),
        ..Material::default()
    }
}

/// The frame of the picture before the eye, its columns from right to left: those of the reflected camera.
fn of_picture(camera: &Camera, (width, height): (u32, u32)) -> Result<TextureFrame, SceneError> {
    let ray = |x: f64, y: f64| camera.ray(width, height, x, y).map_err(SceneError::Camera);
    let (w, h) = (f64::from(width), f64::from(height));
    let corner = ray(w, 0.0)?;
    Ok(TextureFrame {
        o: camera.eye + corner,
        u: ray(0.0, 0.0)? - corner,
        v: ray(w, h)? - corner,
    })
}

/// The plane of a mirror, its normal to the side of the camera.
struct Plane {
    point: DVec3,
    normal: DVec3,
    /// Height up to which a point lies in the plane.
    flat: f64,
}

impl Plane {
    fn of(mesh: &Mesh, eye: DVec3) -> Result<Self, &'static str> {
        let world = |i: u32| {
            let p = mesh.positions.get(i as usize).copied().unwrap_or_default();
            mesh.world_from_object
                .transform_point3(DVec3::from(p.map(f64::from)))
        };
        let cross = |t: &[u32; 3]| {
            let [a, b, c] = t.map(world);
            (b - a).cross(c - a)
        };
        let largest = mesh
            .triangles
            .iter()
            .max_by(|a, b| cross(a).length().total_cmp(&cross(b).length()));
        let Some(largest) = largest else {
            return Err("no triangle");
        };
        let normal = cross(largest).normalize_or_zero();
        if normal == DVec3::ZERO || !normal.is_finite() {
            return Err("no triangle with an area");
        }
        let point = world(largest[0]);
        let corners = || mesh.triangles.iter().flatten().map(|i| world(*i));
        let size = corners().map(|p| (p - point).length()).fold(0.0, f64::max);
        let flat = FLAT * size;
        let beside = corners().any(|p| (p - point).dot(normal).abs() > flat);
        let height = (eye - point).dot(normal);
        match (beside, height.abs() > flat) {
            (true, _) => Err("not flat"),
            (false, false) => Err("seen from the side"),
            (false, true) => Ok(Self {
                point,
                normal: normal * height.signum(),
                flat,
            }),
        }
    }

    fn height(&self, p: DVec3) -> f64 {
        (p - self.point).dot(self.normal)
    }

    /// A camera behind the mirror, which sees left and right exchanged.
    fn mirrored(&self, camera: &Camera) -> Camera {
        let point = |p: DVec3| p - self.normal * (2.0 * self.height(p));
        let [x, y] = camera.lens.center;
        Camera {
            eye: point(camera.eye),
            look: point(camera.look),
            up: camera.up - self.normal * (2.0 * camera.up.dot(self.normal)),
            lens: Lens {
                center: [-x, y],
                ..camera.lens
            },
            ..*camera
        }
    }

    /// The part of a mesh before the mirror: triangles across the plane are cut, and those in it left out, as the rest of a floor whose tile
    /// is the mirror.
    fn before(&self, mesh: &Mesh) -> Mesh {
        let heights: Vec<f64> = mesh
            .positions
            .iter()
            .map(|p| {
                let p = DVec3::from(p.map(f64::from));
                self.height(mesh.world_from_object.transform_point3(p))
            })
            .collect();
        if heights.iter().all(|h| *h > self.flat) {
            return mesh.clone();
        }
        let mut out = Mesh {
            triangles: Vec::new(),
            faces: Vec::new(),
            watertight: false,
            ..mesh.clone()
        };
        for (number, triangle) in mesh.triangles.iter().enumerate() {
            let face = mesh.face(number as u32);
            let height = |i: &u32| heights.get(*i as usize).copied().unwrap_or(0.0);
            if triangle.iter().all(|i| height(i) <= self.flat) {
                continue;
            }
            let mut corners: Vec<u32> = Vec::with_capacity(4);
            for (k, a) in triangle.iter().copied().enumerate() {
                let b = triangle[(k + 1) % 3];
                let [ha, hb] = [a, b].map(|i| height(&i));
                if ha >= 0.0 {
                    corners.push(a);
                }
                if (ha >= 0.0) != (hb >= 0.0) {
                    corners.push(between(&mut out, a, b, (ha / (ha - hb)) as f32));
                }
            }
            for k in 2..corners.len() {
                out.triangles.push([corners[0], corners[k - 1], corners[k]]);
                out.faces.push(face);
            }
        }
        out
    }
}

/// A vertex at part `t` of the way from one to another.
fn between(mesh: &mut Mesh, a: u32, b: u32, t: f32) -> u32 {
    fn mix<const N: usize>(all: &mut Vec<[f32; N]>, a: u32, b: u32, t: f32) {
        if let (Some(from), Some(to)) = (all.get(a as usize).copied(), all.get(b as usize).copied())
        {
            all.push(std::array::from_fn(|k| from[k] * (1.0 - t) + to[k] * t));
        }
    }
    let index = mesh.positions.len() as u32;
    mix(&mut mesh.positions, a, b, t);
    mix(&mut mesh.normals, a, b, t);
    mix(&mut mesh.tangents, a, b, t);
    mix(&mut mesh.uvs, a, b, t);
    mix(&mut mesh.lightmap_uvs, a, b, t);
    mix(&mut mesh.colors, a, b, t);
    index
}
