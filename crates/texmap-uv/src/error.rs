//! Errors of a mesh or a request.

use alloc::string::String;
use core::fmt;

/// Error of a mesh that could not be mapped, packed or reported on. Faces and vertices are counted from 0.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum UvError {
    /// The mesh has no face.
    Empty,
    /// A face with fewer than three corners.
    TooFewCorners {
        /// The face.
        face: usize,
        /// Number of corners of the face.
        corners: usize,
    },
    /// A corner that names no vertex (or no texture coordinate).
    BadIndex {
        /// The face.
        face: usize,
        /// The index that the corner names.
        index: u32,
        /// Number of vertices or texture coordinates.
        count: usize,
    },
    /// A vertex or texture coordinate with a NaN or an infinity, in use by a face.
    NotFinite {
        /// The face.
        face: usize,
        /// Index of the vertex or coordinate.
        index: u32,
    },
    /// A list whose length does not fit the mesh.
    WrongLength {
        /// Name of the list.
        what: &'static str,
        /// Length of the list.
        found: usize,
        /// The length that fits.
        expected: usize,
    },
    /// A frame with a zero or non-finite scale, position or angle.
    BadFrame {
        /// The offending value.
        value: f64,
    },
    /// A parameter out of its range.
    BadParameter {
        /// Name of the parameter.
        what: &'static str,
        /// The offending value.
        value: f64,
    },
    /// Islands that fit no atlas of this size with these gutters at any scale.
    DoesNotFit {
        /// Number of islands.
        charts: usize,
        /// Edge of the atlas in texels.
        size: u32,
        /// Texels between islands.
        gutter: u32,
    },
    /// An atlas larger than the unwrapper can fill.
    AtlasTooLarge {
        /// Edge of the atlas in texels.
        size: u32,
        /// The most that it takes.
        limit: u32,
    },
    /// A vertex pair of a cut or a sew that is no edge of the mesh.
    NotAnEdge {
        /// One end.
        a: u32,
        /// The other end.
        b: u32,
    },
    /// A face of more corners than the unwrapper can take.
    TooManyCorners {
        /// The face.
        face: usize,
        /// Number of corners of the face.
        corners: usize,
        /// The most that it takes.
        limit: usize,
    },
    /// A vertex with more triangles around it than the unwrapper can take.
    TooManyAround {
        /// The vertex.
        vertex: u32,
        /// Triangles around it.
        triangles: usize,
        /// The most that it takes.
        limit: usize,
    },
    /// The caller's progress function ended the work.
    Cancelled,
    /// The unwrapper gave up.
    Unwrap {
        /// The unwrapper's own words.
        reason: String,
    },
}

impl fmt::Display for UvError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the mesh has no face"),
            Self::TooFewCorners { face, corners } => write!(
                f,
                "face {face} has {corners} corners, a face needs at least 3"
            ),
            Self::BadIndex { face, index, count } => write!(
                f,
                "face {face} uses index {index}, but there are only {count}"
            ),
            Self::NotFinite { face, index } => write!(
                f,
                "face {face} uses vertex {index}, which is NaN or infinite"
            ),
            Self::WrongLength {
                what,
                found,
                expected,
            } => write!(f, "{what} has {found} entries, the mesh needs {expected}"),
            Self::BadFrame { value } => write!(
                f,
                "a frame needs finite values and a scale that is not zero, found {value}"
            ),
            Self::BadParameter { what, value } => write!(f, "{what} = {value} is out of its range"),
            Self::DoesNotFit {
                charts,
                size,
                gutter,
            } => {
                write!(
                    f,
                    "{charts} islands with gutters of {gutter} do not fit an atlas of {size} x {size} texels; try a larger atlas or a smaller gutter"
                )
            }
            Self::AtlasTooLarge { size, limit } => write!(
                f,
                "an atlas of {size} x {size} texels, of which the unwrapper takes at most {limit} a side"
            ),
            Self::NotAnEdge { a, b } => {
                write!(f, "no face has an edge from vertex {a} to vertex {b}")
            }
            Self::TooManyCorners {
                face,
                corners,
                limit,
            } => write!(
                f,
                "face {face} has {corners} corners, of which the unwrapper takes at most {limit}"
            ),
            Self::TooManyAround {
                vertex,
                triangles,
                limit,
            } => write!(
                f,
                "{triangles} triangles lie around vertex {vertex}, of which the unwrapper takes at most {limit}"
            ),
            Self::Cancelled => write!(f, "cancelled"),
            Self::Unwrap { reason } => write!(f, "the mesh could not be unwrapped: {reason}"),
        }
    }
}

impl core::error::Error for UvError {}
