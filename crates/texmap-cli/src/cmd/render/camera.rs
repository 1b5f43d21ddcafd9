//! The cameras of the pictures that one input gives.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use texmap_io::framing::{AUTO_FOV, Bounds, Framing, Up, View};
use texmap_io::{
    CameraAxes, CameraList, CameraPath, CameraPose, FileSource, Intrinsics, LightPath,
};
use texmap_light::Light;
use texmap_math::camera::{Camera, Lens};
use texmap_math::glam::DVec3;
use texmap_scene::Scene;

use crate::cmd::render::RenderArgs;
use crate::failure::{Exit, Failure};
use crate::values::{self, Triple};

/// Position and direction of the camera, and the number of pictures.
#[derive(Args, Debug)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraArgs {
    /// The camera of a glTF model, by its name or number (`texmap info` lists them) [default: one that shows the whole model]
    #[arg(long = "camera", value_name = "NAME|N", conflicts_with_all = ["view", "views", "cameras", "path", "turntable"])]
    pub(crate) named: Option<String>,
    /// The side that is seen: three-quarter (from the front, 35 degrees to the right and 20 above), front, back, left, right, top,
    /// bottom, iso. The camera goes so near that the model fills 90 % of the picture. A scene keeps its own camera without this
    #[arg(long, value_name = "NAME", conflicts_with_all = ["views", "camera_eye", "camera_look", "camera_up", "path", "cameras", "camera_matrix"])]
    view: Option<View>,
    /// The axis of the model that points up: y, z, or auto (z for .stl, y for all others)
    #[arg(long, value_name = "AXIS", default_value = "auto")]
    up: UpAxis,
    /// A parallel projection: size does not depend on distance
    #[arg(long, conflicts_with_all = ["verify", "intrinsics", "path"])]
    orthographic: bool,
    /// Position of the camera
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    camera_eye: Option<Triple>,
    /// The point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    camera_look: Option<Triple>,
    /// The direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    camera_up: Option<Triple>,
    /// Horizontal field of view in degrees [default: the scene's; 40 for models]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = values::fov)]
    fov: Option<f64>,
    /// The camera's pose: 16 numbers, row by row, from camera to world
    #[arg(long, value_name = "M11,M12,...", allow_hyphen_values = true, conflicts_with_all = ["camera_eye", "camera_look", "camera_up"])]
    camera_matrix: Option<Matrix>,
    /// The camera's own axes: opengl (x right, y up, looks along -z; Blender, NeRF) or opencv (y down, looks along +z; COLMAP)
    #[arg(
        long,
        value_name = "NAME",
        default_value = "opengl",
        requires = "camera_matrix"
    )]
    camera_axes: CameraAxes,
    /// The matrix leads from world to camera (extrinsics)
    #[arg(long, requires = "camera_matrix")]
    world_to_camera: bool,
    /// Calibrated focal lengths and principal point in pixels of the picture, from its upper left corner
    #[arg(
        long,
        value_name = "FX,FY,CX,CY",
        allow_hyphen_values = true,
        conflicts_with = "fov"
    )]
    intrinsics: Option<Quad>,
    /// One picture for each camera of a JSON list: [{"name":..,"matrix":[[..],..],"axes":"opencv","world_to_camera":true,
    /// "fx":..,"fy":..,"cx":..,"cy":..,"width":..,"height":..}, ...], or "eye", "look", "up", "fov"
    #[arg(long, value_name = "LIST.json", conflicts_with_all = ["views", "camera_eye", "camera_look", "camera_up", "camera_matrix", "intrinsics", "fov", "orthographic"])]
    pub(crate) cameras: Option<PathBuf>,
    /// A captioned contact sheet of these views, or one picture each if -o has {view}
    #[arg(long, value_name = "LIST", value_delimiter = ',', conflicts_with_all = ["camera_eye", "camera_look", "camera_up", "camera_matrix", "intrinsics"])]
    pub(crate) views: Vec<View>,
    /// N pictures all around the model, from the side of --view on, counter-clockwise from above
    #[arg(long, value_name = "N", conflicts_with_all = ["views", "camera_eye", "camera_look", "camera_up", "camera_matrix", "intrinsics", "cameras", "path"], value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) turntable: Option<u32>,
    /// A walk: key positions of the camera, [{"eye":[x,y,z],"look":[x,y,z],"up":..,"fov":..}, ...]
    #[arg(long, value_name = "CAMERA.json", requires = "frames", conflicts_with_all = ["views", "camera_eye", "camera_look", "camera_up", "fov", "camera_matrix", "intrinsics", "cameras"])]
    pub(crate) path: Option<PathBuf>,
    /// A light that moves over the scene: key positions, [{"position":[x,y,z],"look":[x,y,z]} or {"direction":..}, "color":[r,g,b], ...]. Light
    /// maps must hold the other lights (`texmap bake --except LIGHT`): its own light is baked onto them for each picture
    #[arg(long, value_name = "LIGHT.json", requires = "frames", conflicts_with_all = ["views", "turntable", "cameras"])]
    pub(crate) light_path: Option<PathBuf>,
    /// The light of --light-path, by its name or number [default: the last of the scene]
    #[arg(long, value_name = "NAME|N", requires = "light_path")]
    pub(crate) light: Option<String>,
    /// Pictures along the paths, numbered from 0; without a path, through the animation of a glTF model from --time on
    #[arg(long, value_name = "N", conflicts_with_all = ["views", "turntable", "cameras"], value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) frames: Option<u32>,
    /// Pictures a second of a GIF or APNG, and of the animation of a model
    #[arg(long, value_name = "N", default_value_t = 25.0, value_parser = rate)]
    pub(crate) rate: f64,
}

fn rate(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    number
        .filter(|n| (0.01..=1000.0).contains(n))
        .ok_or_else(|| "expected pictures a second, 0.01 to 1000".to_owned())
}

/// `--up`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum UpAxis {
    Y,
    Z,
    Auto,
}

impl UpAxis {
    fn of(self, input: &Path) -> Up {
        let ending = input.extension().and_then(|e| e.to_str());
        match self {
            Self::Y => Up::Y,
            Self::Z => Up::Z,
            Self::Auto if ending.is_some_and(|e| e.eq_ignore_ascii_case("stl")) => Up::Z,
            Self::Auto => Up::Y,
        }
    }
}

/// Numbers with commas (or blanks) between them.
fn list<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let words = text.split([',', ' ', ';', '\n']).map(str::trim);
    let plain: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    let numbers = values::numbers(&plain.join(","))?;
    <[f64; N]>::try_from(numbers).map_err(|v| format!("expected {N} numbers, got {}", v.len()))
}

#[derive(Clone, Copy, Debug)]
struct Matrix([[f64; 4]; 4]);

impl FromStr for Matrix {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all: [f64; 16] = list(text)?;
        let row = |r: usize| [0, 1, 2, 3].map(|c| all[4 * r + c]);
        Ok(Self([0, 1, 2, 3].map(row)))
    }
}

#[derive(Clone, Copy, Debug)]
struct Quad([f64; 4]);

impl FromStr for Quad {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        list(text).map(Self)
    }
}

/// The contents of the files of cameras.
#[derive(Debug, Default)]
pub(crate) struct CameraFiles {
    walk: Option<CameraPath>,
    light: Option<LightPath>,
    list: Option<CameraList>,
}

/// A camera and its name in names of files.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shot {
    pub(crate) name: Option<String>,
    pub(crate) camera: Camera,
    /// The light that moves, where it stands.
    pub(crate) light: Option<Light>,
    /// Seconds into the animation that is drawn.
    pub(crate) time: Option<f64>,
}

impl CameraArgs {
    /// The list, whose cameras name pictures.
    pub(crate) fn list(&self, files: &FileSource) -> Result<CameraFiles, Failure> {
        let list = self.cameras.as_deref();
        Ok(CameraFiles {
            walk: None,
            light: None,
            list: list.map(|p| CameraList::read_from(p, files)).transpose()?,
        })
    }

    /// The walk is read as well.
    pub(crate) fn walk(
        &self,
        files: &FileSource,
        list: CameraFiles,
    ) -> Result<CameraFiles, Failure> {
        let (walk, light) = (self.path.as_deref(), self.light_path.as_deref());
        Ok(CameraFiles {
            walk: walk.map(|p| CameraPath::read_from(p, files)).transpose()?,
            light: light.map(|p| LightPath::read_from(p, files)).transpose()?,
            ..list
        })
    }

    /// True if the command line sets the camera.
    pub(crate) fn is_placed(&self) -> bool {
        let points = [self.camera_eye, self.camera_look, self.camera_up];
        points.iter().any(Option::is_some)
            || self.camera_matrix.is_some()
            || self.cameras.is_some()
            || self.path.is_some()
    }

    /// Seconds into the animation, picture by picture, if a model moves from picture to picture. The first is at `start`.
    pub(crate) fn times(&self, start: f64) -> Option<impl Iterator<Item = f64> + Clone> {
        let stands = self.path.is_none() && self.light_path.is_none();
        let frames = self.frames.filter(|_| stands)?;
        let rate = self.rate;
        Some((0..frames).map(move |i| start + f64::from(i) / rate))
    }

    /// The automatic camera of a model.
    pub(crate) fn framing(&self, input: &Path) -> Framing {
        Framing {
            view: self.view.unwrap_or_default(),
            up: self.up.of(input),
            fov_x: self.fov.map_or(AUTO_FOV, f64::to_radians),
            parallel: self.orthographic,
        }
    }

    /// The names of the pictures of one input where there are several, or where they are numbered: `None` for a single one.
    pub(crate) fn names(&self, files: &CameraFiles) -> Option<Vec<Option<String>>> {
        let unnamed = |n: u32| vec![None; n as usize];
        match (&files.list, self.turntable.or(self.frames)) {
            (Some(list), _) => Some(list.names()),
            (None, Some(n)) => Some(unnamed(n)),
            (None, None) if !self.views.is_empty() => {
                let name = |view: &View| Some(view.name().to_owned());
                Some(self.views.iter().map(name).collect())
            }
            (None, None) => None,
        }
    }
}

/// The cameras of all pictures of a scene, in order.
pub(crate) fn shots(
    args: &RenderArgs,
    input: &Path,
    scene: &Scene,
    files: &CameraFiles,
    posed: impl Fn(f64) -> Result<Scene, Failure>,
) -> Result<Vec<Shot>, Failure> {
    let (camera, size) = (&args.camera, args.resolution);
    let aspect = f64::from(size.width) / f64::from(size.height);
    let framing = camera.framing(input);
    let unnamed = |camera: Camera| Shot {
        name: None,
        camera,
        light: None,
        time: None,
    };
    let start = || match camera.view {
        Some(_) => framing.camera(scene, aspect).unwrap_or(scene.camera),
        None => scene.camera,
    };
    let empty = || {
        let why = "--view, --views and --turntable frame what is there";
        Failure::new(
            Exit::Input,
            "empty-scene",
            "the scene has no triangles",
            why,
        )
    };
    if let Some(times) = camera.times(args.time.unwrap_or(0.0)) {
        // Named cameras may move: each picture has that of its pose.
        let start = match camera.named {
            Some(_) => scene.camera,
            None => framing
                .camera_over(times.clone().map(posed), aspect)?
                .ok_or_else(empty)?,
        };
        let camera = single(args, input, scene, start)?;
        let shot = |time| Shot {
            time: Some(time),
            ..unnamed(camera)
        };
        return Ok(times.map(shot).collect());
    }
    if let Some(frames) = camera.frames {
        let light = match &files.light {
            Some(path) => Some((path, moving(camera, scene)?)),
            None => None,
        };
        let standing = match files.walk {
            Some(_) => scene.camera,
            None => single(args, input, scene, start())?,
        };
        let shot = |i| Shot {
            light: light.and_then(|(path, light)| path.light(&scene.lights[light], i, frames)),
            ..unnamed(match &files.walk {
                Some(walk) => walk.camera(&scene.camera, i, frames),
                None => standing,
            })
        };
        return Ok((0..frames).map(shot).collect());
    }
    if let Some(list) = &files.list {
        let base = near(scene, scene.camera, input);
        let cameras = list.cameras(&base, size.width, size.height)?;
        let shot = |c: texmap_io::NamedCamera| Shot {
            name: c.name,
            ..unnamed(c.camera)
        };
        return Ok(cameras.into_iter().map(shot).collect());
    }
    if let Some(frames) = camera.turntable {
        let cameras = framing.turntable(scene, aspect, frames);
        return match cameras.is_empty() {
            true => Err(empty()),
            false => Ok(cameras.into_iter().map(unnamed).collect()),
        };
    }
    if !camera.views.is_empty() {
        let shot = |view: &View| {
            let framing = Framing {
                view: *view,
                ..framing
            };
            let camera = framing.camera(scene, aspect).ok_or_else(empty)?;
            Ok(Shot {
                name: Some(view.name().to_owned()),
                ..unnamed(camera)
            })
        };
        return camera.views.iter().map(shot).collect();
    }
    single(args, input, scene, start()).map(|camera| vec![unnamed(camera)])
}

/// The index of the light that moves.
pub(crate) fn moving(flags: &CameraArgs, scene: &Scene) -> Result<usize, Failure> {
    let count = scene.lights.len();
    let refused = |what: String| {
        let why = "name a light that has a place or a direction (`ld`, `lp`, `ls`), by a `name` line or its number from 0";
        Failure::usage(what, why)
    };
    let index = match flags.light.as_deref() {
        None => count.checked_sub(1),
        Some(text) => match text.parse::<usize>() {
            Ok(number) => Some(number).filter(|number| *number < count),
            Err(_) => Some(
                scene
                    .light_named(text)
                    .map_err(|e| refused(format!("--light {text}: {e}")))?,
            ),
        },
    };
    let found = index.filter(|index| !matches!(scene.lights[*index], Light::Ambient { .. }));
    found.ok_or_else(|| match &flags.light {
        Some(text) => refused(format!("--light {text}: no light that moves")),
        None => refused("--light-path: the last light of the scene does not move".to_owned()),
    })
}

/// The camera of a picture: `camera` with what the command line says of it.
pub(crate) fn single(
    args: &RenderArgs,
    input: &Path,
    scene: &Scene,
    mut camera: Camera,
) -> Result<Camera, Failure> {
    let flags = &args.camera;
    let mut placed = false;
    for (point, flag) in [
        (&mut camera.eye, flags.camera_eye),
        (&mut camera.look, flags.camera_look),
        (&mut camera.up, flags.camera_up),
    ] {
        if let Some(value) = flag {
            *point = DVec3::from(value.0);
            placed = true;
        }
    }
    if let Some(degrees) = flags.fov {
        camera.fov_x = degrees.to_radians();
    }
    if let Some(Matrix(rows)) = flags.camera_matrix {
        let pose = CameraPose {
            rows,
            axes: flags.camera_axes,
            world_to_camera: flags.world_to_camera,
        };
        let refused = |e| {
            let why = "give the pose as 4 x 4 numbers row by row; other axes or directions: --camera-axes opencv, --world-to-camera";
            Failure::usage(format!("--camera-matrix: {e}"), why)
        };
        camera = pose.place(&camera).map_err(refused)?;
        camera.lens = Lens::default();
        placed = true;
    }
    if let Some(Quad([fx, fy, cx, cy])) = flags.intrinsics {
        let (width, height) = (args.resolution.width, args.resolution.height);
        let k = Intrinsics { fx, fy, cx, cy };
        let refused = |e| {
            let why =
                "fx and fy are focal lengths in pixels; cx and cy count from the upper left corner";
            Failure::usage(format!("--intrinsics: {e}"), why)
        };
        camera = k
            .apply(&camera, f64::from(width), f64::from(height))
            .map_err(refused)?;
        placed = true;
    }
    if placed {
        camera = near(scene, camera, input);
    }
    if flags.orthographic && (placed || camera.lens.parallel_width.is_none()) {
        camera = parallel(scene, camera);
    }
    Ok(camera)
}

/// A model's camera that was placed by hand cuts nothing away that stands before it.
fn near(scene: &Scene, camera: Camera, input: &Path) -> Camera {
    match Bounds::of(scene).filter(|_| !is_scene(input)) {
        Some(bounds) if bounds.radius > 0.0 => Camera {
            near: camera.near.min(1e-4 * bounds.radius),
            ..camera
        },
        _ => camera,
    }
}

/// The parallel projection that shows as much of the point looked at as a camera does.
fn parallel(scene: &Scene, camera: Camera) -> Camera {
    let central = Camera {
        lens: Lens::default(),
        ..camera
    };
    let width = 2.0 * central.half_width((camera.look - camera.eye).length());
    let far = Bounds::of(scene).map_or(1e3, |b| (b.center - camera.eye).length() + 1.01 * b.radius);
    Camera {
        far: far.max(2.0 * camera.near),
        lens: Lens {
            parallel_width: Some(width),
            ..camera.lens
        },
        ..camera
    }
}

/// True if an input is a scene, with a camera and lights of its own, and not a model.
pub(crate) fn is_scene(input: &Path) -> bool {
    ends_in(input, &["scene"])
}

/// True for the formats of models that move.
pub(crate) fn is_animated(input: &Path) -> bool {
    ends_in(input, &["glb", "gltf"])
}

fn ends_in(input: &Path, endings: &[&str]) -> bool {
    let own = input.extension().and_then(|e| e.to_str());
    own.is_some_and(|own| endings.iter().any(|e| own.eq_ignore_ascii_case(e)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_and_quads_are_counted() {
        let numbers = "1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1";
        assert_eq!(
            numbers.parse::<Matrix>().unwrap().0[1],
            [0.0, 1.0, 0.0, 6.0]
        );
        assert!(
            "1 0 0 5; 0 1 0 6; 0 0 1 7; 0 0 0 1"
                .parse::<Matrix>()
                .is_ok()
        );
        for bad in ["", "1,2,3", "1,0,0,5,0,1,0,6,0,0,1,7,0,0,0,nan"] {
            assert!(bad.parse::<Matrix>().is_err(), "{bad}");
        }
        assert!("500,500,320,240".parse::<Quad>().is_ok());
        assert!("500,500,320".parse::<Quad>().is_err());
    }

    #[test]
    fn the_axis_that_points_up_follows_the_ending() {
        let of = |axis: UpAxis, name: &str| axis.of(Path::new(name));
        assert_eq!(of(UpAxis::Auto, "a.STL"), Up::Z);
        assert_eq!(of(UpAxis::Auto, "a.obj"), Up::Y);
        assert_eq!(of(UpAxis::Z, "a.obj"), Up::Z);
        assert_eq!(of(UpAxis::Y, "a.stl"), Up::Y);
    }
}
