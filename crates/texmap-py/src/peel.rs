//! Depth peeling: the surface behind that of the layer before.

use texmap_raster::{AlphaTest, Fragment};

/// Depths (reversed) and triangles of each pixel of a layer.
pub(crate) struct Layer<'a> {
    pub(crate) depths: &'a mut [f32],
    pub(crate) ids: &'a mut [u32],
    /// There is no layer before.
    pub(crate) first: bool,
}

/// Keeps fragments behind those of a layer. Of fragments at one depth the order of submission decides, so that each has a layer.
pub(crate) struct Peel<'a> {
    pub(crate) width: u32,
    pub(crate) depths: &'a [f32],
    pub(crate) ids: &'a [u32],
}

impl AlphaTest for Peel<'_> {
    fn keep(&self, _draw: u32, triangle: u32, fragment: &Fragment) -> bool {
        let [x, y] = fragment.pixel.map(|c| c as usize);
        let at = y * self.width as usize + x;
        let (depth, id) = (self.depths[at], self.ids[at]);
        fragment.depth < depth || (fragment.depth == depth && triangle > id && id != u32::MAX)
    }
}
