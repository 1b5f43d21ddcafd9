//! Environments of scenes, moving lights, depth maps, compressed textures, mirror rays, forward mapping and shapes without caps.

use image::RgbaImage;
use texmap_io::npy;

use crate::program::Desk;
use texmap_tests::exr_files;

fn largest(a: &RgbaImage, b: &RgbaImage) -> u8 {
    assert_eq!(a.dimensions(), b.dimensions());
    let each = a.as_raw().iter().zip(b.as_raw());
    each.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// The spot in each of three frames: its position and the point that it shines at.
const STOPS: [([f32; 3], [f32; 3]); 3] = [
    ([-1.5, 3.0, 0.5], [-1.0, 0.0, 0.0]),
    ([0.0, 2.5, 1.5], [0.2, 0.0, 0.6]),
    ([1.5, 3.0, -0.5], [1.0, 0.0, -0.8]),
];

/// A floor with coordinates under a resting lamp, a board, and a spot.
fn spotted(desk: &Desk, name: &str, (at, look): ([f32; 3], [f32; 3]), more: &str) {
    desk.put("floor.obj", "o floor\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
    let [x, y, z] = at;
    let [dx, dy, dz] = [0, 1, 2].map(|k| look[k] - at[k]);
    desk.put(
        name,
        format!(
            "eye 0 4 4\nlook 0 0 0\nfov 45\nla 0.1 0.1 0.1\nlp 0.3 0.3 0.35 0.5 3 0.5\n\
             ls 0.6 0.5 0.4 {x} {y} {z} {dx} {dy} {dz} 12 20\nname spot\nsurf 1 1 1 1 1 0 5\n\
             v -1.2 1 0\nv -0.4 1 0\nv -0.4 1 -0.8\nv -1.2 1 -0.8\nf 0 1 2 3\n{more}\nobj floor.obj\n"
        ),
    );
}

/// Frames of a light that moves over a baked floor are those of fresh bakes to one code of 255; over a map that holds the resting spot too
/// they are not.
#[test]
fn frames_of_a_moving_light_are_fresh_bakes() {
    let desk = Desk::new();
    let rest = STOPS[0];
    spotted(&desk, "rest.scene", rest, "");
    desk.texmap("bake rest.scene --object floor --light --size 128 --except spot -o still.exr")
        .ok();
    desk.texmap("bake rest.scene --object floor --light --size 128 -o whole.exr")
        .ok();
    let stop =
        |(at, look): ([f32; 3], [f32; 3])| format!("{{\"position\":{at:?},\"look\":{look:?}}}");
    desk.put("spot.json", format!("[{}]", STOPS.map(stop).join(",")));
    let frames = |map: &str| {
        spotted(
            &desk,
            "walk.scene",
            rest,
            &format!("lightmapuv floor.obj\nlightmap {map}"),
        );
        desk.texmap("render walk.scene -o f%d.png --resolution 160x120 --light-path spot.json --light spot --frames 3")
            .ok();
        [0, 1, 2].map(|k| desk.picture(&format!("f{k}.png")))
    };
    let moved = frames("still.exr");
    let twice = frames("whole.exr");
    for (k, stop) in STOPS.into_iter().enumerate() {
        spotted(&desk, "there.scene", stop, "");
        desk.texmap("bake there.scene --object floor --light --size 128 -o fresh.exr")
            .ok();
        spotted(
            &desk,
            "there.scene",
            stop,
            "lightmapuv floor.obj\nlightmap fresh.exr",
        );
        desk.texmap("render there.scene -o fresh.png --resolution 160x120")
            .ok();
        let fresh = desk.picture("fresh.png");
        assert!(
            largest(&moved[k], &fresh) <= 1,
            "frame {k}: {}",
            largest(&moved[k], &fresh)
        );
        assert!(largest(&twice[k], &fresh) > 40, "frame {k}");
        assert!(
            k == 0 || largest(&moved[k], &moved[k - 1]) > 40,
            "the spot moves"
        );
    }
    // Without light maps the light is computed at each pixel.
    spotted(&desk, "walk.scene", rest, "");
    desk.texmap("render walk.scene -o p.gif --resolution 80x60 --light-path spot.json --frames 2")
        .ok();
    desk.refused(
        "render walk.scene -o f%d.png --light-path spot.json --light 0 --frames 2",
        2,
        "no light that moves",
    );
    desk.refused(
        "render walk.scene -o f%d.png --light-path spot.json --light sun --frames 2",
        2,
        "sun",
    );
    desk.refused(
        "render walk.scene -o x.png --light-path spot.json",
        2,
        "--frames",
    );
    desk.refused(
        "bake rest.scene --object floor --light --size 8 --except 7 -o a.png",
        2,
        "3 lights",
    );
}

/// The depths of a light: distances in the array, near light and far dark in the picture, white where nothing is.
#[test]
fn depth_maps_are_pictures_and_arrays() {
    let desk = Desk::new();
    spotted(&desk, "rest.scene", STOPS[1], "");
    desk.texmap("depth rest.scene --light 1 --size 32 -o lamp.npy")
        .ok();
    let array = npy::read(&desk.path("lamp.npy")).unwrap();
    assert_eq!(array.shape, [6 * 32, 32]);
    let npy::Data::F32(depths) = array.data else {
        panic!("floats")
    };
    // Straight down (-Y is the fourth face) lies the floor, 3 units below the lamp; upwards there is nothing.
    let down = depths[(3 * 32 + 15) * 32 + 15];
    assert!((down - 3.0).abs() < 0.02, "{down}");
    assert!(depths[(2 * 32 + 15) * 32 + 15].is_infinite());
    let told = desk
        .texmap("depth rest.scene --light spot --size 64 -o spot.png")
        .ok();
    assert!(
        told.stderr.contains("texels, ") && told.stderr.contains("depths"),
        "{}",
        told.stderr
    );
    let picture = desk.picture("spot.png");
    assert_eq!(picture.dimensions(), (64, 64));
    let codes: Vec<u8> = picture.pixels().map(|p| p[0]).collect();
    let (near, far) = (codes.iter().filter(|c| **c < 255).max(), codes.iter().min());
    assert_eq!((near, far), (Some(&232), Some(&24)));
    desk.refused("depth rest.scene --light 0 -o a.png", 2, "ambient");
    desk.refused("depth rest.scene --light lamp -o a.png", 2, "spot");
    desk.refused("depth rest.scene --light 1 -o a.jpg", 2, ".npy");
}

/// The six views of a point serve a mirror; led to the walls of the room it is nearer to mirror rays than an environment that is
/// infinitely far.
#[test]
fn a_captured_room_is_mirrored() {
    let desk = Desk::new();
    let room = |mirror: &str| {
        let wall = |c: &str, v: &str| format!("surf {c} 1 0 0 1\nf {v}\n");
        let walls = [
            wall("0.9 0.2 0.2", "0 3 7 4"),
            wall("0.2 0.8 0.2", "1 5 6 2"),
            wall("0.3 0.3 0.9", "0 4 5 1"),
            wall("0.8 0.8 0.3", "3 2 6 7"),
            wall("0.3 0.8 0.8", "0 1 2 3"),
            wall("0.7 0.4 0.8", "4 7 6 5"),
        ];
        format!(
            "eye 0.3 0.4 1.8\nlook 1.0 -0.3 -0.2\nfov 50\nla 1 1 1\n\
             v -2 -2 -2\nv 2 -2 -2\nv 2 2 -2\nv -2 2 -2\nv -2 -2 2\nv 2 -2 2\nv 2 2 2\nv -2 2 2\n{}{mirror}",
            walls.concat()
        )
    };
    let ball = "o ball\nv 0.6 0 0\nv -0.6 0 0\nv 0 0.6 0\nv 0 -0.6 0\nv 0 0 0.6\nv 0 0 -0.6\n\
                f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
    desk.put("ball.obj", ball);
    let placed = |env: &str| {
        room(&format!(
            "surf 0 0 0 1 0 0 1\n{env}\ntranslate 1 -0.3 -0.2\nobj ball.obj\nname ball\n"
        ))
    };
    desk.put("empty.scene", room(""));
    desk.put("room.scene", placed("env none"));
    let told = desk
        .texmap("env --from-scene empty.scene --at 0,0,0 --size 64 -o room.exr")
        .ok();
    assert!(told.stderr.contains("seen from 0 0 0"), "{}", told.stderr);
    let seen = exr_files::read(&desk.path("room.exr"));
    assert_eq!(seen.dimensions(), (64, 6 * 64));
    let object = desk
        .texmap("env --from-scene room.scene --object ball --size 64 -o ball.exr")
        .ok();
    assert!(
        object.stderr.contains("seen from 1 -0.3 -0.2"),
        "{}",
        object.stderr
    );
    let error = |env: &str| {
        desk.put("mirror.scene", placed(env));
        let run = desk
            .texmap("render mirror.scene -o mirror.png --resolution 96x72 --compare rays --json")
            .ok();
        let rays = run.json()["items"][0]["rays"].clone();
        assert_eq!(rays["picture"], "mirror.rays.png");
        let bins = rays["mirrors"][0]["bins"].as_array().unwrap().clone();
        let sum = |key: &str| {
            bins.iter()
                .map(|b| b["pixels"].as_f64().unwrap() * b[key].as_f64().unwrap())
                .sum::<f64>()
        };
        let pixels: f64 = bins.iter().map(|b| b["pixels"].as_f64().unwrap()).sum();
        assert!(pixels > 200.0, "{bins:?}");
        sum("mean") / pixels
    };
    let far = error("env room.exr cube 1");
    let led = error("env room.exr cube 1 box -2 -2 -2 2 2 2 at 0 0 0");
    assert!(led * 4.0 < far && far > 10.0, "{led} {far}");
    assert_eq!(desk.picture("mirror.rays.png").dimensions(), (96, 72));
    // A map of reflectivity needs coordinates, which `f` faces have none of, and the program says so.
    desk.put(
        "mirror.scene",
        room("env room.exr cube 1 map check.png\nf 0 1 2\n"),
    );
    let told = desk
        .texmap("render mirror.scene -o a.png --resolution 32x24")
        .ok();
    assert!(told.stderr.contains("`env` with a map"), "{}", told.stderr);
    desk.put(
        "mirror.scene",
        placed("env room.exr cube 1 box -2 -2 -2 2 2 2 at 0 3 0"),
    );
    desk.refused("render mirror.scene -o b.png", 4, "within the `box`");
    desk.refused("env --from-scene room.scene -o c.exr", 2, "--at");
    desk.refused(
        "env --from-scene room.scene --object cow -o c.exr",
        2,
        "ball",
    );
    desk.refused(
        "env check.png --from-scene room.scene --at 0,0,0 -o c.exr",
        2,
        "--from-scene",
    );
    desk.refused(
        "render room.scene -o d.png --compare rays",
        4,
        "no surface of the scene mirrors",
    );
}

/// A flat mesh mirrors the scene where a flag says so.
#[test]
fn a_floor_mirrors_the_board_above_it() {
    let desk = Desk::new();
    spotted(&desk, "rest.scene", STOPS[1], "");
    let draw = |more: &str| {
        desk.texmap(&format!(
            "render rest.scene -o m.png --resolution 120x90 {more}"
        ))
        .ok();
        desk.picture("m.png")
    };
    let plain = draw("");
    let none = draw("--mirror floor=0");
    assert!(largest(&plain, &none) <= 1);
    // The board is dark from below: a tenth of white, and eight tenths of that.
    assert!(largest(&draw("--mirror floor=0.8"), &plain) > 10);
    desk.refused("render rest.scene -o a.png --mirror ceiling", 2, "floor");
    desk.refused("render rest.scene -o a.png --mirror floor=7", 2, "0 to 1");
    desk.texmap("render rest.scene -o s%d.png --resolution 60x45 --mirror floor --turntable 2")
        .ok();
}

/// A compressed texture looks like the picture that it was made of, and the program tells by how much it does not.
#[test]
fn compressed_textures_are_drawn() {
    let desk = Desk::new();
    let photo = image::RgbImage::from_fn(64, 48, |x, y| {
        let wave = |k: f32| (128.0 + 100.0 * (k * x as f32 * 0.1 + y as f32 * 0.07).sin()) as u8;
        image::Rgb([wave(1.0), wave(0.7), wave(1.3)])
    });
    photo.save(desk.path("photo.png")).unwrap();
    // Level 0 alone, as coarser ones are compressed by themselves.
    let picture = |texture: &str| {
        let scene = crate::program::ROOM.replace("check.png", texture);
        desk.put("t.scene", scene);
        desk.texmap("render t.scene -o t.png --resolution 160x120 --filter bilinear")
            .ok();
        desk.picture("t.png")
    };
    let whole = picture("photo.png");
    for (format, bytes, rmse) in [("bc1", 0.5, 6.0), ("bc3", 1.0, 6.0), ("bc7", 1.0, 2.0)] {
        let run = desk
            .texmap(&format!(
                "compress photo.png -o photo.dds --format {format} --json"
            ))
            .ok();
        let report = run.json();
        assert_eq!(
            (report["levels"].as_u64(), report["format"].as_str()),
            (Some(7), Some(format))
        );
        let error = report["rmse"].as_f64().unwrap();
        assert!(error > 0.0 && error < rmse, "{format}: {error}");
        let size = report["bytes"].as_f64().unwrap();
        // A third more for the levels, whole blocks and the head.
        assert!(size < 64.0 * 48.0 * bytes * 1.4 + 300.0, "{format}: {size}");
        let drawn = picture("photo.dds");
        // The decoded picture as a PNG draws the same. Texels of BC7 are whole codes; those of BC1 and BC3 lie up to half a code
        // beside the PNG's, whose colours another half may round to the next.
        desk.texmap("warp photo.dds -o decoded.png --scale 1 --filter nearest")
            .ok();
        let allowed = if format == "bc7" { 0 } else { 1 };
        let apart = largest(&drawn, &picture("decoded.png"));
        assert!(apart <= allowed, "{format}: {apart}");
        assert_ne!(drawn, whole);
    }
    let info = desk.texmap("info photo.dds --json").ok().json();
    assert!(info.to_string().contains("64"), "{info}");
    desk.refused("compress photo.png -o photo.ktx2", 2, ".dds");
    desk.refused("compress none.png -o a.dds", 4, "none.png");
    desk.put("bad.dds", b"DDS nothing");
    desk.put(
        "t.scene",
        crate::program::ROOM.replace("check.png", "bad.dds"),
    );
    desk.refused("render t.scene -o c.png", 4, "bad.dds");
}

/// Texel to pixel: three of four pixels of a picture twice as large are holes.
#[test]
fn forward_maps_count_holes_and_overdraw() {
    let desk = Desk::new();
    let run = desk
        .texmap("warp check.png --forward --scale 2 --size 16x16 -o big.png --json")
        .ok();
    let counts = run.json()["forward"].clone();
    assert_eq!(
        (counts["pixels"].as_u64(), counts["holes"].as_u64()),
        (Some(64), Some(192))
    );
    let clear = desk
        .picture("big.png")
        .pixels()
        .filter(|p| p[3] == 0)
        .count();
    assert_eq!(clear, 192);
    let small = desk
        .texmap("warp check.png --forward --scale 0.5 --size 4x4 -o small.png")
        .ok();
    assert!(
        small.stderr.contains("48 texels overdrawn") && small.stderr.contains("0 holes"),
        "{}",
        small.stderr
    );
    desk.refused(
        "warp check.png --forward --filter nearest -o a.png",
        2,
        "--filter",
    );
}

/// The lid of a cylinder is a picture of its own, or belongs to the side.
#[test]
fn cylinders_have_caps_or_none() {
    let desk = Desk::new();
    desk.put(
        "lid.obj",
        "v -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\nv -1 -1 -1\nv 1 -1 -1\nf 4 3 2 1\nf 1 2 6 5\n",
    );
    let mapped = |flags: &str| {
        desk.texmap(&format!("uv lid.obj --map cylinder {flags} -o out.obj"))
            .ok();
        let text = String::from_utf8(desk.read("out.obj")).unwrap();
        let corners = text.lines().filter(|l| l.starts_with("vt ")).map(|l| {
            let v: Vec<f64> = l
                .split_whitespace()
                .skip(1)
                .map(|w| w.parse().unwrap())
                .collect();
            (v[0], v[1])
        });
        corners.collect::<Vec<_>>()
    };
    let (with, without) = (mapped(""), mapped("--no-caps"));
    // The lid as a picture reaches from corner to corner; on the side it lies around, a quarter of the way from vertex to vertex.
    let is_corner = |(u, v): &(f64, f64)| (*u, *v) == (1.0, 0.0);
    assert!(
        with.iter().any(is_corner) && !without.iter().any(is_corner),
        "{with:?} {without:?}"
    );
    assert!(
        without.len() < with.len(),
        "the lid shares the corners of the side"
    );
    desk.refused("uv lid.obj --map box --no-caps -o b.obj", 2, "--no-caps");
}
