//! The faces of an environment as pictures: below each other, one file each, or unfolded into a cross.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use texmap_light::{Environment, EnvironmentLayout};

/// Arrangement of the faces of a cube in pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Faces {
    /// One picture, +X -X +Y -Y +Z -Z below each other
    #[default]
    Strip,
    /// Six pictures: sky.exr gives sky.px.exr, nx, py, ny, pz, nz
    Files,
    /// One picture, four faces wide and three high: -X +Z +X -Z in the middle row, +Y above +Z and -Y below it; black elsewhere
    Cross,
}

/// A picture of linear light.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    /// Part of its name before the ending.
    pub(super) suffix: Option<&'static str>,
    pub(super) width: u32,
    pub(super) height: u32,
    /// Rows from top to bottom.
    pub(super) texels: Vec<[f32; 3]>,
}

impl Picture {
    /// `sky.exr` becomes `sky.px.exr`.
    pub(super) fn name(&self, path: &Path) -> PathBuf {
        match self.suffix {
            Some(suffix) => with_suffix(path, suffix),
            None => path.to_owned(),
        }
    }
}

/// `sky.exr` and `level0` become `sky.level0.exr`.
pub(super) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let ending = path.extension().unwrap_or_default();
    let mut last = std::ffi::OsString::from(format!("{suffix}."));
    last.push(ending);
    path.with_extension(last)
}

/// In the order of the faces of a cube.
const NAMES: [&str; 6] = ["px", "nx", "py", "ny", "pz", "nz"];
/// Column and row of each face in the cross.
const CROSS: [(u32, u32); 6] = [(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (3, 1)];

impl Faces {
    /// False for a way that only cubes have.
    pub(super) fn fit(self, layout: EnvironmentLayout) -> bool {
        self == Self::Strip || layout.faces() == 6
    }

    /// The pictures of an environment that [fits](Self::fit).
    pub(super) fn pictures(self, environment: &Environment) -> Vec<Picture> {
        let (width, height) = environment.size();
        let faces = environment.layout().faces();
        let texel = |face: usize, x: u32, y: u32| environment.texel(face, x, y).unwrap_or_default();
        let face = |face: usize| {
            let places = (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
            places.map(move |(x, y)| texel(face, x, y))
        };
        match self {
            Self::Strip => vec![Picture {
                suffix: None,
                width,
                height: height * faces as u32,
                texels: (0..faces).flat_map(face).collect(),
            }],
            Self::Files => {
                let each = NAMES.into_iter().zip(0..faces);
                each.map(|(name, f)| Picture {
                    suffix: Some(name),
                    width,
                    height,
                    texels: face(f).collect(),
                })
                .collect()
            }
            Self::Cross => {
                let places = (0..3 * height).flat_map(|y| (0..4 * width).map(move |x| (x, y)));
                let at = |(x, y): (u32, u32)| {
                    let cell = (x / width, y / height);
                    let face = CROSS.iter().position(|place| *place == cell);
                    face.map_or([0.0; 3], |face| texel(face, x % width, y % height))
                };
                vec![Picture {
                    suffix: None,
                    width: 4 * width,
                    height: 3 * height,
                    texels: places.map(at).collect(),
                }]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky() -> Environment {
        let light = |d: texmap_math::glam::DVec3| d.to_array().map(|x| x as f32);
        Environment::from_fn(EnvironmentLayout::Cube, 16, light).unwrap()
    }

    #[test]
    fn the_faces_of_a_cross_meet_at_their_edges() {
        let cross = &Faces::Cross.pictures(&sky())[0];
        assert_eq!((cross.width, cross.height), (64, 48));
        let at = |x: u32, y: u32| cross.texels[(y * 64 + x) as usize];
        let near = |a: (u32, u32), b: (u32, u32)| {
            let apart = at(a.0, a.1)
                .into_iter()
                .zip(at(b.0, b.1))
                .map(|(a, b)| (a - b).abs());
            apart.fold(0.0f32, f32::max) < 0.15
        };
        for k in 0..16 {
            // Around the middle row, and above and below +Z.
            assert!(near((15, 16 + k), (16, 16 + k)) && near((31, 16 + k), (32, 16 + k)));
            assert!(near((47, 16 + k), (48, 16 + k)) && near((63, 16 + k), (0, 16 + k)));
            assert!(near((16 + k, 15), (16 + k, 16)) && near((16 + k, 31), (16 + k, 32)));
        }
        // The sides of +Y touch nothing in the picture.
        assert_eq!(at(0, 0), [0.0; 3]);
        assert!(!near((15, 8), (16, 8)));
    }

    #[test]
    fn files_and_strip_hold_the_same_faces() {
        let sky = sky();
        let strip = &Faces::Strip.pictures(&sky)[0];
        let files = Faces::Files.pictures(&sky);
        let all: Vec<[f32; 3]> = files.iter().flat_map(|f| f.texels.clone()).collect();
        assert_eq!(all, strip.texels);
        let names: Vec<PathBuf> = files
            .iter()
            .map(|f| f.name(Path::new("a/sky.exr")))
            .collect();
        assert_eq!(names[3], Path::new("a/sky.ny.exr"));
        assert!(!Faces::Files.fit(EnvironmentLayout::LatLong));
        assert!(Faces::Cross.fit(EnvironmentLayout::TanCube));
    }
}
