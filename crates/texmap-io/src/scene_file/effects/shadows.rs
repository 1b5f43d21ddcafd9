//! The words of shadows that lights throw: `shadow`.

use super::Effect;
use crate::IoError;
use crate::scene_file::args::Args;
use crate::scene_file::print::{number, numbers, word};

/// The bias of a `shadow` line, with its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bias {
    /// The receiver's slope, and this constant in world units.
    Slope(f64),
    /// A constant in world units.
    Constant(f64),
    /// Along the normal, in texels.
    NormalOffset(f64),
}

pub(super) fn parse(args: &Args<'_>) -> Result<Effect, IoError> {
    const ALLOWED: &str =
        "[SIZE|auto] [taps K] [slope X|constant X|normal-offset X] [area x y z half]";
    let (mut size, mut taps, mut bias, mut area) = (None, 3, None, None);
    let mut i = 0;
    if args.len() > 0 && args.text(0) == "auto" {
        i = 1;
    } else if args.len() > 0 && args.text(0).starts_with(|c: char| c.is_ascii_digit()) {
        size = Some(texels(args, 0)?);
        i = 1;
    }
    while i < args.len() {
        let value = |least: f64| -> Result<f64, IoError> {
            let [x] = args.numbers(i + 1)?;
            args.check(i + 1, x >= least, "0 or more")?;
            Ok(x)
        };
        match args.text(i) {
            "taps" => {
                let x = value(1.0)?;
                let odd = x.fract() == 0.0 && x as u32 % 2 == 1 && x <= 15.0;
                args.check(i + 1, odd, "an odd number, 1 to 15")?;
                taps = x as u32;
            }
            "slope" => bias = Some(Bias::Slope(value(0.0)?)),
            "constant" => bias = Some(Bias::Constant(value(0.0)?)),
            "normal-offset" => bias = Some(Bias::NormalOffset(value(0.0)?)),
            "area" => {
                let [x, y, z, half] = args.numbers(i + 1)?;
                args.check(i + 4, half > 0.0, "more than 0")?;
                area = Some(([x, y, z], half));
                i += 3;
            }
            _ => return Err(args.unknown(i, ALLOWED)),
        }
        i += 2;
    }
    Ok(Effect::Shadow {
        size,
        taps,
        bias,
        area,
    })
}

pub(super) fn texels(args: &Args<'_>, i: usize) -> Result<u32, IoError> {
    let [x] = args.numbers::<1>(i)?;
    let fits = x.fract() == 0.0 && (1.0..=16_384.0).contains(&x);
    args.check(i, fits, "a whole number of texels, 1 to 16384")?;
    Ok(x as u32)
}

/// The values after the word.
pub(super) fn print(
    out: &mut String,
    size: Option<u32>,
    taps: u32,
    bias: Option<Bias>,
    area: Option<([f64; 3], f64)>,
) {
    match size {
        Some(size) => number(out, f64::from(size)),
        None => word(out, "auto"),
    }
    word(out, "taps");
    number(out, f64::from(taps));
    match bias {
        Some(Bias::Slope(x)) => named(out, "slope", x),
        Some(Bias::Constant(x)) => named(out, "constant", x),
        Some(Bias::NormalOffset(x)) => named(out, "normal-offset", x),
        None => {}
    }
    if let Some((middle, half)) = area {
        word(out, "area");
        numbers(out, &middle);
        number(out, half);
    }
}

pub(super) fn named(out: &mut String, name: &str, x: f64) {
    word(out, name);
    number(out, x);
}

#[cfg(test)]
mod tests {
    use crate::scene_file::Command;
    use crate::scene_file::parse::{assert_faults, assert_reads_back};

    #[test]
    fn every_shadow_reads_back() {
        assert_reads_back(
            |c| matches!(c, Command::Effect(_)),
            &[
                "shadow auto taps 3\n",
                "shadow 512 taps 5 slope 0.001\n",
                "shadow 512 taps 1 constant 0.01\n",
                "shadow auto taps 1 normal-offset 1.5\n",
                "shadow auto taps 1 normal-offset 1.5 area 0 1 -2 3.5\n",
            ],
        );
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("shadow 0", "out-of-range", 8),
            ("shadow 512 taps 4", "out-of-range", 17),
            ("shadow 512 soft 4", "unknown-word", 12),
            ("shadow auto taps", "not-a-number", 1),
            ("shadow auto area 0 0 0 0", "out-of-range", 24),
            ("shadow area 0 0 x 1", "not-a-number", 17),
        ]);
    }
}
