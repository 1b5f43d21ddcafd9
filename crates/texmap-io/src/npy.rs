//! NumPy's `.npy` arrays (format 1.0): C order, little-endian.
//!
//! Source: NEP 1, "A Simple File Format for NumPy Arrays".

use std::io::{self, BufReader, Read, Take, Write};
use std::path::Path;

use crate::error::shortened;
use crate::held::Input;
use crate::{FileSource, IoError, SourceLocation, atomic};

/// The values of an array to write.
#[derive(Debug, Clone, Copy)]
pub enum Values<'a> {
    /// `<f4`.
    F32(&'a [f32]),
    /// `<u4`.
    U32(&'a [u32]),
    /// `|u1`.
    U8(&'a [u8]),
}

/// The values of an array that was read.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// `<f4`, and `<f8` rounded to it.
    F32(Vec<f32>),
    /// `|u1`.
    U8(Vec<u8>),
    /// `<u2`.
    U16(Vec<u16>),
    /// `<u4`.
    U32(Vec<u32>),
}

/// An array that was read: C order, the last axis fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// As many values as the product of `shape`.
    pub data: Data,
}

/// Writes an array, whole or not at all.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::BrokenArray`] when `shape` does not hold exactly as many values as given.
pub fn write(path: &Path, shape: &[usize], values: Values<'_>) -> Result<(), IoError> {
    let (descr, count) = match values {
        Values::F32(v) => ("<f4", v.len()),
        Values::U32(v) => ("<u4", v.len()),
        Values::U8(v) => ("|u1", v.len()),
    };
    if element_count(shape) != Some(count) {
        return Err(broken(path, format!("shape {shape:?} for {count} values")));
    }
    let header = header(descr, shape);
    atomic::write(path, |out| {
        out.write_all(&header)?;
        match values {
            Values::F32(v) => write_words(out, v.iter().map(|x| x.to_le_bytes())),
            Values::U32(v) => write_words(out, v.iter().map(|x| x.to_le_bytes())),
            Values::U8(v) => out.write_all(v),
        }
    })
}

/// The most bytes of values that are read, as they are in memory: 2 GiB.
pub const MAX_BYTES: u64 = 1 << 31;

/// Reads an array of `<f4`, `<f8` (rounded to f32), `|u1`, `<u2` or `<u4` in C order. Takes the memory of its values and no more.
///
/// # Errors
/// File errors; [`IoError::BrokenArray`] for a damaged header, another type or order, or missing bytes;
/// [`IoError::FileTooLarge`] for values of more than [`MAX_BYTES`], before they are read.
pub fn read(path: &Path) -> Result<Array, IoError> {
    Stored::open(&FileSource::anywhere(), path, None)?.read()
}

/// An array whose header was read, and whose values were not.
#[derive(Debug)]
pub(crate) struct Stored<'a> {
    path: &'a Path,
    input: BufReader<Take<Input>>,
    pub(crate) shape: Vec<usize>,
    descr: String,
    count: usize,
}

impl<'a> Stored<'a> {
    /// Reads and checks the header.
    pub(crate) fn open(
        files: &FileSource,
        path: &'a Path,
        named_by: Option<&SourceLocation>,
    ) -> Result<Self, IoError> {
        let opened = files.open(path, named_by, u64::MAX)?;
        let bytes = opened.bytes;
        let mut input = BufReader::new(opened.file.take(bytes));
        let (descr, shape, start) = read_header(path, &mut input, bytes)?;
        let stored = match descr.as_str() {
            "|u1" => 1,
            "<u2" => 2,
            "<f4" | "<u4" => 4,
            "<f8" => 8,
            other => return Err(broken(path, format!("element type {}", shortened(other)))),
        };
        let count = element_count(&shape).ok_or_else(|| broken(path, "shape overflows"))?;
        let expected = (count as u64)
            .checked_mul(stored)
            .ok_or_else(|| broken(path, "shape overflows"))?;
        if bytes - start.min(bytes) < expected {
            return Err(broken(
                path,
                format!("shape {shape:?} needs {expected} bytes of data; the file ends before"),
            ));
        }
        let kept = count as u64 * stored.min(4);
        if kept > MAX_BYTES {
            return Err(IoError::FileTooLarge {
                path: path.to_path_buf(),
                bytes: kept,
                limit: MAX_BYTES,
            });
        }
        // Values are read a block at a time.
        let what = format_args!("the array of shape {shape:?} of {}", path.display());
        files.ask(kept, what, "take a smaller array", named_by)?;
        Ok(Self {
            path,
            input,
            shape,
            descr,
            count,
        })
    }

    /// Reads the values.
    pub(crate) fn read(mut self) -> Result<Array, IoError> {
        let (input, count) = (&mut self.input, self.count);
        let data = match self.descr.as_str() {
            "|u1" => words(input, count, |[b]| b).map(Data::U8),
            "<u2" => words(input, count, u16::from_le_bytes).map(Data::U16),
            "<u4" => words(input, count, u32::from_le_bytes).map(Data::U32),
            "<f4" => words(input, count, f32::from_le_bytes).map(Data::F32),
            _ => words(input, count, |b| f64::from_le_bytes(b) as f32).map(Data::F32),
        }
        .map_err(|source| IoError::Read {
            path: self.path.to_path_buf(),
            named_by: None,
            source,
        })?;
        Ok(Array {
            shape: self.shape,
            data,
        })
    }
}

/// Element type and shape of the array, and where its values begin.
fn read_header(
    path: &Path,
    input: &mut impl Read,
    bytes: u64,
) -> Result<(String, Vec<usize>, u64), IoError> {
    let mut magic = [0; 8];
    input
        .read_exact(&mut magic)
        .map_err(|_| broken(path, "shorter than a .npy header"))?;
    if &magic[..6] != b"\x93NUMPY" || !(1..=3).contains(&magic[6]) {
        return Err(broken(path, "not a .npy file of format 1 to 3"));
    }
    let mut length = [0; 4];
    let length_bytes = if magic[6] == 1 { 2 } else { 4 };
    input
        .read_exact(&mut length[..length_bytes])
        .map_err(|_| broken(path, "shorter than a .npy header"))?;
    let length = u64::from(u32::from_le_bytes(length));
    if length > bytes {
        return Err(broken(path, "header longer than the file"));
    }
    if length > MAX_HEADER {
        return Err(broken(path, "header of more than 64 KiB"));
    }
    let mut text = String::new();
    input
        .take(length)
        .read_to_string(&mut text)
        .map_err(|_| broken(path, "header is not text"))?;
    let (descr, shape) = parse_header(&text).map_err(|problem| broken(path, problem))?;
    Ok((descr, shape, 8 + length_bytes as u64 + length))
}

/// NumPy itself refuses headers of more than 10,000 characters.
const MAX_HEADER: u64 = 1 << 16;

fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let mut axes = String::new();
    for n in shape {
        axes += &format!("{n},");
    }
    let mut dict = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({axes}), }}");
    // Magic, version, length and dictionary fill whole blocks of 64 bytes; the last is a newline.
    while (10 + dict.len() + 1) % 64 != 0 {
        dict.push(' ');
    }
    dict.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((dict.len() as u16).to_le_bytes());
    bytes.extend(dict.as_bytes());
    bytes
}

fn parse_header(text: &str) -> Result<(String, Vec<usize>), String> {
    let after = |key: &str| {
        text.find(&format!("'{key}':"))
            .map(|at| text[at + key.len() + 3..].trim_start())
            .ok_or_else(|| format!("header without {key}"))
    };
    let descr = after("descr")?
        .strip_prefix('\'')
        .and_then(|rest| rest.split_once('\''))
        .ok_or("header with a structured type")?
        .0
        .to_owned();
    if !after("fortran_order")?.starts_with("False") {
        return Err("Fortran order".into());
    }
    let shape = after("shape")?
        .strip_prefix('(')
        .and_then(|rest| rest.split_once(')'))
        .ok_or("header without a shape")?
        .0
        .split(',')
        .map(str::trim)
        .filter(|axis| !axis.is_empty())
        .map(|axis| {
            axis.parse()
                .map_err(|_| format!("axis length {}", shortened(axis)))
        })
        .collect::<Result<Vec<usize>, String>>()?;
    if shape.len() > 64 {
        return Err(format!("{} axes", shape.len()));
    }
    Ok((descr, shape))
}

fn element_count(shape: &[usize]) -> Option<usize> {
    shape
        .iter()
        .try_fold(1_usize, |n, &axis| n.checked_mul(axis))
}

fn write_words<const N: usize>(
    out: &mut dyn Write,
    words: impl Iterator<Item = [u8; N]>,
) -> io::Result<()> {
    for word in words {
        out.write_all(&word)?;
    }
    Ok(())
}

/// Reads `count` words, a block at a time: file and array never stand in memory together.
fn words<const N: usize, T>(
    input: &mut impl Read,
    count: usize,
    from: impl Fn([u8; N]) -> T,
) -> io::Result<Vec<T>> {
    const BLOCK: usize = 1 << 13;
    let mut out = Vec::new();
    out.try_reserve_exact(count).map_err(io::Error::other)?;
    let mut block = vec![[0; N]; BLOCK.min(count)];
    while out.len() < count {
        let part = &mut block[..BLOCK.min(count - out.len())];
        input.read_exact(part.as_flattened_mut())?;
        out.extend(part.iter().map(|&word| from(word)));
    }
    Ok(out)
}

fn broken(path: &Path, problem: impl Into<String>) -> IoError {
    IoError::BrokenArray {
        path: path.to_path_buf(),
        problem: problem.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_is_numpys_own() {
        let bytes = header("<f4", &[2, 3, 1]);
        assert_eq!(bytes.len() % 64, 0);
        assert_eq!(bytes.last(), Some(&b'\n'));
        assert!(bytes.starts_with(b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f4', 'fortran_order': False, 'shape': (2,3,1,), }"));
    }

    #[test]
    fn reads_back_what_it_wrote_and_refuses_the_rest() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.npy");
        write(&path, &[2, 2], Values::F32(&[1.0, -0.5, f32::NAN, 4.0])).unwrap();
        let array = read(&path).unwrap();
        assert_eq!(array.shape, [2, 2]);
        let Data::F32(v) = array.data else {
            panic!("f32 was written")
        };
        assert!(v[0] == 1.0 && v[1] == -0.5 && v[2].is_nan() && v[3] == 4.0);
        write(&path, &[3], Values::U32(&[1, 2, u32::MAX])).unwrap();
        assert_eq!(read(&path).unwrap().data, Data::U32(vec![1, 2, u32::MAX]));
        write(&path, &[1, 3], Values::U8(&[0, 7, 255])).unwrap();
        assert_eq!(read(&path).unwrap().data, Data::U8(vec![0, 7, 255]));
        write(&path, &[3], Values::U32(&[1, 2, u32::MAX])).unwrap();

        assert_eq!(
            write(&path, &[4], Values::U32(&[1])).unwrap_err().code(),
            "broken-array"
        );
        let whole = std::fs::read(&path).unwrap();
        for cut in [0, 5, 9, 40, whole.len() - 1] {
            std::fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(
                read(&path).unwrap_err().code(),
                "broken-array",
                "cut at {cut}"
            );
        }
        let fortran = String::from_utf8_lossy(&whole[10..]).replace("False", "True ");
        let mut bytes = whole[..10].to_vec();
        bytes.extend(fortran.as_bytes());
        std::fs::write(&path, bytes).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("Fortran"));
    }
}
