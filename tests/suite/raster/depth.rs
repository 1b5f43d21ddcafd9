//! The depth-only pass is the depth of visibility, at every level and thread count.
use texmap_math::Level;
use texmap_raster::{BinnedDraws, DrawCall, NoAlphaTest, Pass, TargetSize, VisibilityBuffer};
use texmap_tests::levels::levels;

use crate::levels::RandomScene;

#[test]
fn depth_map_is_the_depth_of_visibility() {
    let mut seen = 0;
    for seed in 0..80 {
        let scene = RandomScene::new(seed);
        let draws: Vec<_> = scene
            .draws()
            .into_iter()
            .map(|d| DrawCall {
                pass: Pass::Opaque,
                depth_write: true,
                ..d
            })
            .collect();
        let one =
            BinnedDraws::with_level(scene.target, &draws, Level::fallback(), 1).expect("valid");
        let width = scene.target.width();
        let mut expected = vec![0.0_f32; (width * scene.target.height()) as usize];
        let mut buffers = VisibilityBuffer::new();
        for index in 0..one.tiles() {
            let tile = one.tile(index);
            one.visible(index, &NoAlphaTest, &mut buffers);
            for y in 0..tile.height {
                for x in 0..tile.width {
                    expected[((tile.y0 + y) * width + tile.x0 + x) as usize] =
                        buffers.depth[(y * 64 + x) as usize];
                }
            }
        }
        seen += expected.iter().filter(|&&d| d > 0.0).count();
        for (name, level) in levels() {
            let fast = BinnedDraws::with_level(scene.target, &draws, level, 1).expect("valid");
            // Depths of an earlier map do not show.
            let mut map = vec![0.5; 777];
            fast.depth_map_into(1 + seed as usize % 3, &mut map);
            assert!(
                map.iter()
                    .map(|d| d.to_bits())
                    .eq(expected.iter().map(|d| d.to_bits())),
                "seed {seed}, {name}"
            );
        }
    }
    assert!(seen > 10_000, "{seen} pixels");
}

/// A polygon offset takes the slope of each triangle off its depth, with the same bits on every level: on a slanted plane that is the
/// farthest that the plane reaches within so many pixels.
#[test]
fn depth_slope_moves_each_plane_by_its_own_slope() {
    // Depth .5 + .2 x + .1 y over the target, in pixels of 1/32.
    let at = |x: f32, y: f32| [x, y, 0.5 + 0.2 * x + 0.1 * y];
    let positions = [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)];
    let draw = |depth_slope| DrawCall {
        positions: &positions,
        indices: &[[0, 1, 2], [0, 2, 3]],
        depth_slope,
        ..DrawCall::default()
    };
    let size = TargetSize::new(64, 64).unwrap();
    let map = |slope| {
        BinnedDraws::with_level(size, &[draw(slope)], Level::fallback(), 1)
            .unwrap()
            .depth_map(1)
    };
    let (flat, moved) = (map(0.0), map(3.0));
    for (a, b) in flat.iter().zip(&moved) {
        let expected = a - 3.0 * (0.2 + 0.1) / 32.0;
        assert!((b - expected).abs() < 1e-6, "{a} {b} {expected}");
    }
    assert!(map(40.0).contains(&0.0), "beyond the far plane");
    for seed in 0..40 {
        let scene = RandomScene::new(seed);
        let opaque = |d| DrawCall {
            pass: Pass::Opaque,
            depth_write: true,
            depth_slope: 2.5,
            ..d
        };
        let draws: Vec<_> = scene.draws().into_iter().map(opaque).collect();
        let one =
            BinnedDraws::with_level(scene.target, &draws, Level::fallback(), 1).expect("valid");
        let expected = one.depth_map(1);
        for (name, level) in levels() {
            let fast = BinnedDraws::with_level(scene.target, &draws, level, 1).expect("valid");
            let same = fast.depth_map(1);
            let mut pairs = expected.iter().zip(&same);
            assert!(
                pairs.all(|(a, b)| a.to_bits() == b.to_bits()),
                "{seed}, {name}"
            );
        }
    }
}
