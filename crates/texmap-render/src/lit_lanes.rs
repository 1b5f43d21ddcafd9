//! Lighting and effects sixteen pixels at a time, for the surfaces whose stages all have lanes: the others go sample by sample, with
//! the same bits.

mod columns;
mod vectors;

use texmap_light::lanes::MirrorView;
use texmap_light::{Light, NormalMap, Power, ShadowReader, Surface as Numbers};
use texmap_math::Level;
use texmap_math::fearless_simd::prelude::*;
use texmap_raster::{RunBlock, RunValues, TilePlanes};

use crate::canvas::{Colors, LANES};
use crate::coordinates::{Coordinates, EyeRays};
use crate::lit::SurfaceEffects;
use crate::lit_texels::{
    BakedLookUp, BakedTexels, LookUpScratch, LookUps, SlideLookUp, SlideTexels, Texels,
};
use crate::plan::{LightStage, Plan, Surface};
use crate::ready::{Ready, Thrown};
use crate::relief::{ReliefStage, Space};
use crate::shade::Run;
use crate::textures::Slot;
use crate::{AlphaMode, TextureRole};
use columns::{Columns, Side};
use texmap_math::on_wide_level;
use vectors::{NORMAL, POSITION};

/// The stages of one surface; each is there only if the material or a light asks for it.
pub(crate) struct LitLanes<'a> {
    surface: &'a Surface<'a>,
    numbers: Numbers,
    power: Power,
    lights: Vec<Lamp<'a>>,
    relief: Option<(NormalMap, &'a Slot<'a>, Space)>,
    baked: Option<BakedLookUp<'a>>,
    mirror: Option<(MirrorView<'a>, f32)>,
    look_ups: LookUps<'a>,
    normal: usize,
    position: Option<usize>,
    /// Highlights or a relief's horizon ask for the direction to the eye.
    sees_eye: bool,
    /// Some light other than the slides' reaches every block, or a mirror does: all ask for the normal.
    turned: bool,
    /// Some shadow reads the normal of the triangle's plane.
    planes: bool,
    eye: [f32; 3],
    rays: EyeRays,
    level: Level,
}

/// A light, and what it loses on its way.
struct Lamp<'a> {
    light: Light,
    shadows: &'a [ShadowReader],
    slide: Option<(&'a Thrown<'a>, SlideLookUp<'a>)>,
}

/// Columns between the stages; a thread keeps them.
#[derive(Default)]
pub(crate) struct LitScratch {
    /// The columns of `vectors`.
    values: RunValues,
    look_ups: LookUpScratch,
    /// Base colour and normal map.
    texels: [Texels; 2],
    slides: Vec<SlideTexels>,
    baked: BakedTexels,
    /// Blocks that some slide reaches, and their places in the run.
    reached: Vec<RunBlock>,
    places: Vec<usize>,
}

impl<'a> LitLanes<'a> {
    /// `None` for a surface that has a stage without lanes, or a level without them.
    pub(crate) fn new(plan: &'a Plan<'a>, surface: &'a Surface<'a>) -> Option<Self> {
        let material = surface.material;
        let plain = surface.space.is_none()
            && surface.opacity_map.is_none()
            && surface.color_ramp.is_none()
            && surface.light_ramp.is_none()
            && surface.decal.is_none()
            && surface.carved.is_none()
            && surface.color.is_none()
            && !material.crisp
            && material.alpha == AlphaMode::Opaque
            && matches!(surface.light, LightStage::PerPixel);
        if !plain || !has_lanes(plan.level) {
            return None;
        }
        if let Some(slot) = &surface.base_color
            && (material.texture_role == TextureRole::Decal || !surface.solid || !fits(slot))
        {
            return None;
        }
        if !matches!(surface.uv, Coordinates::None | Coordinates::Vertices) {
            return None;
        }
        let mut this = Self {
            surface,
            numbers: material.surface,
            power: Power::new(material.surface.ns),
            lights: Vec::new(),
            relief: None,
            baked: None,
            mirror: None,
            look_ups: LookUps::new([None; 2]),
            normal: surface.normal?,
            position: surface.position.filter(|first| first + 3 <= surface.shaded),
            sees_eye: false,
            turned: false,
            planes: false,
            eye: plan.eye,
            rays: plan.rays,
            level: plan.level,
        };
        match &surface.effects {
            None => this.lights.extend(plan.lights.iter().map(|light| Lamp {
                light: *light,
                shadows: &[],
                slide: None,
            })),
            Some(effects) => this.take_effects(&plan.ready, effects)?,
        }
        if this.relief.is_some() && this.position.is_none() {
            return None;
        }
        let bumps = this.relief.as_ref().map(|(_, slot, _)| *slot);
        this.look_ups = LookUps::new([surface.base_color.as_ref(), bumps]);
        let mut shining = this.lights.iter().filter(|lamp| !lamp.is_ambient());
        this.turned = this.mirror.is_some() || shining.any(|lamp| lamp.slide.is_none());
        let shines = this.lights.iter().any(|lamp| !lamp.is_ambient());
        let clamps = this.relief.is_some() && material.horizon_clamp;
        this.sees_eye = (shines && material.surface.ks > 0.0) || clamps;
        let shades = this.lights.iter().flat_map(Lamp::shades);
        this.planes = shades.into_iter().any(ShadowReader::reads_normals);
        Some(this)
    }

    /// `None` where an effect has no lanes.
    fn take_effects(
        &mut self,
        ready: &'a Ready<'a>,
        effects: &'a SurfaceEffects<'a>,
    ) -> Option<()> {
        if effects.has_maps() || !ready.paints.is_empty() {
            return None;
        }
        self.relief = match effects.relief_stage() {
            None => None,
            Some(ReliefStage::NormalMap(slot, map, space)) if fits(slot) => {
                Some((*map, slot, *space))
            }
            Some(_) => return None,
        };
        self.baked = effects
            .baked()
            .map(|(share, slot, first)| BakedLookUp { share, slot, first });
        if let Some((environment, reflectivity)) = effects.reflection() {
            let view = MirrorView::new(&ready.environments[environment])?;
            self.mirror = Some((view, reflectivity));
        }
        let first_lamp = ready.lights.len() - ready.lamps.len();
        for (index, light) in effects.lights() {
            let slide = index.checked_sub(first_lamp).map(|i| &ready.lamps[i]);
            let leveled = slide.is_some_and(|slide| slide.reads_derivatives());
            let lamp = Lamp {
                light: *light,
                shadows: &ready.shadows[*index],
                slide: slide.map(|slide| (slide, SlideLookUp::new(&slide.view))),
            };
            if leveled || lamp.shades().any(|shade| !shade.has_lanes()) {
                return None;
            }
            self.lights.push(lamp);
        }
        Some(())
    }

    /// Shades a run: the colours of [`Stages::shade`](crate::shade::Stages::shade).
    pub(crate) fn shade(
        &self,
        planes: &TilePlanes,
        run: &Run<'_>,
        scratch: &mut LitScratch,
        out: &mut Colors,
    ) {
        let (level, list) = (self.level, run.run);
        let LitScratch {
            values,
            look_ups,
            texels,
            slides,
            baked,
            reached,
            places,
        } = scratch;
        if let Some(map) = &self.baked {
            map.run(level, planes, run.blocks, list, baked);
        }
        let thrown = || self.lights.iter().filter_map(|lamp| lamp.slide.as_ref());
        slides.resize_with(thrown().count(), SlideTexels::default);
        on_wide_level!(
            level,
            s => {
                self.look_ups.run(s, level, planes, run.blocks, list, look_ups, texels);
                let late = !self.turned && self.relief.is_none();
                if let (true, Some(first)) = (late, self.position) {
                    self.three(s, planes, run, [first, POSITION], list, &[], values);
                } else {
                    self.vectors(s, planes, run, values);
                }
                for ((_, slide), out) in thrown().zip(&mut *slides) {
                    let [x, y, z] = [0, 1, 2].map(|c| &values.columns[POSITION + c].value);
                    slide.run(s, level, list.len(), [x, y, z], out);
                }
                if late {
                    // Few blocks ask for a normal.
                    reached.clear();
                    places.clear();
                    for (i, at) in list.iter().enumerate() {
                        if slides.iter().any(|slide| slide.reaches(i)) {
                            reached.push(*at);
                            places.push(i);
                        }
                    }
                    self.three(s, planes, run, [self.normal, NORMAL], reached, places, values);
                }
                let columns = Columns { stage: self, run, values, texels, slides, baked };
                let mut side = Side::default();
                for (i, at) in list.iter().enumerate() {
                    self.look_aside(run, *at, &mut side);
                    let color = columns.block(s, i, *at, &side);
                    for (to, c) in out.0.iter_mut().zip(color) {
                        c.store_slice(&mut to[i * LANES..(i + 1) * LANES]);
                    }
                }
            },
            else {}
        );
    }
}

impl Lamp<'_> {
    /// Whether it shines on all normals alike.
    fn is_ambient(&self) -> bool {
        matches!(self.light, Light::Ambient { .. })
    }

    /// Every map that its light passes.
    fn shades(&self) -> impl Iterator<Item = &ShadowReader> {
        let slide = self.slide.as_ref();
        let of_slide = slide.and_then(|(slide, _)| slide.shade.as_ref());
        self.shadows.iter().chain(of_slide)
    }
}

/// Whether a slot reads the coordinates of the mesh as they are.
fn fits(slot: &Slot<'_>) -> bool {
    !slot.is_transformed() && !slot.can_be_transparent()
}

fn has_lanes(level: Level) -> bool {
    on_wide_level!(level, s => { let _ = s; true }, else false)
}
