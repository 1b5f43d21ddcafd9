//! The values of a PLY file: their types, in bytes of either order and as words.

use crate::obj::spells_nan;

/// A type of values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    /// The type of this name.
    pub(super) fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a value.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// The value that these bytes begin with, exactly; `None` if there are too few. `big`: the first byte is the highest.
    #[inline]
    pub(super) fn read(self, bytes: &[u8], big: bool) -> Option<f64> {
        macro_rules! read {
            ($type:ty) => {{
                let bytes = *bytes.first_chunk()?;
                f64::from(match big {
                    true => <$type>::from_be_bytes(bytes),
                    false => <$type>::from_le_bytes(bytes),
                })
            }};
        }
        Some(match self {
            Self::I8 => read!(i8),
            Self::U8 => read!(u8),
            Self::I16 => read!(i16),
            Self::U16 => read!(u16),
            Self::I32 => read!(i32),
            Self::U32 => read!(u32),
            Self::F32 => read!(f32),
            Self::F64 => read!(f64),
        })
    }

    /// Appends the value of a word, lowest byte first; `None` for a word that is none of this type.
    pub(super) fn write(self, word: &[u8], out: &mut Vec<u8>) -> Option<()> {
        macro_rules! whole {
            ($type:ty) => {
                out.extend(
                    std::str::from_utf8(word)
                        .ok()?
                        .parse::<$type>()
                        .ok()?
                        .to_le_bytes(),
                )
            };
        }
        match self {
            Self::I8 => whole!(i8),
            Self::U8 => whole!(u8),
            Self::I16 => whole!(i16),
            Self::U16 => whole!(u16),
            Self::I32 => whole!(i32),
            Self::U32 => whole!(u32),
            Self::F32 => out.extend(float::<f32>(word, f32::NAN)?.to_le_bytes()),
            Self::F64 => out.extend(float::<f64>(word, f64::NAN)?.to_le_bytes()),
        }
        Some(())
    }
}

fn float<T: fast_float2::FastFloat>(word: &[u8], nan: T) -> Option<T> {
    let value = fast_float2::parse(word).ok();
    value.or_else(|| spells_nan(word).then_some(nan))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_become_the_values_that_bytes_hold() {
        for (name, word, value) in [
            ("char", "-128", -128.0),
            ("uint8", "255", 255.0),
            ("short", "-32768", -32768.0),
            ("ushort", "65535", 65535.0),
            ("int32", "-2147483648", -2_147_483_648.0),
            ("uint", "4294967295", 4_294_967_295.0),
            ("float", "0.1", f64::from(0.1_f32)),
            ("double", "-1e300", -1e300),
        ] {
            let kind = Kind::of(name).unwrap();
            let mut bytes = Vec::new();
            kind.write(word.as_bytes(), &mut bytes).unwrap();
            assert_eq!(bytes.len(), kind.size(), "{name}");
            assert_eq!(kind.read(&bytes, false), Some(value), "{name}");
            assert_eq!(kind.read(&bytes[1..], false), None, "{name}");
            bytes.reverse();
            assert_eq!(kind.read(&bytes, true), Some(value), "{name}");
        }
    }

    #[test]
    fn words_of_another_type_are_none() {
        for (name, word) in [
            ("uchar", "256"),
            ("uchar", "-1"),
            ("int", "1.5"),
            ("float", "x"),
            ("float", ""),
            ("char", "\u{e9}"),
        ] {
            let kind = Kind::of(name).unwrap();
            assert_eq!(
                kind.write(word.as_bytes(), &mut Vec::new()),
                None,
                "{name} {word}"
            );
        }
        assert_eq!(Kind::of("half"), None);
    }
}
