//! The planner's choice and the true error of the picture: `--max-error`, `--quality`, `--explain`, `--verify`.

use std::fmt::Write;
use std::str::FromStr;

use clap::ValueEnum;
use serde::Serialize;
use texmap_io::scene_file::words;
use texmap_light::ShadowBias;
use texmap_planner::{Budget, Choices, EnvironmentChoice, IdleLight, ShadowChoice};
use texmap_sample::Precision;
use texmap_scene::Scene;
use texmap_truth::ASSUMPTIONS;
use texmap_truth::metrics::figure;
use texmap_truth::verify::Verified;

use crate::cmd::render::RenderArgs;

/// Samples a side of a pixel in the reference of `--verify`.
pub(crate) const SAMPLES: u32 = 6;

/// `TEXELS` or `TEXELS,RMSE`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MaxError(Budget);

impl FromStr for MaxError {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (texels, rmse) = text
            .split_once(',')
            .map_or((text, None), |(t, r)| (t, Some(r)));
        let number = |text: &str| match text.trim().parse::<f64>() {
            Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
            _ => Err(
                "positive numbers, as in 0.5 (texels) or 0.5,0.02 (texels, colour RMSE of 1)"
                    .to_owned(),
            ),
        };
        let rmse = rmse.map_or(Ok(Budget::default().rmse), number)?;
        Ok(Self(Budget {
            texels: number(texels)?,
            rmse,
        }))
    }
}

/// Budgets with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Quality {
    /// 1 texel and a colour RMSE of 0.05
    Draft,
    /// 0.5 texels and 0.02
    Good,
    /// The methods of the scene, without a planner
    Exact,
}

impl RenderArgs {
    /// The budget, if the planner is to choose.
    pub(crate) fn budget(&self) -> Option<Budget> {
        match (self.max_error, self.quality) {
            (Some(MaxError(budget)), _) => Some(budget),
            (None, Some(Quality::Draft)) => Some(Budget {
                texels: 1.0,
                rmse: 0.05,
            }),
            (None, Some(Quality::Good)) => Some(Budget::default()),
            (None, Some(Quality::Exact) | None) => None,
        }
    }
}

/// The plan and its truth, for programs.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PlanReport {
    max_texels: f64,
    max_rmse: f64,
    pub(crate) met: bool,
    supersample: u32,
    choices: Vec<ChoiceReport>,
    idle_lights: Vec<IdleReport>,
    shadows: Vec<ShadowReport>,
    environments: Vec<EnvironmentReport>,
}

/// An environment or specular map.
#[derive(Clone, Debug, Serialize)]
struct EnvironmentReport {
    environment: usize,
    chart: &'static str,
    /// Of a face, in texels.
    width: u32,
    height: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    exponent: Option<f32>,
    /// Texels a side that the lobe needs.
    #[serde(skip_serializing_if = "Option::is_none")]
    needed: Option<u32>,
    why: String,
}

/// A light that is left out.
#[derive(Clone, Debug, Serialize)]
struct IdleReport {
    light: usize,
    why: &'static str,
}

/// A shadow map.
#[derive(Clone, Debug, Serialize)]
struct ShadowReport {
    light: usize,
    size: u32,
    bias: String,
    /// Predicted width of a texel at the middle of the scene.
    pixels: f64,
    why: &'static str,
}

#[derive(Clone, Debug, Serialize)]
struct ChoiceReport {
    mesh: usize,
    name: String,
    interp: String,
    filter: Option<String>,
    precision: Option<&'static str>,
    predicted_texels: f64,
    predicted_rmse: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    measured_rmse: Option<f64>,
    price_ns: f64,
    pixels_tried: usize,
    why: String,
    left_out: Vec<&'static str>,
}

/// The true error, for programs.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct TruthReport {
    rmse: f64,
    max: f64,
    max_at: Option<(u32, u32)>,
    pixels_judged: usize,
    outline_pixels: usize,
    shadow_edge_pixels: usize,
    shadow_edge_rmse: f64,
    samples: u32,
    /// Assumptions of the reference.
    assumes: &'static str,
    pub(crate) heat: Option<String>,
}

impl PlanReport {
    pub(crate) fn new(scene: &Scene, choices: &Choices, truth: Option<&Verified>) -> Self {
        let report = |c: &texmap_planner::Choice| ChoiceReport {
            mesh: c.mesh,
            name: scene.meshes[c.mesh].name.clone(),
            interp: words::interp(c.interp),
            filter: c.filter.and_then(|(filter, _)| words::filter(filter)),
            precision: c.filter.map(|(_, precision)| match precision {
                Precision::Exact => "exact",
                Precision::Fast => "fast",
            }),
            predicted_texels: c.predicted_texels,
            predicted_rmse: c.predicted_rmse,
            measured_rmse: truth.and_then(|t| t.meshes.get(c.mesh).copied().flatten()),
            price_ns: c.price,
            pixels_tried: c.tried,
            why: c.why.clone(),
            left_out: c.left_out.clone(),
        };
        let idle = |l: &IdleLight| IdleReport {
            light: l.light,
            why: l.why,
        };
        let shadow = |s: &ShadowChoice| ShadowReport {
            light: s.light,
            size: s.size,
            bias: match s.bias {
                ShadowBias::Constant(c) => format!("constant {}", figure(c)),
                ShadowBias::Planes(c) => format!("planes and {}", figure(c)),
                ShadowBias::Slope(c) => format!("slope and {}", figure(c)),
                other => format!("{other:?}"),
            },
            pixels: s.pixels,
            why: if s.fixed {
                "the scene's size"
            } else {
                "about a texel for a pixel at the middle of the scene, 256 to 4096"
            },
        };
        let environment = |e: &EnvironmentChoice| EnvironmentReport {
            environment: e.environment,
            chart: e.chart.name(),
            width: e.size.0,
            height: e.size.1,
            exponent: e.exponent,
            needed: e.needed,
            why: e.why.clone(),
        };
        Self {
            max_texels: choices.budget.texels,
            max_rmse: choices.budget.rmse,
            met: choices.met(),
            supersample: choices.supersample,
            choices: choices.meshes.iter().map(report).collect(),
            idle_lights: choices.idle_lights.iter().map(idle).collect(),
            shadows: choices.shadows.iter().map(shadow).collect(),
            environments: choices.environments.iter().map(environment).collect(),
        }
    }

    /// The table of `--explain`.
    pub(crate) fn table(&self) -> String {
        let n = self.supersample;
        let mut out = format!(
            "budget: {} texels, colour RMSE {}; {n} x {n} samples a pixel\n",
            figure(self.max_texels),
            figure(self.max_rmse)
        );
        let _ = writeln!(
            out,
            "{:<14} {:<12} {:<24} {:>9} {:>9} {:>8}  why; left out",
            "mesh", "interp", "filter", "predicted", "measured", "ns"
        );
        for c in &self.choices {
            let filter = match (&c.filter, c.precision) {
                (Some(name), Some("fast")) => format!("{name}, fast"),
                (Some(name), _) => name.clone(),
                (None, _) => "none".to_owned(),
            };
            let name = if c.name.is_empty() {
                format!("#{}", c.mesh)
            } else {
                c.name.clone()
            };
            let left_out = if c.left_out.is_empty() {
                "nothing".to_owned()
            } else {
                c.left_out.join(", ")
            };
            let _ = writeln!(
                out,
                "{:<14} {:<12} {filter:<24} {:>9} {:>9} {:>8}  {}; {left_out}",
                name.chars().take(14).collect::<String>(),
                c.interp,
                figure(c.predicted_rmse),
                c.measured_rmse.map_or_else(|| "-".to_owned(), figure),
                figure(c.price_ns),
                c.why,
            );
        }
        for s in &self.shadows {
            let _ = writeln!(
                out,
                "shadow map of light {}: {} texels a side, bias {}; predicted edges of {} pixels; {}",
                s.light,
                s.size,
                s.bias,
                figure(s.pixels),
                s.why
            );
        }
        for e in &self.environments {
            let _ = writeln!(
                out,
                "environment {}: {}, {} x {} texels a face; {}",
                e.environment, e.chart, e.width, e.height, e.why
            );
        }
        for l in &self.idle_lights {
            let _ = writeln!(out, "light {} is left out: {}", l.light, l.why);
        }
        out
    }
}

impl TruthReport {
    pub(crate) fn new(truth: &Verified, heat: Option<String>) -> Self {
        Self {
            rmse: truth.rmse,
            max: truth.max,
            max_at: truth.max_at,
            pixels_judged: truth.judged,
            outline_pixels: truth.outlines,
            shadow_edge_pixels: truth.shadow_edges,
            shadow_edge_rmse: truth.shadow_rmse,
            samples: SAMPLES,
            assumes: ASSUMPTIONS,
            heat,
        }
    }

    pub(crate) fn words(&self) -> String {
        let place = self
            .max_at
            .map_or_else(String::new, |(x, y)| format!(" at x {x}, y {y}"));
        let edges = match self.shadow_edge_pixels {
            0 => String::new(),
            n => format!(
                ", {n} at edges of shadows, where the RMSE is {}",
                figure(self.shadow_edge_rmse)
            ),
        };
        format!(
            "true error: RMSE {} of 1, largest {}{place}, over {} pixels (left out: {} at outlines{edges}), against {SAMPLES} x {SAMPLES} samples in f64\n\
             assumed true: {}\n",
            figure(self.rmse),
            figure(self.max),
            self.pixels_judged,
            self.outline_pixels,
            self.assumes,
        )
    }

    /// Message for an error that is larger than the budget of a plan.
    pub(crate) fn over(&self, plan: &PlanReport) -> Option<String> {
        (self.rmse > plan.max_rmse).then(|| {
            format!(
                "the true RMSE {} is over the budget of {}",
                figure(self.rmse),
                figure(plan.max_rmse)
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_positive_numbers() {
        let budget = |text: &str| text.parse::<MaxError>().map(|m| (m.0.texels, m.0.rmse));
        assert_eq!(budget("0.5"), Ok((0.5, 0.02)));
        assert_eq!(budget("1, 0.05"), Ok((1.0, 0.05)));
        for bad in ["", "0", "-1", "nan", "0.5,", "0.5,inf", "a"] {
            assert!(budget(bad).is_err(), "{bad}");
        }
    }
}
