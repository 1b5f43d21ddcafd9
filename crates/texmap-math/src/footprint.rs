//! The footprint of a pixel in texture space.

/// Change of uv over one pixel step to the right (x) and down (y), along the surface at the pixel centre. In uv units, not
/// texels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Change of u per pixel to the right.
    pub du_dx: f32,
    /// Change of v per pixel to the right.
    pub dv_dx: f32,
    /// Change of u per pixel down.
    pub du_dy: f32,
    /// Change of v per pixel down.
    pub dv_dy: f32,
}

impl Footprint {
    /// All four changes.
    #[inline]
    #[must_use]
    pub const fn new(du_dx: f32, dv_dx: f32, du_dy: f32, dv_dy: f32) -> Self {
        Self {
            du_dx,
            dv_dx,
            du_dy,
            dv_dy,
        }
    }
}
