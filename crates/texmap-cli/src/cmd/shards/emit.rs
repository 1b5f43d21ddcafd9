//! Tasks in the forms of engines.

use serde_json::json;

use super::Tasks;

/// A form of the tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Emit {
    /// Every task with its command, memory and time
    Json,
    /// A shell command a line, for GNU parallel or xargs
    Commands,
    /// A script for sbatch
    Slurm,
    /// An Indexed Job for kubectl
    Kubernetes,
    /// A command for HyperQueue
    Hyperqueue,
    /// A document for `aws batch submit-job --cli-input-json`
    AwsBatch,
}

/// The image of docs/deploy/Dockerfile.
const IMAGE: &str = "texmap:latest";

/// The text that an engine takes.
pub(super) fn text(form: Emit, tasks: &Tasks) -> String {
    match form {
        Emit::Json | Emit::Commands => commands(tasks),
        Emit::Slurm => slurm(tasks),
        Emit::Kubernetes => kubernetes(tasks),
        Emit::Hyperqueue => hyperqueue(tasks),
        Emit::AwsBatch => aws_batch(tasks),
    }
}

/// A half more than the estimate, in MiB.
fn mebibytes(tasks: &Tasks) -> u64 {
    (tasks.largest.memory_bytes * 3 / 2).div_ceil(1 << 20)
}

/// Four times the estimate, in whole minutes.
fn minutes(tasks: &Tasks) -> u64 {
    (tasks.largest.core_seconds * 4.0 / 60.0).ceil().max(1.0) as u64
}

fn commands(tasks: &Tasks) -> String {
    let line = |task: &super::Task| format!("{}\n", shell(&task.command));
    tasks.tasks.iter().map(line).collect()
}

fn slurm(tasks: &Tasks) -> String {
    format!(
        "#!/bin/sh\n\
         #SBATCH --job-name=texmap\n\
         #SBATCH --array=1-{count}\n\
         #SBATCH --cpus-per-task={cores}\n\
         #SBATCH --mem={memory}M\n\
         #SBATCH --time={minutes}\n\
         #SBATCH --requeue\n\
         # Exit code 75: something outside of the batch ended a task. It runs again, and skips what is complete.\n\
         {command} --shard=auto --shard-count={count}\n\
         code=$?\n\
         [ $code -ne 75 ] || scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}\"\n\
         exit $code\n",
        count = tasks.count,
        cores = tasks.cores,
        memory = mebibytes(tasks),
        minutes = minutes(tasks),
        command = shell(&tasks.command),
    )
}

fn hyperqueue(tasks: &Tasks) -> String {
    format!(
        "hq submit --name texmap --array 1-{count} --cpus {cores} --time-request {minutes}m --crash-limit 10 -- {command} --shard=auto --shard-count={count}\n",
        count = tasks.count,
        cores = tasks.cores,
        minutes = minutes(tasks),
        command = shell(&tasks.command),
    )
}

fn kubernetes(tasks: &Tasks) -> String {
    let words = arguments(tasks);
    let args: Vec<String> = words
        .iter()
        .map(|word| format!("            - {}\n", json!(word)))
        .collect();
    format!(
        "apiVersion: batch/v1\n\
         kind: Job\n\
         metadata:\n  name: texmap\n\
         spec:\n  completions: {count}\n  parallelism: {parallel}\n  completionMode: Indexed\n  backoffLimitPerIndex: 3\n  maxFailedIndexes: {count}\n  \
         podFailurePolicy:\n    rules:\n      \
         # Lost nodes and evictions do not count.\n      \
         - action: Ignore\n        onPodConditions:\n          - type: DisruptionTarget\n      \
         # 1 to 6: the same call would end with it again.\n      \
         - action: FailIndex\n        onExitCodes:\n          containerName: texmap\n          operator: In\n          values: [1, 2, 3, 4, 5, 6]\n  \
         template:\n    spec:\n      restartPolicy: Never\n      containers:\n        - name: texmap\n          image: {IMAGE}\n          \
         workingDir: /data\n          args:\n{args}          \
         resources:\n            requests: {{cpu: \"{cores}\", memory: {memory}Mi}}\n            limits: {{memory: {memory}Mi}}\n          \
         volumeMounts:\n            - {{name: data, mountPath: /data}}\n      \
         volumes:\n        - name: data\n          persistentVolumeClaim: {{claimName: data}}\n",
        count = tasks.count,
        parallel = tasks.count.min(100),
        args = args.concat(),
        cores = tasks.cores,
        memory = mebibytes(tasks),
    )
}

fn aws_batch(tasks: &Tasks) -> String {
    let document = json!({
        "jobName": "texmap",
        "jobQueue": "texmap",
        "jobDefinition": "texmap",
        // Arrays have 2 to 10,000 children.
        "arrayProperties": { "size": tasks.count },
        "retryStrategy": {
            "attempts": 5,
            "evaluateOnExit": [
                { "onStatusReason": "Host EC2*", "action": "RETRY" },
                { "onExitCode": "75", "action": "RETRY" },
                { "onExitCode": "143", "action": "RETRY" },
                { "onExitCode": "137", "action": "RETRY" },
                { "onExitCode": "*", "action": "EXIT" },
            ],
        },
        "timeout": { "attemptDurationSeconds": (minutes(tasks) * 60).max(60) },
        "containerOverrides": {
            "command": arguments(tasks),
            "resourceRequirements": [
                { "type": "VCPU", "value": tasks.cores.to_string() },
                { "type": "MEMORY", "value": mebibytes(tasks).to_string() },
            ],
        },
    });
    let text = serde_json::to_string_pretty(&document).unwrap_or_default();
    text + "\n"
}

/// The command line without the name of the program, which the image starts.
fn arguments(tasks: &Tasks) -> Vec<String> {
    let mut words: Vec<String> = tasks.command.iter().skip(1).cloned().collect();
    words.push("--shard=auto".to_owned());
    words.push(format!("--shard-count={}", tasks.count));
    words
}

/// Words as a POSIX shell reads them back.
fn shell(words: &[String]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| quoted(word)).collect();
    quoted.join(" ")
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:@%+".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn words_are_quoted_for_the_shell() {
        for (word, expected) in [
            ("--views=front,top", "--views=front,top"),
            ("out/{model}.png", "'out/{model}.png'"),
            ("it's", r"'it'\''s'"),
            ("a b", "'a b'"),
            ("", "''"),
            ("$HOME", "'$HOME'"),
        ] {
            assert_eq!(quoted(word), expected);
        }
    }
}
