//! Textures that fill space: carved patterns, and volumes seen through.

use texmap_math::color::linear_to_srgb8;
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec3};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Pattern, TexelData, Texture3d, Wrap, gradient_noise,
    reference,
};
use texmap_scene::{
    Material, Mesh, Scene, Shading, SolidTexture, SolidTextureSource, TextureSlot, Volume,
};

use super::lit::{Lit, ball, floor, matte};
use super::sheet::sheet;
use super::{DemoPicture, stage};
use crate::LabError;
use texmap_truth::picture::Picture;

/// A material carved out of a pattern whose unit is `unit` wide.
fn carved(pattern: Pattern, unit: f64, at: DVec3, shading: Shading) -> Material {
    Material {
        solid: Some(SolidTexture {
            source: SolidTextureSource::Pattern(pattern),
            world_from_solid: DMat4::from_translation(at) * DMat4::from_scale(DVec3::splat(unit)),
        }),
        shading,
        ..matte([1.0; 3], 0.0)
    }
}

const MARBLE: [[u8; 4]; 4] = [
    [58, 62, 74, 255],
    [190, 190, 194, 255],
    [236, 234, 229, 255],
    [247, 246, 243, 255],
];
const WOOD: [[u8; 4]; 4] = [
    [214, 166, 106, 255],
    [200, 148, 86, 255],
    [168, 112, 58, 255],
    [104, 60, 28, 255],
];

pub(super) fn solids(size: u32) -> Result<DemoPicture, LabError> {
    let eye = DVec3::new(0.0, 2.2, 5.6);
    let mut still = stage::scene(eye, DVec3::new(0.0, 0.7, 0.0), 36.0);
    still.lights = stage::daylight(0.25, [0.85; 3], [-0.6, -1.0, -0.7]);
    let marble = Pattern::Marble {
        octaves: 5,
        turbulence: 1.2,
    };
    let wood = Pattern::Wood { grain: 0.25 };
    let light = stage::ramp(&mut still, &MARBLE, Filter::Bilinear)?;
    let brown = stage::ramp(&mut still, &WOOD, Filter::Bilinear)?;
    let first = Material {
        color_ramp: Some(light),
        ..carved(marble, 0.6, DVec3::ZERO, Shading::PerPixel)
    };
    let second = Material {
        color_ramp: Some(brown.clone()),
        ..carved(wood, 0.16, DVec3::new(1.1, 1.3, 0.0), Shading::PerPixel)
    };
    let first = stage::add(&mut still, first);
    let second = stage::add(&mut still, second);
    still
        .meshes
        .push(ball(DVec3::new(-1.05, 0.9, 0.0), 0.9, first));
    let mut block = stage::cube(DVec3::new(1.0, 0.75, 0.0), 35.0, second);
    block.world_from_object *= DMat4::from_scale(DVec3::splat(0.75));
    still.meshes.push(block);
    let ground = stage::add(&mut still, matte([0.35, 0.36, 0.4], 0.0));
    still.meshes.push(floor(30.0, ground));

    // A ball of one octave of noise, unlit: every pixel against the f64 noise of its point.
    let noise = Pattern::Noise { octaves: 1 };
    let mut bare = stage::scene(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 30.0);
    let plain = carved(noise, 0.35, DVec3::ZERO, Shading::Unlit);
    let plain = stage::add(&mut bare, plain);
    bare.meshes.push(ball(DVec3::ZERO, 1.1, plain));
    let side = size.max(256);
    let seen = Lit::take(&bare, side)?;
    let (mut off, mut wrapped, mut covered) = (0u32, 0u32, 0u32);
    for (i, p) in seen
        .position
        .iter()
        .enumerate()
        .filter(|(_, p)| p.is_finite())
    {
        // At the limb a pixel is wider than the noise, which fades there.
        if seen.normal[i].dot((bare.camera.eye - *p).normalize_or_zero()) < 0.3 {
            continue;
        }
        let q = (*p / 0.35).to_array();
        let code = |v: f64| i32::from(linear_to_srgb8((0.5 + 0.5 * v).clamp(0.0, 1.0) as f32));
        let found = i32::from(seen.picture.rgba()[4 * i]);
        off += u32::from((found - code(reference::gradient_noise(q, 0))).abs() > 1);
        // The same noise as a picture of longitude and latitude, wrapped around.
        let n = p.normalize_or_zero();
        let (u, v) = (
            deterministic_f64::atan2(n.x, n.z),
            deterministic_f64::atan2(n.y, (1.0 - n.y * n.y).max(0.0).sqrt()),
        );
        let flat = gradient_noise([(u * 3.0) as f32, (v * 3.0) as f32, 0.5], 0);
        wrapped += u32::from((found - code(f64::from(flat))).abs() > 16);
        covered += 1;
    }

    // Rings to the horizon: filtered by the pixel's width, and looked up at its centre.
    let mut far = stage::scene(DVec3::new(0.0, 0.6, 0.0), DVec3::new(0.0, 0.25, -3.0), 50.0);
    let rings = Pattern::Wood { grain: 0.0 };
    let rings = carved(rings, 0.25, DVec3::new(0.3, 0.0, -1.0), Shading::Unlit);
    let mut upright = rings;
    if let Some(solid) = &mut upright.solid {
        // About the vertical, so that the floor shows circles.
        solid.world_from_solid *= DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2);
    }
    let upright = stage::add(&mut far, upright);
    far.meshes.push(floor(60.0, upright));
    let truth = stage::picture(&far, size, 16)?;
    let filtered = Lit::take(&far, size)?;
    let centre = filtered.painted(|_, p| {
        let q = p - DVec3::new(0.3, 0.0, -1.0);
        let r = (q.x * q.x + q.z * q.z).sqrt() / 0.25;
        Some([(r - r.floor()) as f32; 3])
    });
    let error = |p: &Picture| {
        let all = (0..(size * size) as usize).filter(|i| filtered.position[*i].is_finite());
        let (mut sum, mut n) = (0.0, 0.0);
        for i in all {
            sum += f64::from(super::lit::difference(p, &truth, i));
            n += 1.0;
        }
        sum / n
    };
    let percent = |n: u32| 100.0 * f64::from(n) / f64::from(covered.max(1));
    let (by_width, by_centre) = (error(&filtered.picture), error(&centre));
    let claims = claims![
        "pixels of a ball of noise more than 1/255 off the f64 noise" => off.into(), 0.0, 0.0;
        "the same noise wrapped around by longitude: % more than 16/255 off" => percent(wrapped), 60.0, 20.0;
        "rings to the horizon, filtered by the pixel's width: mean error, /255" => by_width, 0.0, 6.0;
        "the same looked up at the pixel's centre: mean error, /255" => by_centre, 14.0, 10.0;
    ];
    let panels = panels![
        stage::photograph(&still, size)? =>
            "Carved out of space",
            "Marble and wood as functions of the point: no coordinates, no seams, rings run through the block.";
        shrunk(&seen.picture, size) =>
            "Gradient noise", "One octave on a ball: the f64 noise of every point.";
        filtered.picture.clone() =>
            "Rings, filtered", "Each pixel sees the mean over its width: grey from afar.";
        centre => "Rings at pixel centres", "The naive look-up: moire where rings are finer than pixels.";
    ];
    Ok(sheet(
        "Solid textures: colour as a function of space",
        panels,
        claims,
    ))
}

fn shrunk(picture: &Picture, size: u32) -> Picture {
    let at = |i: u32| i64::from(i * picture.width() / size);
    Picture::from_fn(size, size, |x, y| picture.get(at(x), at(y)))
}

/// A grid of one number a voxel.
fn grid(side: u32, value: impl Fn(DVec3) -> f64) -> Result<Texture3d<'static>, LabError> {
    let place = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let voxels: Vec<f32> = (0..side * side * side)
        .map(|i| {
            value(DVec3::new(
                place(i % side),
                place(i / side % side),
                place(i / side / side),
            )) as f32
        })
        .collect();
    Ok(Texture3d::new(
        side,
        &Image {
            width: side,
            height: side,
            channels: 1,
            texels: TexelData::F32(&voxels),
            color: ColorSpace::Linear,
            alpha: Alpha::Data,
            origin: Origin::TopLeft,
        },
    )?)
}

/// A box of edge 2 about the origin.
fn boxed(density: f32, step: f32, transfer: Option<TextureSlot>) -> Volume {
    Volume {
        grid: 0,
        sampler: stage::sampler(Filter::Bilinear, Wrap::ClampToEdge),
        transfer,
        density,
        step,
        world_from_volume: DMat4::from_translation(DVec3::splat(-1.0))
            * DMat4::from_scale(DVec3::splat(2.0)),
    }
}

pub(super) fn volumes(size: u32) -> Result<DemoPicture, LabError> {
    let black = [0.0, 0.0, 0.0, 1.0];
    let eye = DVec3::new(2.6, 1.8, 3.6);
    // Homogeneous matter: the closed form at every pixel.
    let mut even = stage::scene(eye, DVec3::ZERO, 42.0);
    even.background = black;
    even.effects.grids = vec![grid(1, |_| 1.0)?];
    even.effects.volumes = vec![boxed(0.8, 10.0, None)];
    let picture = stage::picture(&even, size, 1)?;
    even.effects.volumes[0].step = 0.013;
    let fine = stage::picture(&even, size, 1)?;
    let lengths = chords(&even, size)?;
    let code = |a: f64| i32::from(linear_to_srgb8(a as f32));
    let (mut wrong, mut stepped, mut naive) = (0u32, 0u32, 0u32);
    for (i, length) in lengths.iter().enumerate() {
        let found = |p: &Picture| i32::from(p.rgba()[4 * i]);
        wrong += u32::from(
            (found(&picture) - code(1.0 - deterministic_f64::exp(-0.8 * length))).abs() > 1,
        );
        stepped += u32::from((found(&picture) - found(&fine)).abs() > 1);
        // A fixed opacity a step, whatever its length.
        let fixed =
            |step: f64| code(1.0 - deterministic_f64::pow(1.0 - 0.1, (length / step).ceil()));
        naive += u32::from((fixed(0.1) - fixed(0.05)).abs() > 1 && *length > 0.0);
    }
    let inside = lengths.iter().filter(|l| **l > 0.0).count().max(1);

    // A shell with a core of noise.
    let matter = |p: DVec3| {
        let q = 2.0 * p - DVec3::ONE;
        let r = q.length();
        let fold = gradient_noise((p * 6.0).as_vec3().to_array(), 0);
        let core = (1.0 - r / 0.62 + 0.35 * f64::from(fold)).clamp(0.0, 1.0);
        let shell = (1.0 - ((r - 0.85) / 0.06).abs()).clamp(0.0, 1.0);
        (0.6 * core + 0.4).min(1.0) * core.min(1.0).max(0.35 * shell)
    };
    let mut cloud = stage::scene(eye, DVec3::ZERO, 42.0);
    cloud.background = [0.05, 0.06, 0.09, 1.0];
    cloud.effects.grids = vec![grid(48, matter)?];
    cloud.effects.volumes = vec![boxed(2.0, 0.02, None)];
    let gray = stage::picture(&cloud, size, 1)?;
    let stops = [
        [0, 0, 0, 0],
        [70, 120, 220, 26],
        [60, 160, 210, 40],
        [250, 150, 40, 160],
        [255, 235, 170, 255],
        [255, 255, 240, 255],
    ];
    let heat = stage::ramp(&mut cloud, &stops, Filter::Bilinear)?;
    cloud.effects.volumes = vec![boxed(9.0, 0.02, Some(heat))];
    let colored = stage::picture(&cloud, size, 1)?;
    let red = stage::add(&mut cloud, matte([0.7, 0.1, 0.08], 0.4));
    cloud
        .meshes
        .push(ball(DVec3::new(0.45, 0.0, 0.35), 0.4, red));
    cloud.lights = stage::daylight(0.3, [0.8; 3], [1.0, -1.0, -0.6]);
    cloud.camera.eye = DVec3::new(-0.5, 0.1, 0.75);
    cloud.camera.look = DVec3::new(0.3, 0.0, 0.1);
    cloud.camera.fov_x = 1.4;
    cloud.effects.volumes[0].density = 3.0;
    let within = stage::picture(&cloud, size, 1)?;

    // Time and error of ending a ray early.
    let dense = grid(1, |_| 1.0)?;
    let sampler = stage::sampler(Filter::Bilinear, Wrap::ClampToEdge);
    let thick = texmap_sample::VolumeIntegrator::new(&dense, &sampler, None, 40.0, 0.005)?;
    let seen = thick.integrate([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0], (0.0, f64::INFINITY));
    let saved = 100.0 * (1.0 - f64::from(seen.steps) / 200.0);
    let claims = claims![
        "pixels more than 1/255 off 1 - exp(-density length), one step" => wrong.into(), 0.0, 0.0;
        "pixels that change between steps of 10 and of 0.013" => stepped.into(), 0.0, 0.0;
        "with one opacity for every step, % that change when steps are halved" =>
            100.0 * f64::from(naive) / inside as f64, 100.0, 10.0;
        "steps saved by ending where 1/4096 is left, % (density 40)" => saved, 79.0, 2.0;
        "opacity lost by it, /255" => 255.0 * (1.0 - deterministic_f64::exp(-40.0) - f64::from(seen.color[3])), 0.0, 0.1;
    ];
    let panels = panels![
        picture => "Homogeneous", "A white fog box: 1 - exp(-tau) at every pixel, whatever the step.";
        gray => "A grid of 48 x 48 x 48", "Density is the voxel; a shell around folded matter.";
        colored =>
            "With a transfer function",
            "The voxel is looked up along a ramp of colour and alpha: a dependent look-up.";
        within => "The eye inside", "Rays begin at the eye and end at the ball that is solid.";
    ];
    Ok(sheet(
        "Volumes: emission and absorption along rays",
        panels,
        claims,
    ))
}

/// Length of every pixel's ray inside of the box of edge 2, from a cube's near and far sides.
fn chords(scene: &Scene, size: u32) -> Result<Vec<f64>, LabError> {
    let sides = |cull| -> Result<Vec<DVec3>, LabError> {
        let mut only = Scene {
            effects: Default::default(),
            ..scene.clone()
        };
        let material = Material {
            cull,
            ..matte([1.0; 3], 0.0)
        };
        let material = stage::add(&mut only, material);
        let cube: Mesh = stage::cube(DVec3::ZERO, 0.0, material);
        only.meshes = vec![cube];
        Ok(Lit::take(&only, size)?.position)
    };
    let near = sides(texmap_raster::Cull::Back)?;
    let far = sides(texmap_raster::Cull::Front)?;
    let length = |(a, b): (&DVec3, &DVec3)| {
        if a.is_finite() && b.is_finite() {
            (*a - *b).length()
        } else {
            0.0
        }
    };
    Ok(near.iter().zip(&far).map(length).collect())
}
