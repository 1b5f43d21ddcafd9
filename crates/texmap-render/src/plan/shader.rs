//! The stages that run on the fragments of a surface, and their inputs: the one module that knows all stages.

use texmap_light::{Light, ShadowSampler, SpecularExponent};

use super::effects::{AMBIENT, EXPONENT, MAPS, REFLECTIVITY, SPECULAR, SurfaceEffects};
use super::maps::{SurfaceMaps, fits};
use super::{Plan, Space, Surface};
use crate::frame_resources::FrameResources;
use texmap_scene::{AlphaMode, Material, MetallicRoughness, TextureRole};
use texmap_shade::Slot;
use texmap_shade::base_color::{BaseColor, BaseColors, BaseStage};
use texmap_shade::compose::{Compose, Display};
use texmap_shade::cover::{Cover, Projection};
use texmap_shade::environment::Reflection;
use texmap_shade::facing::FacingStage;
use texmap_shade::light_maps::{AmbientMap, Emission, LightMap, LightRamp, SpecularMap};
use texmap_shade::lighting::{LightStage, LitBy, PhongLights, VertexTerms};
use texmap_shade::metallic::{MetallicLight, MetallicStage};
use texmap_shade::normal::{BumpedNormals, MappedNormals, NormalSource};
use texmap_shade::paint::Paint;
use texmap_shade::projector::ProjectorStage;
use texmap_shade::sky::SkyStage;
use texmap_shade::slopes::SlopeMap;
use texmap_shade::stage::Stage;
use texmap_shade::surface::SurfaceShader;
use texmap_shade::texture_set::TextureSet;
use texmap_shade::unlit::Unlit;
use texmap_shade::vectors::{SmoothNormals, VectorReader};
use texmap_shade::volume::VolumeStage;

/// The stages of a draw.
pub(crate) enum Shader<'a> {
    Unlit(Box<Unlit<'a>>),
    Surface(Box<SurfaceShader<'a>>),
    Sky(&'a SkyStage<'a>),
    Volume(&'a VolumeStage<'a>),
}

impl<'a> Shader<'a> {
    pub(crate) fn new(plan: &'a Plan<'a>, surface: &'a Surface<'a>) -> Self {
        match (&surface.space, surface.unlit) {
            (Some(Space::Sky(stage)), _) => Self::Sky(stage),
            (Some(Space::Volume(stage)), _) => Self::Volume(stage),
            (None, Some(color)) => {
                let slot = surface.base_color.as_ref();
                Self::Unlit(Box::new(Unlit::new(color, slot)))
            }
            (None, None) => Self::Surface(Box::new(surface_shader(plan, surface))),
        }
    }

    /// The one stage of an unlit surface.
    pub(crate) fn unlit(&self) -> Option<&Unlit<'a>> {
        match self {
            Self::Unlit(unlit) => Some(unlit),
            _ => None,
        }
    }
}

type Stages<'a> = Vec<Box<dyn Stage + 'a>>;

fn surface_shader<'a>(plan: &'a Plan<'a>, surface: &'a Surface<'a>) -> SurfaceShader<'a> {
    let (ready, material) = (&*plan.ready, surface.material);
    let per_pixel = matches!(surface.light, LightStage::PerPixel);
    let effects = surface.effects.as_deref().filter(|_| per_pixel);
    let covers = surface.base_color.is_some() && material.texture_role == TextureRole::Decal;
    let position = surface.position.filter(|first| first + 3 <= surface.shaded);

    let detail = effects.and_then(|effects| effects.normal.as_ref());
    let normal_map = match detail {
        Some(NormalSource::Map(slot, ..)) if fits(surface, slot) => Some(slot),
        _ => None,
    };
    let base = base_color(surface, covers);
    let mut lights = match (per_pixel, effects) {
        (false, _) => Vec::new(),
        (true, None) => plan.lights.iter().map(unshadowed).collect(),
        (true, Some(effects)) => lights(ready, effects),
    };
    if covers && hides_surface(&base) {
        // The lights of the scene do not reach texels that cover.
        lights.retain(|by| by.projector.is_some());
    }
    let paints = ready.projector_decals.iter();
    let paints = paints.filter(|_| effects.is_some() && position.is_some());
    let paint = Paint {
        projectors: paints.collect(),
        first: lights.iter().filter(|by| by.projector.is_some()).count(),
    };
    let of_lights = lights.iter().filter_map(|by| by.projector);
    let projectors = of_lights.map(|(projected, _)| projected);
    let projectors = projectors.chain(paint.projectors.iter().copied());
    let projectors = projectors.map(ProjectorStage::new).collect();

    let mut shadow_maps = lights.iter().flat_map(LitBy::shadow_maps);
    let by_shadows = shadow_maps.any(ShadowSampler::reads_normals);
    drop(shadow_maps);
    // Paint does not reach surfaces that face away from its projector.
    let metallic = per_pixel && material.metallic_roughness.is_some();
    let by_sky = metallic && !ready.environment_shadows.0.is_empty();
    let reads_planes = by_shadows || by_sky || !paint.projectors.is_empty();
    let reflects = effects.is_some()
        && !metallic
        && (material.reflection.is_some() || material.specular_map.is_some());
    let lights_all = |by: &LitBy<'_>| !by.is_ambient() && by.projector.is_none();
    let maps = effects.map_or([None; MAPS], |effects| {
        effects.maps.each_ref().map(Option::as_ref)
    });
    let mut sources = SurfaceMaps::new([base.texture.filter(|_| base.paired), normal_map]);
    if !(covers && hides_surface(&base)) {
        sources = sources.with_others(surface, effects);
    }
    let short = per_pixel
        && !sources.some_own()
        && base.paired
        && (detail.is_none() || normal_map.is_some())
        && maps.iter().all(Option::is_none)
        && surface.light_ramp.is_none()
        && (effects.is_none() || material.specular_map.is_none())
        && paint.projectors.is_empty();
    let by_map = |detail: &NormalSource<'_>| !matches!(detail, NormalSource::Procedural(_));
    let reads_uv = sources.some_own()
        || base.reads_uv()
        || (detail.is_some_and(by_map) && normal_map.is_none())
        || maps.iter().any(Option::is_some);

    SurfaceShader {
        level: plan.level,
        uv: reads_uv.then_some(&surface.uv),
        second_uv: surface.second_uv,
        textures: TextureSet::new(sources.set),
        vectors: VectorReader {
            normal: surface.normal,
            position,
            tangent: detail.and_then(NormalSource::tangent),
            in_values: !short,
            normal_everywhere: reflects || metallic || lights.iter().any(lights_all),
            normal_changes: reflects,
        },
        facing: per_pixel.then(|| FacingStage {
            cull: material.cull,
            planes: effects
                .filter(|_| reads_planes)
                .map(|effects| &effects.planes[..]),
        }),
        projectors,
        stages: stages(
            plan,
            surface,
            base,
            (covers, normal_map.is_some()),
            (maps, sources),
            lights,
            paint,
        ),
        attributes: (!short).then_some(surface.shaded),
    }
}

/// The stages after the vectors and the texels that several of them read.
fn stages<'a>(
    plan: &'a Plan<'a>,
    surface: &'a Surface<'a>,
    base: BaseColor<'a>,
    (covers, paired_normals): (bool, bool),
    (maps, sources): ([Option<&'a Slot<'a>>; MAPS], SurfaceMaps<'a>),
    lights: Vec<LitBy<'a>>,
    paint: Paint<'a>,
) -> Stages<'a> {
    let mut out: Stages<'a> = Vec::new();
    let display = Display::new(plan.tone_mapping);
    let limit = plan.tone_mapping.map.limit();
    let covering = covers.then(|| covering(display, &lights, &paint));
    if covers && hides_surface(&base) {
        if !lights.is_empty() {
            normals(&mut out, plan, surface, &lights, paired_normals);
        }
        cover(&mut out, surface.material, base, maps, covering, limit);
        return out;
    }
    let lit = match surface.light {
        LightStage::None | LightStage::Colors(_) => false,
        LightStage::Terms { diffuse, highlight } => {
            out.push(Box::new(VertexTerms { diffuse, highlight }));
            true
        }
        LightStage::PerPixel => {
            normals(&mut out, plan, surface, &lights, paired_normals);
            if let Some(model) = &surface.material.metallic_roughness {
                let colors = if covers {
                    BaseColors::Material
                } else {
                    BaseColors::Own
                };
                metallic(
                    &mut out,
                    plan,
                    surface,
                    (model, base, colors),
                    sources,
                    lights,
                    paint,
                );
                cover(&mut out, surface.material, base, maps, covering, limit);
                return out;
            }
            light(&mut out, plan, surface, maps, lights);
            true
        }
    };
    if let Some(ramp) = surface.light_ramp.as_ref().filter(|_| lit) {
        out.push(Box::new(LightRamp(ramp)));
    }
    let mut colors = match surface.light {
        LightStage::Colors(first) => BaseColors::Finished(first),
        _ => BaseColors::Own,
    };
    if covers && colors == BaseColors::Own {
        colors = BaseColors::Material;
    }
    let paired = base.paired && lit && paint.projectors.is_empty();
    if !paired {
        out.push(Box::new(BaseStage { base, colors }));
    }
    if let Some((color, _)) = &surface.emission {
        out.push(Box::new(Emission {
            color: *color,
            map: sources.emission,
            under_light: lit,
        }));
    }
    if lit && !paint.projectors.is_empty() {
        out.push(Box::new(paint));
    }
    out.push(Box::new(Compose {
        paired: paired.then_some(base),
        lit,
        transmits: false,
        display: match surface.light {
            LightStage::None => Display::Clipped(limit),
            // Finished colors are clipped at the vertices.
            LightStage::Colors(_)
                if surface.emission.is_none() && matches!(display, Display::Clipped(_)) =>
            {
                Display::Done
            }
            _ => display,
        },
    }));
    cover(&mut out, surface.material, base, maps, covering, limit);
    out
}

/// True if the texels that cover a surface leave nothing of it.
fn hides_surface(base: &BaseColor<'_>) -> bool {
    base.alpha != AlphaMode::Opaque || (base.opaque_texels && base.decal.is_none())
}

/// The projectors on texels that cover a surface, and those of its lights that project.
fn covering<'a>(
    display: Display,
    lights: &[LitBy<'a>],
    paint: &Paint<'a>,
) -> (Vec<LitBy<'a>>, Option<Projection<'a>>) {
    let lights = lights.iter().filter(|by| by.projector.is_some());
    let lights: Vec<_> = lights.copied().collect();
    let light = (!lights.is_empty()).then_some(display);
    let some = light.is_some() || !paint.projectors.is_empty();
    let projection = some.then(|| Projection {
        paint: paint.clone(),
        light,
    });
    (lights, projection)
}

/// Texels over the surface, with the projectors on them.
fn cover<'a>(
    out: &mut Stages<'a>,
    material: &'a Material,
    base: BaseColor<'a>,
    mut maps: [Option<&'a Slot<'a>>; MAPS],
    covering: Option<(Vec<LitBy<'a>>, Option<Projection<'a>>)>,
    limit: f32,
) {
    let Some((lights, projected)) = covering else {
        return;
    };
    if !lights.is_empty() {
        maps[AMBIENT] = None;
        phong_lights(out, material, maps, lights);
    }
    out.push(Box::new(Cover {
        base,
        projected,
        limit,
    }));
}

/// The light of a metallic-roughness surface and its final colors.
fn metallic<'a>(
    out: &mut Stages<'a>,
    plan: &'a Plan<'a>,
    surface: &'a Surface<'a>,
    (model, base, colors): (&'a MetallicRoughness, BaseColor<'a>, BaseColors),
    sources: SurfaceMaps<'a>,
    lights: Vec<LitBy<'a>>,
    paint: Paint<'a>,
) {
    let effects = surface.effects.as_deref();
    let paired = base.paired && paint.projectors.is_empty();
    if !paired {
        out.push(Box::new(BaseStage { base, colors }));
    }
    if !paint.projectors.is_empty() {
        out.push(Box::new(paint));
    }
    let light_map = effects.and_then(|effects| effects.light_map.as_ref());
    let blended = surface.material.alpha == AlphaMode::Blend;
    let light = plan.environment_light;
    let model = MetallicStage::new(model, sources.metallic, light, blended);
    let transmits = model.transmits();
    out.push(Box::new(MetallicLight {
        model,
        paired: paired.then_some(base),
        lights,
        environment_shadows: &plan.ready.environment_shadows.0,
        light_map: light_map.map(|(map, slot, uv)| (map.scale, slot, *uv)),
        bent: effects.is_some_and(|effects| effects.normal.is_some()),
    }));
    if let Some((color, _)) = &surface.emission {
        out.push(Box::new(Emission {
            color: *color,
            map: sources.emission,
            under_light: false,
        }));
    }
    out.push(Box::new(Compose {
        paired: None,
        lit: false,
        transmits,
        display: Display::new(plan.tone_mapping),
    }));
}

/// Normals, and the directions to the eye that they or the highlights ask for.
fn normals<'a>(
    out: &mut Stages<'a>,
    plan: &Plan<'_>,
    surface: &'a Surface<'a>,
    lights: &[LitBy<'_>],
    paired: bool,
) {
    let (material, effects) = (surface.material, surface.effects.as_deref());
    let detail = effects.and_then(|effects| effects.normal.as_ref());
    let horizon_clamp = material.horizon_clamp;
    let shines = lights.iter().any(|by| !by.is_ambient()) && material.phong.ks > 0.0;
    let sees_eye =
        shines || material.metallic_roughness.is_some() || (detail.is_some() && horizon_clamp);
    out.push(Box::new(SmoothNormals {
        eye: sees_eye.then_some(plan.eye),
    }));
    let slopes = |slot, rise: &_, slopes| SlopeMap {
        slot,
        rise: *rise,
        slopes,
        horizon_clamp,
    };
    out.push(match detail {
        None => return,
        Some(NormalSource::Bump(slot, rise)) => Box::new(slopes(slot, rise, None)),
        Some(NormalSource::Offsets(slot, rise, green)) => {
            Box::new(slopes(slot, rise, Some(*green)))
        }
        Some(NormalSource::Procedural(bump)) => Box::new(BumpedNormals {
            bump,
            horizon_clamp,
        }),
        Some(NormalSource::Map(slot, map, space)) => Box::new(MappedNormals {
            slot: (!paired).then_some(slot),
            map: *map,
            space: *space,
            horizon_clamp,
        }),
    });
}

/// The light of a surface that is lit per pixel. Another model of light replaces [`phong_lights`].
fn light<'a>(
    out: &mut Stages<'a>,
    plan: &'a Plan<'a>,
    surface: &'a Surface<'a>,
    maps: [Option<&'a Slot<'a>>; MAPS],
    lights: Vec<LitBy<'a>>,
) {
    let material = surface.material;
    phong_lights(out, material, maps, lights);
    let Some(effects) = surface.effects.as_deref() else {
        return;
    };
    if let Some((map, slot, uv)) = &effects.light_map {
        let (uv, factor) = (*uv, material.phong.kd * map.scale);
        out.push(Box::new(LightMap { slot, uv, factor }));
    }
    let mut reflect = |index: usize, share, map, within| {
        out.push(Box::new(Reflection {
            environment: &plan.ready.environments[index],
            share,
            map,
            within,
            rays: plan.rays,
        }));
    };
    if let Some(r) = material.reflection {
        reflect(r.environment, r.reflectivity, maps[REFLECTIVITY], r.within);
    }
    if let Some(index) = material.specular_map {
        reflect(index, material.phong.ks, None, None);
    }
}

/// Lights by Phong's terms, and the maps of their numbers.
fn phong_lights<'a>(
    out: &mut Stages<'a>,
    material: &'a Material,
    maps: [Option<&'a Slot<'a>>; MAPS],
    lights: Vec<LitBy<'a>>,
) {
    let numbers = material.phong;
    // Ambient light of an ambient map is a term of its own.
    let apart = |by: &LitBy<'_>| maps[AMBIENT].is_some() && by.is_ambient();
    let (ambient, lights): (Vec<_>, Vec<_>) = lights.into_iter().partition(apart);
    out.push(Box::new(PhongLights {
        numbers,
        power: SpecularExponent::new(numbers.ns),
        exponents: maps[EXPONENT],
        model: material.specular_model,
        lights,
    }));
    if let Some(slot) = maps[SPECULAR] {
        out.push(Box::new(SpecularMap(slot)));
    }
    if let Some(slot) = maps[AMBIENT] {
        let color = |by: &LitBy<'_>| match by.light {
            Light::Ambient { color } => Some(color.map(|c| c * numbers.ka)),
            _ => None,
        };
        let lights = ambient.iter().filter_map(color).collect();
        out.push(Box::new(AmbientMap { slot, lights }));
    }
}

fn base_color<'a>(surface: &'a Surface<'a>, covers: bool) -> BaseColor<'a> {
    let material = surface.material;
    let texture = surface.base_color.as_ref();
    let mut base = BaseColor {
        color: material.phong.color,
        texture,
        paired: false,
        opaque_texels: surface.solid,
        ramp: surface.color_ramp.as_ref(),
        antialiased: material.antialiased_alpha,
        solid: surface.carved.as_ref(),
        decal: surface.decal.as_ref(),
        opacity_map: surface.opacity_map.as_ref(),
        vertex_color: surface.color,
        alpha: material.alpha,
        opacity: material.opacity,
    };
    base.paired = !covers
        && base.alpha == AlphaMode::Opaque
        && base.opacity_map.is_none()
        && base.vertex_color.is_none()
        && base.ramp.is_none()
        && !base.antialiased
        && base.solid.is_none()
        && base.decal.is_none()
        && texture.is_none_or(|slot| fits(surface, slot));
    base
}

fn unshadowed<'a>(light: &Light) -> LitBy<'a> {
    LitBy {
        light: *light,
        shadows: &[],
        projector: None,
    }
}

/// The lights of a surface, their shadow maps and projectors.
fn lights<'a>(ready: &'a FrameResources<'a>, effects: &'a SurfaceEffects<'a>) -> Vec<LitBy<'a>> {
    let first_projector = ready.lights.len() - ready.projector_lights.len();
    let mut numbers = 0..;
    let lights = effects.lights.iter().map(|(index, light)| {
        let projected = index
            .checked_sub(first_projector)
            .map(|k| &ready.projector_lights[k]);
        LitBy {
            light: *light,
            shadows: &ready.shadows[*index],
            projector: projected.and_then(|projected| Some((projected, numbers.next()?))),
        }
    });
    lights.collect()
}
