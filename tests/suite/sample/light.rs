//! Colour and alpha: S5, S6, origin, transforms.

use crate::support::{Random, bilinear_clamped, float_texture, random_bytes};
use texmap_math::{Footprint, Level, color};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, SampleError, Sampler, TexelData, Texture2d,
    UvTransform, Wrap,
};

/// S5. sRGB decodes before it is blended: halfway between black and green is half the light.
#[test]
fn srgb_is_filtered_as_light() {
    let texels = vec![0, 0, 0, 255, 0, 255, 0, 255];
    let t = Texture2d::from_rgba8(2, 1, texels.clone(), ColorSpace::Srgb, Origin::TopLeft).unwrap();
    let middle = bilinear_clamped().sample(&t, [0.5, 0.5]);
    assert!((middle[1] - 0.5).abs() < 0.005, "{middle:?}");
    // The wrong order, for comparison: blend the bytes, then decode.
    let raw = Texture2d::from_rgba8(2, 1, texels, ColorSpace::Linear, Origin::TopLeft).unwrap();
    let wrong = color::srgb_to_linear(bilinear_clamped().sample(&raw, [0.5, 0.5])[1]);
    assert!((wrong - 0.2140).abs() < 0.005, "{wrong}");
}

/// Every sRGB byte survives the way in and out.
#[test]
fn srgb_bytes_survive_the_texture() {
    let texels: Vec<u8> = (0..=255).flat_map(|b| [b, b, b, 255]).collect();
    let t = Texture2d::from_rgba8(256, 1, texels, ColorSpace::Srgb, Origin::TopLeft).unwrap();
    for b in 0..=255_u8 {
        let c = t.texel(0, u32::from(b), 0).unwrap();
        assert_eq!(color::linear_to_srgb8(c[0]), b);
    }
}

/// The codes of a texture are the bytes of an 8-bit image, the rounded encodings of a 16-bit one, and there are none of bytes in
/// linear light, of floats, or of what is transparent.
#[test]
fn codes_of_a_texture_are_the_encodings_of_its_texels() {
    let mut random = Random::new(5);
    let bytes: Vec<u8> = (0..37 * 11)
        .flat_map(|_| {
            let [r, g, b, _] = random.word().to_le_bytes();
            [r, g, b, 255]
        })
        .collect();
    let of = |bytes: &[u8], color| {
        Texture2d::from_rgba8(37, 11, bytes.to_vec(), color, Origin::TopLeft).unwrap()
    };
    let wide: Vec<u16> = (0..37 * 11 * 3)
        .map(|i| (i * 7919 % 65536) as u16)
        .collect();
    let image = Image {
        width: 37,
        height: 11,
        channels: 3,
        texels: TexelData::U16(&wide),
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    };
    let (narrow, wide) = (
        of(&bytes, ColorSpace::Srgb),
        Texture2d::new(&image).unwrap(),
    );
    for level in [Level::new(), Level::baseline()] {
        for texture in [&narrow, &wide] {
            let codes = texture.srgb8_codes(level).unwrap();
            for (x, y) in (0..37).flat_map(|x| (0..11).map(move |y| (x, y))) {
                let [r, g, b, a] = codes.texel(0, x, y).unwrap();
                let light = texture.texel(0, x, y).unwrap();
                let code = |c: f32| f32::from(color::linear_to_srgb8(c)) * (1.0 / 255.0);
                assert_eq!(
                    [r, g, b, a],
                    [code(light[0]), code(light[1]), code(light[2]), 1.0]
                );
            }
        }
        let codes = narrow.srgb8_codes(level).unwrap();
        let [r, ..] = codes.texel(0, 3, 0).unwrap();
        assert_eq!(r, f32::from(bytes[12]) * (1.0 / 255.0));
        let clear: Vec<u8> = bytes.iter().map(|b| b / 2).collect();
        assert!(of(&bytes, ColorSpace::Linear).srgb8_codes(level).is_none());
        assert!(of(&clear, ColorSpace::Srgb).srgb8_codes(level).is_none());
        assert!(
            float_texture(2, 2, 4, &[0.5; 16])
                .srgb8_codes(level)
                .is_none()
        );
    }
}

/// A large 16-bit sRGB image is decoded by table, a small one value by value: to the same light, which is that of the curve.
#[test]
fn wide_srgb_texels_have_the_same_light_in_small_and_large_images() {
    fn image(side: u32, texels: &[u16]) -> Texture2d<'static> {
        let image = Image {
            width: side,
            height: side,
            channels: 1,
            texels: TexelData::U16(texels),
            color: ColorSpace::Srgb,
            alpha: Alpha::Data,
            origin: Origin::TopLeft,
        };
        Texture2d::new(&image).unwrap()
    }
    let codes: Vec<u16> = (0..=u16::MAX).rev().collect();
    let large = image(256, &codes);
    for (i, code) in codes.iter().enumerate().step_by(97) {
        let i = i as u32;
        let (a, b) = (
            large.texel(0, i % 256, i / 256),
            image(1, &[*code]).texel(0, 0, 0),
        );
        assert_eq!(a, b, "{code}");
        let light = f64::from(b.unwrap()[0]);
        let exact = f64::from(color::srgb_to_linear(f32::from(*code) / 65535.0));
        assert!((light - exact).abs() < 0.51 / 65535.0, "{code}");
    }
}

/// S6. Hidden colours of transparent texels never show.
#[test]
fn transparent_texels_do_not_bleed() {
    // Opaque green beside transparent red.
    let texels = vec![0, 255, 0, 255, 255, 0, 0, 0];
    let t = Texture2d::from_rgba8(2, 1, texels, ColorSpace::Linear, Origin::TopLeft)
        .unwrap()
        .with_mips();
    assert!(t.has_alpha());
    for k in 0..=100 {
        let c = bilinear_clamped().sample(&t, [k as f32 / 100.0, 0.5]);
        assert_eq!(c[0], 0.0);
        assert!((c[1] - c[3]).abs() < 1e-6, "{c:?}");
    }
    assert_eq!(t.texel(1, 0, 0).unwrap()[0], 0.0);
}

#[test]
fn partial_alpha_is_premultiplied_finely() {
    let t = Texture2d::from_rgba8(
        1,
        1,
        vec![200, 100, 3, 5],
        ColorSpace::Linear,
        Origin::TopLeft,
    )
    .unwrap();
    let c = t.texel(0, 0, 0).unwrap();
    for (got, byte) in c.into_iter().zip([200.0, 100.0, 3.0, 255.0_f32]) {
        assert!((got - byte * 5.0 / 65025.0).abs() < 1.0 / 65535.0);
    }
}

/// A bottom-left texture is the same picture upside down, to the bit, at every level.
#[test]
fn the_origin_flips_rows_as_integers() {
    let (width, height) = (6, 5);
    let top = random_bytes(width, height, 9).with_mips();
    let mut rows = Vec::new();
    for y in (0..height).rev() {
        for x in 0..width {
            rows.extend(top.texel(0, x, y).unwrap().map(color::unit_to_u8));
        }
    }
    let bottom = Texture2d::from_rgba8(width, height, rows, ColorSpace::Linear, Origin::BottomLeft)
        .unwrap()
        .with_mips();
    let mut random = Random::new(1);
    for filter in [
        Filter::Nearest,
        Filter::Bilinear,
        Filter::Trilinear,
        Filter::Anisotropic(4),
    ] {
        let s = Sampler {
            filter,
            wrap_v: Wrap::MirroredRepeat,
            ..Sampler::default()
        };
        for _ in 0..500 {
            let uv = [random.range(-2.0, 2.0), random.range(-2.0, 2.0)];
            let d = Footprint {
                du_dx: random.unit(),
                dv_dx: 0.1,
                du_dy: 0.0,
                dv_dy: random.unit(),
            };
            assert_eq!(s.sample_grad(&top, uv, d), s.sample_grad(&bottom, uv, d));
        }
    }
    assert_ne!(
        bilinear_clamped().sample(&top, [0.1, 0.1]),
        bilinear_clamped().sample(&top.clone().with_origin(Origin::BottomLeft), [0.1, 0.1])
    );
}

#[test]
fn palettes_are_looked_up_before_any_blend() {
    // Indices 0 and 2: a blend of indices would show entry 1, white.
    let palette = [[0, 0, 0, 255], [255, 255, 255, 255], [0, 0, 0, 255]];
    let t = Texture2d::from_palette(2, 1, &[0, 2], &palette, ColorSpace::Linear, Origin::TopLeft)
        .unwrap();
    for k in 0..=20 {
        assert_eq!(
            bilinear_clamped().sample(&t, [k as f32 / 20.0, 0.5]),
            [0.0, 0.0, 0.0, 1.0]
        );
    }
    let bad = Texture2d::from_palette(2, 1, &[0, 3], &palette, ColorSpace::Linear, Origin::TopLeft);
    assert_eq!(
        bad.unwrap_err(),
        SampleError::PaletteIndex {
            x: 1,
            y: 0,
            index: 3,
            entries: 3
        }
    );
}

#[test]
fn transforms_scale_turn_and_shift() {
    let t = UvTransform {
        offset: [0.5, 0.25],
        scale: [2.0, 4.0],
        rotation: core::f32::consts::FRAC_PI_2,
    };
    let [u, v] = t.apply([0.25, 0.125]);
    // Scaled (0.5, 0.5), turned a quarter (0.5, -0.5), shifted (1, -0.25).
    assert!((u - 1.0).abs() < 1e-6 && (v + 0.25).abs() < 1e-6, "{u} {v}");
    let d = Footprint {
        du_dx: 0.1,
        dv_dx: 0.2,
        du_dy: -0.3,
        dv_dy: 0.4,
    };
    let moved = t.apply_footprint(d);
    let base = t.apply([0.3, 0.6]);
    let right = t.apply([0.3 + d.du_dx, 0.6 + d.dv_dx]);
    let down = t.apply([0.3 + d.du_dy, 0.6 + d.dv_dy]);
    assert!(
        (right[0] - base[0] - moved.du_dx).abs() < 1e-6
            && (right[1] - base[1] - moved.dv_dx).abs() < 1e-6
    );
    assert!(
        (down[0] - base[0] - moved.du_dy).abs() < 1e-6
            && (down[1] - base[1] - moved.dv_dy).abs() < 1e-6
    );
    assert_eq!(UvTransform::default().apply([0.3, -7.0]), [0.3, -7.0]);
}

#[test]
fn bad_textures_are_refused_with_their_numbers() {
    let make = |w, h, n: usize| {
        Texture2d::from_rgba8(w, h, vec![0; n], ColorSpace::Linear, Origin::TopLeft)
    };
    assert_eq!(
        make(0, 4, 0).unwrap_err(),
        SampleError::Size {
            width: 0,
            height: 4
        }
    );
    assert_eq!(
        make(4, 40_000, 0).unwrap_err(),
        SampleError::Size {
            width: 4,
            height: 40_000
        }
    );
    assert_eq!(
        make(2, 2, 15).unwrap_err(),
        SampleError::Length {
            expected: 16,
            got: 15
        }
    );
    let nan = Texture2d::borrow_r32(2, 2, &[0.0, 1.0, f32::NAN, 0.0], Origin::TopLeft);
    assert_eq!(nan.unwrap_err(), SampleError::Texel { x: 0, y: 1 });
    assert!(float_texture(1, 1, 1, &[0.5]).texel(0, 1, 0).is_none());
}
