//! The module's face to JavaScript.

use wasm_bindgen::prelude::wasm_bindgen;

use crate::answer::Answer;
use crate::load::Files;
use crate::request;
use crate::room::{Input, Room};
use crate::walk;
use texmap_io::image_io::encode_png;

/// The lab: files, and the answer to the last request.
#[wasm_bindgen]
#[derive(Debug, Default)]
pub struct Lab {
    files: Files,
    answer: Answer,
}

#[wasm_bindgen]
impl Lab {
    /// A lab without files.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new() -> Self {
        Self {
            files: Files::new(),
            answer: Answer::default(),
        }
    }

    /// Adds a file, in place of one of its name.
    pub fn add(&mut self, name: String, bytes: Vec<u8>) {
        self.files.add([(name.into(), bytes)]);
    }

    /// Takes a file away.
    pub fn remove(&mut self, name: &str) {
        self.files.remove(name.as_ref());
    }

    /// Answers a request in JSON with the figures, the warnings and the place of each picture, in JSON too.
    ///
    /// # Errors
    /// The fault and its remedy.
    pub fn ask(&mut self, request: &str) -> Result<String, String> {
        self.answer = request::answer(&self.files, request)?;
        let panels = self.answer.panels.iter().map(|panel| {
            serde_json::json!({
                "name": panel.name, "width": panel.width, "height": panel.height, "hash": panel.hash(),
                "at": panel.rgba.as_ptr() as usize, "bytes": panel.rgba.len(),
            })
        });
        let panels: Vec<_> = panels.collect();
        let answer = serde_json::json!({
            "panels": panels, "figures": self.answer.figures, "warnings": self.answer.warnings,
        });
        Ok(answer.to_string())
    }

    /// A picture of the last answer as a PNG file, the bytes that `texmap render` writes.
    ///
    /// # Errors
    /// There is no such picture.
    pub fn png(&self, panel: usize) -> Result<Vec<u8>, String> {
        let panel = self
            .answer
            .panels
            .get(panel)
            .ok_or("there is no such picture")?;
        let mut bytes = Vec::new();
        let written = encode_png(&mut bytes, panel.width, panel.height, &panel.rgba);
        written.map(|()| bytes).map_err(|e| e.to_string())
    }

    /// The room of the lecture, to walk through.
    ///
    /// # Errors
    /// A file is missing.
    pub fn room(&self) -> Result<RoomWalk, String> {
        Room::new(&self.files).map(|room| RoomWalk { room })
    }
}

/// A walk through the room.
#[wasm_bindgen]
#[derive(Debug)]
pub struct RoomWalk {
    room: Room,
}

#[wasm_bindgen]
impl RoomWalk {
    /// One step of 1/60 second: buttons, and turns of the mouse in radians.
    pub fn step(&mut self, buttons: u32, turn: f64, raise: f64) {
        self.room.step(Input {
            buttons,
            turn,
            raise,
        });
    }

    /// Draws a frame and returns the place of its pixels in memory.
    ///
    /// # Errors
    /// An unknown filter, or a size that is refused.
    pub fn draw(
        &mut self,
        width: u32,
        height: u32,
        filter: &str,
        affine: bool,
    ) -> Result<usize, String> {
        let filter = filter.parse().map_err(|_| "unknown filter")?;
        if self.room.last().is_some() {
            self.room.photograph()?;
        }
        let frame = self.room.frame([width, height], filter, affine)?;
        Ok(frame.rgba.as_ptr() as usize)
    }

    /// Plays the recorded walk from here and returns the hash of its last frame.
    ///
    /// # Errors
    /// A size that is refused.
    pub fn play(&mut self, width: u32, height: u32, every: u32) -> Result<String, String> {
        walk::play(&mut self.room, [width, height], every, false).map(texmap_render::pixel_hash)
    }

    /// Steps of the recorded walk.
    #[must_use]
    pub fn frames(&self) -> u32 {
        walk::RECORDED.iter().map(|(steps, _)| steps).sum()
    }

    /// Hash of the last frame.
    #[must_use]
    pub fn hash(&self) -> String {
        self.room
            .last()
            .map(texmap_render::pixel_hash)
            .unwrap_or_default()
    }

    /// Pixels of the last frame that a surface covers.
    #[must_use]
    pub fn pixels(&self) -> f64 {
        self.room
            .last()
            .map_or(0.0, |frame| frame.stats.pixels_covered as f64)
    }

    /// Triangles of the last frame that reached a tile.
    #[must_use]
    pub fn triangles(&self) -> f64 {
        self.room
            .last()
            .map_or(0.0, |frame| frame.stats.triangles_drawn as f64)
    }
}
