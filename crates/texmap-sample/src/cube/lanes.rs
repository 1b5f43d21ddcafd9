//! Cube look-ups sixteen at a time, with the bits of [`Sampler::sample_cube`].

use super::{TextureCube, on_face};
use crate::{
    error::SampleError,
    filter::gl_of,
    lanes::{
        ANY, At, Kind, RGBA8_EXACT, RGBA16, View, exact_format,
        float::{Color, Levels, fetch, fetch_two, limit_lanes, mix, mix_four, scaled, select},
    },
    sampler::{Mip, Sampler, Texel},
    slice::{check, on_lanes},
};
use texmap_math::{
    Level,
    fearless_simd::{f32x16, i32x16, mask32x16, prelude::*},
    lanes::{Words, floor_to_i32, gather, load_tail, store_tail},
};

/// Directions to look along, each value in a slice of its own.
#[derive(Clone, Copy, Debug)]
pub struct Directions<'a> {
    /// Components, of any length.
    pub x: &'a [f32],
    /// Components.
    pub y: &'a [f32],
    /// Components.
    pub z: &'a [f32],
    /// Levels of detail; without them every look-up has level 0.
    pub lod: Option<&'a [f32]>,
}

/// [`Sampler::sample_cube`] over columns, dispatched once: the same bits, entry by entry.
///
/// # Errors
/// Slices of different lengths.
pub fn sample_cube_columns(
    level: Level,
    sampler: &Sampler,
    t: &TextureCube<'_>,
    at: &Directions<'_>,
    mut out: [&mut [f32]; 4],
) -> Result<(), SampleError> {
    check("y", at.x.len(), at.y.len())?;
    check("z", at.x.len(), at.z.len())?;
    if let Some(lod) = at.lod {
        check("lod", at.x.len(), lod.len())?;
    }
    for column in &out {
        check("out", at.x.len(), column.len())?;
    }
    let batch = Batch { sampler, t, at };
    let lanes = batch
        .view()
        .is_some_and(|view| on_lanes!(level, s => batch.on(s, &view, &mut out)));
    if !lanes {
        for i in 0..at.x.len() {
            batch.one(i, &mut out);
        }
    }
    Ok(())
}

struct Batch<'a> {
    sampler: &'a Sampler,
    t: &'a TextureCube<'a>,
    at: &'a Directions<'a>,
}

impl<'a> Batch<'a> {
    /// `None` for filters and texels that have no lanes.
    fn view(&self) -> Option<View<'a>> {
        let kind = match gl_of(self.sampler.filter) {
            (Texel::Nearest, Texel::Nearest, Mip::None) => Kind::Nearest,
            (Texel::Linear, Texel::Linear, Mip::None) => Kind::Bilinear,
            (Texel::Linear, Texel::Linear, Mip::Linear) => Kind::Trilinear,
            _ => return None,
        };
        let format = exact_format(&self.t.chain);
        View::prepared(self.sampler, &self.t.chain, kind, format)
    }

    fn one(&self, i: usize, out: &mut [&mut [f32]; 4]) {
        let at = self.at;
        let lod = at.lod.map_or(0.0, |lod| lod[i]);
        let c = self
            .sampler
            .sample_cube(self.t, [at.x[i], at.y[i], at.z[i]], lod);
        for (out, c) in out.iter_mut().zip(c) {
            out[i] = c;
        }
    }

    fn on<S: Simd>(&self, s: S, view: &View<'_>, out: &mut [&mut [f32]; 4]) {
        match view.format {
            RGBA8_EXACT => self.format::<S, RGBA8_EXACT>(s, view, out),
            RGBA16 => self.format::<S, RGBA16>(s, view, out),
            _ => self.format::<S, ANY>(s, view, out),
        }
    }

    fn format<S: Simd, const FORMAT: u8>(&self, s: S, view: &View<'_>, out: &mut [&mut [f32]; 4]) {
        s.vectorize(
            #[inline(always)]
            || {
                let flat = f32x16::splat(s, 0.0);
                for first in (0..self.at.x.len()).step_by(16) {
                    let d = [
                        load_tail(s, &self.at.x[first..]),
                        load_tail(s, &self.at.y[first..]),
                        load_tail(s, &self.at.z[first..]),
                    ];
                    let lod = self.at.lod.map_or(flat, |lod| load_tail(s, &lod[first..]));
                    let (c, corners) = look::<S, FORMAT>(s, view, d, lod);
                    let end = self.at.x.len().min(first + 16);
                    for (k, out) in out.iter_mut().enumerate() {
                        store_tail(c[k], &mut out[first..end]);
                    }
                    if corners.any_true() {
                        let corners = corners.to_bitmask();
                        for i in (first..end).filter(|i| corners >> (i - first) & 1 == 1) {
                            self.one(i, out);
                        }
                    }
                }
            },
        );
    }
}

/// The colours, and the lanes that need the mean at a corner: these have no meaning here.
#[inline(always)]
fn look<S: Simd, const FORMAT: u8>(
    s: S,
    view: &View<'_>,
    direction: [f32x16<S>; 3],
    lod: f32x16<S>,
) -> (Color<S>, mask32x16<S>) {
    let place = Place::new(s, direction);
    let (c, corners) = match view.kind {
        Kind::Nearest => {
            let at = At::uniform(s, view, 0);
            let c = place.nearest::<FORMAT>(s, view, &at);
            (c, mask32x16::splat(s, false))
        }
        Kind::Bilinear => place.bilinear::<FORMAT>(s, view, &At::uniform(s, view, 0)),
        _ => {
            // NaN reads as 0, as it does for one.
            let lod = lod.simd_eq(lod).select(lod, f32x16::splat(s, 0.0));
            let levels = Levels::new(s, view, limit_lanes(s, view, lod));
            let (c, corners) = place.bilinear::<FORMAT>(s, view, &levels.fine);
            if levels.blends {
                let two = levels.weight.simd_gt(f32x16::splat(s, 0.0));
                let (next, past) = place.bilinear::<FORMAT>(s, view, &levels.coarse);
                let blended = mix(view, c, next, levels.weight);
                (select(two, blended, c), corners | (past & two))
            } else {
                (c, corners)
            }
        }
    };
    (scaled(c, view), corners)
}

/// Scalar [`cube_face`](super::cube_face) for sixteen.
struct Place<S: Simd> {
    face: i32x16<S>,
    s: f32x16<S>,
    t: f32x16<S>,
}

impl<S: Simd> Place<S> {
    #[inline(always)]
    fn new(s: S, [x, y, z]: [f32x16<S>; 3]) -> Self {
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let most = f32x16::splat(s, f32::MAX);
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let finite = ax.simd_le(most) & ay.simd_le(most) & az.simd_le(most);
        let some = ax.simd_gt(zero) | ay.simd_gt(zero) | az.simd_gt(zero);
        let good = finite & some;
        let on_z = az.simd_ge(ax) & az.simd_ge(ay);
        let on_y = ay.simd_ge(ax);
        let front = along(on_z, z, on_y, y, x).simd_gt(zero);
        let major = good.select(along(on_z, az, on_y, ay, ax), one);
        let (side, depth) = (front.select(x, -x), front.select(-z, z));
        let right = along(on_z, side, on_y, x, depth);
        let down = along(on_z, -y, on_y, -depth, -y);
        let axis = i32x16::splat(s, 0);
        let axis = on_z.select(axis + 4, on_y.select(axis + 2, axis));
        let face = front.select(axis, axis + 1);
        Self {
            face: good.select(face, i32x16::splat(s, 4)),
            s: good.select(right, zero) / major * 0.5 + 0.5,
            t: good.select(down, zero) / major * 0.5 + 0.5,
        }
    }

    /// Texels before a place of the face in a level.
    #[inline(always)]
    fn texel(&self, at: &At<S>, i: i32x16<S>, j: i32x16<S>) -> i32x16<S> {
        (self.face * at.width + j) * at.width + i
    }

    #[inline(always)]
    fn nearest<const FORMAT: u8>(&self, s: S, view: &View<'_>, at: &At<S>) -> Color<S> {
        let (i, j) = (
            within(s, self.s * at.units_x, at),
            within(s, self.t * at.units_x, at),
        );
        fetch::<S, FORMAT>(s, view, at.word::<FORMAT>(view, self.texel(at, i, j)))
    }

    /// Four texels, across edges too; the lanes that need the mean at a corner.
    #[inline(always)]
    fn bilinear<const FORMAT: u8>(
        &self,
        s: S,
        view: &View<'_>,
        at: &At<S>,
    ) -> (Color<S>, mask32x16<S>) {
        let zero = i32x16::splat(s, 0);
        let (x, y) = (self.s * at.units_x - 0.5, self.t * at.units_x - 0.5);
        let (i, j) = (floor_to_i32(s, x), floor_to_i32(s, y));
        let (wx, wy) = (x - i.to_float::<f32x16<S>>(), y - j.to_float::<f32x16<S>>());
        let last = at.width - 1;
        let (in_x, in_y) = (
            i.simd_ge(zero) & i.simd_lt(last),
            j.simd_ge(zero) & j.simd_lt(last),
        );
        let mut corners = mask32x16::splat(s, false);
        let [top, bottom] = if (in_x & in_y).all_true() {
            let texel = self.texel(at, i, j);
            [
                fetch_two::<S, FORMAT>(s, view, at.word::<FORMAT>(view, texel)),
                fetch_two::<S, FORMAT>(s, view, at.word::<FORMAT>(view, texel + at.width)),
            ]
        } else {
            corners = !in_x & !in_y;
            let texels = [
                self.across(s, at, i, j),
                self.across(s, at, i + 1, j),
                self.across(s, at, i, j + 1),
                self.across(s, at, i + 1, j + 1),
            ];
            [
                [
                    fetch::<S, FORMAT>(s, view, at.word::<FORMAT>(view, texels[0])),
                    fetch::<S, FORMAT>(s, view, at.word::<FORMAT>(view, texels[1])),
                ],
                [
                    fetch::<S, FORMAT>(s, view, at.word::<FORMAT>(view, texels[2])),
                    fetch::<S, FORMAT>(s, view, at.word::<FORMAT>(view, texels[3])),
                ],
            ]
        };
        (mix_four(view, top, bottom, wx, wy), corners)
    }

    /// [`texel`](Self::texel) of a face or, one step beyond one of its edges, of the neighbour; 0 beyond two.
    #[inline(always)]
    fn across(&self, s: S, at: &At<S>, i: i32x16<S>, j: i32x16<S>) -> i32x16<S> {
        let (zero, last) = (i32x16::splat(s, 0), at.width - 1);
        let (left, right) = (i.simd_lt(zero), i.simd_gt(last));
        let (up, down) = (j.simd_lt(zero), j.simd_gt(last));
        let (beside, above) = (left | right, up | down);
        let edge = i32x16::splat(s, 3);
        let edge = up.select(zero + 2, edge);
        let edge = right.select(zero + 1, edge);
        let edge = (self.face << 2) + left.select(zero, edge);
        let step = match Words::new(&EDGES) {
            Some(words) => gather(s, words, edge.bitcast()).bitcast::<i32x16<S>>(),
            None => zero,
        };
        let along = beside.select(j, i);
        let x = (step & 8).simd_gt(zero).select(along, zero);
        let x = (step & 16).simd_gt(zero).select(last - x, x);
        let y = (step & 32).simd_gt(zero).select(along, zero);
        let y = (step & 64).simd_gt(zero).select(last - y, y);
        let neighbour = ((step & 7) * at.width + y) * at.width + x;
        let texel = (beside | above).select(neighbour, self.texel(at, i, j));
        (beside & above).select(zero, texel)
    }
}

// Functions, not closures: these would lose the level's instructions.

/// What belongs to the axis that a direction runs along: z, y or x.
#[inline(always)]
fn along<S: Simd>(
    on_z: mask32x16<S>,
    of_z: f32x16<S>,
    on_y: mask32x16<S>,
    of_y: f32x16<S>,
    of_x: f32x16<S>,
) -> f32x16<S> {
    on_z.select(of_z, on_y.select(of_y, of_x))
}

/// The texel of a coordinate, on the face.
#[inline(always)]
fn within<S: Simd>(s: S, c: f32x16<S>, at: &At<S>) -> i32x16<S> {
    let (zero, last) = (i32x16::splat(s, 0), at.width - 1);
    let i = floor_to_i32(s, c);
    let i = i.simd_gt(zero).select(i, zero);
    i.simd_lt(last).select(i, last)
}

/// What lies beyond each face's edges to the left, right, top and bottom: the neighbour (3 bits), and for its column and then its row
/// whether that counts along the edge or stays 0, and whether it counts from the last texel.
const EDGES: [u32; 24] = {
    let mut edges = [0; 24];
    let mut k = 0;
    while k < 24 {
        let [right, down, major] = axes(k / 4);
        let (out, along) = match k % 4 {
            0 => (opposite(right), down),
            1 => (right, down),
            2 => (opposite(down), right),
            _ => (down, right),
        };
        let mut face = 0;
        while dot(axes(face)[2], out) != 1.0 {
            face += 1;
        }
        let [x, y, _] = axes(face);
        edges[k] = face as u32 | step(x, along, major) << 3 | step(y, along, major) << 5;
        k += 1;
    }
    edges
};

/// To the right, down and out of a face.
const fn axes(face: usize) -> [[f32; 3]; 3] {
    let [x, y, z] = [
        on_face(face, [1.0, 0.0, 0.0]),
        on_face(face, [0.0, 1.0, 0.0]),
        on_face(face, [0.0, 0.0, 1.0]),
    ];
    [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
}

/// How a neighbour's axis runs: along the edge or, if not, towards the face that was left or away from it.
const fn step(axis: [f32; 3], along: [f32; 3], left: [f32; 3]) -> u32 {
    let (along, left) = (dot(axis, along), dot(axis, left));
    if along == 0.0 {
        if left > 0.0 { 2 } else { 0 }
    } else if along > 0.0 {
        1
    } else {
        3
    }
}

const fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

const fn opposite([x, y, z]: [f32; 3]) -> [f32; 3] {
    [-x, -y, -z]
}
