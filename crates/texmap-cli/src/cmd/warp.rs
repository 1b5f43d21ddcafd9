//! `texmap warp`: an image drawn through an affine map or a homography.

mod forward;

use std::io::{self, Write};
use std::path::PathBuf;
use std::str::FromStr;
use std::thread;

use clap::Args;
use texmap_io::{Lost, PictureFormat, PixelCode, image_io, write_pixels};
use texmap_math::glam::{DMat3, DVec2, DVec3};
use texmap_math::{Homography, Level, deterministic_f64};
use texmap_sample::{ColorSpace, EdgeMode, Filter, Resample, Texture2d};
use texmap_scene::ColorMode;

use crate::cmd::written::{Written, one_stdout};
use crate::failure::{self, Exit, Failure, say};
use crate::formats;
use crate::levels::ask_to_prepare;
use crate::output::{Destination, Stage, distinct};
use crate::values::{self, Resolution};

/// Draw an image through a homography or an affine map, filtered and with antialiased edges.
///
/// Positions are pixels of (0,0) at the upper left corner; pixel centres lie at one half. Give four
/// points (--from, --to), a matrix, or any of --scale, --rotate, --translate (applied in this order
/// around the middle of the image). A 16-bit PNG becomes one of 16 bits. HDR and EXR are linear light, read and written as floats.
/// The alpha of a pixel that an edge of the image cuts is the fraction of its square that the image covers.
#[derive(Args, Debug)]
#[command(
    after_help = "Rectify a facade:   texmap warp photo.jpg --from 120,80 690,140 700,610 100,580 --size 600x500 -o facade.png\n\
                  Turn by 45 degrees: texmap warp in.png --rotate 45 -o out.png\n\
                  Texel to pixel:     texmap warp in.png --scale 1.5 --size 600x600 --forward -o holes.png"
)]
pub(crate) struct WarpArgs {
    /// The image: PNG, JPEG, WebP, GIF, BMP, TGA, TIFF, QOI, HDR or EXR
    image: PathBuf,
    /// The file to write; its ending (.png, .jpg, .webp, .hdr, .exr) sets the format; `-` is standard output, PNG
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Four points of the input, in order around the quad [default: its corners]
    #[arg(long, num_args = 4, value_name = "X,Y", allow_hyphen_values = true)]
    from: Vec<Point>,
    /// The same four points in the output [default: its corners, from the upper left clockwise]
    #[arg(long, num_args = 4, value_name = "X,Y", allow_hyphen_values = true)]
    to: Vec<Point>,
    /// Input to output positions: 6 numbers (affine, two rows) or 9 (homography, three rows)
    #[arg(long, value_name = "A,B,C,...", conflicts_with_all = ["from", "to"], allow_hyphen_values = true)]
    matrix: Option<Matrix>,
    /// Degrees, counter-clockwise
    #[arg(long, value_name = "DEGREES", conflicts_with_all = ["from", "to", "matrix"], allow_hyphen_values = true)]
    rotate: Option<f64>,
    /// Pixels to the right and down; fractions are resampled
    #[arg(long, value_name = "X,Y", conflicts_with_all = ["from", "to", "matrix"], allow_hyphen_values = true)]
    translate: Option<Point>,
    /// One factor or two
    #[arg(long, value_name = "S|SX,SY", conflicts_with_all = ["from", "to", "matrix"], allow_hyphen_values = true)]
    scale: Option<Scale>,
    /// Size of the output [default: that of the input]
    #[arg(long, value_name = "WxH")]
    size: Option<Resolution>,
    /// Behaviour outside the image: transparent, border (black), edge or repeat
    #[arg(long, value_name = "WHAT", default_value = "transparent")]
    outside: Beyond,
    /// Texture filter: nearest, bilinear, bicubic:mitchell, trilinear, anisotropic:16, ewa:8, ewa:8:0.75,
    /// summed-area
    #[arg(long, value_name = "METHOD", value_parser = values::filter, default_value = "anisotropic:16")]
    filter: Filter,
    /// Write each texel to the pixel that it falls into, as the earliest programs did, and count overdraw and holes: what is wrong with it
    #[arg(long, conflicts_with_all = ["outside", "filter"])]
    forward: bool,
    /// srgb decodes before filtering; raw takes the codes as they are. Floats are linear light either way
    #[arg(long, value_name = "SPACE", value_parser = values::color, default_value = "srgb")]
    color: ColorMode,
    /// Threads [default: all cores]; no pixel depends on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug)]
struct Point(DVec2);

impl FromStr for Point {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match values::numbers(text)?[..] {
            [x, y] => Ok(Self(DVec2::new(x, y))),
            _ => Err("expected two numbers x,y".to_owned()),
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Scale(DVec2);

impl FromStr for Scale {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match values::numbers(text)?[..] {
            [s] if s != 0.0 => Ok(Self(DVec2::splat(s))),
            [x, y] if x != 0.0 && y != 0.0 => Ok(Self(DVec2::new(x, y))),
            _ => Err("expected one or two factors that are not 0".to_owned()),
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Matrix(DMat3);

impl FromStr for Matrix {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match values::numbers(text)?[..] {
            [a, b, c, d, e, f] => Ok(Self(DMat3::from_cols(
                DVec3::new(a, d, 0.0),
                DVec3::new(b, e, 0.0),
                DVec3::new(c, f, 1.0),
            ))),
            [a, b, c, d, e, f, g, h, i] => Ok(Self(DMat3::from_cols(
                DVec3::new(a, d, g),
                DVec3::new(b, e, h),
                DVec3::new(c, f, i),
            ))),
            _ => Err("expected 6 or 9 numbers, row by row".to_owned()),
        }
    }
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Beyond {
    Transparent,
    Border,
    Edge,
    Repeat,
}

pub(crate) fn run(args: &WarpArgs) -> Result<Exit, Failure> {
    one_stdout(args.json, &args.output)?;
    distinct([&args.output], [&args.image])?;
    let main = Destination::new(&args.output)?;
    let format = formats::picture("-o", &args.output)?;
    let space = match args.color {
        ColorMode::Srgb => ColorSpace::Srgb,
        ColorMode::Raw => ColorSpace::Linear,
    };
    let (texture, bits) = image_io::read_texture(&args.image, space)?;
    let (width, height) = args
        .size
        .map_or((texture.width(), texture.height()), |r| (r.width, r.height));
    let map = output_from_source(args, &texture, width, height)?;
    if args.forward {
        let made = forward::forward(&texture, &map, (width, height));
        return write_forward(args, (main, format, bits), made, (width, height));
    }
    ask_to_prepare(&texture, args.filter, &args.image)?;
    let texture = texture.prepared_for(args.filter);
    let outside = match args.outside {
        Beyond::Transparent => EdgeMode::Transparent,
        Beyond::Border => EdgeMode::Border([0.0, 0.0, 0.0, 1.0]),
        Beyond::Edge => EdgeMode::Edge,
        Beyond::Repeat => EdgeMode::Repeat,
    };
    let resample = Resample::new(&texture, args.filter, outside, &map);
    let alpha = texture.has_alpha() || matches!(args.outside, Beyond::Transparent);
    let code = formats::pixel_code(format, bits, args.color, alpha);
    let mut lost = Lost::default();
    let mut stage = Stage::new(&main)?;
    let path = stage.add(main, format.ending());
    write_pixels(&path, code, (width, height), |out| {
        lost = draw(&resample, args.threads, code, (width, height), out)?;
        Ok(())
    })?;
    stage.commit()?;
    // Filters ring a little over whole numbers, which ends at their range.
    if bits != 32 {
        (lost.above, lost.below) = (0, 0);
    }
    let mut written = Written::new("warp");
    written.picture(&args.output, (width, height));
    written.warn(formats::warn(&args.output, format, lost));
    written.tell(args.json)
}

/// The report of a forward map.
#[derive(Debug, serde::Serialize)]
struct Forward {
    #[serde(flatten)]
    written: Written,
    forward: forward::Counts,
}

fn write_forward(
    args: &WarpArgs,
    (main, format, bits): (Destination, PictureFormat, u32),
    (pixels, counts): (Vec<[f32; 4]>, forward::Counts),
    size: (u32, u32),
) -> Result<Exit, Failure> {
    let code = formats::pixel_code(format, bits, args.color, true);
    let mut lost = Lost::default();
    let mut stage = Stage::new(&main)?;
    let path = stage.add(main, format.ending());
    write_pixels(&path, code, size, |out| {
        let mut bytes = vec![0; code.bytes() * size.0 as usize];
        pixels.chunks(size.0 as usize).try_for_each(|row| {
            lost += code.encode(row, &mut bytes);
            out.write_all(&bytes)
        })
    })?;
    stage.commit()?;
    say(&format!("{}: {}\n", args.output.display(), counts.words()));
    let mut written = Written::new("warp");
    written.picture(&args.output, size);
    written.warn(formats::warn(&args.output, format, lost));
    match args.json {
        true => failure::print_json(&Forward {
            written,
            forward: counts,
        })
        .map(|()| Exit::Done),
        false => Ok(Exit::Done),
    }
}

fn output_from_source(
    args: &WarpArgs,
    t: &Texture2d<'_>,
    width: u32,
    height: u32,
) -> Result<Homography, Failure> {
    let refused = |e: texmap_math::HomographyError| {
        Failure::new(
            Exit::Input,
            "bad-homography",
            format!("the four points or the matrix give no map: {e}"),
            "name the corners in order around a convex quad, no three on a line",
        )
    };
    if let Some(Matrix(m)) = args.matrix {
        return Homography::from_matrix(m).map_err(refused);
    }
    let corners = |w: u32, h: u32| {
        let (w, h) = (f64::from(w), f64::from(h));
        [
            DVec2::ZERO,
            DVec2::new(w, 0.0),
            DVec2::new(w, h),
            DVec2::new(0.0, h),
        ]
    };
    let given = |points: &[Point]| <[Point; 4]>::try_from(points).ok().map(|p| p.map(|p| p.0));
    let (from, to) = (given(&args.from), given(&args.to));
    if from.is_some() || to.is_some() {
        let from = from.unwrap_or_else(|| corners(t.width(), t.height()));
        let to = to.unwrap_or_else(|| corners(width, height));
        return Homography::from_quads(from, to).map_err(refused);
    }
    let [sx, sy] = args.scale.map_or([1.0, 1.0], |s| s.0.to_array());
    // y grows downward: counter-clockwise as seen.
    let (sin, cos) = deterministic_f64::sin_cos(args.rotate.unwrap_or(0.0).to_radians());
    let shift = args.translate.map_or(DVec2::ZERO, |p| p.0);
    let middle = |w: u32, h: u32| DVec2::new(f64::from(w), f64::from(h)) * 0.5;
    let (a, b) = (
        DVec2::new(cos * sx, -sin * sx),
        DVec2::new(sin * sy, cos * sy),
    );
    let source = middle(t.width(), t.height());
    let c = middle(width, height) + shift - a * source.x - b * source.y;
    Homography::from_matrix(DMat3::from_cols(
        a.extend(0.0),
        b.extend(0.0),
        c.extend(1.0),
    ))
    .map_err(refused)
}

/// Rows of a band; each band belongs to one thread.
const BAND: usize = 32;

/// All threads draw one band each while the bands before are encoded, so that no more than two rounds of
/// bands are ever held.
fn draw(
    resample: &Resample<'_>,
    threads: Option<u16>,
    code: PixelCode,
    (width, height): (u32, u32),
    out: &mut dyn Write,
) -> io::Result<Lost> {
    let threads = threads.map_or_else(
        || thread::available_parallelism().map_or(1, usize::from),
        usize::from,
    );
    let (row, rows) = (code.bytes() * width as usize, height as usize);
    let level = Level::new();
    let work = |y0: usize, band: &mut [u8]| {
        let mut lost = Lost::default();
        let mut colors = vec![[0.0; 4]; width as usize];
        for (y, bytes) in band.chunks_mut(row).enumerate() {
            resample.rows(level, width, (y0 + y) as u32, &mut colors)?;
            lost += code.encode(&colors, bytes);
        }
        Ok::<Lost, texmap_sample::SampleError>(lost)
    };
    let mut lost = Lost::default();
    let (mut drawn, mut next) = (Vec::new(), Vec::new());
    for y0 in (0..rows).step_by(BAND * threads) {
        next.resize((rows - y0).min(BAND * threads) * row, 0);
        thread::scope(|scope| {
            let work = &work;
            let handles: Vec<_> = next
                .chunks_mut(BAND * row)
                .enumerate()
                .map(|(i, band)| scope.spawn(move || work(y0 + i * BAND, band)))
                .collect();
            out.write_all(&drawn)?;
            handles.into_iter().try_for_each(|h| match h.join() {
                Ok(result) => {
                    lost += result.map_err(io::Error::other)?;
                    Ok(())
                }
                Err(_) => Err(io::Error::other("a worker thread stopped")),
            })
        })?;
        std::mem::swap(&mut drawn, &mut next);
    }
    out.write_all(&drawn)?;
    Ok(lost)
}
