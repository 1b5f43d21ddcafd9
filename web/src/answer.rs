//! Answers of the lab: pictures with figures.

use serde::Serialize;
use texmap_render::Frame;
use texmap_truth::picture::Picture;

/// The pictures and figures that a request gives.
#[derive(Debug, Default)]
pub struct Answer {
    /// Pictures, the one that the request is about first.
    pub panels: Vec<Panel>,
    /// Measured figures and their closed forms.
    pub figures: Vec<Figure>,
    /// Sentences of the scene and the renderer.
    pub warnings: Vec<String>,
}

/// A picture with its name.
#[derive(Debug)]
pub struct Panel {
    /// The name, for a caption and for readers of the screen.
    pub name: String,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 4 bytes a pixel, straight alpha, rows top to bottom.
    pub rgba: Vec<u8>,
}

/// A figure with its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// The name.
    pub name: String,
    /// The value; `null` in JSON where it is not finite.
    pub value: f64,
    /// The unit, or empty.
    pub unit: &'static str,
    /// The value in closed form, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<f64>,
}

impl Answer {
    /// Adds a picture.
    pub fn picture(&mut self, name: impl Into<String>, picture: &Picture) {
        self.panels.push(Panel {
            name: name.into(),
            width: picture.width(),
            height: picture.height(),
            rgba: picture.rgba().to_vec(),
        });
    }

    /// Adds a frame.
    pub fn frame(&mut self, name: impl Into<String>, frame: Frame) {
        for warning in frame.warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        self.panels.push(Panel {
            name: name.into(),
            width: frame.width,
            height: frame.height,
            rgba: frame.rgba,
        });
    }

    /// Adds a figure.
    pub fn figure(&mut self, name: impl Into<String>, value: f64, unit: &'static str) {
        self.figures.push(Figure {
            name: name.into(),
            value,
            unit,
            expected: None,
        });
    }

    /// Adds a figure that has a closed form.
    pub fn expected(
        &mut self,
        name: impl Into<String>,
        value: f64,
        expected: f64,
        unit: &'static str,
    ) {
        self.figures.push(Figure {
            name: name.into(),
            value,
            unit,
            expected: Some(expected),
        });
    }
}

impl Panel {
    /// Hash of the decoded pixels, as `texmap hash` prints it.
    #[must_use]
    pub fn hash(&self) -> String {
        texmap_render::hash_pixels(self.width, self.height, &self.rgba)
    }
}
