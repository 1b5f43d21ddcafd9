//! The fast path gives the bits of the plain one, on every SIMD level and with any number of threads.
use texmap_math::glam::DMat4;
use texmap_raster::{
    Cull, DepthTest, Draw, Fragment, Interp, NONE, NoAlphaTest, Pass, Prepared, TargetSize,
    TileBuffers,
};
use texmap_tests::levels::levels;

use crate::support::{Owned, Rng, free_w, jittered_grid, size};

/// A random scene of a few draws: meshes of many sizes, some behind the eye, some far outside, with every state.
pub(crate) struct RandomScene {
    meshes: Vec<Owned>,
    states: Vec<Draw<'static>>,
    pub(crate) target: TargetSize,
}

impl RandomScene {
    pub(crate) fn new(seed: u64) -> Self {
        let mut rng = Rng::new(seed ^ 0x5EED);
        let target = size(1 + rng.bits() % 300, 1 + rng.bits() % 200);
        let (mut meshes, mut states) = (Vec::new(), Vec::new());
        for _ in 0..1 + rng.bits() % 4 {
            let n = 1 + rng.bits() % 30;
            let mut mesh = jittered_grid(&mut rng, n);
            let scale = rng.log_range(0.02, 300.0);
            let tilt = rng.range(-3.0, 3.0);
            let turn = rng.range(-1.0, 1.0);
            let shift = [
                rng.range(-1.0, 1.0),
                rng.range(-1.0, 1.0),
                rng.range(0.0, 3.0),
            ];
            let bad = rng.bits() % 4 == 0;
            for p in &mut mesh.positions {
                let [x, y] = [f64::from(p[0]) * scale, f64::from(p[1]) * scale];
                *p = [
                    (x + turn * y + shift[0]) as f32,
                    (y - turn * x + shift[1]) as f32,
                    (shift[2] + tilt * y) as f32,
                ];
                if bad && rng.bits() % 50 == 0 {
                    p[rng.bits() as usize % 3] =
                        [f32::NAN, f32::INFINITY, 1e30, -1e30][rng.bits() as usize % 4];
                }
            }
            let mut mesh = mesh.with_uv(|[x, y, _]| [x * 3.0, y - x]);
            for v in &mut mesh.attributes {
                *v = if v.is_finite() {
                    v.clamp(-1e6, 1e6)
                } else {
                    0.5
                };
                if bad && rng.bits() % 90 == 0 {
                    *v = f32::NAN;
                }
            }
            let pick = |rng: &mut Rng, n: u32| rng.bits() % n;
            states.push(Draw {
                clip_from_object: free_w(rng.log_range(1e-4, 0.3)),
                cull: [Cull::None, Cull::Back, Cull::Front][pick(&mut rng, 3) as usize],
                depth_test: [DepthTest::Less, DepthTest::LessOrEqual, DepthTest::Always]
                    [pick(&mut rng, 3) as usize],
                depth_write: pick(&mut rng, 5) > 0,
                pass: [Pass::Opaque, Pass::Opaque, Pass::CutOut, Pass::Blended]
                    [pick(&mut rng, 4) as usize],
                interp: match pick(&mut rng, 8) {
                    0 => Interp::Affine,
                    1 => Interp::Subdivided(2),
                    2 => Interp::Span(5),
                    3 => Interp::WithinError(0.01),
                    _ => Interp::Perspective,
                },
                screen_linear: u32::from(pick(&mut rng, 4) == 0),
                ..Draw::default()
            });
            meshes.push(mesh);
        }
        Self {
            meshes,
            states,
            target,
        }
    }

    pub(crate) fn draws(&self) -> Vec<Draw<'_>> {
        self.meshes
            .iter()
            .zip(&self.states)
            .map(|(mesh, state)| {
                let own = mesh.draw(DMat4::IDENTITY);
                Draw {
                    positions: own.positions,
                    indices: own.indices,
                    attributes: own.attributes,
                    attribute_count: own.attribute_count,
                    ..*state
                }
            })
            .collect()
    }
}

/// Everything that can be seen of a scene, as bits.
fn picture(prepared: &Prepared<'_>) -> Vec<u32> {
    let mut out = Vec::new();
    let mut buffers = TileBuffers::new();
    let mut fragment = Fragment::default();
    for index in 0..prepared.tiles() {
        let tile = prepared.tile(index);
        prepared.visible(index, &NoAlphaTest, &mut buffers);
        out.extend(buffers.depth.iter().map(|d| d.to_bits()));
        out.extend(&buffers.id);
        for (slot, &id) in buffers.id.iter().enumerate() {
            if id != NONE && slot % 7 == 0 {
                let (x, y) = (tile.x0 + slot as u32 % 64, tile.y0 + slot as u32 / 64);
                prepared.evaluate(id, x, y, &mut fragment);
                out.extend(
                    [fragment.values[0], fragment.values[1], fragment.inv_w].map(f32::to_bits),
                );
            }
        }
        prepared.blended(index, &buffers, &mut |id, x, y| out.extend([id, x, y]));
    }
    out
}

#[test]
fn every_level_and_thread_count_gives_the_plain_bits() {
    let (mut seen, mut clipped) = (0, 0);
    for seed in 0..200 {
        let scene = RandomScene::new(seed);
        let draws = scene.draws();
        let plain = Prepared::plain(scene.target, &draws).expect("valid");
        let expected = picture(&plain);
        seen += plain.stats().binned;
        clipped += plain.stats().clipped;
        for (name, level) in levels() {
            let threads = 1 + seed as usize % 3;
            let fast = Prepared::with_level(scene.target, &draws, level, threads).expect("valid");
            assert_eq!(fast.stats(), plain.stats(), "seed {seed}, {name}");
            assert!(
                picture(&fast) == expected,
                "seed {seed}, {name}: other bits"
            );
        }
    }
    assert!(
        seen > 10_000 && clipped > 100,
        "{seen} seen, {clipped} clipped"
    );
}
