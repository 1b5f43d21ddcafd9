//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;

/// The arguments of the program.
#[derive(Debug, PartialEq)]
pub(crate) struct Arguments {
    pub(crate) file: PathBuf,
    pub(crate) size: (u32, u32),
    pub(crate) frames: Option<u32>,
    pub(crate) exit: bool,
}

impl Arguments {
    /// `None` asks for help.
    pub(crate) fn read(mut words: impl Iterator<Item = OsString>) -> Result<Option<Self>, String> {
        let mut file = None;
        let mut read = Self {
            file: PathBuf::new(),
            size: (960, 720),
            frames: None,
            exit: false,
        };
        while let Some(word) = words.next() {
            let mut value = || {
                words
                    .next()
                    .and_then(|w| w.into_string().ok())
                    .unwrap_or_default()
            };
            match word.to_str() {
                Some("-h" | "--help") => return Ok(None),
                Some("--exit") => read.exit = true,
                Some("--frames") => {
                    let frames = value().parse().ok().filter(|n| (1..=1_000_000).contains(n));
                    read.frames = Some(frames.ok_or("--frames: expected a number from 1 on")?);
                }
                Some("--size") => {
                    read.size = size(&value())
                        .ok_or("--size: expected WxH in pixels, 16 to 8192, as in 960x720")?
                }
                Some(flag) if flag.starts_with("--") => {
                    return Err(format!("unknown flag {flag}; --help lists them"));
                }
                _ => file = Some(PathBuf::from(word)),
            }
        }
        read.file = file.ok_or("name a scene or a model; --help tells more")?;
        if read.exit && read.frames.is_none() {
            return Err("--exit ends after the frames of --frames N: give it, too".into());
        }
        Ok(Some(read))
    }
}

fn size(text: &str) -> Option<(u32, u32)> {
    let (width, height) = text.split_once('x')?;
    let side = |text: &str| text.parse().ok().filter(|n| (16..=8192).contains(n));
    Some((side(width)?, side(height)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_and_bad_ones_told() {
        let read = |line: &str| Arguments::read(line.split_whitespace().map(OsString::from));
        let good = read("a.obj --size 320x200 --frames 3 --exit")
            .unwrap()
            .unwrap();
        assert_eq!(
            (good.size, good.frames, good.exit),
            ((320, 200), Some(3), true)
        );
        assert_eq!(read("--help"), Ok(None));
        for bad in [
            "",
            "a.obj --size 3",
            "a.obj --frames 0",
            "a.obj --exit",
            "a.obj --fast",
        ] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
