//! The plan by budget: for each mesh the cheapest interpolation and filter whose predicted error fits.
//!
//! [`choose`] is a pure function of the scene, the size of the picture and the budget. Prices come from a table that is
//! part of the crate ([`prices`]), never from a clock, so that the same scene gets the same plan on every machine. Errors
//! of interpolation are predicted by the closed form of affine mapping, those of filters by a pilot: each candidate is
//! tried at some of the mesh's own pixels against the mean over the pixel.

mod pilot;
mod prices;

use texmap_light::Light;
use texmap_math::affine_error;
use texmap_math::glam::{DVec2, DVec4};
use texmap_raster::Interp;
use texmap_sample::{Filter, Mip, Precision, Sampler, Texture2d};

use crate::{AlphaMode, ColorMode, Mesh, RenderError, Scene, Shading, TextureRole, TextureSlot};

use pilot::Pilot;
pub use prices::{Price, prices};

/// What a picture may be off by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Texels, for interpolation.
    pub texels: f64,
    /// Root mean square error of the colour as it is stored (0 to 1), for filters.
    pub rmse: f64,
}

impl Default for Budget {
    /// Half a texel and 0.02.
    fn default() -> Self {
        Self {
            texels: 0.5,
            rmse: 0.02,
        }
    }
}

/// What was chosen for a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// How coordinates run across its triangles.
    pub interp: Interp,
    /// Predicted largest error of `interp` in texels.
    pub predicted_texels: f64,
    /// How its texture is read; none where no texture is.
    pub filter: Option<(Filter, Precision)>,
    /// The colour that stands for a texture of one colour: no look-up at all. Premultiplied, linear.
    pub constant: Option<[f32; 4]>,
    /// Predicted root mean square error of the filter, with its margin; infinite where nothing is predicted.
    pub predicted_rmse: f64,
    /// Nanoseconds a pixel by the table, interpolation and filter.
    pub price: f64,
    /// Pixels that the pilot tried.
    pub tried: usize,
    /// Why, in words.
    pub why: String,
    /// What the mesh does not need.
    pub left_out: Vec<&'static str>,
}

/// A plan: a choice for each mesh that has triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Choices {
    /// The budget.
    pub budget: Budget,
    /// One for each mesh with triangles.
    pub meshes: Vec<Choice>,
    /// Lights without any colour, by index.
    pub dark_lights: Vec<usize>,
}

impl Choices {
    /// Whether every prediction fits the budget.
    pub fn met(&self) -> bool {
        self.meshes.iter().all(|c| {
            c.predicted_texels <= self.budget.texels && c.predicted_rmse <= self.budget.rmse
        })
    }

    /// Changes the scene to what was chosen: each mesh gets a material of its own.
    pub fn apply(&self, scene: &mut Scene) {
        for choice in &self.meshes {
            let Some(mesh) = scene.meshes.get_mut(choice.mesh) else {
                continue;
            };
            let Some(mut material) = scene.materials.get(mesh.material).cloned() else {
                continue;
            };
            material.interp = choice.interp;
            if let Some([r, g, b, _]) = choice.constant {
                material.base_color = None;
                if material.texture_role == TextureRole::Decal {
                    material.surface.color = [r, g, b];
                    material.shading = Shading::Unlit;
                } else {
                    let [x, y, z] = material.surface.color;
                    material.surface.color = [x * r, y * g, z * b];
                }
            }
            if let (Some(slot), Some((filter, precision))) =
                (&mut material.base_color, choice.filter)
            {
                slot.sampler.filter = filter;
                slot.sampler.precision = precision;
            }
            mesh.material = scene.materials.len();
            scene.materials.push(material);
        }
        for index in self.dark_lights.iter().rev() {
            scene.lights.remove(*index);
        }
    }
}

/// Chooses for a picture of this size.
///
/// # Errors
/// What [`Scene::check`] refuses.
pub fn choose(
    scene: &Scene,
    width: u32,
    height: u32,
    budget: Budget,
) -> Result<Choices, RenderError> {
    scene.check()?;
    let aspect = f64::from(width) / f64::from(height);
    let clip_from_world = scene
        .camera
        .clip_from_world(aspect)
        .map_err(RenderError::Camera)?;
    let mut meshes = Vec::new();
    for (index, mesh) in scene.meshes.iter().enumerate() {
        if mesh.triangles.is_empty() {
            continue;
        }
        let clip = clip_from_world * mesh.world_from_object;
        let positions: Vec<DVec4> = mesh
            .positions
            .iter()
            .map(|p| {
                let [x, y, z] = p.map(f64::from);
                let p = clip * DVec4::new(x, y, z, 1.0);
                // Pixels times w, y down.
                let (w, h) = (f64::from(width), f64::from(height));
                DVec4::new((p.x + p.w) * 0.5 * w, (p.w - p.y) * 0.5 * h, p.z, p.w)
            })
            .collect();
        let view = View {
            scene,
            mesh,
            positions: &positions,
            size: DVec2::new(f64::from(width), f64::from(height)),
        };
        meshes.push(view.choose(index, budget));
    }
    let dark = |(_, light): &(usize, &Light)| match light {
        Light::Ambient { color }
        | Light::Directional { color, .. }
        | Light::Point { color, .. } => *color == [0.0; 3],
        _ => false,
    };
    // Shadows name their lights by index.
    let free = scene.effects.shadows.is_empty();
    Ok(Choices {
        budget,
        meshes,
        dark_lights: scene
            .lights
            .iter()
            .enumerate()
            .filter(|light| free && dark(light))
            .map(|(i, _)| i)
            .collect(),
    })
}

/// A mesh as the camera sees it.
struct View<'s> {
    scene: &'s Scene,
    mesh: &'s Mesh,
    /// x and y in pixels times w, clip z, w.
    positions: &'s [DVec4],
    size: DVec2,
}

impl View<'_> {
    fn choose(&self, index: usize, budget: Budget) -> Choice {
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
        let texels = material.base_color.as_ref().map_or(1.0, |slot| {
            let texture = &self.scene.textures[slot.texture];
            f64::from(texture.width().max(texture.height()))
        });
        let affine = self.affine_error(texels);
        if affine <= EQUAL_W && prices::interp(Interp::Affine) <= choice.price {
            choice.interp = Interp::Affine;
            choice.predicted_texels = affine;
            choice.price = prices::interp(Interp::Affine);
            choice
                .left_out
                .push("perspective divide (w is equal at the corners)");
        }
        match &material.base_color {
            None => {
                "no texture".clone_into(&mut choice.why);
                choice.left_out.push("texture look-up");
            }
            Some(_) if self.mesh.frame.is_some() || self.mesh.round.is_some() => {
                // Nothing is tried on them: a promise would be empty.
                choice.predicted_rmse = f64::INFINITY;
                "coordinates made per pixel: not predicted, the filter is the scene's"
                    .clone_into(&mut choice.why);
            }
            Some(slot) => self.choose_filter(slot, budget, &mut choice),
        }
        choice
    }

    fn choose_filter(&self, slot: &TextureSlot, budget: Budget, choice: &mut Choice) {
        let material = &self.scene.materials[self.mesh.material];
        let texture = self.scene.textures[slot.texture]
            .clone()
            .with_origin(self.mesh.uv_origin);
        if let Some(color) = constant(&texture) {
            let border = [slot.sampler.wrap_u, slot.sampler.wrap_v]
                .contains(&texmap_sample::Wrap::ClampToBorder);
            let opaque = color[3] >= 1.0
                && material.alpha == AlphaMode::Opaque
                && material.opacity_map.is_none();
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
        let texture = if texture.levels() == 1 {
            texture.with_mips()
        } else {
            texture
        };
        let Some(pilot) = Pilot::new(self, slot, &texture) else {
            choice.filter = Some((slot.sampler.filter, slot.sampler.precision));
            "hardly seen: the filter is the scene's".clone_into(&mut choice.why);
            return;
        };
        choice.tried = pilot.len();
        let srgb = self.scene.color == ColorMode::Srgb;
        let mut best: Option<(f64, &Price)> = None;
        for price in prices() {
            let sampler = Sampler {
                filter: price.filter,
                precision: price.precision,
                ..slot.sampler.clone()
            };
            let predicted = pilot.error(&sampler, &texture, srgb);
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
        choice.price += price.ns;
        choice.why = if predicted <= budget.rmse {
            format!("the cheapest of {} filters that fits", prices().len())
        } else {
            "no filter fits: the most accurate".to_owned()
        };
        if !reads_mips(price.filter) {
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

/// Texels of affine error up to which w counts as equal: below the 8 sub-texel bits of any filter.
const EQUAL_W: f64 = 1.0 / 512.0;

/// The one colour of a texture, if it has but one.
fn constant(texture: &Texture2d<'_>) -> Option<[f32; 4]> {
    let first = texture.texel(0, 0, 0)?;
    let all = (0..texture.height()).flat_map(|y| (0..texture.width()).map(move |x| (x, y)));
    let same = |(x, y)| texture.texel(0, x, y) == Some(first);
    all.into_iter().all(same).then_some(first)
}

fn reads_mips(filter: Filter) -> bool {
    !matches!(
        filter,
        Filter::Nearest | Filter::Bilinear | Filter::Bicubic(_) | Filter::Gl { mip: Mip::None, .. }
    )
}
