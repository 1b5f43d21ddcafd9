//! Statements back to text, one command a line, numbers in their shortest exact form.

use std::fmt::Write;

use texmap_scene::{ColorMode, Gouraud};

use super::classics;
use super::effects;
use super::shapes;
use super::{Alpha, Command, Missing, Rate, Role, SceneFile, words};

/// The file as text. Comments and spacing are gone; `print(parse(x))` is a fixed point, and its
/// commands are those of `x`, number for number.
pub fn print(file: &SceneFile) -> String {
    let mut text = String::new();
    for command in file.commands() {
        line(&mut text, command);
        text.push('\n');
    }
    text
}

fn line(out: &mut String, command: &Command) {
    out.push_str(command.word());
    match command {
        Command::Eye(p)
        | Command::Look(p)
        | Command::Up(p)
        | Command::Vertex(p)
        | Command::Translate(p)
        | Command::Scale(p) => numbers(out, p),
        Command::Fov(x) | Command::Near(x) => number(out, *x),
        Command::Far(x) if x.is_infinite() => out.push_str(" infinite"),
        Command::Far(x) => number(out, *x),
        Command::Background(c) | Command::Border(c) => floats(out, c),
        Command::Color(ColorMode::Srgb) => out.push_str(" srgb"),
        Command::Color(ColorMode::Raw) => out.push_str(" raw"),
        Command::AmbientLight(color) => floats(out, color),
        Command::DirectionalLight {
            color,
            direction: v,
        }
        | Command::PointLight { color, position: v } => {
            floats(out, color);
            floats(out, v);
        }
        Command::Surf(s) => {
            floats(out, &s.color);
            floats(out, &[s.ka, s.kd, s.ks, s.ns]);
        }
        Command::Face(corners) | Command::FramedFace(corners) => {
            for i in corners {
                // Writing to a String cannot fail.
                let _ = write!(out, " {i}");
            }
        }
        Command::TexturedFace(corners) => {
            for corner in corners {
                let _ = write!(out, " {}", corner.vertex);
                floats(out, &corner.uv);
            }
        }
        Command::Texture(None) => out.push_str(" none"),
        Command::Texture(Some(name)) => texture_name(out, name),
        Command::Obj(name) | Command::Include(name) => path(out, name),
        Command::Frame { o, u, v } => {
            numbers(out, o);
            numbers(out, u);
            numbers(out, v);
        }
        Command::Round(None) => word(out, "none"),
        Command::Round(Some(round)) => {
            let name = match round.shape {
                texmap_uv::Round::Cylinder => "cylinder",
                texmap_uv::Round::Sphere => "sphere",
            };
            word(out, name);
            numbers(out, &round.position);
            numbers(out, &round.angles);
            numbers(out, &round.size);
            if round.repeat != [1.0; 2] {
                numbers(out, &round.repeat);
            }
        }
        Command::Filter(filter) => word(out, &words::filter(*filter).unwrap_or_default()),
        Command::Wrap(u, v) if u == v => word(out, words::wrap(*u)),
        Command::Wrap(u, v) => {
            word(out, words::wrap(*u));
            word(out, words::wrap(*v));
        }
        Command::Interp(interp) => word(out, &words::interp(*interp)),
        Command::Cull(cull) => word(out, words::cull(*cull)),
        Command::Alpha(alpha) => match alpha {
            Alpha::Auto => word(out, "auto"),
            Alpha::Opaque => word(out, "opaque"),
            Alpha::Blend => word(out, "blend"),
            Alpha::Test(threshold) => {
                word(out, "test");
                floats(out, threshold.as_slice());
            }
        },
        Command::Shade(shade) => {
            match shade.role {
                Some(Role::Decal) => word(out, "decal"),
                Some(Role::Modulate) => word(out, "modulate"),
                None => {}
            }
            match shade.rate {
                Some(Rate::Vertex) => word(out, "vertex"),
                Some(Rate::Pixel) => word(out, "pixel"),
                None => {}
            }
        }
        Command::Gouraud(Gouraud::ScreenLinear) => word(out, "screen"),
        Command::Gouraud(Gouraud::Perspective) => word(out, "perspective"),
        Command::Rotate { angle, axis } => {
            number(out, *angle);
            numbers(out, axis);
        }
        Command::Missing(Missing::Error) => word(out, "error"),
        Command::Missing(Missing::Warn) => word(out, "warn"),
        Command::Effect(effect) => effects::print(out, effect),
        Command::Classic(classic) => classics::print(out, classic),
        Command::Shape(shape) => shapes::print(out, shape),
        Command::Push | Command::Pop => {}
    }
}

pub(super) fn word(out: &mut String, word: &str) {
    out.push(' ');
    out.push_str(word);
}

/// A file called `none` is not the word `none`.
pub(super) fn texture_name(out: &mut String, name: &str) {
    if name == "none" {
        out.push_str(" \"none\"");
    } else {
        path(out, name);
    }
}

pub(super) fn path(out: &mut String, name: &str) {
    let plain = !name.is_empty() && !name.contains(|c: char| c.is_whitespace() || c == '#');
    let _ = if plain {
        write!(out, " {name}")
    } else {
        write!(out, " \"{name}\"")
    };
}

pub(super) fn numbers(out: &mut String, numbers: &[f64]) {
    for &x in numbers {
        number(out, x);
    }
}

pub(super) fn number(out: &mut String, x: f64) {
    let magnitude = x.abs();
    let _ = if magnitude != 0.0 && !(1e-5..1e16).contains(&magnitude) {
        write!(out, " {x:e}")
    } else {
        write!(out, " {x}")
    };
}

pub(super) fn floats(out: &mut String, numbers: &[f32]) {
    for &x in numbers {
        let magnitude = x.abs();
        let _ = if magnitude != 0.0 && !(1e-5..1e16).contains(&magnitude) {
            write!(out, " {x:e}")
        } else {
            write!(out, " {x}")
        };
    }
}
