//! Forward against inverse mapping (Brackeen 2003, chapter 8): texel to pixel, with its overdraw and its
//! holes counted, and pixel to texel.

use texmap_math::camera::Camera;
use texmap_math::glam::{DVec2, DVec3};
use texmap_math::homography::Homography;
use texmap_raster::{BinnedDraws, DrawCall, NoAlphaTest, Pass, TargetSize, VisibilityBuffer};

use super::sheet::sheet;
use super::{DemoPicture, paint};
use crate::LabError;
use crate::cases::visit;
use texmap_truth::picture::{Picture, Rgba};

const SKY: Rgba = [204, 217, 230, 255];
const HOLE: Rgba = [255, 0, 160, 255];

/// A wall with a texture of as many texels as suit the picture: magnified near the eye, minified far away.
struct Wall {
    size: u32,
    texels: u32,
    texture: Picture,
}

/// The pixels that one way of mapping wrote.
struct Written {
    picture: Picture,
    /// Writes of each pixel.
    writes: Vec<u32>,
    /// True for texels that reached a pixel.
    seen: Vec<bool>,
}

impl Written {
    fn new(wall: &Wall) -> Self {
        let size = wall.size;
        let pixels = size as usize * size as usize;
        let texels = (wall.texels * wall.texels) as usize;
        Self {
            picture: Picture::new(size, size, SKY),
            writes: vec![0; pixels],
            seen: vec![false; texels],
        }
    }

    fn write(&mut self, x: u32, y: u32, texel: u32, wall: &Wall) {
        let (column, row) = (texel % wall.texels, texel / wall.texels);
        let color = wall.texture.get(i64::from(column), i64::from(row));
        self.picture.set(i64::from(x), i64::from(y), color);
        self.writes[(y * self.picture.width() + x) as usize] += 1;
        self.seen[texel as usize] = true;
    }

    fn pixels(&self) -> usize {
        self.writes.iter().filter(|&&n| n > 0).count()
    }

    fn total(&self) -> u32 {
        self.writes.iter().sum()
    }

    fn unseen(&self) -> usize {
        self.seen.iter().filter(|&&seen| !seen).count()
    }
}

pub(super) fn forward_inverse(size: u32) -> Result<DemoPicture, LabError> {
    let texels = (size / 2).next_multiple_of(4);
    let wall = Wall {
        size,
        texels,
        texture: paint::letters(texels),
    };
    let all = texels * texels;
    let points = points(&wall)?;
    let quads = quads(&wall)?;
    let (inverse, differing) = inverse(&wall)?;

    let mut holed = points.picture.clone();
    let mut holes = 0;
    for (index, (&forward, &behind)) in points.writes.iter().zip(&inverse.writes).enumerate() {
        if forward == 0 && behind > 0 {
            holes += 1;
            let index = index as u32;
            holed.set(i64::from(index % size), i64::from(index / size), HOLE);
        }
    }
    let overdrawn = points.total() as usize - points.pixels();
    let twice = quads.writes.iter().filter(|&&n| n > 1).count();
    // The corners of texels are snapped to 1/256 pixel: a quad beside a centre may gain or lose it.
    let claims = claims![
        "texels whose quad covers no pixel centre, against texels that no pixel fetches" =>
            quads.unseen() as f64, inverse.unseen() as f64, f64::from(all) * 0.001;
        "quads: pixels written twice" => twice as f64, 0.0, 0.0;
        "pixels that the quads cover, against the pixels of the polygon" =>
            quads.pixels() as f64, inverse.pixels() as f64, 0.002 * inverse.pixels() as f64;
        "inverse: pixels written more than once" =>
            f64::from(inverse.total()) - inverse.pixels() as f64, 0.0, 0.0;
        "inverse: pixels whose texel differs from the homography's" => f64::from(differing), 0.0, 0.0;
    ];
    let panels = panels![
        holed =>
            "Texel to pixel, points",
            format!("{all} texels, one pixel each: {holes} holes (pink) near the eye, {overdrawn} texels overwritten far away.");
        counts(&points, size) =>
            "Writes of each pixel",
            format!("Black 0, then red to white with the count, up to {}.", points.writes.iter().max().unwrap_or(&0));
        quads.picture.clone() =>
            "Texel to pixel, solid quads",
            format!("{all} quads are set up for {} pixels; {} of them are never seen.", quads.pixels(), quads.unseen());
        inverse.picture.clone() =>
            "Pixel to texel",
            format!("One polygon, {} pixels, each fetches one texel: no hole, no overdraw.", inverse.pixels());
    ];
    Ok(sheet("Forward against inverse mapping", panels, claims))
}

/// The wall: its top left corner, along u and along v. It recedes from the left to the right.
const ORIGIN: DVec3 = DVec3::new(-1.55, 1.35, -1.75);
const ALONG_U: DVec3 = DVec3::new(3.9, 0.0, -4.6);
const ALONG_V: DVec3 = DVec3::new(0.0, -2.7, 0.0);

fn camera() -> Camera {
    Camera {
        eye: DVec3::ZERO,
        look: DVec3::new(-0.2, 0.0, -1.0),
        up: DVec3::Y,
        fov_x: 80f64.to_radians(),
        near: 1e-3,
        far: f64::INFINITY,
    }
}

fn place(u: f64, v: f64) -> DVec3 {
    ORIGIN + ALONG_U * u + ALONG_V * v
}

fn project(point: DVec3, size: u32) -> Result<DVec2, LabError> {
    let clip = camera().clip_from_world(1.0)? * point.extend(1.0);
    let half = 0.5 * f64::from(size);
    Ok(DVec2::new(
        half * (1.0 + clip.x / clip.w),
        half * (1.0 - clip.y / clip.w),
    ))
}

/// Every texel sets the pixel under its centre.
fn points(wall: &Wall) -> Result<Written, LabError> {
    let (size, texels) = (wall.size, wall.texels);
    let mut written = Written::new(wall);
    let n = f64::from(texels);
    for texel in 0..texels * texels {
        let (column, row) = (f64::from(texel % texels), f64::from(texel / texels));
        let at = project(place((column + 0.5) / n, (row + 0.5) / n), size)?.floor();
        let inside = |c: f64| c >= 0.0 && c < f64::from(size);
        if inside(at.x) && inside(at.y) {
            written.write(at.x as u32, at.y as u32, texel, wall);
        }
    }
    Ok(written)
}

/// Every texel is drawn as a quad of its own, over what is there.
fn quads(wall: &Wall) -> Result<Written, LabError> {
    let (size, texels) = (wall.size, wall.texels);
    let corners = texels + 1;
    let mut positions = Vec::new();
    for row in 0..corners {
        for column in 0..corners {
            let (u, v) = (
                f64::from(column) / f64::from(texels),
                f64::from(row) / f64::from(texels),
            );
            positions.push(place(u, v).as_vec3().to_array());
        }
    }
    let mut indices = Vec::new();
    for texel in 0..texels * texels {
        let a = texel / texels * corners + texel % texels;
        indices.extend([
            [a, a + corners, a + corners + 1],
            [a, a + corners + 1, a + 1],
        ]);
    }
    let draw = DrawCall {
        positions: &positions,
        indices: &indices,
        clip_from_object: camera().clip_from_world(1.0)?,
        pass: Pass::Blended,
        ..DrawCall::default()
    };
    let prepared = BinnedDraws::new(TargetSize::new(size, size)?, &[draw])?;
    let mut written = Written::new(wall);
    let mut buffers = VisibilityBuffer::new();
    for tile in 0..prepared.tiles() {
        prepared.visible(tile, &NoAlphaTest, &mut buffers);
        prepared.blended(tile, &buffers, &mut |id, x, y| {
            written.write(x, y, prepared.source(id).1 / 2, wall);
        });
    }
    Ok(written)
}

/// Every pixel of the wall fetches the texel under its centre. Also gives the number of pixels whose texel is
/// not the homography's, those closer than 1/1000 texel to a border left out.
fn inverse(wall: &Wall) -> Result<(Written, u32), LabError> {
    let (size, texels) = (wall.size, wall.texels);
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let positions = square.map(|(u, v)| place(u, v).as_vec3().to_array());
    let uv: Vec<f32> = square
        .iter()
        .flat_map(|&(u, v)| [u as f32, v as f32])
        .collect();
    let draw = DrawCall {
        positions: &positions,
        indices: &[[0, 3, 2], [0, 2, 1]],
        clip_from_object: camera().clip_from_world(1.0)?,
        attributes: &uv,
        attribute_count: 2,
        ..DrawCall::default()
    };
    let mut screen = [DVec2::ZERO; 4];
    for (corner, (u, v)) in screen.iter_mut().zip(square) {
        *corner = project(place(u, v), size)?;
    }
    let to_texture = Homography::from_square(screen)?.inverse();
    let (mut written, mut differing) = (Written::new(wall), 0);
    let texel_of = |c: f64| {
        (c * f64::from(texels))
            .floor()
            .clamp(0.0, f64::from(texels - 1)) as u32
    };
    visit((size, size), &[draw], |x, y, fragment| {
        let (u, v) = (f64::from(fragment.values[0]), f64::from(fragment.values[1]));
        let texel = texel_of(v) * texels + texel_of(u);
        written.write(x, y, texel, wall);
        let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let border =
            |c: f64| (c * f64::from(texels) - (c * f64::from(texels)).round()).abs() < 1e-3;
        let inner = |truth: &DVec2| !border(truth.x) && !border(truth.y);
        if let Some(truth) = to_texture.apply(centre).filter(inner) {
            differing += u32::from(texel != texel_of(truth.y) * texels + texel_of(truth.x));
        }
    })?;
    Ok((written, differing))
}

/// Black for no write, then heat up to the most written pixel.
fn counts(written: &Written, size: u32) -> Picture {
    let most = f64::from(*written.writes.iter().max().unwrap_or(&1)).max(1.0);
    Picture::from_fn(size, size, |x, y| {
        texmap_truth::strip::heat(f64::from(written.writes[(y * size + x) as usize]) / most)
    })
}
