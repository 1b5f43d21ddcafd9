//! The depth-only pass is the depth of visibility, at every level and thread count.
use texmap_raster::{Draw, NoAlphaTest, Pass, Prepared, TileBuffers};
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
            .map(|d| Draw {
                pass: Pass::Opaque,
                depth_write: true,
                ..d
            })
            .collect();
        let plain = Prepared::plain(scene.target, &draws).expect("valid");
        let width = scene.target.width();
        let mut expected = vec![0.0_f32; (width * scene.target.height()) as usize];
        let mut buffers = TileBuffers::new();
        for index in 0..plain.tiles() {
            let tile = plain.tile(index);
            plain.visible(index, &NoAlphaTest, &mut buffers);
            for y in 0..tile.height {
                for x in 0..tile.width {
                    expected[((tile.y0 + y) * width + tile.x0 + x) as usize] =
                        buffers.depth[(y * 64 + x) as usize];
                }
            }
        }
        seen += expected.iter().filter(|&&d| d > 0.0).count();
        for (name, level) in levels() {
            let fast = Prepared::with_level(scene.target, &draws, level, 1).expect("valid");
            // What an earlier map left behind does not show.
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
