//! The files of the web lab: in the program, or in a folder.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

use crate::failure::{Exit, Failure};

/// Names and bytes, where the program was built with them; made by the build script.
#[cfg(feature = "web")]
const EMBEDDED: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/pages.rs"));
#[cfg(not(feature = "web"))]
const EMBEDDED: &[(&str, &[u8])] = &[];

/// The folder of `web/build`, from that of the project.
const MADE: &str = "web/dist";

/// Files by their names from the first page on.
#[derive(Debug)]
pub(crate) enum Pages {
    Embedded,
    /// Canonical.
    Folder(PathBuf),
}

impl Pages {
    /// The folder that is given, else the pages in the program, else the folder that `web/build` makes.
    pub(crate) fn find(given: Option<&Path>) -> Result<Self, Failure> {
        let folder = match given {
            Some(folder) => folder,
            None if !EMBEDDED.is_empty() => return Ok(Self::Embedded),
            None => Path::new(MADE),
        };
        let real = folder.canonicalize().ok();
        let real = real.filter(|real| real.join("index.html").is_file());
        real.map(Self::Folder).ok_or_else(|| {
            Failure::new(
                Exit::Input,
                "no-pages",
                format!("{}: there is no web lab here", folder.display()),
                "make it with web/build in the folder of the project and name it with --folder, or build the program with --features web",
            )
        })
    }

    /// The file of a name that has passed [`plain`], if there is one.
    pub(crate) fn read(&self, name: &str) -> Option<Cow<'static, [u8]>> {
        match self {
            Self::Embedded => {
                let found = EMBEDDED.iter().find(|(known, _)| *known == name)?;
                Some(Cow::Borrowed(found.1))
            }
            Self::Folder(root) => {
                // Links must not lead out of the folder.
                let real = root.join(name).canonicalize().ok()?;
                let inside = real.starts_with(root) && real.is_file();
                inside.then(|| fs::read(real).ok())?.map(Cow::Owned)
            }
        }
    }
}

/// The file that the path of a request names: relative, of plain parts, `index.html` for the first page. `None` for anything
/// else.
pub(crate) fn plain(path: &str) -> Option<String> {
    let path = path.split(['?', '#']).next()?.strip_prefix('/')?;
    let name = decoded(path)?;
    let name = if name.is_empty() {
        "index.html".to_owned()
    } else {
        name
    };
    let good =
        |part: &str| !part.is_empty() && !part.starts_with('.') && !part.contains(['\\', ':']);
    let printable = !name.chars().any(char::is_control);
    (printable && name.split('/').all(good)).then_some(name)
}

/// Percent escapes as the bytes that they stand for; `None` unless the result is UTF-8.
fn decoded(path: &str) -> Option<String> {
    let mut bytes = path.bytes();
    let mut out = Vec::with_capacity(path.len());
    while let Some(byte) = bytes.next() {
        let digit = |byte: Option<u8>| char::from(byte?).to_digit(16);
        out.push(match byte {
            b'%' => (16 * digit(bytes.next())? + digit(bytes.next())?) as u8,
            byte => byte,
        });
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_within_the_folder() {
        assert_eq!(plain("/"), Some("index.html".into()));
        assert_eq!(plain("/wasm/simd.js?x=1"), Some("wasm/simd.js".into()));
        assert_eq!(plain("/a%20b.png"), Some("a b.png".into()));
        for bad in [
            "",
            "index.html",
            "//etc/passwd",
            "/../x",
            "/a/../../x",
            "/%2e%2e/x",
            "/a%2f..%2fx",
            "/a\\b",
            "/.git/config",
            "/c:/x",
            "/%00",
            "/%zz",
            "/%",
            "/%ff",
            "/a//b",
            "http://other/",
        ] {
            assert_eq!(plain(bad), None, "{bad}");
        }
    }

    #[cfg(feature = "web")]
    #[test]
    fn the_program_holds_the_pages() {
        let pages = Pages::find(None).unwrap();
        assert!(matches!(pages, Pages::Embedded));
        let index = pages.read("index.html").unwrap();
        assert!(String::from_utf8_lossy(&index).contains("texmap"));
        let module = pages
            .read("wasm/plain_bg.wasm")
            .or_else(|| pages.read("wasm/simd_bg.wasm"));
        assert!(module.unwrap().starts_with(b"\0asm"));
        assert!(pages.read("none.html").is_none());
    }

    #[cfg(unix)]
    #[test]
    fn links_do_not_lead_out_of_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("pages");
        fs::create_dir(&root).unwrap();
        fs::write(root.join("index.html"), "first").unwrap();
        fs::write(folder.path().join("secret"), "no").unwrap();
        std::os::unix::fs::symlink(folder.path().join("secret"), root.join("link")).unwrap();
        let pages = Pages::find(Some(&root)).unwrap();
        assert_eq!(pages.read("index.html").as_deref(), Some(&b"first"[..]));
        assert!(pages.read("link").is_none() && pages.read("none").is_none());
        let missing = Pages::find(Some(folder.path())).unwrap_err();
        assert!(missing.why.contains("web/build"));
    }
}
