//! Prices of filters and interpolations, from a committed table: `prices.csv`, written from the chart.

use std::sync::LazyLock;

use texmap_raster::Interp;
use texmap_sample::{Filter, Precision};

/// The price of a filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Price {
    /// The filter.
    pub filter: Filter,
    /// Precision of the filter.
    pub precision: Precision,
    /// Nanoseconds a look-up.
    pub ns: f64,
}

/// Lines of `name,precision,ns`; `interp` lines name an interpolation instead of a filter.
const TABLE: &str = include_str!("prices.csv");

static PRICES: LazyLock<Vec<Price>> = LazyLock::new(|| {
    let mut prices: Vec<Price> = rows()
        .filter_map(|(name, precision, ns)| {
            Some(Price {
                filter: name.parse().ok()?,
                precision: match precision {
                    "exact" => Precision::Exact,
                    "fast" => Precision::Fast,
                    _ => return None,
                },
                ns,
            })
        })
        .collect();
    prices.sort_by(|a, b| a.ns.total_cmp(&b.ns));
    prices
});

fn rows() -> impl Iterator<Item = (&'static str, &'static str, f64)> {
    TABLE.lines().skip(1).filter_map(|line| {
        let mut fields = line.split(',');
        Some((fields.next()?, fields.next()?, fields.next()?.parse().ok()?))
    })
}

/// The filters from cheap to dear.
pub fn prices() -> &'static [Price] {
    &PRICES
}

/// The price of perspective or affine interpolation; infinite for those that are only used by name.
pub(super) fn interp(interp: Interp) -> f64 {
    let name = match interp {
        Interp::Perspective => "perspective",
        Interp::Affine => "affine",
        _ => return f64::INFINITY,
    };
    rows()
        .find(|(row, kind, _)| *row == name && *kind == "interp")
        .map_or(f64::INFINITY, |(_, _, ns)| ns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_table_is_a_price() {
        assert_eq!(prices().len() + 2, TABLE.lines().count() - 1);
        assert!(interp(Interp::Perspective) < 100.0 && interp(Interp::Affine) < 100.0);
        assert!(prices().iter().all(|p| p.ns > 0.0 && p.ns < 1e5));
        assert!(prices().windows(2).all(|p| p[0].ns <= p[1].ns));
    }
}
