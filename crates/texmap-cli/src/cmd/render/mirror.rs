//! `--mirror`: flat meshes that mirror the scene.

use std::str::FromStr;

use texmap_bake::with_planar_mirror;
use texmap_scene::Scene;

use crate::cmd::render::draw::Context;
use crate::failure::Failure;

/// A mesh by its name, and the share of light that it mirrors.
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
        let mut done: Option<Scene> = None;
        for mirror in &self.args.mirror {
            let mut named = scene.meshes.iter().enumerate();
            let found = named.find(|(_, mesh)| mesh.name == mirror.name);
            let Some((mesh, _)) = found else {
                let mut names: Vec<&str> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
                names.dedup();
                return Err(Failure::usage(
                    format!("--mirror {}: no mesh of this name", mirror.name),
                    format!("choose from {}", names.join(", ")),
                ));
            };
            // Two samples a pixel see between the pixels of a mirror of the picture's own size.
            let n = self.args.supersample.unwrap_or(1);
            let size = self.args.resolution;
            let pixels = (size.width * n, size.height * n);
            let one = with_planar_mirror(scene, mesh, mirror.share, pixels);
            let one = one.map_err(|e| self.refused(e))?;
            match &mut done {
                None => done = Some(one),
                Some(all) => adopt(all, one, mesh),
            }
        }
        Ok(done)
    }
}

/// Takes a mirror over from a scene that has it alone.
fn adopt(all: &mut Scene, mut one: Scene, mesh: usize) {
    let (Some(picture), Some(mut material)) = (one.textures.pop(), one.materials.pop()) else {
        return;
    };
    all.textures.push(picture);
    if let Some(map) = material.emission.as_mut().and_then(|e| e.map.as_mut()) {
        map.texture = all.textures.len() - 1;
    }
    all.materials.push(material);
    let mut mirror = one.meshes.swap_remove(mesh);
    mirror.material = all.materials.len() - 1;
    all.meshes[mesh] = mirror;
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
