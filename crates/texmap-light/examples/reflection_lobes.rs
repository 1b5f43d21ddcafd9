//! Prints `src/reflection_lobes/table.rs`:
//! `cargo run --release -p texmap-light --example reflection_lobes > table.rs`, then moved there.
//!
//! The GGX lobe of a surface seen aslant, `D V (N.L)` over the hemisphere, as a sum of lobes as an environment light holds them, seen head on, and the cosine
//! about the normal: least squares, weighted as chi-square is, with weights that are not negative and sum to 1. Neighbouring entries
//! start from each other, so that the table is smooth between them.
#![allow(clippy::print_stdout, reason = "the table goes to standard output")]

use std::f64::consts::PI;

use texmap_light::{EnvironmentLight, MIN_ROUGHNESS};
use texmap_math::glam::DVec3;

/// Even steps of roughness, and of the cosine's square root.
const ROWS: usize = 31;
const COLUMNS: usize = 16;
const LOBES: usize = 4;
/// From this roughness on one lobe less is enough.
const ALL_LOBES_TO: f64 = 0.49;
/// Leans and factors of roughness.
const PARAMETERS: usize = 2 * LOBES;
const TERMS: usize = LOBES + 1;
/// Below this roughness the tail of the lobe is left to the lobes.
const EVEN_FROM: f64 = 0.3;
/// Least and largest lean, and factor of roughness.
const RANGES: [(f64, f64); 2] = [(-1.5, 1.0), (0.5, 1.0)];

fn main() {
    let table = table();
    println!("//! Written by `examples/reflection_lobes.rs`.");
    println!(
        "\n/// Rows of even steps of roughness, columns of even steps of the cosine's square root. A word for each lobe holds its lean in"
    );
    println!(
        "/// the low 12 bits, -1.5 to 1, then its factor of roughness in 10 bits, 0.5 to 1, and its weight in 10 bits, 0 to 1."
    );
    println!(
        "#[rustfmt::skip]\npub(super) static LOBES: [[u32; {}]; {LOBES}] = [",
        ROWS * COLUMNS
    );
    for lobe in 0..LOBES {
        println!("    [");
        for row in &table {
            let row: Vec<String> = row
                .iter()
                .map(|entry| format!("{:#x}", entry.word(lobe)))
                .collect();
            println!("        {},", row.join(", "));
        }
        println!("    ],");
    }
    println!("];");
}

#[derive(Clone, Copy)]
struct Entry {
    /// Leans, then factors of roughness.
    parameters: [f64; PARAMETERS],
    weights: [f64; TERMS],
}

impl Entry {
    fn word(&self, k: usize) -> u32 {
        let step = |x: f64, (low, high): (f64, f64), most: f64| {
            ((x - low) / (high - low) * most).round().clamp(0.0, most) as u32
        };
        let lean = step(self.parameters[k], RANGES[0], 4095.0);
        let factor = step(self.parameters[LOBES + k], RANGES[1], 1023.0);
        // Rounded down: their sum is at most 1.
        let weight = (self.weights[k] * 1023.0).clamp(0.0, 1023.0) as u32;
        lean | factor << 12 | weight << 22
    }

    fn middle(&self, other: &Self) -> Self {
        Self {
            parameters: std::array::from_fn(|k| 0.5 * (self.parameters[k] + other.parameters[k])),
            weights: std::array::from_fn(|k| 0.5 * (self.weights[k] + other.weights[k])),
        }
    }
}

/// From the middle of the table outwards.
fn table() -> Vec<Vec<Entry>> {
    let roughness =
        |row: usize| (row as f64 / (ROWS - 1) as f64).max(2.0 * f64::from(MIN_ROUGHNESS));
    let cosine = |column: usize| (column as f64 / (COLUMNS - 1) as f64).powi(2).max(2e-3);
    let (first_row, first_column) = (ROWS * 2 / 5, COLUMNS * 3 / 5);
    let width = roughness(first_row).powi(2);
    let place = |k: usize| (k as f64 + 0.5) / LOBES as f64 * 2.0 - 1.0;
    let parameters = std::array::from_fn(|k| match k {
        0..LOBES => -place(k) * width * 2.4 + width * roughness(first_row),
        _ => 0.8,
    });
    let mut weights = [1.0 / LOBES as f64; TERMS];
    weights[LOBES] = 0.0;
    let start = Entry {
        parameters,
        weights,
    };
    let mut table = vec![vec![start; COLUMNS]; ROWS];
    let outwards = |first: usize, count: usize| (first..count).chain((0..first).rev());
    for row in outwards(first_row, ROWS) {
        let before = if row > first_row {
            row.wrapping_sub(1)
        } else {
            row + 1
        };
        for column in outwards(first_column, COLUMNS) {
            let beside = if column > first_column {
                column.wrapping_sub(1)
            } else {
                column + 1
            };
            let start = match (row == first_row, column == first_column) {
                (true, true) => None,
                (true, false) => Some(table[row][beside]),
                (false, true) => Some(table[before][column]),
                (false, false) => Some(table[before][column].middle(&table[row][beside])),
            };
            let fit = Fit::new(roughness(row), cosine(column));
            table[row][column] = match start {
                Some(near) => fit.near(&near, 0.01),
                None => fit.near(&table[row][column], 0.0),
            };
        }
    }
    table
}

/// The lobe of a roughness seen at a cosine, at directions with their solid angles.
struct Fit {
    roughness: f64,
    mirrored: DVec3,
    directions: Vec<DVec3>,
    lobe: Vec<f64>,
    /// Square roots of the weights of squares.
    scales: Vec<f64>,
}

impl Fit {
    fn new(roughness: f64, cosine: f64) -> Self {
        let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let width = roughness * roughness;
        let (across, around) = (40usize, 2000usize);
        let wide = 2.0 * width * width;
        let density = |l: DVec3| {
            let h = (l + view).normalize_or_zero();
            let q = h.z * h.z * (wide - 1.0) + 1.0;
            let of_half = if h.z > 0.0 {
                wide / (PI * q * q) * h.z
            } else {
                0.0
            };
            (across * across) as f64 * of_half / (4.0 * h.dot(view)).max(1e-6)
                + around as f64 / (4.0 * PI)
        };
        // Mirrored about slopes of a wider GGX, and even over the sphere.
        let slopes = (0..across * across).filter_map(|k| {
            let at = |k: usize| (k as f64 + 0.5) / across as f64;
            let (u, turn) = (at(k / across), 2.0 * PI * at(k % across));
            let slope = (wide * u / (1.0 - u)).sqrt();
            let h = DVec3::new(slope * turn.cos(), slope * turn.sin(), 1.0).normalize();
            (h.dot(view) > 0.0).then(|| 2.0 * h.dot(view) * h - view)
        });
        let even = (0..around).map(|k| {
            let z = 1.0 - 2.0 * (k as f64 + 0.5) / around as f64;
            let (s, turn) = (
                (1.0 - z * z).sqrt(),
                (k as f64 + 0.5) * 2.399_963_229_728_653,
            );
            DVec3::new(s * turn.cos(), s * turn.sin(), z)
        });
        let directions: Vec<DVec3> = slopes.chain(even).collect();
        let angles: Vec<f64> = directions.iter().map(|d| 1.0 / density(*d)).collect();
        let mut lobe: Vec<f64> = directions.iter().map(|l| ggx(width, view, *l)).collect();
        let sum: f64 = lobe.iter().zip(&angles).map(|(w, a)| w * a).sum();
        lobe.iter_mut().for_each(|w| *w /= sum);
        let most = lobe.iter().fold(0.0, |m: f64, w| m.max(*w));
        // Bright windows show the tails of narrow lobes.
        let tail = if roughness < ALL_LOBES_TO { 0.01 } else { 0.1 };
        let scale = |(w, a): (&f64, &f64)| (a / (w + tail * most)).sqrt();
        let mut scales: Vec<f64> = lobe.iter().zip(&angles).map(scale).collect();
        let whole: f64 = lobe.iter().zip(&scales).map(|(w, s)| (w * s).powi(2)).sum();
        scales.iter_mut().for_each(|s| *s /= whole.sqrt());
        Self {
            roughness,
            mirrored: DVec3::new(-view.x, 0.0, view.z),
            directions,
            lobe,
            scales,
        }
    }

    /// The terms of a fit, each of sum 1, scaled.
    fn terms(&self, parameters: &[f64; PARAMETERS]) -> Vec<[f64; TERMS]> {
        let lobes: [(DVec3, [(f64, f64); 2]); LOBES] = std::array::from_fn(|k| {
            let lean = parameters[k];
            let axis = (self.mirrored * (1.0 - lean) + DVec3::Z * lean).normalize();
            (axis, levels(parameters[LOBES + k] * self.roughness))
        });
        let of = |(d, scale): (&DVec3, &f64)| {
            let mut terms = [0.0; TERMS];
            for (term, (axis, levels)) in terms.iter_mut().zip(lobes) {
                let level = |(width, share): (f64, f64)| head_on(width, d.dot(axis)) * share;
                *term = levels.map(level).iter().sum::<f64>() * scale;
            }
            terms[LOBES] = d.z.max(0.0) / PI * scale;
            terms
        };
        self.directions.iter().zip(&self.scales).map(of).collect()
    }

    /// Weights and residuals at parameters. The weights lean to others.
    fn residuals(
        &self,
        parameters: &[f64; PARAMETERS],
        near: &[f64; TERMS],
    ) -> ([f64; TERMS], Vec<f64>) {
        let terms = self.terms(parameters);
        let fitted = |term: usize| match term {
            LOBES => self.roughness > EVEN_FROM,
            _ => term < LOBES - 1 || self.roughness < ALL_LOBES_TO,
        };
        let fitted: Vec<usize> = (0..TERMS).filter(|term| fitted(*term)).collect();
        // Normal equations, the sum of 1 as a heavy row.
        let mut matrix = [[900.0; TERMS]; TERMS];
        let mut right = [900.0; TERMS];
        for (terms, (lobe, scale)) in terms.iter().zip(self.lobe.iter().zip(&self.scales)) {
            for &j in &fitted {
                right[j] += terms[j] * lobe * scale;
                for &k in &fitted {
                    matrix[j][k] += terms[j] * terms[k];
                }
            }
        }
        for &k in &fitted {
            matrix[k][k] += 0.05f64.powi(2);
            right[k] += 0.05f64.powi(2) * near[k];
        }
        // Not negative: coordinate descent.
        let mut weights: [f64; TERMS] =
            std::array::from_fn(|k| if fitted.contains(&k) { near[k] } else { 0.0 });
        for _ in 0..3000 {
            for &j in &fitted {
                let others = fitted.iter().filter(|k| **k != j);
                let rest: f64 = others.map(|&k| matrix[j][k] * weights[k]).sum();
                weights[j] = ((right[j] - rest) / matrix[j][j]).max(0.0);
            }
        }
        let sum: f64 = weights.iter().sum();
        let weights = weights.map(|w| w / sum);
        let residual = |(terms, (lobe, scale)): (&[f64; TERMS], (&f64, &f64))| {
            terms.iter().zip(weights).map(|(t, w)| t * w).sum::<f64>() - lobe * scale
        };
        (
            weights,
            terms
                .iter()
                .zip(self.lobe.iter().zip(&self.scales))
                .map(residual)
                .collect(),
        )
    }

    /// Damped Gauss-Newton steps from another entry, drawn back to it.
    fn near(&self, start: &Entry, pull: f64) -> Entry {
        let within = |p: [f64; PARAMETERS]| -> [f64; PARAMETERS] {
            std::array::from_fn(|k| {
                let (low, high) = RANGES[k / LOBES];
                p[k].clamp(low, high)
            })
        };
        let begin = within(start.parameters);
        let cost = |p: &[f64; PARAMETERS], residuals: &[f64]| {
            let drawn: f64 = p
                .iter()
                .zip(begin)
                .map(|(p, b)| (pull * (p - b)).powi(2))
                .sum();
            residuals.iter().map(|r| r * r).sum::<f64>() + drawn
        };
        let mut at = begin;
        let (mut weights, mut residuals) = self.residuals(&at, &start.weights);
        let mut damping = 1e-3;
        for _ in 0..40 {
            let columns: Vec<Vec<f64>> = (0..PARAMETERS)
                .map(|k| {
                    let mut moved = at;
                    moved[k] += 1e-4;
                    let (_, there) = self.residuals(&moved, &start.weights);
                    there
                        .iter()
                        .zip(&residuals)
                        .map(|(a, b)| (a - b) * 1e4)
                        .collect()
                })
                .collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let mut system = [[0.0; PARAMETERS + 1]; PARAMETERS];
            for j in 0..PARAMETERS {
                for k in 0..PARAMETERS {
                    system[j][k] = dot(&columns[j], &columns[k]);
                }
                system[j][j] += pull * pull + damping;
                system[j][PARAMETERS] =
                    -dot(&columns[j], &residuals) - pull * pull * (at[j] - begin[j]);
            }
            let step = solved(system);
            let next = within(std::array::from_fn(|k| at[k] + step[k]));
            let (new_weights, new) = self.residuals(&next, &start.weights);
            let (old_cost, new_cost) = (cost(&at, &residuals), cost(&next, &new));
            if new_cost < old_cost {
                (at, weights, residuals) = (next, new_weights, new);
                damping = (damping * 0.3).max(1e-9);
                if old_cost - new_cost < 1e-7 * old_cost {
                    break;
                }
            } else {
                damping *= 5.0;
                if damping > 1e3 {
                    break;
                }
            }
        }
        Entry {
            parameters: at,
            weights,
        }
    }
}

/// Gauss elimination of a positive definite system.
fn solved(mut m: [[f64; PARAMETERS + 1]; PARAMETERS]) -> [f64; PARAMETERS] {
    for k in 0..PARAMETERS {
        let pivot = m[k];
        for (j, row) in m.iter_mut().enumerate() {
            if j != k {
                let by = row[k] / pivot[k];
                for (c, p) in row.iter_mut().zip(pivot).skip(k) {
                    *c -= by * p;
                }
            }
        }
    }
    std::array::from_fn(|k| m[k][PARAMETERS] / m[k][k])
}

/// `D V (N.L)` of GGX with height-correlated Smith about +Z, but for a factor.
fn ggx(width: f64, view: DVec3, l: DVec3) -> f64 {
    if l.z <= 0.0 {
        return 0.0;
    }
    let h = (l + view).normalize();
    let a2 = width * width;
    let q = h.z * h.z * (a2 - 1.0) + 1.0;
    let smith = |a: f64, b: f64| a * (b * b * (1.0 - a2) + a2).sqrt();
    l.z / (q * q * (smith(l.z, view.z) + smith(view.z, l.z)))
}

/// Widths of the lobes of the two levels that an environment's light reads for a roughness, and their shares over their integrals.
fn levels(roughness: f64) -> [(f64, f64); 2] {
    let at = EnvironmentLight::level_of_roughness(roughness as f32);
    let last = EnvironmentLight::level_of_roughness(1.0);
    let low = at.floor().min(last - 1.0);
    [(low, 1.0 - (at - low)), (low + 1.0, at - low)].map(|(level, share)| {
        let roughness = f64::from(EnvironmentLight::roughness_of_level(level as usize));
        // The environment itself has no width; this is one too small to matter.
        let width = roughness.max(0.04).powi(2);
        (width, f64::from(share) / head_on_sum(width))
    })
}

/// The lobe of a width as seen head on, by the cosine from its axis, but for a factor.
fn head_on(width: f64, c: f64) -> f64 {
    let q = (1.0 - c).max(0.0) + (c + 1.0) * width * width;
    c.max(0.0) / (q * q)
}

/// Its integral over the sphere: with `q = p + r c`, that of `c / q^2`.
fn head_on_sum(width: f64) -> f64 {
    let a2 = width * width;
    let (p, r) = (1.0 + a2, a2 - 1.0);
    if r.abs() < 1e-6 {
        return PI / (p * p);
    }
    2.0 * PI / (r * r) * (((p + r) / p).ln() + p / (p + r) - 1.0)
}
