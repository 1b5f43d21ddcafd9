//! Meshes, random numbers and whole-target helpers of this suite.
use texmap_math::glam::{DMat4, DVec4};
use texmap_raster::{
    BinnedDraws, DepthTest, DrawCall, Fragment, NO_PRIMITIVE, NoAlphaTest, Pass, TILE, TargetSize,
    VisibilityBuffer,
};

/// A mesh that owns what a draw borrows.
#[derive(Debug, Clone, Default)]
pub(crate) struct Owned {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) indices: Vec<[u32; 3]>,
    pub(crate) attributes: Vec<f32>,
    pub(crate) attribute_count: usize,
}

impl Owned {
    /// Attributes u, v from a function of the position.
    pub(crate) fn with_uv(mut self, uv: impl Fn([f32; 3]) -> [f32; 2]) -> Self {
        self.attributes = self.positions.iter().flat_map(|&p| uv(p)).collect();
        self.attribute_count = 2;
        self
    }

    pub(crate) fn draw(&self, clip_from_object: DMat4) -> DrawCall<'_> {
        DrawCall {
            positions: &self.positions,
            indices: &self.indices,
            attributes: &self.attributes,
            attribute_count: self.attribute_count,
            clip_from_object,
            ..DrawCall::default()
        }
    }

    pub(crate) fn clip(&self, matrix: DMat4, triangle: usize) -> [DVec4; 3] {
        self.indices[triangle].map(|i| {
            let [x, y, z] = self.positions[i as usize].map(f64::from);
            matrix * DVec4::new(x, y, z, 1.0)
        })
    }
}

/// Positions (x w, y w, w) to clip (x w, y w, z, w): vertices with a w of their own, and a constant clip z.
pub(crate) fn free_w(z: f64) -> DMat4 {
    DMat4::from_cols(
        DVec4::new(1.0, 0.0, 0.0, 0.0),
        DVec4::new(0.0, 1.0, 0.0, 0.0),
        DVec4::new(0.0, 0.0, 0.0, 1.0),
        DVec4::new(0.0, 0.0, z, 0.0),
    )
}

/// Number of fragments that cover each pixel's centre.
pub(crate) fn hits(size: TargetSize, draws: &[DrawCall<'_>]) -> Vec<u32> {
    let draws: Vec<_> = draws
        .iter()
        .map(|d| DrawCall {
            pass: Pass::Blended,
            depth_test: DepthTest::Always,
            ..*d
        })
        .collect();
    let prepared = BinnedDraws::new(size, &draws).expect("valid draws");
    let buffers = VisibilityBuffer::new();
    let mut count = vec![0; (size.width() * size.height()) as usize];
    for tile in 0..prepared.tiles() {
        prepared.blended(tile, &buffers, &mut |_, x, y| {
            count[(y * size.width() + x) as usize] += 1;
        });
    }
    count
}

/// Calls `visit` with each visible fragment: triangle in its draw, x, y, fragment.
pub(crate) fn fragments(
    prepared: &BinnedDraws<'_>,
    mut visit: impl FnMut(u32, u32, u32, &Fragment),
) {
    let mut buffers = VisibilityBuffer::new();
    let mut fragment = Fragment::default();
    for index in 0..prepared.tiles() {
        let tile = prepared.tile(index);
        prepared.visible(index, &NoAlphaTest, &mut buffers);
        for y in 0..tile.height {
            for x in 0..tile.width {
                let id = buffers.id[(y * TILE + x) as usize];
                if id != NO_PRIMITIVE {
                    prepared.evaluate(id, tile.x0 + x, tile.y0 + y, &mut fragment);
                    visit(prepared.source(id).1, tile.x0 + x, tile.y0 + y, &fragment);
                }
            }
        }
    }
}

/// A small generator with fixed output everywhere (PCG32 of O'Neill 2014).
#[derive(Debug, Clone)]
pub(crate) struct Rng(u64);

impl Rng {
    pub(crate) fn new(seed: u64) -> Self {
        let mut rng = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x853C_49E6_748F_EA9B);
        rng.bits();
        rng
    }

    pub(crate) fn bits(&mut self) -> u32 {
        let old = self.0;
        self.0 = old
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let shifted = (((old >> 18) ^ old) >> 27) as u32;
        shifted.rotate_right((old >> 59) as u32)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        f64::from(self.bits()) / 4_294_967_296.0
    }

    pub(crate) fn range(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// Log-uniform.
    pub(crate) fn log_range(&mut self, lo: f64, hi: f64) -> f64 {
        texmap_math::deterministic_f64::exp(self.range(
            texmap_math::deterministic_f64::ln(lo),
            texmap_math::deterministic_f64::ln(hi),
        ))
    }
}

/// A grid of n x n cells over [-1, 1]^2 whose inner vertices are moved by up to 0.2 of a cell (every cell stays convex), with random diagonals and
/// random first corners. Positions are (x, y, 0.5).
pub(crate) fn jittered_grid(rng: &mut Rng, n: u32) -> Owned {
    let mut mesh = Owned::default();
    for j in 0..=n {
        for i in 0..=n {
            let mut at = |k: u32| {
                let inner = i > 0 && i < n && j > 0 && j < n;
                let shift = if inner { rng.range(-0.2, 0.2) } else { 0.0 };
                (2.0 * (f64::from(k) + shift) / f64::from(n) - 1.0) as f32
            };
            mesh.positions.push([at(i), at(j), 0.5]);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            let pair = if rng.bits() & 1 == 0 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            for mut t in pair {
                t.rotate_left(rng.bits() as usize % 3);
                mesh.indices.push(t);
            }
        }
    }
    mesh
}

pub(crate) fn size(width: u32, height: u32) -> TargetSize {
    TargetSize::new(width, height).expect("valid size")
}
