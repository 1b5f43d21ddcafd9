//! `texmap render`: cameras of models, poses, series and animations.

use image::AnimationDecoder;

use crate::program::{Desk, Run};

/// Left, top, right and bottom of all meshes that are seen.
fn bounds(run: Run) -> [u64; 4] {
    let report = run.ok().json();
    let meshes = report["items"][0]["pictures"][0]["meshes"]
        .as_array()
        .unwrap()
        .clone();
    let side = |mesh: &serde_json::Value, i: usize| mesh["bounds"][i].as_u64().unwrap();
    meshes.iter().fold([u64::MAX, u64::MAX, 0, 0], |all, mesh| {
        [
            all[0].min(side(mesh, 0)),
            all[1].min(side(mesh, 1)),
            all[2].max(side(mesh, 2)),
            all[3].max(side(mesh, 3)),
        ]
    })
}

const CUBE: &str = "\
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
";

#[test]
fn a_model_fills_its_picture_from_every_side() {
    let desk = Desk::new();
    desk.put("cube.obj", CUBE);
    for view in [
        "",
        "--view front",
        "--view top",
        "--view iso",
        "--orthographic",
        "--up z",
        "--view left --orthographic",
    ] {
        for size in ["400x200", "200x400"] {
            let [left, top, right, bottom] = bounds(desk.texmap(&format!(
                "render cube.obj --resolution {size} -o m.png --json {view}"
            )));
            let (width, height) = if size == "400x200" {
                (400, 200)
            } else {
                (200, 400)
            };
            let share = f64::max(
                (right - left) as f64 / f64::from(width),
                (bottom - top) as f64 / f64::from(height),
            );
            assert!((0.85..=0.92).contains(&share), "{view} {size}: {share}");
        }
    }
    // A camera of one's own is what was asked for.
    let [left, _, right, _] = bounds(desk.texmap("render cube.obj --resolution 400x200 -o m.png --json --camera-eye 0,0,30 --camera-look 0,0,0"));
    assert!(right - left < 200);
}

/// One picture, whether its camera is said by points, by a pose, by extrinsics, or in a list.
#[test]
fn poses_and_lists_are_the_same_cameras() {
    let desk = Desk::new();
    let hash = |flags: &str| {
        let run = desk.texmap(&format!(
            "render m.obj --resolution 64x48 -o m.png --json {flags}"
        ));
        run.ok().json()["items"][0]["pixel_hash"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    // fx = 32 / tan 20 degrees.
    let points = hash("--camera-eye 0,0,5 --camera-look 0,0,0 --camera-up 0,1,0 --fov 40");
    for flags in [
        "--camera-matrix 1,0,0,0,0,1,0,0,0,0,1,5,0,0,0,1",
        "--camera-matrix 1,0,0,0,0,-1,0,0,0,0,-1,5,0,0,0,1 --camera-axes opencv",
        "--camera-matrix 1,0,0,0,0,-1,0,0,0,0,-1,5,0,0,0,1 --camera-axes opencv --world-to-camera",
        "--camera-matrix 1,0,0,0,0,1,0,0,0,0,1,5,0,0,0,1 --intrinsics 87.91927742254792,87.91927742254792,32,24",
    ] {
        assert_eq!(hash(flags), points, "{flags}");
    }
    assert_ne!(
        hash("--camera-matrix 1,0,0,0,0,1,0,0,0,0,1,5,0,0,0,1 --intrinsics 88,88,40,24"),
        points
    );
    desk.put(
        "poses.json",
        r#"[{"name":"front","matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]],"fov":40},
            {"name":"far","eye":[0,0,9],"look":[0,0,0],"fov":40}]"#,
    );
    let run = desk
        .texmap("render m.obj --resolution 64x48 --cameras poses.json -o p/{view}-{n}.png --json")
        .ok();
    let items = run.json()["items"].as_array().unwrap().clone();
    assert_eq!(items[0]["pixel_hash"], points);
    assert_ne!(items[1]["pixel_hash"], points);
    assert!(desk.path("p/front-0.png").is_file() && desk.path("p/far-1.png").is_file());
    desk.refused(
        "render m.obj --camera-matrix 1,0,0,0,0,1,0,0,0,0,-1,5,0,0,0,1 -o x.png",
        2,
        "mirrors",
    );
    desk.refused("render m.obj --cameras poses.json -o x.png", 2, "{n}");
    desk.put(
        "bad.json",
        r#"[{"matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,5]]}]"#,
    );
    desk.refused(
        "render m.obj --cameras bad.json -o x-{n}.png",
        4,
        "not a list of cameras",
    );
}

#[test]
fn a_turntable_is_a_series_or_an_animation() {
    let desk = Desk::new();
    let run = desk
        .texmap("render m.obj --resolution 48x32 --turntable 4 -o t/%d.png --json")
        .ok();
    let hashes: Vec<String> = run.json()["items"]
        .as_array()
        .unwrap()
        .iter()
        .map(|item| item["pixel_hash"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(hashes.len(), 4);
    assert!((0..4).all(|i| (0..i).all(|j| hashes[i] != hashes[j])));
    let run = desk
        .texmap("render m.obj --resolution 48x32 --turntable 4 --rate 10 -o t.apng --json")
        .ok();
    assert_eq!(
        run.json()["items"][0]["cameras"].as_array().unwrap().len(),
        4
    );
    let file = std::io::Cursor::new(desk.read("t.apng"));
    let frames = image::codecs::png::PngDecoder::new(file)
        .unwrap()
        .apng()
        .unwrap()
        .into_frames()
        .collect_frames()
        .unwrap();
    for (number, frame) in frames.iter().enumerate() {
        assert_eq!(
            *frame.buffer(),
            desk.picture(&format!("t/{number}.png")),
            "frame {number}"
        );
        assert_eq!(frame.delay().numer_denom_ms(), (100, 1));
    }
    desk.texmap("render m.obj --resolution 48x32 --turntable 3 -o t.gif")
        .ok();
    let file = std::io::Cursor::new(desk.read("t.gif"));
    let frames = image::codecs::gif::GifDecoder::new(file)
        .unwrap()
        .into_frames()
        .count();
    assert_eq!(frames, 3);
    let fast = "render m.obj --resolution 8x8 --turntable 3 --rate 60";
    let run = desk.texmap(&format!("{fast} -o t.gif")).ok();
    assert!(
        run.stderr.contains("50 pictures a second at most"),
        "{}",
        run.stderr
    );
    desk.refused(
        &format!("{fast} -o fast.gif --strict --dry-run"),
        4,
        "--rate 60",
    );
    let run = desk.texmap(&format!("{fast} -o t.apng --strict")).ok();
    assert_eq!(run.stderr.matches("--rate").count(), 0);
    desk.refused("render m.obj -o x.gif", 2, "--turntable");
    desk.refused("render m.obj --turntable 3 -o x%d.gif", 2, "one file");
    desk.refused(
        "render m.obj --turntable 3 --aov depth -o x.gif",
        2,
        "--aov",
    );
}

/// Pictures of an animation are those of their times. The automatic camera stands still and shows every pose.
#[test]
fn an_animation_is_a_series_of_poses() {
    let desk = Desk::new();
    let bent = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/gltf/bent.glb");
    desk.put("bent.glb", std::fs::read(bent).unwrap());
    let small = "bent.glb --resolution 60x40 --json";
    let hashes = |flags: &str| {
        let run = desk.texmap(&format!("render {small} {flags}")).ok();
        let items = run.json()["items"].as_array().unwrap().clone();
        let hash = |item: &serde_json::Value| item["pixel_hash"].as_str().unwrap().to_owned();
        items.iter().map(hash).collect::<Vec<_>>()
    };
    let eye = "--camera-eye 3,2,5 --camera-look 0,1,0 --ground-shadow";
    let series = hashes(&format!("--time 0.5 --frames 3 --rate 2 -o s%d.png {eye}"));
    assert_eq!(series.len(), 3);
    for (number, time) in ["0.5", "1", "1.5"].into_iter().enumerate() {
        let single = hashes(&format!("--time {time} -o t.png {eye}"));
        assert_eq!(single, series[number..=number], "{time}");
    }
    assert_ne!(series[0], series[1]);
    // Of another animation.
    let jump = hashes(&format!(
        "--animation jump --frames 3 --rate 2 -o j%d.png {eye}"
    ));
    assert!(jump.iter().all(|hash| !series.contains(hash)));
    // The poses of a GIF are those of a series, seen from one place, and none is cut.
    let run = desk.texmap(&format!("render {small} --frames 4 --rate 2 -o a.gif"));
    let report = run.ok().json();
    let cameras = report["items"][0]["cameras"].as_array().unwrap().clone();
    assert_eq!(cameras.len(), 4);
    assert!(cameras.iter().all(|c| c["eye"] == cameras[0]["eye"]));
    // The shadow on the ground moves no camera: it is no part of the model.
    let run = desk.texmap(&format!(
        "render {small} --frames 4 --rate 2 -o g.gif --ground-shadow"
    ));
    assert_eq!(
        run.ok().json()["items"][0]["cameras"],
        report["items"][0]["cameras"]
    );
    hashes("--frames 4 --rate 2 -o a%d.png --background transparent");
    let mut highest = 40;
    for number in 0..4 {
        let picture = desk.picture(&format!("a{number}.png"));
        let drawn = picture.enumerate_pixels().filter(|(.., p)| p[3] > 0);
        let (x, y): (Vec<u32>, Vec<u32>) = drawn.map(|(x, y, _)| (x, y)).unzip();
        assert!(!x.contains(&0) && !x.contains(&59) && !y.contains(&0) && !y.contains(&39));
        highest = highest.min(*y.iter().min().unwrap());
    }
    assert!(highest < 4, "some pose fills the picture: {highest}");
    desk.refused("render m.obj --frames 3 -o x%d.png", 2, "no animation");
    desk.refused("render bent.glb --frames 3 -o x.png", 2, "%");
}

#[test]
fn views_are_a_sheet_or_a_picture_each() {
    let desk = Desk::new();
    desk.texmap("render m.obj --resolution 40x30 --views front,left -o {model}-{view}.jpg")
        .ok();
    assert_eq!(desk.picture("m-front.jpg").dimensions(), (40, 30));
    assert!(desk.path("m-left.jpg").is_file());
    desk.texmap("render m.obj --resolution 40x30 --views front,left -o sheet.webp")
        .ok();
    assert!(desk.picture("sheet.webp").width() > 80);
    desk.refused("render m.obj --views front -o sheet.exr", 2, "8 bits");
}

#[test]
fn cameras_that_see_nothing_or_stand_inside_get_a_warning() {
    let desk = Desk::new();
    desk.put("cube.obj", CUBE);
    let warned = |flags: &str| {
        let run = desk.texmap(&format!(
            "render cube.obj --resolution 32x24 -o c.png {flags}"
        ));
        run.ok().stderr
    };
    assert!(!warned("").contains("warning"));
    let inside = warned("--camera-eye 0.1,0.2,0.3 --camera-look 0,0,5");
    assert!(inside.contains("inside of mesh"), "{inside}");
    let away = warned("--camera-eye 0,0,5 --camera-look 0,0,9");
    assert!(away.contains("nothing was drawn"), "{away}");
    let near = warned("--camera-eye 0,0,1.01 --camera-look 0,0,0");
    assert!(near.contains("the same colour"), "{near}");
    // Under --strict a warning is an error and nothing is written.
    desk.refused("render cube.obj --resolution 32x24 --camera-eye 0,0,5 --camera-look 0,0,9 --strict -o no.png", 4, "error[strict]");
    desk.texmap("render cube.obj --resolution 32x24 --strict -o yes.png")
        .ok();
    // A room is meant to be seen from inside.
    let room = desk
        .texmap("render room.scene --resolution 32x24 -o r.png")
        .ok();
    assert!(!room.stderr.contains("inside"));
}

#[test]
fn models_have_four_samples_and_scenes_what_they_say() {
    let desk = Desk::new();
    let samples = |arguments: &str| {
        desk.texmap(&format!(
            "render {arguments} --resolution 64x48 -o x.png --json"
        ))
        .ok()
        .json()["items"][0]
            .clone()
    };
    let (four, plain) = (samples("m.obj"), samples("m.obj --msaa 1"));
    assert_eq!((&four["msaa"], &plain["msaa"]), (&4.into(), &1.into()));
    assert_ne!(four["pixel_hash"], plain["pixel_hash"]);
    assert_eq!(four["pixel_hash"], samples("m.obj --msaa 4")["pixel_hash"]);
    assert_eq!(samples("room.scene")["msaa"], 1);
    assert_eq!(samples("m.obj --supersample 2")["msaa"], 1);
    // Arrays describe the centres of pixels either way.
    desk.texmap("render m.obj --resolution 64x48 --aov depth -o four.png")
        .ok();
    desk.texmap("render m.obj --resolution 64x48 --msaa 1 --aov depth -o one.png")
        .ok();
    assert_eq!(desk.read("four.depth.npy"), desk.read("one.depth.npy"));
}
