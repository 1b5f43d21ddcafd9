//! A scene or model with its error against a reference.

use serde::Deserialize;
use texmap_io::scene_file::words;
use texmap_render::{Aov, Frame, RenderSettings, no_progress, render};
use texmap_scene::Scene;

use crate::answer::Answer;
use crate::aov;
use crate::camera::CameraAt;
use crate::compare::{self, Compared};
use crate::load::Files;

/// A picture of a scene.
#[derive(Clone, Debug, Deserialize)]
pub struct Draw {
    /// Name of the scene or model.
    file: String,
    /// Its text, for one that is no file.
    text: Option<String>,
    /// Width and height in pixels.
    size: [u32; 2],
    #[serde(flatten)]
    methods: Methods,
    camera: Option<CameraAt>,
    /// An array to show beside the picture.
    aov: Option<String>,
    /// The picture that this one is compared with.
    reference: Option<Reference>,
    /// Texels of the texture's width and height, where shifts of it are measured.
    texels: Option<[f64; 2]>,
    /// Tell the camera, for pages that move it.
    #[serde(default)]
    where_from: bool,
}

/// Overrides, as the flags of `texmap render` of these names.
#[derive(Clone, Debug, Default, Deserialize)]
pub(crate) struct Methods {
    interp: Option<String>,
    filter: Option<String>,
    wrap: Option<String>,
    supersample: Option<u32>,
    msaa: Option<u32>,
}

/// A picture that counts as right.
#[derive(Clone, Debug, Deserialize)]
struct Reference {
    /// Another text than the picture's.
    text: Option<String>,
    #[serde(flatten)]
    methods: Methods,
    /// The f64 reference by rays, one a pixel, instead of the renderer, at this width and height: it is slow.
    rays: Option<[u32; 2]>,
    /// The largest shift in closed form, texels.
    expected: Option<f64>,
    /// The largest difference of a colour in closed form, of 1.
    expected_color: Option<f64>,
}

impl Methods {
    pub(crate) fn settings(
        &self,
        [width, height]: [u32; 2],
        model: bool,
    ) -> Result<RenderSettings, String> {
        let interp = |text: &String| words::parse_interp(text).ok_or(words::INTERPS);
        let sampled = self.supersample.is_some();
        let msaa = self.msaa.unwrap_or(if model && !sampled { 4 } else { 1 });
        Ok(RenderSettings {
            interp: self
                .interp
                .as_ref()
                .map(interp)
                .transpose()
                .map_err(one_of)?,
            filter: parsed(self.filter.as_ref(), words::FILTERS)?,
            wrap: parsed(self.wrap.as_ref(), words::WRAPS)?,
            supersample: self.supersample.unwrap_or(1),
            msaa,
            ..RenderSettings::new(width, height)
        })
    }
}

fn parsed<T: std::str::FromStr>(text: Option<&String>, names: &str) -> Result<Option<T>, String> {
    let parse = |text: &String| text.parse().map_err(|_| one_of(names));
    text.map(parse).transpose()
}

fn one_of(names: &str) -> String {
    format!("expected one of {names}")
}

/// Draws a scene with its displaced meshes and billboards.
pub(crate) fn frame(scene: &Scene, settings: &RenderSettings) -> Result<Frame, String> {
    let shaped = texmap_mesh::tessellate(scene, settings.width).map_err(|e| e.to_string())?;
    render(&shaped, settings, &no_progress).map_err(|e| e.to_string())
}

/// As [`frame`], where the scene is given by its name.
pub(crate) fn drawn(
    files: &Files,
    file: &str,
    text: Option<&str>,
    settings: &RenderSettings,
) -> Result<(Scene, Frame), String> {
    let aspect = f64::from(settings.width) / f64::from(settings.height.max(1));
    let scene = files.scene(file, text, aspect)?;
    let frame = frame(&scene, settings)?;
    Ok((scene, frame))
}

impl Draw {
    pub(crate) fn answer(&self, files: &Files) -> Result<Answer, String> {
        let [width, height] = self.size;
        let aspect = f64::from(width) / f64::from(height.max(1));
        let model = !self.file.to_ascii_lowercase().ends_with(".scene");
        let text = self.text.as_deref();
        let mut scene = files.scene(&self.file, text, aspect)?;
        if let Some(camera) = &self.camera {
            camera.set(&mut scene);
        }
        let mut settings = self.methods.settings(self.size, model)?;
        let shown = self.aov.as_ref().map(|name| name.parse::<Aov>());
        let shown = shown.transpose().map_err(|e| e.to_string())?;
        settings.aovs.extend(shown);
        let shifts = self.reference.is_some() && self.texels.is_some();
        if shifts && shown != Some(Aov::Uv) {
            settings.aovs.push(Aov::Uv);
        }
        let mut drawn = frame(&scene, &settings)?;
        let mut answer = Answer::default();
        if self.where_from {
            let camera = [scene.camera.eye, scene.camera.look, scene.camera.up];
            let names = ["eye", "look", "up"]
                .into_iter()
                .flat_map(|of| ["x", "y", "z"].map(|axis| format!("{of} {axis}")));
            for (name, value) in names.zip(camera.map(|v| v.to_array()).as_flattened()) {
                answer.figure(name, *value, "camera");
            }
            answer.figure("fov", scene.camera.fov_x.to_degrees(), "camera");
        }
        let array = shown.and_then(|aov| aov::picture(&drawn, aov).map(|p| (aov, p)));
        let compared = match &self.reference {
            None => None,
            Some(reference) => Some(self.compared(files, &scene, &drawn, reference, model)?),
        };
        drawn.aovs.clear();
        answer.frame("picture", drawn);
        if let Some((aov, picture)) = array {
            answer.picture(aov.name(), &picture);
        }
        if let Some(compared) = compared {
            let right = self.reference.as_ref();
            let expected = |of: fn(&Reference) -> Option<f64>| right.and_then(of);
            compared.tell(
                &mut answer,
                expected(|r| r.expected),
                expected(|r| r.expected_color),
            );
        }
        Ok(answer)
    }

    fn compared(
        &self,
        files: &Files,
        scene: &Scene,
        drawn: &Frame,
        reference: &Reference,
        model: bool,
    ) -> Result<Compared, String> {
        if let Some(size) = reference.rays {
            let small = frame(scene, &self.methods.settings(size, model)?)?;
            let truth = texmap_truth::frame(scene, size[0], size[1], 1);
            return Ok(compare::with_truth(
                &small,
                &truth.map_err(|e| e.to_string())?,
            ));
        }
        let mut other;
        let scene = match &reference.text {
            None => scene,
            Some(text) => {
                let aspect = f64::from(drawn.width) / f64::from(drawn.height);
                other = files.scene(&self.file, Some(text), aspect)?;
                if let Some(camera) = &self.camera {
                    camera.set(&mut other);
                }
                &other
            }
        };
        let mut settings = reference.methods.settings(self.size, model)?;
        if self.texels.is_some() {
            settings.aovs.push(Aov::Uv);
        }
        Ok(compare::with_frame(
            drawn,
            &frame(scene, &settings)?,
            self.texels,
        ))
    }
}
