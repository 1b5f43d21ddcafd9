//! Every case of the lab's cases.toml meets its figures, and the naive methods fail theirs.
use texmap_lab::cases::{self, Case};

fn file() -> Vec<Case> {
    cases::all().unwrap()
}

#[test]
fn every_case_has_a_runner_and_every_runner_a_case() {
    let mut listed: Vec<String> = file().into_iter().map(|case| case.id).collect();
    let mut runnable: Vec<String> = cases::ids().map(str::to_owned).collect();
    listed.sort();
    runnable.sort();
    assert_eq!(listed, runnable);
}

#[test]
fn every_case_meets_its_figures() {
    let mut faults = Vec::new();
    for case in file() {
        for verdict in cases::judge(&case).unwrap() {
            if !verdict.passes() {
                faults.push(format!("{}: {verdict:?}", case.id));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Each case of a method with a naive twin shows that its input really breaks something.
#[test]
fn cases_have_naive_twins() {
    let without: Vec<String> = file()
        .into_iter()
        .filter(|case| !case.checks.iter().any(|check| check.must_fail))
        .map(|case| case.id)
        .collect();
    assert_eq!(without, ["R8"], "R8 has none: depth has one formula");
}

#[test]
fn an_unknown_case_is_an_error() {
    assert!(cases::run("R99").unwrap_err().to_string().contains("R99"));
}
