//! The outcome of the cases as a page of tables.

use std::fmt::Write;

use super::{Case, Check, Verdict, judge};
use crate::LabError;
use texmap_truth::metrics::figure;

/// A case with the verdicts on all its demands.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The case.
    pub case: Case,
    /// One for each of its checks, in their order.
    pub verdicts: Vec<Verdict>,
}

impl Outcome {
    /// Runs and judges a case.
    ///
    /// # Errors
    /// As [`judge`].
    pub fn of(case: &Case) -> Result<Self, LabError> {
        Ok(Self {
            verdicts: judge(case)?,
            case: case.clone(),
        })
    }

    /// True if every demand is met and every naive method fails its own.
    pub fn passes(&self) -> bool {
        self.verdicts.iter().all(Verdict::passes)
    }
}

impl Verdict {
    /// The verdict for a reader: a naive method that fails is what the case is there to show.
    pub fn word(&self) -> &'static str {
        match (self.passes(), self.check.must_fail) {
            (true, false) => "holds",
            (true, true) => "fails, as it must",
            (false, true) => "DOES NOT FAIL",
            (false, false) => "BROKEN",
        }
    }
}

impl Check {
    /// The demand in words, without what `must_fail` says.
    pub fn demand(&self) -> String {
        let mut parts = Vec::new();
        if let Some(limit) = self.limit {
            parts.push(if limit == 0.0 {
                "none".to_owned()
            } else {
                format!("at most {}", figure(limit))
            });
        }
        if let Some(least) = self.at_least {
            parts.push(format!("at least {}", figure(least)));
        }
        if let Some(value) = self.figure {
            let within = 100.0 * self.within.unwrap_or(0.01);
            parts.push(format!("{} within {} %", figure(value), figure(within)));
        }
        parts.join(", ")
    }
}

/// Headings of the groups of ids.
const GROUPS: &[(char, &str)] = &[
    ('R', "Rasterizer"),
    ('I', "Interpolation"),
    ('S', "Sampler"),
    ('U', "uv mapper"),
    ('P', "Projective textures"),
    ('H', "Shadow maps"),
    ('E', "Environment and light maps"),
    ('B', "Bump, normal and displacement maps"),
    ('L', "Where light is computed"),
    ('G', "Moved, bent and turned shapes"),
    ('V', "Volumes, solid textures and ramps"),
];

/// The page: what fails where, then every demand of every case.
pub fn markdown(outcomes: &[Outcome]) -> String {
    let demands: usize = outcomes.iter().map(|o| o.verdicts.len()).sum();
    let naive = || {
        let all = outcomes.iter();
        all.flat_map(|o| o.verdicts.iter().map(move |v| (o, v)))
            .filter(|(_, v)| v.check.must_fail)
    };
    let broken = outcomes.iter().filter(|o| !o.passes()).count();
    let mut page = format!(
        "# Stability: inputs on which methods fail\n\n\
         Written by `cargo run --release -p texmap-cli -- stability > docs/generated/stability.md`; `--json` gives the same for \
         programs. Counts and largest errors, never averages. A method marked *naive* is the textbook's, kept to show \
         that its case really breaks something: it must fail.\n\n\
         {} cases, {demands} demands, of which {} on naive methods; {} cases with a demand that is not met.\n\n\
         ## Which methods fail where\n\n| method | case | on what | demanded | measured |\n|---|---|---|---|---|\n",
        outcomes.len(),
        naive().count(),
        if broken == 0 {
            "no".to_owned()
        } else {
            broken.to_string()
        },
    );
    for (outcome, verdict) in naive() {
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {} |",
            verdict.check.method,
            outcome.case.id,
            verdict.check.measure,
            verdict.check.demand(),
            measured(verdict),
        );
    }
    for &(letter, heading) in GROUPS {
        let group: Vec<&Outcome> = outcomes
            .iter()
            .filter(|o| o.case.id.starts_with(letter))
            .collect();
        if group.is_empty() {
            continue;
        }
        let _ = write!(page, "\n## {heading}\n");
        for outcome in group {
            let Case {
                id,
                input,
                expected,
                ..
            } = &outcome.case;
            let _ = write!(
                page,
                "\n### {id}\n\nInput: {input}. Expected: {expected}.\n\n\
                 | method | measured is | demanded | measured | verdict |\n|---|---|---|---|---|\n",
            );
            for verdict in &outcome.verdicts {
                let naive = if verdict.check.must_fail {
                    " (naive)"
                } else {
                    ""
                };
                let _ = writeln!(
                    page,
                    "| {}{naive} | {} | {} | {} | {} |",
                    verdict.check.method,
                    verdict.check.measure,
                    verdict.check.demand(),
                    measured(verdict),
                    verdict.word(),
                );
            }
        }
    }
    page
}

fn measured(verdict: &Verdict) -> String {
    verdict
        .measured
        .map_or_else(|| "nothing".to_owned(), figure)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_naive_method_that_does_not_fail_is_shouted() {
        let check = |must_fail| Check {
            method: "m".into(),
            measure: "x".into(),
            limit: Some(1.0),
            at_least: None,
            figure: None,
            within: None,
            must_fail,
        };
        let word = |must_fail, measured| {
            Verdict {
                check: check(must_fail),
                measured,
            }
            .word()
        };
        assert_eq!(word(true, Some(2.0)), "fails, as it must");
        assert_eq!(word(true, Some(0.5)), "DOES NOT FAIL");
        assert_eq!(word(false, Some(2.0)), "BROKEN");
        assert_eq!(word(false, None), "BROKEN");
    }
}
