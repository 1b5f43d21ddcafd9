//! `texmap env`, `texmap bake` and `texmap slice`.

use image::{Rgb, RgbImage, Rgba, Rgba32FImage, RgbaImage};
use texmap_io::npy::{self, Values};
use texmap_math::color;

use crate::program::Desk;
use texmap_tests::exr_files;

/// Largest and mean difference of two pictures, in codes.
fn difference(a: &RgbaImage, b: &RgbaImage) -> (u8, f64) {
    assert_eq!(a.dimensions(), b.dimensions());
    let each = a
        .as_raw()
        .iter()
        .zip(b.as_raw())
        .map(|(a, b)| a.abs_diff(*b));
    let sum: f64 = each.clone().map(f64::from).sum();
    (each.max().unwrap_or(0), sum / a.as_raw().len() as f64)
}

/// Smooth light all around.
fn sky(desk: &Desk) {
    let sky = RgbImage::from_fn(128, 64, |x, y| {
        let turn = f64::from(x) / 128.0 * std::f64::consts::TAU;
        let code = |c: f64| (140.0 + 90.0 * c) as u8;
        Rgb([code(turn.sin()), code(turn.cos()), (y * 3 + 30) as u8])
    });
    sky.save(desk.path("sky.png")).unwrap();
}

#[test]
fn an_environment_comes_back_from_every_chart() {
    let desk = Desk::new();
    sky(&desk);
    for chart in [
        "cube",
        "tan-cube",
        "octahedron",
        "equal-area-octahedron",
        "dual-paraboloid",
        "sphere-map",
    ] {
        desk.texmap(&format!("env sky.png -o there.hdr --to {chart} --size 96"))
            .ok();
        desk.texmap(&format!(
            "env there.hdr -o back.png --from {chart} --to lat-long --size 64"
        ))
        .ok();
        let (_, mean) = difference(&desk.picture("back.png"), &desk.picture("sky.png"));
        assert!(mean < 1.5, "{chart}: {mean}");
        // A chart is no other chart.
        let wrong = if chart == "sphere-map" {
            "octahedron"
        } else {
            "sphere-map"
        };
        if !matches!(chart, "cube" | "tan-cube" | "dual-paraboloid") {
            desk.texmap(&format!(
                "env there.hdr -o wrong.png --from {wrong} --to lat-long --size 64"
            ))
            .ok();
            let (_, mean) = difference(&desk.picture("wrong.png"), &desk.picture("sky.png"));
            assert!(mean > 5.0, "{chart} as {wrong}: {mean}");
        }
    }
}

#[test]
fn a_blurred_environment_is_smooth_and_keeps_its_mean() {
    let desk = Desk::new();
    RgbImage::from_fn(64, 32, |x, y| {
        Rgb([if x / 4 % 2 == y / 4 % 2 { 255 } else { 0 }; 3])
    })
    .save(desk.path("checks.png"))
    .unwrap();
    desk.texmap("env checks.png -o soft.png --to lat-long --size 16 --blur 2")
        .ok();
    let soft = desk.picture("soft.png");
    assert_eq!(soft.dimensions(), (32, 16));
    // Half the light, as sRGB 188.
    assert!(
        soft.pixels().all(|p| p[0].abs_diff(188) < 24),
        "{:?}",
        soft.pixels().map(|p| p[0]).max()
    );
    // A broad lobe needs few texels, a narrow one more, and no lobe all that one may ask for.
    for (exponent, side) in [(2, 15), (36, 60)] {
        desk.texmap(&format!(
            "env checks.png -o lobe.png --to cube --blur {exponent}"
        ))
        .ok();
        assert_eq!(desk.picture("lobe.png").dimensions(), (side, 6 * side));
    }
    desk.refused(
        "env checks.png -o out.png --to cube --size 512 --blur 36",
        2,
        "60 are enough",
    );
}

#[test]
fn environments_are_refused_with_their_reason() {
    let desk = Desk::new();
    sky(&desk);
    RgbImage::new(30, 20).save(desk.path("odd.png")).unwrap();
    desk.refused("env odd.png -o out.png --to cube", 4, "lat-long");
    desk.refused("env sky.png -o out.gif --to cube", 2, ".hdr or .exr");
    desk.refused("env sky.png -o out.png --to ball", 2, "ball");
    desk.refused("env sky.png -o out.png --to cube --blur=-1", 2, "blur");
    desk.refused("env none.png -o out.png --to cube", 4, "none.png");
}

/// Light below 0 is kept by EXR and counted where a format cannot hold it.
#[test]
fn negative_light_is_kept_or_told() {
    let desk = Desk::new();
    let dark = Rgba32FImage::from_fn(16, 8, |x, y| {
        Rgba([if x < 4 { -0.5 } else { 2.0 }, 0.5, y as f32, 1.0])
    });
    exr_files::write(&desk.path("dark.exr"), &dark).unwrap();
    let env = |out: &str| {
        desk.texmap(&format!("env dark.exr -o {out} --to lat-long --size 8"))
            .ok()
            .stderr
    };
    assert!(!env("same.exr").contains("warning"));
    let same = exr_files::read(&desk.path("same.exr"));
    let red = |x, y| same.get_pixel(x, y).0[0];
    assert_eq!((red(1, 4), red(2, 4), red(8, 4)), (-0.5, -0.5, 2.0));
    assert!(
        env("b.hdr").contains("pixels are below 0, which HDR"),
        "{}",
        env("b.hdr")
    );
    let told = env("c.png");
    assert!(
        told.contains("pixels are below 0, which PNG") && told.contains("brighter"),
        "{told}"
    );
}

/// A floor with coordinates, a board above it, a light.
fn room(desk: &Desk, more: &str) {
    desk.put("floor.obj", "o floor\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
    desk.put(
        "lit.scene",
        format!(
            "eye 0 4 4\nlook 0 0 0\nfov 45\nla 0.1 0.1 0.1\nlp 0.7 0.7 0.6 0.5 3 0.5\nshadow 1024\nsurf 1 1 1 1 1 0 5\n\
             v -1.2 1 0\nv -0.4 1 0\nv -0.4 1 -0.8\nv -1.2 1 -0.8\nf 0 1 2 3\n{more}\nobj floor.obj\n"
        ),
    );
}

#[test]
fn baked_light_is_the_light_that_was_baked() {
    let desk = Desk::new();
    room(&desk, "");
    desk.texmap("render lit.scene -o lit.png --resolution 160x120")
        .ok();
    desk.texmap("bake lit.scene --object floor --light --size 256 -o map.png")
        .ok();
    desk.texmap("bake lit.scene --object floor --light --size 8 -o coarse.png")
        .ok();
    assert_eq!(desk.picture("map.png").dimensions(), (256, 256));
    let mean = |map: &str| {
        room(&desk, &format!("lightmapuv floor.obj\nlightmap {map}"));
        desk.texmap("render lit.scene -o baked.png --resolution 160x120")
            .ok();
        difference(&desk.picture("baked.png"), &desk.picture("lit.png")).1
    };
    let (fine, coarse) = (mean("map.png"), mean("coarse.png"));
    assert!(fine < 0.8 && coarse > 2.0 * fine, "{fine} {coarse}");
    room(&desk, "");
    desk.texmap("bake lit.scene --object floor --light --size 64 --luminance -o gray.png")
        .ok();
    let gray = desk.picture("gray.png");
    assert!(gray.pixels().all(|p| p[0] == p[1] && p[1] == p[2]));
}

/// The floor alone under a light, with this surface and power, lit or under a light map.
fn floor_under_a_lamp(desk: &Desk, kd: f32, power: f32, more: &str) {
    room(desk, "");
    let cool = 0.8 * power;
    desk.put(
        "lamp.scene",
        format!(
            "eye 0 4 4\nlook 0 0 0\nfov 45\nla 0.05 0.05 0.1\nlp {power} {cool} {cool} 0.5 3 0.5\nsurf 1 1 1 {kd} {kd} 0 5\n\
             {more}\nobj floor.obj\n"
        ),
    );
}

/// A map is read as it was written: in each format the baked light looks like the live light, to one code of 255.
#[test]
fn baked_light_is_live_light_in_every_format() {
    let desk = Desk::new();
    let render = |out: &str| {
        ["srgb", "raw"].map(|color| {
            desk.texmap(&format!(
                "render lamp.scene -o {out}.png --resolution 160x120 --color {color}"
            ))
            .ok();
            desk.picture(&format!("{out}.png"))
        })
    };
    // Beyond 1 the light of the map is clipped by PNG alone, which says so.
    for (kd, power, clipped) in [(1.0, 0.9, false), (0.3, 3.0, true)] {
        floor_under_a_lamp(&desk, kd, power, "");
        let live = render("live");
        for format in ["png", "hdr", "exr"] {
            let bake = format!("bake lamp.scene --object floor --light --size 256 -o map.{format}");
            let told = desk.texmap(&bake).ok().stderr.contains("were clipped");
            assert_eq!(told, clipped && format == "png", "{format} {power}");
        }
        // A format that bake does not write, but a scene reads: 16 bits of sRGB.
        let light = exr_files::read(&desk.path("map.exr"));
        let code = |c: f32| (f64::from(color::linear_to_srgb(c)) * 65535.0 + 0.5) as u16;
        image::ImageBuffer::from_fn(256, 256, |x, y| {
            let [r, g, b, _] = light.get_pixel(x, y).0;
            Rgb([r, g, b].map(code))
        })
        .save(desk.path("wide.png"))
        .unwrap();
        for map in ["map.png", "wide.png", "map.hdr", "map.exr"] {
            let line = format!("lightmapuv floor.obj\nlightmap {map}");
            floor_under_a_lamp(&desk, kd, power, &line);
            let baked = render("baked");
            let [most, raw] = [0, 1].map(|i| difference(&baked[i], &live[i]).0);
            if clipped && map.ends_with(".png") {
                assert!(most > 20, "{map} {power}: {most}");
            } else {
                assert!(most <= 1, "{map} {power}: {most}");
                // Half a code of sRGB is more than one of light where it is bright.
                let allowed = if map == "map.png" { 2 } else { 1 };
                assert!(raw <= allowed, "{map} {power} raw: {raw}");
            }
        }
    }
}

/// `--aov shadow:NAME` is the shadow of the light that the scene calls so, in a file of that name.
#[test]
fn shadows_are_asked_for_by_name() {
    let desk = Desk::new();
    room(&desk, "");
    let scene = String::from_utf8(desk.read("lit.scene")).unwrap();
    desk.put(
        "lit.scene",
        scene.replace("shadow 1024\n", "name lamp\nshadow 1024\n"),
    );
    let run = desk
        .texmap("render lit.scene -o lit.png --resolution 80x60 --aov depth,shadow:lamp,shadow:1 --json")
        .ok();
    let aovs = run.json()["items"][0]["aovs"].clone();
    assert_eq!(aovs[1]["name"], "shadow:lamp");
    let by_name = desk.read("lit.shadow:lamp.npy");
    assert_eq!(by_name, desk.read("lit.shadow:1.npy"));
    assert_ne!(by_name, desk.read("lit.depth.npy"));
    desk.refused(
        "render lit.scene -o lit.png --aov shadow:sun",
        4,
        "no light is called 'sun'; there is 'lamp' (light 1)",
    );
    desk.refused(
        "render lit.scene -o lit.png --aov shadow:a/b",
        2,
        "shadow:LIGHT",
    );
    desk.refused(
        "render room.scene -o lit.png --aov shadow:sun",
        4,
        "a `name` line",
    );
}

#[test]
fn a_bake_without_light_warns_that_it_is_black() {
    let desk = Desk::new();
    room(&desk, "");
    desk.put(
        "dark.scene",
        "lightmapuv floor.obj\nobj floor.obj\neye 0 2 4\n",
    );
    let bake = |scene: &str| {
        let words = format!("bake {scene}.scene --object floor --light --size 16 -o m.png --json");
        desk.texmap(&words).ok()
    };
    let run = bake("dark");
    assert!(
        run.stderr.contains("warning: no light is baked"),
        "{}",
        run.stderr
    );
    let report = String::from_utf8_lossy(&run.stdout);
    assert!(report.contains("no light is baked"), "{report}");
    assert!(desk.picture("m.png").pixels().all(|p| p.0[..3] == [0; 3]));
    assert!(!bake("lit").stderr.contains("no light"));
    assert!(desk.picture("m.png").pixels().any(|p| p.0[0] > 20));
}

#[test]
fn bakes_are_refused_with_their_reason() {
    let desk = Desk::new();
    room(&desk, "");
    desk.refused(
        "bake lit.scene --object ceiling --light --size 64 -o m.png",
        2,
        "floor",
    );
    desk.refused(
        "bake lit.scene --object floor --light --size 0 -o m.png",
        2,
        "size",
    );
    desk.refused(
        "bake lit.scene --object floor --size 64 -o m.png",
        2,
        "--light",
    );
    desk.refused(
        "bake lit.scene --object floor --light --size 64 -o m.bmp",
        2,
        ".hdr or .exr",
    );
    desk.refused(
        "bake no.scene --object floor --light --size 64 -o m.png",
        4,
        "no.scene",
    );
}

#[test]
fn slices_show_the_voxels_across_each_axis() {
    let desk = Desk::new();
    let voxels: Vec<u8> = (0..24).map(|i| i * 10).collect();
    npy::write(&desk.path("grid.npy"), &[2, 3, 4], Values::U8(&voxels)).unwrap();
    let slice = |arguments: &str| {
        desk.texmap(&format!(
            "slice grid.npy -o cut.png --filter nearest {arguments}"
        ))
        .ok();
        let cut = desk.picture("cut.png");
        let size = cut.dimensions();
        (size, cut.pixels().map(|p| p[0]).collect::<Vec<_>>())
    };
    assert_eq!(slice("--at 0.25"), ((4, 3), voxels[..12].to_vec()));
    assert_eq!(slice("--axis z --at 0.75"), ((4, 3), voxels[12..].to_vec()));
    // Columns and slices of row 1; slices and rows of column 2.
    assert_eq!(
        slice("--axis y"),
        ((4, 2), vec![40, 50, 60, 70, 160, 170, 180, 190])
    );
    assert_eq!(
        slice("--axis x --at 0.6"),
        ((2, 3), vec![20, 140, 60, 180, 100, 220])
    );
    desk.texmap("slice wood -o wood.png --size 64").ok();
    assert_eq!(desk.picture("wood.png").dimensions(), (64, 64));
}

#[test]
fn slices_are_refused_with_their_reason() {
    let desk = Desk::new();
    npy::write(
        &desk.path("nan.npy"),
        &[1, 1, 2],
        Values::F32(&[0.0, f32::NAN]),
    )
    .unwrap();
    npy::write(&desk.path("flat.npy"), &[2, 2], Values::F32(&[0.0; 4])).unwrap();
    npy::write(&desk.path("empty.npy"), &[0, 2, 2], Values::F32(&[])).unwrap();
    desk.refused("slice nan.npy -o cut.png", 4, "column 1");
    desk.refused("slice flat.npy -o cut.png", 4, "slices, rows, columns");
    desk.refused("slice empty.npy -o cut.png", 4, "out of range");
    desk.refused("slice none.npy -o cut.png", 4, "none.npy");
    desk.refused("slice wood -o cut.png --at 2", 2, "outside");
    desk.refused(
        "slice wood -o cut.png --filter trilinear",
        2,
        "nearest or bilinear",
    );
}
