//! Models, frames and shapes that place textures, and files within files.

use texmap_math::texture_frame::TextureFrame;

use super::Set::{Fallible, Nothing, Plain};
use super::Spec;
use crate::scene_file::grammar::Arg::{Corners, Either, File, Frame, Numbers, OneOf, Optional};
use crate::scene_file::grammar::{any, not_zero};

/// Models, frames, shapes and included files.
pub(super) const SPECS: &[Spec] = &[
    Spec {
        word: "obj",
        args: &[File],
        default: "",
        help: "adds a model under the current settings: `.ply`, `.stl`, else Wavefront OBJ",
        set: Fallible(|b, line| b.obj(line.name(), &line.location)),
    },
    Spec {
        word: "frame",
        args: &[Frame],
        default: "",
        help: "setting: places a texture in space: O is the corner u = v = 0, U leads to u = 1, V to v = 1",
        set: Plain(|b, line| {
            let [o, u, v] = [line.numbers(), line.numbers(), line.numbers()].map(Into::into);
            b.settings.frame = Some(TextureFrame { o, u, v }.transform(b.settings.transform));
            b.settings.round = None;
        }),
    },
    Spec {
        word: "ff",
        args: &[Corners],
        default: "",
        help: "adds a face whose coordinates come from the `frame` above: at every pixel u = A.W/C.W and v = B.W/C.W with A = V x O, B = O x U, C = U x V (Brackeen, *Developing Games in Java*, 2003, chapter 8)",
        set: Fallible(|b, line| b.framed_face(line)),
    },
    Spec {
        word: "uv-projection",
        args: &[Either(&[
            &[
                OneOf(&["sphere", "cylinder"]),
                Numbers("x y z", any),
                Numbers("yaw pitch roll", any),
                Numbers("sx sy sz", not_zero),
                Optional(&[Numbers("u v", not_zero)]),
            ],
            &[OneOf(&["none"])],
        ])],
        default: "",
        help: "setting: a shape around its middle x y z, turned by degrees, of width, height and depth sx sy sz, on which the texture repeats u times around and v times up (1 1). Later `ff` faces and `obj` models take their coordinates from it at every pixel",
        set: Fallible(|b, line| b.round(line)),
    },
    Spec {
        word: "include",
        args: &[File],
        default: "",
        help: "reads another scene file at this line",
        // The tree of files was read before; the builder passes through it.
        set: Nothing,
    },
];
