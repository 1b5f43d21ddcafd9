//! An environment in another layout, and a ball that mirrors it: "What's the best chart?" (MIT 6.837, lecture 18, slide 29).

use serde::Deserialize;
use texmap_light::{Environment, EnvironmentLayout};
use texmap_math::color::linear_to_srgb8;
use texmap_truth::picture::Picture;

use crate::answer::Answer;
use crate::compare;
use crate::draw::{self, Methods};
use crate::load::Files;

/// A scene whose first environment is converted.
#[derive(Clone, Debug, Deserialize)]
pub struct Charts {
    text: String,
    size: [u32; 2],
    layout: String,
    /// Texels of the whole chart, about.
    texels: f64,
}

impl Charts {
    pub(crate) fn answer(&self, files: &Files) -> Result<Answer, String> {
        let aspect = f64::from(self.size[0]) / f64::from(self.size[1].max(1));
        let mut scene = files.scene("page.scene", Some(&self.text), aspect)?;
        let layout: EnvironmentLayout = self.layout.parse().map_err(|_| "unknown layout")?;
        let source = scene
            .effects
            .environments
            .first()
            .cloned()
            .ok_or("the scene has no environment")?;
        let settings = Methods::default().settings(self.size, false)?;
        let right = draw::frame(&scene, &settings)?;
        let faces = layout.faces() as f64 * f64::from(layout.aspect());
        let height = (self.texels.clamp(24.0, 1e6) / faces)
            .sqrt()
            .round()
            .max(2.0) as u32;
        let chart = source.convert(layout, height).map_err(|e| e.to_string())?;
        let panel = faces_of(&chart);
        if let Some(first) = scene.effects.environments.first_mut() {
            *first = chart;
        }
        let drawn = draw::frame(&scene, &settings)?;
        let compared = compare::with_frame(&drawn, &right, None);
        let mut answer = Answer::default();
        answer.frame("a ball that mirrors the chart", drawn);
        answer.picture("the chart", &panel);
        let (width, height) = (f64::from(panel.width()), f64::from(panel.height()));
        answer.figure("texels of the chart", width * height, "");
        compared.tell(&mut answer, None, None);
        Ok(answer)
    }
}

/// All faces below each other, or side by side where that is nearer to a square.
fn faces_of(chart: &Environment) -> Picture {
    let (width, height) = chart.size();
    let faces = chart.layout().faces() as u32;
    let columns = if faces == 6 { 3 } else { faces };
    let texel = |x: u32, y: u32| {
        let face = y / height * columns + x / width;
        let light = chart.texel(face as usize, x % width, y % height);
        let [r, g, b] = light.unwrap_or_default().map(linear_to_srgb8);
        [r, g, b, 255]
    };
    Picture::from_fn(width * columns, height * faces.div_ceil(columns), texel)
}
