//! The words of normal maps: `normalmap`.

use texmap_light::Green;

use super::{Effect, none};
use crate::IoError;
use crate::scene_file::args::Args;
use crate::scene_file::print::{texture_name, word};

/// A `normalmap` line.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalMapLine {
    /// The map.
    pub file: String,
    /// Normals of the object, not of its tangent frames.
    pub object_space: bool,
    /// Which way green points.
    pub green: Green,
    /// Only red and green are read.
    pub rebuild_z: bool,
}

pub(super) fn parse(args: &Args<'_>) -> Result<Effect, IoError> {
    if args.len() == 1 && none(args) {
        return Ok(Effect::NormalMap(None));
    }
    args.within(1, 4, "none, or FILE [tangent|object] [up|down] [xyz|xy]")?;
    let mut line = NormalMapLine {
        file: args.text(0).to_owned(),
        object_space: false,
        green: Green::Up,
        rebuild_z: false,
    };
    for i in 1..args.len() {
        match args.text(i) {
            "tangent" => line.object_space = false,
            "object" => line.object_space = true,
            "up" => line.green = Green::Up,
            "down" => line.green = Green::Down,
            "xyz" => line.rebuild_z = false,
            "xy" => line.rebuild_z = true,
            _ => return Err(args.unknown(i, "tangent, object, up, down, xyz, xy")),
        }
    }
    Ok(Effect::NormalMap(Some(line)))
}

/// The values after the word.
pub(super) fn print(out: &mut String, line: &NormalMapLine) {
    texture_name(out, &line.file);
    word(
        out,
        if line.object_space {
            "object"
        } else {
            "tangent"
        },
    );
    word(
        out,
        if line.green == Green::Up {
            "up"
        } else {
            "down"
        },
    );
    word(out, if line.rebuild_z { "xy" } else { "xyz" });
}

#[cfg(test)]
mod tests {
    use crate::scene_file::Command;
    use crate::scene_file::parse::{assert_faults, assert_reads_back};

    #[test]
    fn every_normal_map_reads_back() {
        assert_reads_back(
            |c| matches!(c, Command::Effect(_)),
            &["normalmap n.png object down xy\n", "normalmap none\n"],
        );
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[("normalmap a.png left", "unknown-word", 17)]);
    }
}
