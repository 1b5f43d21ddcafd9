//! Bakes of the scene that has every effect.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use texmap_bake::{BakeOptions, Baker, bake};
use texmap_render::{RenderError, shadow_map_for};
use texmap_scene::{shadow_bias, shadow_kind};

use crate::effects::all;

/// Light maps come out the same for any number of threads, and agree with light computed per pixel.
#[test]
fn bakes_are_the_same_on_any_number_of_threads() {
    let scene = all();
    let mut shadows = Vec::new();
    for light in 1..4 {
        let kind = shadow_kind(&scene, light, None).unwrap();
        let bias = shadow_bias(&scene);
        let map = shadow_map_for(&scene, &kind, 128, bias, 3, 1).unwrap();
        shadows.push((light, map, bias, 3));
    }
    let options = BakeOptions {
        size: 64,
        gutter: 2,
        shadows: &shadows,
        lights: None,
    };
    let pool = |n| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .unwrap()
    };
    let one = pool(1).install(|| bake(&scene, 0, &options).unwrap());
    let three = pool(3).install(|| bake(&scene, 0, &options).unwrap());
    assert_eq!(one, three);
    let dark = one.texels.iter().filter(|c| c[0] < 0.3).count();
    assert!(dark > 50 && dark < 3_000, "{dark}");
    assert!(one.texels.iter().flatten().all(|c| c.is_finite()));
}

/// A break at a step of the atlas or at a lit row ends a bake there.
#[test]
fn a_break_of_progress_ends_a_bake() {
    let scene = all();
    let options = BakeOptions {
        size: 64,
        gutter: 2,
        shadows: &[],
        lights: None,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let work = |last: usize| {
        let calls = AtomicUsize::new(0);
        let progress = |_: usize, _: usize| {
            let call = calls.fetch_add(1, Ordering::Relaxed) + 1;
            match call < last {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }
        };
        let baker = Baker::new(&scene).unwrap();
        (
            baker.bake_with_progress(0, &options, &progress),
            calls.into_inner(),
        )
    };
    pool.unwrap().install(|| {
        let (whole, calls) = work(usize::MAX);
        assert_eq!(whole.unwrap(), bake(&scene, 0, &options).unwrap());
        // One row of tiles in four stages, two texels of gutter, 64 rows.
        assert_eq!(calls, 4 + 2 + 64);
        for last in [1, 4, 5, 6, 40, calls] {
            let (cancelled, early) = work(last);
            assert!(matches!(cancelled, Err(RenderError::Cancelled)));
            assert_eq!(early, last);
        }
    });
}
