//! A spot light on its round over a baked room: the resting light stays in its map, and the spot alone is baked anew.

use serde::Deserialize;
use texmap_lab::demos::MovingSpot;

use crate::answer::Answer;

/// A place of the spot.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct MovingLight {
    /// Pixels a side.
    size: u32,
    /// Frame of the round, and frames in it.
    frame: u32,
    of: u32,
}

impl MovingLight {
    pub(crate) fn answer(self) -> Result<Answer, String> {
        // The words of the errors would bring every demo of the lab along.
        let refused = |_| "a picture has 128 to 1024 pixels a side".to_owned();
        let spot = MovingSpot::new(self.size).map_err(refused)?;
        let (picture, claim) = spot.frame(self.frame, self.of).map_err(refused)?;
        let mut answer = Answer::default();
        answer.picture("resting map plus the map of the spot", &picture);
        answer.expected(
            "largest difference to a fresh bake of all lights",
            claim.measured,
            claim.expected,
            "of 255",
        );
        Ok(answer)
    }
}
