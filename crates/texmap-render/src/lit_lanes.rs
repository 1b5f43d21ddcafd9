//! Lighting and effects sixteen pixels at a time, for the surfaces whose stages all have lanes: the others go sample by sample, with
//! the same bits.

use texmap_light::lanes::{
    MirrorView, RayLanes, V3, clamp_to_horizon_lanes, reflect_across_lanes, share_lanes, unit_lanes,
};
use texmap_light::{Light, NormalMap, Power, ShadowReader, Surface as Numbers};
use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, mask32x16, prelude::*};
use texmap_raster::{Cull, NONE, RUN_ROOM, RunBlock, RunValues, TilePlanes};
use texmap_sample::{Places, sample_columns};

use crate::canvas::{Colors, LANES, bits};
use crate::coordinates::Coordinates;
use crate::dispatch::on_level;
use crate::lit::SurfaceEffects;
use crate::plan::{LightStage, Plan, Surface};
use crate::ready::{Ready, Thrown};
use crate::relief::{ReliefStage, Space};
use crate::shade::{Facing, Run};
use crate::texel::places;
use crate::textures::Slot;
use crate::tile::ATTRIBUTES;
use crate::vertices::narrow;
use crate::{AlphaMode, TextureRole};

/// The stages of one surface; each is there only if the material or a light asks for it.
pub(crate) struct LitLanes<'a> {
    surface: &'a Surface<'a>,
    numbers: Numbers,
    power: Power,
    lights: Vec<Lamp<'a>>,
    relief: Option<(NormalMap, &'a Slot<'a>, usize)>,
    mirror: Option<(MirrorView<'a>, f32)>,
    normal: usize,
    position: Option<usize>,
    /// Attributes before these: coordinates, of which derivatives may be read.
    near: usize,
    /// Derivatives of coordinates are read.
    derivatives: bool,
    /// Lights or a relief ask for the direction to the eye.
    sees_eye: bool,
    /// Some shadow reads the normal of the triangle's plane.
    planes: bool,
    eye: [f32; 3],
    level: Level,
}

/// A light, and what it loses on its way.
struct Lamp<'a> {
    light: Light,
    shadows: &'a [ShadowReader],
    slide: Option<&'a Thrown<'a>>,
}

/// Columns between the stages; a thread keeps them.
#[derive(Default)]
pub(crate) struct LitScratch {
    near: RunValues,
    rest: RunValues,
    base: Texels,
    bumps: Texels,
    slides: Vec<Texels>,
    /// Where a slide is looked up, and the factor of its texels.
    places: Places3,
}

struct Places3([[f32; RUN_ROOM]; 3]);

impl Default for Places3 {
    fn default() -> Self {
        Self([[0.0; RUN_ROOM]; 3])
    }
}

/// Texels of a run, channel by channel.
struct Texels(Colors);

impl Default for Texels {
    fn default() -> Self {
        Self(Colors::new())
    }
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
        let near = match surface.uv {
            Coordinates::None => 0,
            Coordinates::Vertices => 2,
            _ => return None,
        };
        let mut this = Self {
            surface,
            numbers: material.surface,
            power: Power::new(material.surface.ns),
            lights: Vec::new(),
            relief: None,
            mirror: None,
            normal: surface.normal?,
            position: surface.position.filter(|first| first + 3 <= surface.shaded),
            near,
            derivatives: false,
            sees_eye: false,
            planes: false,
            eye: plan.eye,
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
        let slots = surface
            .base_color
            .iter()
            .chain(this.relief.as_ref().map(|r| r.1));
        this.derivatives = slots.into_iter().any(Slot::reads_derivatives);
        this.sees_eye = !this.lights.is_empty() || this.relief.is_some();
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
            Some(ReliefStage::NormalMap(slot, map, Space::Tangent(first))) if fits(slot) => {
                Some((*map, slot, *first))
            }
            Some(_) => return None,
        };
        if let Some((environment, reflectivity)) = effects.reflection() {
            let view = MirrorView::new(&ready.environments[environment])?;
            self.mirror = Some((view, reflectivity));
        }
        let first_lamp = ready.lights.len() - ready.lamps.len();
        for (index, light) in effects.lights() {
            let slide = index.checked_sub(first_lamp).map(|i| &ready.lamps[i]);
            let lamp = Lamp {
                light: *light,
                shadows: &ready.shadows[*index],
                slide,
            };
            let leveled = slide.is_some_and(|slide| slide.reads_derivatives());
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
        let level = self.level;
        let list = run.run;
        let count = list.len() * LANES;
        let LitScratch {
            near,
            rest,
            base,
            bumps,
            slides,
            places,
        } = scratch;
        let (first, others) = ATTRIBUTES[..self.surface.shaded].split_at(self.near);
        if !first.is_empty() {
            planes.values(level, run.blocks, list, first, self.derivatives, near);
        }
        planes.values(level, run.blocks, list, others, self.mirror.is_some(), rest);
        if let Some(slot) = &self.surface.base_color {
            look_up(level, slot, near, count, base);
        }
        if let Some((_, slot, _)) = &self.relief {
            look_up(level, slot, near, count, bumps);
        }
        let thrown = self.lights.iter().filter_map(|lamp| lamp.slide).count();
        slides.resize_with(thrown, Texels::default);
        on_level!(
            level,
            s => {
                if thrown > 0 {
                    self.slides(s, rest, list.len(), &mut places.0, slides);
                }
                let columns = Columns { stage: self, rest, base, bumps, slides };
                for (i, at) in list.iter().enumerate() {
                    let side = self.side(run, *at);
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
    /// Every map that its light passes.
    fn shades(&self) -> impl Iterator<Item = &ShadowReader> {
        let of_slide = self.slide.and_then(|slide| slide.shade.as_ref());
        self.shadows.iter().chain(of_slide)
    }
}

/// How a block's triangles are seen.
struct Side {
    /// Pixels that show the back of theirs.
    back: u16,
    /// Normals of their planes, where shadows read them.
    plane: [[f32; LANES]; 3],
}

impl LitLanes<'_> {
    fn side(&self, run: &Run<'_>, at: RunBlock) -> Side {
        let mut side = Side {
            back: 0,
            plane: [[0.0; LANES]; 3],
        };
        let cull = self.surface.material.cull;
        if cull == Cull::Back && !self.planes {
            return side;
        }
        let effects = self.surface.effects.as_ref().filter(|_| self.planes);
        let mut facing = Facing::new(cull);
        let mut last = (NONE, true, [0.0; 3]);
        for bit in bits(at.mask) {
            let slot = run.slot(at, bit);
            if slot != last.0 {
                let front = facing.is_front(run, slot);
                let plane = effects.map_or([0.0; 3], |effects| {
                    let (_, triangle) = run.prepared.source(run.blocks.ids[slot as usize]);
                    narrow(effects.plane(triangle, front))
                });
                last = (slot, front, plane);
            }
            side.back |= u16::from(!last.1) << bit;
            for (column, c) in side.plane.iter_mut().zip(last.2) {
                column[bit] = c;
            }
        }
        side
    }

    /// Texels of every slide, 0 where it does not reach.
    #[inline(always)]
    fn slides<S: Simd>(
        &self,
        s: S,
        rest: &RunValues,
        blocks: usize,
        [u, v, fade]: &mut [[f32; RUN_ROOM]; 3],
        out: &mut [Texels],
    ) {
        let thrown = self.lights.iter().filter_map(|lamp| lamp.slide);
        for (slide, out) in thrown.zip(out) {
            for i in 0..blocks {
                let at = i * LANES..(i + 1) * LANES;
                let places = slide.view.place_lanes(s, self.position(s, rest, i));
                places.uv[0].store_slice(&mut u[at.clone()]);
                places.uv[1].store_slice(&mut v[at.clone()]);
                let zero = f32x16::splat(s, 0.0);
                let share = places.reached.select(places.fade, zero);
                share.store_slice(&mut fade[at]);
            }
            let count = blocks * LANES;
            let places = Places {
                u: &u[..count],
                v: &v[..count],
                gradients: None,
            };
            let columns = out.0.0.each_mut().map(|c| &mut c[..count]);
            let (sampler, texture) = (&slide.view.sampler, slide.view.texture);
            sample_columns(self.level, sampler, texture, &places, columns)
                .expect("the columns have one length");
            for column in &mut out.0.0 {
                for i in 0..blocks {
                    let at = i * LANES..(i + 1) * LANES;
                    let share = f32x16::from_slice(s, &fade[at.clone()]);
                    let texel = f32x16::from_slice(s, &column[at.clone()]);
                    (texel * share).store_slice(&mut column[at]);
                }
            }
        }
    }

    #[inline(always)]
    fn position<S: Simd>(&self, s: S, rest: &RunValues, i: usize) -> V3<S> {
        match self.position {
            Some(first) => three(s, rest, first - self.near, i),
            None => [f32x16::splat(s, 0.0); 3],
        }
    }
}

/// What the stages of a run read.
struct Columns<'a> {
    stage: &'a LitLanes<'a>,
    rest: &'a RunValues,
    base: &'a Texels,
    bumps: &'a Texels,
    slides: &'a [Texels],
}

impl Columns<'_> {
    /// The colours of a block.
    #[inline(always)]
    fn block<S: Simd>(&self, s: S, i: usize, at: RunBlock, side: &Side) -> [f32x16<S>; 4] {
        let stage = self.stage;
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let pixels = mask32x16::<S>::from_bitmask(s, u64::from(at.mask));
        let back = mask32x16::<S>::from_bitmask(s, u64::from(side.back));
        let smooth = three(s, self.rest, stage.normal - stage.near, i);
        let smooth = turned(back, smooth);
        let point = stage.position(s, self.rest, i);
        let mut view = point;
        for k in 0..3 {
            view[k] = stage.eye[k] - point[k];
        }
        let toward_eye = match stage.sees_eye {
            true => unit_lanes(s, view),
            false => view,
        };
        let mut normal = unit_lanes(s, smooth);
        if let Some((map, _, tangent)) = &stage.relief {
            let first = tangent - stage.near;
            let tangent = three(s, self.rest, first, i);
            let sign = column(s, &self.rest.columns[first + 3].value, i);
            let sign = back.select(-sign, sign);
            let sign = sign.simd_lt(zero).select(-one, one);
            let [r, g, b, _] = self.bumps.0.lanes(s, i);
            normal = map.turn_lanes(s, normal, tangent, sign, [r, g, b]);
            if stage.surface.material.horizon_clamp {
                normal = clamp_to_horizon_lanes(s, normal, toward_eye);
            }
        }
        let (mut diffuse, mut highlight) = ([zero; 3], [zero; 3]);
        let mut slide = self.slides.iter();
        for lamp in &stage.lights {
            let texels = lamp.slide.and_then(|_| slide.next());
            let model = stage.surface.material.highlight;
            let (numbers, power) = (&stage.numbers, stage.power);
            let given = share_lanes(
                s,
                numbers,
                power,
                model,
                &lamp.light,
                point,
                normal,
                toward_eye,
            );
            let lit = given.lit & pixels;
            if !lit.any_true() {
                continue;
            }
            let received = self.received(s, i, lamp, texels, lit, point, side);
            for k in 0..3 {
                let color = given.color[k] * received[k];
                diffuse[k] = lit.select(diffuse[k] + color * given.diffuse, diffuse[k]);
                highlight[k] = lit.select(highlight[k] + color * given.highlight, highlight[k]);
            }
        }
        if let Some((environment, share)) = &stage.mirror {
            let ray = self.mirrored(s, i, back, smooth, normal, view);
            let light = environment.light_lanes(s, &ray);
            for k in 0..3 {
                highlight[k] += light[k] * *share;
            }
        }
        let mut out = [one; 4];
        let texel = match stage.surface.base_color {
            Some(_) => self.base.0.lanes(s, i),
            None => out,
        };
        for k in 0..3 {
            let base = texel[k] * stage.numbers.color[k];
            let value = base * diffuse[k] + highlight[k];
            out[k] = value.simd_lt(one).select(value, one);
        }
        out
    }

    /// What reaches the pixels of a light.
    #[inline(always)]
    fn received<S: Simd>(
        &self,
        s: S,
        i: usize,
        lamp: &Lamp<'_>,
        texels: Option<&Texels>,
        lit: mask32x16<S>,
        point: V3<S>,
        side: &Side,
    ) -> V3<S> {
        let one = f32x16::splat(s, 1.0);
        let plane = [
            f32x16::from_slice(s, &side.plane[0]),
            f32x16::from_slice(s, &side.plane[1]),
            f32x16::from_slice(s, &side.plane[2]),
        ];
        let mut share = one;
        for shade in lamp.shadows {
            share *= shade.lit_lanes(s, lit, point, plane);
        }
        let (Some(texels), Some(thrown)) = (texels, lamp.slide) else {
            return [share; 3];
        };
        let [r, g, b, _] = texels.0.lanes(s, i);
        if let Some(shade) = &thrown.shade {
            let zero = f32x16::splat(s, 0.0);
            let some = r.simd_gt(zero) | g.simd_gt(zero) | b.simd_gt(zero);
            let left = share * shade.lit_lanes(s, lit & some, point, plane);
            share = some.select(left, share);
        }
        [r * share, g * share, b * share]
    }

    #[inline(always)]
    fn mirrored<S: Simd>(
        &self,
        s: S,
        i: usize,
        back: mask32x16<S>,
        smooth: V3<S>,
        normal: V3<S>,
        view: V3<S>,
    ) -> RayLanes<S> {
        let stage = self.stage;
        let [dx, dy] = match stage.position {
            Some(first) => changes(s, self.rest, first - stage.near, i),
            None => [[f32x16::splat(s, 0.0); 3]; 2],
        };
        let [normal_dx, normal_dy] = changes(s, self.rest, stage.normal - stage.near, i);
        let all = mask32x16::splat(s, true);
        let view = RayLanes {
            direction: view,
            dx: turned(all, dx),
            dy: turned(all, dy),
        };
        let [x, y, z] = smooth;
        let length = (x * x + y * y + z * z).sqrt();
        let normal = RayLanes {
            direction: normal,
            dx: turned(back, normal_dx),
            dy: turned(back, normal_dy),
        };
        reflect_across_lanes(&view, &normal, length)
    }
}

/// The places of a run in a texture, and its texels there.
fn look_up(level: Level, slot: &Slot<'_>, near: &RunValues, count: usize, out: &mut Texels) {
    let places = places(slot, near, count);
    let columns = out.0.0.each_mut().map(|c| &mut c[..count]);
    sample_columns(level, &slot.sampler, &slot.texture, &places, columns)
        .expect("the columns have one length");
}

/// Whether a slot reads the coordinates of the mesh as they are.
fn fits(slot: &Slot<'_>) -> bool {
    !slot.is_transformed() && !slot.can_be_transparent()
}

fn has_lanes(level: Level) -> bool {
    on_level!(level, s => { let _ = s; true }, else false)
}

#[inline(always)]
fn column<S: Simd>(s: S, values: &[f32; RUN_ROOM], i: usize) -> f32x16<S> {
    f32x16::from_slice(s, &values[i * LANES..(i + 1) * LANES])
}

#[inline(always)]
fn three<S: Simd>(s: S, values: &RunValues, first: usize, i: usize) -> V3<S> {
    let columns = &values.columns[first..first + 3];
    [
        column(s, &columns[0].value, i),
        column(s, &columns[1].value, i),
        column(s, &columns[2].value, i),
    ]
}

/// Changes of a vector to the right and down.
#[inline(always)]
fn changes<S: Simd>(s: S, values: &RunValues, first: usize, i: usize) -> [V3<S>; 2] {
    let columns = &values.columns[first..first + 3];
    [
        [
            column(s, &columns[0].ddx, i),
            column(s, &columns[1].ddx, i),
            column(s, &columns[2].ddx, i),
        ],
        [
            column(s, &columns[0].ddy, i),
            column(s, &columns[1].ddy, i),
            column(s, &columns[2].ddy, i),
        ],
    ]
}

/// The opposite vector in some lanes.
#[inline(always)]
fn turned<S: Simd>(lanes: mask32x16<S>, v: V3<S>) -> V3<S> {
    [
        lanes.select(-v[0], v[0]),
        lanes.select(-v[1], v[1]),
        lanes.select(-v[2], v[2]),
    ]
}
