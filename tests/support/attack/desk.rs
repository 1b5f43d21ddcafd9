//! The folder that a case runs in: good files of every kind that the program reads.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use texmap_io::npy;

use crate::exr_files;

/// Stands in `secret.txt` and must never stand in a message.
pub(super) const SECRET: &str = "hunter2-s3cr3t";

/// Content of outputs that exist before the run.
pub(super) const OLD: &[u8] = b"the old file";

/// Bytes of a file from which on its content is not compared. Pictures that a case writes are smaller: a light map of
/// 1,024 texels a side is one of 12 MB.
const LARGEST_READ: u64 = 64 << 20;

/// A scene that names a file of every kind.
const ALL: &str = "\
eye 0 1 6
look 0 1 0
fov 60
la 0.4 0.4 0.4
ld 0.6 0.6 0.6 0.3 -1 -0.5
shadow 32
surf 0.9 0.7 0.5 0.4 0.6 0.1 8
include part.scene
v -2 0 -2
v 2 0 -2
v 2 0 4
v -2 0 4
f 0 1 2
texture check.png
tf 0 0 0 3 0 4 2 4 4 1 4 0
";

/// Lines that are added to the scene one at a time. Each brings one more kind of file, or one more effect.
const MORE: [&str; 28] = [
    "obj m.obj",
    "env sky.hdr lat-long 0.3\nobj m.obj",
    "solid grid.npy 0 0 0 4 4 4\nf 0 1 2",
    "bump check.png 0.1\nobj m.obj",
    "displace check.png 0.1\nobj m.obj",
    "terrain check.png 0 0 0 2 1 2",
    "volume grid.npy 0 1 0 2 2 2 1",
    "sky sky.hdr lat-long",
    "decal check.png 0 0 1 1\nobj m.obj",
    "font check.png 2 2 65\ntext \"AB\" 0 1 0 0.3 0 0 0 0.4 0",
    "projector check.png light 0 3 3 0 0 0 0 1 0 40",
    "lightmap check.png\nlightmapuv m.obj\nobj m.obj",
    "normalmap check.png\nobj m.obj",
    "specmap sky.hdr lat-long 8\nobj m.obj",
    "billboard 0 1 0 1 1",
    "bone 0 0 0 0 1 0\nskin smooth 0.2\nobj m.obj",
    "ls 1 1 1 0 4 0 0 -1 0 20 40\nshadow 32 taps 3 slope 0.01",
    "lp 1 1 1 0 4 1\nshadow 16 normal-offset 1 area 0 0 0 3",
    "round sphere 0 0 0 10 20 30 2 2 2 3 1\nff 0 1 2 3",
    "frame 0 0 0 1 0 0 0 0 1\nff 0 1 2 3",
    "carve marble 0.1 0 0 0 1 1 1 octaves 5 fold 2\nobj m.obj",
    "carve waves 0.1 0 0 0 1 1 1 around 7\nobj m.obj",
    "emboss \"AB\" 0.1\nobj m.obj",
    "offsetmap check.png 0.5 down\nobj m.obj",
    "translate 1 0 0\nrotate 30 0 1 0\nscale 2 1 1\nobj m.obj",
    "alpha test 0.5\nfilter anisotropic:8\nwrap clamp-to-border repeat\nborder 1 0 0 0.5\ntf 0 -1 -1 1 9 0 2 4 4",
    "shade modulate vertex\ngouraud perspective\ninterp span:8\ntf 0 0 0 1 1 0 2 1 1",
    "solid wood 0 0 0 1 1 1 octaves 3 fold 0.4\nramp check.png\ncel check.png\nf 0 1 2",
];

const PART: &str = "v 0 2 0\nv 1 2 0\nv 0 3 0\nf 0 1 2\n";

const MODEL: &str = "\
mtllib m.mtl
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
v 0 0 1
vt 0 0
vt 2 0
vt 2 1
vt 0 1
o panel
usemtl paper
f 1/1 2/2 3/3 4/4
o spike
usemtl plain
f 1/1 2/2 5/3
";

const LIBRARY: &str = "\
newmtl paper
Kd 1 1 1
map_Kd check.png
newmtl plain
Kd 0.8 0.2 0.2
Ks 0.2 0.2 0.2
Ns 20
";

const POLYGONS: &str = "\
ply
format ascii 1.0
comment TextureFile check.png
element vertex 4
property float x
property float y
property float z
property float s
property float t
property uchar red
property uchar green
property uchar blue
element face 2
property list uchar int vertex_indices
end_header
-1 -1 0 0 0 255 0 0
1 -1 0 1 0 0 255 0
1 1 0 1 1 0 0 255
-1 1 0 0 1 9 9 9
4 0 1 2 3
3 0 2 3
";

/// Models of the examples, as they are.
const ASSETS: [&str; 5] = [
    "gltf/bent.glb",
    "gltf/plates.gltf",
    "gltf/plates.bin",
    "gltf/leaf card.png",
    "models/cube.stl",
];

/// A folder of its own for each case.
#[derive(Debug)]
pub(super) struct Desk {
    folder: TempDir,
}

impl Desk {
    /// `more` chooses what the scene holds beside its floor.
    pub(super) fn new(more: usize) -> io::Result<Self> {
        let desk = Self {
            folder: tempfile::tempdir()?,
        };
        let put = |name: &str, text: &str| fs::write(desk.path(name), text);
        put("all.scene", &format!("{ALL}{}\n", MORE[more % MORE.len()]))?;
        put("part.scene", PART)?;
        put("m.obj", MODEL)?;
        put("m.mtl", LIBRARY)?;
        put("uv.csv", "0.1,0.2\n0.5,0.5\n0.9,0.1\n")?;
        put("grad.csv", "0.1,0,0,0.1\n0.2,0,0,0.2\n0,0.1,0.1,0\n")?;
        put("pairs.txt", "1 3\n")?;
        put(
            "walk.json",
            r#"[{"eye":[0,1,6],"look":[0,1,0]},{"eye":[3,1,6],"look":[0,1,0],"fov":40}]"#,
        )?;
        put(
            "cams.json",
            r#"[{"name":"l","eye":[0,1,6],"look":[0,0,0]},{"name":"r","matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,6],[0,0,0,1]],"fx":20,"fy":20,"cx":8,"cy":6,"width":16,"height":12}]"#,
        )?;
        put("models.txt", "# Both.\nall.scene\nm.obj\n")?;
        put("p.ply", POLYGONS)?;
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
        for name in ASSETS {
            let from = assets.join(name);
            fs::write(
                desk.path(from.file_name().unwrap_or_default()),
                fs::read(&from)?,
            )?;
        }
        put("list.txt", "sha256:00  check.png\n")?;
        put("secret.txt", &format!("user {SECRET}\n{SECRET} {SECRET}\n"))?;
        let texel = |x: u32, y: u32| image::Rgba([x as u8 * 30, y as u8 * 30, 90, 255]);
        let picture = image::RgbaImage::from_fn(8, 8, texel);
        let save = |result: image::ImageResult<()>| result.map_err(io::Error::other);
        save(picture.save(desk.path("check.png")))?;
        save(picture.save(desk.path("check.gif")))?;
        let rgb = image::DynamicImage::ImageRgba8(picture).into_rgb8();
        save(rgb.save(desk.path("check.jpg")))?;
        let sky = image::Rgb32FImage::from_fn(8, 4, |x, y| image::Rgb([x as f32, y as f32, 1.0]));
        save(sky.save(desk.path("sky.hdr")))?;
        let sky = image::DynamicImage::ImageRgb32F(sky).into_rgba32f();
        exr_files::write(&desk.path("sky.exr"), &sky).map_err(io::Error::other)?;
        let values: Vec<f32> = (0..8).map(|i| i as f32 / 8.0).collect();
        let array = |name: &str, shape: &[usize]| {
            npy::write(&desk.path(name), shape, npy::Values::F32(&values)).map_err(io::Error::other)
        };
        array("grid.npy", &[2, 2, 2])?;
        array("uv.npy", &[4, 2])?;
        Ok(desk)
    }

    pub(super) fn root(&self) -> &Path {
        self.folder.path()
    }

    pub(super) fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Everything in the folder, hidden files too, with the content of what is an ordinary file of ordinary size.
    pub(super) fn state(&self) -> io::Result<Vec<(PathBuf, Option<Vec<u8>>)>> {
        let mut state = Vec::new();
        for entry in fs::read_dir(self.root())? {
            let entry = entry?;
            let metadata = fs::symlink_metadata(entry.path())?;
            let small = metadata.is_file() && metadata.len() < LARGEST_READ;
            let content = small.then(|| fs::read(entry.path())).transpose()?;
            state.push((entry.file_name().into(), content));
        }
        state.sort();
        Ok(state)
    }
}
