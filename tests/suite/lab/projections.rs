//! The scenes of `assets` under their projectors: what their depth maps are for.

use std::path::Path;

use texmap_io::LoadOptions;
use texmap_lab::demos::projections;

fn sheet(name: &str, spoiled: f64) -> Vec<texmap_lab::demos::Claim> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes");
    let scene = texmap_io::load_scene(&folder.join(name), &LoadOptions::default()).unwrap();
    projections(name, &scene, 200, spoiled).unwrap().claims
}

#[test]
fn depth_maps_keep_slides_from_shining_through() {
    for (name, spoiled) in [("teapot_slides.scene", 10.3), ("painted_cow.scene", 0.5)] {
        for claim in sheet(name, spoiled) {
            assert!(claim.holds(), "{name}: {claim}");
        }
    }
}

#[test]
fn a_scene_without_projectors_is_refused() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes");
    let file = folder.join("teapot.scene");
    let scene = texmap_io::load_scene(&file, &LoadOptions::default()).unwrap();
    let error = projections("none", &scene, 200, 1.0).unwrap_err();
    assert!(error.to_string().contains("projector"), "{error}");
}
