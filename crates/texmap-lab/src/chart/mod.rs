//! The chart: speed against accuracy, one small chart for each scene class, never an average over scenes.
//!
//! Every method with its parameters is a [`Point`]: its time per item on one thread ([`time`]) and its error against
//! an f64 reference or a closed form. A method that breaks on the stability inputs of its panel is drawn hollow and
//! cannot be on the front.

mod bump;
mod environment;
mod external;
mod filter;
mod front;
mod interp;
mod machine;
mod memory;
mod page;
mod plane_scenes;
mod scene;
mod shadow;
mod spans;
mod svg;
mod table;
pub mod time;

pub use external::{ExternalPoint, external_csv};
pub use front::{dominator, front};
pub use interp::QuadScene;
pub use machine::Machine;
pub use page::page;
pub use plane_scenes::{PlaneScene, decal_scene};
pub use svg::svg;
pub use table::{csv, prices};

use crate::LabError;
use texmap_truth::picture::Picture;
use time::{Effort, Time};

/// One method with its parameters on one scene.
#[derive(Clone, Debug)]
pub struct Point {
    /// Name and parameters, as on the command line where it has one: `anisotropic:16`.
    pub method: String,
    /// Home of the method.
    pub source: Source,
    /// Nanoseconds an item on one thread; none for a method that was not timed in this run.
    pub time: Option<Time>,
    /// Error against the truth.
    pub error: Error,
    /// Bytes of the tables that the method reads, where that is the question.
    pub bytes: Option<u64>,
    /// Failures with their counts: a point with any is hollow.
    pub failures: Vec<String>,
    /// The method's picture of the scene, beside its error.
    pub picture: Option<Picture>,
}

/// Home of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// In one of the published crates.
    Texmap,
    /// Only here, for comparison.
    Lab,
    /// Another program.
    External,
}

impl Source {
    /// The lab, or else texmap.
    fn of_lab(lab: bool) -> Self {
        if lab { Self::Lab } else { Self::Texmap }
    }
}

/// Errors over the items of a scene, in the chart's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Error {
    /// Root mean square.
    pub rmse: f64,
    /// The 99.9 % quantile.
    pub p999: f64,
    /// Largest.
    pub max: f64,
}

impl Error {
    /// From the error of each item. A NaN counts as infinite.
    pub fn of(errors: impl IntoIterator<Item = f64>) -> Self {
        let sane = |e: f64| if e.is_nan() { f64::INFINITY } else { e.abs() };
        let mut all: Vec<f64> = errors.into_iter().map(sane).collect();
        if all.is_empty() {
            return Self::default();
        }
        let squares: f64 = all.iter().map(|e| e * e).sum();
        let rmse = (squares / all.len() as f64).sqrt();
        let p999 = texmap_truth::metrics::quantile(&mut all, 0.999);
        Self {
            rmse,
            p999,
            max: all.iter().copied().fold(0.0, f64::max),
        }
    }
}

/// Quantity of the horizontal axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Nanoseconds an item.
    Time,
    /// Bytes.
    Bytes,
}

/// One scene class of a panel.
#[derive(Clone, Debug)]
pub struct SceneChart {
    /// Short name, unique: part of file names.
    pub id: String,
    /// The drawn scene.
    pub title: String,
    /// The reference of the errors, and the items that they are taken over.
    pub truth: String,
    /// One item: a covered pixel, a look-up.
    pub item: &'static str,
    /// Unit of the error.
    pub unit: &'static str,
    /// The horizontal axis.
    pub across: Across,
    /// Every method.
    pub points: Vec<Point>,
}

/// A group of charts.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Short name.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Introduction to the charts.
    pub about: &'static str,
    /// One for each scene class.
    pub charts: Vec<SceneChart>,
}

/// Progress: steps done, of how many, and what comes next.
pub type Report<'a> = &'a mut dyn FnMut(usize, usize, &str);

type Builder = fn(Effort) -> Result<Panel, LabError>;

const PANELS: &[(&str, Builder)] = &[
    ("interpolation", interp::panel),
    ("filtering", filter::panel),
    ("environment charts", environment::panel),
    ("shadows", shadow::panel),
    ("bump", bump::panel),
    ("memory", memory::panel),
];

/// Measures all six panels. Other programs stand in them at the error that `external.csv` holds.
///
/// # Errors
/// If a scene is refused, which would be a bug.
pub fn panels(effort: Effort, report: Report<'_>) -> Result<Vec<Panel>, LabError> {
    let mut out = Vec::with_capacity(PANELS.len());
    for (index, (name, build)) in PANELS.iter().enumerate() {
        report(index, PANELS.len(), name);
        let mut panel = build(effort)?;
        for chart in &mut panel.charts {
            chart.points.extend(external::points(&chart.id));
        }
        out.push(panel);
    }
    report(PANELS.len(), PANELS.len(), "done");
    Ok(out)
}

pub use scene::panel as scene_panel;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_numbers() {
        let e = Error::of([3.0, -4.0]);
        assert_eq!((e.rmse, e.p999, e.max), (12.5f64.sqrt(), 4.0, 4.0));
        assert_eq!(Error::of([f64::NAN]).max, f64::INFINITY);
        assert_eq!(Error::of([]), Error::default());
    }
}
