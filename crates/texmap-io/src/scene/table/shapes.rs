//! Displacement, terrain, billboards and bones.

use super::Set::Fallible;
use super::Spec;
use crate::scene::shapes;
use crate::scene_file::grammar::Arg::{Either, File, Floats, Numbers, OneOf, Options};
use crate::scene_file::grammar::{Check, any, axis, count, length, number_from_0, unless};

const GROUND: Check = |v, i| unless(i == 1 || v[i] > 0.0, "a width and a depth above 0");
const CARD: Check = |v, i| unless(v[i] > 0.0, "a width and a height above 0");
const WIDTH: Check = |v, i| unless(v[i] > 0.0, "a width above 0");

/// Shapes that move, bend or turn.
pub(super) const SPECS: &[Spec] = &[
    Spec {
        word: "displace",
        args: &[Either(&[
            &[
                File,
                Floats("height", any),
                Options(&[
                    &[OneOf(&["middle"]), Floats("M", any)],
                    &[OneOf(&["texels"]), Floats("N", length)],
                    &[OneOf(&["pixels"]), Floats("N", length)],
                    &[OneOf(&["triangles"]), Numbers("MAX", count)],
                ]),
            ],
            &[OneOf(&["none"])],
        ])],
        default: "none; middle 0, pixels 2, triangles 4000000",
        help: "setting: later `tf` faces and models are moved by a height map: by `height` (units of the model) times the value (0 to 1) less M, along their normals",
        set: Fallible(shapes::displace),
    },
    Spec {
        word: "terrain",
        args: &[
            File,
            Numbers("x y z", any),
            Floats("width height depth", GROUND),
            Options(&[&[OneOf(&["step"]), Numbers("N", count)]]),
        ],
        default: "step 1",
        help: "adds a height field about x y z, a vertex for every N-th texel; the picture's top is at -z. It takes the current texture, the same ground seen from above",
        set: Fallible(shapes::terrain),
    },
    Spec {
        word: "billboard",
        args: &[
            Numbers("x y z", any),
            Numbers("width height", CARD),
            Options(&[&[OneOf(&["axis"]), Numbers("x y z", axis)]]),
        ],
        default: "",
        help: "adds the current texture as a card about x y z that faces the camera: parallel to the picture, or turning about an axis. What its alpha says is cut out",
        set: Fallible(shapes::billboard),
    },
    Spec {
        word: "bone",
        args: &[
            Numbers("x y z", any),
            Numbers("x y z", any),
            Options(&[
                &[OneOf(&["parent"]), Numbers("N", number_from_0)],
                &[
                    OneOf(&["turn"]),
                    Numbers("degrees", any),
                    Numbers("x y z", axis),
                ],
            ]),
        ],
        default: "",
        help: "adds a bone from one point to another: it turns about its first point and takes along what follows it. N counts the bones of the scene from 0",
        set: Fallible(shapes::bone),
    },
    Spec {
        word: "skin",
        args: &[Either(&[
            &[OneOf(&["rigid"])],
            &[OneOf(&["smooth"]), Numbers("WIDTH", WIDTH)],
            &[OneOf(&["none"])],
        ])],
        default: "none",
        help: "setting: later faces and models follow their nearest bones, alone, or mixed within a band of WIDTH about each joint",
        set: Fallible(shapes::skin),
    },
];
