//! The words of settings for later faces: `surf texture frame round filter wrap border interp cull alpha shade gouraud
//! translate rotate scale missing`.

use texmap_math::frame::TextureFrame;
use texmap_math::glam::DVec3;
use texmap_raster::Cull;
use texmap_scene::Gouraud;
use texmap_uv::Round;

use super::args::Args;
use super::{Alpha, Command, Missing, Rate, Role, RoundShape, Shade, Surf, words};
use crate::IoError;

/// `None` for words of others.
pub(super) fn parse(args: &Args<'_>) -> Result<Option<Command>, IoError> {
    Ok(Some(match args.command {
        "surf" => surf(args)?,
        "texture" => texture(args)?,
        "frame" => frame(args)?,
        "round" => round(args)?,
        "filter" => {
            let name = args.single_word("1 method")?;
            Command::Filter(name.parse().map_err(|_| args.unknown(0, words::FILTERS))?)
        }
        "wrap" => {
            let count = args.len();
            args.within(1, 2, "1 or 2 modes (U [V])")?;
            let wrap = |i| {
                args.text(i)
                    .parse()
                    .map_err(|_| args.unknown(i, words::WRAPS))
            };
            Command::Wrap(wrap(0)?, wrap(count - 1)?)
        }
        "border" => Command::Border(args.unit_floats(0, "4 numbers (r g b a)")?),
        "interp" => {
            let name = args.single_word("1 method")?;
            Command::Interp(
                words::parse_interp(name).ok_or_else(|| args.unknown(0, words::INTERPS))?,
            )
        }
        "cull" => {
            let table = [
                ("none", Cull::None),
                ("back", Cull::Back),
                ("front", Cull::Front),
            ];
            Command::Cull(args.one_of(&table, "none, back, front")?)
        }
        "alpha" => alpha(args)?,
        "shade" => shade(args)?,
        "gouraud" => {
            let table = [
                ("screen", Gouraud::ScreenLinear),
                ("perspective", Gouraud::Perspective),
            ];
            Command::Gouraud(args.one_of(&table, "screen, perspective")?)
        }
        "translate" => Command::Translate(args.point()?),
        "rotate" => {
            args.exactly(4, "4 numbers (degrees, x y z of the axis)")?;
            let axis = args.numbers(1)?;
            args.check(1, axis != [0.0; 3], "an axis that is not zero")?;
            let [angle] = args.numbers(0)?;
            Command::Rotate { angle, axis }
        }
        "scale" => scale(args)?,
        "missing" => Command::Missing(args.one_of(
            &[("error", Missing::Error), ("warn", Missing::Warn)],
            "error, warn",
        )?),
        _ => return Ok(None),
    }))
}

fn surf(args: &Args<'_>) -> Result<Command, IoError> {
    args.exactly(7, "7 numbers (r g b ka kd ks ns)")?;
    let [ka, kd, ks, ns] = args.positive_floats(3)?;
    let color = args.floats(0)?;
    for (i, c) in color.iter().enumerate() {
        args.check(i, (0.0..=1.0).contains(c), "0 to 1")?;
    }
    Ok(Command::Surf(Surf {
        color,
        ka,
        kd,
        ks,
        ns,
    }))
}

fn texture(args: &Args<'_>) -> Result<Command, IoError> {
    let path = args.path()?;
    let none = path == "none" && !args.quoted(0);
    Ok(Command::Texture((!none).then_some(path)))
}

fn frame(args: &Args<'_>) -> Result<Command, IoError> {
    args.exactly(9, "9 numbers (O, U, V)")?;
    let (o, u, v) = (args.numbers(0)?, args.numbers(3)?, args.numbers(6)?);
    TextureFrame::new(DVec3::from(o), DVec3::from(u), DVec3::from(v)).map_err(|e| {
        IoError::DegenerateFrame {
            place: args.word_place(),
            problem: e.to_string(),
        }
    })?;
    Ok(Command::Frame { o, u, v })
}

fn round(args: &Args<'_>) -> Result<Command, IoError> {
    const ALLOWED: &str =
        "none; or sphere or cylinder with position, angles and size (9 numbers) [and repeat u v]";
    args.within(1, 12, ALLOWED)?;
    let shape = match (args.text(0), args.len()) {
        ("none", 1) => return Ok(Command::Round(None)),
        ("sphere", 10 | 12) => Round::Sphere,
        ("cylinder", 10 | 12) => Round::Cylinder,
        ("none" | "sphere" | "cylinder", _) => return Err(args.count_error(ALLOWED)),
        _ => return Err(args.unknown(0, ALLOWED)),
    };
    let (position, angles, size) = (args.numbers(1)?, args.numbers(4)?, args.numbers(7)?);
    let repeat = match args.len() {
        12 => args.numbers(10)?,
        _ => [1.0; 2],
    };
    for i in 7..args.len() {
        let [value] = args.numbers(i)?;
        args.check(i, value != 0.0, "a number that is not 0")?;
    }
    Ok(Command::Round(Some(RoundShape {
        shape,
        position,
        angles,
        size,
        repeat,
    })))
}

fn alpha(args: &Args<'_>) -> Result<Command, IoError> {
    const ALLOWED: &str = "auto, opaque, test [threshold], blend";
    args.within(1, 2, ALLOWED)?;
    let threshold = || {
        let [t] = args.floats(1)?;
        args.check(1, t > 0.0 && t <= 1.0, "a threshold above 0, up to 1")?;
        Ok(t)
    };
    Ok(Command::Alpha(match (args.text(0), args.len()) {
        ("auto", 1) => Alpha::Auto,
        ("opaque", 1) => Alpha::Opaque,
        ("blend", 1) => Alpha::Blend,
        ("test", 1) => Alpha::Test(None),
        ("test", _) => Alpha::Test(Some(threshold()?)),
        _ => return Err(args.unknown(0, ALLOWED)),
    }))
}

fn shade(args: &Args<'_>) -> Result<Command, IoError> {
    const ALLOWED: &str = "decal or modulate, and vertex or pixel; each at most once";
    args.within(1, 2, "1 or 2 words")?;
    let mut shade = Shade::default();
    for i in 0..args.len() {
        let unset = match args.text(i) {
            "decal" => shade.role.replace(Role::Decal).is_none(),
            "modulate" => shade.role.replace(Role::Modulate).is_none(),
            "vertex" => shade.rate.replace(Rate::Vertex).is_none(),
            "pixel" => shade.rate.replace(Rate::Pixel).is_none(),
            _ => false,
        };
        if !unset {
            return Err(args.unknown(i, ALLOWED));
        }
    }
    Ok(Command::Shade(shade))
}

fn scale(args: &Args<'_>) -> Result<Command, IoError> {
    let factors = if args.len() == 1 {
        [args.numbers::<1>(0)?[0]; 3]
    } else {
        args.exactly(3, "1 or 3 numbers")
            .and_then(|()| args.numbers(0))?
    };
    for (i, f) in factors.iter().enumerate() {
        args.check(i.min(args.len() - 1), *f != 0.0, "any number but 0")?;
    }
    Ok(Command::Scale(factors))
}

#[cfg(test)]
mod tests {
    use super::super::parse::assert_faults;

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("surf 2 0 0 1 1 1 5", "out-of-range", 6),
            ("surf 1 0 0 1 1 1 -5", "out-of-range", 18),
            ("scale 1 0 1", "out-of-range", 9),
            ("rotate 30 0 0 0", "out-of-range", 11),
            ("frame 0 0 0 1 0 0 2 0 0", "degenerate-frame", 1),
            ("round torus 0 0 0 0 0 0 1 1 1", "unknown-word", 7),
            ("round sphere 0 0 0 0 0 0 1 1", "argument-count", 1),
            ("round cylinder 0 0 0 0 0 0 1 0 1", "out-of-range", 30),
            ("round sphere 0 0 0 0 0 0 1 1 1 2 0", "out-of-range", 34),
            ("filter blurry", "unknown-word", 8),
            ("filter anisotropic:99", "unknown-word", 8),
            ("wrap repeat sideways", "unknown-word", 13),
            ("interp span:0", "unknown-word", 8),
            ("cull left", "unknown-word", 6),
            ("alpha test 2", "out-of-range", 12),
            ("alpha test 0", "out-of-range", 12),
            ("shade decal modulate", "unknown-word", 13),
            ("texture my wall.png", "argument-count", 12),
            ("texture", "argument-count", 1),
        ]);
    }
}
