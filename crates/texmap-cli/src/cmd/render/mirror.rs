//! `--mirror`: flat meshes that mirror the scene.

use std::str::FromStr;

use texmap_bake::{PlanarMirror, with_planar_mirrors};
use texmap_scene::Scene;

use crate::cmd::render::draw::Context;
use crate::failure::Failure;

/// A mesh by its name, and the share of mirrored light in what is seen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MirrorArg {
    name: String,
    share: f32,
}

/// The share where none is given.
const SHARE: f32 = 0.5;

impl FromStr for MirrorArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, share) = match text.rsplit_once('=') {
            Some((name, share)) => (name, share.parse().ok()),
            None => (text, Some(SHARE)),
        };
        let share = share.filter(|share| (0.0..=1.0).contains(share));
        match (name, share) {
            ("", _) => Err("expected the name of a mesh".to_owned()),
            (_, None) => Err("expected NAME=SHARE with a share of 0 to 1".to_owned()),
            (name, Some(share)) => Ok(Self {
                name: name.to_owned(),
                share,
            }),
        }
    }
}

impl Context<'_> {
    /// The scene with its mirrors for the present camera; `None` without any.
    pub(super) fn mirrored(&self, scene: &Scene) -> Result<Option<Scene>, Failure> {
        if self.args.mirror.is_empty() {
            return Ok(None);
        }
        let mut mirrors = Vec::new();
        for mirror in &self.args.mirror {
            let named = scene.meshes.iter().enumerate();
            let named = named.filter(|(_, mesh)| mesh.name == mirror.name);
            let before = mirrors.len();
            mirrors.extend(named.map(|(mesh, _)| PlanarMirror {
                mesh,
                share: mirror.share,
            }));
            if mirrors.len() == before {
                let mut names: Vec<&str> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
                names.dedup();
                return Err(Failure::usage(
                    format!("--mirror {}: no mesh of this name", mirror.name),
                    format!("choose from {}", names.join(", ")),
                ));
            }
        }
        // Two samples a pixel see between the pixels of a mirror of the picture's own size.
        let n = self.args.supersample.unwrap_or(1);
        let size = self.args.resolution;
        let pixels = (size.width * n, size.height * n);
        let mirrored = with_planar_mirrors(scene, &mirrors, pixels);
        mirrored.map(Some).map_err(|e| self.refused(e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_follow_names() {
        let of = |text: &str| text.parse::<MirrorArg>().map(|m| (m.name, m.share));
        assert_eq!(of("floor"), Ok(("floor".into(), 0.5)));
        assert_eq!(of("a=b=0.25"), Ok(("a=b".into(), 0.25)));
        for bad in ["", "=1", "floor=2", "floor=x"] {
            assert!(of(bad).is_err(), "{bad}");
        }
    }
}
