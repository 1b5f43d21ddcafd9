//! Animated pictures: GIF and APNG, one frame after the other.

use std::io::{self, Write};
use std::path::Path;

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, RgbaImage};

use crate::{IoError, atomic};

/// A format of animated pictures, chosen by the ending of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnimationFormat {
    /// 256 colours a frame, and pixels that are there or not.
    Gif,
    /// All colours and alpha.
    Apng,
}

impl AnimationFormat {
    /// Every format.
    pub const ALL: [Self; 2] = [Self::Gif, Self::Apng];

    /// The ending of its names, without a dot.
    #[must_use]
    pub fn ending(self) -> &'static str {
        match self {
            Self::Gif => "gif",
            Self::Apng => "apng",
        }
    }
}

/// Frames of an animation: RGBA bytes (straight alpha, sRGB, rows from top to bottom), all of one size.
#[derive(Clone, Copy, Debug)]
pub struct Animation<'a> {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// In their order.
    pub frames: &'a [Vec<u8>],
    /// Frames a second, 1/655 at least. GIF counts hundredths of a second, and viewers slow down frames of less than two: 50 at most.
    pub rate: f64,
}

/// Writes an animation that repeats without end, whole or not at all.
///
/// # Errors
/// [`IoError::Write`], also when there is no frame, a frame has not `4 * width * height` bytes, or `rate` is below 1/655.
pub fn write_animation(
    path: &Path,
    format: AnimationFormat,
    animation: &Animation<'_>,
) -> Result<(), IoError> {
    let Animation {
        width,
        height,
        frames,
        rate,
    } = *animation;
    atomic::write(path, |out| {
        let bytes = 4 * u64::from(width) * u64::from(height);
        let whole = |frame: &Vec<u8>| bytes > 0 && frame.len() as u64 == bytes;
        // Both formats count a delay in 16 bits.
        let timed = rate >= 1.0 / 655.0 && rate.is_finite();
        if frames.is_empty() || !frames.iter().all(whole) || !timed {
            let problem = format!(
                "{} frames of {width} x {height} pixels, {rate} a second",
                frames.len()
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
        match format {
            AnimationFormat::Gif => gif(out, animation),
            AnimationFormat::Apng => apng(out, animation),
        }
    })
}

fn gif(out: &mut dyn Write, animation: &Animation<'_>) -> io::Result<()> {
    // Ten is the codec's own speed: colours are counted over a tenth of the pixels.
    let mut encoder = GifEncoder::new_with_speed(out, 10);
    encoder
        .set_repeat(Repeat::Infinite)
        .map_err(io::Error::other)?;
    // The format holds hundredths of a second; below two of them viewers choose their own.
    let rate = animation.rate.min(50.0);
    let end = |number: u32| (100.0 * f64::from(number) / rate).round() as u64;
    for (frame, number) in animation.frames.iter().zip(0..) {
        let picture = RgbaImage::from_raw(animation.width, animation.height, frame.clone())
            .ok_or_else(|| io::Error::other("a frame of the wrong size"))?;
        // Delays differ by one where the rate divides no 100: frames end at their times.
        let hundredths = end(number + 1) - end(number);
        let delay = Delay::from_numer_denom_ms(10 * hundredths as u32, 1);
        let frame = Frame::from_parts(picture, 0, 0, delay);
        encoder.encode_frame(frame).map_err(io::Error::other)?;
    }
    Ok(())
}

fn apng(out: &mut dyn Write, animation: &Animation<'_>) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, animation.width, animation.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Adaptive);
    let count = u32::try_from(animation.frames.len()).map_err(io::Error::other)?;
    encoder.set_animated(count, 0)?;
    let (numerator, denominator) = delay(animation.rate);
    encoder.set_frame_delay(numerator, denominator)?;
    let mut writer = encoder.write_header()?;
    for frame in animation.frames {
        writer.write_image_data(frame)?;
    }
    Ok(writer.finish()?)
}

/// The fraction of a second of 16-bit numbers that is nearest to a frame's.
fn delay(rate: f64) -> (u16, u16) {
    let mut nearest = (1, 1);
    let mut least = f64::INFINITY;
    for numerator in 1..=u16::MAX {
        let denominator = (rate * f64::from(numerator)).round();
        if denominator > f64::from(u16::MAX) {
            break;
        }
        let off = (denominator / (rate * f64::from(numerator)) - 1.0).abs();
        if denominator >= 1.0 && off < least {
            (nearest, least) = ((numerator, denominator as u16), off);
        }
    }
    match least.is_finite() {
        true => nearest,
        false => (1, u16::MAX),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::AnimationDecoder;
    use image::codecs::gif::GifDecoder;
    use image::codecs::png::PngDecoder;
    use std::io::Cursor;

    fn frames() -> Vec<Vec<u8>> {
        let frame = |i: u8| {
            (0..6 * 4)
                .flat_map(|p| [if p == i { 255 } else { 0 }, 40 * i, 9, 255])
                .collect()
        };
        (0..3).map(frame).collect()
    }

    #[test]
    fn frames_come_back_with_their_times() {
        let dir = tempfile::tempdir().unwrap();
        let frames = frames();
        let animation = Animation {
            width: 6,
            height: 4,
            frames: &frames,
            rate: 25.0,
        };
        for format in AnimationFormat::ALL {
            let path = dir.path().join(format!("a.{}", format.ending()));
            write_animation(&path, format, &animation).unwrap();
            let bytes = Cursor::new(std::fs::read(&path).unwrap());
            let decoded = match format {
                AnimationFormat::Gif => GifDecoder::new(bytes)
                    .unwrap()
                    .into_frames()
                    .collect_frames(),
                AnimationFormat::Apng => PngDecoder::new(bytes)
                    .unwrap()
                    .apng()
                    .unwrap()
                    .into_frames()
                    .collect_frames(),
            }
            .unwrap();
            assert_eq!(decoded.len(), 3);
            for (frame, wanted) in decoded.iter().zip(&frames) {
                let (numerator, denominator) = frame.delay().numer_denom_ms();
                assert_eq!(numerator, 40 * denominator);
                assert_eq!(frame.buffer().as_raw(), wanted, "few colours are all kept");
            }
        }
    }

    #[test]
    fn frames_end_at_their_times_at_any_rate() {
        let dir = tempfile::tempdir().unwrap();
        let frames = vec![vec![255; 4]; 60];
        for (rate, milliseconds) in [
            (30.0, 2000),
            (15.0, 4000),
            (24.0, 2500),
            (50.0, 1200),
            (60.0, 1200),
        ] {
            let path = dir.path().join("a.gif");
            let animation = Animation {
                width: 1,
                height: 1,
                frames: &frames,
                rate,
            };
            write_animation(&path, AnimationFormat::Gif, &animation).unwrap();
            let bytes = Cursor::new(std::fs::read(&path).unwrap());
            let decoded = GifDecoder::new(bytes).unwrap().into_frames();
            let delays = decoded.map(|frame| frame.unwrap().delay().numer_denom_ms().0);
            assert_eq!(delays.sum::<u32>(), milliseconds, "{rate}");
        }
        for (rate, fraction) in [
            (25.0, (1, 25)),
            (29.97, (100, 2997)),
            (0.01, (100, 1)),
            (1000.0, (1, 1000)),
            (1e9, (1, u16::MAX)),
        ] {
            assert_eq!(delay(rate), fraction);
        }
        let (numerator, denominator) = delay(1.0 / 655.0);
        assert_eq!(numerator, 655 * denominator);
    }

    #[test]
    fn wrong_sizes_and_rates_leave_no_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.gif");
        let frames = frames();
        for (width, frames, rate) in [
            (5, &frames[..], 25.0),
            (6, &[], 25.0),
            (6, &frames[..], 0.0),
            (6, &frames[..], 0.001),
        ] {
            let animation = Animation {
                width,
                height: 4,
                frames,
                rate,
            };
            let error = write_animation(&path, AnimationFormat::Gif, &animation).unwrap_err();
            assert_eq!(error.code(), "write-failed");
            assert!(!path.exists());
        }
    }
}
