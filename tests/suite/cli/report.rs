//! The JSON report: its fields, and that they say the truth.

use crate::program::Desk;

#[test]
fn the_report_states_camera_counts_times_arrays_and_hash() {
    let desk = Desk::new();
    let run = desk
        .texmap("render room.scene --resolution 64x48 --aov uv,face -o out.png --json")
        .ok();
    let report = run.json();
    assert_eq!(report["texmap"], env!("CARGO_PKG_VERSION"));
    assert_eq!(
        (&report["schema"], &report["verb"], &report["exit"]),
        (&1.into(), &"render".into(), &0.into())
    );
    let settings = &report["settings"];
    assert_eq!(
        (
            &settings["width"],
            &settings["height"],
            &settings["supersample"]
        ),
        (&64.into(), &48.into(), &1.into())
    );
    let item = &report["items"][0];
    assert_eq!(item["status"], "ok");
    assert_eq!(item["scene"]["triangles"], 3);
    assert_eq!(item["scene"]["textures"], 1);
    assert_eq!(item["counts"]["triangles_submitted"], 3);
    for stage in ["load", "plan", "bin", "draw", "write"] {
        assert!(item["times_ms"][stage].as_f64().unwrap() >= 0.0, "{stage}");
    }
    assert_eq!(item["warnings"].as_array().unwrap().len(), 0);
    assert_eq!(item["aovs"][0]["path"], "out.uv.npy");
    assert_eq!(item["aovs"][0]["shape"], serde_json::json!([48, 64, 2]));
    assert_eq!(item["aovs"][1]["dtype"], "uint32");
    assert_eq!(item["aovs"][1]["hole"], "4294967295");
    let hash = item["pixel_hash"].as_str().unwrap();
    let (algorithm, digits) = hash.split_once(':').unwrap();
    assert_eq!(algorithm, "fnv1a-128");
    assert!(digits.len() == 32 && digits.bytes().all(|b| b.is_ascii_hexdigit()));
}

/// The hash is of the decoded pixels: anyone can compute it from the file.
#[test]
fn the_hash_is_that_of_the_decoded_picture() {
    let desk = Desk::new();
    let report = desk
        .texmap("render m.obj --resolution 40x30 -o out.png --json")
        .ok()
        .json();
    let picture = image::load_from_memory(&desk.read("out.png"))
        .unwrap()
        .into_rgba8();
    let mut hash = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128;
    let size = [
        picture.width().to_le_bytes(),
        picture.height().to_le_bytes(),
    ]
    .concat();
    for byte in size.iter().chain(picture.as_raw()) {
        hash = (hash ^ u128::from(*byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
    }
    assert_eq!(
        report["items"][0]["pixel_hash"],
        format!("fnv1a-128:{hash:032x}")
    );
}

/// `clip_from_world` takes the positions of the `position` array to the pixel centres they were seen at.
#[test]
fn the_matrices_project_positions_onto_their_pixels() {
    use texmap_io::npy::{self, Data};
    let desk = Desk::new();
    let (width, height) = (48, 36);
    let report = desk
        .texmap("render room.scene --resolution 48x36 --aov position,depth -o out.png --json")
        .ok()
        .json();
    let rows: [[f64; 4]; 4] =
        serde_json::from_value(report["items"][0]["cameras"][0]["clip_from_world"].clone())
            .unwrap();
    let Data::F32(positions) = npy::read(&desk.path("out.position.npy")).unwrap().data else {
        panic!("f32")
    };
    let Data::F32(depths) = npy::read(&desk.path("out.depth.npy")).unwrap().data else {
        panic!("f32")
    };
    let mut checked = 0;
    for (index, p) in positions
        .chunks(3)
        .enumerate()
        .filter(|(_, p)| !p[0].is_nan())
    {
        let p = [p[0], p[1], p[2], 1.0].map(f64::from);
        let [x, y, z, w] = rows.map(|row| row.iter().zip(p).map(|(m, p)| m * p).sum::<f64>());
        let px = (x / w * 0.5 + 0.5) * f64::from(width);
        let py = (0.5 - y / w * 0.5) * f64::from(height);
        let (column, row) = (index % width as usize, index / width as usize);
        assert!(
            (px - column as f64 - 0.5).abs() < 1e-3 && (py - row as f64 - 0.5).abs() < 1e-3,
            "{column} {row}"
        );
        assert!((z / w - f64::from(depths[index])).abs() < 1e-6);
        checked += 1;
    }
    assert!(checked > 200, "{checked} pixels");
}

#[test]
fn origins_are_those_of_the_files() {
    let desk = Desk::new();
    let model = desk
        .texmap("render m.obj --resolution 16x12 -o out.png --json")
        .ok()
        .json();
    assert_eq!(model["items"][0]["scene"]["uv_origin"], "bottom-left");
}
