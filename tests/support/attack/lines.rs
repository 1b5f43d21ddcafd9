//! Command lines of every verb, and what is wrong with them.

use std::ffi::OsString;

use super::rng::Rng;

/// Good command lines. `@` stands before inputs, `>` before outputs. Verbs whose good runs take long (chart, stability, demo) are
/// only called with something wrong.
pub(super) const LINES: [&str; 40] = [
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
];

/// Lines of verbs whose good runs take long: each is wrong in itself.
const WRONG: [&str; 10] = [
    "chart none.scene -o out.html",
    "chart -o out.txt",
    "chart -o none/out.html --quick",
    "stability NONE",
    "stability --jsn",
    "demo none -o out.png",
    "demo --list --json",
    "demo fence",
    "demo light-maps -o out.png --frames 3",
    "chart all.scene -o out.html --resolution 0x0",
];

const FLAGS: [&str; 34] = [
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
];

const VALUES: [&str; 30] = [
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
];

/// The words of a line, with what `@` and `>` mark.
#[derive(Debug, Default)]
pub(super) struct Line {
    pub(super) words: Vec<OsString>,
    /// Indices of the words that are inputs.
    pub(super) inputs: Vec<usize>,
    /// Indices of the words that are outputs.
    pub(super) outputs: Vec<usize>,
}

impl Line {
    pub(super) fn new(text: &str) -> Self {
        let mut line = Self::default();
        for (i, word) in text.split(' ').enumerate() {
            let name = if let Some(name) = word.strip_prefix('@') {
                line.inputs.push(i);
                name
            } else if let Some(name) = word.strip_prefix('>') {
                line.outputs.push(i);
                name
            } else {
                word
            };
            line.words.push(name.into());
        }
        line
    }

    pub(super) fn wrong(rng: &mut Rng) -> Self {
        Self::new(rng.pick(&WRONG))
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
        "m.obj",
        "all.scene",
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
