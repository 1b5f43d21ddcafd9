//! From a triangle to what a pixel needs: planes about the centre of a 64x64 tile, hulls, and the way to evaluate them.
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::coverage::edge::Edge;
use crate::coverage::stamp::{BLOCK_PIXELS, block_lanes};
use crate::front_end::clip::Hom;
use crate::setup::planes::{
    COEFFICIENTS, Perspective, Plane, RowPlane, Solver, hull, is_moderate, plane_at, w_is_even,
};
use crate::visibility::visible::UvBlock;
use crate::{Interp, MAX_ATTRIBUTES};

mod depth;
pub(crate) mod group;
pub(crate) mod plane_table;
pub(crate) mod planes;
mod rows;
mod wide;

pub(crate) use depth::{Depth, DepthPlane, DepthRow, depth_offset};
pub(crate) use rows::RowNodes;
use rows::{Rows, rows};
pub(crate) use wide::WidePixels;
use wide::bound;

/// Side of a tile in pixels, whatever the target's size. Planes are anchored at tile centres, so this decides bits.
pub const TILE: u32 = 64;

/// Half a tile: how far a pixel can be from the anchor.
pub(crate) const REACH: f64 = TILE as f64 / 2.0;

/// Between these sizes f32 planes neither overflow nor underflow where it matters.
pub(crate) const LARGEST: f64 = (1u64 << 60) as f64;
pub(crate) const SMALLEST: f64 = 1.0 / (1u64 << 60) as f64;

/// Largest to smallest 1/w over a tile up to which f32 planes keep 0.01 texel of 1024.
pub(crate) const W_RATIO: f64 = 2.0;

/// The same for depth: up to it depth keeps 20 bits, relative to its value.
pub(crate) const DEPTH_RATIO: f64 = 8.0;

/// A polygon offset that moves any depth beyond the far plane.
pub(crate) const LEAVES_NOTHING: f32 = 2.0;

/// Values of a fragment: attributes, derivatives, depth and side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// Attribute values, within the hull of the triangle's vertex values.
    pub values: [f32; MAX_ATTRIBUTES],
    /// Change of each value per pixel to the right.
    pub ddx: [f32; MAX_ATTRIBUTES],
    /// Change of each value per pixel down.
    pub ddy: [f32; MAX_ATTRIBUTES],
    /// 1 / clip w.
    pub inv_w: f32,
    /// Reversed depth: 1 at the near plane, 0 at the far plane.
    pub depth: f32,
    /// True if the triangle's front (counter-clockwise) side is seen.
    pub front: bool,
    /// Number of valid attributes; the rest are 0.
    pub count: usize,
    /// The pixel, from the left and from the top, for stages that compute values of their own per pixel.
    pub pixel: [u32; 2],
}

impl Default for Fragment {
    fn default() -> Self {
        Self {
            values: [0.0; MAX_ATTRIBUTES],
            ddx: [0.0; MAX_ATTRIBUTES],
            ddy: [0.0; MAX_ATTRIBUTES],
            inv_w: 0.0,
            depth: 0.0,
            front: true,
            count: 0,
            pixel: [0; 2],
        }
    }
}

impl Fragment {
    fn set(&mut self, k: usize, [value, ddx, ddy]: [f32; 3]) {
        (self.values[k], self.ddx[k], self.ddy[k]) = (value, ddx, ddy);
    }
}

/// A triangle as the front end left it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shape<'a> {
    /// The vertices whose planes carry the perspective attributes; some may lie behind the eye.
    pub outer: [Hom; 3],
    /// The corners of the piece that is drawn: in front of the eye, in the fixed-point range.
    pub piece: [Hom; 3],
    /// Weights of each corner of the piece over the triangle's vertices. `None` where the piece is the triangle.
    pub weights: Option<[[f64; 3]; 3]>,
    /// Attributes of the triangle's three vertices.
    pub attributes: [&'a [f32]; 3],
    /// Bit k: attribute k is linear on the screen.
    pub screen_linear: u32,
    pub front: bool,
    /// The piece's edges, and the target's width, for the interpolations that work along rows.
    pub edges: [Edge; 3],
    pub width: i32,
    pub interp: Interp,
    pub interp_scale: f32,
    /// Of the draw.
    pub depth_slope: f32,
}

fn solve(solver: &Solver<Scalar>, v: [f64; 3], middle: f64) -> Plane {
    // A triangle whose snapped form has area while its own has none gets constant planes.
    let plane = solver.plane(v);
    if solver.solvable && plane.iter().all(|c| c.is_finite()) {
        plane
    } else {
        [0.0, 0.0, middle]
    }
}

fn mean(v: [f64; 3]) -> f64 {
    v[0] / 3.0 + v[1] / 3.0 + v[2] / 3.0
}

/// The middle of a tile in pixels.
pub(crate) fn origin(tile_x: u32, tile_y: u32) -> [i32; 2] {
    [tile_x, tile_y].map(|t| (t * TILE + TILE / 2) as i32)
}

/// A triangle set up for one tile.
#[derive(Debug, Clone, Copy)]
pub struct TriangleSetup {
    /// Tile centre in pixels.
    origin: [i32; 2],
    depth: DepthPlane,
    w: Ranged,
    attributes: [Ranged; MAX_ATTRIBUTES],
    count: usize,
    screen_linear: u32,
    front: bool,
    /// f32 planes would lose digits here (the horizon in the tile, extreme values): evaluate in f64.
    wide: bool,
    rows: Rows,
}

/// A plane and the hull its values are clamped to.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Ranged {
    pub plane: Plane,
    /// The plane's coefficients rounded to f32.
    pub near: [f32; 3],
    pub lo: f32,
    pub hi: f32,
}

impl Ranged {
    fn new(plane: Plane, vertices: [f32; 3]) -> Self {
        let [lo, hi] = hull(Scalar, vertices);
        Self {
            plane,
            near: plane.map(|c| c as f32),
            lo,
            hi,
        }
    }

    /// Takes `by` off all values.
    fn lower(&mut self, by: f32) {
        self.plane[2] -= f64::from(by);
        self.near[2] -= by;
        self.lo -= by;
        self.hi -= by;
    }

    #[inline(always)]
    pub(crate) fn coefficients<I: Isa>(&self, i: I) -> [I::F32; COEFFICIENTS] {
        let [a, b, c] = self.near;
        [i.f32(a), i.f32(b), i.f32(c), i.f32(self.lo), i.f32(self.hi)]
    }

    /// Clamps values in f64.
    #[inline(always)]
    pub(crate) fn clamp<I: Isa>(&self, i: I, v: I::F64) -> I::F64 {
        bound(v, i.f64(f64::from(self.lo)), i.f64(f64::from(self.hi)))
    }

    /// The value at a point on the screen, not divided.
    #[inline(always)]
    pub(crate) fn at<I: Isa>(&self, i: I, x: I::F64, y: I::F64) -> I::F64 {
        plane_at(i, self.plane, x, y)
    }
}

impl TriangleSetup {
    /// `tile_x`, `tile_y`: the tile's coordinates in the grid of [`TILE`].
    pub(crate) fn new(shape: &Shape<'_>, tile_x: u32, tile_y: u32) -> Self {
        let origin = origin(tile_x, tile_y);
        let [ox, oy] = origin.map(f64::from);
        let flat = shape.piece.map(|p| Hom {
            x: p.x / p.w,
            y: p.y / p.w,
            z: p.z / p.w,
            w: 1.0,
        });
        let outer = Solver::new(Scalar, &shape.outer, [ox, oy]);
        let screen = Solver::new(Scalar, &flat, [ox, oy]);

        let inv_w = shape.piece.map(|p| 1.0 / p.w);
        let middle_w = mean(inv_w);
        let w = Ranged::new(solve(&outer, [1.0; 3], middle_w), inv_w.map(|v| v as f32));
        let count = shape.attributes[0].len().min(MAX_ATTRIBUTES);
        let mut attributes = [Ranged::default(); MAX_ATTRIBUTES];
        for (k, slot) in attributes.iter_mut().enumerate().take(count) {
            let vertex = [0, 1, 2].map(|i| shape.attributes[i][k]);
            let value = vertex.map(f64::from);
            *slot = if shape.screen_linear >> k & 1 == 1 {
                let corner = match &shape.weights {
                    Some(rows) => rows.map(|r| r[0] * value[0] + r[1] * value[1] + r[2] * value[2]),
                    None => value,
                };
                Ranged::new(solve(&screen, corner, mean(corner)), vertex)
            } else {
                Ranged::new(solve(&outer, value, mean(value) * middle_w), vertex)
            };
        }
        let mut setup = Self {
            origin,
            depth: DepthPlane::new(shape, &outer),
            w,
            attributes,
            count,
            screen_linear: shape.screen_linear,
            front: shape.front,
            wide: false,
            rows: rows(shape),
        };
        setup.wide = setup.needs_f64();
        setup
    }

    /// True if f32 planes about the tile's centre are too coarse. Decided from the triangle and its fixed tile alone.
    fn needs_f64(&self) -> bool {
        let moderate = |r: &Ranged| is_moderate(Scalar, r.plane, [r.lo, r.hi]);
        !w_is_even(Scalar, self.w.plane, f64::from(self.w.lo))
            || !moderate(&self.w)
            || !self.attributes[..self.count].iter().all(moderate)
    }

    /// Lets values leave the triangle's by what they can change within half a pixel.
    pub(crate) fn widen(&mut self) {
        let slope = |r: &Ranged| r.near[0].abs() + r.near[1].abs();
        let w = &mut self.w;
        let w_slope = slope(w);
        widen_w(w_slope, &mut w.lo, &mut w.hi);
        let w_lo = self.w.lo;
        for (k, r) in self.attributes[..self.count].iter_mut().enumerate() {
            let (change, w) = if self.screen_linear >> k & 1 == 1 {
                (0.0, 1.0)
            } else {
                (w_slope, w_lo)
            };
            widen_attribute(slope(r), change, w, &mut r.lo, &mut r.hi);
        }
    }

    /// True if a pixel needs more than f32 planes and one divide at most.
    pub(crate) fn is_odd(&self) -> bool {
        self.wide || self.uses_rows()
    }

    /// Exact at nodes of each row only.
    pub(crate) fn uses_rows(&self) -> bool {
        matches!(self.rows, Rows::Nodes { .. })
    }

    /// The planes of 1/w and of the attributes.
    pub(crate) fn planes(&self) -> (&Ranged, &[Ranged]) {
        (&self.w, &self.attributes[..self.count])
    }

    /// Depth at a pixel's centre.
    #[must_use]
    pub fn depth(&self, x: u32, y: u32) -> f32 {
        let (px, py) = self.local(x, y);
        self.depth.at(px, py)
    }

    /// Everything at a pixel's centre.
    pub fn evaluate(&self, x: u32, y: u32, out: &mut Fragment) {
        self.evaluate_on(self.row_nodes(y).as_mut(), x, y, out);
    }

    /// [`evaluate`](Self::evaluate) with the nodes of its row.
    pub(crate) fn evaluate_on(
        &self,
        row: Option<&mut RowNodes>,
        x: u32,
        y: u32,
        out: &mut Fragment,
    ) {
        out.depth = self.depth(x, y);
        out.front = self.front;
        out.count = self.count;
        out.pixel = [x, y];
        let (px, py) = self.local(x, y);
        if let Some(row) = row {
            self.at_f64(f64::from(px), f64::from(py), out);
            self.between_nodes(row, x, |k, value, ddx| {
                (out.values[k], out.ddx[k]) = (value, ddx);
            });
        } else if self.wide {
            self.at_f64(f64::from(px), f64::from(py), out);
        } else {
            self.at_f32(px, py, out);
        }
    }

    /// The first two attributes of the 4x4 pixels from (x, y) on, as [`evaluate`](Self::evaluate) finds them. `None` if f32
    /// planes do not serve, or there are fewer attributes.
    #[inline(always)]
    pub(crate) fn uv_block<I: Isa>(&self, i: I, x: u32, y: u32) -> Option<UvBlock> {
        if self.is_odd() || self.count < 2 {
            return None;
        }
        let (px, py) = self.local(x, y);
        let mut out = UvBlock::default();
        for at in (0..BLOCK_PIXELS).step_by(I::LANES) {
            let [dx, dy] = block_lanes(i, at);
            let (px, py) = (dx.to_f32() + px, dy.to_f32() + py);
            let w = RowPlane::new(self.w.coefficients(i), py);
            let pixels = Perspective::new(i, &w, None, px);
            for (k, plane) in self.attributes[..2].iter().enumerate() {
                let plane = RowPlane::new(plane.coefficients(i), py);
                let [u, dx, dy] = if self.is_linear(k) {
                    plane.linear(px)
                } else {
                    pixels.attribute::<true>(&plane)
                };
                u.store(&mut out.value[k][at..]);
                dx.store(&mut out.ddx[k][at..]);
                dy.store(&mut out.ddy[k][at..]);
            }
        }
        Some(out)
    }

    /// The pixel's centre from the origin; exact.
    fn local(&self, x: u32, y: u32) -> (f32, f32) {
        (
            (x as i32 - self.origin[0]) as f32 + 0.5,
            (y as i32 - self.origin[1]) as f32 + 0.5,
        )
    }

    fn is_linear(&self, k: usize) -> bool {
        self.screen_linear >> k & 1 == 1
    }

    fn at_f32(&self, px: f32, py: f32, out: &mut Fragment) {
        let w = RowPlane::new(self.w.coefficients(Scalar), py);
        let pixel = Perspective::new(Scalar, &w, None, px);
        out.inv_w = pixel.inv_w;
        for (k, plane) in self.attributes[..self.count].iter().enumerate() {
            let plane = RowPlane::new(plane.coefficients(Scalar), py);
            out.set(
                k,
                if self.is_linear(k) {
                    plane.linear(px)
                } else {
                    pixel.attribute::<true>(&plane)
                },
            );
        }
    }

    fn at_f64(&self, px: f64, py: f64, out: &mut Fragment) {
        let pixel = WidePixels::new(Scalar, self, [px, py]);
        out.inv_w = pixel.inv_w();
        for k in 0..self.count {
            if let Some(values) = pixel.attribute::<true>(k) {
                out.set(k, values);
            }
        }
    }
}

/// The hull of 1/w for centres up to half a pixel in x and y outside the triangle; it stays above zero.
#[inline(always)]
pub(crate) fn widen_w(slope: f32, lo: &mut f32, hi: &mut f32) {
    let reach = 0.5 * slope;
    let (half, low) = (0.5 * *lo, *lo - reach);
    *lo = if low > half { low } else { half };
    *hi += reach;
}

/// As [`widen_w`] for an attribute u = U/w: du/dx = (U_x - u w_x) / w.
#[inline(always)]
pub(crate) fn widen_attribute(slope: f32, w_slope: f32, w_lo: f32, lo: &mut f32, hi: &mut f32) {
    let (a, b) = (lo.abs(), hi.abs());
    let size = if a > b { a } else { b };
    let reach = 0.5 * (slope + size * w_slope) / w_lo;
    *lo -= reach;
    *hi += reach;
}
