//! The pictures of a batch of poses, one after the other or several at a time.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use pyo3::PyResult;
use texmap_math::Camera;
use texmap_render::{Aov, AovData, RenderSettings};
use texmap_scene::Scene;

use crate::support::{go_on, value};

/// One picture and the arrays that it is written into.
pub(crate) struct Pose<'a> {
    pub(crate) camera: Camera,
    pub(crate) rgba: &'a mut [u8],
    pub(crate) aovs: Vec<(Aov, Values<'a>)>,
}

/// An array of one buffer.
pub(crate) enum Values<'a> {
    F32(&'a mut [f32]),
    U32(&'a mut [u32]),
}

/// Pixels of a picture from which on its own tiles keep all threads busy, and its buffers are too large to have many of.
const LARGE: usize = 1 << 21;

/// Triangles that the copies of a scene may have together.
const COPIED: usize = 1 << 22;

impl<'a> Pose<'a> {
    /// One for each camera; the arrays hold the pictures one after the other.
    pub(crate) fn all(
        cameras: &[Camera],
        rgba: &'a mut [u8],
        aovs: Vec<(Aov, Values<'a>)>,
    ) -> Vec<Self> {
        let part = |len: usize| (len / cameras.len().max(1)).max(1);
        let pictures = rgba.chunks_mut(part(rgba.len()));
        let pose = |(camera, rgba): (&Camera, &'a mut [u8])| Self {
            camera: *camera,
            rgba,
            aovs: Vec::new(),
        };
        let mut poses: Vec<Self> = cameras.iter().zip(pictures).map(pose).collect();
        for (aov, values) in aovs {
            match values {
                Values::F32(values) => {
                    for (pose, out) in poses.iter_mut().zip(values.chunks_mut(part(values.len()))) {
                        pose.aovs.push((aov, Values::F32(out)));
                    }
                }
                Values::U32(values) => {
                    for (pose, out) in poses.iter_mut().zip(values.chunks_mut(part(values.len()))) {
                        pose.aovs.push((aov, Values::U32(out)));
                    }
                }
            }
        }
        poses
    }

    /// Draws the picture; returns its warnings.
    fn draw(
        self,
        scene: &mut Scene,
        settings: &RenderSettings,
        stop: &AtomicBool,
    ) -> PyResult<Vec<String>> {
        scene.camera = self.camera;
        let frame = texmap_render::render(scene, settings, &go_on(stop)).map_err(value)?;
        self.rgba.copy_from_slice(&frame.rgba);
        for (aov, out) in self.aovs {
            let found = frame.aovs.iter().find(|(drawn, ..)| *drawn == aov);
            match (out, found.map(|(.., data)| data)) {
                (Values::F32(out), Some(AovData::F32(data))) => out.copy_from_slice(data),
                (Values::U32(out), Some(AovData::U32(data))) => out.copy_from_slice(data),
                _ => {}
            }
        }
        Ok(frame.warnings)
    }
}

/// Draws all pictures on the threads of the current pool and returns their warnings, each once. Small pictures are drawn several at a
/// time, each by one thread with a scene of its own: their tiles alone are too little work to share. The error is that of the first
/// picture that has one.
pub(crate) fn draw_all(
    scene: Scene,
    settings: &RenderSettings,
    poses: Vec<Pose<'_>>,
    stop: &AtomicBool,
) -> PyResult<Vec<String>> {
    let pixels =
        settings.width as usize * settings.height as usize * (settings.supersample as usize).pow(2);
    let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let workers = match pixels < LARGE {
        true => rayon::current_num_threads()
            .min(poses.len())
            .min(COPIED / triangles.max(1)),
        false => 1,
    };
    let mut results: Vec<(usize, PyResult<Vec<String>>)> = match workers {
        0 | 1 => one_by_one(scene, settings, poses, stop),
        _ => side_by_side(workers, &scene, settings, poses, stop)?,
    };
    results.sort_by_key(|(index, _)| *index);
    let mut warnings: Vec<String> = Vec::new();
    for (_, result) in results {
        for warning in result? {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
    }
    Ok(warnings)
}

fn one_by_one(
    mut scene: Scene,
    settings: &RenderSettings,
    poses: Vec<Pose<'_>>,
    stop: &AtomicBool,
) -> Vec<(usize, PyResult<Vec<String>>)> {
    let mut results = Vec::new();
    for (index, pose) in poses.into_iter().enumerate() {
        let result = pose.draw(&mut scene, settings, stop);
        let failed = result.is_err();
        results.push((index, result));
        if failed {
            break;
        }
    }
    results
}

fn side_by_side(
    workers: usize,
    scene: &Scene,
    settings: &RenderSettings,
    poses: Vec<Pose<'_>>,
    stop: &AtomicBool,
) -> PyResult<Vec<(usize, PyResult<Vec<String>>)>> {
    let alone = || rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pools = (0..workers)
        .map(|_| alone().map_err(value))
        .collect::<PyResult<Vec<_>>>()?;
    let left = Mutex::new(poses.into_iter().enumerate());
    let results = Mutex::new(Vec::new());
    let failed = AtomicBool::new(false);
    let work = || {
        let mut scene = scene.clone();
        while !failed.load(Ordering::Relaxed) {
            let next = left.lock().ok().and_then(|mut left| left.next());
            let Some((index, pose)) = next else { break };
            let result = pose.draw(&mut scene, settings, stop);
            if result.is_err() {
                failed.store(true, Ordering::Relaxed);
            }
            if let Ok(mut results) = results.lock() {
                results.push((index, result));
            }
        }
    };
    thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| pool.install(work));
        }
    });
    results.into_inner().map_err(value)
}
