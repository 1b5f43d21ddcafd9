//! Lights, shadows, projectors, environments, and effects of light on surfaces.

use texmap_light::{EnvironmentLayout, Light, SpecularModel};

use super::Set::{Fallible, Plain};
use super::Spec;
use crate::scene::effects::ReliefSetting;
use crate::scene::settings::emitted;
use crate::scene::{effects, environments, labels, lights};
use crate::scene_file::grammar::Arg::{
    Either, File, Floats, Method, Name, Numbers, OneOf, Optional, Options, Text,
};
use crate::scene_file::grammar::{
    Check, any, direction, field_of_view, is_whole, not_negative, not_zero, octaves, texels, unless,
};
use crate::textures::Content;

/// The layout of an environment in a picture.
pub(super) const LAYOUT: crate::scene_file::grammar::Arg = Method(
    "LAYOUT",
    || {
        EnvironmentLayout::ALL
            .map(EnvironmentLayout::name)
            .join(", ")
    },
    |text| text.parse::<EnvironmentLayout>().is_ok(),
);

/// Half angles of a spot light, degrees.
const CONE: Check = |v, i| match i {
    0 => unless((0.0..=180.0).contains(&v[0]), "0 to 180 degrees"),
    _ => unless(
        v[1] >= v[0] && v[1] <= 180.0,
        "an angle of at least the inner one, up to 180 degrees",
    ),
};
const TAPS: Check = |v, i| {
    unless(
        is_whole(v[i], 1.0, 15.0) && v[i] % 2.0 == 1.0,
        "an odd number, 1 to 15",
    )
};
const AREA: Check = |v, i| unless(i < 3 || v[i] > 0.0, "more than 0");
const SHARE: Check = |v, i| unless((0.0..=1.0).contains(&v[i]), "a share of 0 to 1");
const SOFTNESS: Check = |v, i| unless((0.0..=0.5).contains(&v[i]), "0 to 0.5");
const EXPONENT: Check = |v, i| unless(v[i] >= 0.0, "an exponent of 0 or more");
/// Two corners of a box, the least first.
const CORNERS: Check = |v, i| unless(i < 3 || v[i] > v[i - 3], "more than the first corner has");
const WAVES: Check = |v, i| unless(is_whole(v[i], 1.0, 65_535.0), "a whole number, 1 to 65535");

/// Lighting and its maps.
pub(super) const SPECS: &[Spec] = &[
    Spec {
        word: "ls",
        args: &[
            Floats("r g b", not_negative),
            Floats("x y z", any),
            Floats("dx dy dz", direction),
            Floats("inner outer", CONE),
        ],
        default: "none",
        help: "adds a spot light at x y z along dx dy dz; full up to `inner` degrees from this axis, nothing beyond `outer`",
        set: Plain(|b, line| {
            let (color, position, direction) = (line.floats(), line.floats(), line.floats());
            let [inner, outer] = line.floats().map(f32::to_radians);
            let light = Light::spot(color, position, direction, inner, outer);
            b.scene.lights.push(light);
        }),
    },
    Spec {
        word: "name",
        args: &[Name(|name| {
            let valid = texmap_scene::is_light_name(name);
            unless(valid, "letters, digits, - and _, not digits alone")
        })],
        default: "none",
        help: "the light, the run of faces or the model above, whichever stands last, is called that (letters, digits, `-`, `_`): `--aov shadow:NAME` finds the light, `texmap bake --object NAME` the mesh. The parts of a model are NAME.PART",
        set: Fallible(lights::name),
    },
    Spec {
        word: "shadow",
        args: &[
            Optional(&[Either(&[&[Numbers("SIZE", texels)], &[OneOf(&["auto"])]])]),
            Options(&[
                &[OneOf(&["taps"]), Numbers("K", TAPS)],
                &[OneOf(&["slope"]), Numbers("X", not_negative)],
                &[OneOf(&["constant"]), Numbers("X", not_negative)],
                &[OneOf(&["normal-offset"]), Numbers("X", not_negative)],
                &[OneOf(&["area"]), Numbers("x y z half", AREA)],
            ]),
        ],
        default: "none; auto, 3 taps, planes",
        help: "the light above (`ld`, `lp`, `ls`) casts shadows from a map of SIZE texels a side; `auto` gives a pixel about a texel. K x K comparisons (odd, 1 to 15) are averaged",
        set: Fallible(lights::shadow),
    },
    Spec {
        word: "shadowless",
        args: &[OneOf(&["yes", "no"])],
        default: "no",
        help: "setting: later faces and models cast no shadow",
        set: Plain(|b, line| b.settings.effects.shadowless = line.takes("yes")),
    },
    Spec {
        word: "projector",
        args: &[
            File,
            OneOf(&["light", "paint"]),
            Numbers("x y z", any),
            Numbers("lx ly lz", any),
            Numbers("ux uy uz", any),
            Numbers("degrees", field_of_view),
            Options(&[
                &[OneOf(&["black", "clamp", "repeat"])],
                &[OneOf(&["soft"]), Floats("S", SOFTNESS)],
                &[OneOf(&["color"]), Floats("r g b", not_negative)],
                &[OneOf(&["shadow"]), Numbers("N", texels)],
            ]),
        ],
        default: "black, soft 0, color 1 1 1",
        help: "adds a projector at x y z that looks at lx ly lz with ux uy uz up, with this horizontal field of view and the aspect of its picture",
        set: Fallible(lights::projector),
    },
    Spec {
        word: "highlight",
        args: &[OneOf(&["phong", "blinn"])],
        default: "phong",
        help: "setting: the falloff of highlights, `(V.R)^ns` (Phong) or `(N.H)^ns` (Blinn)",
        set: Plain(|b, line| {
            b.settings.effects.highlight = match line.takes("blinn") {
                true => SpecularModel::Blinn,
                false => SpecularModel::Phong,
            }
        }),
    },
    Spec {
        word: "env",
        args: &[Either(&[
            &[
                File,
                LAYOUT,
                Floats("share", SHARE),
                Options(&[
                    &[OneOf(&["mips"])],
                    &[OneOf(&["box"]), Floats("x0 y0 z0 x1 y1 z1", CORNERS)],
                    &[OneOf(&["at"]), Floats("x y z", any)],
                    &[OneOf(&["map"]), File],
                ]),
            ],
            &[OneOf(&["none"])],
        ])],
        default: "none, without mips, infinitely far, at the middle of the box",
        help: "setting: surfaces reflect this share of an environment; PNG and JPEG are sRGB, HDR and EXR linear light, below 0 too. With `mips` a pixel that reflects many texels reads their mean. `box`: the environment shows the walls of this box as they are seen from the point `at`, and mirrors away from it show them where they are. `map`: the red channel of a picture multiplies the share",
        set: Fallible(environments::reflection),
    },
    Spec {
        word: "specmap",
        args: &[Either(&[
            &[File, LAYOUT, Floats("exponent", EXPONENT)],
            &[OneOf(&["none"])],
        ])],
        default: "none",
        help: "setting: highlights come from the area lights in this environment, gathered with the exponent into as many texels as its lobe needs (10 sqrt(exponent) a side) and multiplied by ks; per vertex with `shade vertex`",
        set: Fallible(environments::specular_map),
    },
    Spec {
        word: "lightmap",
        args: &[Either(&[
            &[File, Optional(&[Floats("scale", not_negative)])],
            &[OneOf(&["none"])],
        ])],
        default: "none",
        help: "setting: baked light stands in for the lights of the scene (not for projectors): colour = surface x (kd scale texel). `texmap bake` makes it; PNG and JPEG are sRGB (with `--color raw` too) and end at 1, HDR and EXR are linear light",
        set: Fallible(|b, line| {
            b.settings.effects.light_map = match line.takes("none") {
                true => None,
                false => {
                    let texture = b.load(line, Content::Light)?;
                    Some((texture, line.optional_float().unwrap_or(1.0)))
                }
            };
            Ok(())
        }),
    },
    Spec {
        word: "lightmapuv",
        args: &[Either(&[&[File], &[OneOf(&["none"])]])],
        default: "none",
        help: "setting: an OBJ of the same faces in the same order whose `vt` are the second coordinates of later models, for `lightmap`",
        set: Plain(|b, line| {
            b.settings.effects.lightmap_uv = match line.takes("none") {
                true => None,
                false => Some((b.beside(line), line.location.clone())),
            }
        }),
    },
    Spec {
        word: "emission",
        args: &[Either(&[
            &[Floats("r g b", not_negative), Optional(&[File])],
            &[OneOf(&["none"])],
        ])],
        default: "none",
        help: "setting: surfaces give off this light themselves, times the texels of a map; sRGB values up to 1, linear factors above. It is added to what they receive, whatever `shade` says, and lights nothing else; faces that copy their texel (`tf` and `ff` without `shade`, billboards) do not show it",
        set: Fallible(|b, line| {
            b.settings.effects.emission = match line.takes("none") {
                true => None,
                false => {
                    let color = emitted(line.floats(), b.scene.color);
                    let map = (line.left() > 0).then(|| b.load(line, Content::Color));
                    Some((color, map.transpose()?))
                }
            };
            Ok(())
        }),
    },
    Spec {
        word: "bump",
        args: &[Either(&[
            &[File, Floats("height", any)],
            &[OneOf(&["none"])],
        ])],
        default: "none",
        help: "setting: a height field; `height` is that of white over black in the units of the model",
        set: Fallible(|b, line| {
            b.set_relief(line, |b, line| {
                Ok(ReliefSetting::Bump(
                    b.load(line, Content::Data)?,
                    line.float(),
                ))
            })
        }),
    },
    Spec {
        word: "offsetmap",
        args: &[Either(&[
            &[
                File,
                Floats("slope", any),
                Optional(&[OneOf(&["up", "down"])]),
            ],
            &[OneOf(&["none"])],
        ])],
        default: "up",
        help: "setting: the two slopes of a height field, red along u and green along v, half is level; `slope` is the change of height over the whole picture where a channel is 1",
        set: Fallible(|b, line| {
            b.set_relief(line, |b, line| {
                let (texture, slope) = (b.load(line, Content::Data)?, line.float());
                Ok(ReliefSetting::Offsets(
                    texture,
                    slope,
                    effects::green(line.word()),
                ))
            })
        }),
    },
    Spec {
        word: "procedural-bump",
        args: &[Either(&[
            &[
                OneOf(&["waves", "noise", "marble", "wood"]),
                Floats("height", any),
                Numbers("x y z", any),
                Numbers("sx sy sz", not_zero),
                Options(&[
                    &[OneOf(&["around"]), Numbers("N", WAVES)],
                    &[OneOf(&["octaves"]), Numbers("N", octaves)],
                    &[OneOf(&["fold"]), Floats("X", any)],
                ]),
            ],
            &[OneOf(&["none"])],
        ])],
        default: "none; 12 around, 4 octaves, fold 0 (waves), 1 (marble), 0.2 (wood)",
        help: "setting: bumps by a formula of the position, with its origin at x y z and a unit of sx sy sz. `waves` run in cylindrical space: N around the y axis and one a unit along it. No coordinates are needed",
        set: Fallible(|b, line| b.set_relief(line, effects::carved)),
    },
    Spec {
        word: "emboss",
        args: &[Either(&[
            &[
                Text(|words| unless(!words.trim().is_empty(), "words that are not blank")),
                Floats("height", any),
            ],
            &[OneOf(&["none"])],
        ])],
        default: "none",
        help: "setting: words of the current `font` as a height field, once over all of the coordinates; a negative height engraves them",
        set: Fallible(|b, line| b.set_relief(line, labels::emboss)),
    },
    Spec {
        word: "normalmap",
        args: &[Either(&[
            &[
                File,
                Options(&[
                    &[OneOf(&["tangent", "object"])],
                    &[OneOf(&["up", "down"])],
                    &[OneOf(&["xyz", "xy"])],
                ]),
            ],
            &[OneOf(&["none"])],
        ])],
        default: "tangent up xyz",
        help: "setting: normals as colours; `up`: green points up the picture (OpenGL, glTF), `down` down (Direct3D); `xy`: blue is not read",
        set: Fallible(|b, line| b.set_relief(line, effects::normal_map)),
    },
    Spec {
        word: "horizon",
        args: &[OneOf(&["clamp", "open"])],
        default: "clamp",
        help: "setting: normals that normal detail turns away from the eye are brought back to the horizon, or keep the light of the side that faces away",
        set: Plain(|b, line| b.settings.effects.horizon_open = line.takes("open")),
    },
];
