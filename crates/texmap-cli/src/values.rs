//! Values of flags: sizes, points, colours. Each refusal lists the accepted values.

use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::str::FromStr;
use texmap_scene::SceneError;

use clap::ValueEnum as _;
use texmap_io::scene_file::words;
use texmap_math::Level;
use texmap_raster::Interp;
use texmap_render::{Aov, UnknownAov};
use texmap_sample::{Filter, Wrap};
use texmap_scene::{ColorMode, Scene, is_light_name};

use crate::failure::Failure;

/// `1920x1080` or `1920,1080`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Resolution {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Largest width and height of a picture.
pub(crate) const MAX_SIDE: u32 = 16_384;

impl FromStr for Resolution {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |s: &str| {
            s.trim()
                .parse::<u32>()
                .ok()
                .filter(|n| (1..=MAX_SIDE).contains(n))
        };
        text.split_once(['x', 'X', ','])
            .and_then(|(w, h)| {
                Some(Self {
                    width: side(w)?,
                    height: side(h)?,
                })
            })
            .ok_or_else(|| {
                format!("expected WIDTHxHEIGHT, each 1 to {MAX_SIDE}, such as 1920x1080")
            })
    }
}

/// `depth`, `shadow:0`, or `shadow:NAME` of a light that has a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct AovArg {
    /// The name as written, which is part of the array's file name.
    pub(crate) name: String,
    /// The buffer; `None` for the shadow of a named light, whose index only the scene tells.
    known: Option<Aov>,
}

impl AovArg {
    /// The buffer of this scene that the name stands for.
    pub(crate) fn of(&self, scene: &Scene) -> Result<Aov, SceneError> {
        let light = self.name.strip_prefix(SHADOW).unwrap_or_default();
        self.known.map_or_else(|| Aov::shadow_of(scene, light), Ok)
    }

    /// Values per pixel.
    pub(crate) fn channels(&self) -> usize {
        self.known.unwrap_or(Aov::Shadow(0)).channels()
    }

    pub(crate) fn is_shadow(&self) -> bool {
        self.name.starts_with(SHADOW)
    }
}

const SHADOW: &str = "shadow:";

impl FromStr for AovArg {
    type Err = UnknownAov;

    fn from_str(text: &str) -> Result<Self, UnknownAov> {
        let name = text.to_owned();
        let light = text.strip_prefix(SHADOW);
        match text.parse() {
            Err(_) if light.is_some_and(is_light_name) => Ok(Self { name, known: None }),
            Err(unknown) => Err(unknown),
            Ok(aov) => Ok(Self {
                name,
                known: Some(aov),
            }),
        }
    }
}

/// `I/N`: one of N parts of about the same size, I counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    pub(crate) index: u32,
    pub(crate) count: u32,
}

impl Part {
    /// The things of the part, if there are so many in all: consecutive ones, and all parts give each once.
    pub(crate) fn of(self, all: u64) -> Range<u64> {
        let border = |i: u32| (u128::from(all) * u128::from(i) / u128::from(self.count)) as u64;
        border(self.index - 1)..border(self.index)
    }
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(index, count)| {
            Some(Self {
                index: index.trim().parse().ok()?,
                count: count.trim().parse().ok()?,
            })
        });
        match numbers {
            Some(part) if (1..=part.count).contains(&part.index) => Ok(part),
            _ => Err("expected I/N with I from 1 to N, as in 3/8".to_owned()),
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// `0-99,200`: numbers from 0, ranges with both ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Ranges(pub(crate) Vec<RangeInclusive<u64>>);

impl Ranges {
    pub(crate) fn contains(&self, number: u64) -> bool {
        self.0.iter().any(|range| range.contains(&number))
    }

    /// Ranges of ascending numbers.
    pub(crate) fn of(numbers: impl IntoIterator<Item = u64>) -> Self {
        let mut ranges: Vec<RangeInclusive<u64>> = Vec::new();
        for number in numbers {
            match ranges.last_mut() {
                Some(last) if last.end() + 1 == number => *last = *last.start()..=number,
                _ => ranges.push(number..=number),
            }
        }
        Self(ranges)
    }
}

impl FromStr for Ranges {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let range = |part: &str| {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            let range = first.trim().parse().ok()?..=last.trim().parse().ok()?;
            (range.start() <= range.end()).then_some(range)
        };
        let ranges: Option<Vec<_>> = text.split(',').map(range).collect();
        ranges
            .map(Self)
            .ok_or_else(|| "expected numbers and ranges from 0, as in 0-99,200".to_owned())
    }
}

impl fmt::Display for Ranges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, range) in self.0.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            match range.start() == range.end() {
                true => write!(f, "{comma}{}", range.start())?,
                false => write!(f, "{comma}{}-{}", range.start(), range.end())?,
            }
        }
        Ok(())
    }
}

/// `x,y,z`, finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Triple(pub(crate) [f64; 3]);

impl FromStr for Triple {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let values = numbers(text)?;
        <[f64; 3]>::try_from(values)
            .map(Self)
            .map_err(|v| format!("expected three numbers x,y,z, got {}", v.len()))
    }
}

/// Horizontal field of view in degrees, between 0 and 180.
pub(crate) fn fov(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|d| *d > 0.0 && *d < 180.0)
        .ok_or_else(|| "expected degrees between 0 and 180 (horizontal)".to_owned())
}

/// A finite number of seconds.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|s| s.is_finite())
        .ok_or_else(|| "expected seconds, such as 1.5".to_owned())
}

/// `#rrggbb`, `#rrggbbaa`, `r,g,b`, `r,g,b,a` (0 to 1), `transparent` or `env`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Background {
    /// sRGB and alpha.
    Color([f32; 4]),
    /// The light from all around.
    Env,
}

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str =
            "expected #rrggbb, #rrggbbaa, r,g,b or r,g,b,a (0 to 1), transparent or env";
        match text {
            "transparent" => return Ok(Self::Color([0.0; 4])),
            "env" => return Ok(Self::Env),
            _ => {}
        }
        if let Some(hex) = text.strip_prefix('#') {
            if !matches!(hex.len(), 6 | 8) || !hex.bytes().all(|b| b.is_ascii_hexdigit()) {
                return Err(EXPECTED.to_owned());
            }
            let byte = |i: usize| {
                u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).map_or(1.0, |b| f32::from(b) / 255.0)
            };
            return Ok(Self::Color([
                byte(0),
                byte(1),
                byte(2),
                if hex.len() == 8 { byte(3) } else { 1.0 },
            ]));
        }
        let values = numbers(text).map_err(|_| EXPECTED.to_owned())?;
        if !matches!(values.len(), 3 | 4) || values.iter().any(|v| !(0.0..=1.0).contains(v)) {
            return Err(EXPECTED.to_owned());
        }
        let part = |i: usize| values.get(i).map_or(1.0, |v| *v as f32);
        Ok(Self::Color([part(0), part(1), part(2), part(3)]))
    }
}

/// An instruction set by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum LevelName {
    /// The best one of this machine.
    Auto,
    Avx512,
    Avx2,
    #[value(name = "sse4.2")]
    Sse42,
    Sse2,
    /// No SIMD.
    Fallback,
}

impl LevelName {
    /// The level, if this machine and build have it.
    pub(crate) fn level(self) -> Result<Level, Failure> {
        let best = Level::new();
        let found = match self {
            Self::Auto => Some(best),
            Self::Fallback => fallback(),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx512 => best.as_avx512().map(Level::Avx512),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx2 => best.as_avx2().map(Level::Avx2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Sse42 => best.as_sse4_2().map(Level::Sse4_2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Sse2 => best.as_sse2().map(Level::Sse2),
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            _ => None,
        };
        found.ok_or_else(|| {
            let name = self.to_possible_value();
            let name = name.as_ref().map_or("", |value| value.get_name());
            Failure::usage(
                match self {
                    Self::Fallback => "this program is built without `--level fallback`".to_owned(),
                    _ => format!("this CPU does not support `--level {name}`"),
                },
                match self {
                    Self::Fallback => {
                        "build with `--features force-fallback`, or use another level"
                    }
                    Self::Avx512 => {
                        "it needs the AVX-512 of Ice Lake or Zen 4; `auto` gives the same picture"
                    }
                    _ => "`auto` gives the same picture",
                },
            )
        })
    }
}

#[cfg(feature = "force-fallback")]
fn fallback() -> Option<Level> {
    Some(Level::fallback())
}

#[cfg(not(feature = "force-fallback"))]
fn fallback() -> Option<Level> {
    Some(Level::baseline()).filter(|level| level.is_fallback())
}

/// The name of a level, as `--level` takes it.
pub(crate) fn level_name(level: Level) -> &'static str {
    match level {
        level if level.is_fallback() => "fallback",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Avx512(_) => "avx512",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Avx2(_) => "avx2",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Sse4_2(_) => "sse4.2",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Sse2(_) => "sse2",
        _ => "baseline",
    }
}

/// An interpolation by name.
pub(crate) fn interp(text: &str) -> Result<Interp, String> {
    words::parse_interp(text).ok_or_else(|| format!("expected one of {}", words::INTERPS))
}

/// A filter by name.
pub(crate) fn filter(text: &str) -> Result<Filter, String> {
    text.parse()
        .map_err(|_| format!("expected one of {}", words::FILTERS))
}

/// A wrap mode by name.
pub(crate) fn wrap(text: &str) -> Result<Wrap, String> {
    text.parse()
        .map_err(|_| format!("expected one of {}", words::WRAPS))
}

/// 8 or 16.
pub(crate) fn bits(text: &str) -> Result<u32, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("expected 8 or 16".to_owned()),
    }
}

/// 1 or 4.
pub(crate) fn msaa(text: &str) -> Result<u32, String> {
    match text {
        "1" => Ok(1),
        "4" => Ok(4),
        _ => Err("expected 1 or 4".to_owned()),
    }
}

/// `srgb` or `raw`.
pub(crate) fn color(text: &str) -> Result<ColorMode, String> {
    match text {
        "srgb" => Ok(ColorMode::Srgb),
        "raw" => Ok(ColorMode::Raw),
        _ => Err("expected srgb or raw".to_owned()),
    }
}

/// Comma-separated finite numbers.
pub(crate) fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',')
        .map(|s| {
            s.trim()
                .parse::<f64>()
                .ok()
                .filter(|n| n.is_finite())
                .ok_or_else(|| format!("`{}` is not a finite number", s.trim()))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_give_everything_once() {
        for (all, count) in [(10, 3), (2, 8), (0, 4), (1000, 7)] {
            let mut next = 0;
            for index in 1..=count {
                let range = Part { index, count }.of(all);
                assert_eq!(range.start, next);
                next = range.end;
            }
            assert_eq!(next, all);
        }
        for bad in ["", "0/3", "4/3", "1", "1/0", "a/b", "-1/2"] {
            assert!(bad.parse::<Part>().is_err(), "{bad}");
        }
    }

    #[test]
    fn ranges_are_read_and_written() {
        let ranges: Ranges = "0-99,200".parse().unwrap();
        assert!(ranges.contains(99) && ranges.contains(200) && !ranges.contains(100));
        assert_eq!(ranges.to_string(), "0-99,200");
        assert_eq!(Ranges::of([1, 2, 3, 7, 9, 10]).to_string(), "1-3,7,9-10");
        for bad in ["", "3-1", "a", "1,,2", "-1"] {
            assert!(bad.parse::<Ranges>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_resolution_takes_both_spellings_and_refuses_the_rest() {
        let hd = Resolution {
            width: 1920,
            height: 1080,
        };
        assert_eq!("1920x1080".parse(), Ok(hd));
        assert_eq!("1920,1080".parse(), Ok(hd));
        for bad in [
            "", "1920", "0x4", "4x0", "16385x4", "-4x4", "4x4x4", "axb", "1e3x4",
        ] {
            assert!(bad.parse::<Resolution>().is_err(), "{bad} was taken");
        }
    }

    #[test]
    fn points_and_angles_are_finite() {
        assert_eq!("-1, 2.5,3e1".parse(), Ok(Triple([-1.0, 2.5, 30.0])));
        for bad in ["1,2", "1,2,3,4", "1,2,nan", "inf,0,0", ""] {
            assert!(bad.parse::<Triple>().is_err(), "{bad} was taken");
        }
        assert_eq!(fov("60"), Ok(60.0));
        for bad in ["0", "180", "-5", "nan", "x"] {
            assert!(fov(bad).is_err(), "{bad} was taken");
        }
    }

    #[test]
    fn a_background_is_hex_parts_or_transparent() {
        assert_eq!(
            "#ff0080".parse(),
            Ok(Background::Color([1.0, 0.0, 128.0 / 255.0, 1.0]))
        );
        assert_eq!("#00000000".parse(), Ok(Background::Color([0.0; 4])));
        assert_eq!("transparent".parse(), Ok(Background::Color([0.0; 4])));
        assert_eq!("env".parse(), Ok(Background::Env));
        assert_eq!(
            "0,0.5,1".parse(),
            Ok(Background::Color([0.0, 0.5, 1.0, 1.0]))
        );
        for bad in [
            "#fff",
            "#ggggggg",
            "#éé00",
            "1,2,3",
            "0,0",
            "red",
            "0,0,0,0,0",
        ] {
            assert!(bad.parse::<Background>().is_err(), "{bad} was taken");
        }
    }
}
