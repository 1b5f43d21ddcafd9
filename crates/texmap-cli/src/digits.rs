//! Numbers as people read them.

/// A number with six significant digits, without zeros at its end.
pub(crate) fn digits(x: f64) -> String {
    let scientific = format!("{x:.5e}");
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        return x.to_string();
    };
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    match exponent.parse::<i32>() {
        Ok(exponent @ -5..=14) => {
            let places = usize::try_from(5 - exponent).unwrap_or(0);
            trimmed(&format!("{x:.places$}"))
        }
        _ => format!("{}e{exponent}", trimmed(mantissa)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_digits_are_significant() {
        for (x, text) in [
            (0.0, "0"),
            (197.0, "197"),
            (1.0 / 3.0, "0.333333"),
            (0.000_447_213_595_5, "0.000447214"),
            (-2.0 / 3e7, "-6.66667e-8"),
            (123_456.7, "123457"),
            (1_234_567.8, "1234568"),
            (9.999_999_9, "10"),
            (1.5e30, "1.5e30"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(digits(x), text);
        }
    }
}
