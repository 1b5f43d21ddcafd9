//! The one reader of OBJ text: cut into pieces, which every core reads at once, and joined.
//!
//! A first pass counts what the indices of a piece refer to, so that the second one checks every line where it stands, as if there
//! were no pieces. Their number follows from the text alone.

use std::mem;
use std::ops::Range;
use std::path::Path;

use memchr::{memchr, memrchr};
use texmap_math::parallel;

use super::read::{self, Counts, Group, Obj, Spans, read_piece};
use super::source::are_finite;
use crate::IoError;

/// Bytes of a piece, and of the rest of its last statement.
const PIECE: usize = 1 << 20;

/// Models of the pieces of a text, in order.
pub(super) struct Pieces(Vec<Obj>);

/// Reads the text of a model.
///
/// With `spans`, the text is read to be given new coordinates: those of the file may be anything, and faces may have them at some
/// corners.
pub(super) fn read(file: &Path, text: &str, spans: Option<&mut Spans>) -> Result<Pieces, IoError> {
    read_in(file, text, spans, PIECE)
}

fn read_in(
    file: &Path,
    text: &str,
    spans: Option<&mut Spans>,
    size: usize,
) -> Result<Pieces, IoError> {
    let pieces = read_pieces(file, text, spans, size)?;
    match pieces.broken_vertex() {
        Some(vertex) => Err(read::vertex_fault(file, text, vertex)),
        None => Ok(pieces),
    }
}

fn read_pieces(
    file: &Path,
    text: &str,
    spans: Option<&mut Spans>,
    size: usize,
) -> Result<Pieces, IoError> {
    let pieces = cut(text, size);
    if let [piece] = &pieces[..] {
        let none = Counts::default();
        let (obj, found) = read_piece(file, text, piece.clone(), (none, none), spans.is_some())?;
        if let (Some(spans), Some(found)) = (spans, found) {
            *spans = found;
        }
        return Ok(Pieces(vec![obj]));
    }
    let counts = parallel::map(pieces.iter(), |piece| Counts::of(text, piece.clone()));
    let counts = counts.into_iter().scan(Counts::default(), |sum, own| {
        let above = *sum;
        *sum = above.and(own);
        Some((above, own))
    });
    let counts: Vec<_> = counts.collect();
    let read = parallel::map(pieces.into_iter().zip(counts), |(piece, counts)| {
        read_piece(file, text, piece, counts, spans.is_some())
    });
    // The first fault of the text, whichever was found first.
    let read = read.into_iter().collect::<Result<Vec<_>, IoError>>()?;
    let (objs, found): (Vec<_>, Vec<_>) = read.into_iter().unzip();
    if let Some(spans) = spans {
        for found in found.into_iter().flatten() {
            spans.corners.extend(found.corners);
            spans.others.extend(found.others);
            spans.uvs.extend(found.uvs);
            spans.libraries.extend(found.libraries);
            spans.first_face = spans.first_face.or(found.first_face);
        }
    }
    Ok(Pieces(objs))
}

/// Cuts a text into pieces of whole statements, one at least.
fn cut(text: &str, size: usize) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let (mut pieces, mut start) = (Vec::new(), 0);
    loop {
        let mut end = start + size.max(1) - 1;
        // The first line end from there on that ends a statement, too.
        loop {
            let found = bytes.get(end..).and_then(|rest| memchr(b'\n', rest));
            let Some(found) = found else {
                pieces.push(start..bytes.len());
                return pieces;
            };
            let line_end = end + found;
            let line = memrchr(b'\n', &bytes[start..line_end]).map_or(start, |n| start + n + 1);
            end = line_end + 1;
            if !text[line..line_end].trim_end().ends_with('\\') {
                break;
            }
        }
        pieces.push(start..end);
        start = end;
    }
}

impl Pieces {
    /// The first vertex that is not finite and that a face uses. (Scans have others: a vertex for each pixel of a depth image.)
    fn broken_vertex(&self) -> Option<usize> {
        if self.0.iter().all(|piece| piece.not_finite.positions == 0) {
            return None;
        }
        let positions = self.0.iter().flat_map(|piece| &piece.positions);
        let broken: Vec<bool> = positions.map(|position| !are_finite(position)).collect();
        let corners = self.0.iter().flat_map(|piece| &piece.corners);
        let used = corners.map(|corner| corner.vertex as usize);
        used.filter(|vertex| broken[*vertex]).min()
    }

    /// The model of all pieces; each list of a piece is given back to the system when it is copied. Corners are more than half of all:
    /// they are joined beside the rest. Takes as much memory as the pieces: a text that is not needed any more should be dropped before.
    pub(super) fn join(self) -> Obj {
        let Self(mut pieces) = self;
        if pieces.len() == 1 {
            return pieces.pop().unwrap_or_default();
        }
        let corners: Vec<_> = pieces
            .iter_mut()
            .map(|p| mem::take(&mut p.corners))
            .collect();
        let (corners, all) = parallel::join(|| joined(corners), || join_rest(pieces));
        Obj { corners, ..all }
    }
}

/// Lists one after the other.
fn joined<T>(lists: Vec<Vec<T>>) -> Vec<T> {
    let mut all = Vec::with_capacity(lists.iter().map(Vec::len).sum());
    for list in lists {
        all.extend(list);
    }
    all
}

/// All but the corners.
fn join_rest(mut pieces: Vec<Obj>) -> Obj {
    let colored = pieces.iter().any(|piece| !piece.colors.is_empty());
    if colored {
        for piece in &mut pieces {
            piece.colors.resize(piece.positions.len(), [1.0; 3]);
        }
    }
    let mut all = Obj::default();
    let (mut faces, mut positions, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    let (mut uvs, mut normals, mut above) = (Vec::new(), Vec::new(), 0);
    for piece in pieces {
        let groups = piece.groups.into_iter().map(|group| Group {
            first_face: above + group.first_face,
            ..group
        });
        all.groups.extend(groups);
        above += piece.faces.len();
        faces.push(piece.faces);
        positions.push(piece.positions);
        colors.push(piece.colors);
        uvs.push(piece.uvs);
        normals.push(piece.normals);
        all.materials.extend(piece.materials);
        all.libraries.extend(piece.libraries);
        all.lines_and_points += piece.lines_and_points;
        all.unknown = all.unknown.or(piece.unknown);
        all.not_finite = all.not_finite.and(piece.not_finite);
    }
    Obj {
        positions: joined(positions),
        colors: joined(colors),
        uvs: joined(uvs),
        normals: joined(normals),
        faces: joined(faces),
        ..all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# made by hand \\\nv 9 9 9\nmtllib a.mtl\r\no Wall\n\\\nv 0 0 0\nv 1 0 \\\n 0 0 1 0\nv 1 1 0\nvt 0 0\n\
        vn 0 0 1\nusemtl brick\ns 3\nf 1/1/1 2/-1/1 \\\n\t\\\n3/1/1\n\ng \u{e9}t\u{e9}\u{3000}x\nwhat 1\ns off\nv 0 0 5 1 0 0\nf -1 -2 \\\n-3 -4\nl 1/1 2\nl 1 \\\n\
        2\nusemtl b\nf 1 2 4\nwhy\np 1\n\\";

    fn debug(text: &str, size: usize) -> String {
        let mut spans = Spans::default();
        let plain = read_in(Path::new("a.obj"), text, None, size).map(Pieces::join);
        let spanned = read_in(Path::new("a.obj"), text, Some(&mut spans), size).map(Pieces::join);
        format!("{plain:?} {spanned:?} {spans:?}")
    }

    /// The size of the pieces changes neither the model, the positions in the text nor the first fault.
    #[test]
    fn pieces_change_nothing() {
        let whole = debug(TEXT, usize::MAX / 2);
        assert!(
            whole.contains("lines_and_points: 3") && whole.contains("Wall"),
            "{whole}"
        );
        for size in 1..TEXT.len() {
            assert_eq!(debug(TEXT, size), whole, "{size}");
        }
        for fault in [
            "f 1 2 5",
            "f 1/2 2/1 3/1",
            "f 1 2 -5",
            "v 0 0 nan\nf 1 2 -1",
            "f 1//1 2/1 3",
            "vt",
            "usemtl",
        ] {
            let text = format!("{TEXT} 1\n# {TEXT}\n{fault}\nv 1\n{TEXT}");
            let whole = debug(&text, usize::MAX / 2);
            assert!(whole.starts_with("Err"), "{whole}");
            for size in 1..text.len() {
                assert_eq!(debug(&text, size), whole, "{fault} {size}");
            }
        }
    }

    /// A cut within a statement would be seen: its two halves are other statements.
    #[test]
    fn joined_lines_stay_together() {
        let pieces = |text: &str, size| {
            let pieces: Vec<_> = cut(text, size)
                .into_iter()
                .map(|p| text[p].to_owned())
                .collect();
            assert_eq!(pieces.concat(), text);
            pieces
        };
        assert_eq!(
            pieces("f 1 \\ \n2 3\ng a\n", 1),
            ["f 1 \\ \n2 3\n", "g a\n", ""]
        );
        assert_eq!(pieces("a\nb\n\nc", 2), ["a\n", "b\n", "\nc"]);
        assert_eq!(pieces("", 5), [""]);
    }
}
