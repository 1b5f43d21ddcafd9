//! Up to sixteen triangles of one draw set up for one tile: edges in i32, depth planes, pixel boxes.
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::BinnedDraws;
use crate::coverage::edge::Edge;
use crate::front_end::arrays::Arrays;
use crate::front_end::clip::Hom;
use crate::front_end::transform::{SPECIAL, Transform};
use crate::setup::planes::{Plane, Solver, depth_is_even, hull};
use crate::setup::{DepthPlane, TILE, depth_offset, origin};

/// Most triangles of a group.
pub(crate) const GROUP: usize = 16;

/// A snapped extent below this keeps i32 edge set-up exact.
const SMALL: i32 = 1 << 15;

/// Edges and depth of up to sixteen triangles; x and y count from the tile's corner.
#[derive(Debug, Clone, Default)]
pub(crate) struct Group {
    /// `q + b y + a x >= 0` inside, at pixel centres.
    pub a: [[i32; GROUP]; 3],
    pub b: [[i32; GROUP]; 3],
    pub q: [[i32; GROUP]; 3],
    pub x0: [i32; GROUP],
    pub y0: [i32; GROUP],
    pub x1: [i32; GROUP],
    pub y1: [i32; GROUP],
    /// The depth plane about the tile's centre, a, b, c, and its hull.
    pub z: [[f32; GROUP]; 3],
    pub z_lo: [f32; GROUP],
    pub z_hi: [f32; GROUP],
    /// Bit per lane: may cover pixels; depth in f64; boxes of at most 2x2 pixels, of at most 4x4.
    pub live: u32,
    pub wide: u32,
    pub tiny: u32,
    pub small: u32,
    /// The f64 planes of wide lanes.
    pub z_wide: [Plane; GROUP],
    /// Offset of the samples from the pixels' centres, in 1/256 pixel.
    pub offset: [i32; 2],
}

impl Group {
    /// True if a live lane covers every pixel of a tile of full size.
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

/// Parts of a [`Group`] that the samples of a pixel share: all that does not depend on the position of the samples.
#[derive(Debug, Clone, Default)]
pub(crate) struct Known {
    /// Snapped x and y of the three vertices.
    v: [[i32; GROUP]; 6],
    z: [[f32; GROUP]; 3],
    z_lo: [f32; GROUP],
    z_hi: [f32; GROUP],
    /// Lanes that are not whole, small triangles with even depth.
    care: u32,
}

/// Use of a group's [`Known`] among the samples of a pixel.
#[derive(Debug)]
pub(crate) enum Sharing<'k> {
    Nothing,
    Keep(&'k mut Known),
    Use(&'k Known),
}

/// Triangles of sixteen ids of a draw, and a bit for each lane that is a piece of a cut triangle.
#[derive(Debug)]
pub(crate) struct Ids {
    /// Triangle in the draw; 0 for pieces.
    pub triangle: [i32; GROUP],
    /// Pieces.
    pub pieces: u32,
}

impl Ids {
    pub(crate) fn new(ids: &[u32], first: u32, whole: u32) -> Self {
        let mut out = Self {
            triangle: [0; GROUP],
            pieces: 0,
        };
        for (lane, &id) in ids.iter().take(GROUP).enumerate() {
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
    /// The triangles of the lanes from `at` on.
    #[inline(always)]
    pub(crate) fn lanes<I: Isa>(&self, i: I, at: usize) -> I::I32 {
        i.load_i32(&self.triangle[at..])
    }

    /// True if all lanes from `at` on are pieces.
    #[inline(always)]
    pub(crate) fn are_pieces<I: Isa>(&self, _: I, at: usize) -> bool {
        let lanes = (1 << I::LANES) - 1;
        self.pieces >> at & lanes == lanes
    }
}

/// A [`Solver`] with z and w of the three vertices.
#[derive(Clone, Copy)]
pub(crate) struct Solved<I: Isa> {
    pub(crate) solver: Solver<I>,
    pub(crate) z: [I::F64; 3],
    pub(crate) w: [I::F64; 3],
}

/// Solves triangles with the given vertices; with `FLAT` for planes that are linear on the screen, from corners at w = 1.
/// Out of line: compiled once a level.
#[inline(never)]
pub(crate) fn solve<I: Isa, const FLAT: bool>(
    i: I,
    arrays: &Arrays<'_>,
    vertex: &[I::I32; 3],
    transform: &Transform,
    origin: [f64; 2],
) -> Solved<I> {
    i.vectorize(
        #[inline(always)]
        || {
            let mut v = [
                arrays.vertex(i, transform, vertex[0]),
                arrays.vertex(i, transform, vertex[1]),
                arrays.vertex(i, transform, vertex[2]),
            ];
            if FLAT {
                for Hom { x, y, z, w } in &mut v {
                    (*x, *y, *z) = (*x / *w, *y / *w, *z / *w);
                    *w = i.f64(1.0);
                }
            }
            Solved {
                solver: Solver::new(i, &v, origin),
                z: [v[0].z, v[1].z, v[2].z],
                w: [v[0].w, v[1].w, v[2].w],
            }
        },
    )
}

impl BinnedDraws<'_> {
    /// Sets up the triangles of `ids`, which all belong to draw `draw`, for a tile.
    #[inline(always)]
    pub(crate) fn setup_group<I: Isa>(
        &self,
        i: I,
        draw: usize,
        ids: &[u32],
        tile: u32,
        sharing: Sharing<'_>,
        group: &mut Group,
    ) {
        let bounds = self.tile(tile as usize);
        let count = ids.len().min(GROUP);
        let exists = (1u32 << count) - 1;
        let mut care = exists;
        group.live = exists;
        group.wide = 0;
        if let Some(arrays) = self.arrays(draw) {
            let named = Ids::new(ids, self.first(draw), self.whole());
            // Pieces of cut triangles, which are large, are often among themselves.
            if named.pieces & exists != exists {
                let corner = [bounds.x0, bounds.y0];
                care = named.pieces
                    | self.setup_whole(i, &arrays, draw, (&named, count), corner, sharing, group);
            }
            care &= exists;
        }
        while care != 0 {
            let lane = care.trailing_zeros() as usize;
            care &= care - 1;
            self.setup_lane(ids[lane], [bounds.x0, bounds.y0], lane, group);
        }
        clip_boxes(i, [bounds.width, bounds.height], group);
    }

    /// Lanes that are whole, small triangles; returns those that are not. Out of line: compiled once a level.
    #[inline(never)]
    fn setup_whole<I: Isa>(
        &self,
        i: I,
        arrays: &Arrays<'_>,
        draw: usize,
        (ids, count): (&Ids, usize),
        corner: [u32; 2],
        mut sharing: Sharing<'_>,
        group: &mut Group,
    ) -> u32 {
        i.vectorize(
            #[inline(always)]
            || {
                let mut care = 0;
                for at in (0..count).step_by(I::LANES) {
                    if !ids.are_pieces(i, at) {
                        let vertex = match &sharing {
                            Sharing::Use(_) => [i.i32(0); 3],
                            _ => arrays.corners(i, ids.lanes(i, at)),
                        };
                        let sharing = &mut sharing;
                        care |=
                            self.setup_lanes(i, at, arrays, draw, &vertex, corner, sharing, group);
                    }
                }
                if let Sharing::Use(known) = sharing {
                    group.z = known.z;
                    group.z_lo = known.z_lo;
                    group.z_hi = known.z_hi;
                    return known.care;
                }
                if let Sharing::Keep(known) = sharing {
                    known.z = group.z;
                    known.z_lo = group.z_lo;
                    known.z_hi = group.z_hi;
                    known.care = care;
                }
                care
            },
        )
    }

    #[inline(always)]
    fn setup_lanes<I: Isa>(
        &self,
        i: I,
        at: usize,
        arrays: &Arrays<'_>,
        draw: usize,
        vertex: &[I::I32; 3],
        corner: [u32; 2],
        sharing: &mut Sharing<'_>,
        group: &mut Group,
    ) -> u32 {
        let whole = match sharing {
            Sharing::Use(known) => {
                let v = &known.v;
                [
                    [i.load_i32(&v[0][at..]), i.load_i32(&v[1][at..])],
                    [i.load_i32(&v[2][at..]), i.load_i32(&v[3][at..])],
                    [i.load_i32(&v[4][at..]), i.load_i32(&v[5][at..])],
                ]
            }
            _ => [
                arrays.snapped(i, vertex[0]),
                arrays.snapped(i, vertex[1]),
                arrays.snapped(i, vertex[2]),
            ],
        };
        let mut v = whole;
        for p in &mut v {
            *p = [p[0] - group.offset[0], p[1] - group.offset[1]];
        }
        let (lo_x, hi_x) = extremes(i, [v[0][0], v[1][0], v[2][0]]);
        let (lo_y, hi_y) = extremes(i, [v[0][1], v[1][1], v[2][1]]);
        let [cx, cy] = corner.map(|c| c as i32);
        (((lo_x + 127) >> 8) - cx).store(&mut group.x0[at..]);
        (((lo_y + 127) >> 8) - cy).store(&mut group.y0[at..]);
        (((hi_x - 128) >> 8) - cx).store(&mut group.x1[at..]);
        (((hi_y - 128) >> 8) - cy).store(&mut group.y1[at..]);

        let area = area_of(i, v);
        let edges = edges_of(i, v, area.simd_lt(0));
        for (k, [p, q]) in edges.iter().enumerate() {
            let (a, b) = (p[1] - q[1], q[0] - p[0]);
            let least = least_inside(i, a, b);
            // p = 256 whole + part; the value over 256, rounded down, decides the sign at every centre.
            let (wx, wy) = (p[0] >> 8, p[1] >> 8);
            let (fx, fy) = (p[0] & 255, p[1] & 255);
            let parts = (a * (i.i32(128) - fx) + b * (i.i32(128) - fy) - least) >> 8;
            let value = a * (i.i32(cx) - wx) + b * (i.i32(cy) - wy) + parts;
            a.store(&mut group.a[k][at..]);
            b.store(&mut group.b[k][at..]);
            value.store(&mut group.q[k][at..]);
        }

        match sharing {
            Sharing::Use(_) => return 0,
            Sharing::Keep(known) => {
                for (to, from) in known.v.iter_mut().zip(whole.as_flattened()) {
                    from.store(&mut to[at..]);
                }
            }
            Sharing::Nothing => {}
        }
        let special = whole[0][0].simd_eq(SPECIAL[0])
            | whole[1][0].simd_eq(SPECIAL[0])
            | whole[2][0].simd_eq(SPECIAL[0]);
        let large = (hi_x - lo_x).simd_ge(SMALL) | (hi_y - lo_y).simd_ge(SMALL);
        let odd = self.depth_planes(i, at, arrays, draw, vertex, corner, group);
        // Wide lanes are few: they take the scalar way, which keeps their f64 planes.
        ((special | large).to_bitmask() | odd) << at
    }

    /// Returns the lanes that f32 planes cannot serve.
    #[inline(always)]
    fn depth_planes<I: Isa>(
        &self,
        i: I,
        at: usize,
        arrays: &Arrays<'_>,
        draw: usize,
        vertex: &[I::I32; 3],
        corner: [u32; 2],
        group: &mut Group,
    ) -> u32 {
        let middle = origin(corner[0] / TILE, corner[1] / TILE).map(f64::from);
        let Solved { solver, z, w } =
            solve::<I, false>(i, arrays, vertex, self.transform(draw), middle);
        let plane = solver.plane(z);
        let [mut lo, mut hi] = hull(
            i,
            [
                i.narrow(z[0] / w[0]),
                i.narrow(z[1] / w[1]),
                i.narrow(z[2] / w[2]),
            ],
        );
        let odd = !(depth_is_even(i, plane, i.widen(lo)) & solver.solvable);
        let mut near = [i.narrow(plane[0]), i.narrow(plane[1]), i.narrow(plane[2])];
        let depth_slope = self.draw(draw as u32).depth_slope;
        if depth_slope != 0.0 {
            let away = depth_offset(i, depth_slope, near);
            near[2] = near[2] - away;
            (lo, hi) = (lo - away, hi - away);
        }
        near[0].store(&mut group.z[0][at..]);
        near[1].store(&mut group.z[1][at..]);
        near[2].store(&mut group.z[2][at..]);
        lo.store(&mut group.z_lo[at..]);
        hi.store(&mut group.z_hi[at..]);
        odd.to_bitmask()
    }

    /// One lane of any kind: a piece, a large triangle, one whose depth needs f64.
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
        let middle = origin(corner[0] / TILE, corner[1] / TILE).map(f64::from);
        let depth = DepthPlane::new(&shape, &Solver::new(Scalar, &shape.outer, middle));
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
}

/// Cuts the boxes to the tile and drops lanes that leave nothing.
#[inline(always)]
fn clip_boxes<I: Isa>(i: I, side: [u32; 2], group: &mut Group) {
    let (mut live, mut tiny, mut small) = (0, 0, 0);
    for at in (0..GROUP).step_by(I::LANES) {
        let x0 = i.load_i32(&group.x0[at..]).max(i.i32(0));
        let y0 = i.load_i32(&group.y0[at..]).max(i.i32(0));
        let x1 = i.load_i32(&group.x1[at..]).min(i.i32(side[0] as i32 - 1));
        let y1 = i.load_i32(&group.y1[at..]).min(i.i32(side[1] as i32 - 1));
        x0.store(&mut group.x0[at..]);
        y0.store(&mut group.y0[at..]);
        x1.store(&mut group.x1[at..]);
        y1.store(&mut group.y1[at..]);
        let (across, down) = (x1 - x0, y1 - y0);
        live |= (x0.simd_le(x1) & y0.simd_le(y1)).to_bitmask() << at;
        tiny |= (across.simd_lt(2) & down.simd_lt(2)).to_bitmask() << at;
        small |= (across.simd_lt(4) & down.simd_lt(4)).to_bitmask() << at;
    }
    group.live &= live;
    let even = group.live & !group.wide;
    group.tiny = tiny & even;
    group.small = small & even;
}

/// Least and greatest of three.
#[inline(always)]
pub(crate) fn extremes<I: Isa>(_: I, v: [I::I32; 3]) -> (I::I32, I::I32) {
    (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]))
}

/// Twice the area of small triangles: negative where the front is seen, as y points down.
#[inline(always)]
pub(crate) fn area_of<I: Isa>(_: I, v: [[I::I32; 2]; 3]) -> I::I32 {
    (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[2][0] - v[0][0]) * (v[1][1] - v[0][1])
}

/// Start and end of the edges, turned so that the inside is positive.
#[inline(always)]
pub(crate) fn edges_of<I: Isa>(_: I, v: [[I::I32; 2]; 3], front: I::Mask) -> [[[I::I32; 2]; 2]; 3] {
    let second = [
        front.select(v[2][0], v[1][0]),
        front.select(v[2][1], v[1][1]),
    ];
    let third = [
        front.select(v[1][0], v[2][0]),
        front.select(v[1][1], v[2][1]),
    ];
    [[v[0], second], [second, third], [third, v[0]]]
}

/// The least value inside an edge of direction (`b`, `-a`) by the top-left rule: 0 for left and top edges, else 1.
#[inline(always)]
pub(crate) fn least_inside<I: Isa>(i: I, a: I::I32, b: I::I32) -> I::I32 {
    let top_left = a.simd_gt(0) | (a.simd_eq(0) & b.simd_gt(0));
    top_left.select(i.i32(0), i.i32(1))
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
