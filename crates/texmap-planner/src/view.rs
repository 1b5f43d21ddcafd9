//! One mesh as the camera sees it, and what is chosen for it.

use texmap_math::glam::{DMat4, DVec2, DVec3, DVec4};
use texmap_math::{ViewRays, affine_error, wide};
use texmap_raster::Interp;
use texmap_sample::{Filter, Precision, Sampler};

use super::gain::Lighting;
use super::look::{Look, Read};
use super::pilot::{Pilot, PixelSamples};
use super::prices::{self, Price, prices};
use super::{Budget, Choice, maps};
use texmap_scene::{
    AlphaMode, ColorMode, Material, Mesh, Scene, Shading, TextureRole, TextureSlot,
};

/// A mesh as the camera sees it.
pub(super) struct View<'s> {
    pub(super) scene: &'s Scene,
    pub(super) mesh: &'s Mesh,
    pub(super) lighting: &'s Lighting<'s>,
    /// x and y in pixels (y down) times w, clip z, w.
    pub(super) positions: &'s [DVec4],
    pub(super) size: DVec2,
    pub(super) view_from_world: DMat4,
    /// Half the width and height of the picture at distance 1.
    pub(super) half: [f64; 2],
}

impl View<'_> {
    pub(super) fn rays(&self) -> ViewRays {
        ViewRays::new(self.half, self.size.to_array()).around(self.scene.camera.lens.center)
    }

    /// A vertex in the world.
    pub(super) fn world(&self, vertex: u32) -> DVec3 {
        let position = wide(self.mesh.positions[vertex as usize]);
        self.mesh.world_from_object.transform_point3(position)
    }

    /// `places` are the pixels of the mesh that are seen, of `all` inside its outline.
    pub(super) fn choose(
        &self,
        index: usize,
        budget: Budget,
        places: &PixelSamples,
        all: usize,
        samples: u32,
    ) -> Choice {
        let material = &self.scene.materials[self.mesh.material];
        let mut choice = Choice {
            mesh: index,
            interp: Interp::Perspective,
            predicted_texels: 0.0,
            filter: None,
            constant: None,
            predicted_rmse: 0.0,
            price: prices::interp(Interp::Perspective),
            tried: 0,
            why: String::new(),
            left_out: Vec::new(),
        };
        let gone = maps::drop_constant(&self.lighting.textures, &mut material.clone());
        choice.left_out.extend(gone);
        let texels = material.base_color.as_ref().map_or(1.0, |slot| {
            let texture = &self.scene.textures[slot.texture];
            f64::from(texture.width().max(texture.height()))
        });
        // Coordinates that are made per pixel need the position, or no attribute at all.
        let per_pixel = self.mesh.texture_frame.is_some() || self.mesh.uv_projection.is_some();
        let affine = self.affine_error(texels);
        if !per_pixel && affine <= EQUAL_W && prices::interp(Interp::Affine) <= choice.price {
            choice.interp = Interp::Affine;
            choice.predicted_texels = affine;
            choice.price = prices::interp(Interp::Affine);
            choice
                .left_out
                .push("perspective divide (w is equal at the corners)");
        }
        match Look::new(self.scene, &self.lighting.textures, self.mesh, material) {
            None => {
                "no texture".clone_into(&mut choice.why);
                choice.left_out.push("texture look-up");
            }
            Some(look) => match look.slot() {
                Some(slot) => {
                    self.choose_filter((slot, &look), budget, places, all, samples, &mut choice);
                }
                None => self.predict(&look, budget, places, all, samples, &mut choice),
            },
        }
        choice.price *= f64::from(samples * samples);
        choice
    }

    /// The error of a surface that has no texture to be filtered.
    fn predict(
        &self,
        look: &Look<'_>,
        budget: Budget,
        places: &PixelSamples,
        all: usize,
        samples: u32,
        choice: &mut Choice,
    ) {
        choice.left_out.push("texture look-up");
        let srgb = self.scene.color == ColorMode::Srgb;
        let read = Read {
            base: Sampler::default(),
            label: None,
        };
        // Everything that is known, where a first look leaves it undecided.
        for all_of_them in [false, true] {
            let Some(pilot) = self.pilot(places, all_of_them, samples, look) else {
                unseen(places, all).clone_into(&mut choice.why);
                return;
            };
            let found = pilot.error(look, &read, srgb);
            (choice.tried, choice.predicted_rmse) = (pilot.len(), found.bound);
            if found.low > budget.rmse || found.bound <= budget.rmse {
                break;
            }
        }
        "no filter to choose: its samples decide".clone_into(&mut choice.why);
    }

    fn pilot(
        &self,
        places: &PixelSamples,
        all: bool,
        samples: u32,
        look: &Look<'_>,
    ) -> Option<Pilot> {
        let material = &self.scene.materials[self.mesh.material];
        let mut gain = self.lighting.gain(self.mesh, material);
        if material.decal.is_some() {
            // The surface colour lies below the label, and is in the look already.
            let mut white = material.clone();
            white.phong.color = [1.0; 3];
            gain = self.lighting.gain(self.mesh, &white);
        }
        let blended = material.alpha == AlphaMode::Blend;
        Pilot::new(places, all, samples, look, (gain, blended))
    }

    fn choose_filter(
        &self,
        (slot, look): (&TextureSlot, &Look<'_>),
        budget: Budget,
        places: &PixelSamples,
        all: usize,
        samples: u32,
        choice: &mut Choice,
    ) {
        let material = &self.scene.materials[self.mesh.material];
        if let Some(color) = look.constant() {
            let border = [slot.sampler.wrap_u, slot.sampler.wrap_v]
                .contains(&texmap_sample::Wrap::ClampToBorder);
            let opaque = color[3] >= 1.0
                && material.alpha == AlphaMode::Opaque
                && material.opacity_map.is_none()
                && material.decal.is_none()
                && !shows_projectors(self.scene, material);
            choice.filter = Some((Filter::Nearest, Precision::Exact));
            "the texture has one colour".clone_into(&mut choice.why);
            choice.left_out.push("mip chain");
            if opaque && !border {
                choice.constant = Some(color);
                choice.filter = None;
                choice
                    .left_out
                    .push("texture look-up (its one colour is the surface's)");
            }
            return;
        }
        let Some(pilot) = self.pilot(places, false, samples, look) else {
            choice.filter = Some((slot.sampler.filter, slot.sampler.precision));
            choice.why = format!("{}: the filter is the scene's", unseen(places, all));
            return;
        };
        choice.tried = pilot.len();
        // Everything that is known, where a first look leaves a filter undecided.
        let mut whole: Option<Pilot> = None;
        let srgb = self.scene.color == ColorMode::Srgb;
        let mut best: Option<(f64, &Price)> = None;
        for price in prices() {
            let read = look.by(price.filter, price.precision);
            let first = pilot.error(look, &read, srgb);
            let mut predicted = first.bound;
            if first.low <= budget.rmse && predicted > budget.rmse {
                if whole.is_none() {
                    whole = self.pilot(places, true, samples, look);
                }
                if let Some(whole) = &whole {
                    choice.tried = whole.len();
                    predicted = whole.error(look, &read, srgb).bound;
                }
            }
            if best.is_none_or(|(error, _)| predicted < error) {
                best = Some((predicted, price));
            }
            // From cheap to dear: the first that fits is the choice.
            if predicted <= budget.rmse {
                break;
            }
        }
        let Some((predicted, price)) = best else {
            return;
        };
        choice.filter = Some((price.filter, price.precision));
        choice.predicted_rmse = predicted;
        choice.price += price.ns * look.textures() as f64;
        choice.why = if predicted <= budget.rmse {
            format!("the cheapest of {} filters that fits", prices().len())
        } else {
            "no filter fits: the most accurate".to_owned()
        };
        if !price.filter.reads_mips() {
            choice.left_out.push("mip chain");
        }
    }

    /// The closed form over the mesh's triangles, in texels; infinite where one crosses the eye's plane.
    fn affine_error(&self, texels: f64) -> f64 {
        let mut most = 0.0f64;
        for triangle in &self.mesh.triangles {
            let w = triangle.map(|i| self.positions[i as usize].w);
            let (low, high) = (w[0].min(w[1]).min(w[2]), w[0].max(w[1]).max(w[2]));
            if !(low > 0.0) {
                return f64::INFINITY;
            }
            let span = |k: usize| {
                let c = triangle.map(|i| {
                    self.mesh
                        .uvs
                        .get(i as usize)
                        .map_or(0.0, |uv| f64::from(uv[k]))
                });
                c[0].max(c[1]).max(c[2]) - c[0].min(c[1]).min(c[2])
            };
            let off = affine_error::max_error(high / low) * span(0).max(span(1)) * texels;
            most = if off.is_nan() {
                f64::INFINITY
            } else {
                most.max(off)
            };
        }
        most
    }
}

/// Reason why so few of a mesh's pixels are seen that nothing can be said.
fn unseen(places: &PixelSamples, all: usize) -> &'static str {
    if places.list.len() < all {
        "nearly all of it is hidden by others"
    } else {
        "hardly seen"
    }
}

/// True if projectors may reach texels that cover a surface, which is then lit.
fn shows_projectors(scene: &Scene, material: &Material) -> bool {
    material.texture_role == TextureRole::Decal
        && material.shading == Shading::PerPixel
        && !scene.effects.projectors.is_empty()
}

/// Texels of affine error up to which w counts as equal: below the 8 sub-texel bits of any filter.
const EQUAL_W: f64 = 1.0 / 512.0;
