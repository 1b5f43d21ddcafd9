//! Skies, and what is put onto surfaces: letters, labels and ramps.

use texmap_light::{Chart, Environment, Light};
use texmap_math::color::linear_to_srgb8;
use texmap_math::glam::DVec3;
use texmap_mesh::Font;
use texmap_render::Settings;
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d, UvTransform, Wrap};
use texmap_scene::{AlphaMode, Backdrop, Material, Scene, Shading, TextureRole, TextureSlot};

use super::lit::{ball, difference, matte};
use super::sheet::sheet;
use super::{Claim, DemoPicture, Panel, stage};
use crate::LabError;
use crate::picture::Picture;

fn slot(texture: usize, filter: Filter, wrap: Wrap) -> TextureSlot {
    TextureSlot {
        texture,
        sampler: Sampler {
            filter,
            wrap_u: wrap,
            wrap_v: wrap,
            ..Sampler::default()
        },
        transform: UvTransform::default(),
    }
}

fn render(scene: &Scene, size: u32, supersample: u32) -> Result<Picture, LabError> {
    let settings = Settings {
        supersample,
        ..Settings::new(size, size)
    };
    let frame = texmap_render::render(scene, &settings, &|_, _| {})?;
    Ok(Picture::from_rgba(size, size, frame.rgba)
        .unwrap_or_else(|| Picture::new(size, size, [0; 4])))
}

fn changed(a: &Picture, b: &Picture, by: u8) -> f64 {
    let n = (a.width() * a.height()) as usize;
    (0..n).filter(|i| difference(a, b, *i) > by).count() as f64
}

/// Light of a sky: blue above, pale at the horizon, sand below, a sun.
fn sky(d: DVec3) -> [f32; 3] {
    let up = d.normalize_or_zero().y;
    let sun = d
        .normalize_or_zero()
        .dot(DVec3::new(0.35, 0.4, -0.85).normalize());
    let blend = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t);
    let base = if up > 0.0 {
        blend([0.75, 0.82, 0.88], [0.10, 0.25, 0.62], up.sqrt())
    } else {
        blend([0.55, 0.48, 0.36], [0.20, 0.17, 0.12], (-up).sqrt())
    };
    let glow = ((sun - 0.985) / 0.015).clamp(0.0, 1.0);
    blend(base, [1.0, 0.95, 0.8], glow).map(|c| c as f32)
}

/// The same sky as a picture: columns are the view's own.
fn sky_picture(side: u32) -> Picture {
    let mut picture = Picture::new(side, side, [0, 0, 0, 255]);
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(side) - 0.5;
        let [r, g, b] = sky(DVec3::new(1.6 * at(x), -1.2 * at(y) + 0.2, -1.0)).map(linear_to_srgb8);
        picture.set(x.into(), y.into(), [r, g, b, 255]);
    }
    picture
}

fn bricks() -> Picture {
    let mut picture = Picture::new(32, 32, [205, 198, 188, 255]);
    for (row, y) in (0..32).step_by(8).enumerate() {
        for x in (0..64).step_by(16) {
            let left = x - 8 * (row as i64 % 2);
            picture.fill(
                left + 1,
                y + 1,
                14,
                6,
                [158, 72 + 8 * (row as u8 % 2), 58, 255],
            );
        }
    }
    picture
}

pub(super) fn skies(size: u32) -> Result<DemoPicture, LabError> {
    let wall = |scene: &mut Scene, repeats: f32| -> Result<(), LabError> {
        let texture = stage::texture(scene, &bricks())?;
        let material = stage::decal(
            scene,
            texture,
            Filter::Trilinear,
            texmap_raster::Interp::Perspective,
        );
        let corners = [[-2.2, 0.9], [2.6, 0.9], [2.6, -1.2], [-2.2, -1.2]];
        let corners = corners.map(|[x, y]| DVec3::new(x, y, -0.35 * x));
        let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[u, v]: [f32; 2]| [u * repeats, v * 0.5 * repeats]);
        scene.meshes.push(stage::quad(corners, uv, material));
        Ok(())
    };
    let view = |yaw: f64| {
        let (sin, cos) = texmap_math::det::sin_cos(yaw);
        stage::scene(
            DVec3::new(0.0, 0.2, 5.0),
            DVec3::new(4.0 * sin, 0.3, 5.0 - 4.0 * cos),
            50.0,
        )
    };
    let picture = sky_picture(256);
    let stretched = |yaw: f64, filter: Filter, with_wall: bool| -> Result<Scene, LabError> {
        let mut scene = view(yaw);
        let texture = stage::texture(&mut scene, &picture)?;
        scene.effects.backdrop = Some(Backdrop::Picture(slot(texture, filter, Wrap::ClampToEdge)));
        if with_wall {
            wall(&mut scene, 6.0)?;
        }
        Ok(scene)
    };
    let around = |yaw: f64, with_wall: bool| -> Result<Scene, LabError> {
        let mut scene = view(yaw);
        scene.effects.environments = vec![Environment::from_fn(Chart::TanCube, 128, sky)?];
        scene.effects.backdrop = Some(Backdrop::Environment(0));
        if with_wall {
            wall(&mut scene, 6.0)?;
        }
        Ok(scene)
    };
    // The picture itself, texel by texel.
    let still = render(&stretched(0.0, Filter::Nearest, false)?, size, 1)?;
    let turned = render(&stretched(0.4, Filter::Nearest, false)?, size, 1)?;
    let mut off = 0u32;
    for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
        let at = |i: u32| ((f64::from(i) + 0.5) / f64::from(size) * 256.0).floor() as i64;
        off += u32::from(still.get(x.into(), y.into()) != picture.get(at(x), at(y)));
    }
    let bare = around(0.3, false)?;
    let seen = render(&bare, size, 1)?;
    let mut wrong = 0u32;
    for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
        let ray = bare
            .camera
            .ray(size, size, f64::from(x) + 0.5, f64::from(y) + 0.5)?;
        let truth = sky(ray).map(linear_to_srgb8);
        let found = seen.get(x.into(), y.into());
        wrong += u32::from((0..3).any(|k| truth[k].abs_diff(found[k]) > 6));
    }
    let pixels = f64::from(size) * f64::from(size);
    let straight = render(&around(0.0, false)?, size, 1)?;
    let claims = vec![
        Claim::new(
            "pixels of the stretched picture that are not their texel",
            off.into(),
            0.0,
            0.0,
        ),
        Claim::new(
            "its pixels that change when the eye turns by 0.4",
            changed(&still, &turned, 0),
            0.0,
            0.0,
        ),
        Claim::new(
            "environment: % of pixels more than 6/255 off the light of their direction",
            100.0 * f64::from(wrong) / pixels,
            0.0,
            3.0,
        ),
        Claim::new(
            "its % of pixels that change when the eye turns by 0.3",
            100.0 * changed(&straight, &seen, 1) / pixels,
            15.0,
            12.0,
        ),
    ];
    let both = |scene: Scene| render(&scene, size, 3);
    let mut stretched_wall = stretched(0.0, Filter::Trilinear, false)?;
    wall(&mut stretched_wall, 1.0)?;
    let panels = vec![
        Panel::new(
            both(stretched(0.0, Filter::Trilinear, true)?)?,
            "Tile the wall, stretch the sky",
            "Bricks repeat; one picture fills the frame behind them.",
        ),
        Panel::new(
            both(stretched(0.3, Filter::Trilinear, true)?)?,
            "The eye turns: a backdrop does not",
            "The stretched sky goes with the eye: its sun has not moved.",
        ),
        Panel::new(
            both(around(0.3, true)?)?,
            "An environment sky",
            "Light by direction: the sun stays where it is in the world.",
        ),
        Panel::new(
            both(stretched_wall)?,
            "The wall stretched",
            "One picture over the whole wall: bricks as large as doors.",
        ),
    ];
    Ok(sheet(
        "Skies: a stretched backdrop and an environment",
        panels,
        claims,
    ))
}

/// Letters on a board; `crisp` or the filtered alpha as it is.
fn letters(words: &str, crisp: bool, filter: Filter, shift: f64) -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 40.0);
    let (texture, font) = texmap_io::built_in_font()?;
    scene.textures.push(texture);
    let ink = Material {
        base_color: Some(slot(0, filter, Wrap::ClampToEdge)),
        texture_role: TextureRole::Modulate,
        shading: Shading::Unlit,
        alpha: AlphaMode::Blend,
        crisp,
        ..matte([0.02, 0.03, 0.10], 0.0)
    };
    let ink = stage::add(&mut scene, ink);
    scene.background = [0.96, 0.94, 0.88, 1.0];
    let font: Font = font;
    let lines = words.lines().count() as f64;
    let columns = words.lines().map(|l| l.chars().count()).max().unwrap_or(1) as f64;
    let wide = 2.5 / columns;
    let up = DVec3::new(-0.12, 1.2 * wide, 0.0);
    let origin = DVec3::new(-1.25 + shift, 0.5 * lines * up.y - up.y, 0.0);
    scene
        .meshes
        .push(font.mesh(words, origin, DVec3::new(wide, 0.1 * wide, 0.0), up, ink));
    Ok(scene)
}

pub(super) fn labels(size: u32) -> Result<DemoPicture, LabError> {
    let words = "Rg&";
    // Truth: the outline at half alpha, cut at each of 16 x 16 samples.
    let mut cut = letters(words, false, Filter::Bilinear, 0.0)?;
    cut.materials[0].alpha = AlphaMode::Test(0.5);
    let truth = render(&cut, size, 16)?;
    let crisp = render(&letters(words, true, Filter::Bilinear, 0.0)?, size, 1)?;
    let soft = render(&letters(words, false, Filter::Bilinear, 0.0)?, size, 1)?;
    let blocky = render(&letters(words, false, Filter::Nearest, 0.0)?, size, 1)?;
    let rmse = |p: &Picture| {
        let n = (size * size) as usize;
        let sum: f64 = (0..n)
            .map(|i| f64::from(difference(p, &truth, i)).powi(2))
            .sum();
        (sum / n as f64).sqrt()
    };
    let (a, b, c) = (rmse(&crisp), rmse(&soft), rmse(&blocky));

    // A label over marble, lit.
    let mut box_scene = stage::scene(DVec3::new(1.6, 1.3, 4.2), DVec3::ZERO, 36.0);
    box_scene.lights = vec![
        Light::Ambient { color: [0.3; 3] },
        Light::Directional {
            color: [0.8; 3],
            direction: [-0.4, -0.8, -1.0],
        },
    ];
    let base = stage::texture(&mut box_scene, &bricks())?;
    let mut label = Picture::new(64, 64, [0; 4]);
    for (x, y) in (0..64i64).flat_map(|y| (0..64i64).map(move |x| (x, y))) {
        let r = (((x - 32) * (x - 32) + (y - 32) * (y - 32)) as f64).sqrt();
        if r < 26.0 {
            label.set(
                x,
                y,
                if r > 20.0 {
                    [250, 250, 245, 255]
                } else {
                    [40, 90, 170, 128]
                },
            );
        }
    }
    let sticker = stage::texture(&mut box_scene, &label)?;
    let clear = Wrap::ClampToBorder;
    let labelled = Material {
        base_color: Some(slot(base, Filter::Trilinear, Wrap::Repeat)),
        decal: Some(slot(sticker, Filter::Trilinear, clear)),
        ..matte([1.0; 3], 0.0)
    };
    let labelled = stage::add(&mut box_scene, labelled);
    box_scene
        .meshes
        .push(stage::cube(DVec3::ZERO, 0.0, labelled));
    let decal = render(&box_scene, size, 3)?;
    // Its colours by the formula, unlit and straight on.
    let mut flat = stage::scene(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, 30.0);
    flat.textures.clone_from(&box_scene.textures);
    let corners =
        [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let mut over = box_scene.materials[labelled].clone();
    over.shading = Shading::Unlit;
    over.base_color = Some(slot(base, Filter::Nearest, Wrap::Repeat));
    over.decal = Some(slot(sticker, Filter::Nearest, clear));
    let over = stage::add(&mut flat, over);
    flat.meshes.push(stage::quad(corners, stage::UNIT_UV, over));
    let shot = stage::Shot::take(&flat, size)?;
    let (mut off, mut inside) = (0u32, 0u32);
    for (x, y) in shot.pixels() {
        let Some(uv) = shot.uv(x, y) else { continue };
        let at = |p: &Picture| {
            let place =
                |t: f64, n: u32| ((t * f64::from(n)).floor() as i64).clamp(0, i64::from(n) - 1);
            p.get(place(uv.x, p.width()), place(uv.y, p.height()))
        };
        let (under, on) = (at(&bricks()), at(&label));
        let light = |c: u8| f64::from(texmap_math::color::srgb8_to_linear(c));
        let alpha = f64::from(on[3]) / 255.0;
        let found = shot.picture.get(x.into(), y.into());
        let right = (0..3).all(|k| {
            let mixed = alpha * light(on[k]) + (1.0 - alpha) * light(under[k]);
            linear_to_srgb8(mixed as f32).abs_diff(found[k]) <= 1
        });
        off += u32::from(!right);
        inside += 1;
    }

    // Bands of light on a ball, and heat colours of a picture of numbers.
    let mut cel = stage::scene(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 30.0);
    cel.lights = vec![
        Light::Ambient { color: [0.1; 3] },
        Light::Directional {
            color: [0.9; 3],
            direction: [-0.7, -0.8, -0.6],
        },
    ];
    let bands = [
        [64, 64, 96, 255],
        [140, 140, 150, 255],
        [225, 225, 220, 255],
        [255, 255, 255, 255],
    ]
    .concat();
    cel.textures.push(Texture2d::from_rgba8(
        4,
        1,
        bands,
        ColorSpace::Srgb,
        Origin::TopLeft,
    )?);
    let toon = Material {
        light_ramp: Some(slot(0, Filter::Nearest, Wrap::ClampToEdge)),
        ..matte([0.9, 0.45, 0.1], 0.0)
    };
    let toon = stage::add(&mut cel, toon);
    cel.meshes.push(ball(DVec3::ZERO, 1.1, toon));
    let one = render(&cel, size, 1)?;
    let mut tones: Vec<_> = one.rgba().chunks_exact(4).collect();
    tones.sort_unstable();
    tones.dedup();
    let heat = heat_field(size)?;
    let claims = vec![
        Claim::new(
            "magnified letters, coverage of the outline: RMSE to 16 x 16 samples, /255",
            a,
            0.0,
            4.0,
        ),
        Claim::new("filtered alpha blended as it is: RMSE, /255", b, 30.0, 15.0),
        Claim::new("nearest texels: RMSE, /255", c, 25.0, 15.0),
        Claim::new(
            "pixels of the label that are not alpha label + (1 - alpha) base",
            off.into(),
            0.0,
            0.001 * f64::from(inside),
        ),
        Claim::new(
            "tones of the ball under a ramp of 4, with the sky",
            tones.len() as f64,
            5.0,
            0.0,
        ),
    ];
    let panels = vec![
        Panel::new(
            crisp,
            "Letters by coverage",
            "A font of 8 x 8 dots: the outline where alpha is a half, one pixel soft.",
        ),
        Panel::new(
            soft,
            "Filtered alpha",
            "The same look-up blended as it is: blurred by the magnification.",
        ),
        Panel::new(
            decal,
            "A decal over base",
            "The label's alpha over the bricks, then both under the light.",
        ),
        Panel::new(
            render(&cel, size, 3)?,
            "A ramp of light",
            "Cel shading: luminance of the light looked up in four texels.",
        ),
        Panel::new(
            heat.0,
            "A field of numbers",
            "Grey: the first look-up alone.",
        ),
        Panel::new(
            heat.1,
            "Heat colours",
            "The number looked up along a ramp: a dependent look-up.",
        ),
    ];
    Ok(sheet("Letters, labels and ramps", panels, claims))
}

/// A picture of noise, and the same along a ramp of heat.
fn heat_field(size: u32) -> Result<(Picture, Picture), LabError> {
    let mut field = Picture::new(64, 64, [0, 0, 0, 255]);
    for (x, y) in (0..64i64).flat_map(|y| (0..64i64).map(move |x| (x, y))) {
        let p = [x as f32 / 12.0, y as f32 / 12.0, 0.5];
        let v = texmap_sample::Pattern::Noise { octaves: 3 }.value(p, 0.0);
        let v = linear_to_srgb8(v);
        field.set(x, y, [v, v, v, 255]);
    }
    let mut scene = stage::scene(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, 53.0);
    let texture = stage::texture(&mut scene, &field)?;
    let plain = stage::decal(
        &mut scene,
        texture,
        Filter::Bilinear,
        texmap_raster::Interp::Perspective,
    );
    let corners =
        [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    scene
        .meshes
        .push(stage::quad(corners, stage::UNIT_UV, plain));
    let gray = render(&scene, size, 1)?;
    let stops = [
        [10, 10, 50, 255],
        [90, 20, 130, 255],
        [220, 60, 60, 255],
        [250, 180, 40, 255],
        [255, 255, 220, 255],
    ]
    .concat();
    scene.textures.push(Texture2d::from_rgba8(
        5,
        1,
        stops,
        ColorSpace::Srgb,
        Origin::TopLeft,
    )?);
    scene.materials[plain].color_ramp = Some(slot(1, Filter::Bilinear, Wrap::ClampToEdge));
    Ok((gray, render(&scene, size, 1)?))
}
