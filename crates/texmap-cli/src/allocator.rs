//! The allocator of the program.
//!
//! Linux gives a process its memory in pages of 4 KiB, each at its first use, which is a third of the processor time of a short run: a model
//! with five maps of 2048 x 2048 touches 60,000. mimalloc asks for pages of 2 MiB, which the C library does not do by itself.

#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub use mimalloc::MiMalloc as Allocator;
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub use std::alloc::System as Allocator;

/// Starts the program again, in the same process, where addresses are limited (`ulimit -v`): mimalloc reserves them by the hundred megabytes
/// unless its environment says otherwise, and the C library 64 MiB for each thread that asks it for a few bytes; nothing of a small limit
/// would be left. Returns where there is no limit.
pub(crate) fn start_within_limits() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        use std::env;
        use std::os::unix::process::CommandExt;
        use std::process::Command;

        const RESERVE: &str = "MIMALLOC_ARENA_RESERVE";
        if env::var_os(RESERVE).is_some() || !crate::memory::addresses_are_limited() {
            return;
        }
        let mut arguments = env::args_os();
        let mut again = Command::new("/proc/self/exe");
        if let Some(name) = arguments.next() {
            again.arg0(name);
        }
        again.env(RESERVE, "0").env("MALLOC_ARENA_MAX", "1");
        // Comes back only if it cannot start; the limit is then met as it is.
        let _ = again.args(arguments).exec();
    }
}
