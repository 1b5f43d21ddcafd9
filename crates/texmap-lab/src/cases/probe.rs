//! Short ways through the rasterizer's public API for the cases.

use texmap_math::glam::{DMat4, DVec4};
use texmap_raster::{
    BinnedDraws, DepthTest, DrawCall, Fragment, NO_PRIMITIVE, NoAlphaTest, Pass, TILE, TargetSize,
    VisibilityBuffer,
};

use crate::LabError;

/// Triangles whose positions are given in pixels of a target, with an own w for each vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Mesh {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) indices: Vec<[u32; 3]>,
    /// One value per vertex, or none.
    pub(super) values: Vec<f32>,
}

impl Mesh {
    pub(super) fn draw(&self) -> DrawCall<'_> {
        DrawCall {
            positions: &self.positions,
            indices: &self.indices,
            clip_from_object: clip_from_xyw(),
            attributes: &self.values,
            attribute_count: usize::from(!self.values.is_empty()),
            depth_test: DepthTest::Always,
            ..DrawCall::default()
        }
    }
}

/// Takes a position (x, y, w) to the clip position (x, y, 0, w): depth 0, at infinity.
pub(super) fn clip_from_xyw() -> DMat4 {
    DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::W, DVec4::ZERO)
}

/// The position (x, y, w) before division of a point given in pixels.
pub(super) fn vertex(size: (u32, u32), x: f64, y: f64, w: f64) -> [f32; 3] {
    let ndc_x = 2.0 * x / f64::from(size.0) - 1.0;
    let ndc_y = 1.0 - 2.0 * y / f64::from(size.1);
    [(ndc_x * w) as f32, (ndc_y * w) as f32, w as f32]
}

/// The pixel position (x, y) and w of a vertex as the rasterizer receives it.
pub(super) fn place(size: (u32, u32), vertex: [f32; 3]) -> [f64; 3] {
    let [x, y, w] = vertex.map(f64::from);
    [
        (x / w + 1.0) * 0.5 * f64::from(size.0),
        (1.0 - y / w) * 0.5 * f64::from(size.1),
        w,
    ]
}

/// Number of times that each pixel of the target is covered.
pub(super) fn coverage(size: (u32, u32), draw: DrawCall<'_>) -> Result<Vec<u32>, LabError> {
    let target = TargetSize::new(size.0, size.1)?;
    let prepared = BinnedDraws::new(
        target,
        &[DrawCall {
            pass: Pass::Blended,
            ..draw
        }],
    )?;
    let mut counts = vec![0; size.0 as usize * size.1 as usize];
    let mut buffers = VisibilityBuffer::new();
    for tile in 0..prepared.tiles() {
        prepared.visible(tile, &NoAlphaTest, &mut buffers);
        prepared.blended(tile, &buffers, &mut |_, x, y| {
            counts[(y * size.0 + x) as usize] += 1;
        });
    }
    Ok(counts)
}

/// Calls `see` with every visible fragment and its pixel.
pub(crate) fn visit(
    size: (u32, u32),
    draws: &[DrawCall<'_>],
    mut see: impl FnMut(u32, u32, &Fragment),
) -> Result<(), LabError> {
    let prepared = BinnedDraws::new(TargetSize::new(size.0, size.1)?, draws)?;
    let (mut buffers, mut fragment) = (VisibilityBuffer::new(), Fragment::default());
    for index in 0..prepared.tiles() {
        prepared.visible(index, &NoAlphaTest, &mut buffers);
        let tile = prepared.tile(index);
        for (cell, &id) in buffers
            .id
            .iter()
            .enumerate()
            .filter(|&(_, &id)| id != NO_PRIMITIVE)
        {
            let (x, y) = (tile.x0 + cell as u32 % TILE, tile.y0 + cell as u32 / TILE);
            prepared.evaluate(id, x, y, &mut fragment);
            see(x, y, &fragment);
        }
    }
    Ok(())
}

/// Coordinates at which a look-up must give a colour all the same.
pub(crate) const SENSELESS: [f32; 6] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    1e30,
    -1e30,
    f32::MAX,
];

/// Pixels hit more than once, and not at all.
pub(super) fn double_and_missing(counts: &[u32]) -> (f64, f64) {
    let double = counts.iter().filter(|&&n| n > 1).count();
    let missing = counts.iter().filter(|&&n| n == 0).count();
    (double as f64, missing as f64)
}

/// Random numbers of a case, the same everywhere (SplitMix64, Steele, Lea and Flood 2014).
#[derive(Debug)]
pub struct Random(pub u64);

impl Random {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `from..to`.
    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
}
