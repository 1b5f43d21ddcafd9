//! Sixteen triangles of one draw set up for one tile: edges in i32, depth planes, pixel boxes.
use texmap_math::fearless_simd::{Simd, f32x16, f64x8, i32x16, mask32x16, mask64x8, prelude::*};
use texmap_math::lanes::{LANES, above, below};

use crate::Prepared;
use crate::arrays::Arrays;
use crate::edge::Edge;
use crate::planes::{Plane, Solver};
use crate::setup::{DEPTH_RATIO, DepthPlane, LEAVES_NOTHING, REACH, TILE, origin};
use crate::vertex::{SPECIAL, Transform};

/// A snapped extent below this keeps i32 edge set-up exact.
const SMALL: i32 = 1 << 15;

/// Edges and depth of up to sixteen triangles; x and y count from the tile's corner.
#[derive(Debug, Clone, Default)]
pub(crate) struct Group {
    /// `q + b y + a x >= 0` inside, at pixel centres.
    pub a: [[i32; LANES]; 3],
    pub b: [[i32; LANES]; 3],
    pub q: [[i32; LANES]; 3],
    pub x0: [i32; LANES],
    pub y0: [i32; LANES],
    pub x1: [i32; LANES],
    pub y1: [i32; LANES],
    /// The depth plane about the tile's centre, a, b, c, and its hull.
    pub z: [[f32; LANES]; 3],
    pub z_lo: [f32; LANES],
    pub z_hi: [f32; LANES],
    /// Bit per lane: may cover pixels; depth in f64; boxes of at most 2x2 pixels, of at most 4x4.
    pub live: u32,
    pub wide: u32,
    pub tiny: u32,
    pub small: u32,
    /// The f64 planes of wide lanes.
    pub z_wide: [Plane; LANES],
    /// Where the samples lie from the pixels' centres, in 1/256 pixel.
    pub offset: [i32; 2],
}

impl Group {
    /// Whether a live lane covers every pixel of a tile of full size.
    #[inline(always)]
    pub(crate) fn covers_tile(&self, lane: usize) -> bool {
        let last = TILE as i32 - 1;
        let spans = self.x0[lane] <= 0 && self.y0[lane] <= 0;
        spans
            && self.x1[lane] >= last
            && self.y1[lane] >= last
            && (0..3).all(|k| {
                let (a, b) = (self.a[k][lane], self.b[k][lane]);
                self.q[k][lane] + (a.min(0) + b.min(0)) * last >= 0
            })
    }
}

/// What the samples of a pixel share of a [`Group`]: all that does not depend on where they lie.
#[derive(Debug, Clone, Default)]
pub(crate) struct Known {
    /// Snapped x and y of the three vertices.
    v: [[i32; LANES]; 6],
    z: [[f32; LANES]; 3],
    z_lo: [f32; LANES],
    z_hi: [f32; LANES],
    /// Lanes that are not whole, small triangles with even depth.
    care: u32,
}

/// What becomes of a group's [`Known`].
#[derive(Debug)]
pub(crate) enum Sharing<'k> {
    Nothing,
    Keep(&'k mut Known),
    Use(&'k Known),
}

/// What sixteen ids of a draw stand for: the corners of whole triangles, and which lanes need a look of their own.
#[derive(Debug)]
pub(crate) struct Ids {
    /// Triangle in the draw; 0 for pieces.
    pub triangle: [i32; LANES],
    /// Pieces.
    pub pieces: u32,
}

impl Ids {
    pub(crate) fn new(ids: &[u32], first: u32, whole: u32) -> Self {
        let mut out = Self {
            triangle: [0; LANES],
            pieces: 0,
        };
        for (lane, &id) in ids.iter().take(LANES).enumerate() {
            if id >= whole {
                out.pieces |= 1 << lane;
            } else {
                out.triangle[lane] = (id - first) as i32;
            }
        }
        out
    }
}

impl Ids {
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, s: S) -> i32x16<S> {
        i32x16::from_slice(s, &self.triangle)
    }
}

/// [`Solver`] for eight triangles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SolverX8<S: Simd> {
    rows: [[f64x8<S>; 3]; 3],
    inverse: f64x8<S>,
    /// Lanes with area.
    pub solvable: mask64x8<S>,
    /// z and w of the three vertices.
    pub z: [f64x8<S>; 3],
    pub w: [f64x8<S>; 3],
}

/// Solvers of sixteen triangles with the given vertices: lanes 0 to 7, then 8 to 15; `FLAT` for planes that are linear on the screen.
/// Out of line: compiled once a level.
#[inline(never)]
pub(crate) fn solve_x16<S: Simd, const FLAT: bool>(
    s: S,
    arrays: &Arrays<'_>,
    vertex: &[i32x16<S>; 3],
    transform: &Transform,
    origin: [f64; 2],
) -> [SolverX8<S>; 2] {
    s.vectorize(
        #[inline(always)]
        || {
            let [ox, oy] = origin;
            let at = [
                arrays.positions(s, vertex[0]),
                arrays.positions(s, vertex[1]),
                arrays.positions(s, vertex[2]),
            ];
            let [[a, d], [b, e], [c, f]] = at;
            [
                SolverX8::new::<FLAT>(s, transform, [a, b, c], ox, oy),
                SolverX8::new::<FLAT>(s, transform, [d, e, f], ox, oy),
            ]
        },
    )
}

impl<S: Simd> SolverX8<S> {
    /// With `FLAT` of the corners on the screen, all at w = 1.
    #[inline(always)]
    fn new<const FLAT: bool>(
        s: S,
        transform: &Transform,
        corners: [[f64x8<S>; 3]; 3],
        ox: f64,
        oy: f64,
    ) -> Self {
        let mut v = [
            transform.apply_x8(s, corners[0]),
            transform.apply_x8(s, corners[1]),
            transform.apply_x8(s, corners[2]),
        ];
        if FLAT {
            for [x, y, z, w] in &mut v {
                (*x, *y, *z) = (*x / *w, *y / *w, *z / *w);
                *w = f64x8::splat(s, 1.0);
            }
        }
        let [v0, v1, v2] = v;
        let (ox, oy) = (f64x8::splat(s, ox), f64x8::splat(s, oy));
        let p0 = [v0[0] - ox * v0[3], v0[1] - oy * v0[3], v0[3]];
        let p1 = [v1[0] - ox * v1[3], v1[1] - oy * v1[3], v1[3]];
        let p2 = [v2[0] - ox * v2[3], v2[1] - oy * v2[3], v2[3]];
        let rows = [cross(p1, p2), cross(p2, p0), cross(p0, p1)];
        let determinant = p0[0] * rows[0][0] + p0[1] * rows[0][1] + p0[2] * rows[0][2];
        let zero = determinant.simd_eq(0.0);
        let inverse = f64x8::splat(s, 1.0) / zero.select(f64x8::splat(s, 1.0), determinant);
        let solvable = !zero & inverse.abs().simd_le(f64::MAX);
        Self {
            rows,
            inverse,
            solvable,
            z: [v0[2], v1[2], v2[2]],
            w: [v0[3], v1[3], v2[3]],
        }
    }

    #[inline(always)]
    pub(crate) fn plane(&self, v: [f64x8<S>; 3]) -> [f64x8<S>; 3] {
        let r = &self.rows;
        [
            (v[0] * r[0][0] + v[1] * r[1][0] + v[2] * r[2][0]) * self.inverse,
            (v[0] * r[0][1] + v[1] * r[1][1] + v[2] * r[2][1]) * self.inverse,
            (v[0] * r[0][2] + v[1] * r[1][2] + v[2] * r[2][2]) * self.inverse,
        ]
    }
}

#[inline(always)]
fn cross<S: Simd>(a: [f64x8<S>; 3], b: [f64x8<S>; 3]) -> [f64x8<S>; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Largest absolute and smallest value of planes over a tile.
#[inline(always)]
pub(crate) fn extent_x8<S: Simd>(plane: [f64x8<S>; 3]) -> (f64x8<S>, f64x8<S>) {
    let slope = (plane[0].abs() + plane[1].abs()) * REACH;
    (plane[2].abs() + slope, plane[2] - slope)
}

/// Where f32 depth planes will do: as [`DepthPlane`] decides.
#[inline(always)]
fn is_even<S: Simd>(plane: [f64x8<S>; 3], lo: f64x8<S>) -> mask64x8<S> {
    let (largest, smallest) = extent_x8(plane);
    let lowest = smallest.simd_gt(lo).select(smallest, lo);
    largest.simd_le(1.0) & largest.simd_le(lowest * DEPTH_RATIO)
}

/// Least and largest of three, by compare and select.
#[inline(always)]
pub(crate) fn hull_x16<S: Simd>(v: [f32x16<S>; 3]) -> (f32x16<S>, f32x16<S>) {
    (
        below(v[2], below(v[1], v[0])),
        above(v[2], above(v[1], v[0])),
    )
}

impl Prepared<'_> {
    /// Sets up the triangles of `ids`, which all belong to draw `draw`, for a tile.
    #[inline(always)]
    pub(crate) fn setup_group<S: Simd>(
        &self,
        s: S,
        draw: usize,
        ids: &[u32],
        tile: u32,
        sharing: Sharing<'_>,
        group: &mut Group,
    ) {
        let bounds = self.tile(tile as usize);
        let count = ids.len().min(LANES);
        let exists = (1u32 << count) - 1;
        let mut care = exists;
        group.live = exists;
        group.wide = 0;
        if let Some(arrays) = self.arrays(draw) {
            let named = Ids::new(ids, self.first(draw), self.whole());
            // Pieces of cut triangles, which are large, are often among themselves.
            if named.pieces & exists != exists {
                care = named.pieces
                    | self.setup_whole(
                        s,
                        &arrays,
                        draw,
                        &named,
                        [bounds.x0, bounds.y0],
                        sharing,
                        group,
                    );
            }
            care &= exists;
        }
        while care != 0 {
            let lane = care.trailing_zeros() as usize;
            care &= care - 1;
            self.setup_lane(ids[lane], [bounds.x0, bounds.y0], lane, group);
        }
        self.clip_boxes(s, [bounds.width, bounds.height], group);
    }

    /// Lanes that are whole, small triangles; returns those that are not. Out of line: compiled once a level.
    #[inline(never)]
    fn setup_whole<S: Simd>(
        &self,
        s: S,
        arrays: &Arrays<'_>,
        draw: usize,
        ids: &Ids,
        corner: [u32; 2],
        sharing: Sharing<'_>,
        group: &mut Group,
    ) -> u32 {
        s.vectorize(
            #[inline(always)]
            || self.setup_lanes(s, arrays, draw, ids, corner, sharing, group),
        )
    }

    #[inline(always)]
    fn setup_lanes<S: Simd>(
        &self,
        s: S,
        arrays: &Arrays<'_>,
        draw: usize,
        ids: &Ids,
        corner: [u32; 2],
        sharing: Sharing<'_>,
        group: &mut Group,
    ) -> u32 {
        let vertex = match &sharing {
            Sharing::Use(_) => [i32x16::splat(s, 0); 3],
            _ => arrays.corners(s, ids.lanes(s)),
        };
        let whole = match &sharing {
            Sharing::Use(known) => {
                let v = &known.v;
                [
                    [i32x16::from_slice(s, &v[0]), i32x16::from_slice(s, &v[1])],
                    [i32x16::from_slice(s, &v[2]), i32x16::from_slice(s, &v[3])],
                    [i32x16::from_slice(s, &v[4]), i32x16::from_slice(s, &v[5])],
                ]
            }
            _ => [
                arrays.snapped(s, vertex[0]),
                arrays.snapped(s, vertex[1]),
                arrays.snapped(s, vertex[2]),
            ],
        };
        let special = whole[0][0].simd_eq(SPECIAL[0])
            | whole[1][0].simd_eq(SPECIAL[0])
            | whole[2][0].simd_eq(SPECIAL[0]);
        let mut v = whole;
        for p in &mut v {
            *p = [p[0] - group.offset[0], p[1] - group.offset[1]];
        }
        let (lo_x, hi_x) = (
            v[0][0].min(v[1][0]).min(v[2][0]),
            v[0][0].max(v[1][0]).max(v[2][0]),
        );
        let (lo_y, hi_y) = (
            v[0][1].min(v[1][1]).min(v[2][1]),
            v[0][1].max(v[1][1]).max(v[2][1]),
        );
        let large = (hi_x - lo_x).simd_ge(SMALL) | (hi_y - lo_y).simd_ge(SMALL);
        let [cx, cy] = corner.map(|c| c as i32);
        (((lo_x + 127) >> 8) - cx).store_slice(&mut group.x0);
        (((lo_y + 127) >> 8) - cy).store_slice(&mut group.y0);
        (((hi_x - 128) >> 8) - cx).store_slice(&mut group.x1);
        (((hi_y - 128) >> 8) - cy).store_slice(&mut group.y1);

        let area =
            (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[2][0] - v[0][0]) * (v[1][1] - v[0][1]);
        let front = area.simd_lt(0);
        let second = [
            front.select(v[2][0], v[1][0]),
            front.select(v[2][1], v[1][1]),
        ];
        let third = [
            front.select(v[1][0], v[2][0]),
            front.select(v[1][1], v[2][1]),
        ];
        let (zero, one) = (i32x16::splat(s, 0), i32x16::splat(s, 1));
        let turn = [v[0], second, third];
        for k in 0..3 {
            let (p, q) = (turn[k], turn[(k + 1) % 3]);
            let (a, b) = (p[1] - q[1], q[0] - p[0]);
            let top_left = a.simd_gt(0) | (a.simd_eq(0) & b.simd_gt(0));
            let least = top_left.select(zero, one);
            // p = 256 whole + part; the value over 256, rounded down, decides the sign at every centre.
            let (wx, wy) = (p[0] >> 8, p[1] >> 8);
            let (fx, fy) = (p[0] & 255, p[1] & 255);
            let parts = (a * (128 - fx) + b * (128 - fy) - least) >> 8;
            let value = a * (cx - wx) + b * (cy - wy) + parts;
            a.store_slice(&mut group.a[k]);
            b.store_slice(&mut group.b[k]);
            value.store_slice(&mut group.q[k]);
        }

        if let Sharing::Use(known) = sharing {
            group.z = known.z;
            group.z_lo = known.z_lo;
            group.z_hi = known.z_hi;
            return known.care;
        }
        let odd = self.depth_planes(s, arrays, draw, &vertex, corner, group);
        // Wide lanes are few: they take the scalar way, which keeps their f64 planes.
        let care = (special | large).to_bitmask() as u32 | odd;
        if let Sharing::Keep(known) = sharing {
            for (to, from) in known.v.iter_mut().zip(whole.as_flattened()) {
                from.store_slice(to);
            }
            known.z = group.z;
            known.z_lo = group.z_lo;
            known.z_hi = group.z_hi;
            known.care = care;
        }
        care
    }

    /// Returns the lanes that f32 planes cannot serve.
    #[inline(always)]
    fn depth_planes<S: Simd>(
        &self,
        s: S,
        arrays: &Arrays<'_>,
        draw: usize,
        vertex: &[i32x16<S>; 3],
        corner: [u32; 2],
        group: &mut Group,
    ) -> u32 {
        let middle = origin(corner[0] / TILE, corner[1] / TILE).map(f64::from);
        let [low, high] = solve_x16::<S, false>(s, arrays, vertex, self.transform(draw), middle);
        let (low_plane, high_plane) = (low.plane(low.z), high.plane(high.z));
        let depth = [
            s.narrow_f64x8(low.z[0] / low.w[0], high.z[0] / high.w[0]),
            s.narrow_f64x8(low.z[1] / low.w[1], high.z[1] / high.w[1]),
            s.narrow_f64x8(low.z[2] / low.w[2], high.z[2] / high.w[2]),
        ];
        let (lo, hi) = hull_x16(depth);
        lo.store_slice(&mut group.z_lo);
        hi.store_slice(&mut group.z_hi);
        for (k, slot) in group.z.iter_mut().enumerate() {
            s.narrow_f64x8(low_plane[k], high_plane[k])
                .store_slice(slot);
        }
        let depth_slope = self.draw(draw as u32).depth_slope;
        if depth_slope != 0.0 {
            let [a, b, c] = [0, 1, 2].map(|k| f32x16::from_slice(s, &group.z[k]));
            let most = f32x16::splat(s, LEAVES_NOTHING);
            let away = below((a.abs() + b.abs()) * depth_slope, most);
            (c - away).store_slice(&mut group.z[2]);
            (lo - away).store_slice(&mut group.z_lo);
            (hi - away).store_slice(&mut group.z_hi);
        }
        let (low_lo, high_lo) = lo.widen();
        let even = is_even(low_plane, low_lo).to_bitmask()
            | is_even(high_plane, high_lo).to_bitmask() << 8;
        let solvable = low.solvable.to_bitmask() | high.solvable.to_bitmask() << 8;
        !(even & solvable) as u32
    }

    /// One lane, the plain way.
    #[inline(never)]
    fn setup_lane(&self, id: u32, corner: [u32; 2], lane: usize, group: &mut Group) {
        let (shape, pixels) = self.shape_at(id, group.offset);
        let Some(pixels) = pixels else {
            group.live &= !(1 << lane);
            return;
        };
        let [cx, cy] = corner.map(|c| c as i32);
        group.x0[lane] = pixels.x0 - cx;
        group.y0[lane] = pixels.y0 - cy;
        group.x1[lane] = pixels.x1 - cx;
        group.y1[lane] = pixels.y1 - cy;
        for (k, edge) in shape.edges.iter().enumerate() {
            let Some([a, b, q]) = local_edge(*edge, cx, cy) else {
                group.live &= !(1 << lane);
                return;
            };
            group.a[k][lane] = a;
            group.b[k][lane] = b;
            group.q[k][lane] = q;
        }
        let [ox, oy] = origin(corner[0] / TILE, corner[1] / TILE).map(f64::from);
        let depth = DepthPlane::new(&shape, Solver::new(&shape.outer, ox, oy).as_ref());
        for (k, slot) in group.z.iter_mut().enumerate() {
            slot[lane] = depth.z.near[k];
        }
        group.z_lo[lane] = depth.z.lo;
        group.z_hi[lane] = depth.z.hi;
        group.z_wide[lane] = depth.z.plane;
        if depth.wide {
            group.wide |= 1 << lane;
        }
    }

    /// Cuts the boxes to the tile and drops lanes that leave nothing.
    #[inline(always)]
    fn clip_boxes<S: Simd>(&self, s: S, side: [u32; 2], group: &mut Group) {
        let zero = i32x16::splat(s, 0);
        let x0 = i32x16::from_slice(s, &group.x0).max(zero);
        let y0 = i32x16::from_slice(s, &group.y0).max(zero);
        let x1 = i32x16::from_slice(s, &group.x1).min(i32x16::splat(s, side[0] as i32 - 1));
        let y1 = i32x16::from_slice(s, &group.y1).min(i32x16::splat(s, side[1] as i32 - 1));
        x0.store_slice(&mut group.x0);
        y0.store_slice(&mut group.y0);
        x1.store_slice(&mut group.x1);
        y1.store_slice(&mut group.y1);
        let some: mask32x16<S> = x0.simd_le(x1) & y0.simd_le(y1);
        let (across, down) = (x1 - x0, y1 - y0);
        let tiny = across.simd_lt(2) & down.simd_lt(2);
        let small = across.simd_lt(4) & down.simd_lt(4);
        group.live &= some.to_bitmask() as u32;
        let even = group.live & !group.wide;
        group.tiny = tiny.to_bitmask() as u32 & even;
        group.small = small.to_bitmask() as u32 & even;
    }
}

/// An edge over a tile's pixels, `a x + b y + q >= 0` in i32: exact, since an edge that crosses the tile stays in range there
/// and one that does not is all inside. `None` when no pixel of the tile is inside.
fn local_edge(edge: Edge, cx: i32, cy: i32) -> Option<[i32; 3]> {
    let value = edge.at_pixel(cx, cy) >> 8;
    let side = i64::from(TILE as i32 - 1);
    let lowest = value + side * (edge.a.min(0) + edge.b.min(0));
    let highest = value + side * (edge.a.max(0) + edge.b.max(0));
    if highest < 0 {
        None
    } else if lowest >= 0 {
        Some([0; 3])
    } else {
        Some([edge.a as i32, edge.b as i32, value as i32])
    }
}
