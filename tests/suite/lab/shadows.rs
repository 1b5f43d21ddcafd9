//! The cow of the accuracy scene under its sun: figures H1 to H4.

use std::path::Path;

use texmap_lab::shadow_scene::ShadowScene;
use texmap_light::ShadowBias;

fn cow() -> ShadowScene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/models/cow.obj");
    ShadowScene::standing(&path).unwrap()
}

/// What the case demands: 0.001 %. A picture of 512 x 512 sees enough points for it; at 256 x 256 one is more than that.
const DEMANDED: f64 = 1e-5;
const PIXELS: u32 = 512;

/// False shadow that a plane's bias leaves where facets rise from it.
const CREASES: f64 = 3e-4;

#[test]
fn the_cow_has_the_figures_of_the_cases() {
    let scene = cow();
    let pixels = 256;
    let show = |what: &str, f: texmap_lab::shadow_scene::Figures| {
        eprintln!(
            "{what}: false shadow {:.4} %, at creases {:.4} %, false light {:.4} %, band {:.2} %",
            100.0 * f.false_shadow,
            100.0 * f.creases,
            100.0 * f.false_light,
            100.0 * f.band
        );
        f
    };
    let none = show(
        "H1, 60",
        scene
            .measure(60.0, 512, ShadowBias::Constant(0.0), 1, pixels)
            .unwrap(),
    );
    assert!(none.false_shadow > 0.4, "acne is seen");
    let texel = 5.2 / 512.0;
    for (elevation, at_least) in [(25.0, 0.025), (10.0, 0.25)] {
        let constant = scene
            .measure(elevation, 512, ShadowBias::Constant(texel), 1, pixels)
            .unwrap();
        show("H2", constant);
        assert!(constant.false_shadow > at_least, "{elevation}");
    }
    for (elevation, size) in [
        (60.0, 512),
        (25.0, 512),
        (10.0, 512),
        (25.0, 2048),
        (10.0, 2048),
    ] {
        let slope = scene
            .measure(elevation, size, ShadowBias::Slope(1e-4), 1, PIXELS)
            .unwrap();
        show(&format!("H3, {elevation}, {size}"), slope);
        assert!(slope.false_shadow <= DEMANDED, "{elevation} {size}");
        assert!(slope.false_light <= DEMANDED, "{elevation} {size}");
        assert!(slope.creases <= CREASES, "{elevation} {size}");
    }
    let (ruled, clamped) = scene.outside(60.0, 512, pixels).unwrap();
    eprintln!(
        "H4: {} % by the rule, {:.3} % clamped",
        100.0 * ruled,
        100.0 * clamped
    );
    assert!(ruled == 0.0 && clamped > 0.002);
}
