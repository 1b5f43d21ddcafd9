//! The commands of the whole picture, and the settings of later faces.

use texmap_math::glam::DMat4;
use texmap_raster::Cull;
use texmap_sample::{Filter, Wrap};
use texmap_scene::{AlphaMode, Shading, TextureRole, VertexColorInterp};

use super::Set::{Nothing, Plain};
use super::Spec;
use crate::scene::settings::rotation;
use crate::scene_file::grammar::Arg::{Either, Floats, Method, Numbers, OneOf, Optional};
use crate::scene_file::grammar::{Check, any, axis, unit, unless};
use crate::scene_file::{Missing, words};

const DISTANCE: Check = |v, i| unless(v[i] > 0.0, "a distance above 0");

const NOT_ZERO: Check = |v, i| unless(v[i] != 0.0, "any number but 0");
const THRESHOLD: Check = |v, i| unless(v[i] > 0.0 && v[i] <= 1.0, "a threshold above 0, up to 1");

fn is_wrap(text: &str) -> bool {
    text.parse::<Wrap>().is_ok()
}

/// Near, far, background and colours.
pub(super) const PICTURE: &[Spec] = &[
    Spec {
        word: "near",
        args: &[Numbers("distance", DISTANCE)],
        default: "1e-4",
        help: "nothing nearer is drawn",
        set: Plain(|b, line| b.set_camera(line, |camera, line| camera.near = line.number())),
    },
    Spec {
        word: "far",
        args: &[Either(&[
            &[Numbers("distance", DISTANCE)],
            &[OneOf(&["infinite"])],
        ])],
        default: "infinite",
        help: "nothing farther is drawn",
        set: Plain(|b, line| {
            b.set_camera(line, |camera, line| {
                camera.far = match line.takes("infinite") {
                    true => f64::INFINITY,
                    false => line.number(),
                };
            });
        }),
    },
    Spec {
        word: "background",
        args: &[Floats("r g b", unit), Optional(&[Floats("a", unit)])],
        default: "0 0 0 1",
        help: "sRGB, 0 to 1; with a = 0 the picture is transparent there",
        set: Plain(|b, line| {
            let ([red, green, blue], alpha) = (line.floats(), line.optional_float());
            b.scene.background = [red, green, blue, alpha.unwrap_or(1.0)];
        }),
    },
    Spec {
        word: "color",
        args: &[OneOf(&["srgb", "raw"])],
        default: "srgb",
        help: "`raw` turns all colour conversion off: values are stored as computed, as in the lectures' programs. It holds for the whole scene, wherever the line stands",
        // It holds for lines above it too, so all files were searched for it before.
        set: Nothing,
    },
];

/// The settings of later faces.
pub(super) const SPECS: &[Spec] = &[
    Spec {
        word: "filter",
        args: &[Method(
            "method",
            || words::FILTERS.into(),
            |text| text.parse::<Filter>().is_ok(),
        )],
        default: "trilinear",
        help: "`nearest`, `bilinear`, `bicubic:catmull-rom`, `bicubic:mitchell`, `bicubic:b-spline`, `mip-nearest`, `bilinear-mip-nearest`, `trilinear`, `anisotropic:N` (2 to 16), `ewa:N` (1 to 16), `ewa:N:WIDTH` (0.25 to 2, 1 if left out: the width of the pixel's Gaussian), `summed-area` (the exact mean of the upright rectangle about a pixel; 32 bytes a texel)",
        set: Plain(|b, line| b.settings.filter = line.parsed()),
    },
    Spec {
        word: "wrap",
        args: &[
            Method("U", || words::WRAPS.into(), is_wrap),
            Optional(&[Method("V", || words::WRAPS.into(), is_wrap)]),
        ],
        default: "repeat",
        help: "`repeat`, `mirrored-repeat`, `clamp-to-edge`, `clamp-to-border`, `mirror-clamp-to-edge`; one word sets both axes",
        set: Plain(|b, line| {
            let u = line.parsed();
            let v = if line.left() > 0 { line.parsed() } else { u };
            b.settings.wrap = [u, v];
        }),
    },
    Spec {
        word: "border",
        args: &[Floats("r g b a", unit)],
        default: "0 0 0 0",
        help: "colour outside of `clamp-to-border`; sRGB and straight alpha, 0 to 1",
        set: Plain(|b, line| b.settings.border = line.floats()),
    },
    Spec {
        word: "interp",
        args: &[Method(
            "method",
            || words::INTERPS.into(),
            |text| words::parse_interp(text).is_some(),
        )],
        default: "perspective",
        help: "`perspective`, `affine`, `subdivided:N`, `span:N`, `within:TOLERANCE` (texels): the interpolation of coordinates over a triangle",
        set: Plain(|b, line| {
            b.settings.interp = words::parse_interp(line.name()).unwrap_or(b.settings.interp);
        }),
    },
    Spec {
        word: "cull",
        args: &[OneOf(&["none", "back", "front"])],
        default: "none",
        help: "the side of faces that is not drawn",
        set: Plain(|b, line| {
            b.settings.cull = match line.word() {
                Some("back") => Cull::Back,
                Some("front") => Cull::Front,
                _ => Cull::None,
            }
        }),
    },
    Spec {
        word: "alpha",
        args: &[Either(&[
            &[OneOf(&["auto", "opaque", "blend"])],
            &[OneOf(&["test"]), Optional(&[Floats("t", THRESHOLD)])],
        ])],
        default: "auto",
        help: "`auto`: tested if the texture has alpha, else opaque. `test` keeps alpha >= t (above 0, up to 1); without t, alpha > 0 for `nearest` and alpha >= 0.5 for filtered alpha. `blend` mixes in the order of the file",
        set: Plain(|b, line| {
            b.settings.alpha = match line.word() {
                Some("opaque") => Some(AlphaMode::Opaque),
                Some("blend") => Some(AlphaMode::Blend),
                // A threshold of 0 stands for the rule of the filter.
                Some("test") => Some(AlphaMode::Test(line.optional_float().unwrap_or(0.0))),
                _ => None,
            };
        }),
    },
    Spec {
        word: "shade",
        args: &[Either(&[
            &[
                OneOf(&["decal", "modulate"]),
                Optional(&[OneOf(&["vertex", "pixel"])]),
            ],
            &[
                OneOf(&["vertex", "pixel"]),
                Optional(&[OneOf(&["decal", "modulate"])]),
            ],
        ])],
        default: "pixel; `tf` and `ff` decal, `obj` modulate",
        help: "`decal` copies the texel; `modulate` multiplies the surface colour by it, then lights it. `vertex` lights at the vertices and interpolates (Gouraud), `pixel` at every pixel",
        set: Plain(|b, line| {
            while let Some(word) = line.word() {
                match word {
                    "decal" => b.settings.role = Some(TextureRole::Decal),
                    "modulate" => b.settings.role = Some(TextureRole::Modulate),
                    "vertex" => b.settings.shading = Shading::PerVertex,
                    _ => b.settings.shading = Shading::PerPixel,
                }
            }
        }),
    },
    Spec {
        word: "gouraud",
        args: &[OneOf(&["screen", "perspective"])],
        default: "screen",
        help: "the interpolation of the colours of `shade vertex` over a triangle: linear on the screen (as in the lectures, with seams at T-junctions) or on the surface",
        set: Plain(|b, line| {
            b.settings.gouraud = match line.takes("perspective") {
                true => VertexColorInterp::Perspective,
                false => VertexColorInterp::ScreenLinear,
            }
        }),
    },
    Spec {
        word: "missing",
        args: &[OneOf(&["error", "checker", "grey", "warn"])],
        default: "error",
        help: "the treatment of an absent map or material library: a magenta and black checker or grey replaces a map, with a warning (`warn` is `checker`)",
        set: Plain(|b, line| {
            let word = line.word().unwrap_or_default();
            let said = word.parse().unwrap_or(Missing::Checker);
            b.settings.missing = b.textures.missing.unwrap_or(said);
        }),
    },
    Spec {
        word: "translate",
        args: &[Numbers("x y z", any)],
        default: "",
        help: "moves later vertices, frames and models",
        set: Plain(|b, line| {
            b.settings.transform *= DMat4::from_translation(line.numbers().into());
        }),
    },
    Spec {
        word: "rotate",
        args: &[Numbers("degrees", any), Numbers("x y z", axis)],
        default: "",
        help: "turns them about an axis through the origin, counter-clockwise when the axis points at the viewer",
        set: Plain(|b, line| {
            b.settings.transform *= rotation(line.number(), line.numbers().into());
        }),
    },
    Spec {
        word: "scale",
        args: &[Either(&[
            &[Numbers("s", NOT_ZERO)],
            &[Numbers("x y z", NOT_ZERO)],
        ])],
        default: "",
        help: "scales them; no factor may be 0",
        set: Plain(|b, line| {
            let factors = match line.left() {
                1 => [line.number(); 3],
                _ => line.numbers(),
            };
            b.settings.transform *= DMat4::from_scale(factors.into());
        }),
    },
    Spec {
        word: "push",
        args: &[],
        default: "",
        help: "keeps all current settings, the transform among them",
        set: Plain(|b, _| b.kept.push(b.settings.clone())),
    },
    Spec {
        word: "pop",
        args: &[],
        default: "",
        help: "returns to the settings kept last; each `push` needs its `pop` in the same file",
        set: Plain(|b, _| {
            // The parser has matched each `pop` with a `push`.
            b.settings = b.kept.pop().unwrap_or_default();
        }),
    },
];
