//! The accuracy scenes of interpolation through the whole renderer: its uv buffer against one ray a pixel.
use texmap_lab::scenes::UvScene;
use texmap_raster::Interp;

fn checked(scene: &UvScene) {
    let error = scene
        .error(&scene.by_render(Interp::Perspective).unwrap())
        .unwrap();
    assert!(error.compared > 10_000, "{error:?}");
    assert!(
        error.mismatches == 0.0 && error.of_allowed <= 1.0,
        "{error:?}"
    );
}

/// 1e-6 of the range on the conformance quad and from nearly flat to steep.
#[test]
fn perspective_planes_agree_within_a_millionth_of_the_range() {
    checked(&UvScene::cts_quad());
    for ratio in [1.02, 1.1, 2.0, 4.0, 8.0, 16.0, 64.0] {
        checked(&UvScene::ratio(ratio));
    }
}

/// 0.01 texel of 1024 through the eye's plane and at 1e4; 1 texel at 1e6; or one f32 step of the value.
#[test]
fn ground_planes_agree_within_their_texels() {
    for half in [200.0, 1e4, 1e6] {
        checked(&UvScene::ground(half));
    }
}

#[test]
fn nothing_is_seen_of_a_plane_behind_the_eye() {
    let scene = UvScene::behind();
    assert!(
        scene
            .by_render(Interp::Perspective)
            .unwrap()
            .iter()
            .all(Option::is_none)
    );
}

/// The negative twin: affine misses the bound by orders of magnitude, from a w-ratio of 1.02 on.
#[test]
fn affine_planes_fail_the_same_bound() {
    for scene in [
        UvScene::cts_quad(),
        UvScene::ratio(1.02),
        UvScene::ratio(64.0),
    ] {
        let error = scene
            .error(&scene.by_render(Interp::Affine).unwrap())
            .unwrap();
        assert!(error.of_allowed > 1000.0, "{error:?}");
    }
}

/// A half-pixel shift of the picture is seen at once: the figures are not blind to where a sample lies.
#[test]
fn a_shifted_image_fails_the_same_bound() {
    let scene = UvScene::ratio(2.0);
    let mut shifted = scene.clone();
    let step = 1.0 / f64::from(scene.size);
    shifted.camera.look.x += step;
    let error = scene
        .error(&shifted.by_render(Interp::Perspective).unwrap())
        .unwrap();
    assert!(error.of_allowed > 1000.0, "{error:?}");
}
