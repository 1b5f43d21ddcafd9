//! Forward mapping: each texel to the pixel that its centre falls into, with overdraw and holes counted.

use serde::Serialize;
use texmap_math::Homography;
use texmap_math::glam::DVec2;
use texmap_sample::Texture2d;

/// Texels and pixels of a forward map, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Counts {
    /// Texels of the image.
    pub(super) texels: u64,
    /// Texels that fell outside of the output, or beyond the horizon.
    pub(super) outside: u64,
    /// Pixels that got a texel.
    pub(super) pixels: u64,
    /// Texels that a later one of the same pixel replaced.
    pub(super) overdrawn: u64,
    /// Pixels within the mapped image that got no texel.
    pub(super) holes: u64,
}

impl Counts {
    /// One line for people.
    pub(super) fn words(&self) -> String {
        let Self {
            texels,
            outside,
            pixels,
            overdrawn,
            holes,
        } = self;
        format!(
            "{texels} texels: {pixels} pixels written, {overdrawn} texels overdrawn, {outside} outside; {holes} holes"
        )
    }
}

/// The picture that writing texel after texel gives, linear and premultiplied, transparent where nothing was written. Of several texels of a
/// pixel the last stays. `map` leads from positions of the image to those of the output.
pub(super) fn forward(
    t: &Texture2d<'_>,
    map: &Homography,
    (width, height): (u32, u32),
) -> (Vec<[f32; 4]>, Counts) {
    let source = DVec2::new(t.width().into(), t.height().into());
    // The side of the horizon that the middle of the image is on.
    let side = map.apply_homogeneous(source * 0.5).z.signum();
    let ahead = |p: DVec2| map.apply_homogeneous(p).z * side > 0.0;
    let mut pixels = vec![[0.0; 4]; width as usize * height as usize];
    let mut written = vec![false; pixels.len()];
    let mut counts = Counts {
        texels: u64::from(t.width()) * u64::from(t.height()),
        ..Counts::default()
    };
    let cells = |w: u32, h: u32| (0..h).flat_map(move |y| (0..w).map(move |x| (x, y)));
    let centre = |x: u32, y: u32| DVec2::new(x.into(), y.into()) + 0.5;
    let within = |p: DVec2, size: DVec2| p.cmpge(DVec2::ZERO).all() && p.cmplt(size).all();
    let target = DVec2::new(width.into(), height.into());
    for (x, y) in cells(t.width(), t.height()) {
        let p = centre(x, y);
        let found = map.apply(p).filter(|q| ahead(p) && within(*q, target));
        let Some(q) = found else {
            counts.outside += 1;
            continue;
        };
        let pixel = q.y as usize * width as usize + q.x as usize;
        counts.overdrawn += u64::from(written[pixel]);
        written[pixel] = true;
        pixels[pixel] = t.texel(0, x, y).unwrap_or_default();
    }
    let back = map.inverse();
    for ((x, y), written) in cells(width, height).zip(&written) {
        counts.pixels += u64::from(*written);
        let inside = |p: &DVec2| ahead(*p) && within(*p, source);
        let covered = back.apply(centre(x, y)).as_ref().is_some_and(inside);
        counts.holes += u64::from(covered && !written);
    }
    (pixels, counts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::glam::{DMat3, DVec3};
    use texmap_sample::{ColorSpace, Origin};

    fn picture(side: u32) -> Texture2d<'static> {
        let texels = (0..side * side).flat_map(|i| [(i % 256) as u8, (i / 256) as u8, 7, 255]);
        Texture2d::from_rgba8(
            side,
            side,
            texels.collect(),
            ColorSpace::Linear,
            Origin::TopLeft,
        )
        .unwrap()
    }

    fn scaled(factor: f64) -> Homography {
        Homography::from_matrix(DMat3::from_diagonal(DVec3::new(factor, factor, 1.0))).unwrap()
    }

    /// Twice as large: of four pixels three are holes. Half as large: of four texels three are overdrawn. As it is: neither.
    #[test]
    fn holes_and_overdraw_are_those_of_the_scale() {
        let t = picture(32);
        let (pixels, same) = forward(&t, &scaled(1.0), (32, 32));
        assert_eq!(
            (same.pixels, same.overdrawn, same.holes, same.outside),
            (1024, 0, 0, 0)
        );
        assert_eq!(pixels[37], t.texel(0, 5, 1).unwrap());
        let (_, large) = forward(&t, &scaled(2.0), (64, 64));
        assert_eq!(
            (large.pixels, large.overdrawn, large.holes),
            (1024, 0, 3 * 1024)
        );
        let (small, counts) = forward(&t, &scaled(0.5), (32, 32));
        assert_eq!(
            (counts.pixels, counts.overdrawn, counts.holes),
            (256, 768, 0)
        );
        assert_eq!(
            small[0],
            t.texel(0, 1, 1).unwrap(),
            "the last of four stays"
        );
        let (_, cut) = forward(&t, &scaled(2.0), (16, 16));
        assert_eq!((cut.pixels, cut.outside, cut.holes), (64, 1024 - 64, 192));
    }

    /// Texels beyond the horizon are outside, not mirrored into the picture.
    #[test]
    fn nothing_comes_from_beyond_the_horizon() {
        let m = DMat3::from_cols(DVec3::new(1.0, 0.0, -0.04), DVec3::Y, DVec3::Z);
        let map = Homography::from_matrix(m).unwrap();
        let (_, counts) = forward(&picture(32), &map, (4096, 64));
        assert!(counts.outside >= 7 * 32, "{counts:?}");
        assert_eq!(
            counts.pixels + counts.overdrawn + counts.outside,
            counts.texels
        );
    }
}
