//! `texmap sample`: values of an image at given coordinates, for checks by other programs.

use std::path::{Path, PathBuf};

use clap::Args;
use texmap_io::{FileSource, image_io, npy};
use texmap_math::{Footprint, Level, MemoryBudget};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Sampler, TexelData, Texture2d, Wrap, sample_slice,
};
use texmap_scene::ColorMode;

use crate::cmd::written::{Written, one_stdout};
use crate::failure::{Exit, Failure};
use crate::formats;
use crate::levels::{ask_for_levels, ask_to_prepare};
use crate::output::{Destination, Stage, distinct};
use crate::values;

/// Sample an image at the coordinates of a file; exact precision.
///
/// The result is f32 of shape (N, channels of the image): linear and premultiplied, or with --color raw
/// the codes over 255 (65535 for 16 bits) with each channel on its own. HDR and EXR are linear light, as they are. Texels and all mip
/// levels are floats. v = 0 is the top row.
#[derive(Args, Debug)]
#[command(
    after_help = "Texels at three places: printf '0.5,0.5\\n0.1,0.2\\n0.9,0.9\\n' > uv.txt && texmap sample brick.png --uv uv.txt -o values.npy\n\
                  Minified:               texmap sample brick.png --uv uv.npy --grad gradients.npy --filter anisotropic:16 -o values.npy"
)]
pub(crate) struct SampleArgs {
    /// The image: PNG, JPEG, WebP, GIF, BMP, TGA, TIFF, QOI, HDR or EXR
    image: PathBuf,
    /// Coordinates: .npy of shape (N, 2), or lines `u,v`
    #[arg(long, value_name = "FILE")]
    uv: PathBuf,
    /// Gradients: .npy of shape (N, 4) or lines `du/dx,dv/dx,du/dy,dv/dy`
    #[arg(long, value_name = "FILE", conflicts_with = "lod")]
    grad: Option<PathBuf>,
    /// One level of detail for all
    #[arg(long, value_name = "LEVEL", allow_hyphen_values = true)]
    lod: Option<f32>,
    /// nearest, bilinear, bicubic:mitchell, mip-nearest, bilinear-mip-nearest, trilinear, anisotropic:16, ewa:8,
    /// ewa:8:0.75, summed-area
    #[arg(long, value_name = "METHOD", value_parser = values::filter, default_value = "trilinear")]
    filter: Filter,
    /// repeat, mirrored-repeat, clamp-to-edge, clamp-to-border (transparent), mirror-clamp-to-edge
    #[arg(long, value_name = "MODE", value_parser = values::wrap, default_value = "repeat")]
    wrap: Wrap,
    /// srgb decodes and premultiplies before filtering; raw does neither
    #[arg(long, value_name = "SPACE", value_parser = values::color, default_value = "srgb")]
    color: ColorMode,
    /// The .npy to write; `-` is standard output
    #[arg(short, long, value_name = "OUT.npy")]
    output: PathBuf,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &SampleArgs) -> Result<Exit, Failure> {
    one_stdout(args.json, &args.output)?;
    let inputs = [&args.image, &args.uv].into_iter().chain(&args.grad);
    distinct([&args.output], inputs)?;
    let main = Destination::new(&args.output)?;
    formats::ending("-o", &args.output, &["npy"])?;
    let uv = read_rows(&args.uv, 2)?;
    let grad = args
        .grad
        .as_deref()
        .map(|path| read_rows(path, 4))
        .transpose()?;
    if let (Some(grad), Some(path)) = (&grad, &args.grad)
        && grad.len() / 4 != uv.len() / 2
    {
        return Err(bad_rows(
            path,
            format!(
                "{} gradients for {} coordinates",
                grad.len() / 4,
                uv.len() / 2
            ),
        ));
    }
    let (texture, channels) = read(args)?;
    ask_for_levels(&texture, &args.image)?;
    let texture = texture.with_mips();
    ask_to_prepare(&texture, args.filter, &args.image)?;
    let texture = texture.prepared_for(args.filter);
    let sampler = Sampler {
        filter: args.filter,
        wrap_u: args.wrap,
        wrap_v: args.wrap,
        ..Sampler::default()
    };
    // Two coordinates, four channels, and those that are written.
    MemoryBudget::of_process().ask(
        uv.len() as u64 / 2 * (8 + 16 + 16),
        format_args!("the values at {} coordinates", uv.len() / 2),
        "give fewer coordinates at a time",
    )?;
    let (u, v): (Vec<f32>, Vec<f32>) = uv.as_chunks::<2>().0.iter().map(|[u, v]| (*u, *v)).unzip();
    let mut out = vec![[0.0; 4]; u.len()];
    if let Some(lod) = args.lod {
        for (i, out) in out.iter_mut().enumerate() {
            *out = sampler.sample_lod(&texture, [u[i], v[i]], lod);
        }
    } else {
        let grads: Option<Vec<Footprint>> = grad.map(|g| {
            g.as_chunks::<4>()
                .0
                .iter()
                .map(|[a, b, c, d]| Footprint::new(*a, *b, *c, *d))
                .collect()
        });
        sample_slice(
            Level::new(),
            &sampler,
            &texture,
            &u,
            &v,
            grads.as_deref(),
            &mut out,
        )
        .map_err(|e| Failure::internal(e.to_string()))?;
    }
    let picked: &[usize] = match channels {
        1 => &[0],
        2 => &[0, 3],
        3 => &[0, 1, 2],
        _ => &[0, 1, 2, 3],
    };
    let values: Vec<f32> = out
        .iter()
        .flat_map(|c| picked.iter().map(move |k| c[*k]))
        .collect();
    let mut stage = Stage::new(&main)?;
    npy::write(
        &stage.add(main, "npy"),
        &[u.len(), picked.len()],
        npy::Values::F32(&values),
    )?;
    stage.commit()?;
    let mut written = Written::new("sample");
    written.array(&args.output, &[u.len(), picked.len()]);
    written.tell(args.json)
}

/// The texture and the channels that the file has.
fn read(args: &SampleArgs) -> Result<(Texture2d<'static>, u32), Failure> {
    let image = image_io::read_image(&args.image)?;
    let (width, height, channels) = (image.width, image.height, image.channels);
    let (texels, alpha) = match args.color {
        ColorMode::Srgb => image.into_floats(ColorSpace::Srgb),
        ColorMode::Raw => (image.into_floats(ColorSpace::Linear).0, Alpha::Data),
    };
    let texture = Texture2d::new(&Image {
        width,
        height,
        channels: 4,
        texels: TexelData::F32(&texels),
        color: ColorSpace::Linear,
        alpha,
        origin: Origin::TopLeft,
    })
    .map_err(|e| {
        Failure::new(
            Exit::Input,
            "broken-image",
            format!("{}: {e}", args.image.display()),
            "",
        )
    })?;
    Ok((texture, channels))
}

/// Rows of numbers from an .npy array or from text with commas.
fn read_rows(path: &Path, columns: usize) -> Result<Vec<f32>, Failure> {
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("npy"))
    {
        let array = npy::read(path)?;
        let npy::Data::F32(values) = array.data else {
            return Err(bad_rows(path, "not an array of floats".to_owned()));
        };
        if array.shape.len() != 2 || array.shape[1] != columns {
            return Err(bad_rows(
                path,
                format!("shape {:?} instead of (N, {columns})", array.shape),
            ));
        }
        return Ok(values);
    }
    let text = FileSource::anywhere().read_text(path, FileSource::MAX_LIST)?;
    let mut values = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let before = values.len();
        for (n, word) in line.split(',').enumerate() {
            match word.trim().parse::<f32>() {
                Ok(x) => values.push(x),
                // Nothing is quoted: the file may be anything.
                Err(_) => {
                    return Err(bad_rows(
                        path,
                        format!("line {}: value {} is not a number", i + 1, n + 1),
                    ));
                }
            }
        }
        if values.len() - before != columns {
            return Err(bad_rows(
                path,
                format!(
                    "line {}: {} numbers instead of {columns}",
                    i + 1,
                    values.len() - before
                ),
            ));
        }
    }
    Ok(values)
}

fn bad_rows(path: &Path, problem: String) -> Failure {
    Failure::new(
        Exit::Input,
        "bad-coordinates",
        format!("{}: {problem}", path.display()),
        "coordinates are rows u,v; gradients rows du/dx,dv/dx,du/dy,dv/dy, as many",
    )
}
