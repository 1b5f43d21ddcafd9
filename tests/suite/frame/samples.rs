//! Four samples a pixel: what is shaded at a centre that lies outside of the triangle.

use texmap_render::{RenderSettings, Renderer, pixel_hash, render};
use texmap_sample::{Filter, Precision};
use texmap_scene::{ColorMode, Mesh, Scene};
use texmap_tests::levels::levels;

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
    let settings = RenderSettings {
        msaa: 4,
        ..RenderSettings::new(SIDE, SIDE)
    };
    let whole = render(&plane(1), &settings, &texmap_render::no_progress).unwrap();
    for cells in [13, 40, 160] {
        let cut = render(&plane(cells), &settings, &texmap_render::no_progress).unwrap();
        let pixels = whole.rgba.chunks_exact(4).zip(cut.rgba.chunks_exact(4));
        let off = pixels.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1));
        assert_eq!(off.count(), 0, "{cells} x {cells} cells");
    }
}

/// Texels whose bytes are the pixels stay bytes up to the mean of the samples: the same picture as that of their light, on each level,
/// over a background that is no byte and not opaque.
#[test]
fn bytes_have_the_mean_of_their_light() {
    let mut seen = Vec::new();
    for filter in [Filter::Nearest, Filter::Bilinear, Filter::Trilinear] {
        for cells in [1, 13, 70] {
            let mut scene = plane(cells);
            scene.color = ColorMode::Raw;
            scene.background = [0.1, 0.77, 0.3, 0.6];
            for p in &mut scene.meshes[0].positions {
                *p = [0.21 * p[0], 0.17 * p[1] + 0.05 * p[0], p[2]];
            }
            let sampler = &mut scene.materials[0].base_color.as_mut().unwrap().sampler;
            (sampler.filter, sampler.precision) = (filter, Precision::Fast);
            let settings = RenderSettings {
                msaa: 4,
                ..RenderSettings::new(SIDE, SIDE)
            };
            let frame = |settings: &RenderSettings, staged: bool| {
                let renderer = Renderer::new(&scene, settings).unwrap();
                let renderer = if staged { renderer.staged() } else { renderer };
                renderer.draw(&texmap_render::no_progress).unwrap()
            };
            let expected = frame(&settings, true);
            for (name, level) in levels() {
                let settings = RenderSettings {
                    level,
                    ..settings.clone()
                };
                let drawn = frame(&settings, false);
                let what = format!("{filter:?}, {cells} x {cells} cells, {name}");
                assert_eq!(pixel_hash(&drawn), pixel_hash(&expected), "{what}");
                let covered = [&drawn, &expected].map(|f| f.stats.pixels_covered);
                assert_eq!(covered[0], covered[1], "{what}");
            }
            seen.extend(expected.rgba.chunks_exact(4).map(<[u8]>::to_vec));
        }
    }
    seen.sort_unstable();
    seen.dedup();
    assert!(seen.len() > 2000, "{} colours", seen.len());
}
