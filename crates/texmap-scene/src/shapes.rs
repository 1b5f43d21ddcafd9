//! Meshes by description: displacement maps and billboards, which become triangles before a picture.

use texmap_math::glam::DVec3;

use crate::TextureSlot;

/// A height map that moves the surface of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Displacement {
    /// The heights: red channel, data. A filter with mip levels reads the level whose texels are as far apart as the vertices.
    pub slot: TextureSlot,
    /// Distance by which a value of 1 above `middle` moves the surface along its normal. In units of the object; negative moves
    /// it in.
    pub height: f32,
    /// The value that leaves the surface where it is.
    pub middle: f32,
    /// The longest edge of the finer triangles.
    pub budget: EdgeBudget,
    /// More triangles than this, of all displaced meshes together, are refused.
    pub max_triangles: u32,
}

impl Displacement {
    /// Edges of at most two pixels, black stays, at most [`MAX_TRIANGLES`](Self::MAX_TRIANGLES).
    #[must_use]
    pub fn new(slot: TextureSlot, height: f32) -> Self {
        Self {
            slot,
            height,
            middle: 0.0,
            budget: EdgeBudget::Pixels(2.0),
            max_triangles: Self::MAX_TRIANGLES,
        }
    }

    /// Triangles that are allowed unless said otherwise.
    pub const MAX_TRIANGLES: u32 = 4_000_000;
}

/// The longest edge of a displaced mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeBudget {
    /// Texels of the height map.
    Texels(f32),
    /// Pixels of the picture that a line of this length has, square to the view at the middle of the edge. The direction of
    /// the camera does not matter. No edge below half a texel is halved.
    Pixels(f32),
}

/// A rectangle that faces the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Billboard {
    /// Middle of the billboard, in world space.
    pub position: DVec3,
    /// Width and height, both above 0.
    pub size: [f64; 2],
    /// Orientation towards the camera.
    pub facing: Facing,
}

/// Orientation of a billboard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facing {
    /// Parallel to the picture, its top where the picture's top is: never seen edge-on.
    Screen,
    /// About this direction, its upright, towards the eye: trees. Seen along the axis it is edge-on: a line, which covers
    /// no pixel; from near there it is foreshortened, as a standing card is.
    Axis(DVec3),
}
