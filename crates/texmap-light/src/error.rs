use core::fmt;

use crate::{Environment, EnvironmentLayout};

/// Reason for which a function refused its input or ended early. Nothing has been written when the error is returned.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LightError {
    /// Slices that belong together have different lengths.
    Length {
        /// Name of the slice.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length that the output slice asks for.
        expected: usize,
    },
    /// A face of an environment that its layout cannot have.
    LayoutSize {
        /// The layout.
        chart: EnvironmentLayout,
        /// Texels.
        width: u32,
        /// Texels.
        height: u32,
    },
    /// A texel of an environment that is NaN, infinite or beyond 2^120, or a depth that is NaN or negative.
    Texel {
        /// Its index.
        index: usize,
    },
    /// A highlight's exponent that is negative or not finite.
    Exponent {
        /// The exponent.
        exponent: f32,
    },
    /// The progress callback ended the work.
    Cancelled,
}

impl fmt::Display for LightError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length {
                what,
                found,
                expected,
            } => {
                write!(
                    f,
                    "{what} has {found} entries but the output has {expected}: pass slices of one length"
                )
            }
            Self::LayoutSize {
                chart,
                width,
                height,
            } => write!(
                f,
                "a {} face of {width} x {height} texels: its width must be {} times its height, each side 1 to {}",
                chart.name(),
                chart.aspect(),
                Environment::MAX_SIDE
            ),
            Self::Cancelled => write!(f, "cancelled"),
            Self::Texel { index } => write!(
                f,
                "texel {index} is NaN, infinite, beyond 2^120 or a negative depth: replace such values first"
            ),
            Self::Exponent { exponent } => write!(
                f,
                "an exponent of {exponent}: it must be finite and not negative"
            ),
        }
    }
}

impl core::error::Error for LightError {}

/// Refuses a slice whose length differs from the output's.
pub(crate) fn same_length(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), LightError> {
    if found == expected {
        Ok(())
    } else {
        Err(LightError::Length {
            what,
            found,
            expected,
        })
    }
}
