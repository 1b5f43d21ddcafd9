//! Lighting and effects sixteen pixels at a time. A surface whose stages all read columns of their own takes the short way; another
//! reads all its attributes first, and what has no lanes goes pixel by pixel between the stages that have: the bits are those of
//! [`Stages`] either way.

mod banded;
mod columns;
mod ground;
mod side;
mod vectors;

use texmap_light::{Environment, Light, NormalMap, Power, ShadowReader, Surface as Numbers};
use texmap_math::Level;
use texmap_math::fearless_simd::prelude::*;
use texmap_math::on_wide_level;
use texmap_raster::{RunBlock, RunValues, TilePlanes};

use crate::canvas::{Colors, LANES};
use crate::carved::Carved;
use crate::coordinates::{Coordinates, EyeRays};
use crate::lit::SurfaceEffects;
use crate::lit_texels::{LookUpScratch, LookUps, MapTexels, SlideLookUp, SlideTexels, Texels};
use crate::plan::{LightStage, Plan, Surface};
use crate::ready::{Ready, Thrown};
use crate::relief::{ReliefStage, SlopeTexels, Space};
use crate::shade::{Run, Stages};
use crate::textures::Slot;
use columns::Columns;
use ground::Ground;
use side::Side;
use texmap_scene::TextureRole;
use vectors::{NORMAL, POSITION, TANGENT};

/// The stages of one surface; each is there only if the material or a light asks for it.
pub(crate) struct LitLanes<'a> {
    surface: &'a Surface<'a>,
    ready: &'a Ready<'a>,
    numbers: Numbers,
    power: Power,
    lights: Vec<Lamp<'a>>,
    ground: Ground<'a>,
    relief: Relief<'a>,
    /// Baked light: what multiplies its texels, its map, and the first attribute of the coordinates.
    baked: Option<(f32, &'a Slot<'a>, usize)>,
    /// Paint, the later over the earlier.
    paints: Vec<Cast<'a>>,
    mirror: Option<(&'a Environment, f32)>,
    /// The environment that gives highlights.
    specular: Option<&'a Environment>,
    /// Textures in place of numbers, by [`SurfaceEffects::maps`].
    maps: [Option<&'a Slot<'a>>; MAPS],
    look_ups: LookUps<'a>,
    /// All attributes are read before the first stage.
    reads_all: bool,
    /// First columns of normals, positions and tangents.
    normal: usize,
    position: Option<usize>,
    tangent: usize,
    /// Highlights or a relief's horizon ask for the direction to the eye.
    sees_eye: bool,
    /// Some light other than the slides' reaches every block, or a mirror does: all ask for the normal.
    turned: bool,
    /// Some shadow or paint reads the normal of the triangle's plane.
    planes: bool,
    eye: [f32; 3],
    rays: EyeRays,
    level: Level,
}

/// A light, and what it loses on its way.
struct Lamp<'a> {
    light: Light,
    shadows: &'a [ShadowReader],
    slide: Option<Cast<'a>>,
}

/// A slide on its way to a surface.
struct Cast<'a> {
    thrown: &'a Thrown<'a>,
    look_up: SlideLookUp<'a>,
}

/// What turns the normals.
enum Relief<'a> {
    None,
    /// The texels are those of the packed look-ups, or those of a map of its own.
    Normals(NormalMap, &'a Slot<'a>, Space, bool),
    Slopes(&'a ReliefStage<'a>),
    Carved(&'a Carved),
}

const AMBIENT: usize = 0;
const SPECULAR: usize = 1;
const EXPONENT: usize = 2;
const REFLECTIVITY: usize = 3;
const MAPS: usize = 4;

/// Columns between the stages; a thread keeps them.
#[derive(Default)]
pub(crate) struct LitScratch {
    /// The columns of `vectors`.
    values: RunValues,
    /// Coordinates of maps: of the mesh, of the light map.
    uv: RunValues,
    look_ups: LookUpScratch,
    /// What the stages of a run have read.
    read: Reads,
    /// The run, without the pixels of blocks that no slide reaches.
    reached: Vec<RunBlock>,
}

/// What the stages of a run have read.
#[derive(Default)]
struct Reads {
    /// Base colour and normal map.
    texels: [Texels; 2],
    /// By [`LitLanes::slides`].
    slides: Vec<SlideTexels>,
    baked: MapTexels,
    maps: [MapTexels; MAPS],
    normals: MapTexels,
    slopes: SlopeTexels,
    base: MapTexels,
    opacity: MapTexels,
    emission: MapTexels,
}

impl<'a> LitLanes<'a> {
    /// `None` for surfaces that have a texture instead of light, or none but that, and for levels without lanes.
    pub(crate) fn new(plan: &'a Plan<'a>, surface: &'a Surface<'a>) -> Option<Self> {
        let material = surface.material;
        let covered = surface.base_color.is_some() && material.texture_role == TextureRole::Decal;
        let other = surface.space.is_some() || surface.texel.is_some();
        if covered || other || !has_lanes(plan.level) {
            return None;
        }
        let per_pixel = matches!(surface.light, LightStage::PerPixel);
        let mut this = Self {
            surface,
            ready: &plan.ready,
            numbers: material.surface,
            power: Power::new(material.surface.ns),
            lights: Vec::new(),
            ground: Ground::new(surface),
            relief: Relief::None,
            baked: None,
            paints: Vec::new(),
            mirror: None,
            specular: None,
            maps: [None; MAPS],
            look_ups: LookUps::new([None; 2]),
            reads_all: false,
            normal: surface.normal.unwrap_or(0),
            position: surface.position.filter(|first| first + 3 <= surface.shaded),
            tangent: 0,
            sees_eye: false,
            turned: false,
            planes: false,
            eye: plan.eye,
            rays: plan.rays,
            level: plan.level,
        };
        match &surface.effects {
            _ if !per_pixel => {}
            None => {
                let lights = plan.lights.iter();
                this.lights.extend(lights.map(|light| Lamp {
                    light: *light,
                    shadows: &[],
                    slide: None,
                }));
            }
            Some(effects) => this.take_effects(effects),
        }
        let has_relief = !matches!(this.relief, Relief::None);
        if has_relief && this.position.is_none() {
            return None;
        }
        this.choose_way();
        let mapped = this.reads_uv();
        if mapped && matches!(surface.uv, Coordinates::None) {
            return None;
        }
        let mut shining = this.lights.iter().filter(|lamp| !lamp.is_ambient());
        this.turned = this.has_mirrors() || shining.any(|lamp| lamp.slide.is_none());
        let shines = this.lights.iter().any(|lamp| !lamp.is_ambient());
        let clamps = has_relief && material.horizon_clamp;
        this.sees_eye = (shines && material.surface.ks > 0.0) || clamps;
        let shades = this.lights.iter().flat_map(Lamp::shades);
        let shaded = shades.into_iter().any(ShadowReader::reads_normals);
        // Paint does not reach what turns away from its projector.
        this.planes = shaded || !this.paints.is_empty();
        Some(this)
    }

    fn take_effects(&mut self, effects: &'a SurfaceEffects<'a>) {
        let ready = self.ready;
        self.maps = effects.maps();
        self.relief = match effects.relief_stage() {
            None => Relief::None,
            Some(ReliefStage::NormalMap(slot, map, space)) => {
                Relief::Normals(*map, slot, *space, fits(self.surface, slot))
            }
            Some(ReliefStage::Carved(carved)) => Relief::Carved(carved),
            Some(slopes) => Relief::Slopes(slopes),
        };
        self.baked = effects.baked();
        if self.position.is_some() {
            self.paints.extend(ready.paints.iter().map(Cast::new));
        }
        let mirror = |index: usize| &ready.environments[index];
        self.mirror = effects
            .reflection()
            .map(|(environment, share)| (mirror(environment), share));
        self.specular = effects.specular_map().map(mirror);
        let first_lamp = ready.lights.len() - ready.lamps.len();
        for (index, light) in effects.lights() {
            let slide = index.checked_sub(first_lamp).map(|i| &ready.lamps[i]);
            self.lights.push(Lamp {
                light: *light,
                shadows: &ready.shadows[*index],
                slide: slide.map(Cast::new),
            });
        }
    }

    /// Whether columns of a few attributes will do, and where the vectors stand in those that are read.
    fn choose_way(&mut self) {
        let base = match &self.ground {
            Ground::Texels => self.surface.base_color.as_ref(),
            _ => None,
        };
        let normals = match &self.relief {
            Relief::Normals(_, slot, _, true) => Some(*slot),
            _ => None,
        };
        self.look_ups = LookUps::new([base, normals]);
        self.reads_all = !matches!(self.surface.light, LightStage::PerPixel)
            || !matches!(self.ground, Ground::Texels)
            || !matches!(self.relief, Relief::None | Relief::Normals(.., true))
            || self.maps.iter().any(Option::is_some)
            || self.surface.light_ramp.is_some()
            || self.surface.emission.is_some()
            || self.specular.is_some()
            || !self.paints.is_empty();
        if let Relief::Normals(_, _, Space::Tangent(first), _) = self.relief {
            self.tangent = first;
        }
        if !self.reads_all {
            self.normal = NORMAL;
            self.tangent = TANGENT;
            self.position = self.position.map(|_| POSITION);
        }
    }

    /// Whether all that shading reads must be among the values of a run.
    pub(crate) fn reads_all(&self) -> bool {
        self.reads_all
    }

    /// Whether some stage reads coordinates as columns.
    fn reads_uv(&self) -> bool {
        let relief = matches!(
            self.relief,
            Relief::Slopes(_) | Relief::Normals(_, _, _, false)
        );
        let maps = self.maps.iter().any(Option::is_some) || self.emission_map().is_some();
        relief || self.ground.reads_uv() || maps
    }

    fn emission_map(&self) -> Option<&'a Slot<'a>> {
        self.surface.emission.as_ref()?.map.as_ref()
    }

    fn has_mirrors(&self) -> bool {
        self.mirror.is_some() || self.specular.is_some()
    }

    /// Shades a run: the colours of [`Stages::shade`].
    pub(crate) fn shade(
        &self,
        plan: &Plan<'_>,
        planes: &TilePlanes,
        run: &Run<'_>,
        stages: &mut Stages,
        scratch: &mut LitScratch,
        out: &mut Colors,
    ) {
        let (level, list) = (self.level, run.run);
        if let Ground::Stages = self.ground {
            stages.base_colors(plan, self.surface, run, out);
        }
        self.read_maps(planes, run, stages, scratch);
        let LitScratch {
            values,
            uv,
            look_ups,
            read,
            reached,
        } = scratch;
        read.slides
            .resize_with(self.slides().count(), SlideTexels::default);
        on_wide_level!(
            level,
            s => {
                self.look_ups.run(s, level, planes, run.blocks, list, look_ups, &mut read.texels);
                if let Relief::Slopes(stage) = &self.relief {
                    stage.slopes(s, level, self.uv(run, uv), list.len(), &mut read.slopes);
                }
                let values = if self.reads_all {
                    self.look_up_slides(s, run.values, list.len(), &mut read.slides);
                    run.values
                } else {
                    self.few_attributes(s, planes, run, values, &mut read.slides, reached);
                    &*values
                };
                let columns = Columns { stage: self, run, values, read };
                let mut side = Side::new();
                for (i, at) in list.iter().enumerate() {
                    self.look_aside(run, *at, &mut side);
                    let color = if self.reads_all {
                        columns.any_block(s, i, *at, &side, out)
                    } else {
                        columns.block::<_, false>(s, i, *at, &side, out)
                    };
                    for (to, color) in out.0.iter_mut().zip(&color) {
                        color.store_slice(&mut to[i * LANES..(i + 1) * LANES]);
                    }
                }
            },
            else {}
        );
    }

    /// The look-ups that need no lanes around them.
    fn read_maps(
        &self,
        planes: &TilePlanes,
        run: &Run<'_>,
        stages: &mut Stages,
        scratch: &mut LitScratch,
    ) {
        let (level, blocks) = (self.level, run.run.len());
        let LitScratch { uv, read, .. } = scratch;
        if let Some((_, slot, first)) = self.baked {
            let (wanted, derivatives) = ([first, first + 1], slot.reads_derivatives());
            planes.values(level, run.blocks, run.run, &wanted, derivatives, uv);
            read.baked.look_up(level, slot, uv, blocks);
        }
        if !self.reads_uv() {
            return;
        }
        if !matches!(self.surface.uv, Coordinates::Vertices) {
            stages.uv_columns(level, self.surface, run, uv);
        }
        let uv = self.uv(run, uv);
        for (slot, out) in self.maps.iter().zip(&mut read.maps) {
            if let Some(slot) = slot {
                out.look_up(level, slot, uv, blocks);
            }
        }
        if let Relief::Normals(_, slot, _, false) = self.relief {
            read.normals.look_up(level, slot, uv, blocks);
        }
        if let Some(slot) = self.emission_map() {
            read.emission.look_up(level, slot, uv, blocks);
        }
        if let Ground::Maps { base, opacity, .. } = self.ground {
            if let Some(slot) = base {
                read.base.look_up(level, slot, uv, blocks);
            }
            if let Some(slot) = opacity {
                read.opacity.look_up(level, slot, uv, blocks);
            }
        }
    }

    /// Coordinates of the mesh: among the values of a run, or found for it.
    fn uv<'b>(&self, run: &Run<'b>, found: &'b RunValues) -> &'b RunValues {
        match self.surface.uv {
            Coordinates::Vertices => run.values,
            _ => found,
        }
    }

    /// Slides of the lights, then paint.
    fn slides(&self) -> impl Iterator<Item = &Cast<'a>> {
        let of_lights = self.lights.iter().filter_map(|lamp| lamp.slide.as_ref());
        of_lights.chain(&self.paints)
    }
}

impl<'a> Cast<'a> {
    fn new(thrown: &'a Thrown<'a>) -> Self {
        Self {
            thrown,
            look_up: SlideLookUp::new(&thrown.view),
        }
    }

    fn shade(&self) -> Option<&'a ShadowReader> {
        self.thrown.shade.as_ref()
    }
}

impl Lamp<'_> {
    /// Whether it shines on all normals alike.
    fn is_ambient(&self) -> bool {
        matches!(self.light, Light::Ambient { .. })
    }

    /// Every map that its light passes.
    fn shades(&self) -> impl Iterator<Item = &ShadowReader> {
        let of_slide = self.slide.as_ref().and_then(Cast::shade);
        self.shadows.iter().chain(of_slide)
    }
}

/// Whether the packed look-ups read a slot: at the coordinates of the mesh as they are, and without an alpha that matters.
fn fits(surface: &Surface<'_>, slot: &Slot<'_>) -> bool {
    let uv = matches!(surface.uv, Coordinates::Vertices);
    uv && !slot.is_transformed() && !slot.can_be_transparent()
}

fn has_lanes(level: Level) -> bool {
    on_wide_level!(level, s => { let _ = s; true }, else false)
}
