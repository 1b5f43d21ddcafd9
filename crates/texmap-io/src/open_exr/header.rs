//! Sizes that the header of an OpenEXR file states. The decoder allocates blocks by them, for pictures of any size.

use exr::meta::BlockDescription;
use exr::meta::header::Header;

use crate::image_io::MAX_SIDE;

/// Bytes of a block that a file may ask for: 2 GiB.
const MAX_BLOCK: usize = 1 << 31;

/// The fault of a header that states a size no picture may have.
pub(super) fn fault(header: &Header) -> Option<String> {
    let tile = match header.blocks {
        BlockDescription::Tiles(tiles) => Some(tiles.tile_size),
        BlockDescription::ScanLines => None,
    };
    let sizes = [("layer", Some(header.layer_size)), ("tile", tile)];
    for (what, size) in sizes {
        if let Some(size) = size
            && size.0.max(size.1) > MAX_SIDE as usize
        {
            return Some(format!(
                "a {what} of {} x {} pixels, of which a side has at most {MAX_SIDE}",
                size.0, size.1
            ));
        }
    }
    let block = header.max_block_byte_size();
    (block > MAX_BLOCK).then(|| format!("a block of {block} bytes, of {MAX_BLOCK} at most"))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use crate::image_io::ImageSource;
    use crate::open_exr::ExrFile;

    fn picture() -> Vec<u8> {
        use exr::prelude::{Encoding, Image, SpecificChannels, Vec2, WritableImage as _};
        let channels = SpecificChannels::rgb(|_: Vec2<usize>| (1.0_f32, 2.0_f32, 3.0_f32));
        let mut file = Cursor::new(Vec::new());
        Image::from_encoded_channels((12, 9), Encoding::SMALL_LOSSLESS, channels)
            .write()
            .to_buffered(&mut file)
            .unwrap();
        file.into_inner()
    }

    /// A data window of a billion columns around a picture of twelve asks for blocks of 190 GB.
    #[test]
    fn windows_beyond_the_picture_are_refused_before_they_are_allocated() {
        let mut bytes = picture();
        let opened = |bytes: &[u8]| ExrFile::open(ImageSource::bytes(bytes)).err();
        assert_eq!(opened(&bytes), None);
        let name = b"dataWindow\0box2i\0\x10\0\0\0";
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len();
        // The right column.
        bytes[at + 8..at + 12].copy_from_slice(&1_000_000_000_i32.to_le_bytes());
        let problem = opened(&bytes).unwrap();
        assert!(
            problem.starts_with("a layer of 1000000001 x 9"),
            "{problem}"
        );
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("wide.exr");
        std::fs::write(&path, &bytes).unwrap();
        let error = crate::image_io::read_image(&path).unwrap_err();
        assert_eq!(error.code(), "broken-image");
        assert!(error.to_string().contains("1000000001"), "{error}");
    }
}
