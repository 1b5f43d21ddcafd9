//! Every demo measures what it claims, and its pixels are pinned.
use texmap_lab::demos::{SIZES, demo, list};
use texmap_tests::golden;

/// Pixels a side of the panels that are pinned.
const SIZE: u32 = 160;

fn holds(name: &str) {
    let drawn = demo(name, SIZE).unwrap();
    assert!(!drawn.claims.is_empty() && !drawn.captions.is_empty());
    for claim in &drawn.claims {
        assert!(claim.holds(), "{name}: {claim}");
    }
    golden::check(&format!("demo-{name}"), &drawn.image);
}

macro_rules! demos {
    ($($test:ident $name:literal),* $(,)?) => {
        $(#[test] fn $test() { holds($name); })*

        #[test]
        fn every_demo_is_tested() {
            assert!(list().map(|(name, _)| name).eq([$($name),*]));
        }
    };
}

demos! {
    affine_image "affine-image",
    affine_checker "affine-checker",
    subdivided "subdivided",
    gouraud_tjoint "gouraud-tjoint",
    gouraud_lod "gouraud-lod",
    tiling "tiling",
    transparency "transparency",
    forward_inverse "forward-inverse",
    frame "frame",
    slides "slides",
    shadows "shadows",
    environments "environments",
    parallax "parallax",
    planar_mirror "planar-mirror",
    best_chart "best-chart",
    specular_maps "specular-maps",
    rectification "rectification",
    uv_mapping "uv-mapping",
    bumps "bumps",
    light_maps "light-maps",
    displacement "displacement",
    skin "skin",
    billboards "billboards",
    terrain "terrain",
    antialiasing "antialiasing",
    solids "solids",
    volumes "volumes",
    skies "skies",
    labels "labels",
}

/// A demo has no constants hidden in its size: other panels give the same figures within the tolerance.
#[test]
fn claims_hold_at_other_sizes() {
    for size in [*SIZES.start(), 333] {
        for name in [
            "tiling",
            "transparency",
            "forward-inverse",
            "gouraud-tjoint",
        ] {
            for claim in demo(name, size).unwrap().claims {
                assert!(claim.holds(), "{name} at {size}: {claim}");
            }
        }
    }
}

#[test]
fn unknown_names_and_sizes_are_refused() {
    let error = demo("affine", 256).unwrap_err().to_string();
    assert!(
        error.contains("'affine'") && error.contains("affine-checker"),
        "{error}"
    );
    for size in [0, 127, 1025] {
        assert!(
            demo("tiling", size)
                .unwrap_err()
                .to_string()
                .contains(&size.to_string())
        );
    }
}

/// A claim with a NaN or beyond its tolerance does not hold, and says so.
#[test]
fn a_false_claim_is_told() {
    let mut claim = demo("gouraud-lod", 128).unwrap().claims.remove(0);
    assert!(claim.to_string().starts_with("holds"));
    claim.measured = claim.expected + 1.01 * claim.tolerance;
    assert!(!claim.holds() && claim.to_string().starts_with("FAILS"));
    claim.measured = f64::NAN;
    assert!(!claim.holds());
}
