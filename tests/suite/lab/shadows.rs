//! The cow of the accuracy scene under its sun: figures H1 to H4.

use std::path::Path;

use texmap_lab::shadow_scene::ShadowScene;
use texmap_light::ShadowBias;

fn cow() -> ShadowScene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/models/cow.obj");
    ShadowScene::standing(&path).unwrap()
}

/// Share of points that light reaches in error: at the cow's terminator facets shadow slivers of each other that are narrower than
/// the ring of eight neighbours can tell; they are there without a bias, too.
const SLIVERS: f64 = 1e-4;

/// A single point of the picture's, 0.0026 %.
const ONE: f64 = 3e-5;

#[test]
fn the_cow_has_the_figures_of_the_cases() {
    let scene = cow();
    let pixels = 256;
    let show = |what: &str, f: texmap_lab::shadow_scene::Figures| {
        eprintln!(
            "{what}: false shadow {:.4} %, false light {:.4} %, band {:.2} %",
            100.0 * f.false_shadow,
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
    assert!(none.false_shadow > 0.3, "acne is seen");
    let texel = 5.2 / 512.0;
    for (elevation, at_least) in [(25.0, 0.005), (10.0, 0.1)] {
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
            .measure(elevation, size, ShadowBias::Slope(1e-4), 1, pixels)
            .unwrap();
        show(&format!("H3, {elevation}, {size}"), slope);
        assert!(slope.false_shadow <= ONE, "{elevation} {size}");
        assert!(slope.false_light <= SLIVERS, "{elevation} {size}");
    }
    let (ruled, clamped) = scene.outside(60.0, 512, pixels).unwrap();
    eprintln!(
        "H4: {} % by the rule, {:.3} % clamped",
        100.0 * ruled,
        100.0 * clamped
    );
    assert!(ruled == 0.0 && clamped > 0.002);
}
