//! The scene language: text to statements and back.
//!
//! The language of the MIT 6.837 (Fall 2001) course, lecture 18, and texmap's extensions in the
//! same style: one command a line, a word and its values; a line that begins with a number
//! continues the command above; `#` begins a comment. `docs/SCENE_FORMAT.md` has the tables.
//!
//! [`parse`] checks everything that one file can show by itself (words, counts, ranges, indices);
//! [`crate::load_scene`] then reads the files it names and makes the scene.

mod args;
mod classics;
mod commands;
mod effects;
mod parse;
mod print;
mod settings;
mod shapes;
mod token;
pub mod words;

use texmap_raster::{Cull, Interp};
use texmap_sample::{Filter, Wrap};
use texmap_scene::{ColorMode, Gouraud};
use texmap_uv::Round;

pub use classics::{Classic, SolidLine, SolidSource};
pub use commands::COMMANDS;
pub use effects::{
    Bias, CarveLine, Effect, EnvironmentLine, Formula, NormalMapLine, ProjectorLine, ReliefLine,
};
pub use parse::parse;
pub use print::print;
pub use shapes::{BoneLine, DisplaceLine, Shape, TerrainLine};

/// The statements of one file in their order.
#[derive(Debug, Clone, Default)]
pub struct SceneFile {
    /// Commands and where they stand.
    pub statements: Vec<Statement>,
}

impl SceneFile {
    /// The commands without their places; two files with equal commands are the same scene.
    pub fn commands(&self) -> impl Iterator<Item = &Command> {
        self.statements.iter().map(|s| &s.command)
    }
}

impl FromIterator<Command> for SceneFile {
    /// A file with each command on its own line.
    fn from_iter<I: IntoIterator<Item = Command>>(commands: I) -> Self {
        let statements = commands
            .into_iter()
            .zip(1..)
            .map(|(command, line)| Statement {
                command,
                line,
                column: 1,
            })
            .collect();
        Self { statements }
    }
}

/// A command and the place of its word.
#[derive(Debug, Clone)]
pub struct Statement {
    /// What it says.
    pub command: Command,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

/// Where a shape of `round` stands and how often the picture repeats on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundShape {
    /// The shape.
    pub shape: Round,
    /// Its middle.
    pub position: [f64; 3],
    /// Yaw, pitch and roll, degrees.
    pub angles: [f64; 3],
    /// Its width, height and depth; none is 0.
    pub size: [f64; 3],
    /// Pictures around and up; neither is 0.
    pub repeat: [f64; 2],
}

/// One command of the scene language. Lengths are world units, angles degrees, as in the file.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// `eye x y z`.
    Eye([f64; 3]),
    /// `look x y z`: a point, not a direction.
    Look([f64; 3]),
    /// `up x y z`.
    Up([f64; 3]),
    /// `fov degrees`, horizontal.
    Fov(f64),
    /// `near distance`.
    Near(f64),
    /// `far distance`, or `far infinite`.
    Far(f64),
    /// `background r g b [a]`.
    Background([f32; 4]),
    /// `color srgb` or `color raw`.
    Color(ColorMode),
    /// `la r g b`: ambient light.
    AmbientLight([f32; 3]),
    /// `ld r g b x y z`: light along a direction, from the light to the surface.
    DirectionalLight {
        /// Linear factors.
        color: [f32; 3],
        /// Not zero; any length.
        direction: [f32; 3],
    },
    /// `lp r g b x y z`: light at a point.
    PointLight {
        /// Linear factors.
        color: [f32; 3],
        /// World position.
        position: [f32; 3],
    },
    /// `surf r g b ka kd ks ns`: the surface of later faces.
    Surf(Surf),
    /// `v x y z`.
    Vertex([f64; 3]),
    /// `f i1 i2 ... in`.
    Face(Vec<u32>),
    /// `texture FILE`, or `texture none`.
    Texture(Option<String>),
    /// `tf i1 u1 v1 ... in un vn`.
    TexturedFace(Vec<TexturedCorner>),
    /// `frame Ox Oy Oz Ux Uy Uz Vx Vy Vz`.
    Frame {
        /// Where u = v = 0.
        o: [f64; 3],
        /// From O to u = 1.
        u: [f64; 3],
        /// From O to v = 1.
        v: [f64; 3],
    },
    /// `round sphere|cylinder x y z yaw pitch roll sx sy sz [u v]`, or `round none`.
    Round(Option<RoundShape>),
    /// `ff i1 i2 ... in`: a face textured by the frame or round shape above.
    FramedFace(Vec<u32>),
    /// `filter METHOD`.
    Filter(Filter),
    /// `wrap U [V]`.
    Wrap(Wrap, Wrap),
    /// `border r g b a`: the colour outside of `clamp-to-border`, sRGB and straight alpha.
    Border([f32; 4]),
    /// `interp METHOD`.
    Interp(Interp),
    /// `cull none|back|front`.
    Cull(Cull),
    /// `alpha auto|opaque|test [threshold]|blend`.
    Alpha(Alpha),
    /// `shade decal|modulate|vertex|pixel`, one or two of them.
    Shade(Shade),
    /// `gouraud screen|perspective`.
    Gouraud(Gouraud),
    /// `translate x y z`.
    Translate([f64; 3]),
    /// `rotate degrees x y z`: about an axis, counter-clockwise when the axis points at the viewer.
    Rotate {
        /// Degrees.
        angle: f64,
        /// Not zero; any length.
        axis: [f64; 3],
    },
    /// `scale s` or `scale x y z`; none is zero.
    Scale([f64; 3]),
    /// `push`: keeps all current settings.
    Push,
    /// `pop`: returns to the settings kept last.
    Pop,
    /// `missing error|warn`: what a missing map or material library is.
    Missing(Missing),
    /// `obj FILE`.
    Obj(String),
    /// `include FILE`.
    Include(String),
    /// A line about light: see [`Effect`].
    Effect(Effect),
    /// A line about solid textures, ramps, decals, words, skies and volumes: see [`Classic`].
    Classic(Classic),
    /// A line about shape: see [`Shape`].
    Shape(Shape),
}

/// `surf r g b ka kd ks ns`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surf {
    /// sRGB, 0 to 1.
    pub color: [f32; 3],
    /// Ambient factor.
    pub ka: f32,
    /// Diffuse factor.
    pub kd: f32,
    /// Specular factor.
    pub ks: f32,
    /// Phong exponent.
    pub ns: f32,
}

impl Default for Surf {
    /// The course loader's: `surf 0.5 0.5 0.5 1 1 1 5`.
    fn default() -> Self {
        Self {
            color: [0.5; 3],
            ka: 1.0,
            kd: 1.0,
            ks: 1.0,
            ns: 5.0,
        }
    }
}

/// One corner of a `tf`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TexturedCorner {
    /// Index of a `v` above, from 0.
    pub vertex: u32,
    /// Texture coordinates; v = 0 is the top row.
    pub uv: [f32; 2],
}

/// How texture alpha is used.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Alpha {
    /// Test for textures with alpha (above 0 for `nearest`, from 0.5 otherwise), opaque for the rest.
    #[default]
    Auto,
    /// Alpha is ignored.
    Opaque,
    /// Texels below the threshold are holes; `None` is the threshold of `Auto`.
    Test(Option<f32>),
    /// Mixed with what lies behind, in the order of the file.
    Blend,
}

/// What `shade` sets; a part that the line does not name stays as it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Shade {
    /// `decal` or `modulate`.
    pub role: Option<Role>,
    /// `vertex` or `pixel`.
    pub rate: Option<Rate>,
}

/// What a texel does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It is copied: no light.
    Decal,
    /// It is the colour of the surface, which is then lit.
    Modulate,
}

/// Where light is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rate {
    /// At vertices, and interpolated (Gouraud).
    Vertex,
    /// At every pixel.
    #[default]
    Pixel,
}

/// What a missing map or material library is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Missing {
    /// An error.
    #[default]
    Error,
    /// A warning; a magenta and black checker stands in for the map.
    Warn,
}
