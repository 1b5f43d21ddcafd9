//! The commands of the course: camera, lights, vertices and faces.

use texmap_light::{Light, PhongMaterial};

use super::Set::{Fallible, Plain};
use super::Spec;
use crate::scene_file::grammar::Arg::{
    Corners, Either, File, Floats, Numbers, OneOf, TexturedCorners,
};
use crate::scene_file::grammar::{any, direction, field_of_view, not_negative, unit};

/// The commands of the course.
pub(super) const SPECS: &[Spec] = &[
    Spec {
        word: "eye",
        args: &[Numbers("x y z", any)],
        default: "0 0 -10",
        help: "the position of the eye",
        set: Plain(|b, line| b.set_camera(line, |camera, line| camera.eye = line.numbers().into())),
    },
    Spec {
        word: "look",
        args: &[Numbers("x y z", any)],
        default: "0 0 0",
        help: "the point that the camera looks at (not a direction)",
        set: Plain(|b, line| {
            b.set_camera(line, |camera, line| camera.look = line.numbers().into());
        }),
    },
    Spec {
        word: "up",
        args: &[Numbers("x y z", direction)],
        default: "0 1 0",
        help: "the up direction",
        set: Plain(|b, line| b.set_camera(line, |camera, line| camera.up = line.numbers().into())),
    },
    Spec {
        word: "fov",
        args: &[Numbers("degrees", field_of_view)],
        default: "30",
        help: "horizontal field of view, more than 0 and less than 180",
        set: Plain(|b, line| {
            b.set_camera(line, |camera, line| {
                camera.fov_x = line.number().to_radians();
            });
        }),
    },
    Spec {
        word: "la",
        args: &[Floats("r g b", not_negative)],
        default: "none",
        help: "adds ambient light; linear factors, 0 or more",
        set: Plain(|b, line| {
            let color = line.floats();
            b.scene.lights.push(Light::Ambient { color });
        }),
    },
    Spec {
        word: "ld",
        args: &[Floats("r g b", not_negative), Floats("x y z", direction)],
        default: "none",
        help: "adds directional light; x y z points **from the light to the surface**, any length",
        set: Plain(|b, line| {
            let (color, direction) = (line.floats(), line.floats());
            b.scene.lights.push(Light::Directional { color, direction });
        }),
    },
    Spec {
        word: "lp",
        args: &[Floats("r g b", not_negative), Floats("x y z", any)],
        default: "none",
        help: "adds a point light at x y z",
        set: Plain(|b, line| {
            let (color, position) = (line.floats(), line.floats());
            b.scene.lights.push(Light::Point { color, position });
        }),
    },
    Spec {
        word: "surf",
        args: &[Floats("r g b", unit), Floats("ka kd ks ns", not_negative)],
        default: "0.5 0.5 0.5 1 1 1 5",
        help: "setting: surface of later faces; r g b are sRGB, 0 to 1; ns is the Phong exponent",
        set: Plain(|b, line| {
            let (color, [ka, kd, ks, ns]) = (line.floats(), line.floats());
            b.settings.surf = Some(PhongMaterial {
                color,
                ka,
                kd,
                ks,
                ns,
            });
        }),
    },
    Spec {
        word: "v",
        args: &[Numbers("x y z", any)],
        default: "",
        help: "adds a vertex",
        set: Fallible(|b, line| b.vertex(line)),
    },
    Spec {
        word: "f",
        args: &[Corners],
        default: "",
        help: "adds a lit face of n >= 3 corners",
        set: Plain(|b, line| b.face(line)),
    },
    Spec {
        word: "texture",
        args: &[Either(&[&[File], &[OneOf(&["none"])]])],
        default: "none",
        help: "setting: the texture of later `tf`, `ff` and `obj` (PNG, JPEG, WebP, GIF, BMP, TGA, TIFF, QOI, HDR or EXR)",
        set: Fallible(|b, line| b.texture(line)),
    },
    Spec {
        word: "tf",
        args: &[TexturedCorners],
        default: "",
        help: "adds a textured face of n >= 3 corners; u = 0 is the left edge of the picture, **v = 0 its top row**",
        set: Fallible(|b, line| b.textured_face(line)),
    },
];
