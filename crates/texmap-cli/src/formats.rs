//! The format of an output, by its ending, for all verbs.

use std::path::Path;

use texmap_io::{AnimationFormat, Lost, PictureFormat, PixelCode};
use texmap_sample::ColorSpace;
use texmap_scene::ColorMode;

use crate::failure::{Failure, say};

/// The one of the `known` endings that a name has; for standard output and devices the first. `flag` names the output.
pub(crate) fn ending<'e>(flag: &str, output: &Path, known: &[&'e str]) -> Result<&'e str, Failure> {
    let device = output == Path::new("-")
        || std::fs::metadata(output).is_ok_and(|m| !m.is_file() && !m.is_dir());
    let given = output.extension().and_then(|e| e.to_str());
    let found = known.iter().find(|known| match given {
        _ if device => true,
        Some(given) => given.eq_ignore_ascii_case(known),
        None => false,
    });
    found.copied().ok_or_else(|| {
        let what = match given {
            Some(given) => format!("cannot be written as .{given}"),
            None => "has no ending that says its format".to_owned(),
        };
        let list = match known {
            [rest @ .., last] if !rest.is_empty() => {
                format!(".{} or .{last}", rest.join(", ."))
            }
            _ => format!(".{}", known.concat()),
        };
        Failure::usage(
            format!("{flag} {}: {what}", output.display()),
            format!("end the name with {list}"),
        )
    })
}

/// The format of a picture of colours, which may be any format. The output is named by `flag`.
pub(crate) fn picture(flag: &str, output: &Path) -> Result<PictureFormat, Failure> {
    // `.jpeg` is `.jpg`.
    if let Some(format) = PictureFormat::of(output) {
        return Ok(format);
    }
    let endings = PictureFormat::ALL.map(PictureFormat::ending);
    ending(flag, output, &endings).map(|_| PictureFormat::Png)
}

/// Files of the pictures of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Output {
    /// One file each.
    Pictures(PictureFormat),
    /// One file for all.
    Animation(AnimationFormat),
}

/// The format of one picture or, where there are several, of an animation.
pub(crate) fn output(path: &Path, several: bool) -> Result<Output, Failure> {
    let ending = path.extension().and_then(|e| e.to_str());
    let animation = AnimationFormat::ALL
        .into_iter()
        .find(|f| ending.is_some_and(|e| e.eq_ignore_ascii_case(f.ending())));
    match animation {
        Some(format) if several => Ok(Output::Animation(format)),
        Some(format) => Err(Failure::usage(
            format!(
                "-o {}: a .{} is an animation, and this is one picture",
                path.display(),
                format.ending()
            ),
            "add --turntable N, or --path CAMERA.json --frames N, or end the name with .png",
        )),
        None => picture("-o", path).map(Output::Pictures),
    }
}

/// Pixel layout of a picture that is made of one with `bits` a channel.
pub(crate) fn pixel_code(
    format: PictureFormat,
    bits: u32,
    color: ColorMode,
    alpha: bool,
) -> PixelCode {
    let space = match color {
        ColorMode::Srgb => ColorSpace::Srgb,
        ColorMode::Raw => ColorSpace::Linear,
    };
    match format {
        PictureFormat::Png if bits == 16 => PixelCode::Png16(space),
        PictureFormat::Png => PixelCode::Png8(space),
        PictureFormat::Jpeg => PixelCode::Jpeg(space),
        PictureFormat::WebP => PixelCode::WebP(space),
        PictureFormat::Hdr => PixelCode::Hdr,
        PictureFormat::Exr if alpha => PixelCode::ExrAlpha,
        PictureFormat::Exr => PixelCode::Exr,
    }
}

/// Warns of pixels that the format of an output could not hold, and returns the warnings.
pub(crate) fn warn(output: &Path, format: PictureFormat, lost: Lost) -> Vec<String> {
    let name = format.ending().to_uppercase();
    let wider = match format {
        PictureFormat::Hdr | PictureFormat::Exr => ".exr",
        _ => ".exr or .hdr",
    };
    let mut warnings = Vec::new();
    let Lost {
        above,
        below,
        transparent,
    } = lost;
    for (count, what) in [
        (
            above,
            format!("brighter than {name} can hold and were clipped: write {wider}"),
        ),
        (
            below,
            format!("below 0, which {name} cannot hold, and became 0: write .exr"),
        ),
        (
            transparent,
            format!(
                "not opaque, and {name} has no alpha: they stand over black; write .exr or .png"
            ),
        ),
    ] {
        if count > 0 {
            let warning = format!("{}: {count} pixels are {what}", output.display());
            say(&format!("warning: {warning}\n"));
            warnings.push(warning);
        }
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_are_known_or_refused_with_those_that_are() {
        let known = ["png", "hdr", "exr"];
        let of = |name: &str| ending("-o", Path::new(name), &known);
        assert_eq!(of("out.EXR").unwrap(), "exr");
        assert_eq!(of("-").unwrap(), "png");
        for bad in ["x.jpg", "x", "png", "x.png.gz"] {
            let failure = of(bad).unwrap_err();
            assert_eq!(failure.exit as u8, 2, "{bad}");
            assert!(failure.what.contains(bad), "{}", failure.what);
            assert_eq!(failure.why, "end the name with .png, .hdr or .exr");
        }
        assert!(
            picture("-o", Path::new("a.JPEG")).is_ok()
                && picture("-o", Path::new("a.webp")).is_ok()
        );
        assert!(picture("-o", Path::new("a.bmp")).is_err());
        let spin = Path::new("spin.gif");
        assert_eq!(
            output(spin, true),
            Ok(Output::Animation(AnimationFormat::Gif))
        );
        assert!(output(spin, false).unwrap_err().why.contains("--turntable"));
        let one = ending("--heat", Path::new("a.jpg"), &["png"]).unwrap_err();
        assert_eq!(one.why, "end the name with .png");
        assert_eq!(one.what, "--heat a.jpg: cannot be written as .jpg");
    }
}
