//! A pixel in the texture: the quad that its square covers, the ellipse and the level that filters take for it.

use serde::Deserialize;
use texmap_math::Homography;
use texmap_math::glam::DVec2;
use texmap_render::{Aov, AovData, Frame};
use texmap_sample::{EdgeMode, Filter};

use crate::answer::Answer;
use crate::compare;
use crate::draw::{self, Methods};
use crate::load::Files;
use crate::plot::{RIGHT, WRONG};
use crate::rectify::{between, corners, warp};

/// A pixel of a scene of one flat textured face.
#[derive(Clone, Debug, Deserialize)]
pub struct PixelFootprint {
    text: String,
    texture: String,
    /// Texels a side of the texture.
    texels: f64,
    size: [u32; 2],
    /// Parts of the picture's width and height.
    pixel: [f64; 2],
    /// The part of the texture that is shown: texels around the footprint.
    window: f64,
    reference: Option<String>,
}

impl PixelFootprint {
    pub(crate) fn answer(&self, files: &Files) -> Result<Answer, String> {
        let [width, height] = self.size;
        let mut settings = Methods::default().settings(self.size, false)?;
        settings.aovs = vec![Aov::Uv, Aov::Lod];
        let (_, mut frame) = draw::drawn(files, "page.scene", Some(&self.text), &settings)?;
        let place = |part: f64, n: u32| {
            (part * f64::from(n))
                .clamp(3.0, f64::from(n.max(8)) - 4.0)
                .floor()
        };
        let (x, y) = (place(self.pixel[0], width), place(self.pixel[1], height));
        let mut answer = Answer::default();
        let map = texture_from_screen(&frame, x as i64, y as i64, self.texels);
        let lod = value(&frame, Aov::Lod, x as i64, y as i64, 0);
        frame.aovs.clear();
        let mut marked = texmap_truth::picture::Picture::from_rgba(
            width,
            height,
            std::mem::take(&mut frame.rgba),
        )
        .ok_or("the picture has no pixels")?;
        let bytes = marked.rgba().to_vec();
        marked.frame(x as i64 - 4, y as i64 - 4, 9, 9, WRONG);
        marked.frame(x as i64 - 5, y as i64 - 5, 11, 11, [255, 255, 255, 255]);
        answer.picture("picture", &marked);
        if let Some(map) = map {
            self.texture_panel(files, &map, (x, y), &mut answer)?;
        }
        match lod {
            Some(lod) => answer.figure("level of detail", lod, ""),
            None => answer
                .warnings
                .push("the ray of this pixel meets no floor: move the handle down".to_owned()),
        }
        if let Some(text) = &self.reference {
            let mut settings = Methods::default().settings(self.size, false)?;
            settings.supersample = 8;
            let (_, right) = draw::drawn(files, "page.scene", Some(text), &settings)?;
            frame.rgba = bytes;
            compare::with_frame(&frame, &right, None).tell(&mut answer, None, None);
        }
        Ok(answer)
    }

    fn texture_panel(
        &self,
        files: &Files,
        map: &Homography,
        (x, y): (f64, f64),
        answer: &mut Answer,
    ) -> Result<(), String> {
        let corner = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let quad = corner.map(|(a, b)| map.apply(DVec2::new(x + a, y + b)));
        let [Some(a), Some(b), Some(c), Some(d)] = quad else {
            return Ok(());
        };
        let centre = (a + b + c + d) / 4.0;
        // The axes of the parallelogram of the derivatives, as an ellipse.
        let (across, down) = ((b - a + c - d) / 2.0, (d - a + c - b) / 2.0);
        let (long, short) = axes(across, down);
        let window = self.window.clamp(4.0, 1024.0);
        let low = centre - DVec2::splat(window / 2.0);
        let side = 384u32;
        let zoom = f64::from(side) / window;
        let texture = files.texture(&self.texture)?;
        // The texture repeats: the window is moved into it.
        let start = DVec2::new(low.x.rem_euclid(self.texels), low.y.rem_euclid(self.texels));
        let shown = corners([window, window]).map(|p| p + start);
        let view = between(shown, corners([f64::from(side); 2]))?;
        let filter = if zoom >= 1.0 {
            Filter::Nearest
        } else {
            Filter::Trilinear
        };
        let mut picture = warp(&texture, filter, &view, EdgeMode::Repeat, [side, side])?;
        let place = |p: DVec2| {
            let p = (p - low) * zoom;
            (p.x.round() as i64, p.y.round() as i64)
        };
        for (from, to) in [(a, b), (b, c), (c, d), (d, a)] {
            let (from, to) = (place(from), place(to));
            picture.line((from.0 + 1, from.1), (to.0 + 1, to.1), [255, 255, 255, 255]);
            picture.line(from, to, WRONG);
        }
        let ellipse = |i: u32| {
            let (sin, cos) = texmap_math::deterministic_f64::sin_cos(
                f64::from(i) / 96.0 * std::f64::consts::TAU,
            );
            place(centre + 0.5 * (across * cos + down * sin))
        };
        for i in 0..96 {
            picture.line(ellipse(i), ellipse(i + 1), RIGHT);
        }
        answer.picture(
            "the pixel in the texture: its square red, its ellipse blue",
            &picture,
        );
        answer.figure("long axis", long, "texels");
        answer.figure("short axis", short, "texels");
        answer.figure("anisotropy", long / short, "");
        answer.figure("area", across.perp_dot(down).abs(), "texels²");
        Ok(())
    }
}

/// Lengths of the longer and the shorter axis of the ellipse with these conjugate diameters (the singular values of the matrix
/// with these columns).
fn axes(a: DVec2, b: DVec2) -> (f64, f64) {
    let (sum, product) = (a.length_squared() + b.length_squared(), a.perp_dot(b).abs());
    let root = (sum * sum - 4.0 * product * product).max(0.0).sqrt();
    (
        ((sum + root) / 2.0).sqrt(),
        ((sum - root) / 2.0).max(0.0).sqrt(),
    )
}

/// The map from the screen to texels around a pixel, through the coordinates of four pixels beside it.
fn texture_from_screen(frame: &Frame, x: i64, y: i64, texels: f64) -> Option<Homography> {
    let around = [(-3, -3), (3, -3), (3, 3), (-3, 3)].map(|(dx, dy)| {
        let (x, y) = (x + dx, y + dy);
        let uv = [0, 1].map(|k| value(frame, Aov::Uv, x, y, k));
        let screen = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let texel = DVec2::new(uv[0]?, uv[1]?) * texels;
        Some((screen, texel))
    });
    let [Some(a), Some(b), Some(c), Some(d)] = around else {
        return None;
    };
    Homography::from_quads([a.0, b.0, c.0, d.0], [a.1, b.1, c.1, d.1]).ok()
}

fn value(frame: &Frame, aov: Aov, x: i64, y: i64, channel: usize) -> Option<f64> {
    let (_, channels, data) = frame.aovs.iter().find(|(kind, ..)| *kind == aov)?;
    let AovData::F32(values) = data else {
        return None;
    };
    let pixel = usize::try_from(y).ok()? * frame.width as usize + usize::try_from(x).ok()?;
    let value = f64::from(*values.get(pixel * channels + channel)?);
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_of_a_sheared_circle_keep_its_area() {
        let (long, short) = axes(DVec2::new(3.0, 0.0), DVec2::new(0.0, 2.0));
        assert!((long - 3.0).abs() < 1e-12 && (short - 2.0).abs() < 1e-12);
        let (long, short) = axes(DVec2::new(3.0, 0.0), DVec2::new(1.0, 2.0));
        assert!((long * short - 6.0).abs() < 1e-12 && long > 3.0);
    }
}
