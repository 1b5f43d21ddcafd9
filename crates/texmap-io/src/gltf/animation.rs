//! Animations: the nodes and weights at a time.

use std::collections::BTreeMap;

use texmap_math::deterministic_f64::{atan2, sin};

use super::json::AnimationSampler;
use super::model::Model;
use super::nodes::Trs;
use crate::IoError;

/// The pose that an animation sets, by node.
#[derive(Debug, Default)]
pub(super) struct Pose {
    /// Translation, rotation and scale of every node that has one of them animated.
    pub(super) places: BTreeMap<usize, Trs>,
    pub(super) weights: BTreeMap<usize, Vec<f64>>,
    /// Channels that move something else.
    pub(super) ignored: usize,
}

impl Pose {
    fn place<'p>(&'p mut self, model: &Model<'_>, node: usize) -> &'p mut Trs {
        let rest = || Trs::of(&model.document.nodes[node]);
        self.places.entry(node).or_insert_with(rest)
    }
}

/// The pose of the animation `index` at `time`, seconds; the first and the last key hold beyond them.
pub(super) fn pose(model: &Model<'_>, index: usize, time: f64) -> Result<Pose, IoError> {
    let animation = &model.document.animations[index];
    let mut pose = Pose::default();
    for (c, channel) in animation.channels.iter().enumerate() {
        let at = format!("/animations/{index}/channels/{c}");
        let Some(node) = channel.target.node else {
            pose.ignored += 1;
            continue;
        };
        let target = model.item(
            &model.document.nodes,
            node,
            &format!("{at}/target/node"),
            "node",
        )?;
        let sampler = model.item(
            &animation.samplers,
            channel.sampler,
            &format!("{at}/sampler"),
            "sampler",
        )?;
        let at = format!("/animations/{index}/samplers/{}", channel.sampler);
        match channel.target.path.as_str() {
            "translation" | "rotation" | "scale" if target.matrix.is_some() => pose.ignored += 1,
            "translation" => {
                pose.place(model, node).translation = keys::<3>(model, sampler, &at)?.three(time);
            }
            "scale" => pose.place(model, node).scale = keys::<3>(model, sampler, &at)?.three(time),
            "rotation" => {
                pose.place(model, node).rotation = keys::<4>(model, sampler, &at)?.rotation(time);
            }
            "weights" => {
                let weights = keys::<1>(model, sampler, &at)?.at(time);
                pose.weights.insert(node, weights);
            }
            _ => pose.ignored += 1,
        }
    }
    Ok(pose)
}

/// The last key of an animation, seconds; 0 without one that can be read.
pub(super) fn seconds(model: &Model<'_>, index: usize) -> f64 {
    let samplers = &model.document.animations[index].samplers;
    let last = samplers.iter().enumerate().filter_map(|(s, sampler)| {
        let at = format!("/animations/{index}/samplers/{s}/input");
        let times = model
            .accessor(sampler.input, &at)
            .ok()?
            .floats::<1>()
            .ok()?;
        times.last().map(|[t]| f64::from(*t))
    });
    last.fold(0.0, f64::max)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// The keys of a sampler.
#[derive(Debug)]
struct Keys {
    /// Seconds, rising.
    times: Vec<f64>,
    /// `width` numbers a key; three times as many for a spline: tangent before, value, tangent after.
    values: Vec<f64>,
    width: usize,
    interpolation: Interpolation,
}

fn keys<const N: usize>(
    model: &Model<'_>,
    sampler: &AnimationSampler,
    at: &str,
) -> Result<Keys, IoError> {
    let interpolation = match sampler.interpolation.as_deref() {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        Some(other) => {
            let problem = format!(
                "`{}` is none of LINEAR, STEP, CUBICSPLINE",
                crate::shortened(other)
            );
            return Err(model.broken(&format!("{at}/interpolation"), problem));
        }
    };
    let at_input = format!("{at}/input");
    let times = model.accessor(sampler.input, &at_input)?.floats::<1>()?;
    if times.windows(2).any(|w| w[0] >= w[1]) {
        return Err(model.broken(&at_input, "times must rise"));
    }
    let at_output = format!("{at}/output");
    let values = model.accessor(sampler.output, &at_output)?.floats::<N>()?;
    let parts = if interpolation == Interpolation::CubicSpline {
        3
    } else {
        1
    };
    let per_key = values.len() / times.len();
    // Weights have several values a key, vectors one.
    let fits =
        per_key * times.len() == values.len() && per_key.is_multiple_of(parts) && per_key > 0;
    if !fits || (N > 1 && per_key != parts) {
        let problem = format!(
            "{} values for {} keys of {parts}",
            values.len(),
            times.len()
        );
        return Err(model.broken(&at_output, problem));
    }
    Ok(Keys {
        times: times.into_iter().map(|[t]| f64::from(t)).collect(),
        values: values.into_iter().flatten().map(f64::from).collect(),
        width: per_key / parts * N,
        interpolation,
    })
}

impl Keys {
    /// Index of the last key at or before `time`, and the fraction of the way to the next one.
    fn find(&self, time: f64) -> (usize, f64) {
        let next = self.times.partition_point(|t| *t <= time);
        let Some(key) = next.checked_sub(1) else {
            return (0, 0.0);
        };
        match self.times.get(next) {
            Some(end) => (key, (time - self.times[key]) / (end - self.times[key])),
            None => (key, 0.0),
        }
    }

    /// Part 0, 1 or 2 (the value) of a spline's key, or the value of another one.
    fn part(&self, key: usize, part: usize) -> &[f64] {
        let start = match self.interpolation {
            Interpolation::CubicSpline => 3 * key + part,
            _ => key,
        };
        &self.values[start * self.width..][..self.width]
    }

    fn at(&self, time: f64) -> Vec<f64> {
        const VALUE: usize = 1;
        let (key, share) = self.find(time);
        let from = self.part(key, VALUE);
        if share == 0.0 || self.interpolation == Interpolation::Step {
            return from.to_vec();
        }
        let to = self.part(key + 1, VALUE);
        if self.interpolation == Interpolation::Linear {
            return from
                .iter()
                .zip(to)
                .map(|(a, b)| a + (b - a) * share)
                .collect();
        }
        let (after, before) = (self.part(key, 2), self.part(key + 1, 0));
        let span = self.times[key + 1] - self.times[key];
        let hermite = |i: usize| {
            let t = share;
            let (t2, t3) = (t * t, t * t * t);
            (2.0 * t3 - 3.0 * t2 + 1.0) * from[i]
                + span * (t3 - 2.0 * t2 + t) * after[i]
                + (3.0 * t2 - 2.0 * t3) * to[i]
                + span * (t3 - t2) * before[i]
        };
        (0..self.width).map(hermite).collect()
    }

    fn three(&self, time: f64) -> [f64; 3] {
        let at = self.at(time);
        [at[0], at[1], at[2]]
    }

    /// A quaternion; on the great circle between two keys of linear interpolation.
    fn rotation(&self, time: f64) -> [f64; 4] {
        let four = |q: &[f64]| [q[0], q[1], q[2], q[3]];
        let (key, share) = self.find(time);
        if share == 0.0 || self.interpolation != Interpolation::Linear {
            return four(&self.at(time));
        }
        slerp(four(self.part(key, 1)), four(self.part(key + 1, 1)), share)
    }
}

/// The rotation at a fraction of the way from `a` to `b`, the shorter way (Shoemake 1985).
fn slerp(a: [f64; 4], b: [f64; 4], share: f64) -> [f64; 4] {
    let unit = |q: [f64; 4]| {
        let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length > 0.0 {
            q.map(|c| c / length)
        } else {
            [0.0, 0.0, 0.0, 1.0]
        }
    };
    let (a, mut b) = (unit(a), unit(b));
    let dot: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    if dot < 0.0 {
        b = b.map(|c| -c);
    }
    let length = |sign: f64| {
        let squares = a
            .iter()
            .zip(&b)
            .map(|(a, b)| (a + sign * b) * (a + sign * b));
        squares.sum::<f64>().sqrt()
    };
    // Exact for small angles, where the cosine says little.
    let angle = 2.0 * atan2(length(-1.0), length(1.0));
    let whole = sin(angle);
    let (from, to) = match whole > 1e-12 {
        true => (
            sin((1.0 - share) * angle) / whole,
            sin(share * angle) / whole,
        ),
        false => (1.0 - share, share),
    };
    std::array::from_fn(|i| from * a[i] + to * b[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(interpolation: Interpolation, width: usize, values: &[f64]) -> Keys {
        Keys {
            times: vec![1.0, 3.0, 4.0],
            values: values.to_vec(),
            width,
            interpolation,
        }
    }

    #[test]
    fn steps_lines_and_the_ends() {
        let line = keys(Interpolation::Linear, 1, &[10.0, 20.0, 0.0]);
        let step = keys(Interpolation::Step, 1, &[10.0, 20.0, 0.0]);
        for (time, on_line, on_step) in [
            (-5.0, 10.0, 10.0),
            (1.0, 10.0, 10.0),
            (1.5, 12.5, 10.0),
            (3.0, 20.0, 20.0),
            (3.75, 5.0, 20.0),
            (4.0, 0.0, 0.0),
            (9.0, 0.0, 0.0),
        ] {
            assert_eq!(
                (line.at(time), step.at(time)),
                (vec![on_line], vec![on_step]),
                "{time}"
            );
        }
    }

    /// A cubic is its own spline: values and slopes of t^3 - 2t give it back between the keys.
    #[test]
    fn splines_are_exact_on_cubics() {
        let (value, slope) = (|t: f64| t * t * t - 2.0 * t, |t: f64| 3.0 * t * t - 2.0);
        let all: Vec<f64> = [1.0, 3.0, 4.0]
            .iter()
            .flat_map(|&t| [slope(t), value(t), slope(t)])
            .collect();
        let spline = keys(Interpolation::CubicSpline, 1, &all);
        for time in [1.0, 1.3, 2.0, 2.9, 3.0, 3.5, 4.0] {
            assert!((spline.at(time)[0] - value(time)).abs() < 1e-12, "{time}");
        }
        // With the tangents of a key exchanged for others it is another curve.
        let wrong: Vec<f64> = all.chunks(3).flat_map(|k| [k[1], k[1], k[0]]).collect();
        let wrong = keys(Interpolation::CubicSpline, 1, &wrong);
        assert!((wrong.at(2.0)[0] - value(2.0)).abs() > 0.1);
    }

    /// Halves and thirds of a turn about one axis, the short way, at even speed.
    #[test]
    fn rotations_keep_their_speed() {
        let about_z = |degrees: f64| {
            let half = 0.5 * degrees.to_radians();
            [
                0.0,
                0.0,
                sin(half),
                texmap_math::deterministic_f64::cos(half),
            ]
        };
        let near = |a: [f64; 4], b: [f64; 4]| a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-14);
        for share in [0.0, 0.25, 1.0 / 3.0, 0.5, 1.0] {
            assert!(
                near(
                    slerp(about_z(10.0), about_z(130.0), share),
                    about_z(10.0 + 120.0 * share)
                ),
                "{share}"
            );
            // 350 degrees are 10 back; the quaternion of the other sign is the same rotation.
            let back = slerp(about_z(0.0), about_z(350.0), share);
            assert!(near(back, about_z(-10.0 * share)), "{share} {back:?}");
            let tiny = slerp(about_z(0.0), about_z(1e-9), share);
            assert!((tiny[2] - sin(0.5 * (1e-9 * share).to_radians())).abs() < 1e-24);
        }
        // A straight line between the quaternions is late at a quarter of the way.
        let (a, b) = (about_z(0.0), about_z(120.0));
        let line: [f64; 4] = std::array::from_fn(|i| a[i] + 0.25 * (b[i] - a[i]));
        let length = line.iter().map(|c| c * c).sum::<f64>().sqrt();
        assert!(!near(line.map(|c| c / length), about_z(30.0)));
    }
}
