//! Forward against inverse mapping (Brackeen 2003, chapter 8): texel to pixel with its holes and overdraw, pixel to texel.

use serde::Deserialize;
use texmap_math::glam::DVec2;
use texmap_sample::{EdgeMode, Filter};
use texmap_truth::picture::{Picture, Rgba};
use texmap_truth::strip::heat;

use crate::answer::Answer;
use crate::load::Files;
use crate::rectify::{between, corners, warp};

const SKY: Rgba = [204, 217, 230, 255];
const HOLE: Rgba = [255, 0, 160, 255];

/// A picture on a quad of the screen.
#[derive(Clone, Debug, Deserialize)]
pub struct Forward {
    picture: String,
    /// The picture is read at so many texels a side.
    texels: u32,
    size: [u32; 2],
    /// Parts of the screen's width and height, in order around the quad from the picture's upper left corner.
    corners: [[f64; 2]; 4],
}

impl Forward {
    pub(crate) fn answer(&self, files: &Files) -> Result<Answer, String> {
        let [width, height] = self.size.map(|n| n.clamp(16, 1024));
        let texels = self.texels.clamp(2, 512);
        let texture = files.texture(&self.picture)?;
        let side = f64::from(texels);
        let whole = [texture.width(), texture.height()].map(f64::from);
        let read = between(corners(whole), corners([side, side]))?;
        let source = warp(
            &texture,
            Filter::Trilinear,
            &read,
            EdgeMode::Edge,
            [texels, texels],
        )?;
        let quad = self
            .corners
            .map(|[x, y]| DVec2::new(x * f64::from(width), y * f64::from(height)));
        let map = between(corners([side, side]), quad)?;

        let index = |x: u32, y: u32| (y * width + x) as usize;
        let mut writes = vec![0u32; (width * height) as usize];
        let mut forward = Picture::new(width, height, SKY);
        for texel in 0..texels * texels {
            let (u, v) = (texel % texels, texel / texels);
            let centre = DVec2::new(f64::from(u) + 0.5, f64::from(v) + 0.5);
            let Some(at) = map.apply(centre).map(DVec2::floor) else {
                continue;
            };
            if at.x >= 0.0 && at.y >= 0.0 && at.x < f64::from(width) && at.y < f64::from(height) {
                forward.set(at.x as i64, at.y as i64, source.get(u.into(), v.into()));
                writes[index(at.x as u32, at.y as u32)] += 1;
            }
        }
        let back = map.inverse();
        let mut inverse = Picture::new(width, height, SKY);
        let (mut pixels, mut holes) = (0u32, 0u32);
        let mut seen = vec![false; (texels * texels) as usize];
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let inside = |p: &DVec2| p.x >= 0.0 && p.y >= 0.0 && p.x < side && p.y < side;
            let Some(at) = back.apply(centre).filter(inside) else {
                continue;
            };
            let (u, v) = (at.x as u32, at.y as u32);
            inverse.set(x.into(), y.into(), source.get(u.into(), v.into()));
            seen[(v * texels + u) as usize] = true;
            pixels += 1;
            if writes[index(x, y)] == 0 {
                holes += 1;
                forward.set(x.into(), y.into(), HOLE);
            }
        }
        let written: u32 = writes.iter().sum();
        let once = writes.iter().filter(|n| **n > 0).count() as f64;
        let most = writes.iter().copied().max().unwrap_or(0);
        let counts = Picture::from_fn(width, height, |x, y| {
            heat(f64::from(writes[index(x, y)]) / f64::from(most.max(1)))
        });
        let mut answer = Answer::default();
        answer.picture("texel to pixel: holes are pink", &forward);
        answer.picture("pixel to texel", &inverse);
        answer.picture("writes of each pixel, white: the most", &counts);
        answer.figure("texels written", written.into(), "");
        answer.figure("pixels of the quad", pixels.into(), "");
        answer.figure("holes", holes.into(), "pixels");
        answer.figure("texels overwritten", f64::from(written) - once, "");
        answer.figure("most writes of a pixel", most.into(), "");
        let unseen = seen.iter().filter(|seen| !**seen).count();
        answer.figure("texels that no pixel shows", unseen as f64, "");
        Ok(answer)
    }
}
