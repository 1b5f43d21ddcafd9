//! The slope of a texture's surface, and dependent look-ups: in a second texture at what a first one says.

use crate::{
    address::{
        lod::{TexelFootprint, lod},
        texel::LaneLevel,
    },
    batch::{PART, Places, sample_bound_soa},
    bound_texture::{ANY, BoundTexture, exact_format},
    error::SampleError,
    fetch::{Color, fetch_corners, scaled},
    filter::{Kernel, bilinear::cell},
    sampler::Sampler,
    texture::Texture2d,
    vectors::{in_vectors, load, store_columns, vector_start},
};
use texmap_math::{
    Level, dispatch_simd,
    footprint::Footprint,
    simd::{Isa, Scalar, prelude::*},
};

impl Sampler {
    /// The bilinear surface at a level: value and its exact derivatives by u and by v.
    ///
    /// The nearest level to `lod` is taken, so that value and slope belong to one surface.
    pub fn sample_with_gradient(&self, t: &Texture2d<'_>, uv: [f32; 2], lod: f32) -> [[f32; 4]; 3] {
        match self.view(t) {
            Some(view) => surface(Scalar, &view, uv, self.limit_lod(lod)),
            None => [[0.0; 4]; 3],
        }
    }

    /// A dependent look-up: the first two channels of `first` at `uv` are the coordinates in `second`.
    ///
    /// The footprint of the second look-up is that of the first through the slope of the first
    /// texture's surface (the chain rule), at the level that the first look-up asks for.
    pub fn sample_through_ramp(
        &self,
        first: &Texture2d<'_>,
        uv: [f32; 2],
        d: Footprint,
        sampler: &Self,
        second: &Texture2d<'_>,
    ) -> [f32; 4] {
        let Some(view) = self.view(first) else {
            return [0.0; 4];
        };
        let d = [d.du_dx, d.dv_dx, d.du_dy, d.dv_dy];
        let [u, v, ux, vx, uy, vy] = dependent(Scalar, &view, uv, d);
        sampler.sample_grad(second, [u, v], Footprint::new(ux, vx, uy, vy))
    }
}

/// [`Sampler::sample_through_ramp`] over columns, bit for bit. Without gradients the first texture is read on the level that a
/// footprint of nothing asks for, and the second as if it were magnified.
///
/// ```
/// use texmap_math::Level;
/// use texmap_sample::{ColorSpace, Origin, Places, Sampler, Texture2d, sample_dependent_soa};
///
/// // A picture of two values, and the ramp that colours them: black for 0, red for 1.
/// let values = Texture2d::from_rgba8(2, 1, [[0, 0, 0, 255], [255, 0, 0, 255]].concat(), ColorSpace::Linear, Origin::TopLeft)?;
/// let ramp = Texture2d::from_rgba8(2, 1, [[0, 0, 0, 255], [255, 0, 0, 255]].concat(), ColorSpace::Linear, Origin::TopLeft)?;
/// let along = Sampler { wrap_u: texmap_sample::Wrap::ClampToEdge, ..Sampler::default() };
/// let (at, s) = (Places { u: &[0.25, 0.75], v: &[0.5; 2], gradients: None }, Sampler::default());
/// let mut colors = [[0.0; 2]; 4];
/// sample_dependent_soa(Level::new(), (&s, &values), (&along, &ramp), &at, colors.each_mut().map(|c| &mut c[..]))?;
/// assert_eq!(colors[0], [0.0, 1.0]);
/// # Ok::<(), texmap_sample::SampleError>(())
/// ```
///
/// # Errors
/// Slices of different lengths.
pub fn sample_dependent_soa(
    level: Level,
    (sampler, first): (&Sampler, &Texture2d<'_>),
    (along, second): (&Sampler, &Texture2d<'_>),
    at: &Places<'_>,
    mut out: [&mut [f32]; 4],
) -> Result<(), SampleError> {
    for column in &out {
        at.check(column.len())?;
    }
    let format = exact_format(&first.chain);
    let view = BoundTexture::of_chain(sampler, &first.chain, Kernel::Bilinear, format);
    let (Some(view), Some(ramp)) = (view, BoundTexture::new(along, second)) else {
        return Ok(());
    };
    let mut columns = [[0.0; PART]; 6];
    for start in (0..at.u.len()).step_by(PART) {
        let part = at.part(start..at.u.len().min(start + PART));
        let count = part.u.len();
        let inner = columns.each_mut().map(|c| &mut c[..count]);
        dispatch_simd!(level, i => dependent_columns(i, &view, &part, inner));
        let [u, v, gradients @ ..] = columns.each_ref().map(|c| &c[..count]);
        let gradients = Some(gradients);
        let out = out.each_mut().map(|c| &mut c[start..start + count]);
        sample_bound_soa(level, (along, &ramp), &Places { u, v, gradients }, out)?;
    }
    Ok(())
}

#[inline(never)]
fn dependent_columns<I: Isa>(i: I, view: &BoundTexture<'_>, at: &Places<'_>, out: [&mut [f32]; 6]) {
    let [ux, vx, uy, vy] = at.gradients.unwrap_or([&[0.0; PART][..at.u.len()]; 4]);
    in_vectors::<I, _, 6, 6>([at.u, at.v, ux, vx, uy, vy], out, |columns, mut out| {
        i.vectorize(
            #[inline(always)]
            || {
                let [u, v, ux, vx, uy, vy] = columns;
                for first in (0..u.len()).step_by(I::LANES) {
                    let first = vector_start::<I>(first, u.len());
                    let uv = [load(i, u, first), load(i, v, first)];
                    let d = [
                        load(i, ux, first),
                        load(i, vx, first),
                        load(i, uy, first),
                        load(i, vy, first),
                    ];
                    store_columns(i, dependent(i, view, uv, d), first, &mut out);
                }
            },
        );
    });
}

/// Coordinates in a second texture and their derivatives, in the order of [`Footprint`].
#[inline(always)]
fn dependent<I: Isa>(
    i: I,
    view: &BoundTexture<'_>,
    uv: [I::F32; 2],
    [ux, vx, uy, vy]: [I::F32; 4],
) -> [I::F32; 6] {
    let level = lod(i, view, &TexelFootprint::new(i, view, ux, vx, uy, vy));
    let [value, du, dv] = surface(i, view, uv, level);
    [
        value[0],
        value[1],
        du[0] * ux + dv[0] * vx,
        du[1] * ux + dv[1] * vx,
        du[0] * uy + dv[0] * vy,
        du[1] * uy + dv[1] * vy,
    ]
}

/// The bilinear surface of the level that is nearest to a limited level of detail: value, and derivatives by u and by v.
#[inline(always)]
fn surface<I: Isa>(i: I, view: &BoundTexture<'_>, uv: [I::F32; 2], lod: I::F32) -> [Color<I>; 3] {
    let last = i.f32(view.last as f32);
    let lod = lod.simd_gt(last).select(last, lod);
    let lod = lod.simd_gt(0.0).select(lod, i.f32(0.0));
    // Half way between two levels, the finer one.
    let number = i.i32(-1) - (-(lod + 0.5)).floor_to_i32();
    let level = LaneLevel::of(i, view, number);
    let [x, y] = level.scale(i, view, uv);
    let (at, [wx, wy]) = cell::<I>([x - 0.5, y - 0.5]);
    let corners = fetch_corners::<I, ANY>(i, view, &level, at);
    // No `map`: its closure is not always inlined.
    let [[a, b], [c, d]] = corners;
    let (a, b) = (scaled::<I>(a, view), scaled::<I>(b, view));
    let (c, d) = (scaled::<I>(c, view), scaled::<I>(d, view));
    let (w, h) = (level.width.to_f32(), level.height.to_f32());
    let mut out = [[i.f32(0.0); 4]; 3];
    for k in 0..4 {
        let (top, bottom) = (a[k] + (b[k] - a[k]) * wx, c[k] + (d[k] - c[k]) * wx);
        out[0][k] = top + (bottom - top) * wy;
        let (left, right) = (a[k] + (c[k] - a[k]) * wy, b[k] + (d[k] - b[k]) * wy);
        out[1][k] = (right - left) * w;
        out[2][k] = (bottom - top) * h;
    }
    out
}
