//! The machine that the times were measured on.

use std::fmt;

use texmap_math::Level;

/// A description without names of hosts or users.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Model of the processor, where the system says.
    pub processor: String,
    /// Logical processors.
    pub processors: usize,
    /// Instruction set that the kernels used.
    pub level: String,
    /// Operating system and architecture.
    pub system: String,
}

impl Machine {
    /// The machine that runs this program.
    pub fn here() -> Self {
        let level = format!("{:?}", Level::new());
        let level = level.split('(').next().unwrap_or("").trim().to_owned();
        Self {
            processor: processor().unwrap_or_else(|| "a processor without a name".to_owned()),
            processors: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            level,
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {} logical processors, one thread used, kernels on {}, {}, texmap {}",
            self.processor,
            self.processors,
            self.level,
            self.system,
            env!("CARGO_PKG_VERSION"),
        )
    }
}

/// Model and clock from Linux's own file; elsewhere nothing is known without a library.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let field = |name: &str| {
        let line = text.lines().find(|l| l.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    let model = field("model name")?;
    Some(match field("cpu MHz").and_then(|m| m.parse::<f64>().ok()) {
        Some(clock) => format!("{model}, {clock:.0} MHz when asked"),
        None => model,
    })
}
