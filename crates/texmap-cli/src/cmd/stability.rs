//! `texmap stability`: the inputs on which methods fail, measured on this machine.

use clap::Args;
use serde::Serialize;
use texmap_lab::cases::{self, Case, Outcome, Verdict};

use crate::failure::{self, Exit, Failure, say_always};
use crate::progress::Progress;

/// Run the failure cases: inputs, demands, and the results of every method.
#[derive(Args, Debug)]
#[command(
    after_help = "Prints Markdown tables. Naive methods must fail, visibly. Exit code 1 when a demand is not met."
)]
pub(crate) struct StabilityArgs {
    /// Cases to run, such as R1 or S5; all if none is named
    #[arg(value_name = "CASE")]
    ids: Vec<String>,
    /// Print JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    texmap: &'static str,
    schema: u32,
    verb: &'static str,
    passes: bool,
    cases: Vec<CaseReport<'a>>,
}

#[derive(Serialize)]
struct CaseReport<'a> {
    id: &'a str,
    input: &'a str,
    expected: &'a str,
    passes: bool,
    checks: Vec<CheckReport<'a>>,
}

#[derive(Serialize)]
struct CheckReport<'a> {
    method: &'a str,
    naive: bool,
    measure: &'a str,
    limit: Option<f64>,
    at_least: Option<f64>,
    figure: Option<f64>,
    /// The figure; `null` if it is not finite, which `measured_text` tells.
    measured: Option<f64>,
    measured_text: Option<String>,
    verdict: &'static str,
    passes: bool,
}

impl<'a> From<&'a Verdict> for CheckReport<'a> {
    fn from(verdict: &'a Verdict) -> Self {
        let check = &verdict.check;
        Self {
            method: &check.method,
            naive: check.must_fail,
            measure: &check.measure,
            limit: check.limit,
            at_least: check.at_least,
            figure: check.figure,
            measured: verdict.measured,
            measured_text: verdict.measured.map(texmap_truth::metrics::figure),
            verdict: verdict.word(),
            passes: verdict.passes(),
        }
    }
}

pub(crate) fn run(args: &StabilityArgs) -> Result<Exit, Failure> {
    let internal = |e: texmap_lab::LabError| Failure::from(e);
    let all = cases::all().map_err(internal)?;
    if let Some(unknown) = args.ids.iter().find(|id| !all.iter().any(|c| c.id == **id)) {
        let known: Vec<&str> = all.iter().map(|c| c.id.as_str()).collect();
        return Err(Failure::usage(
            format!("unknown case `{unknown}`"),
            format!("choose from {}", known.join(", ")),
        ));
    }
    let chosen: Vec<&Case> = all
        .iter()
        .filter(|c| args.ids.is_empty() || args.ids.contains(&c.id))
        .collect();
    let progress = Progress::new("cases");
    let mut outcomes = Vec::with_capacity(chosen.len());
    for (done, case) in chosen.iter().enumerate() {
        progress.update(done, chosen.len());
        outcomes.push(Outcome::of(case).map_err(internal)?);
    }
    drop(progress);
    let passes = outcomes.iter().all(Outcome::passes);
    if args.json {
        failure::print_json(&Report {
            texmap: env!("CARGO_PKG_VERSION"),
            schema: 1,
            verb: "stability",
            passes,
            cases: outcomes
                .iter()
                .map(|o| CaseReport {
                    id: &o.case.id,
                    input: &o.case.input,
                    expected: &o.case.expected,
                    passes: o.passes(),
                    checks: o.verdicts.iter().map(CheckReport::from).collect(),
                })
                .collect(),
        })?;
    } else {
        failure::print(&cases::markdown(&outcomes))?;
    }
    for outcome in outcomes.iter().filter(|o| !o.passes()) {
        say_always(&format!("{}: a demand is not met\n", outcome.case.id));
    }
    Ok(if passes { Exit::Done } else { Exit::Differs })
}
