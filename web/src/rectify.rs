//! A photo through four points: `texmap warp` with its defaults.

use serde::Deserialize;
use texmap_io::PixelCode;
use texmap_math::glam::DVec2;
use texmap_math::{Homography, Level};
use texmap_sample::{ColorSpace, EdgeMode, Filter, Resample, Texture2d};
use texmap_truth::picture::Picture;

use crate::answer::Answer;
use crate::load::Files;
use crate::plot::{INK, WRONG};

/// Four points of a photo that become the corners of a picture.
#[derive(Clone, Debug, Deserialize)]
pub struct Rectify {
    photo: String,
    /// Parts of the photo's width and height, in order around the quad from the upper left corner.
    from: [[f64; 2]; 4],
    /// Width and height of the result.
    size: [u32; 2],
    filter: String,
    /// Width at which the photo is shown.
    shown: u32,
}

impl Files {
    /// The texture that a picture file gives, with mips.
    pub(crate) fn texture(&self, name: &str) -> Result<Texture2d<'static>, String> {
        let text = format!("texture \"{name}\"\nv 0 0 0\nv 1 0 0\nv 0 1 0\ntf 0 0 0 1 1 0 2 0 1\n");
        let mut scene = self.scene("texture.scene", Some(&text), 1.0)?;
        let texture = scene.textures.pop();
        let texture = texture.ok_or_else(|| format!("{name}: no picture"))?;
        Ok(texture.with_mips())
    }
}

/// Draws a texture through a homography of pixels.
pub(crate) fn warp(
    texture: &Texture2d<'_>,
    filter: Filter,
    output_from_source: &Homography,
    outside: EdgeMode,
    [width, height]: [u32; 2],
) -> Result<Picture, String> {
    let resample = Resample::new(texture, filter, outside, output_from_source);
    let mut colors = vec![[0.0f32; 4]; width as usize * height as usize];
    let drawn = resample.rows(Level::new(), width, 0, &mut colors);
    drawn.map_err(|e| e.to_string())?;
    let code = PixelCode::Png8(ColorSpace::Srgb);
    let mut rgba = vec![0; colors.len() * code.bytes()];
    let _ = code.encode(&colors, &mut rgba);
    Picture::from_rgba(width, height, rgba).ok_or_else(|| "the picture has no pixels".to_owned())
}

/// The map between two quads, or a sentence for the user.
pub(crate) fn between(from: [DVec2; 4], to: [DVec2; 4]) -> Result<Homography, String> {
    Homography::from_quads(from, to).map_err(|e| {
        format!("the four points give no map: {e}\nkeep the quad convex, no three points on a line")
    })
}

/// The corners of a rectangle, from the upper left one clockwise.
pub(crate) fn corners([width, height]: [f64; 2]) -> [DVec2; 4] {
    [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]].map(DVec2::from)
}

impl Rectify {
    pub(crate) fn answer(&self, files: &Files) -> Result<Answer, String> {
        let texture = files.texture(&self.photo)?;
        let filter = self.filter.parse().map_err(|_| "unknown filter")?;
        let whole = [texture.width(), texture.height()].map(f64::from);
        let from = self
            .from
            .map(|[x, y]| DVec2::new(x * whole[0], y * whole[1]));
        let size = self.size.map(|n| n.clamp(1, 4096));
        let to = corners(size.map(f64::from));
        let map = between(from, to)?;
        let mut answer = Answer::default();
        answer.picture(
            "the plane, rectified",
            &warp(&texture, filter, &map, EdgeMode::Transparent, size)?,
        );

        let shown = self.shown.clamp(64, 1024);
        let height = (f64::from(shown) * whole[1] / whole[0])
            .round()
            .clamp(16.0, 2048.0);
        let small = between(corners(whole), corners([f64::from(shown), height]))?;
        let mut photo = warp(
            &texture,
            Filter::Trilinear,
            &small,
            EdgeMode::Edge,
            [shown, height as u32],
        )?;
        let place = |p: DVec2| {
            small
                .apply(p)
                .map_or((0, 0), |p| (p.x.round() as i64, p.y.round() as i64))
        };
        for i in 0..4 {
            let (a, b) = (place(from[i]), place(from[(i + 1) % 4]));
            photo.line((a.0, a.1 + 1), (b.0, b.1 + 1), INK);
            photo.line(a, b, WRONG);
        }
        answer.picture("the photo with its four points", &photo);
        let worst = from
            .iter()
            .zip(to)
            .filter_map(|(a, b)| Some((map.apply(*a)? - b).length()));
        answer.expected(
            "largest error at the corners",
            worst.fold(0.0, f64::max),
            0.0,
            "pixels",
        );
        let around = from
            .iter()
            .filter_map(|p| Some((map.inverse().apply(map.apply(*p)?)? - *p).length()));
        answer.expected("there and back", around.fold(0.0, f64::max), 0.0, "pixels");
        answer.figure("condition of the map", map.condition(), "");
        for (i, p) in from.iter().enumerate() {
            answer.figure(format!("x{}", i + 1), p.x, "point");
            answer.figure(format!("y{}", i + 1), p.y, "point");
        }
        Ok(answer)
    }
}
