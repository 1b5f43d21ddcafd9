//! `texmap warp`, `texmap sample` and `texmap mip`.

use image::{DynamicImage, GrayImage, Rgb, RgbImage, Rgba};
use texmap_io::npy;
use texmap_math::color;

use crate::program::Desk;
use texmap_tests::exr_files;

/// Seven by five opaque pixels, no two alike.
fn photo(desk: &Desk) -> RgbImage {
    let photo = RgbImage::from_fn(7, 5, |x, y| {
        Rgb([(x * 36) as u8, (y * 60) as u8, (x * 5 + y * 41) as u8])
    });
    photo.save(desk.path("photo.png")).unwrap();
    photo
}

fn array(desk: &Desk, name: &str) -> (Vec<usize>, Vec<f32>) {
    let array = npy::read(&desk.path(name)).unwrap();
    let npy::Data::F32(values) = array.data else {
        panic!("{name} does not hold f32");
    };
    (array.shape, values)
}

#[test]
fn a_warp_that_moves_nothing_changes_nothing() {
    let desk = Desk::new();
    let photo = DynamicImage::from(photo(&desk)).into_rgba8();
    for how in [
        "",
        "--matrix 1,0,0,0,1,0",
        "--rotate 0 --filter bilinear",
        "--from 0,0 7,0 7,5 0,5 --to 0,0 7,0 7,5 0,5 --color raw",
    ] {
        desk.texmap(&format!("warp photo.png -o out.png {how}"))
            .ok();
        assert_eq!(desk.picture("out.png"), photo, "{how}");
    }
}

#[test]
fn a_quarter_turn_is_counter_clockwise_and_exact() {
    let desk = Desk::new();
    let photo = photo(&desk);
    desk.texmap("warp photo.png -o out.png --rotate 90 --size 5x7")
        .ok();
    let out = desk.picture("out.png");
    for (x, y, p) in photo.enumerate_pixels() {
        let [r, g, b] = p.0;
        assert_eq!(out.get_pixel(y, 6 - x).0, [r, g, b, 255], "({x}, {y})");
    }
}

#[test]
fn half_a_pixel_of_shift_is_the_mean_of_neighbours() {
    let desk = Desk::new();
    let photo = photo(&desk);
    desk.texmap(
        "warp photo.png -o out.png --translate 0.5,0 --color raw --filter bilinear --outside edge",
    )
    .ok();
    let out = desk.picture("out.png");
    for y in 0..5 {
        for x in 1..7 {
            for k in 0..3 {
                let sum = u32::from(photo.get_pixel(x - 1, y).0[k])
                    + u32::from(photo.get_pixel(x, y).0[k]);
                let got = u32::from(out.get_pixel(x, y).0[k]);
                assert!(
                    got == sum / 2 || got == sum.div_ceil(2),
                    "({x}, {y}) {got} {sum}"
                );
            }
        }
    }
}

#[test]
fn four_points_place_the_image_and_the_rest_is_outside() {
    let desk = Desk::new();
    photo(&desk);
    desk.texmap("warp photo.png -o out.png --size 14x5 --to 7,0 14,0 14,5 7,5")
        .ok();
    let out = desk.picture("out.png");
    let inside = desk.picture("photo.png");
    for (x, y, p) in out.enumerate_pixels() {
        if x < 7 {
            assert_eq!(p.0[3], 0, "({x}, {y})");
        } else {
            assert_eq!(p, inside.get_pixel(x - 7, y), "({x}, {y})");
        }
    }
    desk.texmap("warp photo.png -o b.png --size 14x5 --to 7,0 14,0 14,5 7,5 --outside border")
        .ok();
    assert_eq!(desk.picture("b.png").get_pixel(2, 2).0, [0, 0, 0, 255]);
    desk.texmap("warp photo.png -o r.png --size 14x5 --to 7,0 14,0 14,5 7,5 --outside repeat")
        .ok();
    assert_eq!(
        desk.picture("r.png").get_pixel(2, 2),
        inside.get_pixel(2, 2)
    );
}

/// A pixel on a slanted edge is as opaque as its square is covered, not as its distance to the edge says.
#[test]
fn slanted_edges_cover_what_they_cover() {
    let desk = Desk::new();
    RgbImage::from_pixel(1200, 900, Rgb([255; 3]))
        .save(desk.path("white.png"))
        .unwrap();
    desk.texmap(
        "warp white.png -o out.png --to 130.3,20.7 300.2,60.1 395.6,290.4 8.9,220.5 --size 400x300",
    )
    .ok();
    let alpha = desk.picture("out.png").get_pixel(55, 144).0[3];
    // 0.8799 by 1000 x 1000 points.
    assert!((f32::from(alpha) / 255.0 - 0.8799).abs() < 0.003, "{alpha}");
    desk.texmap("warp white.png -o turned.png --rotate 30 --scale .1 --size 200x200")
        .ok();
    let turned = desk.picture("turned.png");
    let area: f64 = turned.pixels().map(|p| f64::from(p.0[3]) / 255.0).sum();
    assert!((area - 120.0 * 90.0).abs() < 2.0, "{area}");
}

/// More rows than one round of bands, on any number of threads.
#[test]
fn threads_do_not_change_a_warp() {
    let desk = Desk::new();
    photo(&desk);
    for threads in [1, 2, 5] {
        desk.texmap(&format!(
            "warp photo.png -o t{threads}.png --size 41x301 --scale 5,60 --rotate 10 --threads {threads}"
        ))
        .ok();
    }
    let one = desk.read("t1.png");
    assert!(one == desk.read("t2.png") && one == desk.read("t5.png"));
}

#[test]
fn bad_warps_are_named() {
    let desk = Desk::new();
    photo(&desk);
    desk.refused("warp photo.png", 2, "--output");
    desk.refused("warp missing.png -o out.png", 4, "missing.png");
    desk.refused("warp m.obj -o out.png", 4, "m.obj");
    desk.refused(
        "warp photo.png -o photo.png/out.png",
        4,
        "photo.png is no folder",
    );
    desk.refused(
        "warp photo.png -o out.png --from 0,0 1,1 2,2 0,5",
        4,
        "quad",
    );
    desk.refused("warp photo.png -o out.png --from 0,0 7,0 7,5", 2, "--from");
    desk.refused("warp photo.png -o out.png --matrix 0,0,0,0,0,0", 4, "map");
    desk.refused("warp photo.png -o out.png --matrix 1,2,3", 2, "6 or 9");
    desk.refused("warp photo.png -o out.png --matrix 1,0,nan,0,1,0", 2, "nan");
    desk.refused(
        "warp photo.png -o out.png --matrix 1,0,0,0,1,0 --rotate 5",
        2,
        "--rotate",
    );
    desk.refused("warp photo.png -o out.png --scale 0", 2, "not 0");
    desk.refused("warp photo.png -o out.png --size 0x5", 2, "0x5");
    desk.refused("warp photo.png -o out.png --filter sharp", 2, "anisotropic");
    desk.refused("warp photo.png -o out.png --outside void", 2, "void");
}

#[test]
fn samples_are_the_bytes_at_texel_centres() {
    let desk = Desk::new();
    let photo = photo(&desk);
    let lines: String = photo
        .enumerate_pixels()
        .map(|(x, y, _)| format!("{},{}\n", (x as f32 + 0.5) / 7.0, (y as f32 + 0.5) / 5.0))
        .collect();
    desk.put("uv.csv", format!("# u, v\n\n{lines}"));
    for filter in ["nearest", "bilinear", "trilinear", "anisotropic:16"] {
        desk.texmap(&format!(
            "sample photo.png --uv uv.csv -o out.npy --filter {filter} --wrap clamp-to-edge --color raw"
        ))
        .ok();
        let (shape, values) = array(&desk, "out.npy");
        assert_eq!(shape, [35, 3]);
        for (got, want) in values.as_chunks::<3>().0.iter().zip(photo.pixels()) {
            for (got, want) in got.iter().zip(want.0) {
                assert!(
                    (got - f32::from(want) / 255.0).abs() < 1e-5,
                    "{filter} {got} {want}"
                );
            }
        }
    }
}

#[test]
fn as_many_channels_come_out_as_the_image_has() {
    let desk = Desk::new();
    desk.put("uv.csv", "0.5,0.5\n");
    GrayImage::from_raw(2, 1, vec![0, 255])
        .unwrap()
        .save(desk.path("grey.png"))
        .unwrap();
    desk.texmap("sample grey.png --uv uv.csv -o out.npy --filter bilinear")
        .ok();
    // Half of the light, whichever way bytes encode it.
    assert_eq!(array(&desk, "out.npy").0, [1, 1]);
    assert!((array(&desk, "out.npy").1[0] - 0.5).abs() < 1e-4);
    desk.texmap("sample check.png --uv uv.csv -o out.npy").ok();
    assert_eq!(array(&desk, "out.npy").0, [1, 4]);
    photo(&desk);
    desk.texmap("sample photo.png --uv uv.csv -o out.npy").ok();
    assert_eq!(array(&desk, "out.npy").0, [1, 3]);
    assert_eq!(
        desk.texmap("sample photo.png --uv uv.csv -o -").ok().stdout,
        desk.read("out.npy")
    );
}

#[test]
fn gradients_and_levels_reach_the_mips() {
    let desk = Desk::new();
    let photo = photo(&desk);
    let uv = [0.3_f32, 0.6, 0.9, 0.1];
    npy::write(&desk.path("uv.npy"), &[2, 2], npy::Values::F32(&uv)).unwrap();
    npy::write(
        &desk.path("d.npy"),
        &[2, 4],
        npy::Values::F32(&[2.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 2.0]),
    )
    .unwrap();
    desk.texmap("sample photo.png --uv uv.npy --grad d.npy -o grad.npy")
        .ok();
    desk.texmap("sample photo.png --uv uv.npy --lod 9 -o lod.npy")
        .ok();
    let mean = |k: usize| {
        photo
            .pixels()
            .map(|p| f64::from(color::srgb8_to_linear(p.0[k])))
            .sum::<f64>()
            / 35.0
    };
    for name in ["grad.npy", "lod.npy"] {
        let (shape, values) = array(&desk, name);
        assert_eq!(shape, [2, 3]);
        for (i, value) in values.iter().enumerate() {
            assert!((f64::from(*value) - mean(i % 3)).abs() < 1e-4, "{name} {i}");
        }
    }
}

#[test]
fn bad_coordinates_are_named() {
    let desk = Desk::new();
    photo(&desk);
    desk.put("uv.csv", "0.5,0.5\n0.1,0.2\n");
    desk.put("one.csv", "1,0,0,1\n");
    desk.put("three.csv", "0.5,0.5,0.5\n");
    desk.put("words.csv", "0.5,0.5\nhere,there\n");
    npy::write(&desk.path("flat.npy"), &[4], npy::Values::F32(&[0.0; 4])).unwrap();
    desk.put("broken.npy", "not an array");
    let sample = |rest: &str| format!("sample photo.png -o out.npy {rest}");
    desk.refused(&sample(""), 2, "--uv");
    desk.refused(&sample("--uv missing.csv"), 4, "missing.csv");
    desk.refused(&sample("--uv three.csv"), 4, "line 1");
    desk.refused(&sample("--uv words.csv"), 4, "line 2");
    desk.refused(&sample("--uv flat.npy"), 4, "(N, 2)");
    desk.refused(&sample("--uv broken.npy"), 4, "broken.npy");
    desk.refused(
        &sample("--uv uv.csv --grad one.csv"),
        4,
        "1 gradients for 2",
    );
    desk.refused(&sample("--uv uv.csv --grad one.csv --lod 1"), 2, "--lod");
    desk.refused(&sample("--uv uv.csv --filter ewa:99"), 2, "ewa:1..16");
    desk.refused(&sample("--uv uv.csv --wrap around"), 2, "mirrored-repeat");
}

#[test]
fn a_mip_chain_is_numbered_files_down_to_one_pixel() {
    let desk = Desk::new();
    let photo = photo(&desk);
    desk.texmap("mip photo.png -o m%02d.png").ok();
    let sizes: Vec<_> = (0..3)
        .map(|k| desk.picture(&format!("m{k:02}.png")).dimensions())
        .collect();
    assert_eq!(sizes, [(7, 5), (3, 2), (1, 1)]);
    assert!(!desk.names().contains(&"m03.png".to_owned()));
    assert_eq!(
        desk.picture("m00.png"),
        DynamicImage::from(photo.clone()).into_rgba8()
    );
    // Area-weighted, in linear light: the last level is the mean of the image.
    for (k, got) in desk
        .picture("m02.png")
        .get_pixel(0, 0)
        .0
        .into_iter()
        .take(3)
        .enumerate()
    {
        let light = photo
            .pixels()
            .map(|p| f64::from(color::srgb8_to_linear(p.0[k])))
            .sum::<f64>()
            / 35.0;
        assert!(
            got.abs_diff(color::linear_to_srgb8(light as f32)) <= 1,
            "{k} {got}"
        );
    }
    desk.texmap("mip photo.png -o r%d.png --color raw").ok();
    let mean = photo.pixels().map(|p| f64::from(p.0[0])).sum::<f64>() / 35.0;
    let raw = f64::from(desk.picture("r2.png").get_pixel(0, 0).0[0]);
    assert!((raw - mean).abs() <= 1.0, "{raw} {mean}");
}

#[test]
fn bad_chains_are_named() {
    let desk = Desk::new();
    photo(&desk);
    desk.refused("mip photo.png -o level.png", 2, "%d");
    desk.refused("mip missing.png -o m%d.png", 4, "missing.png");
    desk.refused(
        "mip photo.png -o m%d.png --keep-coverage 2",
        2,
        "between 0 and 1",
    );
    desk.refused(
        "mip photo.png -o photo.png/m%d.png",
        4,
        "photo.png is no folder",
    );
}

/// Linear light from -0.5 to 200, with alpha.
fn light(desk: &Desk) -> image::Rgba32FImage {
    let light = image::Rgba32FImage::from_fn(8, 4, |x, y| {
        Rgba([
            200.0 - x as f32,
            3.0 + y as f32,
            -0.5,
            if x < 4 { 1.0 } else { 0.25 },
        ])
    });
    exr_files::write(&desk.path("light.exr"), &light).unwrap();
    light
}

#[test]
fn floats_stay_floats_in_every_verb() {
    let desk = Desk::new();
    let light = light(&desk);
    let picture = |name: &str| exr_files::read(&desk.path(name));
    for color in ["srgb", "raw"] {
        desk.texmap(&format!("warp light.exr -o same.exr --color {color}"))
            .ok();
        assert_eq!(picture("same.exr"), light, "{color}");
        desk.texmap(&format!("mip light.exr -o level%d.exr --color {color}"))
            .ok();
        assert_eq!(picture("level0.exr"), light, "{color}");
        let mean = |k: usize| light.pixels().map(|p| f64::from(p.0[k])).sum::<f64>() / 32.0;
        let last = picture("level3.exr").get_pixel(0, 0).0;
        for (k, got) in last.into_iter().enumerate() {
            assert!((f64::from(got) - mean(k)).abs() < 1e-4, "{color} {k} {got}");
        }
        desk.put("uv.csv", "0.0625,0.125\n");
        for (how, texel) in [
            ("--filter nearest", light.get_pixel(0, 0).0),
            ("--lod 9", last),
        ] {
            desk.texmap(&format!(
                "sample light.exr --uv uv.csv -o s.npy --color {color} {how}"
            ))
            .ok();
            assert_eq!(
                array(&desk, "s.npy"),
                (vec![1, 4], texel.to_vec()),
                "{color} {how}"
            );
        }
    }
    // Formats that cannot hold it say so.
    for (verb, name) in [("warp", "out"), ("mip", "out%d")] {
        let told = |ending: &str| {
            let line = format!("{verb} light.exr -o {name}.{ending}");
            desk.texmap(&line).ok().stderr
        };
        assert!(told("png").contains("brighter than PNG can hold"), "{verb}");
        let hdr = told("hdr");
        assert!(hdr.contains("below 0") && hdr.contains("no alpha"), "{hdr}");
        assert_eq!(told("exr"), "", "{verb}");
    }
}

#[test]
fn sixteen_bits_stay_sixteen() {
    let desk = Desk::new();
    let wide = image::ImageBuffer::from_fn(64, 32, |x, y| image::Luma([(x * 1024 + y) as u16]));
    wide.save(desk.path("wide.png")).unwrap();
    let picture = |name: &str| {
        let image = image::open(desk.path(name)).unwrap();
        assert_eq!(image.color(), image::ColorType::Rgba16, "{name}");
        image.into_luma16()
    };
    for color in ["srgb", "raw"] {
        desk.texmap(&format!("warp wide.png -o out.png --color {color}"))
            .ok();
        assert_eq!(picture("out.png"), wide, "{color}");
        desk.texmap(&format!("mip wide.png -o m%d.png --color {color}"))
            .ok();
        assert_eq!(picture("m0.png"), wide, "{color}");
        picture("m3.png");
    }
}

/// `--color raw --lod` reads means that no byte has rounded.
#[test]
fn levels_are_floats() {
    let desk = Desk::new();
    let photo = photo(&desk);
    desk.put("uv.csv", "0.5,0.5\n");
    desk.texmap("sample photo.png --uv uv.csv -o mean.npy --lod 9 --color raw")
        .ok();
    let mean = |k: usize| photo.pixels().map(|p| f64::from(p.0[k])).sum::<f64>() / 35.0 / 255.0;
    for (k, got) in array(&desk, "mean.npy").1.into_iter().enumerate() {
        assert!(
            (f64::from(got) - mean(k)).abs() < 1e-6,
            "{k} {got} {}",
            mean(k)
        );
    }
}

#[test]
fn an_opaque_chain_stays_opaque() {
    let desk = Desk::new();
    photo(&desk);
    desk.texmap("mip photo.png -o plain%d.png").ok();
    desk.texmap("mip photo.png -o kept%d.png --keep-coverage 0.5")
        .ok();
    for level in 0..3 {
        assert_eq!(
            desk.picture(&format!("kept{level}.png")),
            desk.picture(&format!("plain{level}.png"))
        );
    }
}

/// No verb writes another format than the name says.
#[test]
fn endings_that_no_verb_writes_are_refused() {
    let desk = Desk::new();
    photo(&desk);
    desk.put("uv.csv", "0.5,0.5\n");
    for (line, known) in [
        ("warp photo.png -o", ".png, .jpg, .webp, .hdr or .exr"),
        ("slice wood -o", ".png, .jpg, .webp, .hdr or .exr"),
        (
            "env photo.png --to cube -o",
            ".png, .jpg, .webp, .hdr or .exr",
        ),
        (
            "bake m.obj --object panel --light --size 4 -o",
            ".png, .jpg, .webp, .hdr or .exr",
        ),
        ("render room.scene -o", ".png, .jpg, .webp, .hdr or .exr"),
        ("demo affine-checker -o", ".png, .jpg, .webp, .hdr or .exr"),
        (
            "diff photo.png photo.png --heat",
            ".png, .jpg, .webp, .hdr or .exr",
        ),
        ("sample photo.png --uv uv.csv -o", ".npy"),
        ("uv m.obj --map plane -o", ".obj"),
        ("uv m.obj --tangents", ".npy"),
        ("chart --quick -o", ".html or .csv"),
        ("chart --quick -o a.html --prices", ".csv"),
    ] {
        for name in ["x.bmp", "x.tga", "x"] {
            desk.refused(
                &format!("{line} {name}"),
                2,
                &format!("end the name with {known}\n"),
            );
        }
    }
    desk.refused(
        "mip photo.png -o x%d.bmp",
        2,
        ".png, .jpg, .webp, .hdr or .exr",
    );
    desk.refused(
        "demo light-maps --frames 2 -o x%d.bmp",
        2,
        ".png, .jpg, .webp, .hdr or .exr",
    );
}
