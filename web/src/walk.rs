//! A recorded walk through the room: through the door, around a cow, past the pillar.

use texmap_render::Frame;
use texmap_sample::Filter;

use crate::room::{Input, Room};

/// Steps and the buttons that are held through them.
pub const RECORDED: [(u32, u32); 12] = [
    (90, Input::FORWARD),
    (1, Input::USE),
    (70, 0),
    (80, Input::FORWARD | Input::RUN),
    (20, Input::TURN_LEFT),
    (60, Input::FORWARD),
    (45, Input::TURN_RIGHT),
    (90, Input::FORWARD | Input::TURN_RIGHT),
    (60, Input::FORWARD | Input::LEFT),
    (50, Input::TURN_LEFT | Input::BACK),
    (60, Input::FORWARD | Input::RUN),
    (30, Input::TURN_LEFT),
];

/// Plays the recorded walk, with a frame of `size` every `every` steps and one at its end, which it returns.
///
/// # Errors
/// As [`Room::frame`].
pub fn play(room: &mut Room, size: [u32; 2], every: u32, affine: bool) -> Result<&Frame, String> {
    while room.photograph()? {}
    let inputs = RECORDED
        .iter()
        .flat_map(|(steps, buttons)| (0..*steps).map(|_| *buttons));
    for (step, buttons) in (0u32..).zip(inputs) {
        room.step(Input {
            buttons,
            ..Input::default()
        });
        if every > 0 && step % every == 0 {
            room.frame(size, Filter::Trilinear, affine)?;
        }
    }
    room.frame(size, Filter::Trilinear, affine)
}
