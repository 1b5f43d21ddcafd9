//! All lanes give the bits of one lane, on every SIMD level and with any number of threads.
use texmap_math::glam::DMat4;
use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{
    AlphaTest, AttributePlanes, BinnedDraws, BlockSink, BlockValues, Cull, DepthTest, DrawCall,
    Fragment, FragmentBlock, Interp, NO_PRIMITIVE, NoAlphaTest, Pass, SAMPLES_4, SampleSetup,
    TargetSize, TileVisibility, UvBlock, Varying, Varyings, VisibilityBuffer,
};
use texmap_tests::levels::levels;

use crate::support::{Owned, Rng, free_w, jittered_grid, size};

/// A random scene of a few draws: meshes of many sizes, some behind the eye, some far outside, with every state.
pub(crate) struct RandomScene {
    meshes: Vec<Owned>,
    states: Vec<DrawCall<'static>>,
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
            let bad = rng.bits().is_multiple_of(4);
            for p in &mut mesh.positions {
                let [x, y] = [f64::from(p[0]) * scale, f64::from(p[1]) * scale];
                *p = [
                    (x + turn * y + shift[0]) as f32,
                    (y - turn * x + shift[1]) as f32,
                    (shift[2] + tilt * y) as f32,
                ];
                if bad && rng.bits().is_multiple_of(50) {
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
                if bad && rng.bits().is_multiple_of(90) {
                    *v = f32::NAN;
                }
            }
            let pick = |rng: &mut Rng, n: u32| rng.bits() % n;
            states.push(DrawCall {
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
                ..DrawCall::default()
            });
            meshes.push(mesh);
        }
        Self {
            meshes,
            states,
            target,
        }
    }

    pub(crate) fn draws(&self) -> Vec<DrawCall<'_>> {
        self.meshes
            .iter()
            .zip(&self.states)
            .map(|(mesh, state)| {
                let own = mesh.draw(DMat4::IDENTITY);
                DrawCall {
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
fn picture(prepared: &BinnedDraws<'_>) -> Vec<u32> {
    let mut out = Vec::new();
    let mut buffers = VisibilityBuffer::new();
    let mut fragment = Fragment::default();
    for index in 0..prepared.tiles() {
        let tile = prepared.tile(index);
        prepared.visible(index, &NoAlphaTest, &mut buffers);
        out.extend(buffers.depth.iter().map(|d| d.to_bits()));
        out.extend(&buffers.id);
        for (slot, &id) in buffers.id.iter().enumerate() {
            if id != NO_PRIMITIVE && slot % 7 == 0 {
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
fn every_level_and_thread_count_gives_the_bits_of_one_lane() {
    let (mut seen, mut clipped) = (0, 0);
    for seed in 0..200 {
        let scene = RandomScene::new(seed);
        let mut draws = scene.draws();
        if seed % 8 == 7 {
            // No test: what comes last is seen.
            for draw in &mut draws {
                (draw.depth_test, draw.depth_write) = (DepthTest::Always, seed % 16 == 7);
                if draw.pass == Pass::CutOut {
                    draw.pass = Pass::Opaque;
                }
            }
        }
        let one =
            BinnedDraws::with_level(scene.target, &draws, Level::fallback(), 1).expect("valid");
        let expected = picture(&one);
        seen += one.stats().binned;
        clipped += one.stats().clipped;
        for (name, level) in levels() {
            let threads = 1 + seed as usize % 3;
            let fast =
                BinnedDraws::with_level(scene.target, &draws, level, threads).expect("valid");
            assert_eq!(fast.stats(), one.stats(), "seed {seed}, {name}");
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

/// A wall drawn first hides what lies behind it, and nothing else: where it covers whole tiles these need no look at a pixel.
#[test]
fn what_a_wall_hides_is_hidden_in_one_lane() {
    let (mut walled, mut before) = (0, 0);
    for seed in 0..120 {
        let scene = RandomScene::new(seed);
        let mut rng = Rng::new(seed);
        let wall = Owned {
            positions: vec![[-9.0, -9.0, 1.0], [9.0, -9.0, 1.0], [0.3, 9.0, 1.0]],
            indices: vec![[0, 1, 2]],
            attributes: vec![0.0; 6],
            attribute_count: 2,
        };
        let mut wall = wall.draw(free_w(rng.log_range(1e-3, 0.1)));
        wall.depth_test = [DepthTest::Less, DepthTest::LessOrEqual][seed as usize % 2];
        let mut draws = scene.draws();
        // Before what may pass without a test, and after it.
        draws.insert(0, wall);
        draws.insert(2, wall);
        let one =
            BinnedDraws::with_level(scene.target, &draws, Level::fallback(), 1).expect("valid");
        let expected = picture(&one);
        let mut buffers = VisibilityBuffer::new();
        for tile in 0..one.tiles() {
            one.visible(tile, &NoAlphaTest, &mut buffers);
            walled += buffers.id.iter().filter(|id| **id == 0).count();
            before += buffers
                .id
                .iter()
                .filter(|id| **id != 0 && **id != NO_PRIMITIVE)
                .count();
        }
        for (name, level) in levels() {
            let fast = BinnedDraws::with_level(scene.target, &draws, level, 1).expect("valid");
            assert!(
                picture(&fast) == expected,
                "seed {seed}, {name}: other bits"
            );
        }
    }
    assert!(walled > 100_000 && before > 100_000, "{walled}, {before}");
}

/// Keeps what its first two attributes and their changes say. Asked about blocks or about single fragments.
struct Grille {
    by_blocks: bool,
}

impl Grille {
    fn keeps(uv: [f32; 2], ddx: [f32; 2], ddy: [f32; 2]) -> bool {
        let bits = uv.into_iter().chain(ddx).chain(ddy).map(f32::to_bits);
        bits.fold(0u32, |sum, bits| sum.wrapping_mul(31) ^ bits) % 3 != 0
    }
}

impl AlphaTest for Grille {
    fn keep(&self, _: u32, _: u32, at: &Fragment) -> bool {
        let two = |v: &[f32]| [v[0], v[1]];
        Self::keeps(two(&at.values), two(&at.ddx), two(&at.ddy))
    }

    fn keep_by_uv(&self, _: u32, at: &UvBlock, asked: u16) -> Option<u16> {
        let of = |v: &[[f32; 16]; 2], bit: usize| v.map(|column| column[bit]);
        let keep = |bit| Self::keeps(of(&at.value, bit), of(&at.ddx, bit), of(&at.ddy, bit));
        let bits = (0..16).filter(|bit| asked >> bit & 1 == 1 && keep(*bit));
        self.by_blocks
            .then(|| bits.fold(0, |kept, bit| kept | 1 << bit))
    }
}

#[test]
fn cut_outs_by_blocks_are_those_by_fragments() {
    let mut count = 0;
    for seed in 0..100 {
        let scene = RandomScene::new(seed);
        let mut draws = scene.draws();
        for draw in &mut draws {
            draw.pass = Pass::CutOut;
        }
        let one =
            BinnedDraws::with_level(scene.target, &draws, Level::fallback(), 1).expect("valid");
        let (mut expected, mut found) = (TileVisibility::new(), TileVisibility::new());
        for (name, level) in levels() {
            let fast = BinnedDraws::with_level(scene.target, &draws, level, 1).expect("valid");
            for tile in 0..one.tiles() {
                one.visible_blocks(tile, &Grille { by_blocks: false }, &mut expected);
                fast.visible_blocks(tile, &Grille { by_blocks: true }, &mut found);
                let bits =
                    |d: &TileVisibility| d.depth.iter().map(|d| d.to_bits()).collect::<Vec<_>>();
                assert!(
                    found.slot == expected.slot && bits(&found) == bits(&expected),
                    "seed {seed}, {name}, tile {tile}"
                );
                count += found
                    .slot
                    .iter()
                    .filter(|slot| **slot != NO_PRIMITIVE)
                    .count();
            }
        }
    }
    assert!(count > 100_000, "{count}");
}

/// Blocks handed out in submitted order are one lane's blended fragments.
#[test]
fn forward_blocks_are_the_blended_fragments() {
    let mut count = 0;
    for seed in 0..120 {
        let scene = RandomScene::new(seed);
        let draws: Vec<_> = scene
            .draws()
            .into_iter()
            .map(|d| DrawCall {
                pass: Pass::Blended,
                ..d
            })
            .collect();
        let one =
            BinnedDraws::with_level(scene.target, &draws, Level::fallback(), 1).expect("valid");
        for (name, level) in levels() {
            let fast = BinnedDraws::with_level(scene.target, &draws, level, 1).expect("valid");
            for index in 0..one.tiles() {
                let tile = one.tile(index);
                let mut expected = Vec::new();
                one.blended(index, &VisibilityBuffer::new(), &mut |id, x, y| {
                    expected.push((id, x, y));
                });
                let mut found = Vec::new();
                let (mut slots, mut blocks) = (Vec::new(), TileVisibility::new());
                let mut listed = Vec::new();
                fast.forward_blocks(index, &mut blocks, &|_| true, &mut listed);
                for FragmentBlock {
                    slot,
                    block,
                    mask: bits,
                } in listed
                {
                    let block = u32::from(block);
                    for bit in (0..16).filter(|b| bits >> b & 1 == 1) {
                        let (x, y) = (block % 16 * 4 + bit % 4, block / 16 * 4 + bit / 4);
                        slots.push((slot, tile.x0 + x, tile.y0 + y));
                    }
                }
                found.extend(
                    slots
                        .iter()
                        .map(|&(slot, x, y)| (blocks.ids[slot as usize], x, y)),
                );
                // Within a triangle the order is free.
                let order = |all: &mut Vec<(u32, u32, u32)>| {
                    all.chunk_by_mut(|a, b| a.0 == b.0)
                        .for_each(|run| run.sort_unstable());
                };
                order(&mut expected);
                order(&mut found);
                count += found.len();
                assert!(found == expected, "seed {seed}, {name}, tile {index}");
            }
        }
    }
    assert!(count > 100_000, "{count}");
}

/// Values of runs in the lanes that a level takes by default, four on 128-bit levels: stored, and shown to a sink.
struct Narrow {
    stored: Varyings,
    shown: Varyings,
}

impl Narrow {
    fn new(columns: usize) -> Self {
        let mut stored = Varyings::default();
        stored.varyings.resize(columns, Varying::ZERO);
        let mut shown = Varyings::default();
        shown.varyings.resize(2, Varying::ZERO);
        Self { stored, shown }
    }

    #[inline(always)]
    fn fill<I: Isa>(
        &mut self,
        i: I,
        planes: &AttributePlanes,
        blocks: &TileVisibility,
        run: &[FragmentBlock],
        wanted: &[usize],
    ) {
        planes.each_column::<_, true>(i, blocks, run, wanted, 0, &mut self.stored);
        planes.each_block::<_, true, _>(i, blocks, run, [1, 0], &mut Store(&mut self.shown));
    }

    fn assert_bits(&self, all: &Varyings, run: &[FragmentBlock], wanted: &[usize]) {
        let bits = |of: &Varyings, k: usize, place: usize| {
            let column = &of.varyings[k];
            [column.value[place], column.ddx[place], column.ddy[place]].map(f32::to_bits)
        };
        for (i, at) in run.iter().enumerate() {
            for bit in (0..16).filter(|bit| at.mask >> bit & 1 == 1) {
                let place = i * 16 + bit;
                let inv_w = all.inv_w[place].to_bits();
                assert_eq!(self.stored.inv_w[place].to_bits(), inv_w);
                for k in 0..wanted.len() {
                    assert_eq!(bits(&self.stored, k, place), bits(all, k, place));
                }
                if wanted.starts_with(&[1, 0]) {
                    assert_eq!(self.shown.inv_w[place].to_bits(), inv_w);
                    for k in 0..2 {
                        assert_eq!(bits(&self.shown, k, place), bits(all, k, place));
                    }
                }
            }
        }
    }
}

struct Store<'a>(&'a mut Varyings);

impl<I: Isa> BlockSink<I> for Store<'_> {
    #[inline(always)]
    fn pixels(&mut self, _: I, place: usize, _: FragmentBlock, values: &BlockValues<I>) {
        values.inv_w.store(&mut self.0.inv_w[place..]);
        for (k, column) in self.0.varyings.iter_mut().enumerate() {
            values.value[k].store(&mut column.value[place..]);
            values.ddx[k].store(&mut column.ddx[place..]);
            values.ddy[k].store(&mut column.ddy[place..]);
        }
    }
}

/// Values of runs of blocks are the bits of `evaluate`, pixel by pixel.
#[test]
fn runs_of_blocks_have_the_bits_of_single_pixels() {
    let mut count = 0;
    for seed in 0..100 {
        let scene = RandomScene::new(seed);
        let draws = scene.draws();
        for (name, level) in levels() {
            let prepared = BinnedDraws::with_level(scene.target, &draws, level, 1).expect("valid");
            let (mut blocks, mut planes, mut run) = (
                TileVisibility::new(),
                AttributePlanes::new(),
                Varyings::default(),
            );
            let mut fragment = Fragment::default();
            for index in 0..prepared.tiles() {
                let tile = prepared.tile(index);
                prepared.visible_blocks(index, &NoAlphaTest, &mut blocks);
                prepared.planes(index, &mut planes);
                // Blocks of the nearest fragments, and once more the pixels of each block's first fragment alone.
                let mut seen = Vec::new();
                for block in 0..256_u16 {
                    let slots = &blocks.slot[block as usize * 16..][..16];
                    let mask = |wanted: &dyn Fn(u32) -> bool| {
                        (0..16)
                            .filter(|&bit| wanted(slots[bit]))
                            .fold(0, |mask, bit| mask | 1 << bit)
                    };
                    let at = FragmentBlock {
                        block,
                        mask: mask(&|slot| slot != NO_PRIMITIVE),
                        slot: NO_PRIMITIVE,
                    };
                    if at.mask != 0 {
                        let first = slots[at.mask.trailing_zeros() as usize];
                        seen.push(at);
                        seen.push(FragmentBlock {
                            block,
                            mask: mask(&|slot| slot == first),
                            slot: first,
                        });
                    }
                }
                for (chunk, wanted) in seen
                    .chunks(16)
                    .zip([&[1, 0][..], &[0], &[1, 0, 1], &[]].into_iter().cycle())
                {
                    planes.values(level, &blocks, chunk, wanted, true, &mut run);
                    for (i, at) in chunk.iter().enumerate() {
                        for bit in (0..16).filter(|bit| at.mask >> bit & 1 == 1) {
                            let (block, place) = (u32::from(at.block), i * 16 + bit);
                            let x = tile.x0 + block % 16 * 4 + bit as u32 % 4;
                            let y = tile.y0 + block / 16 * 4 + bit as u32 / 4;
                            let id = blocks.ids[blocks.slot[block as usize * 16 + bit] as usize];
                            prepared.evaluate(id, x, y, &mut fragment);
                            let mut found = vec![run.inv_w[place]];
                            let mut expected = vec![fragment.inv_w];
                            for (column, &k) in run.varyings.iter().zip(wanted) {
                                let d = [column.ddx[place], column.ddy[place]];
                                found.extend([column.value[place], d[0], d[1]]);
                                let d = [fragment.ddx[k], fragment.ddy[k]];
                                expected.extend([fragment.values[k], d[0], d[1]]);
                            }
                            let bits =
                                |v: &[f32]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                            assert_eq!(
                                bits(&found),
                                bits(&expected),
                                "seed {seed}, {name}, {x} {y}: {found:?} {expected:?}"
                            );
                            count += 1;
                        }
                    }
                    let all = run.clone();
                    let mut narrow = Narrow::new(wanted.len());
                    dispatch_simd!(level, i => narrow.fill(i, &planes, &blocks, chunk, wanted));
                    narrow.assert_bits(&all, chunk, wanted);
                    planes.values(level, &blocks, chunk, wanted, false, &mut run);
                    for (i, at) in chunk.iter().enumerate() {
                        for place in (0..16)
                            .filter(|bit| at.mask >> bit & 1 == 1)
                            .map(|bit| i * 16 + bit)
                        {
                            assert_eq!(run.inv_w[place].to_bits(), all.inv_w[place].to_bits());
                            for k in 0..wanted.len() {
                                assert_eq!(
                                    run.varyings[k].value[place].to_bits(),
                                    all.varyings[k].value[place].to_bits()
                                );
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(count > 100_000, "{count}");
}

/// Samples beside the centres. Lanes give the bits of one lane, and the fill rule holds for them as for the centres.
#[test]
fn samples_have_the_bits_of_one_lane_and_leave_no_crack() {
    let mut seen = 0;
    for seed in 0..40 {
        let scene = RandomScene::new(seed);
        let draws = scene.draws();
        let one =
            BinnedDraws::with_samples(scene.target, &draws, Level::fallback(), 1).expect("valid");
        let (mut expected, mut found) = (TileVisibility::new(), TileVisibility::new());
        let mut all: [TileVisibility; 4] = std::array::from_fn(|_| TileVisibility::new());
        let mut setup = SampleSetup::default();
        for (name, level) in levels() {
            let fast = BinnedDraws::with_samples(scene.target, &draws, level, 1).expect("valid");
            assert_eq!(fast.stats(), one.stats(), "seed {seed}, {name}");
            for tile in 0..one.tiles() {
                let together = SAMPLES_4.into_iter().zip(&mut all);
                fast.visible_samples(tile, &NoAlphaTest, &mut setup, together);
                for (offset, shared) in SAMPLES_4.into_iter().zip(&all) {
                    one.visible_sample(tile, offset, &NoAlphaTest, &mut expected);
                    fast.visible_sample(tile, offset, &NoAlphaTest, &mut found);
                    assert!(
                        found.slot == expected.slot,
                        "seed {seed}, {name}, tile {tile}: other fragments"
                    );
                    let bits = |b: &TileVisibility| {
                        b.depth.iter().map(|d| d.to_bits()).collect::<Vec<_>>()
                    };
                    assert!(
                        bits(&found) == bits(&expected),
                        "seed {seed}, {name}, tile {tile}: other depth"
                    );
                    assert!(
                        shared.slot == found.slot
                            && shared.masks == found.masks
                            && bits(shared) == bits(&found),
                        "seed {seed}, {name}, tile {tile}: others if set up once"
                    );
                    seen += found.slot.iter().filter(|&&s| s != NO_PRIMITIVE).count();
                }
            }
        }
    }
    assert!(seen > 100_000, "{seen}");
    // A fine mesh, cells of about a pixel, over the whole target: no sample is free.
    let target = size(64, 64);
    let mut mesh = jittered_grid(&mut Rng::new(11), 70);
    for p in &mut mesh.positions {
        *p = [p[0] * 1.1, p[1] * 1.1, 0.5];
    }
    let draw = mesh.draw(DMat4::IDENTITY);
    let prepared = BinnedDraws::with_samples(target, &[draw], Level::new(), 1).expect("valid");
    let mut blocks = TileVisibility::new();
    for offset in SAMPLES_4 {
        prepared.visible_sample(0, offset, &NoAlphaTest, &mut blocks);
        assert!(blocks.slot.iter().all(|&s| s != NO_PRIMITIVE));
    }
}
