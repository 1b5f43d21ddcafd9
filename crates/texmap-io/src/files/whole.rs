//! Files read whole, large ones by every thread.

use std::fs::File;
use std::io::{self, Read};

/// Files from this size on are read by every thread, a piece of this size each: 4 MiB.
pub(super) const LARGE: u64 = 1 << 22;

pub(super) fn read_whole(file: impl Read, size: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(size as usize)
        .map_err(io::Error::other)?;
    file.take(size).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(unix)]
pub(super) fn read_at_once(file: File, size: u64) -> io::Result<Vec<u8>> {
    use std::os::unix::fs::FileExt;

    // The system zeroes memory pages at the first write to each, which is most of the time of reading.
    let mut bytes = vec![0; size as usize];
    let pieces = bytes.chunks_mut(LARGE as usize).enumerate();
    texmap_math::parallel::try_for_each(pieces, |(number, piece)| {
        file.read_exact_at(piece, number as u64 * LARGE)
    })?;
    Ok(bytes)
}

#[cfg(not(unix))]
pub(super) fn read_at_once(file: File, size: u64) -> io::Result<Vec<u8>> {
    read_whole(file, size)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::{FileSource, MAX_TEXT};
    use super::*;

    #[test]
    fn large_files_are_read_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        let bytes: Vec<u8> = (0..3 * LARGE + 7).map(|i| (i / 977) as u8).collect();
        for size in [LARGE - 1, LARGE, LARGE + 1, 3 * LARGE + 7] {
            fs::write(&path, &bytes[..size as usize]).unwrap();
            assert!(
                FileSource::anywhere().read(&path, MAX_TEXT).unwrap() == bytes[..size as usize],
                "{size}"
            );
        }
    }
}
