//! Purple Cow Doom: a walk through the room of the lecture. Walls stop, a door opens, cows wander.
//!
//! Time runs in steps of 1/60 second, and everything follows from the inputs: the same inputs give the same frames everywhere.

use texmap_math::deterministic_f64::{atan2, sin_cos};
use texmap_math::glam::{DMat4, DVec2, DVec3};
use texmap_raster::Interp;
use texmap_render::{Frame, RenderSettings, Renderer, no_progress, render};
use texmap_sample::{ColorSpace, Filter, Origin, Texture2d};
use texmap_scene::{AlphaMode, Material, Mesh, Scene, Shading, TextureRole, TextureSlot};

use crate::load::Files;

/// The input of a player in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input {
    /// Sum of [`FORWARD`](Self::FORWARD) and the others.
    pub buttons: u32,
    /// Turn to the left, radians, beside that of the buttons.
    pub turn: f64,
    /// Turn upwards, radians.
    pub raise: f64,
}

impl Input {
    /// Walk ahead.
    pub const FORWARD: u32 = 1;
    /// Walk backwards.
    pub const BACK: u32 = 2;
    /// Step to the left.
    pub const LEFT: u32 = 4;
    /// Step to the right.
    pub const RIGHT: u32 = 8;
    /// Turn to the left.
    pub const TURN_LEFT: u32 = 16;
    /// Turn to the right.
    pub const TURN_RIGHT: u32 = 32;
    /// Open or close the door that is near.
    pub const USE: u32 = 64;
    /// Walk faster.
    pub const RUN: u32 = 128;
}

/// The room, its player and its cows.
#[derive(Debug)]
pub struct Room {
    scene: Scene,
    frame: Option<Frame>,
    eye: DVec2,
    yaw: f64,
    pitch: f64,
    /// Openness of the door, 0 to 1, and the way that it goes.
    door: f64,
    opening: bool,
    held: bool,
    cows: Vec<Cow>,
    random: u32,
    door_mesh: usize,
    cow_meshes: std::ops::Range<usize>,
    base: DMat4,
    first_card: usize,
    /// Material of the first picture of the cow, and its texture.
    first_view: usize,
    first_picture: usize,
    /// Pictures of the cow that are taken, and the scene that they are taken in.
    views: usize,
    studio: Scene,
}

#[derive(Clone, Copy, Debug)]
struct Cow {
    at: DVec2,
    ahead: DVec2,
    /// Steps until it thinks again, and whether it walks until then.
    steps: u32,
    walks: bool,
}

/// Height of the eye, as in the lecture.
const EYE: f64 = 6.0;
const WALK: f64 = 0.13;
const TURN: f64 = 0.035;
/// Radius of the player and of cows; a cow is longer than wide.
const PLAYER: f64 = 0.9;
const COW: f64 = 2.2;

/// Least and largest x and y that the floor has.
const FLOOR: [f64; 4] = [-20.0, -20.0, 15.0, 20.0];
/// Things on it: pillar, the wall left and right of the door, fence, plant.
const SOLID: [[f64; 4]; 5] = [
    [5.0, 10.0, 10.0, 15.0],
    [-20.0, -0.4, -4.0, 0.4],
    [1.0, -0.4, 15.0, 0.4],
    [-18.0, -9.1, -8.0, -8.9],
    [12.0, -17.5, 14.5, -15.0],
];
const DOOR: [f64; 4] = [-4.0, -0.4, 1.0, 0.4];

/// Cows as meshes, then those that are cards.
const MESHES: usize = 2;
const COWS: [[f64; 2]; 6] = [
    [6.0, -7.0],
    [-6.0, 6.0],
    [-14.0, 14.0],
    [11.0, 6.0],
    [-9.0, -5.0],
    [2.0, 16.0],
];
/// Pictures of the cow from around it.
const VIEWS: usize = 8;
const VIEW_SIZE: u32 = 192;
/// Width and height of a card, and the distance at which its pictures were taken.
const CARD: f64 = 7.6;
const CARD_FROM: f64 = 26.0;

impl Room {
    /// The room with its cows where they begin.
    ///
    /// # Errors
    /// A file of the scene is missing.
    pub fn new(files: &Files) -> Result<Self, String> {
        let mut scene = files.scene("room.scene", Some(include_str!("room.scene")), 1.6)?;
        // Chains that lie ready are not rebuilt for each frame.
        scene.textures = scene
            .textures
            .into_iter()
            .map(Texture2d::with_mips)
            .collect();
        let named = |name: &str| {
            let found = scene
                .meshes
                .iter()
                .position(|mesh| mesh.name.starts_with(name));
            found.ok_or_else(|| format!("the room has no {name}"))
        };
        let (door_mesh, first) = (named("door")?, named("cow")?);
        let count = scene.meshes.len() - first;
        let base = scene.meshes[first].world_from_object;
        let studio = Scene {
            meshes: scene.meshes[first..].to_vec(),
            background: [0.0; 4],
            ..scene.clone()
        };
        let (first_view, first_picture) = empty_views(&mut scene)?;
        for _ in 1..MESHES {
            let again: Vec<Mesh> = scene.meshes[first..first + count].to_vec();
            scene.meshes.extend(again);
        }
        let first_card = scene.meshes.len();
        let half = (CARD / 2.0) as f32;
        let card = Mesh::quad([
            [-half, 0.0, half],
            [half, 0.0, half],
            [half, 0.0, -half],
            [-half, 0.0, -half],
        ]);
        let cards = COWS[MESHES..].iter().map(|_| card.clone());
        scene.meshes.extend(cards);
        let cows = COWS.map(|at| Cow {
            at: at.into(),
            ahead: DVec2::X,
            steps: 0,
            walks: false,
        });
        Ok(Self {
            scene,
            frame: None,
            eye: DVec2::new(-1.5, -17.0),
            yaw: std::f64::consts::FRAC_PI_2,
            pitch: 0.0,
            door: 0.0,
            opening: false,
            held: false,
            cows: cows.into(),
            random: 0x2545_f491,
            door_mesh,
            cow_meshes: first..first + count,
            base,
            first_card,
            first_view,
            first_picture,
            views: 0,
            studio,
        })
    }

    /// Takes the next picture of the cow for its cards, which are not seen without; false if all are taken. A room that is walked through
    /// takes one a frame, so that its first frame comes soon.
    ///
    /// # Errors
    /// The renderer refuses the cow.
    pub fn photograph(&mut self) -> Result<bool, String> {
        if self.views == VIEWS {
            return Ok(false);
        }
        let texture = photograph(&mut self.studio, self.views)?;
        self.scene.textures[self.first_picture + self.views] = texture;
        self.views += 1;
        Ok(true)
    }

    /// One step of 1/60 second.
    pub fn step(&mut self, input: Input) {
        let pressed = |button: u32| f64::from(u8::from(input.buttons & button != 0));
        self.yaw += input.turn + TURN * (pressed(Input::TURN_LEFT) - pressed(Input::TURN_RIGHT));
        self.pitch = (self.pitch + input.raise).clamp(-0.6, 0.6);
        let (sin, cos) = sin_cos(self.yaw);
        let (ahead, left) = (DVec2::new(cos, sin), DVec2::new(-sin, cos));
        let wish = ahead * (pressed(Input::FORWARD) - pressed(Input::BACK))
            + left * (pressed(Input::LEFT) - pressed(Input::RIGHT));
        let speed = if input.buttons & Input::RUN != 0 {
            2.0 * WALK
        } else {
            WALK
        };
        let wish = wish.normalize_or_zero() * speed;
        // Along a wall one slides.
        for way in [DVec2::new(wish.x, 0.0), DVec2::new(0.0, wish.y)] {
            let to = self.eye + way;
            let nearer = |cow: &Cow| {
                (cow.at - to).length() < COW + PLAYER
                    && (cow.at - to).length() < (cow.at - self.eye).length()
            };
            if !self.blocked(to, PLAYER) && !self.cows.iter().any(nearer) {
                self.eye = to;
            }
        }
        let using = input.buttons & Input::USE != 0;
        let near = self.eye.distance(DVec2::new(-1.5, 0.0)) < 7.0;
        if using && !self.held && near {
            self.opening = !self.opening;
        }
        self.held = using;
        // Nothing is crushed.
        let free = self.opening || !self.in_doorway();
        if free {
            let way = if self.opening { 0.02 } else { -0.02 };
            self.door = (self.door + way).clamp(0.0, 1.0);
        }
        for i in 0..self.cows.len() {
            self.wander(i);
        }
    }

    fn in_doorway(&self) -> bool {
        let inside = |at: DVec2, r: f64| overlaps(&DOOR, at, r);
        inside(self.eye, PLAYER) || self.cows.iter().any(|cow| inside(cow.at, COW))
    }

    fn blocked(&self, at: DVec2, radius: f64) -> bool {
        let [x0, y0, x1, y1] = FLOOR;
        let outside =
            at.x < x0 + radius || at.x > x1 - radius || at.y < y0 + radius || at.y > y1 - radius;
        outside
            || SOLID.iter().any(|solid| overlaps(solid, at, radius))
            || (self.door < 0.9 && overlaps(&DOOR, at, radius))
    }

    fn wander(&mut self, i: usize) {
        let mut cow = self.cows[i];
        if cow.steps == 0 {
            let draw = self.draw();
            let (sin, cos) = sin_cos(f64::from(draw % 64) / 64.0 * std::f64::consts::TAU);
            cow.walks = draw & 0x300 != 0;
            cow.steps = 60 + (draw >> 12) % 180;
            if cow.walks {
                cow.ahead = DVec2::new(cos, sin);
            }
        }
        cow.steps -= 1;
        if cow.walks {
            let to = cow.at + cow.ahead * 0.035;
            let others = self.cows.iter().enumerate();
            let near = |at: DVec2, reach: f64| {
                at.distance(to) < reach && at.distance(to) < at.distance(cow.at)
            };
            let crowded = others
                .into_iter()
                .any(|(j, other)| j != i && near(other.at, 2.0 * COW));
            if self.blocked(to, COW) || crowded || near(self.eye, COW + PLAYER) {
                cow.steps = 0;
            } else {
                cow.at = to;
            }
        }
        self.cows[i] = cow;
    }

    /// Xorshift of 32 bits (Marsaglia 2003).
    fn draw(&mut self) -> u32 {
        let mut x = self.random;
        x ^= x << 13;
        x ^= x >> 17;
        x ^= x << 5;
        self.random = x;
        x
    }

    /// Draws the frame of the present; `affine` leaves the division out.
    ///
    /// # Errors
    /// A size that is refused.
    pub fn frame(
        &mut self,
        [width, height]: [u32; 2],
        filter: Filter,
        affine: bool,
    ) -> Result<&Frame, String> {
        self.place();
        let settings = RenderSettings {
            filter: Some(filter),
            interp: affine.then_some(Interp::Affine),
            ..RenderSettings::new(width, height)
        };
        let renderer = Renderer::new(&self.scene, &settings).map_err(|e| e.to_string())?;
        let kept = self
            .frame
            .take()
            .filter(|f| (f.width, f.height) == (width, height));
        let drawn = match kept {
            Some(mut frame) => renderer
                .draw_into(&mut frame, &no_progress, &|blocks| (0..blocks).collect())
                .map(|()| frame),
            None => renderer.draw(&no_progress),
        };
        Ok(self.frame.insert(drawn.map_err(|e| e.to_string())?))
    }

    /// The frame that was drawn last.
    #[must_use]
    pub fn last(&self) -> Option<&Frame> {
        self.frame.as_ref()
    }

    /// Puts camera, door and cows of the scene where they are.
    fn place(&mut self) {
        let (sin, cos) = sin_cos(self.yaw);
        let (up, level) = sin_cos(self.pitch);
        let eye = self.eye.extend(EYE);
        self.scene.camera.eye = eye;
        self.scene.camera.look = eye + DVec3::new(cos * level, sin * level, up);
        let lifted = DMat4::from_translation(DVec3::new(0.0, 0.0, 6.8 * self.door));
        self.scene.meshes[self.door_mesh].world_from_object = lifted;
        let parts = self.cow_meshes.len();
        for (i, cow) in self.cows.iter().enumerate() {
            if i < MESHES {
                let world = standing(cow.at, cow.ahead) * self.base;
                let first = match i {
                    0 => self.cow_meshes.start,
                    i => self.cow_meshes.end + (i - 1) * parts,
                };
                for mesh in &mut self.scene.meshes[first..first + parts] {
                    mesh.world_from_object = world;
                }
                continue;
            }
            let to_eye = (self.eye - cow.at).normalize_or(DVec2::NEG_Y);
            // The card's front looks along -y of its own space.
            let across = DVec2::new(-to_eye.y, to_eye.x);
            let world = DMat4::from_translation(DVec3::new(0.0, 0.0, CARD / 2.0 - 1.55))
                * standing(cow.at, across);
            let mesh = &mut self.scene.meshes[self.first_card + i - MESHES];
            mesh.world_from_object = world;
            mesh.material = self.first_view + view_of(cow.ahead, to_eye);
        }
    }
}

/// A thing on the floor whose x axis looks along `ahead`.
fn standing(at: DVec2, ahead: DVec2) -> DMat4 {
    DMat4::from_cols(
        ahead.extend(0.0).extend(0.0),
        DVec3::new(-ahead.y, ahead.x, 0.0).extend(0.0),
        DVec3::Z.extend(0.0),
        at.extend(0.0).extend(1.0),
    )
}

fn overlaps([x0, y0, x1, y1]: &[f64; 4], at: DVec2, radius: f64) -> bool {
    let nearest = at.clamp(DVec2::new(*x0, *y0), DVec2::new(*x1, *y1));
    at.distance(nearest) < radius
}

fn around(view: usize) -> DVec2 {
    let (sin, cos) = sin_cos(view as f64 / VIEWS as f64 * std::f64::consts::TAU);
    DVec2::new(cos, sin)
}

/// The picture of a cow that looks along `ahead`, seen from the direction `to_eye`.
fn view_of(ahead: DVec2, to_eye: DVec2) -> usize {
    let seen = DVec2::new(ahead.dot(to_eye), ahead.perp_dot(to_eye));
    let nearer = |a: &usize, b: &usize| around(*a).dot(seen).total_cmp(&around(*b).dot(seen));
    (0..VIEWS).max_by(nearer).unwrap_or(0)
}

/// Materials and textures for the pictures of the cow, still without any; the first of each.
fn empty_views(scene: &mut Scene) -> Result<(usize, usize), String> {
    let first = (scene.materials.len(), scene.textures.len());
    for _ in 0..VIEWS {
        let texture = view_texture(1, vec![0; 4])?;
        let mut slot = TextureSlot::new(scene.textures.len());
        slot.sampler.wrap_u = texmap_sample::Wrap::ClampToEdge;
        slot.sampler.wrap_v = texmap_sample::Wrap::ClampToEdge;
        scene.textures.push(texture);
        scene.materials.push(Material {
            base_color: Some(slot),
            texture_role: TextureRole::Decal,
            shading: Shading::Unlit,
            alpha: AlphaMode::Test(0.5),
            ..Material::default()
        });
    }
    Ok(first)
}

fn view_texture(size: u32, rgba: Vec<u8>) -> Result<Texture2d<'static>, String> {
    let texture = Texture2d::from_rgba8(size, size, rgba, ColorSpace::Srgb, Origin::TopLeft);
    Ok(texture.map_err(|e| e.to_string())?.with_mips())
}

/// A picture of the cow from one of the directions around it.
fn photograph(studio: &mut Scene, view: usize) -> Result<Texture2d<'static>, String> {
    let from = around(view) * CARD_FROM;
    let middle = DVec3::new(0.0, 0.0, CARD / 2.0 - 1.55);
    studio.camera.eye = middle + from.extend(2.0);
    studio.camera.look = middle;
    studio.camera.fov_x = 2.0 * atan2(CARD / 2.0, CARD_FROM);
    let settings = RenderSettings {
        supersample: 4,
        ..RenderSettings::new(VIEW_SIZE, VIEW_SIZE)
    };
    let frame = render(studio, &settings, &no_progress).map_err(|e| e.to_string())?;
    view_texture(VIEW_SIZE, frame.rgba)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_card_shows_the_side_that_is_seen() {
        // The cow looks along +y and is seen from +y: its front, the first picture.
        assert_eq!(view_of(DVec2::Y, DVec2::Y), 0);
        assert_eq!(view_of(DVec2::Y, DVec2::NEG_Y), VIEWS / 2);
        assert_eq!(view_of(DVec2::X, DVec2::Y), VIEWS / 4);
    }

    #[test]
    fn walls_stop_and_open_ground_does_not() {
        assert!(overlaps(&SOLID[0], DVec2::new(4.5, 12.0), PLAYER));
        assert!(!overlaps(&SOLID[0], DVec2::new(3.0, 12.0), PLAYER));
    }

    fn room() -> Room {
        let names = [
            "textures/carpet.gif",
            "textures/ceilingtile.gif",
            "textures/walls.gif",
            "textures/fence.png",
            "textures/leaf.png",
            "textures/cow.png",
            "models/cow.obj",
            "models/cow.mtl",
        ];
        let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
        let mut files = Files::new();
        files.add(names.map(|name| (name.into(), std::fs::read(assets.join(name)).unwrap())));
        Room::new(&files).unwrap()
    }

    #[test]
    fn the_door_alone_is_lifted() {
        let room = room();
        let [x0, y0, x1, y1] = DOOR;
        let within = |p: &[f32; 3]| {
            (x0..=x1).contains(&f64::from(p[0])) && (y0..=y1).contains(&f64::from(p[1]))
        };
        assert!(
            room.scene.meshes[room.door_mesh]
                .positions
                .iter()
                .all(within)
        );
        let walls = room.scene.meshes.iter().find(|mesh| mesh.name == "walls");
        assert!(!walls.unwrap().positions.iter().all(within));
    }

    #[test]
    fn the_door_stops_until_it_is_open() {
        let mut room = room();
        let walk = |room: &mut Room, steps: u32, buttons: u32| {
            (0..steps).for_each(|_| {
                room.step(Input {
                    buttons,
                    ..Input::default()
                });
            });
        };
        walk(&mut room, 150, Input::FORWARD);
        assert!(room.eye.y < DOOR[1] - PLAYER + WALK, "{}", room.eye);
        walk(&mut room, 1, Input::USE);
        walk(&mut room, 60, 0);
        walk(&mut room, 60, Input::FORWARD);
        assert!(room.eye.y > DOOR[3], "{}", room.eye);
    }

    #[test]
    fn the_recorded_walk_goes_through_the_door() {
        let mut room = room();
        crate::walk::play(&mut room, [64, 40], 0, false).unwrap();
        assert!(
            room.door > 0.9 && room.eye.y > DOOR[3] + PLAYER,
            "{}",
            room.eye
        );
    }
}
