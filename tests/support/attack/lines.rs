//! Command lines of every verb, and what is wrong with them.

use std::ffi::OsString;

use super::rng::Rng;

/// Good command lines. `@` stands before inputs, `>` before outputs, `<` before the file that standard input is. Verbs whose good runs take long (chart, stability, demo) are
/// only called with something wrong.
pub(super) const LINES: [&str; 60] = [
    "render @all.scene -o >out.png --resolution 24x18",
    "info @all.scene",
    "uv @m.obj -o >out.obj --map unwrap --pack 64",
    "diff @check.png @check.gif --json",
    "render @m.obj -o >out.png --resolution 24x18 --msaa 4",
    "hash @check.png @grid.npy",
    "sample @check.png --uv @uv.csv -o >out.npy",
    "warp @check.png -o >out.png --rotate 30",
    "bake @all.scene --object panel --light --size 16 -o >out.png --shadow-size 32",
    "info @m.obj --json",
    "mip @check.png -o >out%d.png",
    "env @sky.hdr -o >out.hdr --to cube --size 4",
    "slice @grid.npy -o >out.png --size 16",
    "uv-raster @m.obj -o >out --size 16",
    "hash --check @list.txt",
    "render @all.scene --path @walk.json --frames 2 -o >out%d.png --resolution 16x12",
    "uv @m.obj --report",
    "uv @m.obj --json --per-triangle --map box",
    "uv @m.obj -o >out.obj --cut @pairs.txt",
    "uv @m.obj -o >out.obj --sew @pairs.txt --tangents >out.npy",
    "sample @check.png --uv @uv.npy --lod 1 -o >out.npy",
    "sample @check.jpg --uv @uv.csv --grad @grad.csv -o >out.npy",
    "info @check.png",
    "info @check.jpg",
    "diff @grid.npy @uv.npy --fail-max 1",
    "diff @check.png @check.jpg --heat >out.png --fail-rms 1",
    "render @all.scene -o >out.png --resolution 16x12 --aov depth,uv,face,position,normal",
    "render @all.scene @m.obj -o {model}.png --resolution 16x12 --json",
    "render @m.obj -o >out.png --resolution 16x12 --views front,iso",
    "render @all.scene --dry-run --explain --quality draft --resolution 16x12",
    "render @all.scene -o >out.png --resolution 16x12 --max-error 1 --json",
    "render @all.scene -o >out.png --resolution 16x12 --root .",
    "render @all.scene -o - --resolution 16x12",
    "env @sky.exr -o >out.exr --to octahedron --blur 4 --size 4",
    "env @check.png -o >out.png --from octahedron --to lat-long --size 4",
    "bake @m.obj --object panel --light --size 16 -o >out.exr --luminance",
    "slice @grid.npy -o >out.png --axis x --at 0.3 --ramp @check.png --size 8",
    "warp @check.jpg -o >out.png --to 0,0 9,1 8,9 1,7 --size 12x12 --outside repeat",
    "uv @m.obj -o >out.obj --map plane --frame 0,0,0,0,0,0,1,1,1 --tile 1,1",
    "render @all.scene -o >out.png --resolution 16x12 --supersample 2 --threads 1 --interp affine --filter nearest",
    "render @bent.glb -o >out.png --resolution 16x12 --time 0.5 --msaa 1",
    "render @plates.gltf -o >out.jpg --resolution 16x12 --env @sky.hdr --env-rotate 30 --tone-map aces",
    "render @p.ply -o >out.webp --resolution 16x12 --wireframe",
    "render @cube.stl -o >out.gif --turntable 4 --resolution 16x12",
    "render @m.obj -o >out.apng --path @walk.json --frames 3 --resolution 16x12",
    "render @bent.glb -o >cam{n}.png --cameras @cams.json --resolution 16x12",
    "render @p.ply -o >{view}.png --cameras @cams.json --resolution 16x12 --json",
    "render @cube.stl -o >out.exr --intrinsics 20,20,8,6 --resolution 16x12 --aov depth,normal",
    "render @p.ply -o >out.hdr --camera-matrix 1,0,0,0,0,1,0,0,0,0,1,6,0,0,0,1 --exposure 2 --resolution 16x12",
    "render - <m.obj --texture @check.png -o >out.png --resolution 16x12",
    "render - <cube.stl --env @sky.exr --shading metallic-roughness -o - --resolution 16x12",
    "render @@models.txt -o >made/{model}.png --resolution 16x12",
    "render @p.ply @cube.stl @bent.glb -o >made/{model}.jpg --resolution 16x12 --json",
    "render @m.obj -o >out.png --bits 16 --material checker --up z --view top --resolution 16x12",
    "render @m.obj -o >side{view}.png --views front,top --resolution 16x12 --orthographic",
    "info @bent.glb --json",
    "info @plates.gltf",
    "info @p.ply",
    "info @cube.stl --json",
    "bake @all.scene --object all --light --size 8 -o >map-{object}.png",
];

/// Lines of verbs whose good runs take long: each is wrong in itself.
const WRONG: [&str; 10] = [
    "chart none.scene -o out.html",
    "chart -o out.txt",
    "chart -o check.png/out.html --quick",
    "stability NONE",
    "stability --jsn",
    "demo none -o out.png",
    "demo --list --json",
    "demo fence",
    "demo light-maps -o out.png --frames 3",
    "chart all.scene -o out.html --resolution 0x0",
];

const FLAGS: [&str; 51] = [
    "--resolution",
    "--size",
    "--threads",
    "--supersample",
    "--msaa",
    "--filter",
    "--wrap",
    "--interp",
    "--level",
    "--fov",
    "--camera-eye",
    "--background",
    "--env-shadows",
    "--aov",
    "--views",
    "--frames",
    "--path",
    "--map",
    "--by",
    "--frame",
    "--repeat",
    "--tile",
    "--pack",
    "--gutter",
    "--cut-angle",
    "--texture-size",
    "--lod",
    "--color",
    "--fail-max",
    "--at",
    "--blur",
    "--keep-coverage",
    "--shadow-taps",
    "--root",
    "--matrix",
    "--turntable",
    "--cameras",
    "--camera",
    "--camera-matrix",
    "--camera-axes",
    "--intrinsics",
    "--env",
    "--env-rotate",
    "--exposure",
    "--tone-map",
    "--texture",
    "--time",
    "--animation",
    "--rate",
    "--bits",
    "--memory-limit",
];

const VALUES: [&str; 36] = [
    "0",
    "-1",
    "1",
    "2",
    "16384",
    "65537",
    "4294967296",
    "1e300",
    "nan",
    "inf",
    "-inf",
    "1e-45",
    "",
    " ",
    "x",
    "0x0",
    "16384x16384",
    "1,2",
    "1,2,3",
    "0,0,0,0,0,0,0,0,0",
    "nan,nan,nan",
    "1e38,1e38,1e38",
    "none",
    "auto",
    "trilinear",
    "anisotropic:0",
    "span:99999999999",
    "../..",
    "/",
    "QQQQ",
    "check.png",
    "cams.json",
    "walk.json",
    "nan,nan,nan,nan",
    "1e-300,1e300,0,0",
    "1,0,0,1e300,0,1,0,0,0,0,1,0,0,0,0,1",
];

/// The words of a line, with what `@` and `>` mark.
#[derive(Debug, Default)]
pub(super) struct Line {
    pub(super) words: Vec<OsString>,
    /// Indices of the words that are inputs.
    pub(super) inputs: Vec<usize>,
    /// Indices of the words that are outputs.
    pub(super) outputs: Vec<usize>,
    /// File that is standard input.
    pub(super) stdin: Option<OsString>,
}

impl Line {
    pub(super) fn new(text: &str) -> Self {
        let mut line = Self::default();
        for word in text.split(' ') {
            let i = line.words.len();
            let name = match word.split_at(1) {
                ("<", name) => {
                    line.stdin = Some(name.into());
                    continue;
                }
                ("@", name) => {
                    line.inputs.push(i);
                    name
                }
                (">", name) => {
                    line.outputs.push(i);
                    name
                }
                _ => word,
            };
            line.words.push(name.into());
        }
        line
    }

    pub(super) fn wrong(rng: &mut Rng) -> Self {
        Self::new(rng.pick(&WRONG))
    }

    /// The file that an input word names: a list stands behind a `@`.
    pub(super) fn file(&self, at: usize) -> OsString {
        let word = &self.words[at];
        let list = word.to_str().and_then(|word| word.strip_prefix('@'));
        list.map_or_else(|| word.clone(), OsString::from)
    }

    /// Files of the desk that the line reads for certain: no output may replace them.
    pub(super) fn reads(&self) -> Vec<OsString> {
        let mut names: Vec<OsString> = self.inputs.iter().map(|&at| self.file(at)).collect();
        let draws = self
            .words
            .first()
            .is_some_and(|verb| matches!(verb.to_str(), Some("render" | "bake")));
        let more: &[(&str, &[&str])] = &[
            ("all.scene", &["part.scene", "check.png"]),
            ("m.obj", &["m.mtl", "check.png"]),
            ("plates.gltf", &["plates.bin", "leaf card.png"]),
            ("p.ply", &["check.png"]),
        ];
        for (name, named) in more.iter().filter(|_| draws) {
            if names.iter().any(|known| known == name) {
                names.extend(named.iter().map(OsString::from));
            }
        }
        names
    }

    pub(super) fn text(&self) -> String {
        let words: Vec<_> = self.words.iter().map(|w| w.to_string_lossy()).collect();
        words.join(" ")
    }

    /// Adds, drops, doubles or spoils a word after the verb.
    pub(super) fn spoil(&mut self, rng: &mut Rng) {
        let at = 1 + rng.below(self.words.len() - 1);
        match rng.below(6) {
            0 => drop(self.words.remove(at)),
            1 => {
                let word = self.words[at].clone();
                self.words.insert(at, word);
            }
            2 => self.words.push(odd_name(rng)),
            3 => self.words[at] = rng.pick(&VALUES).into(),
            _ => {
                self.words.push(rng.pick(&FLAGS).into());
                if !rng.chance(6) {
                    self.words.push(rng.pick(&VALUES).into());
                }
            }
        }
        // The roles of the words are no longer known.
        self.inputs.clear();
        self.outputs.clear();
    }
}

/// Names that are seldom thought of.
pub(super) fn odd_name(rng: &mut Rng) -> OsString {
    let names = [
        "",
        ".",
        "/",
        "..",
        "-",
        "--",
        "/dev/full",
        "/dev/zero",
        "/dev/null",
        "/dev/stdin",
        "none/out.png",
        "secret.txt",
        "a\nb.png",
        "\u{1b}[31mred.png",
        "out\u{202e}gnp.png",
        "out",
        "%d.png",
        "%99d.png",
        "{model}",
        "check.png/x.png",
        "~",
        "*.png",
        "out.PNG",
        "check.png",
        "./check.png",
        "m.obj",
        "m.mtl",
        "all.scene",
        "out.gif",
        "out{n}.png",
        "@models.txt",
    ];
    match rng.below(names.len() + 3) {
        0 => "Q".repeat(300).into(),
        1 => format!("{}.png", "Q".repeat(5000)).into(),
        2 => not_unicode(b"o\xff\xfet.png"),
        i => names[i - 3].into(),
    }
}

/// A name of any bytes, where names may be that.
pub(super) fn not_unicode(bytes: &[u8]) -> OsString {
    #[cfg(unix)]
    return std::os::unix::ffi::OsStringExt::from_vec(bytes.to_vec());
    #[cfg(not(unix))]
    String::from_utf8_lossy(bytes).into_owned().into()
}
