//! The bytes of an image file, in memory or opened, as one type: decoders are compiled once for it.

use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};

use crate::held::Input;

/// Bytes that a decoder reads.
#[derive(Debug)]
pub(crate) enum ImageSource<'a> {
    /// A whole file.
    Bytes(Cursor<&'a [u8]>),
    /// A file of which the head alone may be read.
    Opened(BufReader<Input>),
}

impl<'a> ImageSource<'a> {
    pub(crate) fn bytes(bytes: &'a [u8]) -> Self {
        Self::Bytes(Cursor::new(bytes))
    }

    pub(crate) fn opened(input: Input) -> Self {
        Self::Opened(BufReader::new(input))
    }

    /// True if the next bytes are these.
    pub(crate) fn begins_with(&mut self, magic: &[u8]) -> bool {
        self.fill_buf().is_ok_and(|bytes| bytes.starts_with(magic))
    }
}

impl Read for ImageSource<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Bytes(bytes) => bytes.read(to),
            Self::Opened(file) => file.read(to),
        }
    }

    fn read_exact(&mut self, to: &mut [u8]) -> io::Result<()> {
        match self {
            Self::Bytes(bytes) => bytes.read_exact(to),
            Self::Opened(file) => file.read_exact(to),
        }
    }

    fn read_to_end(&mut self, to: &mut Vec<u8>) -> io::Result<usize> {
        match self {
            Self::Bytes(bytes) => bytes.read_to_end(to),
            Self::Opened(file) => file.read_to_end(to),
        }
    }
}

impl BufRead for ImageSource<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match self {
            Self::Bytes(bytes) => bytes.fill_buf(),
            Self::Opened(file) => file.fill_buf(),
        }
    }

    fn consume(&mut self, count: usize) {
        match self {
            Self::Bytes(bytes) => bytes.consume(count),
            Self::Opened(file) => file.consume(count),
        }
    }
}

impl Seek for ImageSource<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Self::Bytes(bytes) => bytes.seek(to),
            Self::Opened(file) => file.seek(to),
        }
    }

    fn stream_position(&mut self) -> io::Result<u64> {
        match self {
            Self::Bytes(bytes) => bytes.stream_position(),
            Self::Opened(file) => file.stream_position(),
        }
    }
}
