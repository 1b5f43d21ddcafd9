//! Cameras that show a whole model, and the light for a model that brings none.

mod bounds;
mod bright_lights;
mod fit;
mod model_light;
mod studio;

use std::borrow::Borrow;
use std::convert::Infallible;
use std::str::FromStr;

use texmap_light::Light;
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_scene::Scene;

pub use bounds::Bounds;
pub use bright_lights::dim_bright_lights;
pub use model_light::{light_as_model, light_dark_surfaces, light_model, metallic_surfaces};
pub use studio::{light_by_studio, renew_studio, studio};

/// The axis of a model that points up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Up {
    /// +Y is up and +Z is the front, as in OBJ and glTF.
    #[default]
    Y,
    /// +Z is up and -Y is the front, as in STL files and in Blender.
    Z,
}

impl Up {
    /// The direction itself.
    #[must_use]
    pub fn direction(self) -> DVec3 {
        self.turn(DVec3::Y)
    }

    /// A direction of a model with +Y up, in a model with this axis up.
    #[must_use]
    pub fn turn(self, v: DVec3) -> DVec3 {
        match self {
            Self::Y => v,
            Self::Z => DVec3::new(v.x, -v.z, v.y),
        }
    }
}

/// The side from which a model is seen: for +Y up, the front is +Z and the right is +X; [`Up`] turns all of it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum View {
    /// From the front, 35 degrees to the right and 20 above: the view of a model without a camera.
    #[default]
    ThreeQuarter,
    /// From +Z.
    Front,
    /// From -Z.
    Back,
    /// From -X.
    Left,
    /// From +X.
    Right,
    /// From +Y, with the front at the lower edge.
    Top,
    /// From -Y, with the front at the upper edge.
    Bottom,
    /// From the front, right and above, equally.
    Iso,
}

/// From the model to the eye in the three-quarter view, unit length: (sin 35 cos 20, sin 20, cos 35 cos 20).
const THREE_QUARTER: DVec3 = DVec3::new(
    0.538_985_544_695_758_5,
    0.342_020_143_325_668_7,
    0.769_751_131_320_057_7,
);

impl View {
    /// Every view and its word.
    pub const ALL: [(&'static str, Self); 8] = [
        ("three-quarter", Self::ThreeQuarter),
        ("front", Self::Front),
        ("back", Self::Back),
        ("left", Self::Left),
        ("right", Self::Right),
        ("top", Self::Top),
        ("bottom", Self::Bottom),
        ("iso", Self::Iso),
    ];

    /// The word of the view.
    pub fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(_, view)| *view == self)
            .map_or("", |(name, _)| name)
    }

    /// From the model to the eye, any length.
    fn direction(self, up: Up) -> DVec3 {
        up.turn(match self {
            Self::ThreeQuarter => THREE_QUARTER,
            Self::Front => DVec3::Z,
            Self::Back => DVec3::NEG_Z,
            Self::Left => DVec3::NEG_X,
            Self::Right => DVec3::X,
            Self::Top => DVec3::Y,
            Self::Bottom => DVec3::NEG_Y,
            Self::Iso => DVec3::ONE,
        })
    }

    fn up(self, up: Up) -> DVec3 {
        up.turn(match self {
            Self::Top => DVec3::NEG_Z,
            Self::Bottom => DVec3::Z,
            _ => DVec3::Y,
        })
    }
}

impl FromStr for View {
    type Err = &'static str;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.iter().find(|(name, _)| *name == word);
        found
            .map(|(_, view)| *view)
            .ok_or("know three-quarter, front, back, left, right, top, bottom, iso")
    }
}

/// A camera that shows a whole model: the projections of its vertices fill [`FILL`](Self::FILL) of the width or of the height of the
/// picture, whichever they fill first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Framing {
    /// The side that is seen.
    pub view: View,
    /// The axis of the model that points up.
    pub up: Up,
    /// Horizontal field of view, radians; a parallel projection looks from as far away.
    pub fov_x: f64,
    /// True for a parallel (orthographic) projection instead of a central one.
    pub parallel: bool,
}

impl Default for Framing {
    /// The three-quarter view with +Y up and a field of view of 40 degrees.
    fn default() -> Self {
        Self {
            view: View::default(),
            up: Up::default(),
            fov_x: AUTO_FOV,
            parallel: false,
        }
    }
}

impl Framing {
    /// Fraction of the picture's width or height that a model fills.
    pub const FILL: f64 = 0.9;

    /// The camera for a picture of `aspect` = width / height; `None` for a scene without triangles.
    #[must_use]
    pub fn camera(&self, scene: &Scene, aspect: f64) -> Option<Camera> {
        self.camera_over([Ok::<_, Infallible>(scene)], aspect)
            .unwrap_or_else(|never| match never {})
    }

    /// The camera that shows the whole of a model in each of its poses; `None` for scenes without triangles.
    ///
    /// # Errors
    /// The first of the poses.
    pub fn camera_over<E>(
        &self,
        poses: impl IntoIterator<Item = Result<impl Borrow<Scene>, E>>,
        aspect: f64,
    ) -> Result<Option<Camera>, E> {
        let back = self.view.direction(self.up);
        fit::whole(poses, self, back, self.view.up(self.up), aspect)
    }

    /// The cameras of `frames` pictures around the model, counter-clockwise seen from above, the first from the side of the view:
    /// all at one distance, so that the widest view of the model fills [`FILL`](Self::FILL). Empty for a scene without triangles.
    #[must_use]
    pub fn turntable(&self, scene: &Scene, aspect: f64, frames: u32) -> Vec<Camera> {
        let back = self.view.direction(self.up);
        fit::turntable(scene, self, back, aspect, frames)
    }
}

/// Horizontal field of view of automatic cameras: 40 degrees.
pub const AUTO_FOV: f64 = 40.0 * core::f64::consts::PI / 180.0;

/// The light of a model that brings none: a key from the upper left front, a weaker one from the other side, ambient.
pub fn auto_lights(up: Up) -> Vec<Light> {
    let toward = |x: f64, y: f64, z: f64| up.turn(DVec3::new(x, y, z)).to_array().map(|c| c as f32);
    vec![
        Light::Ambient { color: [0.35; 3] },
        Light::Directional {
            color: [0.65; 3],
            direction: toward(0.5, -0.8, -0.7),
        },
        Light::Directional {
            color: [0.25; 3],
            direction: toward(-0.6, -0.3, 0.7),
        },
    ]
}
