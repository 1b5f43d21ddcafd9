//! Shading in stages over a run of samples of one surface: coordinates -> base colour -> opacity -> light -> compose.
//! A stage that the surface lacks is not run.

use texmap_light::{Terms, terms_slice};
use texmap_math::Footprint;
use texmap_raster::{Fragment, Prepared, TILE, TriangleSetup};
use texmap_sample::sample_slice;

use crate::coordinates::Coordinates;
use crate::plan::{LightStage, Plan, Surface};
use crate::textures::Slot;
use crate::{AlphaMode, TextureRole};

/// Longest run that the stages take at once.
pub(crate) const RUN: usize = 256;

/// A sample of a surface: fragment id and place on the grid.
#[derive(Clone, Copy)]
pub(crate) struct Hit {
    pub(crate) id: u32,
    pub(crate) x: u32,
    pub(crate) y: u32,
}

/// Set-ups of the triangles met last, for one tile.
pub(crate) struct SetupCache {
    slots: Vec<Option<(u32, TriangleSetup)>>,
}

impl SetupCache {
    const SLOTS: usize = 64;

    pub(crate) fn new() -> Self {
        Self {
            slots: vec![None; Self::SLOTS],
        }
    }

    /// To be called when the tile changes.
    pub(crate) fn clear(&mut self) {
        self.slots.fill(None);
    }

    pub(crate) fn evaluate(&mut self, prepared: &Prepared<'_>, hit: Hit, out: &mut Fragment) {
        let slot = &mut self.slots[hit.id as usize % Self::SLOTS];
        let setup = match slot {
            Some((id, setup)) if *id == hit.id => setup,
            _ => {
                &mut slot
                    .insert((hit.id, prepared.setup(hit.id, hit.x / TILE, hit.y / TILE)))
                    .1
            }
        };
        setup.evaluate(hit.x, hit.y, out);
    }
}

/// Scratch of the stages, one entry per sample of the run.
#[derive(Default)]
pub(crate) struct Stages {
    fragment: Fragment,
    uv: Vec<([f32; 2], Footprint)>,
    u: Vec<f32>,
    v: Vec<f32>,
    footprint: Vec<Footprint>,
    texel: Vec<[f32; 4]>,
    mask: Vec<[f32; 4]>,
    color: Vec<[f32; 3]>,
    normal: Vec<[f32; 3]>,
    position: Vec<[f32; 3]>,
    terms: Vec<Terms>,
}

impl Stages {
    /// Shades at most [`RUN`] samples of `surface` into `out`: linear light (raw values in raw mode), premultiplied.
    pub(crate) fn shade(
        &mut self,
        plan: &Plan<'_>,
        surface: &Surface<'_>,
        prepared: &Prepared<'_>,
        setups: &mut SetupCache,
        hits: &[Hit],
        out: &mut Vec<[f32; 4]>,
    ) {
        self.interpolate(surface, prepared, setups, hits);
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
        if matches!(surface.light, LightStage::PerPixel) {
            self.terms.clear();
            self.terms.resize(hits.len(), Terms::default());
            self.position.resize(hits.len(), [0.0; 3]);
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
        out.clear();
        out.extend((0..hits.len()).map(|i| self.compose(surface, i)));
    }

    /// Values of the run's samples, those that the surface's stages read.
    fn interpolate(
        &mut self,
        surface: &Surface<'_>,
        prepared: &Prepared<'_>,
        setups: &mut SetupCache,
        hits: &[Hit],
    ) {
        self.uv.clear();
        self.color.clear();
        self.normal.clear();
        self.position.clear();
        let lit_at_vertices = matches!(surface.light, LightStage::Terms { .. });
        if lit_at_vertices {
            self.terms.clear();
        }
        let per_pixel = matches!(surface.light, LightStage::PerPixel);
        let color = match surface.light {
            LightStage::Colors(first) => Some(first),
            _ => surface.color,
        };
        let fragment = &mut self.fragment;
        for hit in hits {
            setups.evaluate(prepared, *hit, fragment);
            if !matches!(surface.uv, Coordinates::None) {
                self.uv.push(surface.uv.at(fragment).unwrap_or_default());
            }
            if let Some(first) = color {
                self.color.push(three(fragment, first));
            }
            if let LightStage::Terms { diffuse, highlight } = surface.light {
                let highlight = highlight.map_or([0.0; 3], |first| three(fragment, first));
                self.terms.push(Terms {
                    diffuse: three(fragment, diffuse),
                    highlight,
                });
            }
            if let (true, Some(first)) = (per_pixel, surface.normal) {
                self.normal.push(facing_normal(fragment, first));
            }
            if let (true, Some(first)) = (per_pixel, surface.position) {
                self.position.push(three(fragment, first));
            }
        }
    }

    /// The colour of sample `i`.
    fn compose(&self, surface: &Surface<'_>, i: usize) -> [f32; 4] {
        let material = surface.material;
        let texel = if surface.base_color.is_some() {
            self.texel[i]
        } else {
            [1.0; 4]
        };
        let mask = surface
            .opacity_map
            .as_ref()
            .map_or(1.0, |slot| slot.opacity(self.mask[i]));
        let veil = material.opacity * mask;
        if surface.base_color.is_some() && material.texture_role == TextureRole::Decal {
            let [r, g, b, alpha] = texel;
            return match material.alpha {
                AlphaMode::Opaque if alpha < 1.0 => {
                    let under = self.light(surface, i, material.surface.color);
                    let over = |texel: f32, under: f32| clip(texel + (1.0 - alpha) * under);
                    [over(r, under[0]), over(g, under[1]), over(b, under[2]), 1.0]
                }
                AlphaMode::Opaque => [clip(r), clip(g), clip(b), 1.0],
                AlphaMode::Test(_) => with_alpha(straight(texel).map(clip), 1.0),
                AlphaMode::Blend => with_alpha(straight(texel).map(clip), alpha * veil),
            };
        }
        let [r, g, b] = material.surface.color;
        let [tr, tg, tb] = straight(texel);
        let lit = self.light(surface, i, [r * tr, g * tg, b * tb]);
        let alpha = if material.alpha == AlphaMode::Blend {
            texel[3] * veil
        } else {
            1.0
        };
        with_alpha(lit, alpha)
    }

    /// A base colour under the surface's light, clipped at 1.
    fn light(&self, surface: &Surface<'_>, i: usize, base: [f32; 3]) -> [f32; 3] {
        let tinted = |base: [f32; 3]| match (surface.color, self.color.get(i)) {
            (Some(_), Some(tint)) => [base[0] * tint[0], base[1] * tint[1], base[2] * tint[2]],
            _ => base,
        };
        match surface.light {
            LightStage::None => tinted(base).map(clip),
            LightStage::Colors(_) => self.color[i],
            LightStage::Terms { .. } | LightStage::PerPixel => self.terms[i].color(tinted(base)),
        }
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

/// Premultiplied to straight colour; black where nothing is left of it.
pub(crate) fn straight([r, g, b, a]: [f32; 4]) -> [f32; 3] {
    if a > 0.0 {
        [r / a, g / a, b / a]
    } else {
        [0.0; 3]
    }
}

fn with_alpha([r, g, b]: [f32; 3], alpha: f32) -> [f32; 4] {
    [r * alpha, g * alpha, b * alpha, alpha]
}

fn clip(value: f32) -> f32 {
    if value < 1.0 { value } else { 1.0 }
}
