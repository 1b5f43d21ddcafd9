//! Values of MTL statements.

use super::super::source::finite;
use crate::error::shortened;
use crate::{IoError, SourceLocation};

/// A map and the options before its name.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::obj) struct Map {
    pub(in crate::obj) location: SourceLocation,
    pub(in crate::obj) name: String,
    /// `-s u v`.
    pub(in crate::obj) scale: [f32; 2],
    /// `-o u v`.
    pub(in crate::obj) offset: [f32; 2],
    /// `-clamp on`.
    pub(in crate::obj) clamp: bool,
    /// `-bm`: the height of a bump or displacement.
    pub(in crate::obj) height: Option<f32>,
}

/// A number of 0 to 1, cut to it.
pub(super) fn share(
    location: SourceLocation,
    command: &'static str,
    rest: &str,
    warnings: &mut Vec<String>,
) -> Result<f32, IoError> {
    let number = one(location.clone(), command, rest)?;
    in_range(number >= 0.0, location.clone(), command, rest, "0 to 1")?;
    if number > 1.0 {
        warnings.push(format!(
            "{location}: `{command} {}` is above 1 and cut to it",
            shortened(rest)
        ));
    }
    Ok(number.min(1.0))
}

/// A colour of 0 to 1, cut to it.
pub(super) fn color(
    location: SourceLocation,
    command: &'static str,
    rest: &str,
    warnings: &mut Vec<String>,
) -> Result<Option<[f32; 3]>, IoError> {
    let Some(rgb) = rgb(&location, command, rest, warnings)? else {
        return Ok(None);
    };
    if rgb.iter().any(|c| *c > 1.0) {
        warnings.push(format!(
            "{location}: `{command} {}` is above 1 and cut to it",
            shortened(rest)
        ));
    }
    Ok(Some(rgb.map(|c| c.min(1.0))))
}

/// A colour of 0 or more; `None`, with a warning, for the forms that are not supported.
pub(super) fn rgb(
    location: &SourceLocation,
    command: &'static str,
    rest: &str,
    warnings: &mut Vec<String>,
) -> Result<Option<[f32; 3]>, IoError> {
    let words: Vec<_> = rest
        .split_whitespace()
        .take_while(|w| !w.starts_with('#'))
        .collect();
    if matches!(words.first(), Some(&("spectral" | "xyz"))) {
        warnings.push(format!(
            "{location}: `{command} {}` is not supported and left out",
            words[0]
        ));
        return Ok(None);
    }
    let mut numbers = Vec::new();
    for word in &words {
        numbers.push(finite(|| location.clone(), command, word)?);
    }
    let rgb = match numbers[..] {
        [grey] => [grey; 3],
        [r, g, b] => [r, g, b],
        _ => return Err(count(location.clone(), command, "1 or 3 numbers")),
    };
    in_range(
        rgb.iter().all(|c| *c >= 0.0),
        location.clone(),
        command,
        rest,
        "0 to 1",
    )?;
    Ok(Some(rgb))
}

/// `-option values ... file name`; the name may hold blanks.
pub(super) fn map(
    location: SourceLocation,
    command: &'static str,
    text: &str,
    warnings: &mut Vec<String>,
) -> Result<Map, IoError> {
    let mut map = Map {
        location,
        name: String::new(),
        scale: [1.0; 2],
        offset: [0.0; 2],
        clamp: false,
        height: None,
    };
    let mut rest = text;
    while let Some(option) = rest
        .split_whitespace()
        .next()
        .filter(|w| w.starts_with('-'))
    {
        let (least, most) = match option {
            "-s" | "-o" | "-t" => (1, 3),
            "-mm" => (2, 2),
            "-clamp" | "-blendu" | "-blendv" | "-boost" | "-cc" | "-imfchan" | "-texres"
            | "-type" | "-bm" => (1, 1),
            // A file name may begin with a dash.
            _ => break,
        };
        rest = rest[option.len()..].trim_start();
        let mut values = Vec::new();
        while values.len() < most {
            let value = rest.split_whitespace().next().unwrap_or("");
            if values.len() >= least && value.parse::<f32>().is_err() {
                break;
            }
            values.push(value);
            rest = rest[value.len()..].trim_start();
        }
        let number = |i: usize, default: f32| match values.get(i) {
            Some(text) => finite(|| map.location.clone(), command, text),
            None => Ok(default),
        };
        match option {
            "-s" => {
                map.scale = [number(0, 1.0)?, number(1, 1.0)?];
                let allowed = "scales of -s that are not zero";
                in_range(
                    !map.scale.contains(&0.0),
                    map.location.clone(),
                    command,
                    text,
                    allowed,
                )?;
            }
            "-o" => map.offset = [number(0, 0.0)?, number(1, 0.0)?],
            "-clamp" => {
                in_range(
                    matches!(values[0], "on" | "off"),
                    map.location.clone(),
                    command,
                    text,
                    "-clamp on, -clamp off",
                )?;
                map.clamp = values[0] == "on";
            }
            "-bm" if matches!(command, "map_Bump" | "disp") => map.height = Some(number(0, 1.0)?),
            other => warnings.push(format!(
                "{}: `{command}`: the option {} is not supported",
                map.location,
                shortened(other)
            )),
        }
    }
    if rest.is_empty() {
        return Err(count(map.location, command, "a file name"));
    }
    map.name = rest.into();
    Ok(map)
}

pub(super) fn one(
    location: SourceLocation,
    command: &'static str,
    rest: &str,
) -> Result<f32, IoError> {
    let mut words = rest.split_whitespace().take_while(|w| !w.starts_with('#'));
    match (words.next(), words.next()) {
        (Some(word), None) => finite(|| location.clone(), command, word),
        _ => Err(count(location, command, "1 number")),
    }
}

pub(super) fn in_range(
    valid: bool,
    location: SourceLocation,
    command: &'static str,
    text: &str,
    allowed: &'static str,
) -> Result<(), IoError> {
    if valid {
        Ok(())
    } else {
        Err(IoError::OutOfRange {
            location,
            command,
            text: text.into(),
            allowed,
        })
    }
}

pub(super) fn count(
    location: SourceLocation,
    command: &'static str,
    expected: &'static str,
) -> IoError {
    IoError::ArgumentCount {
        location,
        command,
        expected: expected.into(),
        found: 0,
    }
}
