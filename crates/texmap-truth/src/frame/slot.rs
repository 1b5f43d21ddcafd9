//! A texture as a surface reads it: transformed coordinates, filtered texels, outlines, ramps.

use texmap_math::glam::{DVec2, DVec3, DVec4};
use texmap_sample::{Filter, Lod, Origin, Sampler, Texture2d, reference as sampling};
use texmap_scene::{Scene, TextureSlot, UvSet};

use super::color::straight;

/// Coordinates and their change for one sample to the right and one down.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    pub(super) uv: DVec2,
    pub(super) dx: DVec2,
    pub(super) dy: DVec2,
}

/// The textures of a scene, each with its mip levels, and with its sums, once some slot reads it.
pub(super) struct Textures<'s> {
    scene: &'s Scene,
    ready: Vec<Option<Texture2d<'static>>>,
}

impl<'s> Textures<'s> {
    pub(super) fn new(scene: &'s Scene) -> Self {
        let ready = vec![None; scene.textures.len()];
        Self { scene, ready }
    }

    fn get(&mut self, index: usize) -> Texture2d<'static> {
        let own = &self.scene.textures[index];
        let ready = &mut self.ready[index];
        let build = || match own.levels() {
            1 => own.clone().with_mips(),
            _ => own.clone(),
        };
        ready.get_or_insert_with(build).clone()
    }

    fn read_by(&mut self, slot: &TextureSlot) -> Texture2d<'static> {
        let made = self.get(slot.texture).prepared_for(slot.sampler.filter);
        self.ready[slot.texture] = Some(made.clone());
        made
    }

    /// A slot whose v = 0 lies where `origin` says.
    pub(super) fn slot(&mut self, slot: &'s TextureSlot, origin: Origin) -> Slot<'s> {
        Slot {
            sampler: &slot.sampler,
            texture: self.read_by(slot).with_origin(origin),
            rows: slot.transform.rows().map(|row| row.map(f64::from)),
            uv_set: slot.uv_set,
        }
    }

    /// A picture by itself, v = 0 at its top.
    pub(super) fn picture(&mut self, index: usize) -> Texture2d<'static> {
        self.get(index).with_origin(Origin::TopLeft)
    }
}

pub(super) struct Slot<'s> {
    pub(super) sampler: &'s Sampler,
    pub(super) texture: Texture2d<'static>,
    /// Rows of the transform of coordinates.
    rows: [[f64; 3]; 2],
    /// The coordinates of the mesh that it reads.
    pub(super) uv_set: UvSet,
}

impl Slot<'_> {
    /// Texture coordinates of the mesh in those of the slot.
    pub(super) fn placed(&self, place: Place) -> Place {
        let [[a, b, c], [d, e, f]] = self.rows;
        let turn = |p: DVec2| DVec2::new(a * p.x + b * p.y, d * p.x + e * p.y);
        Place {
            uv: turn(place.uv) + DVec2::new(c, f),
            dx: turn(place.dx),
            dy: turn(place.dy),
        }
    }

    /// The filtered texel: linear, premultiplied.
    pub(super) fn texel(&self, place: Place) -> DVec4 {
        self.filtered(self.placed(place))
    }

    /// The texel at coordinates of the slot.
    pub(super) fn filtered(&self, at: Place) -> DVec4 {
        sample(self.sampler, &self.texture, at)
    }

    /// The filtered texel without its alpha.
    pub(super) fn straight(&self, place: Place) -> DVec3 {
        straight(self.texel(place))
    }

    /// Opacity of an opacity map: its alpha, or its red channel if it has none.
    pub(super) fn opacity(&self, place: Place) -> f64 {
        let texel = self.texel(place);
        if self.texture.has_alpha() {
            texel.w
        } else {
            texel.x
        }
    }

    /// The texel of a ramp at 0 to 1 along it.
    pub(super) fn along(&self, at: f64) -> DVec4 {
        let texel = sampling::sample_lod(self.sampler, &self.texture, [at, 0.5], 0.0);
        DVec4::from_array(texel)
    }

    /// The texel of a ramp where the first channel of this texture points: a dependent look-up, of the bilinear picture of the level
    /// nearest to the one that the sample asks for.
    pub(super) fn dependent(&self, place: Place, ramp: &Slot<'_>) -> DVec4 {
        let at = self.placed(place);
        let lod = self.lod(at);
        let value = |uv: DVec2| self.bilinear(uv, lod).x;
        let (dx, dy) = (self.slope(at, at.dx, value), self.slope(at, at.dy, value));
        let at = Place {
            uv: DVec2::new(value(at.uv), 0.5),
            dx: DVec2::new(dx, 0.0),
            dy: DVec2::new(dy, 0.0),
        };
        ramp.filtered(at)
    }

    /// Level of detail at coordinates of the slot.
    fn lod(&self, at: Place) -> f64 {
        let gradient = [at.dx.x, at.dx.y, at.dy.x, at.dy.y];
        sampling::lod(self.sampler, &self.texture, gradient)
    }

    /// The share of a sample inside of the outline where the alpha of the bilinear picture is a half. `filtered` is the alpha that the
    /// filter gave, which is the coverage where a sample sees more than a texel (Green 2007, SIGGRAPH course "Improved Alpha-Tested
    /// Magnification").
    pub(super) fn outline(&self, place: Place, filtered: f64) -> f64 {
        let at = self.placed(place);
        if self.lod(at) > 0.0 {
            return filtered;
        }
        let alpha = |uv: DVec2| self.bilinear(uv, 0.0).w;
        let change = DVec2::new(self.slope(at, at.dx, alpha), self.slope(at, at.dy, alpha));
        let inside = alpha(at.uv) - 0.5;
        let width = change.length().min(1.0);
        if width > 0.0 {
            (inside / width + 0.5).clamp(0.0, 1.0)
        } else {
            f64::from(u8::from(inside >= 0.0))
        }
    }

    /// The bilinear picture of the level nearest to a level of detail.
    fn bilinear(&self, uv: DVec2, lod: f64) -> DVec4 {
        let sampler = Sampler {
            filter: Filter::BilinearMipNearest,
            lod: Lod::default(),
            ..self.sampler.clone()
        };
        let texel = sampling::sample_lod(&sampler, &self.texture, uv.to_array(), lod);
        DVec4::from_array(texel)
    }

    /// Change of a value along a step of the coordinates, by a central difference of a thousandth of it.
    fn slope(&self, at: Place, step: DVec2, value: impl Fn(DVec2) -> f64) -> f64 {
        let beside = step * 1e-3;
        (value(at.uv + beside) - value(at.uv - beside)) / 2e-3
    }
}

/// A texture through a sampler at its own coordinates.
pub(super) fn sample(sampler: &Sampler, texture: &Texture2d<'_>, at: Place) -> DVec4 {
    let gradient = [at.dx.x, at.dx.y, at.dy.x, at.dy.y];
    DVec4::from_array(sampling::sample_grad(
        sampler,
        texture,
        at.uv.to_array(),
        gradient,
    ))
}
