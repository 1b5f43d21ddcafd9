//! Skies, and what is put onto surfaces: letters, labels and ramps.

use texmap_light::{Environment, EnvironmentLayout};
use texmap_math::color::linear_to_srgb8;
use texmap_math::glam::DVec3;
use texmap_mesh::Font;
use texmap_sample::{Filter, Wrap};
use texmap_scene::{AlphaMode, Background, Material, Scene, Shading, TextureRole};

use super::lit::{ball, difference, matte};
use super::sheet::sheet;
use super::{DemoPicture, stage};
use crate::LabError;
use texmap_truth::picture::Picture;

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
    Picture::from_fn(side, side, |x, y| {
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(side) - 0.5;
        let [r, g, b] = sky(DVec3::new(1.6 * at(x), -1.2 * at(y) + 0.2, -1.0)).map(linear_to_srgb8);
        [r, g, b, 255]
    })
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
        let (sin, cos) = texmap_math::deterministic_f64::sin_cos(yaw);
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
        scene.effects.background = Some(Background::Picture(stage::slot(
            texture,
            filter,
            Wrap::ClampToEdge,
        )));
        if with_wall {
            wall(&mut scene, 6.0)?;
        }
        Ok(scene)
    };
    let around = |yaw: f64, with_wall: bool| -> Result<Scene, LabError> {
        let mut scene = view(yaw);
        scene.effects.environments =
            vec![Environment::from_fn(EnvironmentLayout::TanCube, 128, sky)?];
        scene.effects.background = Some(Background::Environment(0));
        if with_wall {
            wall(&mut scene, 6.0)?;
        }
        Ok(scene)
    };
    // The picture itself, texel by texel.
    let still = stage::picture(&stretched(0.0, Filter::Nearest, false)?, size, 1)?;
    let turned = stage::picture(&stretched(0.4, Filter::Nearest, false)?, size, 1)?;
    let mut off = 0u32;
    for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
        let at = |i: u32| ((f64::from(i) + 0.5) / f64::from(size) * 256.0).floor() as i64;
        off += u32::from(still.get(x.into(), y.into()) != picture.get(at(x), at(y)));
    }
    let bare = around(0.3, false)?;
    let seen = stage::picture(&bare, size, 1)?;
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
    let straight = stage::picture(&around(0.0, false)?, size, 1)?;
    let claims = claims![
        "pixels of the stretched picture that are not their texel" => off.into(), 0.0, 0.0;
        "its pixels that change when the eye turns by 0.4" => changed(&still, &turned, 0), 0.0, 0.0;
        "environment: % of pixels more than 6/255 off the light of their direction" =>
            100.0 * f64::from(wrong) / pixels, 0.0, 3.0;
        "its % of pixels that change when the eye turns by 0.3" =>
            100.0 * changed(&straight, &seen, 1) / pixels, 15.0, 12.0;
    ];
    let both = |scene: Scene| stage::picture(&scene, size, 3);
    let mut stretched_wall = stretched(0.0, Filter::Trilinear, false)?;
    wall(&mut stretched_wall, 1.0)?;
    let panels = panels![
        both(stretched(0.0, Filter::Trilinear, true)?)? =>
            "Tile the wall, stretch the sky", "Bricks repeat; one picture fills the frame behind them.";
        both(stretched(0.3, Filter::Trilinear, true)?)? =>
            "The eye turns: a backdrop does not", "The stretched sky goes with the eye: its sun has not moved.";
        both(around(0.3, true)?)? =>
            "An environment sky", "Light by direction: the sun stays where it is in the world.";
        both(stretched_wall)? =>
            "The wall stretched", "One picture over the whole wall: bricks as large as doors.";
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
        base_color: Some(stage::slot(0, filter, Wrap::ClampToEdge)),
        texture_role: TextureRole::Modulate,
        shading: Shading::Unlit,
        alpha: AlphaMode::Blend,
        antialiased_alpha: crisp,
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
    let truth = stage::picture(&cut, size, 16)?;
    let crisp = stage::picture(&letters(words, true, Filter::Bilinear, 0.0)?, size, 1)?;
    let soft = stage::picture(&letters(words, false, Filter::Bilinear, 0.0)?, size, 1)?;
    let blocky = stage::picture(&letters(words, false, Filter::Nearest, 0.0)?, size, 1)?;
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
    box_scene.lights = stage::daylight(0.3, [0.8; 3], [-0.4, -0.8, -1.0]);
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
        base_color: Some(stage::slot(base, Filter::Trilinear, Wrap::Repeat)),
        decal: Some(stage::slot(sticker, Filter::Trilinear, clear)),
        ..matte([1.0; 3], 0.0)
    };
    let labelled = stage::add(&mut box_scene, labelled);
    box_scene
        .meshes
        .push(stage::cube(DVec3::ZERO, 0.0, labelled));
    let decal = stage::picture(&box_scene, size, 3)?;
    // The decal's colours by the formula, unlit and straight on.
    let mut flat = stage::scene(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, 30.0);
    flat.textures.clone_from(&box_scene.textures);
    let mut over = box_scene.materials[labelled].clone();
    over.shading = Shading::Unlit;
    over.base_color = Some(stage::slot(base, Filter::Nearest, Wrap::Repeat));
    over.decal = Some(stage::slot(sticker, Filter::Nearest, clear));
    let over = stage::add(&mut flat, over);
    flat.meshes.push(stage::square(over));
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
    cel.lights = stage::daylight(0.1, [0.9; 3], [-0.7, -0.8, -0.6]);
    let bands = [
        [64, 64, 96, 255],
        [140, 140, 150, 255],
        [225, 225, 220, 255],
        [255, 255, 255, 255],
    ];
    let toon = Material {
        light_ramp: Some(stage::ramp(&mut cel, &bands, Filter::Nearest)?),
        ..matte([0.9, 0.45, 0.1], 0.0)
    };
    let toon = stage::add(&mut cel, toon);
    cel.meshes.push(ball(DVec3::ZERO, 1.1, toon));
    let one = stage::picture(&cel, size, 1)?;
    let mut tones: Vec<_> = one.rgba().chunks_exact(4).collect();
    tones.sort_unstable();
    tones.dedup();
    let heat = heat_field(size)?;
    let claims = claims![
        "magnified letters, coverage of the outline: RMSE to 16 x 16 samples, /255" => a, 0.0, 4.0;
        "filtered alpha blended as it is: RMSE, /255" => b, 15.0, 8.0;
        "nearest texels: RMSE, /255" => c, 15.0, 8.0;
        "pixels of the label that are not alpha label + (1 - alpha) base" =>
            off.into(), 0.0, 0.001 * f64::from(inside);
        "tones of the ball under a ramp of 4, with the sky" => tones.len() as f64, 5.0, 0.0;
    ];
    let panels = panels![
        crisp =>
            "Letters by coverage", "The outline of a font where its alpha is a half, one pixel soft.";
        soft => "Filtered alpha", "The same look-up blended as it is: blurred by the magnification.";
        decal => "A decal over base", "The label's alpha over the bricks, then both under the light.";
        stage::picture(&cel, size, 3)? =>
            "A ramp of light", "Cel shading: luminance of the light looked up in four texels.";
        heat.0 => "A field of numbers", "Grey: the first look-up alone.";
        heat.1 => "Heat colours", "The number looked up along a ramp: a dependent look-up.";
    ];
    Ok(sheet("Letters, labels and ramps", panels, claims))
}

/// A picture of noise, and the same along a ramp of heat.
fn heat_field(size: u32) -> Result<(Picture, Picture), LabError> {
    let field = Picture::from_fn(64, 64, |x, y| {
        let p = [x as f32 / 12.0, y as f32 / 12.0, 0.5];
        let v = texmap_sample::Pattern::Noise { octaves: 3 }.value(p, 0.0);
        let v = linear_to_srgb8(v);
        [v, v, v, 255]
    });
    let mut scene = stage::scene(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, 53.0);
    let texture = stage::texture(&mut scene, &field)?;
    let plain = stage::decal(
        &mut scene,
        texture,
        Filter::Bilinear,
        texmap_raster::Interp::Perspective,
    );
    scene.meshes.push(stage::square(plain));
    let gray = stage::picture(&scene, size, 1)?;
    let stops = [
        [10, 10, 50, 255],
        [90, 20, 130, 255],
        [220, 60, 60, 255],
        [250, 180, 40, 255],
        [255, 255, 220, 255],
    ];
    let heat = stage::ramp(&mut scene, &stops, Filter::Bilinear)?;
    scene.materials[plain].color_ramp = Some(heat);
    Ok((gray, stage::picture(&scene, size, 1)?))
}
