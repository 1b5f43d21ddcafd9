//! Random scenes in the scene language: every effect that it has words for, in many combinations.

use std::path::PathBuf;

use texmap_io::{IoError, npy};

use crate::random::Random;

const TEXTURES: [&str; 9] = [
    "brick.png",
    "carpet.gif",
    "checker.png",
    "face.png",
    "fence.png",
    "leaf.gif",
    "leaf.png",
    "uv_grid.png",
    "ceilingtile.gif",
];
const MODELS: [&str; 8] = [
    "ball",
    "cone",
    "cube",
    "cylinder",
    "head",
    "house",
    "twisted_box",
    "teapot_white",
];

/// The folders of the files that scenes name.
#[derive(Clone, Debug)]
pub struct Folders {
    /// `assets` of the repository.
    pub assets: PathBuf,
    /// `data` of this package: pictures in formats that `assets` lacks.
    pub data: PathBuf,
    /// Takes what is written.
    pub work: PathBuf,
}

/// Writes what all random scenes share: two grids, a second model with a material of many maps, a file to be included.
///
/// # Errors
/// A file that cannot be written.
pub fn shared(folders: &Folders) -> Result<(), IoError> {
    let mut random = Random::new(1000);
    let bytes: Vec<u8> = (0..9 * 7 * 8).map(|_| random.next() as u8).collect();
    npy::write(
        &folders.work.join("grid.npy"),
        &[9, 7, 8],
        npy::Values::U8(&bytes),
    )?;
    let colours: Vec<f32> = (0..5 * 6 * 4 * 4).map(|_| random.range(0.0, 1.0)).collect();
    npy::write(
        &folders.work.join("fog.npy"),
        &[5, 6, 4, 4],
        npy::Values::F32(&colours),
    )?;
    let textures = folders.assets.join("textures");
    let textures = textures.display();
    let library = format!(
        "newmtl all\nKd 0.8 0.7 0.9\nKs 0.6 0.5 0.4\nNs 30\nillum 3\n\
         map_Kd -s 2 1 1 -o 0.25 0 0 {textures}/uv_grid.png\nmap_Ka {textures}/brick.png\n\
         map_Ks {textures}/checker.png\nmap_Ns {textures}/brick.png\nmap_Bump -bm 0.05 {textures}/brick.png\n\
         newmtl cut\nKd 1 1 1\nd 0.7\nmap_Kd {textures}/leaf.png\nmap_d {textures}/fence.png\n\
         newmtl moved\nKd 0.9 0.9 0.9\nmap_Kd -clamp on {textures}/brick.png\ndisp -bm 0.1 {textures}/hills.png\n\
         newmtl turned\nKd 0.7 0.7 0.9\nmap_Kd {textures}/brick.png\nnorm {textures}/uv_grid.png\nKe 0.2 0.1 0.3\nmap_Ke {textures}/checker.png\n"
    );
    let sheet = |name: &str, at: f32| {
        let (x, y) = (at - 1.0, at);
        format!(
            "o {name}\nusemtl {name}\nv {x} 0 {at}\nv {y} 0 {at}\nv {y} 1 {at}\nv {x} 1.2 {at}\n\
             f -4/1 -3/2 -2/3 -1/4\n"
        )
    };
    let model: String = ["all", "cut", "moved", "turned"]
        .iter()
        .enumerate()
        .map(|(i, name)| sheet(name, i as f32 * 0.6 - 1.0))
        .collect();
    let model = format!("mtllib maps.mtl\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n{model}");
    let part = format!(
        "texture {textures}/checker.png\nfilter ewa:4\nv -0.4 0 -0.4\nv 0.4 0 -0.4\nv 0.4 0.9 -0.5\nv -0.4 0.9 -0.3\n\
         tf 0 0 1 1 1 1 2 1 0 3 0 0\n"
    );
    for (name, text) in [
        ("maps.mtl", library),
        ("maps.obj", model),
        ("part.scene", part),
    ] {
        let path = folders.work.join(name);
        std::fs::write(&path, text).map_err(|source| IoError::Write { path, source })?;
    }
    Ok(())
}

/// The text of a random scene; the same for the same seed and folders.
#[must_use]
pub fn text(seed: u64, folders: &Folders) -> String {
    let mut scene = Text {
        random: Random::new(seed + 2000),
        folders,
        out: String::new(),
        vertices: 0,
        bones: 0,
    };
    scene.whole();
    scene.lights();
    scene.floor();
    for thing in 0..5 {
        scene.line("push");
        scene.settings();
        scene.thing(seed as usize + thing);
        scene.line("pop");
    }
    scene.in_space();
    scene.out
}

struct Text<'a> {
    random: Random,
    folders: &'a Folders,
    out: String,
    vertices: usize,
    bones: usize,
}

impl Text<'_> {
    fn line(&mut self, line: &str) {
        self.out.push_str(line);
        self.out.push('\n');
    }

    fn number(&mut self, low: f32, high: f32) -> String {
        // Three digits: the text is the same however numbers are printed.
        let value = self.random.range(low * 1000.0, high * 1000.0) as i32;
        let (sign, value) = (if value < 0 { "-" } else { "" }, value.abs());
        format!("{sign}{}.{:03}", value / 1000, value % 1000)
    }

    fn numbers<const N: usize>(&mut self, low: f32, high: f32) -> String {
        [(); N].map(|()| self.number(low, high)).join(" ")
    }

    fn texture(&mut self) -> String {
        let name = self.random.pick(&TEXTURES);
        format!("{}/textures/{name}", self.folders.assets.display())
    }

    /// A picture of heights or slopes: opaque.
    fn heights(&mut self) -> String {
        let name = self.random.pick(&["hills.png", "brick.png", "uv_grid.png"]);
        format!("{}/textures/{name}", self.folders.assets.display())
    }

    fn sky(&mut self) -> (String, &'static str) {
        let (name, chart) = self.random.pick(&[
            ("half_piz.exr", "lat-long"),
            ("half_pxr24.exr", "lat-long"),
            ("float_zip.exr", "lat-long"),
            ("half_b44.exr", "lat-long"),
            ("sky.hdr", "lat-long"),
            ("cube.hdr", "cube"),
            ("octahedron.exr", "octahedron"),
            ("equal.exr", "equal-area-octahedron"),
            ("paraboloid.hdr", "dual-paraboloid"),
            ("tan.exr", "tan-cube"),
            ("ball.hdr", "sphere-map"),
        ]);
        let folder = match name.starts_with("half_") || name.starts_with("float_") {
            true => &self.folders.data,
            false => &self.folders.work,
        };
        (folder.join(name).display().to_string(), chart)
    }

    fn whole(&mut self) {
        let eye = format!(
            "{} {} {}",
            self.number(-2.0, 2.0),
            self.number(0.6, 2.4),
            self.number(2.6, 4.5)
        );
        self.line(&format!("eye {eye}"));
        let look = self.numbers::<3>(-0.3, 0.5);
        self.line(&format!("look {look}\nup 0.1 1 0.05"));
        let fov = self.number(40.0, 75.0);
        let background = self.numbers::<3>(0.0, 1.0);
        self.line(&format!("fov {fov}\nbackground {background} 0.5"));
        if self.random.one_in(4) {
            self.line("near 0.5\nfar 30");
        }
        if self.random.one_in(5) {
            self.line("color raw");
        }
        if self.random.one_in(3) {
            let (file, chart) = self.sky();
            match self.random.one_in(3) {
                true => {
                    let file = self.texture();
                    self.line(&format!("sky {file}"));
                }
                false => self.line(&format!("sky {file} {chart}")),
            }
        }
        self.line("missing warn");
    }

    fn lights(&mut self) {
        let ambient = self.numbers::<3>(0.1, 0.4);
        self.line(&format!("la {ambient}"));
        let color = self.numbers::<3>(0.2, 0.8);
        let toward = self.numbers::<2>(-0.8, 0.8);
        self.line(&format!("ld {color} {toward} -0.9\nname sun"));
        self.shadow("area 0 0 0 4");
        let color = self.numbers::<3>(0.2, 0.7);
        let place = self.numbers::<2>(-2.0, 2.0);
        match self.random.one_in(2) {
            true => {
                self.line(&format!("lp {color} {place} 2.5"));
                self.shadow("area 0 0 0 3");
            }
            false => {
                self.line(&format!("ls {color} {place} 3 0.1 -0.4 -1 30 60"));
                self.shadow("");
            }
        }
        for kind in ["light", "paint"] {
            if self.random.one_in(3) {
                let file = self.texture();
                let place = self.numbers::<2>(-2.0, 2.0);
                let border = self.random.pick(&["black", "clamp", "repeat"]);
                let shadow = self.random.pick(&["", " shadow 128", " shadow 70"]);
                self.line(&format!(
                    "projector {file} {kind} {place} 4 0 0 0 0 1 0 35 {border} soft 0.1 color 0.9 1 0.7{shadow}"
                ));
            }
        }
    }

    fn shadow(&mut self, area: &str) {
        let size = self.random.pick(&["", " auto", " 130", " 256"]);
        let taps = self.random.pick(&["", " taps 1", " taps 3", " taps 5"]);
        let bias = self
            .random
            .pick(&["", " slope 0.001", " constant 0.02", " normal-offset 1.5"]);
        // An area asks for a size.
        let area = match self.random.one_in(3) && !area.is_empty() && size.len() > 1 {
            true => format!(" {area}"),
            false => String::new(),
        };
        if !self.random.one_in(4) {
            self.line(&format!("shadow{size}{taps}{bias}{area}"));
        }
    }

    fn floor(&mut self) {
        let texture = self.texture();
        self.line(&format!(
            "texture {texture}\nshade modulate pixel\nsurf 0.9 0.9 0.8 1 1 0.3 9"
        ));
        self.line("push\ntranslate 0 -0.6 0");
        self.quad(3.0);
        self.line("pop");
        self.line("texture none\nshade decal pixel");
    }

    /// A level sheet of half-side `half`, not quite flat, as a textured face.
    fn quad(&mut self, half: f32) {
        let first = self.vertices;
        for [x, z] in [[-half, half], [half, half], [half, -half], [-half, -half]] {
            let tilt = self.number(-0.1, 0.1);
            self.line(&format!("v {x} {tilt} {z}"));
        }
        self.vertices += 4;
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
        self.line(&format!("tf {a} 0 2 {b} 2 2 {c} 2 0 {d} 0 0"));
    }

    fn settings(&mut self) {
        let file = self.texture();
        let missing = self.random.one_in(12);
        self.line(&match missing {
            true => "texture absent.png".to_owned(),
            false => format!("texture {file}"),
        });
        let filter = self.random.pick(&[
            "nearest",
            "bilinear",
            "bicubic:catmull-rom",
            "bicubic:mitchell",
            "bicubic:b-spline",
            "mip-nearest",
            "bilinear-mip-nearest",
            "trilinear",
            "anisotropic:2",
            "anisotropic:16",
            "ewa:1",
            "ewa:8",
        ]);
        const WRAPS: [&str; 5] = [
            "repeat",
            "mirrored-repeat",
            "clamp-to-edge",
            "clamp-to-border",
            "mirror-clamp-to-edge",
        ];
        let (u, v) = (self.random.pick(&WRAPS), self.random.pick(&WRAPS));
        let interp = self.random.pick(&[
            "perspective",
            "perspective",
            "perspective",
            "affine",
            "subdivided:3",
            "span:16",
            "within:0.5",
        ]);
        let cull = self.random.pick(&["none", "none", "back", "front"]);
        let alpha = self
            .random
            .pick(&["auto", "opaque", "test", "test 0.3", "blend"]);
        let shade = self.random.pick(&[
            "decal pixel",
            "modulate pixel",
            "modulate pixel",
            "modulate vertex",
        ]);
        let gouraud = self.random.pick(&["screen", "perspective"]);
        let highlight = self.random.pick(&["phong", "blinn"]);
        let surf = self.numbers::<3>(0.2, 1.0);
        let terms = self.numbers::<3>(0.1, 1.0);
        let exponent = self.random.pick(&["1", "5", "30.5", "200"]);
        self.line(&format!(
            "filter {filter}\nwrap {u} {v}\nborder 0.2 0.7 0.4 0.6\ninterp {interp}\ncull {cull}\nalpha {alpha}\n\
             shade {shade}\ngouraud {gouraud}\nhighlight {highlight}\nsurf {surf} {terms} {exponent}"
        ));
        let place = self.numbers::<3>(-1.0, 1.0);
        let turn = self.number(-70.0, 70.0);
        let scale = self.random.pick(&["1.1", "0.9 1.2 0.8", "-1 1 1"]);
        self.line(&format!(
            "translate {place}\nrotate {turn} 0.2 1 0.3\nscale {scale}"
        ));
        if self.random.one_in(5) {
            self.line("shadowless yes");
        }
        if self.random.one_in(4) {
            self.line("horizon open");
        }
        if self.random.one_in(3) {
            let (file, chart) = self.sky();
            let mips = self.random.pick(&["", " mips"]);
            let share = self.number(0.2, 1.0);
            self.line(&format!("env {file} {chart} {share}{mips}"));
        }
        if self.random.one_in(6) {
            let (file, chart) = self.sky();
            self.line(&format!("specmap {file} {chart} 6"));
        }
        if self.random.one_in(6) {
            let file = self.texture();
            self.line(&format!("decal {file} 0.2 0.3 0.5 0.4"));
        }
        if self.random.one_in(6) {
            let file = self.texture();
            self.line(&format!("cel {file}"));
        }
        if self.random.one_in(6) {
            let color = self.numbers::<3>(0.0, 0.6);
            let file = self.texture();
            let map = if self.random.one_in(2) {
                file
            } else {
                String::new()
            };
            self.line(&format!("emission {color} {map}"));
        }
        if self.random.one_in(6) {
            let kind = self.random.pick(&[
                "marble 0 0 0 0.4 0.4 0.4 octaves 3 fold 0.8",
                "wood 0.1 0 0 0.2 0.2 0.5",
                "noise 0 0 0 0.3 0.2 0.3 octaves 2",
            ]);
            let grid = self.folders.work.join("grid.npy");
            match self.random.one_in(3) {
                true => self.line(&format!("solid {} 0 0 0 2 2 2", grid.display())),
                false => self.line(&format!("solid {kind}")),
            }
            if self.random.one_in(2) {
                let file = self.texture();
                self.line(&format!("ramp {file}"));
            }
        }
    }

    fn detail(&mut self) {
        let file = self.heights();
        let green = self.random.pick(&["up", "down"]);
        let height = self.number(0.02, 0.3);
        let detail = match self.random.next() % 8 {
            0 => format!("bump {file} {height}"),
            1 => format!("offsetmap {file} {height} {green}"),
            2 => format!("normalmap {file} tangent {green} xyz"),
            3 => format!("normalmap {file} object {green} xy"),
            4 => format!("carve waves {height} 0 0 0 1 0.3 1 around 9 fold 0.2"),
            5 => format!("carve marble {height} 0 0 0 0.3 0.3 0.3 octaves 3 fold 0.5"),
            6 => format!("emboss \"CS 184\" {height}"),
            _ => return,
        };
        self.line(&detail);
    }

    fn thing(&mut self, kind: usize) {
        let model = format!(
            "{}/models/{}.obj",
            self.folders.assets.display(),
            self.random.pick(&MODELS)
        );
        match kind % 11 {
            0 => {
                self.detail();
                self.line(&format!("obj {model}"));
            }
            1 => {
                self.detail();
                self.quad(0.9);
            }
            2 => {
                let file = self.heights();
                self.line(&format!(
                    "displace {file} 0.2 middle 0.3 pixels 4 triangles 60000"
                ));
                self.quad(0.8);
            }
            3 => {
                let frame = self.random.pick(&[
                    "frame -1 0 0.2 2 0 0 0 1.5 0.3",
                    "round sphere 0 0.2 0 10 20 30 1.4 1.2 1 2 1",
                    "round cylinder 0 0 0 0 0 0 1 1 1",
                ]);
                self.line(frame);
                let first = self.vertices;
                self.line("v -1 0 0.2\nv 1 0 0.2\nv 1 1.4 0.4\nv 0 1.8 0\nv -1 1.2 0.3");
                self.vertices += 5;
                let corners: Vec<String> = (first..first + 5).map(|i| i.to_string()).collect();
                self.line(&format!("ff {}", corners.join(" ")));
            }
            4 => {
                let heights = self.folders.assets.join("textures/hills.png");
                self.line(&format!(
                    "terrain {} 0 -0.5 0 3 0.6 3 step 9",
                    heights.display()
                ));
            }
            5 => {
                let axis = self.random.pick(&["", " axis 0 1 0.1"]);
                self.line(&format!("billboard 0 0 0 1 1.3{axis}"));
            }
            6 => {
                let first = self.bones;
                self.line(&format!(
                    "bone 0 -0.5 0 0 0.1 0\nbone 0 0.1 0 0 0.8 0 parent {first} turn 40 0 0.3 1"
                ));
                self.bones += 2;
                let skin = self.random.pick(&["rigid", "smooth 0.4"]);
                self.line(&format!("skin {skin}\nobj {model}"));
            }
            7 => {
                let first = self.vertices;
                self.line(
                    "v -0.7 -0.4 0.5\nv 0.8 -0.4 0.4\nv 0.9 0.6 0\nv 0 1.1 -0.2\nv -0.8 0.7 0",
                );
                self.vertices += 5;
                let corners: Vec<String> = (first..first + 5).map(|i| i.to_string()).collect();
                self.line(&format!("f {}", corners.join(" ")));
            }
            8 => {
                let folder = self.folders.work.display();
                self.line(&format!(
                    "obj {folder}/maps.obj\ninclude {folder}/part.scene"
                ));
            }
            9 => {
                let map = self.folders.data.join("photo_420.jpg");
                self.line(&format!(
                    "shade modulate pixel\nlightmap {} 1.5\nlightmapuv {model}\nobj {model}",
                    map.display()
                ));
            }
            _ => {
                let lit = self.random.pick(&["decal", "modulate"]);
                self.line(&format!(
                    "shade {lit} pixel\ntext \"texmap {}\" -1 0 0.2 0.35 0.02 0 0 0.6 0.1",
                    kind
                ));
            }
        }
    }

    fn in_space(&mut self) {
        if self.random.one_in(2) {
            let name = self.random.pick(&["grid.npy", "fog.npy"]);
            let grid = self.folders.work.join(name);
            if self.random.one_in(2) {
                let file = self.texture();
                self.line(&format!("ramp {file}"));
            }
            let density = self.number(0.5, 4.0);
            let step = self.random.pick(&["", " step 0.05"]);
            self.line(&format!(
                "volume {} 0.3 0.2 0.4 1.4 1 1.2 {density}{step}",
                grid.display()
            ));
        }
    }
}
