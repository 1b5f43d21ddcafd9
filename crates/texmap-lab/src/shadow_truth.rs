//! Shadow maps against shadow rays: false shadow and false light outside of the band around the edges of true shadows.

use texmap_bake::{BakeOptions, bake};
use texmap_light::{Light, ShadowBias, ShadowKind};
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_raster::{Atlas, AtlasMesh, AtlasOptions, Coverage, TargetSize};
use texmap_render::shadow_map_for;
use texmap_sample::Origin;
use texmap_scene::{Scene, shadow_kind};

use crate::LabError;
use crate::shadow_scene::{HALF, ShadowScene, across};

/// Points of the band that are looked at: eight on its rim, the others spread within, so dense that a shadow narrower than a texel is met.
const RIM: u32 = 8;
const SAMPLES: u32 = 200;

/// Points of a scene that face a light, each with the truth about its shadow.
#[derive(Debug)]
pub struct ShadowTruth<'s> {
    of: &'s ShadowScene,
    scene: Scene,
    points: Vec<Point>,
}

#[derive(Clone, Copy, Debug)]
struct Point {
    at: DVec3,
    /// Normal of its triangle's plane, on the side that is seen.
    normal: DVec3,
    dark: bool,
}

/// Points that a shadow map gets wrong, with nothing of a true shadow's edge within `pcf_size + 1` texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wrong {
    /// Points that face the light.
    pub facing: usize,
    /// Lit in truth, and not wholly lit by the map.
    pub shadow: usize,
    /// Dark in truth, and not wholly dark by the map.
    pub light: usize,
}

impl Wrong {
    /// Parts of the points that face the light: false shadow and false light.
    pub fn shares(&self) -> [f64; 2] {
        [self.shadow, self.light].map(|n| n as f64 / self.facing.max(1) as f64)
    }
}

impl std::iter::Sum for Wrong {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |a, b| Self {
            facing: a.facing + b.facing,
            shadow: a.shadow + b.shadow,
            light: a.light + b.light,
        })
    }
}

impl<'s> ShadowTruth<'s> {
    /// The points that a picture of `pixels` x `pixels` sees and a light (no ambient one) reaches.
    ///
    /// # Errors
    /// If the camera has no rays.
    pub fn new(of: &'s ShadowScene, light: Light, pixels: u32) -> Result<Self, LabError> {
        let mut scene = of.scene.clone();
        scene.lights = vec![light];
        let mut truth = Self {
            of,
            scene,
            points: Vec::new(),
        };
        for (at, normal) in of.points(pixels)? {
            if normal.dot(truth.to_light(at).normalize()) > 0.02 {
                let dark = truth.dark(at, normal);
                truth.points.push(Point { at, normal, dark });
            }
        }
        Ok(truth)
    }

    /// The bias of a scene that names none.
    pub fn default_bias(&self) -> ShadowBias {
        texmap_scene::shadow_bias(&self.scene)
    }

    /// Errors of a map of `size` texels with a bias and `pcf_size` x `pcf_size` comparisons.
    ///
    /// # Errors
    /// Sizes out of range.
    pub fn wrong(&self, size: u32, bias: ShadowBias, pcf_size: u32) -> Result<Wrong, LabError> {
        let kind = self.kind()?;
        let map = shadow_map_for(&self.scene, &kind, size, bias, pcf_size, 1)?;
        let mut wrong = Wrong {
            facing: self.points.len(),
            ..Wrong::default()
        };
        for point in &self.points {
            let lit = map.visibility(point.at, point.normal, bias, pcf_size);
            let right = if point.dark { 0.0 } else { 1.0 };
            if lit == right {
                continue;
            }
            let reach = f64::from(pcf_size + 1) * texel(&kind, size, point.at);
            if self.near_edge(point, reach) {
                continue;
            }
            wrong.shadow += usize::from(!point.dark);
            wrong.light += usize::from(point.dark);
        }
        Ok(wrong)
    }

    /// Texels of a light map of `texels` a side that are off by more than .02, of those that the light would reach without shadows,
    /// with a map of `size` texels under the default bias.
    ///
    /// # Errors
    /// Those of [`bake`].
    pub fn wrong_bake(
        &self,
        mesh: usize,
        texels: u32,
        size: u32,
        bias: ShadowBias,
        pcf_size: u32,
    ) -> Result<Wrong, LabError> {
        let kind = self.kind()?;
        let map = shadow_map_for(&self.scene, &kind, size, bias, pcf_size, 1)?;
        let shadows = [(0, map, bias, pcf_size)];
        let options = |shadows| BakeOptions {
            size: texels,
            gutter: 0,
            shadows,
            lights: None,
        };
        let shaded = bake(&self.scene, mesh, &options(&shadows))?;
        let free = bake(&self.scene, mesh, &options(&[]))?;
        let mesh = &self.scene.meshes[mesh];
        let atlas = Atlas::new(
            TargetSize::new(texels, texels)?,
            &AtlasMesh {
                uvs: &mesh.uvs,
                positions: &mesh.positions,
                normals: &[],
                indices: &mesh.triangles,
                bottom_up: mesh.uv_origin == Origin::BottomLeft,
            },
            AtlasOptions {
                conservative: true,
                gutter: 0,
                threads: 1,
                ..AtlasOptions::default()
            },
        )?;
        let place = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
        let mut wrong = Wrong::default();
        for (i, (shaded, free)) in shaded.texels.iter().zip(&free.texels).enumerate() {
            if atlas.coverage[i] == Coverage::None || free[0] <= 0.02 {
                continue;
            }
            wrong.facing += 1;
            let at = DVec3::from(atlas.position[i].map(f64::from));
            let [a, b, c] = mesh.triangles[atlas.face[i] as usize].map(place);
            let normal = (b - a).cross(c - a).normalize();
            let dark = self.dark(at, normal);
            let right = if dark { 0.0 } else { free[0] };
            let point = Point { at, normal, dark };
            let reach = f64::from(pcf_size + 1) * texel(&kind, size, at);
            if (shaded[0] - right).abs() > 0.02 && !self.near_edge(&point, reach) {
                wrong.shadow += usize::from(!dark);
                wrong.light += usize::from(dark);
            }
        }
        Ok(wrong)
    }

    fn kind(&self) -> Result<ShadowKind, LabError> {
        let parallel = matches!(self.scene.lights[0], Light::Directional { .. });
        let area = parallel.then_some((DVec3::ZERO, HALF));
        Ok(shadow_kind(&self.scene, 0, area)?)
    }

    /// To a light's position, or far along parallel light.
    fn to_light(&self, at: DVec3) -> DVec3 {
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        match self.scene.lights[0] {
            Light::Directional { direction, .. } => wide(direction).normalize() * -100.0,
            Light::Point { position, .. }
            | Light::Spot { position, .. }
            | Light::Punctual { position, .. } => wide(position) - at,
            _ => DVec3::Z,
        }
    }

    fn dark(&self, at: DVec3, normal: DVec3) -> bool {
        let from = at + normal * 1e-4;
        self.of.rays.blocked(from, from + self.to_light(from))
    }

    /// True if the light differs anywhere within `reach` of a point, seen from the light.
    fn near_edge(&self, point: &Point, reach: f64) -> bool {
        let (a, b) = across(self.to_light(point.at).normalize());
        (0..SAMPLES).any(|k| {
            let within = f64::from(k.saturating_sub(RIM)) / f64::from(SAMPLES - RIM);
            let (radius, turn) = if k < RIM {
                (1.0, f64::from(k) * std::f64::consts::FRAC_PI_4)
            } else {
                // The golden angle.
                (within.sqrt(), f64::from(k) * 2.399_963)
            };
            let (sin, cos) = deterministic_f64::sin_cos(turn);
            let place = point.at + (a * cos + b * sin) * (radius * reach);
            let toward = self.to_light(place).normalize();
            let beside = self.of.surface_beside(place + toward * 1e-7, toward);
            beside.is_none_or(|(p, n)| self.dark(p, n) != point.dark)
                || (!point.dark && self.hides_shadow(point, place, toward, reach))
        })
    }

    /// True if something dark stands between the light and the plane of a point that is lit, at a point beside it: the far side of a
    /// ridge, or the shadow behind it, which may be less than a texel wide as the light sees them.
    fn hides_shadow(&self, point: &Point, place: DVec3, toward: DVec3, reach: f64) -> bool {
        let plane = point.normal.dot(point.at - place) / point.normal.dot(toward);
        let mut along = plane.max(0.0) + 16.0 * reach;
        for _ in 0..12 {
            let (from, left) = (place + toward * along, along - plane);
            let Some(hit) = self.of.rays.nearest(from, -toward, (0.0, left)) else {
                return false;
            };
            along -= hit.t + 1e-6;
            if along - plane < 1e-3 * reach {
                return false;
            }
            let normal = self.of.plane(&hit);
            let side = if normal.dot(toward) < 0.0 { -1.0 } else { 1.0 };
            if self.dark(hit.point, normal * side) {
                return true;
            }
        }
        false
    }
}

/// World size of a texel of a map at a point.
fn texel(kind: &ShadowKind, size: u32, at: DVec3) -> f64 {
    let side = match *kind {
        ShadowKind::Directional { half, .. } => 2.0 * half,
        ShadowKind::Spot {
            light_from_world,
            tan_half,
        } => -2.0 * tan_half * light_from_world.transform_point3(at).z,
        ShadowKind::Point { position } => 2.0 * (at - position).abs().max_element(),
    };
    side / f64::from(size)
}
