//! Metallic-roughness surfaces: their numbers by maps, and their light.

use texmap_light::lanes::{
    ClearcoatLanes, EnvironmentVisibilityLanes, MetallicRoughnessLanes, ReflectanceLanes,
    SheenLanes, Vector, dot, splat, unit,
};
use texmap_light::{
    EnvironmentLight, EnvironmentSample, LEAST_SAMPLE_COSINE, Light, ShadowSampler,
};
use texmap_math::simd::{Isa, prelude::*};

use crate::Slot;
use crate::base_color::BaseColor;
use crate::batch::{flip, load_vector, parts};
use crate::fetch::{PackedTexels, Texels};
use crate::lighting::{LitBy, visibility};
use crate::stage::{Inputs, Kernel, ShadeColumns};
use crate::texture_set::MapSource;
use texmap_scene::{MetallicRoughness, TextureSlot};

/// The maps of a model, by their number in [`MetallicStage::maps`].
const ROUGHNESS: usize = 0;
const OCCLUSION: usize = 1;
const SPECULAR: usize = 2;
const SPECULAR_COLOR: usize = 3;
const COAT: usize = 4;
const COAT_ROUGHNESS: usize = 5;
const SHEEN_COLOR: usize = 6;
const SHEEN_ROUGHNESS: usize = 7;
const TRANSMISSION: usize = 8;
/// Maps of a metallic-roughness model, in the order of [`slots`].
pub const METALLIC_MAPS: usize = 9;

/// The textures of a model in the order of the stage; no occlusion where it is the red channel of the first, which is
/// read once.
pub fn slots(model: &MetallicRoughness) -> [Option<&TextureSlot>; METALLIC_MAPS] {
    let (coat, sheen) = (model.clearcoat.as_ref(), model.sheen.as_ref());
    [
        model.map.as_ref(),
        occlusion(model).filter(|_| !shares_occlusion(model)),
        model.specular_map.as_ref(),
        model.specular_color_map.as_ref(),
        coat.and_then(|coat| coat.map.as_ref()),
        coat.and_then(|coat| coat.roughness_map.as_ref()),
        sheen.and_then(|sheen| sheen.color_map.as_ref()),
        sheen.and_then(|sheen| sheen.roughness_map.as_ref()),
        model.transmission.as_ref().and_then(|t| t.map.as_ref()),
    ]
}

/// True if the occlusion of a model is the red channel of its first map, which is read once.
fn shares_occlusion(model: &MetallicRoughness) -> bool {
    model.map.is_some() && model.map.as_ref() == occlusion(model)
}

fn occlusion(model: &MetallicRoughness) -> Option<&TextureSlot> {
    model.occlusion.as_ref().map(|(slot, _)| slot)
}

/// Texels of maps: those that the stage reads, and those of the set.
struct Read<'a> {
    own: &'a [Texels],
    set: &'a [PackedTexels],
}

/// The numbers of a metallic-roughness surface.
pub struct MetallicStage<'a> {
    pub(crate) model: &'a MetallicRoughness,
    pub(crate) maps: [MapSource<'a>; METALLIC_MAPS],
    /// Occlusion is the red channel of the first map, which is read once.
    pub(crate) shared_occlusion: bool,
    pub(crate) environment: Option<&'a EnvironmentLight>,
    /// Light passes the surface: it is blended, and its model transmits.
    pub(crate) transmits: bool,
}

impl<'a> MetallicStage<'a> {
    /// The model with its maps, in the order of [`slots`], and the environment that lights it. Light passes it where it is `blended`.
    pub fn new(
        model: &'a MetallicRoughness,
        maps: [MapSource<'a>; METALLIC_MAPS],
        environment: Option<&'a EnvironmentLight>,
        blended: bool,
    ) -> Self {
        Self {
            model,
            maps,
            shared_occlusion: shares_occlusion(model),
            environment,
            transmits: blended && model.transmission.is_some(),
        }
    }

    /// True if light passes the surface.
    pub fn transmits(&self) -> bool {
        self.transmits
    }

    /// The straight color of a map from pixel `at` on, if there is the map.
    #[inline(always)]
    fn texel<I: Isa>(&self, i: I, at: usize, read: &Read<'_>, map: usize) -> Option<Vector<I>> {
        match (self.maps[map], read.own.get(map)) {
            (MapSource::Set(number), _) => Some(read.set[number].opaque(i, at)),
            (MapSource::Own(_), Some(texels)) => Some(texels.straight(i, at)),
            _ => None,
        }
    }

    /// The alpha of a map, 1 without; maps of a set are opaque.
    #[inline(always)]
    fn alpha<I: Isa>(&self, i: I, at: usize, read: &Read<'_>, map: usize) -> I::F32 {
        match (self.maps[map], read.own.get(map)) {
            (MapSource::Own(_), Some(texels)) => texels.colors.load(i, at)[3],
            _ => i.f32(1.0),
        }
    }

    /// A factor times a channel of a map.
    #[inline(always)]
    fn factor<I: Isa>(
        &self,
        i: I,
        at: usize,
        read: &Read<'_>,
        (map, channel): (usize, usize),
        factor: f32,
    ) -> I::F32 {
        match self.texel(i, at, read, map) {
            Some(texel) => texel[channel] * factor,
            None => i.f32(factor),
        }
    }

    /// The surface from pixel `at` on, and the fraction of indirect light that reaches it.
    #[inline(always)]
    fn surface<I: Isa>(
        &self,
        i: I,
        at: usize,
        read: &Read<'_>,
        base_color: Vector<I>,
    ) -> (MetallicRoughnessLanes<I>, I::F32) {
        let (model, one) = (self.model, i.f32(1.0));
        let specular = self.alpha(i, at, read, SPECULAR) * model.specular;
        let tint = self.texel(i, at, read, SPECULAR_COLOR);
        let root = (model.ior - 1.0) / (model.ior + 1.0);
        let mut f0 = splat(i, model.specular_color.map(|c| c * root * root));
        for (k, f0) in f0.iter_mut().enumerate() {
            if let Some(tint) = tint {
                *f0 = *f0 * tint[k];
            }
            *f0 = f0.below(one) * specular;
        }
        let occluded = if self.shared_occlusion {
            ROUGHNESS
        } else {
            OCCLUSION
        };
        let share = match (&model.occlusion, self.texel(i, at, read, occluded)) {
            (Some((_, strength)), Some([r, ..])) => (r - one) * *strength + one,
            _ => one,
        };
        let surface = MetallicRoughnessLanes {
            base_color,
            metallic: self.factor(i, at, read, (ROUGHNESS, 2), model.metallic),
            roughness: self.factor(i, at, read, (ROUGHNESS, 1), model.roughness),
            f0,
            f90: specular,
            transmission: match &model.transmission {
                Some(sheet) if self.transmits => {
                    Some(self.factor(i, at, read, (TRANSMISSION, 0), sheet.factor))
                }
                _ => None,
            },
            clearcoat: match &model.clearcoat {
                Some(coat) => Some(ClearcoatLanes {
                    factor: self.factor(i, at, read, (COAT, 0), coat.factor),
                    roughness: self.factor(i, at, read, (COAT_ROUGHNESS, 1), coat.roughness),
                }),
                None => None,
            },
            sheen: match &model.sheen {
                Some(sheen) => {
                    let mut color = splat(i, sheen.color);
                    if let Some(texel) = self.texel(i, at, read, SHEEN_COLOR) {
                        for k in 0..3 {
                            color[k] = color[k] * texel[k];
                        }
                    }
                    Some(SheenLanes {
                        color,
                        roughness: self.alpha(i, at, read, SHEEN_ROUGHNESS) * sheen.roughness,
                    })
                }
                None => None,
            },
        };
        (surface, share)
    }
}

/// The light of a metallic-roughness surface: base colors become light, not clipped.
pub struct MetallicLight<'a> {
    /// Numbers and maps of the material.
    pub model: MetallicStage<'a>,
    /// The base color, where no stage has stored it: its texels are those of the set.
    pub paired: Option<BaseColor<'a>>,
    /// The lights in the order of the scene.
    pub lights: Vec<LitBy<'a>>,
    /// Samples of the environment and their shadow maps; empty if the environment casts no shadows.
    pub environment_shadows: &'a [(EnvironmentSample, ShadowSampler)],
    /// Factor and map of baked light, and the first attribute of its coordinates.
    pub light_map: Option<(f32, &'a Slot<'a>, usize)>,
    /// Normals are bent: the clear layer has those of the vertices.
    pub bent: bool,
}

impl Kernel for MetallicLight<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        let (level, batch) = (inputs.level, inputs.batch);
        let ShadeColumns {
            metallic,
            uv,
            texels,
            ..
        } = columns;
        metallic.resize_with(METALLIC_MAPS, Texels::default);
        for (slot, texels) in self.model.maps.iter().zip(metallic) {
            if let MapSource::Own(slot) = slot {
                texels.fetch(level, slot, inputs.uv_of(slot), batch.list.len());
            }
        }
        if let Some((_, slot, first)) = self.light_map {
            let (wanted, changes) = ([first, first + 1], slot.reads_derivatives());
            let planes = inputs.planes;
            planes.values(level, batch.blocks, batch.list, &wanted, changes, uv);
            texels.fetch(level, slot, uv, batch.list.len());
        }
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let at = part.at;
            let [r, g, b, alpha] = match &self.paired {
                Some(base) => {
                    let [r, g, b] = base.of_set(i, inputs, at);
                    [r, g, b, i.f32(1.0)]
                }
                None => columns.color.load(i, at),
            };
            let read = Read {
                own: &columns.metallic,
                set: inputs.textures,
            };
            let (surface, share) = self.model.surface(i, at, &read, [r, g, b]);
            let normal = columns.normal.load(i, at);
            let mut smooth = normal;
            if self.bent && surface.clearcoat.is_some() {
                let back = part.mask(i, inputs.sides.back[part.index]);
                smooth = unit(i, flip(i, back, load_vector(i, inputs.vectors.normal, at)));
            }
            let view = columns.toward_eye.load(i, at);
            let reflectance = ReflectanceLanes::new(i, &surface, normal, smooth, view);
            let point = match inputs.vectors.position {
                Some(position) => load_vector(i, position, at),
                None => [i.f32(0.0); 3],
            };
            let mut sum = splat(i, [0.0; 3]);
            if let Some(light) = self.model.environment {
                sum = match self.environment_shadows {
                    [] => environment(i, &reflectance, light, share, None),
                    shadows => {
                        let plane = inputs.sides.plane.load(i, at);
                        let lit = part.mask(i, part.block.mask);
                        let mut seen = visible(i, &reflectance, shadows, lit, point, plane);
                        for seen in &mut seen {
                            *seen = seen.below(share);
                        }
                        environment(i, &reflectance, light, i.f32(1.0), Some(seen))
                    }
                };
            }
            if let Some((factor, ..)) = self.light_map {
                let [r, g, b] = columns.texels.straight(i, at);
                let light = [r * factor, g * factor, b * factor];
                let baked = reflectance.under_irradiance(light);
                for k in 0..3 {
                    sum[k] = sum[k] + baked[k];
                }
            }
            for by in &self.lights {
                let Some(texel) = by.texel(i, inputs, &part) else {
                    continue;
                };
                let (light, lit) = contribution(i, &reflectance, &by.light, point);
                let lit = lit & part.mask(i, part.block.mask);
                if !lit.any_true() {
                    continue;
                }
                let received = if by.is_ambient() {
                    [share; 3]
                } else {
                    by.received(i, (inputs, at), texel, lit, point)
                };
                for k in 0..3 {
                    sum[k] = lit.select(sum[k] + light[k] * received[k], sum[k]);
                }
            }
            let [r, g, b] = sum;
            columns.color.store(i, at, [r, g, b, alpha]);
            if let Some(passing) = reflectance.transmitted() {
                columns.transmitted.store(i, at, [passing]);
            }
        }
    }
}

/// Out of line, as look-ups are much code.
#[inline(never)]
fn environment<I: Isa>(
    i: I,
    reflectance: &ReflectanceLanes<I>,
    light: &EnvironmentLight,
    share: I::F32,
    visible: Option<Vector<I>>,
) -> Vector<I> {
    i.vectorize(
        #[inline(always)]
        || reflectance.under_environment(i, light, share, visible),
    )
}

/// Fractions of the light of an environment that reach points past the scene. Out of line, as it is rare.
#[inline(never)]
fn visible<I: Isa>(
    i: I,
    reflectance: &ReflectanceLanes<I>,
    shadows: &[(EnvironmentSample, ShadowSampler)],
    lit: I::Mask,
    point: Vector<I>,
    plane: Vector<I>,
) -> Vector<I> {
    i.vectorize(
        #[inline(always)]
        || {
            let mut sum = EnvironmentVisibilityLanes::new(i);
            for (sample, shadow) in shadows {
                let above = dot(plane, splat(i, sample.direction)).simd_gt(LEAST_SAMPLE_COSINE);
                let mut weights = reflectance.sample_weights(i, sample);
                for weight in &mut weights {
                    *weight = above.select(*weight, i.f32(0.0));
                }
                let [a, b, c] = weights;
                let lit = lit & (a.simd_gt(0.0) | b.simd_gt(0.0) | c.simd_gt(0.0));
                if lit.any_true() {
                    sum.add(weights, visibility(i, shadow, lit, point, plane));
                }
            }
            sum.fractions(i)
        },
    )
}

/// Out of line, as lobes are much code.
#[inline(never)]
fn contribution<I: Isa>(
    i: I,
    reflectance: &ReflectanceLanes<I>,
    light: &Light,
    point: Vector<I>,
) -> (Vector<I>, I::Mask) {
    i.vectorize(
        #[inline(always)]
        || reflectance.under_light(i, light, point),
    )
}
