//! Skies and volumes.

use texmap_sample::UvTransform;
use texmap_scene::{Background, Volume};

use super::build::Builder;
use super::environments::Use;
use super::materials::{placed, sampler};
use crate::IoError;
use crate::scene_file::Line;
use crate::textures::Content;

/// `sky`.
pub(super) fn sky(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    b.scene.effects.background = match (line.takes("none"), line.left()) {
        (true, _) => None,
        (false, 1) => {
            let texture = b.load(line, Content::Color)?;
            let slot = b
                .settings
                .slot(texture, UvTransform::default(), true, b.scene.color);
            Some(Background::Picture(slot))
        }
        _ => {
            let (path, chart) = (b.beside(line), line.parsed());
            let shown = Use::Shown { mips: false };
            Some(Background::Environment(
                b.environment(path, line, chart, shown)?,
            ))
        }
    };
    Ok(())
}

/// `volume`.
pub(super) fn volume(b: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
    let path = b.beside(line);
    let grid = b.textures.grid(&path, &line.location, b.settings.missing)?;
    let placed = placed(line.numbers(), line.numbers(), true);
    let density = line.float();
    let step = line.takes("step").then(|| line.float());
    let world_from_volume = b.settings.transform * placed;
    let voxels = b.textures.grids[grid].level_size(0).unwrap_or([1; 3]);
    let sides = [0, 1, 2].map(|k| {
        let side = world_from_volume.col(k).truncate().length();
        side / f64::from(voxels[k])
    });
    let voxel = sides.into_iter().fold(f64::INFINITY, f64::min);
    b.scene.effects.volumes.push(Volume {
        grid,
        sampler: sampler(&b.settings),
        transfer: b.settings.materials.ramp.clone(),
        density,
        step: step.unwrap_or((0.5 * voxel) as f32),
        world_from_volume,
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::scene_file::{assert_faults, assert_reads_back};

    #[test]
    fn every_line_reads_back() {
        assert_reads_back(&[
            "sky clouds.png\n",
            "sky clouds.png lat-long\n",
            "sky none\n",
            "volume fog.npy 0 0 0 2 2 2 1.5\n",
            "volume fog.npy 0 0 0 2 -2 2 1.5 step 0.01\n",
        ]);
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("sky a.png ball", "unknown-word", 11),
            ("volume a.npy 0 0 0 1 1 1", "argument-count", 1),
            ("volume a.npy 0 0 0 1 0 1 1", "out-of-range", 22),
            ("volume a.npy 0 0 0 1 1 1 -1", "out-of-range", 26),
            ("volume a.npy 0 0 0 1 1 1 1 step 0", "out-of-range", 33),
            ("volume a.npy 0 0 0 1 1 1 1 every 1", "unknown-word", 28),
        ]);
    }
}
