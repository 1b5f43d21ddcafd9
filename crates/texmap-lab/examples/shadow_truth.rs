//! Shares of false shadow and false light of shadow maps, against shadow rays: `shadow_truth [MODEL.obj] [--pixels N]`.
//!
//! For each scene, light, size and filter: under the slope of the receiver alone, then under the default bias.

#![allow(clippy::print_stdout, reason = "the table is the output")]

use std::path::Path;

use texmap_lab::shadow_scene::{ShadowScene, sun};
use texmap_lab::shadow_truth::ShadowTruth;
use texmap_light::{Light, ShadowBias};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scenes = Vec::new();
    let (mut pixels, mut sizes) = (384, vec![512, 2048]);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--pixels" => pixels = args.next().ok_or("--pixels N")?.parse()?,
            "--size" => sizes = vec![args.next().ok_or("--size N")?.parse()?],
            file => scenes.push((file.to_owned(), ShadowScene::standing(Path::new(file))?)),
        }
    }
    if scenes.is_empty() {
        scenes = vec![
            ("ring".to_owned(), ShadowScene::ring()),
            ("bumpy ball".to_owned(), ShadowScene::bumpy_ball()),
            ("terrain".to_owned(), ShadowScene::terrain()),
        ];
    }
    let position = [1.4, -1.0, 2.2];
    let spot = Light::spot([1.0; 3], position, [-1.4, 1.0, -1.9], 0.5, 0.6);
    let point = Light::Point {
        color: [1.0; 3],
        position,
    };
    let lights = [
        ("sun 60", sun(60.0)),
        ("sun 25", sun(25.0)),
        ("sun 10", sun(10.0)),
        ("spot", spot),
        ("point", point),
    ];
    println!(
        "| scene | light | texels | taps | slope: shadow | light % | default: shadow | light % |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, scene) in &scenes {
        for (source, light) in &lights {
            let truth = ShadowTruth::new(scene, *light, pixels)?;
            let ShadowBias::Planes(constant) = truth.default_bias() else {
                return Err("the default has changed".into());
            };
            for &size in &sizes {
                for taps in [1, 3, 5] {
                    let old = truth.wrong(size, ShadowBias::Slope(constant), taps)?;
                    let new = truth.wrong(size, truth.default_bias(), taps)?;
                    let [a, b] = old.shares().map(|s| 100.0 * s);
                    let [c, d] = new.shares().map(|s| 100.0 * s);
                    println!(
                        "| {name} | {source} | {size} | {taps} | {a:.4} | {b:.4} | {c:.4} | {d:.4} |"
                    );
                }
            }
        }
    }
    Ok(())
}
