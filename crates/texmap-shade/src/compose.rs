//! Final colors: the base color under its light.

use texmap_light::lanes::Vector;
use texmap_math::simd::{Isa, prelude::*};
use texmap_scene::ToneMapping;

use crate::base_color::BaseColor;
use crate::batch::parts;
use crate::stage::{Inputs, Kernel, ShadeColumns};

/// Premultiplied colors from base colors and their light.
pub struct Compose<'a> {
    /// The base color, where no stage has stored it: its texels are those of the set.
    pub paired: Option<BaseColor<'a>>,
    /// `base * diffuse + highlight`; else the colors have their light already.
    pub lit: bool,
    /// A part of the light from behind passes: it is not covered, and what the surface reflects does not fade with it.
    pub transmits: bool,
    /// Tone mapping of the sum.
    pub display: Display,
}

/// The way from the light of a surface to display light.
#[derive(Clone, Copy, PartialEq)]
pub enum Display {
    /// Light is display light as it is.
    Done,
    /// Clipped at this value: 1, or the [limit](texmap_light::ToneMap::limit) of light that is not clipped.
    Clipped(f32),
    /// Exposed and mapped light.
    Mapped(ToneMapping),
}

impl Display {
    /// No more than a clip for the identity.
    pub fn new(mapping: ToneMapping) -> Self {
        if mapping.is_identity() {
            Self::Clipped(mapping.map.limit())
        } else {
            Self::Mapped(mapping)
        }
    }

    #[inline(always)]
    pub(crate) fn of<I: Isa>(self, i: I, light: Vector<I>) -> Vector<I> {
        match self {
            Self::Done => light,
            Self::Clipped(limit) => {
                let (limit, [r, g, b]) = (i.f32(limit), light);
                [r.below(limit), g.below(limit), b.below(limit)]
            }
            Self::Mapped(mapping) => mapped(i, mapping, light),
        }
    }
}

/// Out of line: most scenes have no curve.
#[inline(never)]
fn mapped<I: Isa>(i: I, mapping: ToneMapping, light: Vector<I>) -> Vector<I> {
    i.vectorize(
        #[inline(always)]
        || mapping.map.apply_lanes(i, mapping.exposure, light),
    )
}

impl Kernel for Compose<'_> {
    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let (at, one) = (part.at, i.f32(1.0));
            let [r, g, b, alpha] = match &self.paired {
                Some(base) => {
                    let [r, g, b] = base.of_set(i, inputs, at);
                    [r, g, b, one]
                }
                None => columns.color.load(i, at),
            };
            let mut color = [r, g, b];
            if self.lit {
                let (diffuse, highlight) =
                    (columns.diffuse.load(i, at), columns.highlight.load(i, at));
                for k in 0..3 {
                    color[k] = color[k] * diffuse[k] + highlight[k];
                }
            }
            let [r, g, b] = self.display.of(i, color);
            let covered = if self.transmits {
                let [passing] = columns.transmitted.load(i, at);
                alpha * (one - passing)
            } else {
                alpha
            };
            let color = [r * alpha, g * alpha, b * alpha, covered];
            columns.color.store(i, at, color);
        }
    }
}
