//! Unwraps a mesh, with progress and a way to cancel, into a vertex buffer with uvs and tangents.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::ops::ControlFlow;
use texmap::uv::{AtlasSize, Faces, Mesh, Origin, SeamEdges, tangents, unwrap};

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|c| c as f32);
    let cube: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let mut faces = Faces::new();
    for quad in [b"0231", b"4576", b"0462", b"1375", b"2673", b"0154"] {
        faces.push(&quad.map(|c| u32::from(c - b'0')));
    }
    let mesh = Mesh::new(&cube, &faces)?;
    // `ControlFlow::Break(())` would end the work with `UvError::Cancelled`.
    let progress = |done, of| {
        println!("{done} of {of:?}");
        ControlFlow::Continue(())
    };
    let (cuts, page) = (SeamEdges::default(), AtlasSize::default());
    let set = unwrap(&mesh, &cuts, page, Origin::TopLeft, &progress)?;
    let flat = vec![[0.0; 3]; faces.corners().len()]; // a normal of zero stands for its face's
    let buffer = set.split(&mesh, &tangents(&mesh, &set, &flat)?)?;
    let vertices = buffer.positions.len();
    println!("{vertices} vertices, {} triangles", buffer.indices.len());
    Ok(())
}
