//! Bounds on a triangle's derivatives over a tile hold at each of its pixels.
use texmap_math::Level;
use texmap_raster::{
    AttributePlanes, BinnedDraws, Fragment, NO_PRIMITIVE, NoAlphaTest, SAMPLES_4, TileVisibility,
};

use crate::levels::RandomScene;
use crate::support::{Owned, free_w, size};

/// Asks `check` about each pixel of a tile: its slot, the most that is said of it, its fragment. Returns how many were asked about.
fn each_pixel(
    prepared: &BinnedDraws<'_>,
    sampled: bool,
    mut check: impl FnMut(Option<[[f32; 2]; 2]>, &Fragment),
) {
    let (mut blocks, mut planes, mut fragment) = (
        TileVisibility::new(),
        AttributePlanes::new(),
        Fragment::default(),
    );
    for index in 0..prepared.tiles() {
        let tile = prepared.tile(index);
        if sampled {
            prepared.visible_sample(index, SAMPLES_4[1], &NoAlphaTest, &mut blocks);
        } else {
            prepared.visible_blocks(index, &NoAlphaTest, &mut blocks);
        }
        prepared.planes(index, &mut planes);
        for (place, &slot) in blocks
            .slot
            .iter()
            .enumerate()
            .filter(|(_, slot)| **slot != NO_PRIMITIVE)
        {
            let (block, bit) = (place as u32 / 16, place as u32 % 16);
            let x = tile.x0 + block % 16 * 4 + bit % 4;
            let y = tile.y0 + block / 16 * 4 + bit / 4;
            prepared.evaluate(blocks.ids[slot as usize], x, y, &mut fragment);
            check(planes.max_gradient(slot, [0, 1]), &fragment);
        }
    }
}

fn found(fragment: &Fragment) -> [[f32; 2]; 2] {
    [0, 1].map(|k| [fragment.ddx[k].abs(), fragment.ddy[k].abs()])
}

#[test]
fn no_pixel_changes_faster() {
    let (mut known, mut unknown) = (0, 0);
    for seed in 0..150 {
        let scene = RandomScene::new(seed);
        let draws = scene.draws();
        let sampled = seed % 3 == 0;
        let prepared = if sampled {
            BinnedDraws::with_samples(scene.target, &draws, Level::new(), 1)
        } else {
            BinnedDraws::with_level(scene.target, &draws, Level::new(), 1)
        };
        each_pixel(&prepared.expect("valid"), sampled, |most, fragment| {
            let Some(most) = most else {
                unknown += 1;
                return;
            };
            known += 1;
            for (most, found) in most
                .as_flattened()
                .iter()
                .zip(found(fragment).as_flattened())
            {
                assert!(found <= most, "seed {seed}: {found} > {most}");
            }
        });
    }
    assert!(known > 100_000 && unknown > 1000, "{known} {unknown}");
}

/// The bound is close: over a tilted plane that fills tiles some pixel comes near it.
#[test]
fn some_pixel_of_a_full_tile_changes_nearly_as_fast() {
    let corners = [(-4.0, -4.0, 0.5), (4.0, -4.0, 0.6), (0.0, 6.0, 1.0)];
    let plane = Owned {
        positions: corners.map(|(x, y, w)| [x * w, y * w, w]).to_vec(),
        indices: vec![[0, 1, 2]],
        ..Owned::default()
    };
    let plane = plane.with_uv(|[x, y, w]| [x * 3.0 + w, y - x]);
    let draws = [plane.draw(free_w(0.2))];
    let prepared = BinnedDraws::with_level(size(64, 64), &draws, Level::new(), 1).expect("valid");
    let mut reached = [[0.0f32; 2]; 2];
    let mut most = None;
    each_pixel(&prepared, false, |of, fragment| {
        most = of;
        for (reached, found) in reached
            .as_flattened_mut()
            .iter_mut()
            .zip(found(fragment).as_flattened())
        {
            *reached = reached.max(*found);
        }
    });
    let most = most.expect("far from the eye");
    for (reached, most) in reached.as_flattened().iter().zip(most.as_flattened()) {
        assert!(*reached > 0.8 * most, "{reached} of {most}");
    }
}
