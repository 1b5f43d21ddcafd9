//! Lists that the program reads, checked without running what they say.

use std::ffi::OsString;
use std::path::Path;

use clap::Parser;

use crate::args::{Cli, Verb};
use crate::cmd::{batch, merge};
use crate::failure::Failure;

/// Ids and command lines of the units that `texmap batch` would run for `arguments`, the first of which is the program's name. Lists and
/// manifests are read, nothing is run or written.
///
/// # Errors
/// The message of the program: arguments that are not of a batch, lists and manifests with faults, names that clash.
pub fn batch_units(arguments: &[OsString]) -> Result<Vec<(String, Vec<String>)>, String> {
    let cli = Cli::try_parse_from(batch::with_verb(arguments.to_vec()))
        .map_err(|refusal| said(Failure::from(refusal)))?;
    let Verb::Batch(args) = cli.verb else {
        return Err("the arguments are not of `texmap batch`".to_owned());
    };
    let plan = batch::plan::Plan::new(&args).map_err(said)?;
    let units = plan.units.iter();
    Ok(units
        .map(|unit| (unit.id.clone(), plan.words(&[unit], 1)))
        .collect())
}

/// Number of the units of the batch whose reports these are, if `texmap merge` finds every unit in them once.
///
/// # Errors
/// The message of the program: reports with faults, of different batches, or with units missing.
pub fn merged_units(report: &Path) -> Result<u64, String> {
    merge::units(&[report.to_owned()]).map_err(said)
}

fn said(failure: Failure) -> String {
    failure.what
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_planned_and_faults_are_told() {
        let dir = tempfile::tempdir().unwrap();
        let manifest = dir.path().join("all.json");
        let words = || {
            let words = ["texmap", "batch", "render"].map(OsString::from);
            let mut words = words.to_vec();
            words.push(manifest.clone().into_os_string());
            words
        };
        let text = r#"{"version":1,"items":[{"id":"b","input":"a.obj","output":"a.png"}]}"#;
        std::fs::write(&manifest, text).unwrap();
        let units = batch_units(&words()).unwrap();
        assert_eq!(units.len(), 1);
        assert_eq!(units[0].0, "b");
        assert_eq!(units[0].1[..2], ["texmap", "render"]);
        std::fs::write(&manifest, text.replace("output", "outptu")).unwrap();
        assert!(batch_units(&words()).unwrap_err().contains("outptu"));
    }

    #[test]
    fn a_report_of_any_number_of_units_is_read_at_once() {
        let dir = tempfile::tempdir().unwrap();
        let report = dir.path().join("report-1-of-2.jsonl");
        let head = |units: u64, shard: &str| {
            format!(
                "{{\"texmap\":\"0\",\"schema\":1,\"verb\":\"render\",\"shard\":\"{shard}\",\"folder\":\"..\",\"units\":{units},\
                 \"units_hash\":\"a\",\"settings_hash\":\"b\"}}\n"
            )
        };
        std::fs::write(&report, head(0, "1/1")).unwrap();
        assert_eq!(merged_units(&report), Ok(0));
        for shard in ["1/2", "1/4294967295", "0-9"] {
            std::fs::write(&report, head(u64::MAX, shard)).unwrap();
            let said = merged_units(&report).unwrap_err();
            assert!(
                said.contains("18446744073709551615 units are missing"),
                "{said}"
            );
        }
    }
}
