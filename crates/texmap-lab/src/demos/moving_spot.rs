//! A spotlight that moves over a baked room: the resting light stays as it is, and only the spot is baked again.

use texmap_bake::LightMap;
use texmap_light::Light;
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_sample::{Filter, Wrap};
use texmap_scene::{Mesh, Scene};

use super::bump_maps::{baked, under};
use super::lit::{ball, difference, matte};
use super::{Claim, paint, stage};
use crate::LabError;
use texmap_truth::picture::Picture;

/// Texels a side of the room's light map.
const TEXELS: u32 = 192;

/// The frames of a spotlight on its round through a room of bricks: structure times light, as light maps are used in games
/// (Abrash 1997, chapter 68), with what rests and what moves in maps of their own.
#[derive(Debug)]
pub struct MovingSpot {
    size: u32,
    resting: LightMap,
}

impl MovingSpot {
    /// Bakes the light that rests. Pictures have `size` x `size` pixels.
    ///
    /// # Errors
    /// A size out of [`SIZES`](super::SIZES).
    pub fn new(size: u32) -> Result<Self, LabError> {
        if !super::SIZES.contains(&size) {
            return Err(LabError::PanelSize(size));
        }
        let resting = baked(&room()?, TEXELS, None)?;
        Ok(Self { size, resting })
    }

    /// Frame `number` of a round of `of`, under the resting map plus that of the spot alone.
    ///
    /// # Errors
    /// None that a size within range brings.
    pub fn picture(&self, number: u32, of: u32) -> Result<Picture, LabError> {
        self.moved(&scene_of(number, of)?)
    }

    /// The picture of a frame, and how far it is from the picture under a fresh bake of all lights.
    ///
    /// # Errors
    /// None that a size within range brings.
    pub fn frame(&self, number: u32, of: u32) -> Result<(Picture, Claim), LabError> {
        let scene = scene_of(number, of)?;
        let moved = self.moved(&scene)?;
        let fresh = self.under_map(&scene, &baked(&scene, TEXELS, None)?)?;
        let pixels = 0..(self.size * self.size) as usize;
        let worst = pixels.map(|i| difference(&moved, &fresh, i)).max();
        let claim = Claim::new(
            format!("frame {number}: largest difference to a fresh bake, /255"),
            f64::from(worst.unwrap_or(0)),
            0.0,
            1.0,
        );
        Ok((moved, claim))
    }

    /// The last light of the scene is the spot.
    fn moved(&self, scene: &Scene) -> Result<Picture, LabError> {
        let mut map = baked(scene, TEXELS, Some(&[scene.lights.len() - 1]))?;
        for (sum, rest) in map.texels.iter_mut().zip(&self.resting.texels) {
            *sum = [0, 1, 2].map(|k| sum[k] + rest[k]);
        }
        self.under_map(scene, &map)
    }

    fn under_map(&self, scene: &Scene, map: &LightMap) -> Result<Picture, LabError> {
        stage::photograph(&under(scene.clone(), map)?, self.size)
    }
}

/// The room with its spot at a frame of its round.
fn scene_of(number: u32, of: u32) -> Result<Scene, LabError> {
    let part = f64::from(number) / f64::from(of.max(1));
    let mut scene = room()?;
    let (sin, cos) = deterministic_f64::sin_cos(part * std::f64::consts::TAU);
    let aim = DVec3::new(1.7 * cos, 0.9 + 0.9 * sin, -1.6 + 0.4 * sin);
    let from = DVec3::new(0.0, 2.6, 1.6);
    let narrow = |v: DVec3| v.as_vec3().to_array();
    scene.lights.push(Light::spot(
        [0.8, 0.75, 0.6],
        narrow(from),
        narrow(aim - from),
        0.16,
        0.26,
    ));
    Ok(scene)
}

/// Floor and three walls of bricks under one mesh, and a ball.
fn room() -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(0.0, 1.5, 4.6), DVec3::new(0.0, 1.1, 0.0), 56.0);
    let bricks = stage::texture(&mut scene, &paint::bricks(256))?;
    scene.lights = vec![
        Light::Ambient { color: [0.12; 3] },
        Light::Point {
            color: [0.35, 0.38, 0.45],
            position: [-1.2, 2.6, 1.0],
        },
    ];
    let mut wall = matte([1.0; 3], 0.0);
    wall.base_color = Some(stage::slot(bricks, Filter::Trilinear, Wrap::Repeat));
    let wall = stage::add(&mut scene, wall);
    let plaster = stage::add(&mut scene, matte([0.75, 0.7, 0.65], 0.0));
    let sides = [
        // Lower left corner, right and up, as one looks at them from inside.
        (
            DVec3::new(-2.2, 0.0, 2.0),
            DVec3::X * 4.4,
            DVec3::NEG_Z * 4.4,
        ),
        (
            DVec3::new(-2.2, 0.0, 2.0),
            DVec3::NEG_Z * 4.4,
            DVec3::Y * 2.8,
        ),
        (DVec3::new(-2.2, 0.0, -2.4), DVec3::X * 4.4, DVec3::Y * 2.8),
        (DVec3::new(2.2, 0.0, -2.4), DVec3::Z * 4.4, DVec3::Y * 2.8),
    ];
    let mut mesh = Mesh {
        name: "room".into(),
        material: wall,
        ..Mesh::default()
    };
    for (i, (corner, right, up)) in (0u32..).zip(sides) {
        // Four charts in a square, a gutter around each.
        let chart = [f64::from(i % 2) * 0.5, f64::from(i / 2) * 0.5];
        for (s, t) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let p = corner + right * s + up * t;
            mesh.positions.push(p.as_vec3().to_array());
            let uv = [s * right.length() * 0.5, -t * up.length() * 0.5];
            mesh.uvs.push(uv.map(|c| c as f32));
            let inset = |c: f64, k: usize| (chart[k] + 0.02 + 0.46 * c) as f32;
            mesh.lightmap_uvs.push([inset(s, 0), inset(1.0 - t, 1)]);
        }
        mesh.triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| v + 4 * i)));
        mesh.faces.extend([i; 2]);
    }
    scene.meshes = vec![mesh, ball(DVec3::new(0.7, 0.5, -0.6), 0.5, plaster)];
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each frame is its own fresh bake; another frame's picture is not.
    #[test]
    fn every_frame_is_within_a_code_of_a_fresh_bake() {
        let round = MovingSpot::new(128).unwrap();
        let mut last: Option<Picture> = None;
        for number in 0..4 {
            let (picture, claim) = round.frame(number, 4).unwrap();
            assert!(claim.holds(), "{claim}");
            if let Some(last) = last.replace(picture.clone()) {
                let most = (0..128 * 128).map(|i| difference(&picture, &last, i)).max();
                assert!(most > Some(40), "the spot moves: {most:?}");
            }
        }
        assert!(MovingSpot::new(64).is_err());
    }
}
