//! Addresses in a document: data that they hold, or a file beside it.

use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};

use crate::shortened;

/// Target of an address.
#[derive(Debug, PartialEq)]
pub(super) enum Target {
    /// The bytes that it holds.
    Data(Vec<u8>),
    /// A name relative to the document.
    File(String),
}

/// Decodes an address; the error is one sentence.
pub(super) fn target(uri: &str) -> Result<Target, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data
            .split_once(',')
            .filter(|(kind, _)| kind.ends_with(";base64"));
        let (_, encoded) = encoded.ok_or("a data URI must be `data:TYPE;base64,...`")?;
        let decoded = LENIENT.decode(encoded);
        return decoded
            .map(Target::Data)
            .map_err(|e| format!("data URI: {e}"));
    }
    if let Some(problem) = address(uri) {
        return Err(problem);
    }
    let uri = uri.strip_prefix("file://").unwrap_or(uri);
    let name =
        decoded(uri).ok_or_else(|| format!("`{}` is not UTF-8 once decoded", shortened(uri)))?;
    match name.as_str() {
        "" => Err("an empty file name".into()),
        _ => Ok(Target::File(name)),
    }
}

/// The message about an address of another kind than files and data.
pub(super) fn address(uri: &str) -> Option<String> {
    // A scheme of one letter is a drive of another machine.
    let colon = uri.find(':').filter(|colon| *colon > 1)?;
    let scheme = &uri[..colon];
    let read = matches!(scheme, "data" | "file") || scheme.contains(['/', '\\']);
    (!read).then(|| {
        format!(
            "`{}` is an address; only files beside the model are read",
            shortened(uri)
        )
    })
}

const LENIENT: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_allow_trailing_bits(true)
        .with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Percent codes as their bytes; a `%` without two digits stands for itself.
fn decoded(uri: &str) -> Option<String> {
    let digit = |byte: Option<&u8>| char::from(*byte?).to_digit(16);
    let bytes = uri.as_bytes();
    let (mut out, mut at) = (Vec::with_capacity(bytes.len()), 0);
    while let Some(byte) = bytes.get(at) {
        match (byte, digit(bytes.get(at + 1)), digit(bytes.get(at + 2))) {
            (b'%', Some(high), Some(low)) => {
                out.push((16 * high + low) as u8);
                at += 3;
            }
            _ => {
                out.push(*byte);
                at += 1;
            }
        }
    }
    String::from_utf8(out)
        .ok()
        .filter(|name| !name.contains('\0'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_names_and_addresses() {
        let file = |name: &str| Ok(Target::File(name.to_owned()));
        assert_eq!(
            target("data:application/octet-stream;base64,AAEC/w=="),
            Ok(Target::Data(vec![0, 1, 2, 255]))
        );
        assert_eq!(
            target("data:image/png;base64,AAEC/w"),
            Ok(Target::Data(vec![0, 1, 2, 255]))
        );
        assert_eq!(target("a%20b/%C3%A9.png"), file("a b/é.png"));
        assert_eq!(target("100%.png"), file("100%.png"));
        assert_eq!(target("a/b:c.png"), file("a/b:c.png"));
        // Paths of other machines. The source of files refuses those outside of its root.
        assert_eq!(target("C:\\me\\a.png"), file("C:\\me\\a.png"));
        assert_eq!(target("c:/me/a.png"), file("c:/me/a.png"));
        assert_eq!(target("file:///C:/a%20b.png"), file("/C:/a b.png"));
        for bad in [
            "",
            "data:,abc",
            "data:text/plain;base64,A",
            "http://x/y.png",
            "file://",
            "blob:null/3",
            "%ff.png",
            "a%00b",
        ] {
            assert!(target(bad).is_err(), "{bad}");
        }
    }
}
