//! Times of methods measured in turns, so that whatever disturbs the machine disturbs all of them alike.

use super::Point;
use std::time::{Duration, Instant};

/// Amount of work for a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Runs of each method.
    pub rounds: usize,
    /// Least duration of one run of a method.
    pub run: Duration,
    /// Samples a side of a pixel in supersampled truths.
    pub grid: usize,
}

impl Effort {
    /// For a first look: all panels in half a minute or so.
    pub const QUICK: Self = Self {
        rounds: 7,
        run: Duration::from_micros(300),
        grid: 16,
    };
    /// For figures that are published.
    pub const FULL: Self = Self {
        rounds: 21,
        run: Duration::from_millis(3),
        grid: 48,
    };
}

/// Nanoseconds an item on one thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Time {
    /// Median of the runs.
    pub median: f64,
    /// The 95 % quantile.
    pub p95: f64,
    /// Shortest run: what a busy machine disturbs least.
    pub best: f64,
}

/// Times functions that work through `items` items each: a warm-up, then `effort.rounds` rounds in which each runs
/// once, repeated until it has lasted `effort.run`.
pub fn interleaved(effort: Effort, items: usize, runs: &mut [Box<dyn FnMut() + '_>]) -> Vec<Time> {
    let once = |run: &mut dyn FnMut()| {
        let start = Instant::now();
        run();
        start.elapsed().max(Duration::from_nanos(50))
    };
    let repeats: Vec<u32> = runs
        .iter_mut()
        .map(|run| {
            once(run);
            let warm = once(run);
            (effort.run.as_secs_f64() / warm.as_secs_f64())
                .ceil()
                .max(1.0) as u32
        })
        .collect();
    let mut samples = vec![Vec::with_capacity(effort.rounds); runs.len()];
    for _ in 0..effort.rounds {
        for ((run, &repeats), samples) in runs.iter_mut().zip(&repeats).zip(&mut samples) {
            let start = Instant::now();
            for _ in 0..repeats {
                run();
            }
            let each = start.elapsed().as_secs_f64() * 1e9 / f64::from(repeats);
            samples.push(each / items.max(1) as f64);
        }
    }
    let summary = |samples: &mut Vec<f64>| Time {
        median: texmap_truth::metrics::quantile(samples, 0.5),
        p95: texmap_truth::metrics::quantile(samples, 0.95),
        best: samples.iter().copied().fold(f64::INFINITY, f64::min),
    };
    samples.iter_mut().map(summary).collect()
}

/// Times the functions of some points ([`interleaved`]).
pub(super) fn timed(
    points: &mut [Point],
    effort: Effort,
    items: usize,
    runs: &mut [Box<dyn FnMut() + '_>],
) {
    let times = interleaved(effort, items, runs);
    for (point, time) in points.iter_mut().zip(times) {
        point.time = Some(time);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_runs_in_every_round() {
        let counts = [std::cell::Cell::new(0u32), std::cell::Cell::new(0)];
        let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
        for count in &counts {
            runs.push(Box::new(|| {
                count.set(count.get() + 1);
                std::thread::sleep(Duration::from_micros(20));
            }));
        }
        let effort = Effort {
            rounds: 3,
            run: Duration::from_nanos(1),
            grid: 1,
        };
        let times = interleaved(effort, 10, &mut runs);
        assert_eq!(counts.each_ref().map(std::cell::Cell::get), [5, 5]);
        assert!(
            times
                .iter()
                .all(|t| t.median >= 2000.0 && t.p95 >= t.median)
        );
    }
}
