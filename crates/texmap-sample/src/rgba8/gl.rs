//! OpenGL's choices of texels and levels with weights of a byte.

use super::{bilinear::bilinear_in, nearest::nearest_in};
use crate::{
    address::texel::LaneLevel,
    bound_texture::BoundTexture,
    filter::{ByteKernel, LookUp},
    sampler::{Mip, TexelFilter},
};
use texmap_math::simd::{ByteIsa, prelude::*};

pub(crate) struct Gl;

impl ByteKernel for Gl {
    const WIDE: bool = false;

    #[inline(always)]
    fn word<I: ByteIsa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>) -> I::U32 {
        let (mag, min, mip) = view.gl;
        let zero = i.i32(0);
        let lod = at.fixed_lod(i, view);
        let magnified = lod.simd_le(0);
        let (last, top) = (i.i32(view.last), i.i32(view.last << 8));
        let lod = lod.simd_gt(top).select(top, lod);
        let lod = magnified.select(zero, lod);
        let (fine, weight) = match mip {
            Mip::None => (zero, zero),
            // ceil(lod + 1/2) - 1: halves go to the finer level.
            Mip::Nearest => ((lod + 127) >> 8, zero),
            Mip::Linear => (lod >> 8, lod & 255),
        };
        // One place in the code for all that may be read.
        let reads = [
            (magnified.any_true(), mag, zero),
            (!magnified.all_true(), min, fine),
            (weight.simd_gt(0).any_true(), min, (fine + 1).min(last)),
        ];
        let mut texels = [i.u32(0); 3];
        for (to, (wanted, texel, level)) in texels.iter_mut().zip(&reads) {
            if *wanted {
                let level = LaneLevel::of(i, view, *level);
                *to = match texel {
                    TexelFilter::Nearest => nearest_in(i, view, &level, at.uv),
                    TexelFilter::Linear => i.words(bilinear_in(i, view, &level, at.uv)),
                };
            }
        }
        let [near, fine, coarse] = texels;
        let far = i.lerp_bytes(i.bytes(fine), i.bytes(coarse), i.weights(weight));
        magnified.select(near, i.words(far))
    }
}
