//! Colour transfer.

use texmap_math::color::{
    linear_to_srgb, linear_to_srgb8, srgb_to_linear, srgb8_to_linear, srgb8_to_linear16, unit_to_u8,
};

/// IEC 61966-2-1 in f64 with the platform's power.
fn decode(c: f64) -> f64 {
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

fn encode(c: f64) -> f64 {
    if c <= 0.003_130_8 {
        c * 12.92
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    }
}

#[test]
fn tables_are_the_curve() {
    for c in 0..=255u8 {
        let exact = decode(f64::from(c) / 255.0);
        assert_eq!(srgb8_to_linear(c), exact as f32, "{c}");
        assert_eq!(
            f64::from(srgb8_to_linear16(c)),
            (exact * 65535.0).round(),
            "{c}"
        );
        assert_eq!(linear_to_srgb8(srgb8_to_linear(c)), c);
        assert_eq!(
            linear_to_srgb8(f32::from(srgb8_to_linear16(c)) / 65535.0),
            c
        );
        assert!(c == 0 || srgb8_to_linear16(c) > srgb8_to_linear16(c - 1));
    }
    assert_eq!((srgb8_to_linear(0), srgb8_to_linear(255)), (0.0, 1.0));
    assert_eq!(srgb8_to_linear16(255), 65535);
}

#[test]
fn eight_bits_are_the_nearest() {
    for i in 0..=1_000_000u32 {
        let c = f64::from(i) as f32 / 1e6;
        let exact = encode(f64::from(c)) * 255.0;
        let got = f64::from(linear_to_srgb8(c));
        assert!((got - exact).abs() <= 0.5 + 1e-9, "{c}: {got} {exact}");
    }
    for (c, want) in [
        (-1.0, 0),
        (f32::NAN, 0),
        (2.0, 255),
        (f32::INFINITY, 255),
        (f32::NEG_INFINITY, 0),
        (-0.0, 0),
    ] {
        assert_eq!(linear_to_srgb8(c), want);
        assert_eq!(unit_to_u8(c), want);
    }
    for i in 0..=255u8 {
        assert_eq!(unit_to_u8(f32::from(i) / 255.0), i);
    }
    assert_eq!((unit_to_u8(0.5), unit_to_u8(0.499_99)), (128, 127));
}

#[test]
fn curves_are_exact_and_invert_each_other() {
    for i in 0..=100_000u32 {
        let c = (f64::from(i) / 1e5) as f32;
        assert_eq!(srgb_to_linear(c), decode(f64::from(c)) as f32, "{c}");
        assert_eq!(linear_to_srgb(c), encode(f64::from(c)) as f32, "{c}");
        assert!((linear_to_srgb(srgb_to_linear(c)) - c).abs() <= 2e-7);
    }
    assert_eq!(srgb_to_linear(-0.5), -0.5 / 12.92);
    assert!(srgb_to_linear(f32::NAN).is_nan() && linear_to_srgb(f32::NAN).is_nan());
}
