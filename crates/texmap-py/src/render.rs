//! Pictures of a scene from one camera or many.

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use texmap_io::framing::{Bounds, Framing, View};
use texmap_io::{CameraAxes, CameraPose, Intrinsics};
use texmap_math::Camera;
use texmap_raster::Interp;
use texmap_render::{Aov, RenderSettings};
use texmap_sample::{Filter, Wrap};

use crate::poses::{Pose, Values, draw_all};
use crate::scene::{Loaded, Scene, look_at};
use crate::support::{Threads, interruptible, level, unlocked, value, word};

/// The cameras of a call, as flat arrays.
#[derive(FromPyObject)]
pub(crate) enum Cameras<'py> {
    /// Poses (16 numbers each), intrinsics (fx fy cx cy each, or none), axes, true for world to camera.
    Poses(
        PyReadonlyArray1<'py, f64>,
        Option<PyReadonlyArray1<'py, f64>>,
        String,
        bool,
        Option<f64>,
    ),
    /// Eye, look, up, horizontal field of view in radians, near, far.
    LookAt([f64; 3], [f64; 3], [f64; 3], f64, Option<f64>, f64),
    /// A side from which the automatic camera looks.
    View(String),
}

/// Draws `n` pictures into `rgba` (n, height, width, 4) and one array for each name of `aovs`. Returns the warnings.
#[pyfunction]
#[pyo3(signature = (scene, size, cameras, rgba, aovs, supersample, msaa, filter, wrap, interp, threads, simd))]
pub(crate) fn render(
    py: Python<'_>,
    scene: &Scene,
    size: (u32, u32),
    cameras: Option<Cameras<'_>>,
    mut rgba: PyReadwriteArray1<'_, u8>,
    aovs: Vec<(String, Bound<'_, PyAny>)>,
    supersample: Option<u32>,
    msaa: Option<u32>,
    filter: Option<&str>,
    wrap: Option<&str>,
    interp: Option<&str>,
    threads: Option<Threads>,
    simd: Option<&str>,
) -> PyResult<Vec<String>> {
    let (width, height) = size;
    build_mips(py, scene)?;
    let loaded = scene.copy()?;
    let views = Views::of(cameras.as_ref())?;
    let cameras = unlocked(py, threads, || all_cameras(&loaded, &views, size))??;
    let mut settings = RenderSettings::new(width, height);
    settings.supersample = supersample.unwrap_or(1);
    settings.msaa = msaa.unwrap_or(if loaded.model && supersample.is_none() {
        4
    } else {
        1
    });
    settings.filter = filter.map(|f| word::<Filter>("filter", f)).transpose()?;
    settings.wrap = wrap.map(|w| word::<Wrap>("wrap", w)).transpose()?;
    settings.interp = interp.map(interpolation).transpose()?;
    settings.level = level(simd)?;
    let mut floats: Vec<(Aov, PyReadwriteArray1<'_, f32>)> = Vec::new();
    let mut ids: Vec<(Aov, PyReadwriteArray1<'_, u32>)> = Vec::new();
    for (name, array) in &aovs {
        let aov = aov(&loaded.scene, name)?;
        match aov {
            Aov::Face | Aov::Mesh => ids.push((aov, array.extract()?)),
            _ => floats.push((aov, array.extract()?)),
        }
        settings.aovs.push(aov);
    }
    let rgba = rgba.as_slice_mut()?;
    let mut slices: Vec<(Aov, Values<'_>)> = Vec::new();
    for (aov, array) in &mut floats {
        slices.push((*aov, Values::F32(array.as_slice_mut()?)));
    }
    for (aov, array) in &mut ids {
        slices.push((*aov, Values::U32(array.as_slice_mut()?)));
    }
    interruptible(py, threads, |stop| {
        let shaped = texmap_mesh::tessellate(&loaded.scene, width).map_err(value)?;
        let owned = match shaped {
            std::borrow::Cow::Owned(scene) => Some(scene),
            std::borrow::Cow::Borrowed(_) => None,
        };
        let scene = owned.unwrap_or(loaded.scene);
        draw_all(scene, &settings, Pose::all(&cameras, rgba, slices), stop)
    })?
}

/// The buffer of a name; shadows by the number or name of their light.
fn aov(scene: &texmap_scene::Scene, name: &str) -> PyResult<Aov> {
    match (name.parse::<Aov>(), name.strip_prefix("shadow:")) {
        (Ok(aov), _) => Ok(aov),
        (_, Some(light)) => Aov::shadow_of(scene, light).map_err(value),
        (Err(unknown), None) => Err(value(unknown)),
    }
}

/// `perspective`, `affine`, `subdivided:N`, `span:N`, `within:TOLERANCE`.
fn interpolation(text: &str) -> PyResult<Interp> {
    let (name, parameter) = text
        .split_once(':')
        .map_or((text, None), |(n, p)| (n, Some(p)));
    let count = || parameter.and_then(|p| p.parse().ok());
    let tolerance = || parameter.and_then(|p| p.parse().ok());
    let found = match name {
        "perspective" => Some(Interp::Perspective),
        "affine" => Some(Interp::Affine),
        "subdivided" => count().map(Interp::Subdivided),
        "span" => count().map(Interp::Span),
        "within" => tolerance().map(Interp::WithinError),
        _ => None,
    };
    found.ok_or_else(|| {
        value(format!(
            "interp={text:?}: know perspective, affine, subdivided:N, span:N, within:TOLERANCE"
        ))
    })
}

/// Builds the mip chains and the summed-area tables that the samplers of the scene read, so that no picture builds them again.
fn build_mips(py: Python<'_>, scene: &Scene) -> PyResult<()> {
    if scene.inner.read().map_err(value)?.has_mips {
        return Ok(());
    }
    py.detach(|| {
        let mut inner = scene.inner.write().map_err(value)?;
        let scene = &mut inner.scene;
        let materials = scene
            .meshes
            .iter()
            .filter_map(|m| scene.materials.get(m.material));
        let read: Vec<_> = materials
            .flat_map(|m| m.slots())
            .map(|slot| (slot.texture, slot.sampler.filter))
            .collect();
        for (index, filter) in read {
            if let Some(texture) = scene.textures.get_mut(index)
                && texture.bytes_to_prepare(filter) > 0
            {
                *texture = texture.clone().prepared_for(filter);
            }
        }
        inner.has_mips = true;
        Ok(())
    })
}

/// Refuses poses and lenses that no picture of this size can be drawn by, with the words of [`render`].
#[pyfunction]
#[pyo3(signature = (cameras, size))]
pub(crate) fn check_cameras(cameras: Cameras<'_>, size: (u32, u32)) -> PyResult<()> {
    if let Views::Poses(poses) = Views::of(Some(&cameras))? {
        let base = Camera::look_at([0.0, 0.0, 1.0], [0.0; 3]);
        for camera in poses.cameras(&base, size)? {
            camera.view().map_err(value)?;
        }
    }
    Ok(())
}

/// The cameras of a call without arrays of the interpreter, for work on the threads of a pool.
enum Views {
    Own,
    Poses(Calibrated),
    LookAt([f64; 3], [f64; 3], [f64; 3], f64, Option<f64>, f64),
    Side(View),
}

impl Views {
    fn of(cameras: Option<&Cameras<'_>>) -> PyResult<Self> {
        Ok(match cameras {
            None => Self::Own,
            Some(Cameras::View(name)) => Self::Side(word("camera", name)?),
            Some(Cameras::LookAt(eye, look, up, fov_x, near, far)) => {
                Self::LookAt(*eye, *look, *up, *fov_x, *near, *far)
            }
            Some(Cameras::Poses(poses, intrinsics, axes, world_to_camera, fov_x)) => {
                Self::Poses(Calibrated {
                    poses: poses.as_slice()?.as_chunks::<16>().0.to_vec(),
                    intrinsics: match intrinsics {
                        Some(array) => array.as_slice()?.as_chunks::<4>().0.to_vec(),
                        None => Vec::new(),
                    },
                    axes: word("axes", axes)?,
                    world_to_camera: *world_to_camera,
                    fov_x: *fov_x,
                })
            }
        })
    }
}

/// Poses with one lens for all or one for each.
struct Calibrated {
    poses: Vec<[f64; 16]>,
    intrinsics: Vec<[f64; 4]>,
    axes: CameraAxes,
    world_to_camera: bool,
    fov_x: Option<f64>,
}

impl Calibrated {
    /// `base` at each of the poses, for pictures of a size.
    fn cameras(&self, base: &Camera, (width, height): (u32, u32)) -> PyResult<Vec<Camera>> {
        let one = |(k, pose): (usize, &[f64; 16])| {
            let mut rows = [[0.0; 4]; 4];
            rows.as_flattened_mut().copy_from_slice(pose);
            let pose = CameraPose {
                rows,
                axes: self.axes,
                world_to_camera: self.world_to_camera,
            };
            let named = |e: String| value(format!("pose[{k}]: {e}"));
            let mut camera = pose.place(base).map_err(named)?;
            if let Some(fov_x) = self.fov_x {
                camera.fov_x = fov_x;
            }
            let own = self.intrinsics.get(k).or_else(|| self.intrinsics.first());
            if let Some(&[fx, fy, cx, cy]) = own {
                let lens = Intrinsics { fx, fy, cx, cy };
                let applied = lens.apply(&camera, f64::from(width), f64::from(height));
                camera = applied.map_err(|e| value(format!("K[{k}]: {e}")))?;
            }
            Ok(camera)
        };
        self.poses.iter().enumerate().map(one).collect()
    }
}

/// The cameras of the pictures, at least one. Called on a pool: fitting a camera shares its work out.
fn all_cameras(
    loaded: &Loaded,
    views: &Views,
    (width, height): (u32, u32),
) -> PyResult<Vec<Camera>> {
    let scene = &loaded.scene;
    if width == 0 || height == 0 {
        return Err(value(format!(
            "size=({width}, {height}): a picture has at least one pixel a side"
        )));
    }
    let aspect = f64::from(width) / f64::from(height);
    let automatic = |framing: &Framing| {
        let camera = framing.camera(scene, aspect);
        camera.ok_or_else(|| value("the scene has no triangles: give it a camera"))
    };
    match views {
        Views::Own => match &loaded.framing {
            Some(framing) => Ok(vec![automatic(framing)?]),
            None => Ok(vec![scene.camera]),
        },
        Views::Side(view) => {
            let framing = Framing {
                view: *view,
                up: loaded.up,
                ..loaded.framing.unwrap_or_default()
            };
            Ok(vec![automatic(&framing)?])
        }
        Views::LookAt(eye, look, up, fov_x, near, far) => {
            let camera = look_at(*eye, *look, *up, *fov_x, *near, *far);
            Ok(vec![match near {
                Some(_) => camera,
                None => near_of(loaded, camera),
            }])
        }
        Views::Poses(poses) => {
            let mut base = near_of(loaded, scene.camera);
            if let Some(framing) = &loaded.framing {
                base.fov_x = framing.fov_x;
            }
            poses.cameras(&base, (width, height))
        }
    }
}

/// A camera near to a model cuts nothing away that stands before it, as in the program.
pub(crate) fn near_of(loaded: &Loaded, camera: Camera) -> Camera {
    match Bounds::of(&loaded.scene).filter(|_| loaded.model) {
        Some(bounds) if bounds.radius > 0.0 => Camera {
            near: camera.near.min(1e-4 * bounds.radius),
            ..camera
        },
        _ => camera,
    }
}
