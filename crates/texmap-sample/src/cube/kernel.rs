//! Cube look-ups sixteen at a time, with the bits of [`Sampler::sample_cube`].

use super::{TextureCube, USUAL, on_face};
use crate::{
    error::SampleError,
    filter::gl_of,
    lanes::{
        ANY, At, Kind, RGBA8_EXACT, View, exact_format,
        float::{Color, Levels, fetch, fetch_two, limit_lanes, mix, mix_four, scaled, select},
        gl::Reads,
    },
    sampler::{Mip, Sampler, Texel},
    slice::{check, on_lanes},
};
use texmap_math::{
    Level,
    fearless_simd::{f32x16, i32x16, mask32x16, prelude::*, u32x16},
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
    let batch = Batch {
        sampler,
        t,
        at,
        gl: gl_of(sampler.filter),
    };
    let view = View::prepared(sampler, &t.chain, Kind::Gl, exact_format(&t.chain));
    let lanes = view.is_some_and(|view| on_lanes!(level, s => batch.on(s, &view, &mut out)));
    if !lanes {
        for i in 0..at.x.len() {
            batch.one(i, &mut out);
        }
    }
    Ok(())
}

/// Every look-up reads the same texels of level 0.
const BASE: u8 = 0;
/// Four texels of one level or of two.
const TRILINEAR: u8 = 1;
/// Any choice of OpenGL's.
const GL: u8 = 2;

struct Batch<'a> {
    sampler: &'a Sampler,
    t: &'a TextureCube<'a>,
    at: &'a Directions<'a>,
    gl: (Texel, Texel, Mip),
}

impl Batch<'_> {
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
        let levels = match self.gl {
            (mag, min, Mip::None) if mag == min => BASE,
            (Texel::Linear, Texel::Linear, Mip::Linear) => TRILINEAR,
            _ => GL,
        };
        match (view.format, levels) {
            (RGBA8_EXACT, BASE) => self.format::<S, RGBA8_EXACT, BASE>(s, view, out),
            (RGBA8_EXACT, TRILINEAR) => self.format::<S, RGBA8_EXACT, TRILINEAR>(s, view, out),
            (_, BASE) => self.format::<S, ANY, BASE>(s, view, out),
            (_, TRILINEAR) => self.format::<S, ANY, TRILINEAR>(s, view, out),
            _ => self.format::<S, ANY, GL>(s, view, out),
        }
    }

    fn format<S: Simd, const FORMAT: u8, const LEVELS: u8>(
        &self,
        s: S,
        view: &View<'_>,
        out: &mut [&mut [f32]; 4],
    ) {
        s.vectorize(
            #[inline(always)]
            || {
                let mut places = Places::default();
                for start in (0..self.at.x.len()).step_by(16 * RUN) {
                    let end = self.at.x.len().min(start + 16 * RUN);
                    for (k, first) in (start..end).step_by(16).enumerate() {
                        let d = [
                            load_tail(s, &self.at.x[first..end]),
                            load_tail(s, &self.at.y[first..end]),
                            load_tail(s, &self.at.z[first..end]),
                        ];
                        places.find(s, k, d);
                    }
                    for (k, first) in (start..end).step_by(16).enumerate() {
                        self.look_ups::<S, FORMAT, LEVELS>(s, view, &places, k, first, out);
                    }
                }
            },
        );
    }

    /// The look-ups of block `k` of a run, which is that from entry `first`.
    #[inline(always)]
    fn look_ups<S: Simd, const FORMAT: u8, const LEVELS: u8>(
        &self,
        s: S,
        view: &View<'_>,
        places: &Places,
        k: usize,
        first: usize,
        out: &mut [&mut [f32]; 4],
    ) {
        let flat = f32x16::splat(s, 0.0);
        let place = places.place(s, k);
        let lod = self.at.lod.map_or(flat, |lod| load_tail(s, &lod[first..]));
        let (c, corners) = self.look::<S, FORMAT, LEVELS>(s, view, &place, lod);
        let end = self.at.x.len().min(first + 16);
        for (k, out) in out.iter_mut().enumerate() {
            store_tail(c[k], &mut out[first..end]);
        }
        let alone = corners.to_bitmask() | places.strange[k];
        if alone != 0 {
            for i in (first..end).filter(|i| alone >> (i - first) & 1 == 1) {
                self.one(i, out);
            }
        }
    }

    /// The colours, and the lanes that need the mean at a corner: theirs have no meaning.
    #[inline(always)]
    fn look<S: Simd, const FORMAT: u8, const LEVELS: u8>(
        &self,
        s: S,
        view: &View<'_>,
        place: &Place<S>,
        lod: f32x16<S>,
    ) -> (Color<S>, mask32x16<S>) {
        if LEVELS == BASE {
            let at = At::uniform(s, view, 0);
            let (color, corners) = place.read::<FORMAT>(s, view, &at, self.gl.0);
            return (scaled(color, view), corners);
        }
        // NaN reads as 0, as it does for one.
        let lod = lod.simd_eq(lod).select(lod, f32x16::splat(s, 0.0));
        let lod = limit_lanes(s, view, lod);
        if LEVELS == TRILINEAR {
            let levels = Levels::new(s, view, lod);
            let (color, corners) = place.bilinear::<FORMAT>(s, view, &levels.fine);
            if !levels.blends {
                return (scaled(color, view), corners);
            }
            let two = levels.weight.simd_gt(f32x16::splat(s, 0.0));
            let (next, past) = place.bilinear::<FORMAT>(s, view, &levels.coarse);
            let blended = select(two, mix(view, color, next, levels.weight), color);
            return (scaled(blended, view), corners | (past & two));
        }
        let mut reads = Reads::new(s, view, self.gl, lod);
        let mut corners = mask32x16::splat(s, false);
        let mut color = [f32x16::splat(s, 0.0); 4];
        loop {
            if reads.lanes.any_true() {
                let at = At::of(s, view, reads.level);
                let (read, past) = place.read::<FORMAT>(s, view, &at, reads.texel);
                color = reads.onto(view, color, read);
                corners |= past & reads.lanes;
            }
            if !reads.step() {
                return (scaled(color, view), corners);
            }
        }
    }
}

/// Blocks whose places are found before the first is looked up: a gather waits for its places alone.
const RUN: usize = 8;

/// Places of a run's blocks.
#[derive(Default)]
struct Places {
    face: [[i32; 16]; RUN],
    s: [[f32; 16]; RUN],
    t: [[f32; 16]; RUN],
    /// Bits of the lanes whose direction is zero, tiny, huge or not finite: their place is any on the cube.
    strange: [u64; RUN],
}

impl Places {
    /// Scalar [`cube_face`](super::cube_face) for the sixteen of block `k`.
    #[inline(always)]
    fn find<S: Simd>(&mut self, s: S, k: usize, [x, y, z]: [f32x16<S>; 3]) {
        let (zero, half) = (f32x16::splat(s, 0.0), f32x16::splat(s, 0.5));
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let [least, most] = USUAL.map(f32::to_bits);
        let total: u32x16<S> = (ax + ay + az).bitcast();
        let usual = (total - least).simd_le(most - least);
        // Where it is not z, it is y; where not y, x.
        let y_over_x = ay.simd_ge(ax);
        let major = y_over_x.select(y, x);
        let on_z = az.simd_ge(major.abs());
        let major = on_z.select(z, major);
        let signed = half / major;
        let scale = signed.abs();
        // To the right and down: (-z, -y) on x, (x, z) on y, (x, -y) on z, turned round on their negative sides, but for x on y and y.
        let right = on_z.select(x, y_over_x.select(x, z));
        let right = right * on_z.select(signed, y_over_x.select(scale, -signed)) + 0.5;
        let down = on_z.select(y, y_over_x.select(z, y));
        let down = down * on_z.select(-scale, y_over_x.select(signed, -scale)) + 0.5;
        let axis = i32x16::splat(s, 0);
        let axis = on_z.select(axis + 4, y_over_x.select(axis + 2, axis));
        let negative = (major.bitcast::<u32x16<S>>() >> 31).bitcast::<i32x16<S>>();
        (axis + negative).store_slice(&mut self.face[k]);
        usual.select(right, zero).store_slice(&mut self.s[k]);
        usual.select(down, zero).store_slice(&mut self.t[k]);
        self.strange[k] = (!usual).to_bitmask();
    }

    #[inline(always)]
    fn place<S: Simd>(&self, s: S, k: usize) -> Place<S> {
        Place {
            face: i32x16::from_slice(s, &self.face[k]),
            s: f32x16::from_slice(s, &self.s[k]),
            t: f32x16::from_slice(s, &self.t[k]),
        }
    }
}

/// Faces, and where on them.
struct Place<S: Simd> {
    face: i32x16<S>,
    s: f32x16<S>,
    t: f32x16<S>,
}

impl<S: Simd> Place<S> {
    /// Colours in a level, and the lanes that need the mean at a corner.
    #[inline(always)]
    fn read<const FORMAT: u8>(
        &self,
        s: S,
        view: &View<'_>,
        at: &At<S>,
        texel: Texel,
    ) -> (Color<S>, mask32x16<S>) {
        match texel {
            Texel::Nearest => (
                self.nearest::<FORMAT>(s, view, at),
                mask32x16::splat(s, false),
            ),
            Texel::Linear => self.bilinear::<FORMAT>(s, view, at),
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
        let (x, y) = (self.s * at.units_x - 0.5, self.t * at.units_x - 0.5);
        let (i, j) = (floor_to_i32(s, x), floor_to_i32(s, y));
        let (wx, wy) = (x - i.to_float::<f32x16<S>>(), y - j.to_float::<f32x16<S>>());
        // Unsigned: -1 lies beyond the last one too.
        let last: u32x16<S> = (at.width - 1).bitcast();
        let in_x = i.bitcast::<u32x16<S>>().simd_lt(last);
        let in_y = j.bitcast::<u32x16<S>>().simd_lt(last);
        if (in_x & in_y).all_true() {
            let texel = self.texel(at, i, j);
            let top = fetch_two::<S, FORMAT>(s, view, at.word::<FORMAT>(view, texel));
            let below = at.word::<FORMAT>(view, texel + at.width);
            let bottom = fetch_two::<S, FORMAT>(s, view, below);
            return (
                mix_four(view, top, bottom, wx, wy),
                mask32x16::splat(s, false),
            );
        }
        // One place in the code for all four.
        let mut rows = [[[f32x16::splat(s, 0.0); 4]; 2]; 2];
        for (j, row) in [j, j + 1].iter().zip(&mut rows) {
            for (i, texel) in [i, i + 1].iter().zip(row) {
                let word = at.word::<FORMAT>(view, self.across(s, at, *i, *j));
                *texel = fetch::<S, FORMAT>(s, view, word);
            }
        }
        let [top, bottom] = rows;
        (mix_four(view, top, bottom, wx, wy), !in_x & !in_y)
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
