//! The depth map of a light as a picture: near is light, far is dark, the background white (MIT 6.837, lecture 18, slide 27).

use serde::Deserialize;
use texmap_light::ShadowMap;
use texmap_render::shadow_map;
use texmap_scene::shadow_fit::shadow_kind;
use texmap_truth::picture::Picture;

use crate::answer::Answer;
use crate::compare;
use crate::draw::{self, Methods};
use crate::load::Files;

/// A scene with a shadow, and the map of its first light that casts one.
#[derive(Clone, Debug, Deserialize)]
pub struct DepthMap {
    text: String,
    size: [u32; 2],
    /// Texels a side of the picture of the map.
    map: u32,
    /// Compare with shadows by rays at this width and height: they are slow.
    rays: Option<[u32; 2]>,
}

impl DepthMap {
    pub(crate) fn answer(&self, files: &Files) -> Result<Answer, String> {
        let settings = Methods::default().settings(self.size, false)?;
        let (scene, frame) = draw::drawn(files, "page.scene", Some(&self.text), &settings)?;
        let compared = match self.rays {
            None => None,
            Some(size) => {
                let small = draw::frame(&scene, &Methods::default().settings(size, false)?)?;
                let truth = texmap_truth::frame(&scene, size[0], size[1], 1);
                let truth = truth.map_err(|e| e.to_string())?;
                Some(compare::with_truth(&small, &truth))
            }
        };
        let mut answer = Answer::default();
        answer.frame("picture", frame);
        if let Some(shadow) = scene.effects.shadows.first() {
            let kind = shadow_kind(&scene, shadow.light, shadow.area).map_err(|e| e.to_string())?;
            let map = shadow_map(&scene, &kind, self.map.clamp(16, 1024), 1)
                .map_err(|e| e.to_string())?;
            answer.picture("the light's depth map", &depths(&map));
        }
        if let Some(compared) = compared {
            compared.tell(&mut answer, None, None);
        }
        Ok(answer)
    }
}

fn depths(map: &ShadowMap) -> Picture {
    let size = map.size();
    let all = (0..size * size).filter_map(|i| map.depth_at(0, i % size, i / size));
    let finite = all.filter(|d| d.is_finite());
    let (near, far) = finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), d| {
        (a.min(d), b.max(d))
    });
    Picture::from_fn(size, size, |x, y| match map.depth_at(0, x, y) {
        Some(depth) if depth.is_finite() => {
            let part = (depth - near) / (far - near).max(f32::MIN_POSITIVE);
            let grey = (235.0 - 215.0 * part) as u8;
            [grey, grey, grey, 255]
        }
        _ => [255; 4],
    })
}
