//! Names of files as bytes, so that templates are filled without loss if a name is no Unicode.

use std::ffi::{OsStr, OsString};

/// The bytes of a name.
#[cfg(unix)]
pub(crate) fn bytes(name: &OsStr) -> Vec<u8> {
    std::os::unix::ffi::OsStrExt::as_bytes(name).to_vec()
}

/// The name of these bytes.
#[cfg(unix)]
pub(crate) fn of_bytes(bytes: Vec<u8>) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes)
}

/// The bytes of a name, with U+FFFD for parts that are no Unicode.
#[cfg(not(unix))]
pub(crate) fn bytes(name: &OsStr) -> Vec<u8> {
    name.to_string_lossy().into_owned().into_bytes()
}

/// The name of these bytes.
#[cfg(not(unix))]
pub(crate) fn of_bytes(bytes: Vec<u8>) -> OsString {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

/// `name` with every `pattern` replaced.
pub(crate) fn replaced(name: &OsStr, pattern: &str, by: &OsStr) -> OsString {
    let (name, by, pattern) = (bytes(name), bytes(by), pattern.as_bytes());
    let mut out = Vec::with_capacity(name.len() + by.len());
    let mut at = 0;
    while at < name.len() {
        if name[at..].starts_with(pattern) {
            out.extend(&by);
            at += pattern.len();
        } else {
            out.push(name[at]);
            at += 1;
        }
    }
    of_bytes(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_are_replaced_and_the_rest_is_kept() {
        let replaced = |name: &str| replaced(name.as_ref(), "{model}", "cow".as_ref());
        assert_eq!(replaced("a/{model}.{model}.png"), "a/cow.cow.png");
        assert_eq!(replaced("{mode} l}"), "{mode} l}");
        #[cfg(unix)]
        {
            let odd = of_bytes(b"\xff{model}\xfe".to_vec());
            assert_eq!(
                bytes(&super::replaced(&odd, "{model}", "x".as_ref())),
                b"\xffx\xfe"
            );
        }
    }
}
