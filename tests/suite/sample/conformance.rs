//! The committed table of expected values (`tests/data/sampler.toml`).

use crate::support::{float_texture, largest_difference};
use serde::Deserialize;
use texmap_math::Footprint;
use texmap_sample::Sampler;

#[derive(Deserialize)]
struct Table {
    texture: Vec<Entry>,
}

#[derive(Deserialize)]
struct Entry {
    width: u32,
    height: u32,
    texels: Vec<f32>,
    case: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    filter: String,
    wrap: [String; 2],
    uv: [f32; 2],
    grad: [f32; 4],
    expect: [f64; 4],
}

#[test]
fn the_committed_table_holds() {
    let table: Table =
        toml::from_str(include_str!("../../data/sampler.toml")).expect("the table parses");
    let mut cases = 0;
    for entry in &table.texture {
        let t = float_texture(entry.width, entry.height, 4, &entry.texels).with_mips();
        for case in &entry.case {
            let s = Sampler {
                filter: case.filter.parse().expect("a known filter"),
                wrap_u: case.wrap[0].parse().expect("a known wrap"),
                wrap_v: case.wrap[1].parse().expect("a known wrap"),
                border: [0.5, 0.25, 0.0, 1.0],
                ..Sampler::default()
            };
            let [a, b, c, d] = case.grad;
            let got = s.sample_grad(&t, case.uv, Footprint::new(a, b, c, d));
            let error = largest_difference(got, case.expect);
            assert!(
                error < 1e-4,
                "{}x{} {} {:?} {:?} {:?}: {got:?} instead of {:?}",
                entry.width,
                entry.height,
                case.filter,
                case.wrap,
                case.uv,
                case.grad,
                case.expect
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 900);
}
