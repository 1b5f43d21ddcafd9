//! Lighting and effects sixteen pixels at a time, for the surfaces whose stages all have lanes: the others go sample by sample, with
//! the same bits.

use texmap_light::lanes::{
    MirrorView, RayLanes, V3, clamp_to_horizon_lanes, reflect_across_lanes, share_lanes, spread,
    unit_lanes,
};
use texmap_light::{Light, NormalMap, Power, ShadowReader, Surface as Numbers};
use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, mask32x16, prelude::*};
use texmap_math::glam::DMat3;
use texmap_raster::{
    BlockSink, BlockValues, Column, Cull, NONE, RUN_ROOM, RunBlock, RunValues, TilePlanes,
};

use crate::canvas::{Colors, LANES, bits};
use crate::coordinates::{Coordinates, EyeRays};
use crate::dispatch::on_level;
use crate::lit::SurfaceEffects;
use crate::lit_texels::{
    BakedLookUp, BakedTexels, LookUpScratch, LookUps, SlideLookUp, SlideTexels, Texels,
};
use crate::plan::{LightStage, Plan, Surface};
use crate::ready::{Ready, Thrown};
use crate::relief::{ReliefStage, Space};
use crate::shade::{Facing, Run};
use crate::textures::Slot;
use crate::vertices::narrow;
use crate::{AlphaMode, TextureRole};

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
    /// [`NORMAL`], [`POSITION`] and [`TANGENT`].
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

/// Columns of vectors.
const NORMAL: usize = 0;
const POSITION: usize = 3;
const TANGENT: usize = 6;

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
        on_level!(
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

    /// One vector of some blocks, from its attribute to its column, without its changes. The blocks stand at `places` in the run, or where
    /// they are in the list if there are none.
    #[inline(always)]
    fn three<S: Simd>(
        &self,
        s: S,
        planes: &TilePlanes,
        run: &Run<'_>,
        [attribute, column]: [usize; 2],
        list: &[RunBlock],
        places: &[usize],
        out: &mut RunValues,
    ) {
        if out.columns.len() < TANGENT + 4 {
            out.columns.resize(TANGENT + 4, Column::ZERO);
        }
        if let Some(columns) = out.columns[column..].first_chunk_mut() {
            let columns = Store::<3, false>(columns.each_mut());
            let mut sink = Placed { columns, places };
            let all = [attribute, attribute + 1, attribute + 2];
            planes.each_block::<_, 3, false, _>(s, run.blocks, list, all, &mut sink);
        }
    }

    /// Normals, positions and tangents of a run. The changes of normals are read by mirrors.
    #[inline(always)]
    fn vectors<S: Simd>(&self, s: S, planes: &TilePlanes, run: &Run<'_>, out: &mut RunValues) {
        if out.columns.len() < TANGENT + 4 {
            out.columns.resize(TANGENT + 4, Column::ZERO);
        }
        let (blocks, list, n) = (run.blocks, run.run, self.normal);
        let columns = &mut out.columns[..];
        let tangent = match self.relief {
            Some((_, _, Space::Tangent(first))) => Some(first),
            _ => None,
        };
        let Some(p) = self.position else {
            // Nothing but a mirror asks for no position, or light that is the same everywhere.
            if let Some(normals) = columns.first_chunk_mut() {
                let mut sink = Store::<3, true>(normals.each_mut());
                let all = [n, n + 1, n + 2];
                planes.each_block::<_, 3, true, _>(s, blocks, list, all, &mut sink);
            }
            return;
        };
        match (tangent, self.mirror.is_some()) {
            (Some(t), false) => {
                if let Some(vectors) = columns.first_chunk_mut() {
                    let mut sink = Store::<10, false>(vectors.each_mut());
                    let all = [n, n + 1, n + 2, p, p + 1, p + 2, t, t + 1, t + 2, t + 3];
                    planes.each_block::<_, 10, false, _>(s, blocks, list, all, &mut sink);
                }
            }
            (None, false) => {
                if let Some(vectors) = columns.first_chunk_mut() {
                    let mut sink = Store::<6, false>(vectors.each_mut());
                    let all = [n, n + 1, n + 2, p, p + 1, p + 2];
                    planes.each_block::<_, 6, false, _>(s, blocks, list, all, &mut sink);
                }
            }
            (tangent, true) => {
                if let Some(vectors) = columns.first_chunk_mut() {
                    let mut sink = Store::<6, true>(vectors.each_mut());
                    let all = [n, n + 1, n + 2, p, p + 1, p + 2];
                    planes.each_block::<_, 6, true, _>(s, blocks, list, all, &mut sink);
                }
                if let (Some(t), Some(tangents)) = (tangent, columns[TANGENT..].first_chunk_mut()) {
                    let mut sink = Store::<4, false>(tangents.each_mut());
                    let all = [t, t + 1, t + 2, t + 3];
                    planes.each_block::<_, 4, false, _>(s, blocks, list, all, &mut sink);
                }
            }
        }
    }
}

/// Stores values in columns, and their changes if `D` asks for that.
struct Store<'a, const N: usize, const D: bool>([&'a mut Column; N]);

impl<S: Simd, const N: usize, const D: bool> BlockSink<S, N> for Store<'_, N, D> {
    #[inline(always)]
    fn block(&mut self, _s: S, i: usize, _at: RunBlock, values: &BlockValues<S, N>) {
        let at = i * LANES..(i + 1) * LANES;
        for (k, column) in self.0.iter_mut().enumerate() {
            values.value[k].store_slice(&mut column.value[at.clone()]);
            if D {
                values.ddx[k].store_slice(&mut column.ddx[at.clone()]);
                values.ddy[k].store_slice(&mut column.ddy[at.clone()]);
            }
        }
    }
}

/// Stores values at other places of the run than they are asked for at.
struct Placed<'a> {
    columns: Store<'a, 3, false>,
    places: &'a [usize],
}

impl<S: Simd> BlockSink<S, 3> for Placed<'_> {
    #[inline(always)]
    fn block(&mut self, s: S, i: usize, at: RunBlock, values: &BlockValues<S, 3>) {
        let i = self.places.get(i).copied().unwrap_or(i);
        self.columns.block(s, i, at, values);
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

/// How a block's triangles are seen.
#[derive(Default)]
struct Side {
    /// Pixels that show the back of theirs.
    back: u16,
    /// Normals of their planes, where shadows read them.
    plane: [[f32; LANES]; 3],
}

impl LitLanes<'_> {
    fn look_aside(&self, run: &Run<'_>, at: RunBlock, side: &mut Side) {
        let cull = self.surface.material.cull;
        if cull == Cull::Back && !self.planes {
            // All show their fronts, as the side says from the start.
            return;
        }
        *side = Side::default();
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
    }
}

/// What the stages of a run read.
struct Columns<'a> {
    stage: &'a LitLanes<'a>,
    run: &'a Run<'a>,
    values: &'a RunValues,
    texels: &'a [Texels; 2],
    slides: &'a [SlideTexels],
    baked: &'a BakedTexels,
}

impl Columns<'_> {
    /// The colours of a block.
    #[inline(always)]
    fn block<S: Simd>(&self, s: S, i: usize, at: RunBlock, side: &Side) -> [f32x16<S>; 4] {
        let stage = self.stage;
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let pixels = mask32x16::<S>::from_bitmask(s, u64::from(at.mask));
        let back = mask32x16::<S>::from_bitmask(s, u64::from(side.back));
        let point = match stage.position {
            Some(_) => three(s, self.values, POSITION, i),
            None => [zero; 3],
        };
        let (mut smooth, mut normal, mut toward_eye) = (point, point, point);
        // Without a light that asks for the normal nothing shows it.
        if stage.turned || self.slides.iter().any(|slide| slide.reaches(i)) {
            smooth = turned(back, three(s, self.values, NORMAL, i));
            if stage.sees_eye {
                for k in 0..3 {
                    toward_eye[k] = stage.eye[k] - point[k];
                }
                toward_eye = unit_lanes(s, toward_eye);
            }
            normal = unit_lanes(s, smooth);
            if let Some((map, _, space)) = &stage.relief {
                let texel = self.texels[1].lanes(s, i);
                normal = match space {
                    Space::Object(to_world) => {
                        let world = to_world_lanes(s, to_world, map.decode_lanes(s, texel));
                        unit_lanes(s, turned(back, world))
                    }
                    Space::Tangent(_) => {
                        let tangent = three(s, self.values, TANGENT, i);
                        let sign = column(s, &self.values.columns[TANGENT + 3].value, i);
                        let sign = back.select(-sign, sign);
                        let sign = sign.simd_lt(zero).select(-one, one);
                        map.turn_lanes(s, normal, tangent, sign, texel)
                    }
                };
                if stage.surface.material.horizon_clamp {
                    normal = clamp_to_horizon_lanes(s, normal, toward_eye);
                }
            }
        }
        let (mut diffuse, mut highlight) = ([zero; 3], [zero; 3]);
        let mut slide = self.slides.iter();
        for lamp in &stage.lights {
            let texel = match lamp.slide.as_ref().and_then(|_| slide.next()) {
                None => None,
                Some(texels) => match texels.lanes(s, i) {
                    None => continue,
                    some => some,
                },
            };
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
            let received = self.received(s, lamp, texel, lit, point, side);
            for k in 0..3 {
                let color = given.color[k] * received[k];
                diffuse[k] = lit.select(diffuse[k] + color * given.diffuse, diffuse[k]);
                highlight[k] = lit.select(highlight[k] + color * given.highlight, highlight[k]);
            }
        }
        if let Some(map) = &stage.baked {
            let light = self.baked.lanes(s, i);
            for k in 0..3 {
                diffuse[k] += light[k] * map.share;
            }
        }
        if let Some((environment, share)) = &stage.mirror {
            let ray = self.mirrored(s, i, at, back, smooth, normal);
            let light = environment.light_lanes(s, &ray);
            for k in 0..3 {
                highlight[k] += light[k] * *share;
            }
        }
        let mut out = [one; 4];
        let texel = match stage.surface.base_color {
            Some(_) => self.texels[0].lanes(s, i),
            None => [one; 3],
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
        lamp: &Lamp<'_>,
        texel: Option<V3<S>>,
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
        let (Some([r, g, b]), Some((thrown, _))) = (texel, &lamp.slide) else {
            return [share; 3];
        };
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
        at: RunBlock,
        back: mask32x16<S>,
        smooth: V3<S>,
        normal: V3<S>,
    ) -> RayLanes<S> {
        let rays = &self.stage.rays;
        let view = RayLanes {
            direction: rays.block(s, self.run.pixel(at, 0)),
            dx: spread(s, rays.dx),
            dy: spread(s, rays.dy),
        };
        let [normal_dx, normal_dy] = changes(s, self.values, NORMAL, i);
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

/// A matrix times the vectors in all lanes, in f64 as for one.
#[inline(always)]
fn to_world_lanes<S: Simd>(s: S, to_world: &DMat3, v: V3<S>) -> V3<S> {
    let [(x0, x1), (y0, y1), (z0, z1)] = [v[0].widen(), v[1].widen(), v[2].widen()];
    let mut out = v;
    for (k, out) in out.iter_mut().enumerate() {
        let (a, b, c) = (to_world.x_axis[k], to_world.y_axis[k], to_world.z_axis[k]);
        *out = s.narrow_f64x8(x0 * a + y0 * b + z0 * c, x1 * a + y1 * b + z1 * c);
    }
    out
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
