//! Normal detail: normal maps and procedural bumps turn the normals of the vertices. (Bump and offset maps: [`slopes`](crate::slopes).)
//!
//! Relief belongs to the front of a surface: a bump of the front is a dent of the back, as on a sheet of metal.

use texmap_light::lanes::{Vector, clamp_to_horizon, unit};
use texmap_light::{NormalMap, NormalMapGreen};
use texmap_math::glam::DMat3;
use texmap_math::simd::{Isa, prelude::*};

use crate::Slot;
use crate::batch::{flip, load, load_changes, load_vector, parts};
use crate::procedural::ProceduralBump;
use crate::slopes::Rise;
use crate::stage::{Inputs, Kernel, ShadeColumns};
use crate::texture_set::NORMAL;

/// The normal detail of a surface.
pub enum NormalSource<'s> {
    /// A height map.
    Bump(Slot<'s>, Rise),
    /// A map of slopes.
    Offsets(Slot<'s>, Rise, NormalMapGreen),
    /// Heights of a procedure.
    Procedural(ProceduralBump),
    /// Normals of a map.
    Map(Slot<'s>, NormalMap, NormalSpace),
}

/// The space of the vectors of a normal map.
#[derive(Clone, Copy)]
pub enum NormalSpace {
    /// The object; normals go to the world by this.
    Object(DMat3),
    /// Tangent frames, which are attributes from here on.
    Tangent(usize),
}

impl NormalSource<'_> {
    /// First attribute of the tangent frames.
    pub fn tangent(&self) -> Option<usize> {
        match self {
            Self::Map(_, _, NormalSpace::Tangent(first)) => Some(*first),
            _ => None,
        }
    }
}

/// Normals by a normal map.
pub struct MappedNormals<'a> {
    /// `None` if the texels are those of the set: see [`TextureSet`](crate::texture_set::TextureSet).
    pub slot: Option<&'a Slot<'a>>,
    /// Scale and conventions of its texels.
    pub map: NormalMap,
    /// The frame of its normals.
    pub space: NormalSpace,
    /// Normals turned away from the eye are brought back to the horizon.
    pub horizon_clamp: bool,
}

impl Kernel for MappedNormals<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        if let Some(slot) = self.slot {
            columns.fetch(inputs, slot);
        }
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.reached) {
            let at = part.at;
            let texel = match self.slot {
                Some(_) => columns.texels.straight(i, at),
                None => inputs.textures[NORMAL].opaque(i, at),
            };
            let back = part.mask(i, inputs.sides.back[part.index]);
            let normal = match &self.space {
                NormalSpace::Object(to_world) => {
                    unit(i, transform(i, to_world, self.map.decode(i, texel)))
                }
                NormalSpace::Tangent(_) => {
                    let [x, y, z, w] = inputs.vectors.tangent;
                    let tangent = [
                        load(i, &x.value, at),
                        load(i, &y.value, at),
                        load(i, &z.value, at),
                    ];
                    let sign = load(i, &w.value, at);
                    let sign = sign.simd_lt(0.0).select(i.f32(-1.0), i.f32(1.0));
                    let front = front_normal(i, back, at, columns);
                    self.map.apply(i, front, tangent, sign, texel)
                }
            };
            store_normal(i, self.horizon_clamp, back, at, normal, columns);
        }
    }
}

/// Normals by a formula of heights in space.
pub struct BumpedNormals<'a> {
    /// The heights.
    pub bump: &'a ProceduralBump,
    /// Normals turned away from the eye are brought back to the horizon.
    pub horizon_clamp: bool,
}

impl Kernel for BumpedNormals<'_> {
    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.reached) {
            let back = part.mask(i, inputs.sides.back[part.index]);
            let mut normal = front_normal(i, back, part.at, columns);
            if let Some(position) = inputs.vectors.position {
                let (point, changes) = (
                    load_vector(i, position, part.at),
                    load_changes(i, position, part.at),
                );
                normal = self.bump.normal(i, point, changes, normal);
            }
            store_normal(i, self.horizon_clamp, back, part.at, normal, columns);
        }
    }
}

/// The smooth normals of the front, whichever side is seen.
#[inline(always)]
pub(super) fn front_normal<I: Isa>(
    i: I,
    back: I::Mask,
    at: usize,
    columns: &ShadeColumns,
) -> Vector<I> {
    flip(i, back, columns.normal.load(i, at))
}

/// Stores normals of the front on the side that is seen, brought back to the horizon if that is asked for.
#[inline(always)]
pub(super) fn store_normal<I: Isa>(
    i: I,
    horizon_clamp: bool,
    back: I::Mask,
    at: usize,
    front: Vector<I>,
    columns: &mut ShadeColumns,
) {
    let mut normal = flip(i, back, front);
    if horizon_clamp {
        normal = clamp_to_horizon(i, normal, columns.toward_eye.load(i, at));
    }
    columns.normal.store(i, at, normal);
}

/// A matrix times vectors, in f64.
#[inline(always)]
fn transform<I: Isa>(i: I, matrix: &DMat3, v: Vector<I>) -> Vector<I> {
    let [x, y, z] = [i.widen(v[0]), i.widen(v[1]), i.widen(v[2])];
    let mut out = v;
    for (k, out) in out.iter_mut().enumerate() {
        let (a, b, c) = (matrix.x_axis[k], matrix.y_axis[k], matrix.z_axis[k]);
        *out = i.narrow(x * a + y * b + z * c);
    }
    out
}
