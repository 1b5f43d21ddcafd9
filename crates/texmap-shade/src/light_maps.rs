//! Textures of light: baked light, maps of the material's numbers, emitted light, and the ramp of diffuse light.

use texmap_math::color::luminance;
use texmap_math::simd::{Isa, Scalar};
use texmap_raster::BATCH_STRIDE;

use crate::Slot;
use crate::batch::{LANES, parts, straight};
use crate::stage::{Inputs, Kernel, ShadeColumns, Stage};
use crate::texture_set::MapSource;

/// Baked light, added to the diffuse light.
pub struct LightMap<'a> {
    /// The map of light that was baked.
    pub slot: &'a Slot<'a>,
    /// First attribute of its coordinates.
    pub uv: usize,
    /// A factor of its light.
    pub factor: f32,
}

impl Kernel for LightMap<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        let (level, batch) = (inputs.level, inputs.batch);
        let ShadeColumns { uv, texels, .. } = columns;
        let (wanted, changes) = ([self.uv, self.uv + 1], self.slot.reads_derivatives());
        let planes = inputs.planes;
        planes.values(level, batch.blocks, batch.list, &wanted, changes, uv);
        texels.fetch(level, self.slot, uv, batch.list.len());
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let light = columns.texels.straight(i, part.at);
            let mut sum = columns.diffuse.load(i, part.at);
            for k in 0..3 {
                sum[k] = sum[k] + light[k] * self.factor;
            }
            columns.diffuse.store(i, part.at, sum);
        }
    }
}

/// A texture instead of the color of the highlights.
pub struct SpecularMap<'a>(pub &'a Slot<'a>);

impl Kernel for SpecularMap<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        columns.fetch(inputs, self.0);
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let tint = columns.texels.straight(i, part.at);
            let mut sum = columns.highlight.load(i, part.at);
            for k in 0..3 {
                sum[k] = sum[k] * tint[k];
            }
            columns.highlight.store(i, part.at, sum);
        }
    }
}

/// A texture instead of the base color under ambient light. Its color multiplies neither the base color nor that of the highlights.
pub struct AmbientMap<'a> {
    /// The map of ambient light.
    pub slot: &'a Slot<'a>,
    /// The ambient lights, times the material's ambient reflectance.
    pub lights: Vec<[f32; 3]>,
}

impl Kernel for AmbientMap<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        columns.fetch(inputs, self.slot);
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let texel = columns.texels.straight(i, part.at);
            let mut sum = columns.highlight.load(i, part.at);
            for k in 0..3 {
                let mut ambient = i.f32(0.0);
                for light in &self.lights {
                    ambient = ambient + texel[k] * light[k];
                }
                sum[k] = sum[k] + ambient;
            }
            columns.highlight.store(i, part.at, sum);
        }
    }
}

/// Light that a surface emits.
pub struct Emission<'a> {
    /// Emitted light, linear.
    pub color: [f32; 3],
    /// A map that multiplies it.
    pub map: MapSource<'a>,
    /// True if emitted light is added to the highlights; else it is added to the colors, which have their light already.
    pub under_light: bool,
}

impl Kernel for Emission<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        if let MapSource::Own(slot) = self.map {
            columns.fetch(inputs, slot);
        }
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let at = part.at;
            let mut emitted = match self.map {
                MapSource::None => [i.f32(1.0); 3],
                MapSource::Own(_) => columns.texels.straight(i, at),
                MapSource::Set(number) => inputs.textures[number].opaque(i, at),
            };
            for (emitted, color) in emitted.iter_mut().zip(self.color) {
                *emitted = *emitted * color;
            }
            if self.under_light {
                let mut sum = columns.highlight.load(i, at);
                for k in 0..3 {
                    sum[k] = sum[k] + emitted[k];
                }
                columns.highlight.store(i, at, sum);
            } else {
                let mut sum = columns.color.load(i, at);
                for k in 0..3 {
                    sum[k] = sum[k] + emitted[k];
                }
                columns.color.store(i, at, sum);
            }
        }
    }
}

/// Diffuse light along a ramp by its luminance.
pub struct LightRamp<'a>(pub &'a Slot<'a>);

impl Stage for LightRamp<'_> {
    fn run(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        let count = inputs.batch.list.len() * LANES;
        let mut along = [0.0; BATCH_STRIDE];
        for (at, along) in along[..count].iter_mut().enumerate() {
            *along = luminance(columns.diffuse.get(at));
        }
        let texels = &mut columns.texels.colors;
        let out = texels.columns_mut(count);
        self.0.along(inputs.level, &along[..count], out);
        for at in 0..count {
            columns.diffuse.set(at, straight(Scalar, texels.get(at)));
        }
    }
}
