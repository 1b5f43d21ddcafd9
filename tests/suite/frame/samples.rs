//! Four samples a pixel: what is shaded at a centre that lies outside of the triangle.

use texmap_render::{Mesh, Scene, Settings, render};
use texmap_sample::Filter;

use crate::scenes::{of, slot, texture, unlit};

const SIDE: u32 = 96;

/// A tilted plane that fills the view, as `n` x `n` cells whose inner corners are shaken.
fn plane(n: u32) -> Scene {
    let mut state = 1u32;
    let mut shake = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    let mut mesh = Mesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let inner = i > 0 && i < n && j > 0 && j < n;
            let [x, y] = [i, j].map(|k| {
                let moved = k as f32 + if inner { 0.6 * shake() } else { 0.0 };
                16.0 * moved / n as f32 - 8.0
            });
            mesh.positions.push([x, y, -3.0 + 0.375 * x]);
            mesh.uvs.push([x * 0.25, y * 0.25]);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let b = a + n + 1;
            mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    let mut material = unlit([1.0; 3]);
    material.base_color = slot(0, Filter::Bilinear);
    Scene {
        textures: vec![texture(64, 64, |x, y| {
            let [r, g] = [x * 37 + y * 11, (x * 5) ^ (y * 29)].map(|v| (v % 251) as u8);
            [r, g, 255 - r, 255]
        })],
        ..of(material, mesh)
    }
}

/// However a plane is cut into triangles, its pixels are the same: a centre outside of the triangle that a sample shows has the
/// values of the plane, not the nearest of the triangle's.
#[test]
fn cuts_in_a_plane_do_not_show() {
    let settings = Settings {
        msaa: 4,
        ..Settings::new(SIDE, SIDE)
    };
    let whole = render(&plane(1), &settings, &|_, _| ()).unwrap();
    for cells in [13, 40, 160] {
        let cut = render(&plane(cells), &settings, &|_, _| ()).unwrap();
        let pixels = whole.rgba.chunks_exact(4).zip(cut.rgba.chunks_exact(4));
        let off = pixels.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1));
        assert_eq!(off.count(), 0, "{cells} x {cells} cells");
    }
}
