//! Textures that are looked up at once have the bits of one look-up after the other.

use crate::support::{Random, WRAPS, filters, random_bytes, random_floats};
use texmap_math::Level;
use texmap_sample::lanes::{BoundTexture, JointTextures, RGBA8_EXACT, RGBA16};
use texmap_sample::{
    ColorSpace, Filter, Lod, Origin, Places, Precision, Sampler, Texture2d, Wrap, sample_soa,
};
use texmap_tests::levels::levels;

/// Four runs of sixteen lanes and some.
const MOST: usize = 69;

fn srgb(width: u32, height: u32, seed: u64, alpha: bool) -> Texture2d<'static> {
    let mut random = Random::new(seed);
    let texels = (0..width * height).flat_map(|_| {
        let [r, g, b, a, ..] = random.word().to_le_bytes();
        [r, g, b, if alpha { a } else { 255 }]
    });
    let texels = texels.collect::<Vec<u8>>();
    Texture2d::from_rgba8(width, height, texels, ColorSpace::Srgb, Origin::TopLeft).unwrap()
}

/// Coordinates in runs of one level and far apart, and some that are no numbers.
fn columns() -> [Vec<f32>; 6] {
    let mut random = Random::new(5);
    let mut columns = [2.0, 2.0, 0.1, 0.1, 0.1, 0.1].map(|reach| {
        (0..MOST)
            .map(|k| random.range(-reach, reach) * if k < 32 { 0.02 } else { 1.0 })
            .collect::<Vec<f32>>()
    });
    columns[0][40] = f32::NAN;
    columns[1][41] = 1e30;
    columns[2][42] = f32::INFINITY;
    columns
}

fn bits(columns: &[Vec<f32>; 4]) -> [Vec<u32>; 4] {
    columns
        .each_ref()
        .map(|column| column.iter().map(|x| x.to_bits()).collect())
}

/// Bytes, sRGB, bytes with alpha and sRGB with alpha of one size are one group for filters of one cell or two on unbordered textures, and
/// every group has the bits of single textures, for all filters, wraps, levels of detail and lengths.
#[test]
fn joint_textures_have_the_bits_of_each_alone() {
    let at = columns();
    let mut joint = 0;
    for (width, height) in [(64, 64), (37, 21)] {
        let textures = [
            srgb(width, height, 1, false).with_mips(),
            random_bytes(width, height, 2).with_mips(),
            srgb(width, height, 3, true).with_mips(),
            random_bytes(width, height, 4).with_mips(),
            random_floats(width, height, 5).with_mips(),
        ];
        for (k, filter) in filters().into_iter().enumerate() {
            for (wrap, precision) in WRAPS
                .into_iter()
                .flat_map(|wrap| [Precision::Exact, Precision::Fast].map(|p| (wrap, p)))
            {
                let lod = Lod {
                    bias: 0.7,
                    min: 0.2,
                    max: 3.3,
                };
                let s = Sampler {
                    filter,
                    wrap_u: wrap,
                    precision,
                    lod: if k % 2 == 1 { lod } else { Lod::default() },
                    ..Sampler::default()
                };
                for group in groups(&s, &textures) {
                    let texels = group.iter().map(|k| {
                        let view = BoundTexture::new(&s, &textures[*k]).unwrap();
                        view.format
                    });
                    let formats: Vec<u8> = texels.collect();
                    let both = [RGBA8_EXACT, RGBA16].map(|format| formats.contains(&format));
                    joint += u32::from(group.len() > 2 && both == [true, true]);
                    check(&s, &textures, &group, &at);
                }
            }
        }
    }
    assert!(joint >= 16, "{joint}");
}

/// Indices of textures that are looked up together.
fn groups(s: &Sampler, textures: &[Texture2d<'static>]) -> Vec<Vec<usize>> {
    let mut groups: Vec<(JointTextures<'_>, Vec<usize>)> = Vec::new();
    for (k, t) in textures.iter().enumerate() {
        let view = BoundTexture::new(s, t).unwrap();
        match groups.iter_mut().find_map(|(group, indices)| {
            let added = group.add(&view);
            added.then_some(indices)
        }) {
            Some(indices) => indices.push(k),
            None => groups.push((JointTextures::new(s, view), vec![k])),
        }
    }
    groups.into_iter().map(|(_, indices)| indices).collect()
}

fn check(s: &Sampler, textures: &[Texture2d<'static>], group: &[usize], at: &[Vec<f32>; 6]) {
    let view = |k: &usize| BoundTexture::new(s, &textures[*k]).unwrap();
    let mut joint = JointTextures::new(s, view(&group[0]));
    for k in &group[1..] {
        assert!(joint.add(&view(k)));
    }
    for (name, level) in levels() {
        for count in [0, 1, 3, 4, 15, 16, 17, 64, MOST] {
            for with in [true, false] {
                let [u, v, gradients @ ..] = at.each_ref().map(|column| &column[..count]);
                let gradients = with.then_some(gradients);
                let places = Places { u, v, gradients };
                let mut found: Vec<_> = group
                    .iter()
                    .map(|_| [(); 4].map(|()| vec![0.0; count]))
                    .collect();
                let mut outs: Vec<[&mut [f32]; 4]> = found
                    .iter_mut()
                    .map(|columns| columns.each_mut().map(|column| &mut column[..]))
                    .collect();
                joint.sample_soa(level, &places, &mut outs).unwrap();
                for (k, found) in group.iter().zip(&found) {
                    let mut alone = [(); 4].map(|()| vec![0.0; count]);
                    let out = alone.each_mut().map(|column| &mut column[..]);
                    sample_soa(level, s, &textures[*k], &places, out).unwrap();
                    assert!(
                        bits(found) == bits(&alone),
                        "{s:?} {name} {count} {with} texture {k}"
                    );
                }
            }
        }
    }
}

/// Textures that read other texels at the same coordinates are given back.
#[test]
fn textures_of_other_texels_are_not_joined() {
    let s = Sampler {
        filter: Filter::Trilinear,
        ..Sampler::default()
    };
    let t = srgb(64, 64, 1, false).with_mips();
    let bytes = random_bytes(64, 64, 2).with_mips();
    let joint = JointTextures::new(&s, BoundTexture::new(&s, &t).unwrap());
    let add = |s: &Sampler, other: &Texture2d<'static>| {
        let mut joint = joint.clone();
        joint.add(&BoundTexture::new(s, other).unwrap())
    };
    assert!(add(&s, &bytes));
    let others = [
        random_bytes(64, 32, 3).with_mips(),
        random_bytes(32, 32, 3).with_mips(),
        random_bytes(64, 64, 3),
        random_bytes(64, 64, 3)
            .with_origin(Origin::BottomLeft)
            .with_mips(),
        random_floats(64, 64, 3).with_mips(),
    ];
    for (k, other) in others.iter().enumerate() {
        assert!(!add(&s, other), "{k}");
    }
    let samplers = [
        Sampler {
            filter: Filter::Bilinear,
            ..s.clone()
        },
        Sampler {
            wrap_u: Wrap::ClampToEdge,
            ..s.clone()
        },
        Sampler {
            wrap_v: Wrap::MirroredRepeat,
            ..s.clone()
        },
        Sampler {
            lod: Lod {
                bias: 0.5,
                ..Lod::default()
            },
            ..s.clone()
        },
        Sampler {
            precision: Precision::Fast,
            ..s.clone()
        },
    ];
    for other in &samplers {
        assert!(!add(other, &bytes), "{other:?}");
    }
    // Texels beyond a border have no cells.
    let bordered = Sampler {
        wrap_u: Wrap::ClampToBorder,
        ..s.clone()
    };
    let mut joint = JointTextures::new(&bordered, BoundTexture::new(&bordered, &t).unwrap());
    let view = BoundTexture::new(&bordered, &bytes).unwrap();
    assert!(!joint.add(&view));
}

/// Columns of another length, or none for a texture, are an error.
#[test]
fn columns_of_other_lengths_are_refused() {
    let s = Sampler::default();
    let t = random_bytes(16, 16, 2).with_mips();
    let view = || BoundTexture::new(&s, &t).unwrap();
    let mut joint = JointTextures::new(&s, view());
    let (u, v) = ([0.1; 20], [0.2; 20]);
    let at = Places {
        u: &u,
        v: &v,
        gradients: None,
    };
    let level = Level::new();
    let none = joint.sample_soa(level, &at, &mut []).unwrap_err();
    assert_eq!(
        none.to_string(),
        "0 sets of columns for 1 textures: give one for each"
    );
    assert!(joint.add(&view()));
    let (mut a, mut b) = ([[0.0; 20]; 4], [[0.0; 20]; 4]);
    let [r, g, b, alpha] = b.each_mut();
    let mut outs = [
        a.each_mut().map(|column| &mut column[..]),
        [&mut r[..], &mut g[..], &mut b[..], &mut alpha[..19]],
    ];
    assert!(joint.sample_soa(level, &at, &mut outs).is_err());
}
