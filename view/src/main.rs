//! `texmap-view FILE`: a window on a scene or model. It orbits and walks, changes methods by keys, and reads the files again when they
//! change.
//!
//! With `--frames N --exit` it draws N frames of a fixed walk, prints the hash of the last and ends: for tests without a person.

mod arguments;
mod controls;
mod eye;
mod model;
mod watch;

use std::process::ExitCode;
use std::time::Instant;

use minifb::{Key, KeyRepeat, MouseButton, MouseMode, Scale, ScaleMode, Window, WindowOptions};
use texmap_render::{Aov, AovData, Frame, RenderSettings, no_progress, pixel_hash, render};

use crate::arguments::Arguments;
use crate::controls::Methods;
use crate::eye::Eye;
use crate::model::Model;

const HELP: &str = "\
texmap-view FILE [--size WxH] [--frames N --exit]
  FILE           a scene (.scene) or a model (.obj, .gltf, .glb, .ply, .stl)
  --size WxH     size of the window [default: 960x720]
  --frames N     draw so many frames of a fixed walk
  --exit         end after them and print the hash of the last
Keys: drag or arrows orbit, W A S D and Q E walk, wheel or + - nearer and farther, F filter, I interpolation, T wrap, O array,
      L lines, M samples, R read again, Home first view, Escape ends.";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(4)
        }
    }
}

fn run() -> Result<(), String> {
    let Some(arguments) = Arguments::read(std::env::args_os().skip(1))? else {
        println!("{HELP}");
        return Ok(());
    };
    let (width, height) = arguments.size;
    let mut model = Model::read(&arguments.file, f64::from(width) / f64::from(height))?;
    let mut eye = Eye::of(&model.scene.camera);
    let mut methods = Methods::default();
    let options = WindowOptions {
        resize: true,
        scale: Scale::X1,
        scale_mode: ScaleMode::AspectRatioStretch,
        ..WindowOptions::default()
    };
    let mut window = Window::new("texmap", width as usize, height as usize, options)
        .map_err(|e| format!("there is no window: {e}\n  start it within X11 or Wayland's XWayland, or under xvfb-run"))?;
    window.set_target_fps(if arguments.exit { 0 } else { 60 });

    let mut shown: Vec<u32> = Vec::new();
    let mut last_mouse = None;
    let mut stale = true;
    let mut frame = None;
    let mut count = 0u32;
    while window.is_open() && !window.is_key_down(Key::Escape) {
        let scripted = arguments.frames.is_some_and(|frames| count < frames);
        if scripted {
            eye.script(count);
            stale = true;
        } else if arguments.exit {
            break;
        }
        let mouse = window.get_mouse_pos(MouseMode::Pass);
        let dragged = window.get_mouse_down(MouseButton::Left);
        if let (true, Some((x, y)), Some((x0, y0))) = (dragged, mouse, last_mouse)
            && (x, y) != (x0, y0)
        {
            let (dx, dy): (f32, f32) = (x - x0, y - y0);
            eye.orbit(f64::from(dx) * -0.4, f64::from(dy) * 0.4);
            stale = true;
        }
        last_mouse = mouse;
        if let Some((_, wheel)) = window.get_scroll_wheel()
            && wheel != 0.0
        {
            eye.zoom(f64::from(-wheel.signum()) * 0.08);
            stale = true;
        }
        stale |= eye.keys(&window);
        for key in window.get_keys_pressed(KeyRepeat::No) {
            if key == Key::Home {
                eye.home();
                stale = true;
            }
            stale |= methods.key(key);
        }
        if window.is_key_pressed(Key::R, KeyRepeat::No) || model.changed() {
            // A file that is half written is read again at its next change; the picture stays meanwhile.
            match model.again(&arguments.file) {
                Ok(()) => {
                    // Models have the camera that frames them: a change of their shape is no other view.
                    eye.again(&model.scene.camera, model.is_scene);
                    stale = true;
                }
                Err(error) => eprintln!("warning: {error}"),
            }
        }
        if stale {
            let began = Instant::now();
            eye.set(&mut model.scene);
            match draw(&model, &methods, arguments.size) {
                Ok(drawn) => {
                    let milliseconds = began.elapsed().as_secs_f64() * 1e3;
                    window.set_title(&format!(
                        "{} · {} · {milliseconds:.1} ms",
                        model.name,
                        methods.words()
                    ));
                    shown = methods.shown(&drawn);
                    frame = Some(drawn);
                }
                // An edited file may be refused: the picture stays until it is right again.
                Err(error) if frame.is_some() && !arguments.exit => eprintln!("warning: {error}"),
                Err(error) => return Err(error),
            }
            stale = false;
            count += 1;
        }
        window
            .update_with_buffer(&shown, width as usize, height as usize)
            .map_err(|e| e.to_string())?;
    }
    if let (true, Some(frame)) = (arguments.exit, &frame) {
        println!(
            "{} frames, buffer {}, picture {}",
            count,
            controls::hash(&shown, arguments.size),
            pixel_hash(frame)
        );
    }
    Ok(())
}

fn draw(model: &Model, methods: &Methods, (width, height): (u32, u32)) -> Result<Frame, String> {
    let shaped = texmap_mesh::tessellate(&model.scene, width).map_err(|e| e.to_string())?;
    let settings = RenderSettings {
        filter: methods.filter(),
        interp: methods.interp(),
        wrap: methods.wrap(),
        msaa: methods.msaa(model.is_scene),
        aovs: methods.aovs(),
        ..RenderSettings::new(width, height)
    };
    let mut frame = render(&shaped, &settings, &no_progress).map_err(|e| e.to_string())?;
    let depth = frame.aovs.iter().find(|(aov, ..)| *aov == Aov::Depth);
    if let (true, Some((_, _, AovData::F32(depth)))) = (methods.lines, depth) {
        texmap_mesh::wireframe(&shaped, [width, height], depth, &mut frame.rgba, None);
    }
    Ok(frame)
}
