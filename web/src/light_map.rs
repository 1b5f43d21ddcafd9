//! A spot light on its round over a baked room: the resting light stays in its map, and the spot alone is baked again.

use serde::Deserialize;
use texmap_lab::demos::MovingSpot;

use crate::answer::Answer;
use crate::baked_room;
use crate::load::Files;

/// A place of the spot.
#[derive(Clone, Debug, Deserialize)]
pub struct MovingLight {
    /// Pixels a side.
    size: u32,
    /// Frame of the round, and frames in it.
    frame: u32,
    of: u32,
    /// A scene or model of the user, in place of the room of the demo.
    file: Option<String>,
    /// The picture alone, without the fresh bake: it comes first.
    #[serde(default)]
    quick: bool,
}

impl MovingLight {
    pub(crate) fn answer(&self, files: &Files) -> Result<Answer, String> {
        if let Some(file) = &self.file {
            let part = f64::from(self.frame) / f64::from(self.of.max(1));
            return baked_room::answer(&files.scene(file, None, 1.0)?, self.size, part, self.quick);
        }
        // The words of the errors would bring every demo of the lab along.
        let refused = |_| "a picture has 128 to 1024 pixels a side".to_owned();
        let spot = MovingSpot::new(self.size).map_err(refused)?;
        let mut answer = Answer::default();
        let name = "resting map plus the map of the spot";
        if self.quick {
            let picture = spot.picture(self.frame, self.of).map_err(refused)?;
            answer.picture(name, &picture);
            return Ok(answer);
        }
        let (picture, claim) = spot.frame(self.frame, self.of).map_err(refused)?;
        answer.picture(name, &picture);
        answer.expected(
            "largest difference to a fresh bake of all lights",
            claim.measured,
            claim.expected,
            "of 255",
        );
        Ok(answer)
    }
}
