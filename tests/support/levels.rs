//! Every SIMD level that this CPU can run, and the forced scalar fallback.

use texmap_math::Level;

/// Names a comma-separated list of levels (as [`levels`] names them) that a run must have, so that a machine without AVX-512 cannot
/// pass a job that is meant to test it.
pub const REQUIRE: &str = "TEXMAP_REQUIRE_LEVELS";

/// The levels from the strongest down, `fallback` last. A kernel must give the same bits on each.
#[must_use]
pub fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_avx512().map(|t| ("avx512", Level::Avx512(t))));
        levels.extend(best.as_avx2().map(|t| ("avx2", Level::Avx2(t))));
        levels.extend(best.as_sse4_2().map(|t| ("sse4.2", Level::Sse4_2(t))));
        levels.extend(best.as_sse2().map(|t| ("sse2", Level::Sse2(t))));
    }
    #[cfg(target_arch = "aarch64")]
    levels.extend(best.as_neon().map(|t| ("neon", Level::Neon(t))));
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    levels.push(("wasm-simd128", best));
    levels.push(("fallback", Level::fallback()));
    levels
}

/// The levels named in [`REQUIRE`] that are missing here.
#[must_use]
pub fn missing(required: &str) -> Vec<String> {
    let have = levels();
    required
        .split(',')
        .map(str::trim)
        .filter(|name| !name.is_empty() && have.iter().all(|(n, _)| n != name))
        .map(str::to_owned)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_required_levels_are_here() {
        let required = std::env::var(REQUIRE).unwrap_or_default();
        let missing = missing(&required);
        assert!(
            missing.is_empty(),
            "{REQUIRE} names levels that this CPU cannot run: {missing:?}; every test over SIMD levels would pass without them"
        );
    }

    /// Kernels without optimisation are scalar on every level. Then the suites would compare scalars with scalars.
    #[test]
    fn the_levels_have_lanes() {
        let lanes = texmap_math::LANES;
        assert!(lanes, "texmap-math is compiled at opt-level 0");
    }

    #[test]
    fn names_are_distinct_and_a_wrong_one_is_missing() {
        let mut names: Vec<_> = levels().iter().map(|l| l.0).collect();
        assert!(levels().iter().any(|l| l.1.is_fallback()));
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        assert_eq!(missing(&format!("{}, mmx,", names[0])), ["mmx"]);
    }
}
