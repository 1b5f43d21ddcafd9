//! Look-ups in cubes.

use super::{TextureCube, edges::EDGES};
use crate::{
    address::texel::LaneLevel,
    batch::check,
    bound_texture::{ANY, BoundTexture, RGBA8_EXACT, exact_format},
    error::SampleError,
    fetch::{Color, fetch, fetch_two, mix, mix_four, scaled, select},
    filter::{Kernel, bilinear::cell, gl::Reads, gl_of, trilinear::LevelPair},
    sampler::{Mip, Sampler, TexelFilter},
    vectors::{in_vectors, load, store_columns, vector_start},
};
use texmap_math::{
    Level, dispatch_simd,
    lanes::GatherTable,
    simd::{Isa, Scalar, prelude::*},
};

/// Directions to look along, each value in a slice of its own.
#[derive(Clone, Copy, Debug)]
pub struct DirectionBatch<'a> {
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
pub fn sample_cube_soa(
    level: Level,
    sampler: &Sampler,
    t: &TextureCube<'_>,
    at: &DirectionBatch<'_>,
    out: [&mut [f32]; 4],
) -> Result<(), SampleError> {
    check("y", at.x.len(), at.y.len())?;
    check("z", at.x.len(), at.z.len())?;
    if let Some(lod) = at.lod {
        check("lod", at.x.len(), lod.len())?;
    }
    for column in &out {
        check("out", at.x.len(), column.len())?;
    }
    let format = exact_format(&t.chain);
    if let Some(view) = BoundTexture::of_chain(sampler, &t.chain, Kernel::Gl, format) {
        let batch = Batch {
            level,
            sampler,
            t,
            view: &view,
            at,
            out,
        };
        run(sampler, format, batch);
    }
    Ok(())
}

/// The colour in one direction.
#[inline(always)]
pub(super) fn sample(
    sampler: &Sampler,
    t: &TextureCube<'_>,
    direction: [f32; 3],
    lod: f32,
) -> [f32; 4] {
    let format = exact_format(&t.chain);
    let single = Single {
        sampler,
        t,
        direction,
        lod,
    };
    run(sampler, format, single)
}

/// Every look-up reads the same texels of level 0.
const BASE: u8 = 0;
/// Four texels of one level or of two.
const TRILINEAR: u8 = 1;
/// Any choice of OpenGL's.
const GL: u8 = 2;

/// Runs a kernel: over a batch, or for one look-up.
trait Run {
    type Out;
    fn run<const FORMAT: u8, const LEVELS: u8>(self) -> Self::Out;
}

/// Runs the kernel of a filter on a format.
#[inline(always)]
fn run<R: Run>(sampler: &Sampler, format: u8, run: R) -> R::Out {
    let levels = match gl_of(sampler.filter) {
        (mag, min, Mip::None) if mag == min => BASE,
        (TexelFilter::Linear, TexelFilter::Linear, Mip::Linear) => TRILINEAR,
        _ => GL,
    };
    match (format, levels) {
        (RGBA8_EXACT, BASE) => run.run::<RGBA8_EXACT, BASE>(),
        (RGBA8_EXACT, TRILINEAR) => run.run::<RGBA8_EXACT, TRILINEAR>(),
        (_, BASE) => run.run::<ANY, BASE>(),
        (_, TRILINEAR) => run.run::<ANY, TRILINEAR>(),
        _ => run.run::<ANY, GL>(),
    }
}

struct Single<'a> {
    sampler: &'a Sampler,
    t: &'a TextureCube<'a>,
    direction: [f32; 3],
    lod: f32,
}

impl Run for Single<'_> {
    type Out = [f32; 4];

    #[inline(never)]
    fn run<const FORMAT: u8, const LEVELS: u8>(self) -> [f32; 4] {
        let chain = &self.t.chain;
        let format = match FORMAT {
            ANY => exact_format(chain),
            format => format,
        };
        let Some(view) = BoundTexture::single(self.sampler, chain, Kernel::Gl, format) else {
            return [0.0; 4];
        };
        let (place, usual) = FaceVector::new(Scalar, self.direction);
        let [s, t] = place.coordinates(Scalar, usual);
        let place = Place {
            face: place.face,
            s,
            t,
        };
        place.look::<FORMAT, LEVELS>(Scalar, &view, self.lod)
    }
}

struct Batch<'a> {
    level: Level,
    sampler: &'a Sampler,
    t: &'a TextureCube<'a>,
    view: &'a BoundTexture<'a>,
    at: &'a DirectionBatch<'a>,
    out: [&'a mut [f32]; 4],
}

impl Run for Batch<'_> {
    type Out = ();

    fn run<const FORMAT: u8, const LEVELS: u8>(self) {
        dispatch_simd!(self.level, i => columns::<_, FORMAT, LEVELS>(i, self));
    }
}

#[inline(never)]
fn columns<I: Isa, const FORMAT: u8, const LEVELS: u8>(i: I, batch: Batch<'_>) {
    let Batch {
        view, at, mut out, ..
    } = batch;
    if const { I::LANES == 1 } {
        for k in 0..at.x.len() {
            let single = Single {
                sampler: batch.sampler,
                t: batch.t,
                direction: [at.x[k], at.y[k], at.z[k]],
                lod: at.lod.map_or(0.0, |lod| lod[k]),
            };
            let c = single.run::<FORMAT, LEVELS>();
            out.iter_mut().zip(c).for_each(|(out, c)| out[k] = c);
        }
        return;
    }
    let lod = at.lod.unwrap_or(at.x);
    in_vectors::<I, _, 4, 4>([at.x, at.y, at.z, lod], out, |columns, mut out| {
        let ([x, y, z, lod], has_lod) = (columns, at.lod.is_some());
        i.vectorize(
            #[inline(always)]
            || {
                let (mut places, count) = (Places::default(), x.len());
                for start in (0..count).step_by(I::LANES * RUN) {
                    let end = count.min(start + I::LANES * RUN);
                    for (k, first) in (start..end).step_by(I::LANES).enumerate() {
                        let first = vector_start::<I>(first, count);
                        let d = [load(i, x, first), load(i, y, first), load(i, z, first)];
                        places.find(i, k, d);
                    }
                    for (k, first) in (start..end).step_by(I::LANES).enumerate() {
                        let first = vector_start::<I>(first, count);
                        let lod = if has_lod {
                            load(i, lod, first)
                        } else {
                            i.f32(0.0)
                        };
                        let place = places.place(i, k);
                        let c = place.look::<FORMAT, LEVELS>(i, view, lod);
                        store_columns(i, c, first, &mut out);
                    }
                }
            },
        );
    });
}

/// Blocks whose face coordinates are computed before the first look-up. A gather then waits for its own addresses alone.
const RUN: usize = 8;

/// Face coordinates of a run's blocks.
#[derive(Default)]
struct Places {
    face: [[i32; 16]; RUN],
    s: [[f32; 16]; RUN],
    t: [[f32; 16]; RUN],
}

impl Places {
    /// The face coordinates of block `k`.
    #[inline(always)]
    fn find<I: Isa>(&mut self, i: I, k: usize, direction: [I::F32; 3]) {
        let (place, usual) = FaceVector::new(i, direction);
        let [s, t] = place.coordinates(i, usual);
        place.face.store(&mut self.face[k]);
        s.store(&mut self.s[k]);
        t.store(&mut self.t[k]);
    }

    #[inline(always)]
    fn place<I: Isa>(&self, i: I, k: usize) -> Place<I> {
        Place {
            face: i.load_i32(&self.face[k]),
            s: i.load_f32(&self.s[k]),
            t: i.load_f32(&self.t[k]),
        }
    }
}

/// Directions in the axes of their faces.
pub(super) struct FaceVector<I: Isa> {
    pub(super) face: I::I32,
    /// To the right and down: (-z, -y) on +X, (x, z) on +Y, (x, -y) on +Z. Mirrored on the other sides as OpenGL has it.
    pub(super) across: [I::F32; 2],
    /// Out of the face, above 0.
    pub(super) major: I::F32,
}

impl<I: Isa> FaceVector<I> {
    /// Also the lanes whose reciprocals lose nothing. Zero and what is not finite point out of the middle of +Z.
    #[inline(always)]
    pub(super) fn new(i: I, [x, y, z]: [I::F32; 3]) -> (Self, I::Mask) {
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let [least, most] = USUAL.map(f32::to_bits);
        let total = ax + ay + az;
        let usual = (total.to_bits() - least).simd_le(most - least);
        // The major axis; of equal ones z before y before x.
        let y_over_x = ay.simd_ge(ax);
        let major = y_over_x.select(y, x);
        let on_z = az.simd_ge(major.abs());
        let major = on_z.select(z, major);
        let sign = major.to_bits() & SIGN;
        let right = on_z.select(x, y_over_x.select(x, z)).to_bits();
        let right = right ^ on_z.select(sign, y_over_x.select(i.u32(0), sign ^ SIGN));
        let down = on_z.select(y, y_over_x.select(z, y)).to_bits();
        let down = down ^ on_z.select(i.u32(SIGN), y_over_x.select(sign, i.u32(SIGN)));
        let axis = on_z.select(i.i32(4), y_over_x.select(i.i32(2), i.i32(0)));
        let mut all = Self {
            face: axis + (sign >> 31).to_i32(),
            across: [right.to_f32_bits(), down.to_f32_bits()],
            major: major.abs(),
        };
        if !usual.all_true() {
            let finite = ax.simd_le(f32::MAX) & ay.simd_le(f32::MAX) & az.simd_le(f32::MAX);
            let zero = ax.simd_eq(0.0) & ay.simd_eq(0.0) & az.simd_eq(0.0);
            let points = finite & !zero;
            all.face = points.select(all.face, i.i32(4));
            all.across = [
                points.select(all.across[0], i.f32(0.0)),
                points.select(all.across[1], i.f32(0.0)),
            ];
            all.major = points.select(all.major, i.f32(1.0));
        }
        (all, usual)
    }

    /// (s, t) on the face.
    #[inline(always)]
    pub(super) fn coordinates(&self, i: I, usual: I::Mask) -> [I::F32; 2] {
        let [right, down] = self.across;
        let scale = i.f32(0.5) / self.major;
        let [mut s, mut t] = [right * scale, down * scale];
        if !usual.all_true() {
            s = usual.select(s, (right / self.major) * 0.5);
            t = usual.select(t, (down / self.major) * 0.5);
        }
        [s + 0.5, t + 0.5]
    }
}

const SIGN: u32 = 1 << 31;

/// Sums of components that are finite and whose reciprocals lose nothing.
const USUAL: [f32; 2] = [1e-30, 1e30];

/// Faces, and coordinates on them.
struct Place<I: Isa> {
    face: I::I32,
    s: I::F32,
    t: I::F32,
}

impl<I: Isa> Place<I> {
    #[inline(always)]
    fn look<const FORMAT: u8, const LEVELS: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        lod: I::F32,
    ) -> Color<I> {
        if LEVELS == BASE {
            let at = LaneLevel::uniform(i, view, 0);
            let color = self.read::<FORMAT>(i, view, &at, view.gl.0);
            return scaled::<I>(color, view);
        }
        let lod = lod.simd_eq(lod).select(lod, i.f32(0.0));
        let lod = view.lod_range.limit(i, lod);
        if LEVELS == TRILINEAR {
            let levels = LevelPair::new(i, view, lod);
            let color = self.bilinear::<FORMAT>(i, view, &levels.fine);
            if !levels.blends {
                return scaled::<I>(color, view);
            }
            let two = levels.weight.simd_gt(0.0);
            let next = self.bilinear::<FORMAT>(i, view, &levels.coarse);
            let blended = mix::<I>(view, color, next, levels.weight);
            return scaled::<I>(select::<I>(two, blended, color), view);
        }
        let mut reads = Reads::new(i, view, lod);
        let mut color = [i.f32(0.0); 4];
        loop {
            if reads.lanes.any_true() {
                let at = LaneLevel::of(i, view, reads.level);
                let read = self.read::<FORMAT>(i, view, &at, reads.texel);
                color = reads.onto(view, color, read);
            }
            if !reads.step() {
                return scaled::<I>(color, view);
            }
        }
    }

    /// Colours in a level.
    #[inline(always)]
    fn read<const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        at: &LaneLevel<I>,
        texel: TexelFilter,
    ) -> Color<I> {
        match texel {
            TexelFilter::Nearest => self.nearest::<FORMAT>(i, view, at),
            TexelFilter::Linear => self.bilinear::<FORMAT>(i, view, at),
        }
    }

    /// Index of a texel of the face, from the first texel of the level.
    #[inline(always)]
    fn texel(&self, at: &LaneLevel<I>, [x, y]: [I::I32; 2]) -> I::I32 {
        (self.face * at.width + y) * at.width + x
    }

    #[inline(always)]
    fn nearest<const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        at: &LaneLevel<I>,
    ) -> Color<I> {
        let texel = [
            on_face(i, (self.s * at.units_x).floor_to_i32(), at),
            on_face(i, (self.t * at.units_x).floor_to_i32(), at),
        ];
        let word = at.word::<FORMAT>(view, self.texel(at, texel));
        fetch::<I, FORMAT>(i, view, word)
    }

    /// Four texels, across edges too.
    #[inline(always)]
    fn bilinear<const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        at: &LaneLevel<I>,
    ) -> Color<I> {
        let ([x, y], weights) = cell::<I>([self.s * at.units_x - 0.5, self.t * at.units_x - 0.5]);
        // Unsigned: -1 lies beyond the last one too.
        let last = (at.width - 1).to_u32();
        let (in_x, in_y) = (x.to_u32().simd_lt(last), y.to_u32().simd_lt(last));
        if (in_x & in_y).all_true() {
            let texel = self.texel(at, [x, y]);
            let below = at.word::<FORMAT>(view, texel + at.width);
            let rows = [
                fetch_two::<I, FORMAT>(i, view, at.word::<FORMAT>(view, texel)),
                fetch_two::<I, FORMAT>(i, view, below),
            ];
            return mix_four::<I>(view, rows, weights);
        }
        let corners = (!in_x & !in_y).any_true();
        // One place in the code for all four.
        let mut rows = [[[i.f32(0.0); 4]; 2]; 2];
        for (y, row) in [y, y + 1].iter().zip(&mut rows) {
            for (x, texel) in [x, x + 1].iter().zip(row) {
                let word = at.word::<FORMAT>(view, self.across(i, at, [*x, *y]));
                *texel = fetch::<I, FORMAT>(i, view, word);
                if corners {
                    *texel = self.at_corner::<FORMAT>(i, view, at, [*x, *y], *texel);
                }
            }
        }
        mix_four::<I>(view, rows, weights)
    }

    /// The texel, or beyond two edges the mean of the three around the corner: rare, and out of line.
    #[inline(never)]
    fn at_corner<const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        at: &LaneLevel<I>,
        place: [I::I32; 2],
        texel: Color<I>,
    ) -> Color<I> {
        i.vectorize(
            #[inline(always)]
            || self.corner_mean::<FORMAT>(i, view, at, place, texel),
        )
    }

    #[inline(always)]
    fn corner_mean<const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        at: &LaneLevel<I>,
        [x, y]: [I::I32; 2],
        texel: Color<I>,
    ) -> Color<I> {
        let (inner_x, inner_y) = (on_face(i, x, at), on_face(i, y, at));
        let beyond = !x.simd_eq(inner_x) & !y.simd_eq(inner_y);
        if !beyond.any_true() {
            return texel;
        }
        let mut around = [texel; 3];
        let places = [[inner_x, inner_y], [x, inner_y], [inner_x, y]];
        for (c, place) in around.iter_mut().zip(&places) {
            let word = at.word::<FORMAT>(view, self.across(i, at, *place));
            *c = fetch::<I, FORMAT>(i, view, word);
        }
        let [a, b, c] = around;
        let mut mean = a;
        for k in 0..4 {
            // The mean over differences keeps a constant cube constant.
            mean[k] = a[k] + ((b[k] - a[k]) + (c[k] - a[k])) / 3.0;
        }
        select::<I>(beyond, mean, texel)
    }

    /// [`texel`](Self::texel) of a face or, one step beyond one of its edges, of the neighbour; 0 beyond two.
    #[inline(always)]
    fn across(&self, i: I, at: &LaneLevel<I>, [x, y]: [I::I32; 2]) -> I::I32 {
        let (zero, last) = (i.i32(0), at.width - 1);
        let (left, right) = (x.simd_lt(0), x.simd_gt(last));
        let (up, down) = (y.simd_lt(0), y.simd_gt(last));
        let (beside, above) = (left | right, up | down);
        let edge = up.select(i.i32(2), i.i32(3));
        let edge = right.select(i.i32(1), edge);
        let edge = (self.face << 2) + left.select(zero, edge);
        let step = match GatherTable::new(&EDGES) {
            Some(words) => i.gather(words, edge.to_u32()).to_i32(),
            None => zero,
        };
        let along = beside.select(y, x);
        let column = (step & 8).simd_gt(0).select(along, zero);
        let column = (step & 16).simd_gt(0).select(last - column, column);
        let row = (step & 32).simd_gt(0).select(along, zero);
        let row = (step & 64).simd_gt(0).select(last - row, row);
        let neighbour = ((step & 7) * at.width + row) * at.width + column;
        let texel = (beside | above).select(neighbour, self.texel(at, [x, y]));
        (beside & above).select(zero, texel)
    }
}

/// A column or row within the face.
#[inline(always)]
fn on_face<I: Isa>(i: I, x: I::I32, at: &LaneLevel<I>) -> I::I32 {
    x.max(i.i32(0)).min(at.width - 1)
}
