//! `texmap stability`, `texmap chart`, and renders by budget.

use crate::program::Desk;

#[test]
fn stability_shows_the_naive_method_failing() {
    let desk = Desk::new();
    let report = desk.texmap("stability S5 --json").ok().json();
    assert_eq!(report["passes"], true);
    let checks = report["cases"][0]["checks"].as_array().unwrap().clone();
    let naive = checks.iter().find(|c| c["naive"] == true).unwrap();
    assert_eq!(naive["verdict"], "fails, as it must");
    assert!(naive["measured"].as_f64().unwrap() > naive["limit"].as_f64().unwrap());
    let unknown = desk.texmap("stability X9");
    assert_eq!(unknown.code, 2);
    assert!(unknown.stderr.contains("X9"), "{}", unknown.stderr);
}

#[test]
fn a_chart_is_a_page_or_a_table() {
    let desk = Desk::new();
    assert_eq!(desk.texmap("chart -o chart.txt").code, 2);
    // Refused before anything is measured, which would take minutes.
    desk.refused("chart -o chart.html --svg m.obj", 4, "m.obj is no folder");
    desk.texmap("chart room.scene -o room.csv -r 32x24 --quick")
        .ok();
    let table = std::fs::read_to_string(desk.path("room.csv")).unwrap();
    for method in ["nearest", "anisotropic:16", "trilinear, affine"] {
        assert!(table.contains(method), "{method} is not in\n{table}");
    }
}

#[test]
fn a_budget_that_nothing_meets_is_said_and_ends_with_five() {
    let desk = Desk::new();
    let good =
        desk.texmap("render m.obj -o m.png --resolution 64x48 --quality draft --json --explain");
    let plan = &good.json()["items"][0]["plans"][0];
    assert_eq!(plan["met"], good.code == 0);
    assert!(good.stderr.contains("predicted"), "{}", good.stderr);
    let tight = desk
        .texmap("render m.obj -o m.png --resolution 64x48 --max-error 0.5,1e-9 --verify --json");
    assert_eq!(tight.code, 5, "{}", tight.stderr);
    assert!(tight.stderr.contains("budget not met"));
    assert!(
        tight.json()["items"][0]["truth"]["pixels_judged"]
            .as_u64()
            .unwrap()
            > 0
    );
    assert!(desk.path("m.heat.png").is_file());
}

/// A promise that does not hold is a failed claim: here light comes from a volume whose steps are too long, which no filter can tell.
#[test]
fn a_true_error_over_the_budget_ends_with_one() {
    let desk = Desk::new();
    let face = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 0 1 2 3\n";
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap();
    let cloud = root.join("assets/textures/cloud.npy");
    std::fs::copy(cloud, desk.path("cloud.npy")).unwrap();
    let scene = |step: &str| {
        format!("eye 0 0 4\nla 1 1 1\n{face}volume cloud.npy 0 0 1 2 2 1 4 step {step}\n")
    };
    desk.put("coarse.scene", scene("2"));
    desk.put("fine.scene", scene("0.02"));
    let words = "-o a.png --resolution 48x36 --quality good --verify --json";
    let coarse = desk.texmap(&format!("render coarse.scene {words}"));
    assert_eq!(coarse.code, 1, "{}", coarse.stderr);
    assert!(
        coarse.stderr.contains("is over the budget of 0.02"),
        "{}",
        coarse.stderr
    );
    assert!(
        coarse
            .stderr
            .contains("assumed true: perspective coordinates, bilinear texels")
    );
    let fine = desk.texmap(&format!("render fine.scene {words}"));
    assert_eq!(fine.code, 0, "{}", fine.stderr);
    let truth = &fine.json()["items"][0]["truth"];
    assert!(truth["assumes"].as_str().unwrap().contains("hard shadows"));
    assert_eq!(truth["shadow_edge_pixels"], 0);
}

/// The reference wraps as the picture does.
#[test]
fn verify_follows_a_wrap_mode_of_the_command_line() {
    let desk = Desk::new();
    let face =
        "texture check.png\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\ntf 0 0 2 1 2 2 2 2 0 3 0 0\n";
    desk.put("wall.scene", format!("eye 0 0 2\n{face}"));
    let words = "-o a.png --resolution 48x36 --wrap clamp-to-edge --verify --json";
    let run = desk.texmap(&format!("render wall.scene {words}"));
    let rmse = run.json()["items"][0]["truth"]["rmse"].as_f64().unwrap();
    assert!(rmse < 0.05, "{rmse}");
}

#[test]
fn a_plan_names_the_environments_that_are_read() {
    let desk = Desk::new();
    let face = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nf 0 1 2\n";
    desk.put(
        "shiny.scene",
        format!("env check.png octahedron 0.5\nspecmap check.png octahedron 20\n{face}"),
    );
    desk.put("plain.scene", face);
    let words = "-o a.png --resolution 16x16 --quality draft --explain --json";
    let shiny = desk.texmap(&format!("render shiny.scene {words}"));
    let report = shiny.json();
    let read = report["items"][0]["plans"][0]["environments"].clone();
    assert_eq!(read[0]["chart"], "octahedron");
    assert_eq!(
        (&read[0]["width"], &read[0]["exponent"]),
        (&8.into(), &serde_json::Value::Null)
    );
    // 10 sqrt(20) texels a side, rounded up.
    assert_eq!(
        (&read[1]["width"], &read[1]["needed"]),
        (&45.into(), &45.into())
    );
    assert_eq!(read[1]["exponent"], 20.0);
    let line = "environment 1: cube, 45 x 45 texels a face; specular map of exponent 20";
    assert!(shiny.stderr.contains(line), "{}", shiny.stderr);
    // Negative twin: nothing is read, nothing is named.
    let plain = desk.texmap(&format!("render plain.scene {words}"));
    let none = plain.json()["items"][0]["plans"][0]["environments"].clone();
    assert_eq!(none, serde_json::json!([]));
    assert!(!plain.stderr.contains("environment"), "{}", plain.stderr);
}
