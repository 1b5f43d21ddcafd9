//! Shards: the part of a batch that one task runs, and its number from the variables of the engine that started the task.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::cmd::batch::args::{BatchFlags, ShardArg};
use crate::failure::Failure;
use crate::values::{Part, Ranges};

/// The units that a run is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Shard {
    Part(Part),
    Ranges(Ranges),
}

impl Shard {
    /// The whole batch.
    pub(crate) const ALL: Self = Self::Part(Part { index: 1, count: 1 });

    /// The shard of the command line; `environment` is asked for `auto`.
    pub(crate) fn of(
        flags: &BatchFlags,
        environment: &dyn Fn(&str) -> Option<String>,
    ) -> Result<Self, Failure> {
        if let Some(ranges) = &flags.range {
            return Ok(Self::Ranges(ranges.clone()));
        }
        match flags.shard {
            None => Ok(Self::ALL),
            Some(ShardArg::Part(part)) => match flags.shard_count {
                Some(count) if count != part.count => {
                    Err(contradiction("--shard", part.count, count))
                }
                _ => Ok(Self::Part(part)),
            },
            Some(ShardArg::Auto) => auto(flags.shard_count, environment).map(Self::Part),
        }
    }

    /// Numbers of the units, of `all` in order.
    ///
    /// # Errors
    /// A range that ends behind the last unit.
    pub(crate) fn units(&self, all: usize) -> Result<Vec<usize>, Failure> {
        match self {
            Self::Part(part) => {
                let Range { start, end } = part.of(all as u64);
                Ok((start as usize..end as usize).collect())
            }
            Self::Ranges(ranges) => {
                if let Some(beyond) = ranges.0.iter().find(|r| *r.end() >= all as u64) {
                    return Err(Failure::usage(
                        format!("--range {ranges}: {} is beyond the last unit", beyond.end()),
                        format!("there are {all} units, 0 to {}", all.saturating_sub(1)),
                    ));
                }
                let wanted = |unit: &usize| ranges.contains(*unit as u64);
                Ok((0..all).filter(wanted).collect())
            }
        }
    }

    /// Name of its report, without the ending.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Part(Part { index: 1, count: 1 }) => "report".to_owned(),
            Self::Part(part) => format!("report-{}-of-{}", part.index, part.count),
            Self::Ranges(ranges) => {
                format!("report-range-{}", ranges.to_string().replace(',', "_"))
            }
        }
    }
}

/// Variables of an engine that numbers its tasks.
struct Engine {
    name: &'static str,
    /// Number of the task; whole numbers alone count: SGE says `undefined` outside of an array.
    id: &'static str,
    /// Number of the first task: a variable, or what the engine starts with.
    first: First,
    /// Difference of neighbouring numbers, 1 without it.
    step: Option<&'static str>,
    count: Count,
}

enum First {
    Is(u32),
    Told(&'static str),
}

enum Count {
    Told(&'static str),
    /// The number of the last task is told.
    Last(&'static str),
    /// The user says it.
    Unknown,
}

/// The table of docs/batch.md.
const ENGINES: [Engine; 8] = [
    Engine {
        name: "Slurm",
        id: "SLURM_ARRAY_TASK_ID",
        first: First::Told("SLURM_ARRAY_TASK_MIN"),
        step: Some("SLURM_ARRAY_TASK_STEP"),
        count: Count::Told("SLURM_ARRAY_TASK_COUNT"),
    },
    Engine {
        name: "HyperQueue",
        id: "HQ_TASK_ID",
        first: First::Is(1),
        step: None,
        count: Count::Unknown,
    },
    Engine {
        name: "Kubernetes",
        id: "JOB_COMPLETION_INDEX",
        first: First::Is(0),
        step: None,
        count: Count::Unknown,
    },
    Engine {
        name: "AWS Batch",
        id: "AWS_BATCH_JOB_ARRAY_INDEX",
        first: First::Is(0),
        step: None,
        count: Count::Told("AWS_BATCH_JOB_ARRAY_SIZE"),
    },
    Engine {
        name: "PBS",
        id: "PBS_ARRAY_INDEX",
        first: First::Is(1),
        step: None,
        count: Count::Unknown,
    },
    Engine {
        name: "SGE",
        id: "SGE_TASK_ID",
        first: First::Told("SGE_TASK_FIRST"),
        step: Some("SGE_TASK_STEPSIZE"),
        count: Count::Last("SGE_TASK_LAST"),
    },
    Engine {
        name: "LSF",
        id: "LSB_JOBINDEX",
        first: First::Is(1),
        step: Some("LSB_JOBINDEX_STEP"),
        count: Count::Last("LSB_JOBINDEX_END"),
    },
    Engine {
        name: "GNU parallel",
        id: "PARALLEL_SEQ",
        first: First::Is(1),
        step: None,
        count: Count::Unknown,
    },
];

/// The shard of the present task.
fn auto(given: Option<u32>, environment: &dyn Fn(&str) -> Option<String>) -> Result<Part, Failure> {
    let number = |name: &str| environment(name)?.trim().parse::<u32>().ok();
    // LSF numbers from 1 and says 0 outside of an array.
    let outside = |engine: &Engine, id: u32| engine.name == "LSF" && id == 0;
    let found: BTreeMap<&str, (&Engine, u32)> = ENGINES
        .iter()
        .filter_map(|engine| Some((engine.id, (engine, number(engine.id)?))))
        .filter(|(_, (engine, id))| !outside(engine, *id))
        .collect();
    let mut all = found.values();
    let Some((engine, id)) = all.next() else {
        let names: Vec<&str> = ENGINES.iter().map(|engine| engine.id).collect();
        return Err(Failure::usage(
            "--shard auto: no engine has numbered this task",
            format!(
                "start it as a task of an array, which sets one of {}, or write --shard I/N",
                names.join(", ")
            ),
        ));
    };
    if all.next().is_some() {
        let names: Vec<&str> = found.keys().copied().collect();
        return Err(Failure::usage(
            format!(
                "--shard auto: several engines have numbered this task: {}",
                names.join(" and ")
            ),
            format!(
                "name the number that counts, as in --shard \"${}/N\", or unset the others",
                names[0]
            ),
        ));
    }
    engine.part(*id, given, &number)
}

impl Engine {
    fn part(
        &self,
        id: u32,
        given: Option<u32>,
        number: &dyn Fn(&str) -> Option<u32>,
    ) -> Result<Part, Failure> {
        let bad = |what: String| {
            let why = format!(
                "the variables of {} do not fit together: submit the array again, or write --shard I/N",
                self.name
            );
            Failure::usage(format!("--shard auto: {}={id}, {what}", self.id), why)
        };
        let first = match self.first {
            First::Is(first) => first,
            First::Told(name) => number(name).unwrap_or(1),
        };
        let step = self.step.and_then(number).unwrap_or(1);
        let of_numbers = |number: u32| {
            let steps = number.checked_sub(first)?;
            (step > 0 && steps.is_multiple_of(step)).then(|| steps / step + 1)
        };
        let index = of_numbers(id).ok_or_else(|| {
            bad(format!(
                "tasks are numbered from {first} in steps of {step}"
            ))
        })?;
        let told = match self.count {
            Count::Told(name) => number(name),
            Count::Last(name) => {
                number(name).map(|last| last.checked_sub(first).map_or(0, |l| l / step + 1))
            }
            Count::Unknown => None,
        };
        let count = match (told, given) {
            (Some(told), Some(given)) if told != given => {
                return Err(contradiction(self.name, told, given));
            }
            (Some(count), _) | (None, Some(count)) => count,
            (None, None) => {
                return Err(Failure::usage(
                    format!(
                        "--shard auto: {} does not tell the number of tasks",
                        self.name
                    ),
                    "add --shard-count N, the size of the array",
                ));
            }
        };
        match index <= count {
            true => Ok(Part { index, count }),
            false => Err(bad(format!("the task {index} of {count}"))),
        }
    }
}

fn contradiction(who: &str, told: u32, given: u32) -> Failure {
    Failure::usage(
        format!("{who} says {told} shards, and --shard-count {given}"),
        "a part of an array that runs again keeps its old number of shards: write --shard I/N",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(variables: &str, count: Option<u32>) -> Result<String, String> {
        let map: BTreeMap<&str, &str> = variables
            .split_whitespace()
            .filter_map(|pair| pair.split_once('='))
            .collect();
        let environment = |name: &str| map.get(name).map(|v| (*v).to_owned());
        auto(count, &environment)
            .map(|part| part.to_string())
            .map_err(|failure| failure.what)
    }

    #[test]
    fn every_engine_counts_in_its_way() {
        let slurm = "SLURM_ARRAY_TASK_MIN=10 SLURM_ARRAY_TASK_STEP=5 SLURM_ARRAY_TASK_COUNT=4";
        for (variables, count, expected) in [
            (format!("SLURM_ARRAY_TASK_ID=20 {slurm}"), None, "3/4"),
            (format!("SLURM_ARRAY_TASK_ID=25 {slurm}"), Some(4), "4/4"),
            (
                "SLURM_ARRAY_TASK_ID=0 SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_COUNT=8".into(),
                None,
                "1/8",
            ),
            ("HQ_TASK_ID=8".into(), Some(8), "8/8"),
            ("JOB_COMPLETION_INDEX=0".into(), Some(8), "1/8"),
            ("JOB_COMPLETION_INDEX=7".into(), Some(8), "8/8"),
            ("AWS_BATCH_JOB_ARRAY_INDEX=2".into(), Some(5), "3/5"),
            (
                "AWS_BATCH_JOB_ARRAY_INDEX=2 AWS_BATCH_JOB_ARRAY_SIZE=5".into(),
                None,
                "3/5",
            ),
            ("PBS_ARRAY_INDEX=3".into(), Some(3), "3/3"),
            (
                "SGE_TASK_ID=7 SGE_TASK_FIRST=1 SGE_TASK_LAST=10 SGE_TASK_STEPSIZE=3".into(),
                None,
                "3/4",
            ),
            ("LSB_JOBINDEX=2 LSB_JOBINDEX_END=6".into(), None, "2/6"),
            (
                "LSB_JOBINDEX=3 LSB_JOBINDEX_END=7 LSB_JOBINDEX_STEP=2".into(),
                None,
                "2/4",
            ),
            ("PARALLEL_SEQ=1".into(), Some(2), "1/2"),
            (
                "SGE_TASK_ID=undefined LSB_JOBINDEX=0 PARALLEL_SEQ=2".into(),
                Some(2),
                "2/2",
            ),
        ] {
            assert_eq!(
                of(&variables, count).as_deref(),
                Ok(expected),
                "{variables}"
            );
        }
    }

    #[test]
    fn counts_are_never_guessed() {
        for (variables, count, word) in [
            ("", Some(8), "no engine"),
            ("SGE_TASK_ID=undefined", Some(8), "no engine"),
            ("HQ_TASK_ID=3", None, "does not tell"),
            ("JOB_COMPLETION_INDEX=3", None, "does not tell"),
            ("HQ_TASK_ID=0", Some(8), "numbered from 1"),
            ("PBS_ARRAY_INDEX=9", Some(8), "task 9 of 8"),
            ("JOB_COMPLETION_INDEX=8", Some(8), "task 9 of 8"),
            // One task of an array runs again alone.
            (
                "SLURM_ARRAY_TASK_ID=3 SLURM_ARRAY_TASK_MIN=3 SLURM_ARRAY_TASK_COUNT=1",
                Some(8),
                "Slurm says 1",
            ),
            (
                "SLURM_ARRAY_TASK_ID=4 SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_COUNT=4 SLURM_ARRAY_TASK_STEP=2",
                None,
                "steps of 2",
            ),
            ("SLURM_ARRAY_TASK_ID=3", None, "does not tell"),
            (
                "AWS_BATCH_JOB_ARRAY_INDEX=2 AWS_BATCH_JOB_ARRAY_SIZE=5",
                Some(6),
                "AWS Batch says 5",
            ),
            ("HQ_TASK_ID=1 PARALLEL_SEQ=1", Some(8), "several engines"),
            ("LSB_JOBINDEX=3 LSB_JOBINDEX_END=2", None, "task 3 of 2"),
        ] {
            let refused = of(variables, count).unwrap_err();
            assert!(refused.contains(word), "{variables}: {refused}");
        }
    }

    #[test]
    fn shards_and_ranges_name_units() {
        let part = |index, count| Shard::Part(Part { index, count });
        assert_eq!(part(2, 3).units(7).unwrap(), [2, 3]);
        assert_eq!(part(2, 3).name(), "report-2-of-3");
        let ranges = Shard::Ranges("0-1,4".parse().unwrap());
        assert_eq!(ranges.units(5).unwrap(), [0, 1, 4]);
        assert_eq!(ranges.name(), "report-range-0-1_4");
        assert!(ranges.units(4).unwrap_err().what.contains("beyond"));
    }
}
