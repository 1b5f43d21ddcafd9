//! Prints `src/albedo/table.rs`: `cargo run --release -p texmap-light --example albedo_table > crates/texmap-light/src/albedo/table.rs`.
#![allow(clippy::print_stdout, reason = "the table goes to standard output")]
use texmap_light::reference::metallic_roughness::{
    GRAZING_MEAN, GRAZING_VARIANCE, ggx_albedo, sheen_albedo,
};
use texmap_light::{MIN_ROUGHNESS, SHEEN_MIN_ROUGHNESS};

const SIDE: usize = 64;

fn step(k: usize) -> f64 {
    k as f64 / (SIDE - 1) as f64
}

fn stored(x: f64) -> u32 {
    (x.clamp(0.0, 1.0) * 65535.0).round() as u32
}

fn print(name: &str, doc: &str, values: &[u32]) {
    println!(
        "\n/// {doc}\n#[rustfmt::skip]\npub(super) static {name}: [u32; {}] = [",
        values.len()
    );
    for row in values.chunks(16) {
        let row: Vec<String> = row.iter().map(|x| format!("{x:#x}")).collect();
        println!("    {},", row.join(", "));
    }
    println!("];");
}

fn main() {
    let (mut ggx, mut average, mut grazing, mut sheen) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for row in 0..SIDE {
        let width = |least: f32| {
            let roughness = step(row).max(least.into());
            roughness * roughness
        };
        let cosine = |column: usize| (step(column) * step(column)).max(1e-4);
        let albedo = |cosine: f64| ggx_albedo(width(MIN_ROUGHNESS), cosine, 384);
        let packed = |[a, b]: [f64; 2]| stored(a) | stored(b) << 16;
        ggx.extend((0..SIDE).map(|column| packed(albedo(cosine(column)))));
        let (mut sum, mut slopes) = ([0.0; 2], [0.0; 2]);
        for k in 0..128 {
            let t = (f64::from(k) + 0.5) / 128.0;
            let value = ggx_albedo(width(MIN_ROUGHNESS), t * t, 128);
            // 2 c dc for c = t^2.
            let share = 4.0 * t * t * t / 128.0;
            // (1 - c)^5 less its mean, over its variance.
            let off = ((1.0 - t * t).powi(5) - GRAZING_MEAN) / GRAZING_VARIANCE;
            sum = [0, 1].map(|j| sum[j] + value[j] * share);
            slopes = [0, 1].map(|j| slopes[j] + value[j] * share * off);
        }
        average.push(packed(sum));
        grazing.push(packed([0.5 - 0.5 * slopes[0], slopes[1]]));
        let cloth = |column| sheen_albedo(width(SHEEN_MIN_ROUGHNESS), cosine(column), 192);
        sheen.extend((0..SIDE).map(|column| stored(cloth(column))));
    }
    println!("//! Written by `examples/albedo_table.rs`. Values are in steps of 1 / 65535.");
    let by = "rows of even steps of roughness, columns of even steps of the cosine's square root";
    let factors = "the factor of the reflectance head on in the low half of a word, that of the one at grazing incidence in the high half";
    print("GGX", &format!("The GGX lobe, {by}: {factors}."), &ggx);
    print(
        "GGX_AVERAGE",
        "Cosine-weighted means of the rows of [`GGX`].",
        &average,
    );
    print(
        "GGX_GRAZING",
        "Slopes of the factors of [`GGX`] by `(1 - c)^5`, least squares over a hemisphere: half of 1 less the first one, and the second one.",
        &grazing,
    );
    print("SHEEN", &format!("White sheen, {by}."), &sheen);
}
