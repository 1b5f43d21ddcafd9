//! Memory budgets of the libraries: each of its own, none that the process shares.

use std::fs;

use texmap_io::{FileSource, IoError, LoadOptions, load};
use texmap_math::MemoryBudget;
use texmap_raster::{Atlas, AtlasMesh, AtlasOptions, RasterError, TargetSize};
use texmap_render::{Aov, RenderError, RenderSettings, Renderer, render};
use texmap_scene::Scene;

/// Less than anything large.
const LITTLE: MemoryBudget = MemoryBudget::new(20 << 20);

fn scene(lines: &str, memory: MemoryBudget) -> Result<Scene, IoError> {
    let dir = tempfile::tempdir().unwrap();
    image::GrayImage::new(2200, 2200)
        .save(dir.path().join("big.png"))
        .unwrap();
    let path = dir.path().join("a.scene");
    let text = format!("eye 0 2 6\nlook 0 0 0\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\n{lines}\nf 0 2 1\n");
    fs::write(&path, text).unwrap();
    let options = LoadOptions {
        files: FileSource::anywhere().with_memory(memory),
        ..LoadOptions::default()
    };
    load(&path, &options)
}

#[test]
fn loading_asks_the_options() {
    let lines = "texture big.png\ntf 0 0 0 2 1 1 1 1 0";
    assert!(scene(lines, MemoryBudget::UNLIMITED).is_ok());
    assert!(scene("", LITTLE).is_ok());
    let error = scene(lines, LITTLE).unwrap_err();
    assert_eq!(error.code(), "over-memory-budget");
    // The line that names the map, the map, and advice.
    assert_eq!(error.location().map(|p| p.line), Some(6));
    assert!(
        error
            .to_string()
            .contains("no memory for the 2200 x 2200 texels of")
    );
    assert!(
        error.help().contains("take a smaller image"),
        "{}",
        error.help()
    );
}

#[test]
fn drawing_asks_the_settings() {
    let scene = scene("ld 1 1 1 0 -1 0.1\nshadow 4096", MemoryBudget::UNLIMITED).unwrap();
    let settings = |side, aovs: &[Aov], memory| RenderSettings {
        aovs: aovs.to_vec(),
        memory,
        ..RenderSettings::new(side, side)
    };
    let refused = |settings: &RenderSettings| match Renderer::new(&scene, settings) {
        Err(RenderError::Memory(refused)) => refused.what,
        Err(other) => panic!("{other}"),
        Ok(_) => String::new(),
    };
    let shadow = refused(&settings(16, &[], LITTLE));
    assert_eq!(shadow, "a shadow map of 1 x 4096 x 4096 texels");
    assert_eq!(refused(&settings(16, &[], MemoryBudget::new(80 << 20))), "");
    // The picture alone fits, with positions it does not.
    let frame = MemoryBudget::new(70 << 20);
    assert_eq!(refused(&settings(2500, &[], frame)), "");
    let words = refused(&settings(2500, &[Aov::Position], frame));
    assert_eq!(words, "a frame of 2500 x 2500 pixels of 16 bytes");
    let error = render(
        &scene,
        &settings(2500, &[Aov::Position], frame),
        &texmap_render::no_progress,
    );
    assert_eq!(error.unwrap_err().code(), "over-memory-budget");
}

/// Maps that fit one by one but not together are refused before the first is drawn.
#[test]
fn shadow_maps_are_asked_for_together() {
    let lights = "ld 1 1 1 0 -1 0.1\nshadow 2048\n".repeat(5);
    let scene = scene(&lights, MemoryBudget::UNLIMITED).unwrap();
    let renderer = |mib: u64| {
        let settings = RenderSettings {
            memory: MemoryBudget::new(mib << 20),
            ..RenderSettings::new(16, 16)
        };
        Renderer::new(&scene, &settings).map(|_| ())
    };
    let Err(RenderError::Memory(refused)) = renderer(70) else {
        panic!("five maps of 16 MiB are more than 70 MiB")
    };
    assert_eq!(refused.what, "5 shadow maps");
    assert!(renderer(90).is_ok());
}

#[test]
fn atlases_ask_their_options() {
    let mesh = AtlasMesh {
        uvs: &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        indices: &[[0, 1, 2]],
        ..AtlasMesh::default()
    };
    let atlas = |side| {
        let options = AtlasOptions {
            memory: LITTLE,
            ..AtlasOptions::default()
        };
        Atlas::new(TargetSize::new(side, side).unwrap(), &mesh, options)
    };
    assert!(atlas(1000).is_ok());
    let Err(RasterError::Memory(refused)) = atlas(1200) else {
        panic!("17 bytes a texel are more than 20 MiB")
    };
    assert_eq!(refused.bytes, 1200 * 1200 * 17);
}
