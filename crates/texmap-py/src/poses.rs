//! The pictures of a batch of poses, one after the other or several at a time.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use pyo3::{PyErr, PyResult};
use texmap_math::Camera;
use texmap_render::{Aov, AovData, RenderError, RenderSettings};
use texmap_scene::{Scene, SceneError};

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

/// Bytes of a vertex or triangle in a copy of a scene and in what a picture of it makes ready.
const VERTEX: u64 = 128;
const TRIANGLE: u64 = 32;

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
    ) -> Result<Vec<String>, RenderError> {
        scene.camera = self.camera;
        let frame = texmap_render::render(scene, settings, &go_on(stop))?;
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

/// The warnings or the error of one picture, with its number.
type Drawn = (usize, Result<Vec<String>, RenderError>);

/// Draws all pictures on the threads of the current pool and returns their warnings, each once. Small pictures are drawn several at a
/// time, each by one thread with a scene of its own: their tiles alone are too little work to share. The error is that of the first
/// picture that has one.
pub(crate) fn draw_all(
    scene: Scene,
    settings: &RenderSettings,
    poses: Vec<Pose<'_>>,
    stop: &AtomicBool,
) -> PyResult<Vec<String>> {
    let count = poses.len();
    let mut drawn = match at_once(&scene, settings, count) {
        0 | 1 => one_by_one(scene, settings, poses, stop),
        workers => side_by_side(workers, &scene, settings, poses, stop)?,
    };
    drawn.sort_by_key(|(index, _)| *index);
    let mut warnings: Vec<String> = Vec::new();
    for (index, result) in drawn {
        for warning in result.map_err(|error| named(error, index, count))? {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
    }
    Ok(warnings)
}

/// An error that one camera has and another may not have names its pose, if there are several.
fn named(error: RenderError, index: usize, count: usize) -> PyErr {
    let of_camera = matches!(
        error,
        RenderError::Scene(SceneError::Camera(_)) | RenderError::Raster { .. }
    );
    match of_camera && count > 1 {
        true => value(format!("pose[{index}]: {error}")),
        false => value(error),
    }
}

/// The number of pictures that are drawn at a time: one if they are large, if there is one thread, or if the memory budget does not have
/// the buffers of several.
fn at_once(scene: &Scene, settings: &RenderSettings, poses: usize) -> usize {
    let pixels = settings.width as usize * settings.height as usize;
    if pixels * (settings.supersample as usize).pow(2) >= LARGE {
        return 1;
    }
    let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let vertices: usize = scene.meshes.iter().map(|mesh| mesh.positions.len()).sum();
    let workers = rayon::current_num_threads()
        .min(poses)
        .min(COPIED / triangles.max(1));
    let channels: usize = settings.aovs.iter().map(|aov| aov.channels()).sum();
    let frame = 4 * pixels as u64 * (1 + channels as u64);
    let copy = VERTEX * vertices as u64 + TRIANGLE * triangles as u64;
    let asked = settings.memory.ask(
        workers as u64 * (frame + copy),
        format_args!("{workers} pictures at a time"),
        "give fewer threads",
    );
    match asked {
        Ok(()) => workers,
        Err(_) => 1,
    }
}

fn one_by_one(
    mut scene: Scene,
    settings: &RenderSettings,
    poses: Vec<Pose<'_>>,
    stop: &AtomicBool,
) -> Vec<Drawn> {
    let mut drawn = Vec::new();
    for (index, pose) in poses.into_iter().enumerate() {
        let result = pose.draw(&mut scene, settings, stop);
        let failed = result.is_err();
        drawn.push((index, result));
        if failed {
            break;
        }
    }
    drawn
}

/// Each worker has a pool of one thread: on a pool that is shared, a thread that waits for its tiles would begin another picture.
fn side_by_side(
    workers: usize,
    scene: &Scene,
    settings: &RenderSettings,
    poses: Vec<Pose<'_>>,
    stop: &AtomicBool,
) -> PyResult<Vec<Drawn>> {
    let alone = |_| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        pool.map_err(value)
    };
    let pools = (0..workers).map(alone).collect::<PyResult<Vec<_>>>()?;
    // Pictures are taken in order: each before the first that failed has been drawn to its end.
    let left = Mutex::new(poses.into_iter().enumerate());
    let failed = AtomicBool::new(false);
    let work = || {
        let (mut scene, mut drawn) = (scene.clone(), Vec::new());
        while !failed.load(Ordering::Relaxed) {
            let next = left.lock().ok().and_then(|mut left| left.next());
            let Some((index, pose)) = next else { break };
            let result = pose.draw(&mut scene, settings, stop);
            if result.is_err() {
                failed.store(true, Ordering::Relaxed);
            }
            drawn.push((index, result));
        }
        drawn
    };
    let all = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                let drawn = pool.install(work);
                if let Ok(mut all) = all.lock() {
                    all.extend(drawn);
                }
            });
        }
    });
    all.into_inner().map_err(value)
}
