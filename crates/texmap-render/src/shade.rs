//! Shading in stages over a run of samples of one surface: coordinates -> base colour -> opacity -> light -> compose.
//! A stage that the surface lacks is not run.

mod compose;

use texmap_light::{Terms, terms_slice};
use texmap_math::{Footprint, Level};
use texmap_raster::{
    Column, Cull, Fragment, NONE, Prepared, RUN_ROOM, RunBlock, RunValues, Tile, TileBlocks,
};
use texmap_sample::sample_slice;
use texmap_uv::PixelMapping;

use crate::canvas::{Colors, LANES, bits};
use crate::coordinates::Coordinates;
use crate::lit::{Sample, SurfaceEffects};
use crate::plan::{LightStage, Plan, Space, Surface};
use crate::textures::Slot;
use texmap_math::color::{luminance, straight};

/// A run of one surface: its blocks and their attributes.
pub(crate) struct Run<'a> {
    pub(crate) prepared: &'a Prepared<'a>,
    pub(crate) tile: Tile,
    pub(crate) blocks: &'a TileBlocks,
    pub(crate) run: &'a [RunBlock],
    pub(crate) values: &'a RunValues,
}

impl Run<'_> {
    pub(crate) fn slot(&self, at: RunBlock, bit: usize) -> u32 {
        if at.slot == NONE {
            self.blocks.slot[at.block as usize * LANES + bit]
        } else {
            at.slot
        }
    }

    /// The sample of a place.
    pub(crate) fn pixel(&self, at: RunBlock, bit: usize) -> [u32; 2] {
        let (x, y) = (at.block as usize % 16 * 4, at.block as usize / 16 * 4);
        [
            self.tile.x0 + (x + bit % 4) as u32,
            self.tile.y0 + (y + bit / 4) as u32,
        ]
    }

    /// Reversed depth of what is solid at a place.
    pub(crate) fn depth(&self, at: RunBlock, bit: usize) -> f32 {
        self.blocks.depth[at.block as usize * LANES + bit]
    }

    /// Places of the run that hold a pixel, with the block and the bit of each.
    pub(crate) fn places(&self) -> impl Iterator<Item = (usize, RunBlock, usize)> {
        self.run
            .iter()
            .enumerate()
            .flat_map(|(i, &at)| bits(at.mask).map(move |bit| (i * LANES + bit, at, bit)))
    }

    fn three(&self, first: usize, place: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| self.values.columns[first + c].value[place])
    }
}

/// Scratch of the stages, one entry per sample of the run.
#[derive(Default)]
pub(crate) struct Stages {
    uv: Vec<([f32; 2], Footprint)>,
    u: Vec<f32>,
    v: Vec<f32>,
    footprint: Vec<Footprint>,
    texel: Vec<[f32; 4]>,
    mask: Vec<[f32; 4]>,
    decal: Vec<[f32; 4]>,
    carved: Vec<[f32; 4]>,
    emitted: Vec<[f32; 4]>,
    color: Vec<[f32; 3]>,
    normal: Vec<[f32; 3]>,
    position: Vec<[f32; 3]>,
    terms: Vec<Terms>,
    paint: Vec<[f32; 4]>,
    /// Positions and their changes right and down, and uv, where a shape maps them.
    moves: [Vec<[f32; 3]>; 3],
    place: Vec<[f32; 2]>,
}

impl Stages {
    /// Shades a run of `surface`: linear light (raw values in raw mode), premultiplied.
    pub(crate) fn shade(
        &mut self,
        plan: &Plan<'_>,
        surface: &Surface<'_>,
        run: &Run<'_>,
        out: &mut Colors,
    ) {
        match surface.space.as_deref() {
            Some(Space::Sky(stage)) => return stage.shade(plan.level, run, out),
            Some(Space::Volume(stage)) => return stage.shade(run, out),
            None => {}
        }
        self.ground(plan, surface, run);
        if let Some(slot) = surface.emission.as_ref().and_then(|e| e.map.as_ref()) {
            look_up(
                plan,
                slot,
                &self.uv,
                (&mut self.u, &mut self.v, &mut self.footprint),
                &mut self.emitted,
            );
        }
        self.vectors(surface, run);
        if let Some(effects) = &surface.effects {
            self.under_effects(plan, surface, effects, run);
        } else if matches!(surface.light, LightStage::PerPixel) {
            self.terms.clear();
            self.terms.resize(self.normal.len(), Terms::default());
            self.position.resize(self.normal.len(), [0.0; 3]);
            let (points, normals) = (&self.position, &self.normal);
            terms_slice(
                &surface.material.surface,
                plan.lights,
                points,
                normals,
                plan.eye,
                &mut self.terms,
            )
            .expect("the stage buffers have one length");
        }
        if let Some(ramp) = &surface.light_ramp {
            for terms in &mut self.terms {
                terms.diffuse = straight(ramp.along(luminance(terms.diffuse)));
            }
        }
        for (i, (place, _, _)) in run.places().enumerate() {
            for (column, value) in out.0.iter_mut().zip(self.compose(surface, i)) {
                column[place] = value;
            }
        }
    }

    /// What lies under the light of the run's pixels: coordinates, texels, vertex colours.
    fn ground(&mut self, plan: &Plan<'_>, surface: &Surface<'_>, run: &Run<'_>) {
        self.coordinates(plan.level, surface, run);
        self.colors(surface, run);
        if let Some(slot) = &surface.base_color {
            look_up(
                plan,
                slot,
                &self.uv,
                (&mut self.u, &mut self.v, &mut self.footprint),
                &mut self.texel,
            );
        }
        if let Some(slot) = &surface.opacity_map {
            look_up(
                plan,
                slot,
                &self.uv,
                (&mut self.u, &mut self.v, &mut self.footprint),
                &mut self.mask,
            );
        }
        if let Some(slot) = &surface.decal {
            look_up(
                plan,
                slot,
                &self.uv,
                (&mut self.u, &mut self.v, &mut self.footprint),
                &mut self.decal,
            );
        }
        self.color_texels(plan.level, surface, run);
    }

    /// The base colours of a surface lit per pixel, straight, and its opacities, for stages that light it themselves.
    pub(crate) fn base_colors(
        &mut self,
        plan: &Plan<'_>,
        surface: &Surface<'_>,
        run: &Run<'_>,
        out: &mut Colors,
    ) {
        self.ground(plan, surface, run);
        for (i, (place, _, _)) in run.places().enumerate() {
            let ([r, g, b], alpha) = self.base_color(surface, i);
            for (column, value) in out.0.iter_mut().zip([r, g, b, alpha]) {
                column[place] = value;
            }
        }
    }

    /// The coordinates of a run as columns 0 and 1.
    pub(crate) fn uv_columns(
        &mut self,
        level: Level,
        surface: &Surface<'_>,
        run: &Run<'_>,
        out: &mut RunValues,
    ) {
        self.coordinates(level, surface, run);
        out.columns.resize(2, Column::ZERO);
        for ((place, ..), (uv, d)) in run.places().zip(&self.uv) {
            let changes = [[d.du_dx, d.du_dy], [d.dv_dx, d.dv_dy]];
            for ((column, value), [dx, dy]) in out.columns.iter_mut().zip(uv).zip(changes) {
                column.value[place] = *value;
                column.ddx[place] = dx;
                column.ddy[place] = dy;
            }
        }
    }

    fn coordinates(&mut self, level: Level, surface: &Surface<'_>, run: &Run<'_>) {
        self.uv.clear();
        match &surface.uv {
            Coordinates::None => {}
            Coordinates::Vertices => {
                let [u, v] = [&run.values.columns[0], &run.values.columns[1]];
                self.uv.extend(run.places().map(|(i, ..)| {
                    let d = Footprint {
                        du_dx: u.ddx[i],
                        dv_dx: v.ddx[i],
                        du_dy: u.ddy[i],
                        dv_dy: v.ddy[i],
                    };
                    ([u.value[i], v.value[i]], d)
                }));
            }
            Coordinates::Frame(frame) => {
                self.uv.extend(run.places().map(|(_, at, bit)| {
                    let [x, y] = run.pixel(at, bit);
                    frame.uv(x, y).unwrap_or_default()
                }));
            }
            Coordinates::Round(map, first) => self.round(level, map, *first, run),
        }
    }

    /// Vertex colours.
    fn colors(&mut self, surface: &Surface<'_>, run: &Run<'_>) {
        self.color.clear();
        let color = match surface.light {
            LightStage::Colors(first) => Some(first),
            _ => surface.color,
        };
        if let Some(first) = color {
            let colors = run.places().map(|(i, ..)| run.three(first, i));
            self.color.extend(colors);
        }
    }

    /// What the light of the run's pixels is computed from.
    fn vectors(&mut self, surface: &Surface<'_>, run: &Run<'_>) {
        self.normal.clear();
        self.position.clear();
        if let LightStage::Terms { diffuse, highlight } = surface.light {
            self.terms.clear();
            self.terms.extend(run.places().map(|(i, ..)| Terms {
                diffuse: run.three(diffuse, i),
                highlight: highlight.map_or([0.0; 3], |first| run.three(first, i)),
            }));
        }
        if matches!(surface.light, LightStage::PerPixel) {
            if let Some(first) = surface.normal {
                let mut facing = Facing::new(surface.material.cull);
                self.normal.extend(run.places().map(|(i, at, bit)| {
                    let normal = run.three(first, i);
                    if facing.is_front(run, run.slot(at, bit)) {
                        normal
                    } else {
                        normal.map(|x| -x)
                    }
                }));
            }
            // A position that only an AOV asked for is not among the values of the run.
            let read = |first: &usize| first + 3 <= surface.shaded;
            if let Some(first) = surface.position.filter(read) {
                let positions = run.places().map(|(i, ..)| run.three(first, i));
                self.position.extend(positions);
            }
        }
    }

    /// Outlines, ramps and solid colours.
    fn color_texels(&mut self, level: Level, surface: &Surface<'_>, run: &Run<'_>) {
        if let Some(stage) = &surface.carved {
            self.carved.clear();
            let columns = [0, 1, 2].map(|k| &run.values.columns[stage.position + k]);
            let mut values = [0.0; RUN_ROOM];
            let has_values = stage.values(level, columns, run.run.len(), &mut values);
            self.carved.extend(run.places().map(|(i, ..)| {
                let of = |pick: fn(&Column) -> &[f32]| columns.map(|column| pick(column)[i]);
                let color = if has_values {
                    [values[i], values[i], values[i], 1.0]
                } else {
                    stage.color(of(|c| &c.value), of(|c| &c.ddx), of(|c| &c.ddy))
                };
                match &surface.color_ramp {
                    Some(ramp) => ramp.along(color[0]),
                    None => color,
                }
            }));
        }
        let Some(slot) = &surface.base_color else {
            return;
        };
        if let (Some(ramp), None) = (&surface.color_ramp, &surface.carved) {
            for (texel, (uv, d)) in self.texel.iter_mut().zip(&self.uv) {
                let keep = texel[3];
                *texel = slot.dependent(*uv, *d, ramp).map(|c| c * keep);
            }
        }
        if surface.material.crisp {
            for (texel, (uv, d)) in self.texel.iter_mut().zip(&self.uv) {
                let alpha = slot.outline(*uv, *d, texel[3]);
                *texel = with_alpha(straight(*texel), alpha);
            }
        }
    }

    /// Light and paint of surfaces with effects: one sample after the other.
    fn under_effects(
        &mut self,
        plan: &Plan<'_>,
        surface: &Surface<'_>,
        effects: &SurfaceEffects<'_>,
        run: &Run<'_>,
    ) {
        self.terms.clear();
        self.paint.clear();
        let mut fragment = Fragment::default();
        let mut facing = Facing::new(surface.material.cull);
        for (i, (place, at, bit)) in run.places().enumerate() {
            for (k, column) in run.values.columns[..surface.shaded].iter().enumerate() {
                fragment.values[k] = column.value[place];
                fragment.ddx[k] = column.ddx[place];
                fragment.ddy[k] = column.ddy[place];
            }
            let slot = run.slot(at, bit);
            fragment.pixel = run.pixel(at, bit);
            fragment.front = facing.is_front(run, slot);
            let (_, triangle) = run.prepared.source(run.blocks.ids[slot as usize]);
            let sample = Sample::new(
                &fragment,
                surface.position,
                surface.normal,
                effects,
                triangle,
            );
            let uv = self.uv.get(i).copied().unwrap_or_default();
            let (terms, paint) = effects.shade(plan, &sample, self.normal[i], uv);
            self.terms.push(terms);
            self.paint.push(paint);
        }
    }

    /// Coordinates from positions, for the run's pixels.
    fn round(&mut self, level: Level, map: &PixelMapping, first: usize, run: &Run<'_>) {
        let [x, y, z] = [0, 1, 2].map(|k| &run.values.columns[first + k]);
        let [points, dx, dy] = &mut self.moves;
        for list in [&mut *points, &mut *dx, &mut *dy] {
            list.clear();
        }
        for (i, ..) in run.places() {
            points.push([x.value[i], y.value[i], z.value[i]]);
            dx.push([x.ddx[i], y.ddx[i], z.ddx[i]]);
            dy.push([x.ddy[i], y.ddy[i], z.ddy[i]]);
        }
        self.place.resize(points.len(), [0.0; 2]);
        self.footprint.resize(points.len(), Footprint::default());
        map.slice(level, points, dx, dy, &mut self.place, &mut self.footprint)
            .expect("the lists have one length");
        let places = self.place.iter().copied();
        self.uv.extend(places.zip(self.footprint.iter().copied()));
    }
}

fn look_up(
    plan: &Plan<'_>,
    slot: &Slot<'_>,
    places: &[([f32; 2], Footprint)],
    (u, v, footprint): (&mut Vec<f32>, &mut Vec<f32>, &mut Vec<Footprint>),
    out: &mut Vec<[f32; 4]>,
) {
    u.clear();
    v.clear();
    footprint.clear();
    for (uv, d) in places {
        let (uv, d) = slot.place(*uv, *d);
        u.push(uv[0]);
        v.push(uv[1]);
        footprint.push(d);
    }
    out.resize(places.len(), [0.0; 4]);
    sample_slice(
        plan.level,
        &slot.sampler,
        &slot.texture,
        u,
        v,
        Some(footprint),
        out,
    )
    .expect("the stage buffers have one length");
}

/// Which side of a triangle is seen, asked once for pixels of one triangle in a row.
pub(crate) struct Facing {
    cull: Cull,
    last: (u32, bool),
}

impl Facing {
    pub(crate) fn new(cull: Cull) -> Self {
        Self {
            cull,
            last: (NONE, true),
        }
    }

    pub(crate) fn is_front(&mut self, run: &Run<'_>, slot: u32) -> bool {
        match self.cull {
            Cull::Back => return true,
            Cull::Front => return false,
            Cull::None => {}
        }
        if self.last.0 != slot {
            let id = run.blocks.ids[slot as usize];
            self.last = (slot, run.prepared.is_front(id));
        }
        self.last.1
    }
}

/// The interpolated normal on the side that is seen.
pub(crate) fn facing_normal(fragment: &Fragment, first: usize) -> [f32; 3] {
    let normal = three(fragment, first);
    if fragment.front {
        normal
    } else {
        normal.map(|x| -x)
    }
}

pub(crate) fn three(fragment: &Fragment, first: usize) -> [f32; 3] {
    [
        fragment.values[first],
        fragment.values[first + 1],
        fragment.values[first + 2],
    ]
}

fn with_alpha([r, g, b]: [f32; 3], alpha: f32) -> [f32; 4] {
    [r * alpha, g * alpha, b * alpha, alpha]
}
