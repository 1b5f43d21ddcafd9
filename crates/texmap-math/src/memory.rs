//! Memory budget: a limit that large buffers ask for before they are allocated.
//!
//! A program that must not run out of memory passes one [`MemoryBudget`] to everything that it calls. Code that is
//! about to allocate a large buffer calls [`MemoryBudget::ask`] with its size; a refusal is an ordinary error that says
//! which buffer, how many bytes, and which setting makes it smaller.

use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::error::Error;
use core::fmt;

/// Bytes from which on a buffer asks: 16 MiB. Smaller ones are always granted.
pub const LARGE: u64 = 16 << 20;

#[cfg(feature = "std")]
static OF_PROCESS: std::sync::OnceLock<MemoryBudget> = std::sync::OnceLock::new();

/// Limit on the memory of large buffers.
///
/// [`ask`](Self::ask) compares a buffer's size, added to what is in use already, with the limit; then it asks the
/// allocator for the same bytes and gives them back, so that the allocation that follows does not abort the process.
/// Buffers below [`LARGE`] are granted without a look. The budget keeps no books: memory in use is measured each time by the
/// function that [`measured`](Self::measured) was given, or taken as 0, which limits each buffer by itself.
#[derive(Clone, Copy, Debug)]
pub struct MemoryBudget {
    limit: u64,
    used: fn() -> u64,
}

impl MemoryBudget {
    /// No limit of its own: only what the allocator refuses is refused.
    pub const UNLIMITED: Self = Self::new(u64::MAX);

    /// At most `limit` bytes for each buffer.
    #[must_use]
    pub const fn new(limit: u64) -> Self {
        Self::measured(limit, || 0)
    }

    /// At most `limit` bytes in all. `used` returns the bytes in use, for instance those that the operating system counts for this
    /// process; it is called for large buffers only.
    #[must_use]
    pub const fn measured(limit: u64, used: fn() -> u64) -> Self {
        Self { limit, used }
    }

    /// The budget of this process: the one given to [`set_for_process`](Self::set_for_process), [`UNLIMITED`](Self::UNLIMITED)
    /// until then and without the feature `std`. It is the [`Default`] of everything that takes a budget, and what functions ask
    /// that take none.
    #[must_use]
    pub fn of_process() -> Self {
        #[cfg(feature = "std")]
        return OF_PROCESS.get().copied().unwrap_or(Self::UNLIMITED);
        #[cfg(not(feature = "std"))]
        Self::UNLIMITED
    }

    /// Makes this the budget of the process. A program calls it once, before it loads anything; a library should pass budgets
    /// instead.
    ///
    /// # Errors
    /// The budget that was set before, which stays.
    #[cfg(feature = "std")]
    pub fn set_for_process(self) -> Result<(), Self> {
        OF_PROCESS.set(self).map_err(|_| Self::of_process())
    }

    /// The limit in bytes; `u64::MAX` if there is none.
    #[must_use]
    pub const fn limit(&self) -> u64 {
        self.limit
    }

    /// Bytes that are left below the limit now.
    #[must_use]
    pub fn available(&self) -> u64 {
        self.limit.saturating_sub((self.used)())
    }

    /// Asks for a buffer of `bytes` bytes, or for several that are allocated one after the other.
    ///
    /// `what` names the buffer, with its size; `lower` says which settings make it smaller. Both are for the error only. A
    /// size that overflows should be passed as `u64::MAX`.
    ///
    /// # Errors
    /// [`OverBudget`] if the bytes do not fit below the limit, or if the allocator refuses them.
    pub fn ask(
        &self,
        bytes: u64,
        what: fmt::Arguments<'_>,
        lower: &'static str,
    ) -> Result<(), OverBudget> {
        if bytes < LARGE {
            return Ok(());
        }
        let used = (self.used)();
        let limit = (used.saturating_add(bytes) > self.limit).then_some(self.limit);
        if limit.is_none() && is_available(bytes) {
            return Ok(());
        }
        Err(OverBudget {
            what: what.to_string(),
            bytes,
            used,
            limit,
            lower,
        })
    }

    /// Asks for a buffer as [`ask`](Self::ask) does and reserves it at once, for one that is filled much later. A buffer that has
    /// the capacity already is not asked for.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn reserve<T>(
        &self,
        buffer: &mut Vec<T>,
        len: usize,
        what: fmt::Arguments<'_>,
        lower: &'static str,
    ) -> Result<(), OverBudget> {
        if buffer.capacity() >= len {
            return Ok(());
        }
        let bytes = (len as u64).saturating_mul(size_of::<T>() as u64);
        self.ask(bytes, what, lower)?;
        let more = len - buffer.len();
        buffer.try_reserve_exact(more).map_err(|_| OverBudget {
            what: what.to_string(),
            bytes,
            used: (self.used)(),
            limit: None,
            lower,
        })
    }
}

impl Default for MemoryBudget {
    /// [`MemoryBudget::of_process`].
    fn default() -> Self {
        Self::of_process()
    }
}

impl PartialEq for MemoryBudget {
    /// Equal limits, measured by the same function.
    fn eq(&self, other: &Self) -> bool {
        self.limit == other.limit && core::ptr::fn_addr_eq(self.used, other.used)
    }
}

impl Eq for MemoryBudget {}

/// A buffer that does not fit into the memory budget. `Display` says what asked for how much; [`lower`](Self::lower) says
/// what to change.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct OverBudget {
    /// The buffer, with its size in its own units.
    pub what: String,
    /// Bytes that were asked for; `u64::MAX` for a size beyond 64 bits.
    pub bytes: u64,
    /// Bytes that were in use before.
    pub used: u64,
    /// The limit in bytes; `None` if the allocator refused the buffer although it fits the budget.
    pub limit: Option<u64>,
    /// Settings that make the buffer smaller.
    pub lower: &'static str,
}

impl fmt::Display for OverBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no memory for {} ({}): ", self.what, Size(self.bytes))?;
        match self.limit {
            None => f.write_str("the system has less than that left"),
            Some(limit) if self.used == 0 => write!(f, "the budget is {}", Size(limit)),
            Some(limit) => {
                let (used, limit) = (Size(self.used), Size(limit));
                write!(f, "{used} of a budget of {limit} are in use")
            }
        }
    }
}

impl Error for OverBudget {}

/// Bytes in the largest binary unit that leaves a number of at least 1.
struct Size(u64);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [(u32, &str); 4] = [(40, "TiB"), (30, "GiB"), (20, "MiB"), (10, "KiB")];
        match UNITS.iter().find(|(bits, _)| self.0 >> bits > 0) {
            _ if self.0 == u64::MAX => f.write_str("more than 16 EiB"),
            Some((bits, unit)) => write!(f, "{:.1} {unit}", self.0 as f64 / (1u64 << bits) as f64),
            None => write!(f, "{} bytes", self.0),
        }
    }
}

/// True if the allocator hands out so many bytes. They are given back before this returns: a zeroed buffer allocated next is
/// then as lazy as ever.
fn is_available(bytes: u64) -> bool {
    let mut probe = Vec::<u8>::new();
    let reserved = usize::try_from(bytes).map(|bytes| probe.try_reserve_exact(bytes));
    // Without the black box a compiler may drop an allocation that nobody reads, and call it granted.
    core::hint::black_box(&mut probe);
    matches!(reserved, Ok(Ok(())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(budget: MemoryBudget, bytes: u64) -> Result<(), OverBudget> {
        budget.ask(
            bytes,
            format_args!("a picture of {} x {}", 7, 9),
            "lower the size",
        )
    }

    #[test]
    fn large_buffers_count_with_what_is_in_use() {
        let budget = MemoryBudget::measured(100 << 20, || 70 << 20);
        assert_eq!(ask(budget, 30 << 20), Ok(()));
        assert_eq!(budget.available(), 30 << 20);
        let refused = ask(budget, (30 << 20) + 1).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "no memory for a picture of 7 x 9 (30.0 MiB): 70.0 MiB of a budget of 100.0 MiB are in use"
        );
        assert_eq!(refused.lower, "lower the size");
        // Each by itself.
        let budget = MemoryBudget::new(100 << 20);
        assert_eq!(ask(budget, 100 << 20), Ok(()));
        let refused = ask(budget, 1 << 30).unwrap_err().to_string();
        assert!(
            refused.ends_with("(1.0 GiB): the budget is 100.0 MiB"),
            "{refused}"
        );
    }

    #[test]
    fn small_buffers_are_granted_unmeasured() {
        let budget = MemoryBudget::measured(0, || panic!("measured for a small buffer"));
        assert_eq!(ask(budget, LARGE - 1), Ok(()));
    }

    #[test]
    fn the_allocator_has_the_last_word() {
        let refused = ask(MemoryBudget::UNLIMITED, 1 << 62).unwrap_err();
        assert_eq!((refused.limit, refused.bytes), (None, 1 << 62));
        assert!(refused.to_string().contains("the system has less"));
        let mut buffer: Vec<u32> = Vec::new();
        let mut reserve = |budget: MemoryBudget, len| {
            let done = budget.reserve(&mut buffer, len, format_args!("words"), "");
            done.map(|()| buffer.capacity())
        };
        assert_eq!(reserve(MemoryBudget::new(0), 1_000), Ok(1_000));
        assert_eq!(reserve(MemoryBudget::new(0), 900), Ok(1_000));
        assert!(reserve(MemoryBudget::new(1 << 25), 1 << 24).is_err());
        assert!(reserve(MemoryBudget::UNLIMITED, usize::MAX).is_err());
        assert_eq!(reserve(MemoryBudget::new(1 << 26), 1 << 24), Ok(1 << 24));
        let refused = ask(MemoryBudget::UNLIMITED, u64::MAX).unwrap_err();
        assert!(refused.to_string().contains("more than 16 EiB"));
        assert_eq!(ask(MemoryBudget::default(), LARGE), Ok(()));
    }
}
