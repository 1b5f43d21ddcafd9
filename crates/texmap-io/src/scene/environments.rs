//! Environments that surfaces mirror, and light that was gathered from them.

use std::collections::HashMap;
use std::path::PathBuf;

use texmap_light::{Environment, EnvironmentLayout, ReflectionBox};
use texmap_scene::Reflection;

use super::build::Builder;
use crate::scene_file::Line;
use crate::textures::Content;
use crate::{IoError, environment_io};

/// Environments that are read once.
pub(super) type Known = HashMap<(PathBuf, &'static str, Use), usize>;

/// The use of an environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Use {
    /// The environment itself, with smaller levels or without.
    Shown { mips: bool },
    /// Gathered with the exponent of these bits.
    Gathered(u32),
}

/// `env`.
pub(super) fn reflection(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    b.settings.effects.reflection = match line.takes("none") {
        true => None,
        false => {
            let (path, chart, reflectivity) = (b.beside(line), line.parsed(), line.float());
            let (mut mips, mut walls, mut center, mut map) = (false, None, None, None);
            while let Some(word) = line.word() {
                match word {
                    "mips" => mips = true,
                    "box" => walls = Some((line.floats(), line.floats())),
                    "at" => center = Some(line.floats()),
                    _ => map = Some(b.load(line, Content::Data)?),
                }
            }
            b.settings.effects.reflectivity = map;
            Some(Reflection {
                environment: b.environment(path, line, chart, Use::Shown { mips })?,
                reflectivity,
                within: within(line, walls, center)?,
            })
        }
    };
    Ok(())
}

/// The walls of a reflection, seen from their middle if no other point is given.
fn within(
    line: &Line<'_>,
    walls: Option<([f32; 3], [f32; 3])>,
    center: Option<[f32; 3]>,
) -> Result<Option<ReflectionBox>, IoError> {
    let shape = |problem: &str| IoError::BadShape {
        location: line.location.clone(),
        problem: format!("`env`: {problem}"),
    };
    let Some((low, high)) = walls else {
        return match center {
            Some(_) => Err(shape(
                "`at` is the point from which a `box` is seen, and there is no box",
            )),
            None => Ok(None),
        };
    };
    let middle = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
    let center = center.unwrap_or(middle);
    if !(0..3).all(|k| low[k] < center[k] && center[k] < high[k]) {
        return Err(shape("the point after `at` must lie within the `box`"));
    }
    Ok(Some(ReflectionBox { low, high, center }))
}

/// `specmap`.
pub(super) fn specular_map(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    b.settings.effects.specular_map = match line.takes("none") {
        true => None,
        false => {
            let (path, chart) = (b.beside(line), line.parsed());
            let gathered = Use::Gathered(line.float().to_bits());
            Some(b.environment(path, line, chart, gathered)?)
        }
    };
    Ok(())
}

impl Builder {
    /// Index of the environment of a file for a use.
    pub(super) fn environment(
        &mut self,
        path: PathBuf,
        line: &Line<'_>,
        chart: EnvironmentLayout,
        purpose: Use,
    ) -> Result<usize, IoError> {
        let key = (path, chart.name(), purpose);
        if let Some(&index) = self.environments.get(&key) {
            return Ok(index);
        }
        let (path, location) = (&key.0, &line.location);
        let read = environment_io::read_named(&self.textures.source, path, chart, Some(location))?;
        let light = match purpose {
            Use::Shown { mips: false } => read,
            Use::Shown { mips: true } => read.with_mips(),
            Use::Gathered(bits) => {
                let exponent = f32::from_bits(bits);
                let size = Environment::blurred_size(exponent);
                let map = read.specular_map(EnvironmentLayout::Cube, size, exponent);
                map.map_err(|e| IoError::BrokenImage {
                    path: path.clone(),
                    named_by: Some(location.clone()),
                    problem: e.to_string(),
                })?
            }
        };
        self.scene.effects.environments.push(light);
        let index = self.scene.effects.environments.len() - 1;
        self.environments.insert(key, index);
        Ok(index)
    }
}

#[cfg(test)]
mod tests {
    use crate::scene_file::{assert_faults, assert_reads_back};

    #[test]
    fn every_line_reads_back() {
        assert_reads_back(&[
            "env sky.hdr lat-long 0.5 mips\n",
            "env sky.hdr lat-long 0.5\n",
            "env cow.exr cube 1 box -2 0 -2 2 3 2 at 0 1 0.5\n",
            "env cow.exr cube 1 mips map shine.png\n",
            "env none\n",
            "specmap lamps.exr tan-cube 40\n",
            "specmap none\n",
        ]);
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("env a.png cube 1 levels", "unknown-word", 18),
            ("env a.png cube", "argument-count", 1),
            ("env a.png ball 1", "unknown-word", 11),
            ("env a.png cube 2", "out-of-range", 16),
            ("env a.png cube 1 box 0 0 0 1 1 0", "out-of-range", 32),
            ("env a.png cube 1 box 0 0 0 1 1", "argument-count", 1),
            ("specmap a.png cube -1", "out-of-range", 20),
        ]);
    }
}
