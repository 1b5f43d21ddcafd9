//! Neighbours of a cube's faces.

use super::on_face;

/// The neighbours beyond each face's left, right, top and bottom edge: the face (3 bits), and for its column and then its row two
/// bits: one if that counts along the edge (else it stays 0), one if it counts from the last texel.
pub(super) static EDGES: [u32; 24] = {
    let mut edges = [0; 24];
    let mut k = 0;
    while k < 24 {
        let [right, down, major] = axes(k / 4);
        let (out, along) = match k % 4 {
            0 => (opposite(right), down),
            1 => (right, down),
            2 => (opposite(down), right),
            _ => (down, right),
        };
        let mut face = 0;
        while dot(axes(face)[2], out) != 1.0 {
            face += 1;
        }
        let [x, y, _] = axes(face);
        edges[k] = face as u32 | step(x, along, major) << 3 | step(y, along, major) << 5;
        k += 1;
    }
    edges
};

/// To the right, down and out of a face.
const fn axes(face: usize) -> [[f32; 3]; 3] {
    let [x, y, z] = [
        on_face(face, [1.0, 0.0, 0.0]),
        on_face(face, [0.0, 1.0, 0.0]),
        on_face(face, [0.0, 0.0, 1.0]),
    ];
    [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
}

/// Direction of a neighbour's axis: along the edge or, if not, towards the face that was left or away from it.
const fn step(axis: [f32; 3], along: [f32; 3], left: [f32; 3]) -> u32 {
    let (along, left) = (dot(axis, along), dot(axis, left));
    if along == 0.0 {
        if left > 0.0 { 2 } else { 0 }
    } else if along > 0.0 {
        1
    } else {
        3
    }
}

const fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

const fn opposite([x, y, z]: [f32; 3]) -> [f32; 3] {
    [-x, -y, -z]
}
