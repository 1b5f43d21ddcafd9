//! Solid textures, ramps, labels, skies and volumes.

use super::Set::Fallible;
use super::Spec;
use super::light::LAYOUT;
use crate::scene::{labels, materials, volumes};
use crate::scene_file::grammar::Arg::{
    Either, File, Floats, Numbers, OneOf, Optional, Options, Text,
};
use crate::scene_file::grammar::{
    Check, any, direction, is_whole, length, not_negative, not_zero, octaves, unless,
};

const RECTANGLE: Check = |v, i| unless(i < 2 || v[i] != 0.0, "a number that is not 0");
/// Columns, rows and first character of a font.
const CELLS: Check = |v, i| {
    let least = if i == 2 { 0.0 } else { 1.0 };
    if !is_whole(v[i], least, 1_114_111.0) {
        return Some("a whole number; of cells at least 1");
    }
    unless(
        i != 1 || v[0] * v[1] <= 1_048_576.0,
        "at most 1048576 cells",
    )
};

/// Textures beyond pictures on faces.
pub(super) const SPECS: &[Spec] = &[
    Spec {
        word: "solid",
        args: &[Either(&[
            &[
                Either(&[&[OneOf(&["marble", "wood", "noise"])], &[File]]),
                Numbers("x y z", any),
                Numbers("sx sy sz", not_zero),
                Options(&[
                    &[OneOf(&["octaves"]), Numbers("N", octaves)],
                    &[OneOf(&["fold"]), Floats("X", any)],
                ]),
            ],
            &[OneOf(&["none"])],
        ])],
        default: "none; 4 octaves, fold 1 (marble), 0.2 (wood)",
        help: "setting: later faces without a covering texture take their colour from this procedural or three-dimensional texture. A FILE is a grid whose box has its middle at x y z and is sx sy sz large; a pattern has its origin at x y z and a unit of sx sy sz",
        set: Fallible(materials::solid),
    },
    Spec {
        word: "ramp",
        args: &[Either(&[&[File], &[OneOf(&["none"])]])],
        default: "none",
        help: "setting: the first channel of the solid, else of the texture, is looked up along the first row of this picture: heat colours, whose alpha shows as that of a texture does, but cuts nothing out. It is the transfer function of later volumes",
        set: Fallible(|b, line| {
            b.settings.materials.ramp = materials::ramp(b, line)?;
            Ok(())
        }),
    },
    Spec {
        word: "cel",
        args: &[Either(&[&[File], &[OneOf(&["none"])]])],
        default: "none",
        help: "setting: the light (its luminance, 0 to 1) is looked up along this picture: bands of cel shading. Highlights stay",
        set: Fallible(|b, line| {
            b.settings.materials.cel = materials::ramp(b, line)?;
            Ok(())
        }),
    },
    Spec {
        word: "decal",
        args: &[Either(&[
            &[File, Optional(&[Floats("u v width height", RECTANGLE)])],
            &[OneOf(&["none"])],
        ])],
        default: "none; 0 0 1 1",
        help: "setting: a label over the texture of later textured faces and models, as its alpha says; once, its upper left corner at u v",
        set: Fallible(materials::decal),
    },
    Spec {
        word: "font",
        args: &[Either(&[
            &[File, Numbers("columns rows first", CELLS)],
            &[OneOf(&["none"])],
        ])],
        default: "built in",
        help: "setting: an atlas of equal cells, one character each, from code point `first` on; its alpha is the letter; built in is JetBrains Mono with ASCII and Latin-1",
        set: Fallible(labels::font),
    },
    Spec {
        word: "text",
        args: &[
            Text(|_| None),
            Numbers("x y z", any),
            Numbers("rx ry rz", direction),
            Numbers("ux uy uz", direction),
        ],
        default: "",
        help: "writes words: x y z is the lower left corner of the first character, r its step to the next, u its height; built-in letters are upright and as wide as drawn where r is 0.6 of u",
        set: Fallible(labels::text),
    },
    Spec {
        word: "sky",
        args: &[Either(&[&[File, Optional(&[LAYOUT])], &[OneOf(&["none"])]])],
        default: "none",
        help: "the whole scene: a picture stretched over the frame behind everything, or an environment seen by direction",
        set: Fallible(volumes::sky),
    },
    Spec {
        word: "volume",
        args: &[
            File,
            Numbers("x y z", any),
            Numbers("sx sy sz", not_zero),
            Floats("density", not_negative),
            Options(&[&[OneOf(&["step"]), Floats("S", length)]]),
        ],
        default: "half a voxel",
        help: "adds a box of matter with its middle at x y z; a length L of values of 1 transmits exp(-density L) of the light behind",
        set: Fallible(volumes::volume),
    },
];
