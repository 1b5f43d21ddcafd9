//! Requests of the pages, and the module that answers each.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::Deserialize;

use crate::answer::Answer;
use crate::charts::Charts;
use crate::draw::Draw;
use crate::edge::Edge;
use crate::footprint::PixelFootprint;
use crate::forward::Forward;
use crate::light_map::MovingLight;
use crate::load::Files;
use crate::mapping::Mapped;
use crate::rectify::Rectify;
use crate::shadow_map::DepthMap;

/// A request of a page; in JSON an object whose `kind` names the variant.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Request {
    /// A scene or model, with its error against a reference.
    Draw(Draw),
    /// One edge seen from the side, and s(t).
    Edge(Edge),
    /// Texel to pixel against pixel to texel.
    Forward(Forward),
    /// A photo through four points.
    Rectify(Rectify),
    /// A pixel in the texture.
    Footprint(PixelFootprint),
    /// The depth map of a light.
    DepthMap(DepthMap),
    /// A spot light that moves over a baked room.
    LightMap(MovingLight),
    /// An environment in another layout, and a ball that mirrors it.
    Charts(Charts),
    /// A mapping of a model with its distortion.
    Mapping(Mapped),
}

/// A request with texts that stand in for files while it is answered.
#[derive(Clone, Debug, Deserialize)]
struct Asked {
    #[serde(default)]
    texts: BTreeMap<String, String>,
    #[serde(flatten)]
    request: Request,
}

/// Answers a request in JSON. Its member `texts` may hold further files by their names.
///
/// # Errors
/// A sentence for the user: bad JSON, or the fault of the scene with its line.
pub fn answer(files: &Files, json: &str) -> Result<Answer, String> {
    let asked: Asked =
        serde_json::from_str(json).map_err(|e| format!("the request is not valid: {e}"))?;
    let files = match asked.texts.is_empty() {
        true => Cow::Borrowed(files),
        false => {
            let mut files = files.clone();
            files.add(
                asked
                    .texts
                    .into_iter()
                    .map(|(name, text)| (name.into(), text.into_bytes())),
            );
            Cow::Owned(files)
        }
    };
    let files = files.as_ref();
    match asked.request {
        Request::Draw(draw) => draw.answer(files),
        Request::Edge(edge) => Ok(edge.answer()),
        Request::Forward(forward) => forward.answer(files),
        Request::Rectify(rectify) => rectify.answer(files),
        Request::Footprint(footprint) => footprint.answer(files),
        Request::DepthMap(map) => map.answer(files),
        Request::LightMap(light) => light.answer(files),
        Request::Charts(charts) => charts.answer(files),
        Request::Mapping(mapped) => mapped.answer(files),
    }
}
