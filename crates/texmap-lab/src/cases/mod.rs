//! The failure cases: inputs on which rasterizers, interpolators and samplers are known to break, each with
//! the figure that is still acceptable.
//!
//! A file of cases ([`parse`]) says what is put in, what must come out and how good is good enough; a runner
//! of the same id ([`run`]) measures texmap's public API and, beside it, the naive methods that must fail.

/// A table of measurements: `method, measure => value;` a row.
macro_rules! measured {
    ($($method:expr, $measure:expr => $value:expr;)*) => {
        vec![$($crate::cases::Measurement::new($method, $measure, $value)),*]
    };
}

mod bump;
mod environment;
mod footprint;
mod interp;
mod naive;
mod probe;
mod raster;
mod sampler;
mod shading;
mod shadows;
mod shapes;
mod summed_area;
mod table;
mod uv;
mod volume;

use serde::Deserialize;

pub use probe::Random;
pub(crate) use probe::{SENSELESS, visit};
pub use table::{Outcome, markdown};

use crate::LabError;

/// One failure case of a file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Short id: R for the rasterizer, I for interpolation, S for the sampler, U for the uv mapper, P for
    /// projective textures, H for shadows, E for environment and light maps, B for bumps, displacement and tangents, L for
    /// where light is computed, G for
    /// moved, bent and turned shapes, V for volumes, solid textures and ramps.
    pub id: String,
    /// The input.
    pub input: String,
    /// The expected output.
    pub expected: String,
    /// The figures that are demanded.
    #[serde(rename = "check")]
    pub checks: Vec<Check>,
}

/// A figure that is demanded of a method.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// The method measured; a naive one has `must_fail`.
    pub method: String,
    /// The measured quantity, with its unit.
    pub measure: String,
    /// Largest value that is accepted.
    pub limit: Option<f64>,
    /// Smallest value that is accepted.
    pub at_least: Option<f64>,
    /// The value that theory gives; the measured one must lie within `within` (relative) of it.
    pub figure: Option<f64>,
    /// Relative tolerance of `figure`, 0.01 if not given.
    pub within: Option<f64>,
    /// The method is naive on purpose: `limit` and `at_least` must NOT both be met.
    #[serde(default)]
    pub must_fail: bool,
}

impl Check {
    /// True if a measured value meets the check. NaN meets no bound.
    pub fn holds(&self, value: f64) -> bool {
        let figure = self
            .figure
            .is_none_or(|f| (value - f).abs() <= self.within.unwrap_or(0.01) * f.abs());
        let bounds =
            self.limit.is_none_or(|l| value <= l) && self.at_least.is_none_or(|l| value >= l);
        figure && bounds != self.must_fail
    }
}

/// A figure that a runner has measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The method measured.
    pub method: String,
    /// The measured quantity, with its unit.
    pub measure: String,
    /// The figure.
    pub value: f64,
}

impl Measurement {
    fn new(method: &str, measure: impl Into<String>, value: f64) -> Self {
        Self {
            method: method.into(),
            measure: measure.into(),
            value,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "case")]
    cases: Vec<Case>,
}

/// The cases that the program carries: `cases.toml` of this package.
///
/// # Errors
/// If the file does not fit its schema.
pub fn all() -> Result<Vec<Case>, LabError> {
    parse(include_str!("../../cases.toml"))
}

/// Reads a file of cases.
///
/// # Errors
/// If the text is not TOML of this schema, an id comes twice, or a check demands nothing.
pub fn parse(text: &str) -> Result<Vec<Case>, LabError> {
    let file: File = toml::from_str(text).map_err(|error| LabError::Cases(error.to_string()))?;
    for (index, case) in file.cases.iter().enumerate() {
        let id = &case.id;
        if file.cases[..index].iter().any(|earlier| earlier.id == *id) {
            return Err(LabError::Cases(format!("the id '{id}' is given twice")));
        }
        if case.checks.is_empty() {
            return Err(LabError::Cases(format!("case '{id}' has no check")));
        }
        for check in &case.checks {
            let Check {
                method,
                measure,
                limit,
                at_least,
                figure,
                ..
            } = check;
            let bounded = limit.is_some() || at_least.is_some();
            if !(bounded || figure.is_some() && !check.must_fail) {
                return Err(LabError::Cases(format!(
                    "case '{id}', {method}, {measure}: give limit, at_least or figure (must_fail needs a bound)"
                )));
            }
        }
    }
    Ok(file.cases)
}

type Runner = fn() -> Result<Vec<Measurement>, LabError>;

/// Every case that can be run, in the order of the file.
const RUNNERS: &[(&str, Runner)] = &[
    ("R1", raster::r1),
    ("R2", raster::r2),
    ("R3", raster::r3),
    ("R4", raster::r4),
    ("R5", raster::r5),
    ("R6", raster::r6),
    ("R7", raster::r7),
    ("R8", raster::r8),
    ("I1", interp::i1),
    ("I2", interp::i2),
    ("I3", interp::i3),
    ("I4", interp::i4),
    ("I5", interp::i5),
    ("I6", interp::i6),
    ("S1", sampler::s1),
    ("S2", sampler::s2),
    ("S3", sampler::s3),
    ("S4", sampler::s4),
    ("S5", sampler::s5),
    ("S6", footprint::s6),
    ("S7", footprint::s7),
    ("S8", footprint::s8),
    ("S9", footprint::s9),
    ("S10", sampler::s10),
    ("S11", summed_area::s11),
    ("U1", uv::u1),
    ("U2", uv::u2),
    ("U3", uv::u3),
    ("U4", uv::u4),
    ("U5", uv::u5),
    ("B4", uv::b4),
    ("P1", shadows::p1),
    ("P2", shadows::p2),
    ("P3", shadows::p3),
    ("H1", shadows::h1),
    ("H2", shadows::h2),
    ("H3", shadows::h3),
    ("H4", shadows::h4),
    ("H5", shadows::h5),
    ("H6", shadows::h6),
    ("H7", shadows::h7),
    ("E1", environment::e1),
    ("E2", environment::e2),
    ("E3", environment::e3),
    ("E4", environment::e4),
    ("E5", environment::e5),
    ("E6", environment::e6),
    ("E7", environment::e7),
    ("B1", bump::b1),
    ("B2", bump::b2),
    ("B3", bump::b3),
    ("B5", bump::b5),
    ("B6", bump::b6),
    ("B7", shapes::b7),
    ("L1", shading::l1),
    ("G1", shapes::g1),
    ("G2", shapes::g2),
    ("G3", shapes::g3),
    ("G4", shapes::g4),
    ("V1", volume::v1),
    ("V2", volume::v2),
    ("V3", volume::v3),
    ("V4", volume::v4),
    ("V5", volume::v5),
    ("V6", volume::v6),
];

/// Ids of the cases that can be run.
pub fn ids() -> impl Iterator<Item = &'static str> {
    RUNNERS.iter().map(|&(id, _)| id)
}

/// Measures one case: texmap's own methods and the naive ones.
///
/// # Errors
/// If no runner has this id.
pub fn run(id: &str) -> Result<Vec<Measurement>, LabError> {
    let (_, runner) = RUNNERS
        .iter()
        .find(|(known, _)| *known == id)
        .ok_or_else(|| LabError::UnknownCase(id.to_owned()))?;
    runner()
}

/// A demand of a case beside what was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The demand.
    pub check: Check,
    /// The figure; none when the runner has not measured it.
    pub measured: Option<f64>,
}

impl Verdict {
    /// True if the figure meets the case: a naive method passes by failing.
    pub fn passes(&self) -> bool {
        self.measured.is_some_and(|value| self.check.holds(value))
    }
}

/// Runs a case and judges each of its demands.
///
/// # Errors
/// If no runner has the id, the runner fails, or it measures something of which nothing is demanded.
pub fn judge(case: &Case) -> Result<Vec<Verdict>, LabError> {
    let measured = run(&case.id)?;
    let same = |m: &Measurement, c: &Check| m.method == c.method && m.measure == c.measure;
    if let Some(m) = measured
        .iter()
        .find(|m| !case.checks.iter().any(|c| same(m, c)))
    {
        return Err(LabError::Cases(format!(
            "case '{}': nothing is demanded of {}, {} = {}",
            case.id, m.method, m.measure, m.value
        )));
    }
    let verdict = |check: &Check| Verdict {
        check: check.clone(),
        measured: measured.iter().find(|m| same(m, check)).map(|m| m.value),
    };
    Ok(case.checks.iter().map(verdict).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "[[case]]\nid = \"X\"\ninput = \"i\"\nexpected = \"e\"\n";

    fn check(fields: &str) -> Result<Vec<Case>, LabError> {
        parse(&format!(
            "{HEAD}check = [{{ method = \"m\", measure = \"x\", {fields} }}]"
        ))
    }

    #[test]
    fn a_check_holds_by_its_bounds() {
        let one = |fields: &str| check(fields).unwrap().remove(0).checks.remove(0);
        let limit = one("limit = 1.0");
        assert!(limit.holds(1.0) && !limit.holds(1.1) && !limit.holds(f64::NAN));
        let both = one("limit = 2.0, at_least = 1.0");
        assert!(both.holds(1.5) && !both.holds(0.5));
        let naive = one("limit = 1.0, must_fail = true");
        assert!(!naive.holds(1.0) && naive.holds(1.1) && naive.holds(f64::NAN));
        let figure = one("figure = -100.0, within = 0.1");
        assert!(figure.holds(-91.0) && !figure.holds(-89.0) && !figure.holds(f64::NAN));
    }

    #[test]
    fn a_file_that_demands_nothing_is_refused() {
        for bad in [
            "must_fail = true",
            "within = 0.1",
            "must_fail = true, figure = 1.0",
        ] {
            assert!(check(bad).is_err(), "{bad}");
        }
        assert!(check("limit = 1.0, speed = 2.0").is_err(), "an unknown key");
        assert!(
            parse("[[case]]\nid = \"X\"\ninput = \"\"\nexpected = \"\"\ncheck = []\n").is_err()
        );
        let twice =
            format!("{HEAD}check = [{{ method = \"m\", measure = \"x\", limit = 1 }}]\n").repeat(2);
        assert!(parse(&twice).unwrap_err().to_string().contains("twice"));
    }
}
