use core::fmt;

/// Why a slice function refused its input. Nothing has been written when it is returned.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LightError {
    /// Slices that belong together have different lengths.
    Length {
        /// Which slice.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length that the output slice asks for.
        expected: usize,
    },
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
