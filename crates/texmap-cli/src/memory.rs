//! Memory budget of the program: `--memory-limit`, or three quarters of the memory that the system grants.
//!
//! The grant is the least of RLIMIT_AS, RLIMIT_DATA, the limits of the control group (v1 and v2) and the machine's memory, as
//! Linux tells in /proc and /sys. Memory in use is measured the way the least of them counts it. On other systems the default is no limit,
//! and `--memory-limit` bounds each buffer by itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use texmap_math::MemoryBudget;

/// The limit of the command line.
static GIVEN: OnceLock<Option<u64>> = OnceLock::new();

/// The limit of the command line, if there is one.
pub(crate) fn given() -> Option<u64> {
    GIVEN.get().copied().flatten()
}

/// The largest memory of this process since [`forget_peak`], where the system tells.
pub(crate) fn peak() -> Option<u64> {
    match of_this_process("VmHWM:") {
        0 => None,
        bytes => Some(bytes),
    }
}

/// Measures the largest memory from now on (5 resets it: proc(5)).
pub(crate) fn forget_peak() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Makes `limit` bytes, or three quarters of the grant, the budget of the process.
pub(crate) fn set_budget(limit: Option<u64>) {
    let _ = GIVEN.set(limit);
    let budget = match (limit, granted()) {
        (Some(limit), _) => MemoryBudget::measured(limit, resident),
        (None, Some(grant)) => {
            bound_threads();
            MemoryBudget::measured(grant.bytes / 4 * 3, grant.used)
        }
        (None, None) => MemoryBudget::UNLIMITED,
    };
    // A second run in one process, as tests make them, keeps the first budget.
    let _ = budget.set_for_process();
}

/// `512M`, `2G`, `1.5GiB`, or plain bytes.
pub(crate) fn parse_size(text: &str) -> Result<u64, String> {
    let refused = || "expected bytes, or a number with K, M, G or T, such as 2G".to_owned();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = text[digits.len()..].to_ascii_lowercase();
    let bits = match unit.trim_end_matches('b').trim_end_matches('i') {
        "" => 0,
        "k" => 10,
        "m" => 20,
        "g" => 30,
        "t" => 40,
        _ => return Err(refused()),
    };
    let number: f64 = digits.parse().map_err(|_| refused())?;
    let bytes = number * (1u64 << bits) as f64;
    if bytes >= 1.0 && bytes < u64::MAX as f64 {
        Ok(bytes as u64)
    } else {
        Err(refused())
    }
}

/// A limit of the system, and the measure of memory that counts against it.
#[derive(Clone, Copy)]
struct Grant {
    bytes: u64,
    used: fn() -> u64,
}

/// Fewer threads where RLIMIT_AS is small: each takes up to 64 MiB of addresses for its heap, of which it uses little.
fn bound_threads() {
    const EACH: u64 = 256 << 20;
    let Some(addresses) = soft_limit(&own_limits(), "Max address space") else {
        return;
    };
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = all.min((addresses / EACH).max(1) as usize);
    // A second run in one process keeps the first pool.
    let _ = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global();
}

/// True if RLIMIT_AS or RLIMIT_DATA is set, which count addresses, whether they are used or not.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(crate) fn addresses_are_limited() -> bool {
    let limits = own_limits();
    ["Max address space", "Max data size"]
        .iter()
        .any(|name| soft_limit(&limits, name).is_some())
}

fn own_limits() -> String {
    fs::read_to_string("/proc/self/limits").unwrap_or_default()
}

fn granted() -> Option<Grant> {
    let limits = own_limits();
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let machine = fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let group = group_files(&groups)
        .iter()
        .filter_map(|file| fs::read_to_string(file).ok()?.trim().parse().ok())
        .min();
    let grant = |bytes: Option<u64>, used: fn() -> u64| bytes.map(|bytes| Grant { bytes, used });
    [
        grant(soft_limit(&limits, "Max address space"), address_space),
        grant(soft_limit(&limits, "Max data size"), data),
        grant(group, resident),
        grant(kilobytes(&machine, "MemTotal:"), resident),
    ]
    .into_iter()
    .flatten()
    .min_by_key(|grant| grant.bytes)
}

/// The soft limit of a line of /proc/self/limits; `None` if it is unlimited.
fn soft_limit(limits: &str, name: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Files with the memory limits of the groups that /proc/self/cgroup lists, and of the groups around them: each of them counts.
/// Inside a container the path may be the host's; then only the root of the mounted hierarchy is found.
fn group_files(groups: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else {
            continue;
        };
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            c if c.split(',').any(|c| c == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        let around = Path::new(path.trim_start_matches('/')).ancestors();
        files.extend(around.map(|group| Path::new(root).join(group).join(file)));
    }
    files
}

/// A value in kB of /proc/meminfo or /proc/self/status, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let value: u64 = line.split_whitespace().next()?.parse().ok()?;
    value.checked_mul(1024)
}

fn of_this_process(name: &str) -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    kilobytes(&status, name).unwrap_or(0)
}

fn address_space() -> u64 {
    of_this_process("VmSize:")
}

fn data() -> u64 {
    of_this_process("VmData:")
}

/// Memory pages that belong to no file.
fn resident() -> u64 {
    of_this_process("RssAnon:")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_binary() {
        for (text, bytes) in [
            ("100", 100),
            ("1k", 1024),
            ("512M", 512 << 20),
            ("1.5GiB", 3 << 29),
            ("2tb", 2 << 40),
        ] {
            assert_eq!(parse_size(text), Ok(bytes), "{text}");
        }
        for bad in ["", "M", "0", "-1G", "nan", "infG", "1X", "1e30T"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn limits_are_found_in_the_words_of_linux() {
        let limits = "Limit                     Soft Limit           Hard Limit           Units     \n\
             Max data size             unlimited            unlimited            bytes     \n\
             Max address space         1073741824           unlimited            bytes     \n";
        assert_eq!(soft_limit(limits, "Max address space"), Some(1 << 30));
        assert_eq!(soft_limit(limits, "Max data size"), None);
        assert_eq!(
            kilobytes("MemTotal:       24677 kB\n", "MemTotal:"),
            Some(24677 << 10)
        );
        let files = group_files("4:cpu,memory:/a/b\n3:cpu:/x\n0::/c\n");
        let names: Vec<_> = files
            .iter()
            .map(|f| f.to_string_lossy().into_owned())
            .collect();
        assert_eq!(
            names,
            [
                "/sys/fs/cgroup/memory/a/b/memory.limit_in_bytes",
                "/sys/fs/cgroup/memory/a/memory.limit_in_bytes",
                "/sys/fs/cgroup/memory/memory.limit_in_bytes",
                "/sys/fs/cgroup/c/memory.max",
                "/sys/fs/cgroup/memory.max",
            ]
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_machine_grants_something() {
        let grant = granted().expect("Linux tells its memory");
        assert!(grant.bytes > 64 << 20);
        for used in [address_space, data, resident] {
            assert!(used() > 0);
        }
    }
}
