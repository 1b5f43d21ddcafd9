//! `--compare rays`: the picture with ray-traced mirrors, and the error of mapped reflections by distance from the middle of each mirror.

use serde::Serialize;
use texmap_math::glam::DVec3;
use texmap_render::{Aov, AovData, Frame};
use texmap_scene::{Scene, Shading};
use texmap_truth::frame_by_rays;
use texmap_truth::picture::Picture;

use crate::failure::{Exit, Failure};

/// Truth that the picture is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Compare {
    /// Ray-traced mirrors
    Rays,
}

/// Distances that are told apart.
const BINS: usize = 5;

/// The error of mapped reflections.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RaysReport {
    /// The picture by rays.
    pub(crate) picture: Option<String>,
    pub(crate) mirrors: Vec<MirrorReport>,
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct MirrorReport {
    mesh: String,
    /// From the middle of the box of the mesh outwards.
    bins: Vec<Bin>,
}

/// Pixels of a mirror whose points lie so far from its middle, in units of the scene. Errors are of 255, over red, green and blue.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Bin {
    from: f64,
    to: f64,
    pixels: u64,
    mean: f64,
    largest: f64,
}

/// The picture of a frame's scene with ray-traced mirrors, one sample a pixel, and the frame's distance from it. The frame has positions and
/// meshes among its arrays.
pub(super) fn compare(scene: &Scene, frame: &Frame) -> Result<(Picture, RaysReport), Failure> {
    let mirrors: Vec<bool> = scene
        .meshes
        .iter()
        .map(|mesh| {
            let material = &scene.materials[mesh.material];
            material.shading == Shading::PerPixel && material.reflection.is_some()
        })
        .collect();
    if !mirrors.contains(&true) {
        return Err(Failure::new(
            Exit::Input,
            "no-mirror",
            "--compare rays: no surface of the scene mirrors an environment",
            "add an `env` line above the faces or the model, such as `env sky.hdr lat-long 0.5`",
        ));
    }
    let truth = frame_by_rays(scene, frame.width, frame.height, 1)?;
    let codes = truth.codes();
    let mut report = RaysReport {
        picture: None,
        mirrors: Vec::new(),
    };
    let (positions, meshes) = arrays(frame);
    for (mesh, _) in mirrors.iter().enumerate().filter(|(_, mirror)| **mirror) {
        // Pixels in which both see this mesh.
        let pixels: Vec<usize> = (0..meshes.len())
            .filter(|i| {
                let seen = truth.seen[*i].is_some_and(|(seen, _)| seen == mesh);
                meshes[*i] as usize == mesh && seen
            })
            .collect();
        let Ok(middle) = texmap_bake::center_of(scene, &[mesh]) else {
            continue;
        };
        let distance = |i: usize| {
            let p = [0, 1, 2].map(|k| f64::from(positions[3 * i + k]));
            (DVec3::from(p) - middle).length()
        };
        let largest = pixels.iter().map(|i| distance(*i)).fold(0.0, f64::max);
        let mut bins = [Bin::default(); BINS];
        for (k, bin) in bins.iter_mut().enumerate() {
            let at = |k: usize| largest * k as f64 / BINS as f64;
            (bin.from, bin.to) = (at(k), at(k + 1));
        }
        for i in pixels {
            let part = if largest > 0.0 {
                distance(i) / largest
            } else {
                0.0
            };
            let bin = &mut bins[((part * BINS as f64) as usize).min(BINS - 1)];
            bin.pixels += 1;
            let range = 4 * i..4 * i + 3;
            for (got, code) in frame.rgba[range.clone()].iter().zip(&codes[range]) {
                let apart = (f64::from(*got) - code).abs();
                bin.mean += apart / 3.0;
                bin.largest = bin.largest.max(apart);
            }
        }
        for bin in &mut bins {
            bin.mean /= bin.pixels.max(1) as f64;
        }
        report.mirrors.push(MirrorReport {
            mesh: scene.meshes[mesh].name.clone(),
            bins: bins.into_iter().filter(|bin| bin.pixels > 0).collect(),
        });
    }
    Ok((truth.picture(), report))
}

/// World positions and meshes of the pixels.
fn arrays(frame: &Frame) -> (&[f32], &[u32]) {
    let (mut positions, mut meshes): (&[f32], &[u32]) = (&[], &[]);
    for (aov, _, values) in &frame.aovs {
        match (aov, values) {
            (Aov::Position, AovData::F32(values)) => positions = values,
            (Aov::Mesh, AovData::U32(values)) => meshes = values,
            _ => {}
        }
    }
    (positions, meshes)
}

impl RaysReport {
    /// A table for people.
    pub(super) fn words(&self) -> String {
        let mut words = String::from("rays: error of mapped reflections, of 255\n");
        for mirror in &self.mirrors {
            for bin in &mirror.bins {
                words += &format!(
                    "  {}, {:.3} to {:.3} from its middle: {:.2} in the mean, {:.0} at most, {} pixels\n",
                    mirror.mesh, bin.from, bin.to, bin.mean, bin.largest, bin.pixels
                );
            }
        }
        words
    }
}
