//! Look-ups.

use texmap_math::{Footprint, Level};
use texmap_sample::{
    Alpha, ColorSpace, Cubic, Filter, Image, Lod, Mip, Origin, Precision, Sampler, TexelData,
    TexelFilter, Texture2d, Wrap, sample_rgba8_slice, sample_slice,
};

use super::choices::Choices;

/// Any texture under any sampler at any place: finite colours, the same from a slice as one by one.
pub fn sample(bytes: &[u8]) {
    let mut c = Choices(bytes);
    let (width, height) = (c.below(10) as u32, c.below(10) as u32);
    let channels = c.below(6) as u32;
    let surplus = usize::from(c.byte() == 255);
    let count = (width * height * channels) as usize + surplus;
    let (mut small, mut wide, mut floats) = (Vec::new(), Vec::new(), Vec::new());
    let texels = match c.below(3) {
        0 => {
            small.extend((0..count).map(|_| c.byte()));
            TexelData::U8(&small)
        }
        1 => {
            wide.extend((0..count).map(|_| u16::from_le_bytes([c.byte(), c.byte()])));
            TexelData::U16(&wide)
        }
        _ => {
            floats.extend((0..count).map(|_| c.number()));
            TexelData::F32(&floats)
        }
    };
    let image = Image {
        width,
        height,
        channels,
        texels,
        color: c.of(&[ColorSpace::Linear, ColorSpace::Srgb]),
        alpha: c.of(&[Alpha::Straight, Alpha::Premultiplied]),
        origin: c.of(&[Origin::TopLeft, Origin::BottomLeft]),
    };
    let texture = match Texture2d::new(&image) {
        Ok(texture) => texture,
        Err(refusal) => return assert!(!refusal.to_string().is_empty()),
    };
    let texture = match c.below(4) {
        0 => texture,
        1 => texture.with_normal_mips(),
        2 => texture.with_coverage_mips(c.number()),
        _ => texture.with_mips().with_summed_area(),
    };
    // Products of colour and alpha stay in range.
    let tame = floats.iter().all(|x| x.abs() <= 1e15);
    for _ in 0..1 + c.below(3) {
        looked_up(&texture, tame, &mut c);
    }
}

fn looked_up(texture: &Texture2d<'_>, tame: bool, c: &mut Choices<'_>) {
    const WRAPS: [Wrap; 5] = [
        Wrap::Repeat,
        Wrap::MirroredRepeat,
        Wrap::ClampToEdge,
        Wrap::ClampToBorder,
        Wrap::MirrorClampToEdge,
    ];
    let number = c.byte();
    let filters = [
        Filter::Nearest,
        Filter::Bilinear,
        Filter::Bicubic(Cubic::CatmullRom),
        Filter::Bicubic(Cubic::BSpline),
        Filter::MipNearest,
        Filter::BilinearMipNearest,
        Filter::Trilinear,
        Filter::Anisotropic(number),
        Filter::ewa(number),
        Filter::SummedArea,
        Filter::Gl {
            mag: TexelFilter::Nearest,
            min: TexelFilter::Linear,
            mip: Mip::Linear,
        },
    ];
    let sampler = Sampler {
        filter: c.of(&filters),
        wrap_u: c.of(&WRAPS),
        wrap_v: c.of(&WRAPS),
        border: c.tame(),
        precision: c.of(&[Precision::Exact, Precision::Fast]),
        lod: Lod {
            bias: c.number(),
            min: c.number(),
            max: c.number(),
        },
    };
    let tame = tame && sampler.border.iter().all(|x| x.abs() <= 1e15);
    let count = c.below(20);
    let (u, v): (Vec<f32>, Vec<f32>) = (0..count).map(|_| (c.number(), c.number())).unzip();
    let grads: Vec<Footprint> = (0..count)
        .map(|_| {
            let [a, b, d, e] = c.numbers();
            Footprint::new(a, b, d, e)
        })
        .collect();
    let grads = (c.byte() < 200).then_some(&grads[..]);
    let mut out = vec![[0.0; 4]; count];
    sample_slice(Level::new(), &sampler, texture, &u, &v, grads, &mut out).expect("one length");
    for (i, colour) in out.iter().enumerate() {
        let one = match grads {
            Some(grads) => sampler.sample_grad(texture, [u[i], v[i]], grads[i]),
            None => sampler.sample(texture, [u[i], v[i]]),
        };
        let bits = |c: &[f32; 4]| c.map(f32::to_bits);
        assert_eq!(
            bits(colour),
            bits(&one),
            "{sampler:?} {:?} {:?}",
            [u[i], v[i]],
            grads.map(|g| g[i])
        );
        assert!(
            !tame || colour.iter().all(|c| c.is_finite()),
            "{colour:?} {sampler:?} {:?}",
            [u[i], v[i]]
        );
    }
    let mut bytes = vec![0; count];
    sample_rgba8_slice(Level::new(), &sampler, texture, &u, &v, grads, &mut bytes)
        .expect("one length");
}
