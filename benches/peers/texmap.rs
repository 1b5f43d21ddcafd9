//! texmap's side of the race.

use std::time::{Duration, Instant};

use texmap_benches::bench_scenes::{BenchMesh, BenchScene, Content, DEPTH_SIZE, Hidden, Lookup};
use texmap_math::Level;
use texmap_math::glam::DMat4;
use texmap_raster::{BinnedDraws, Cull, DrawCall, RasterError, TargetSize};
use texmap_render::{Frame, RenderSettings, Renderer};
use texmap_sample::Filter;
pub(crate) use texmap_sample::Precision;
use texmap_scene::Scene;

/// Mode in which texmap draws a row: sampler precision, and the treatment of hidden layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mode {
    pub(crate) precision: Precision,
    pub(crate) hidden: Hidden,
}

impl Mode {
    pub(crate) fn name(self) -> &'static str {
        match (self.precision, self.hidden) {
            (Precision::Fast, Hidden::Shaded) => "fast",
            (Precision::Fast, Hidden::Skipped) => "fast-visible",
            (_, Hidden::Shaded) => "exact",
            (_, Hidden::Skipped) => "exact-visible",
        }
    }

    /// The modes in which a row is drawn: `fill` twice, with hidden layers shaded and skipped; without a depth buffer skipped, as
    /// llvmpipe skips them there.
    pub(crate) fn of(scene: &BenchScene) -> Vec<Self> {
        let precisions: &[Precision] = match scene.lookup {
            Lookup::None | Lookup::Flat => &[Precision::Fast],
            _ => &[Precision::Fast, Precision::Exact],
        };
        let hidden: &[Hidden] = match scene.content {
            Content::Layers {
                blend: false,
                depth,
            } => {
                if depth {
                    &[Hidden::Shaded, Hidden::Skipped]
                } else {
                    &[Hidden::Skipped]
                }
            }
            _ => &[Hidden::Shaded],
        };
        let pair = |precision| {
            hidden.iter().map(move |h| Self {
                precision,
                hidden: *h,
            })
        };
        precisions.iter().copied().flat_map(pair).collect()
    }
}

/// One row made ready.
pub(crate) enum Texmap {
    /// A picture.
    Frame {
        renderer: Box<Renderer<'static>>,
        frame: Box<Frame>,
        /// Shadow maps are drawn with each frame.
        with_maps: bool,
    },
    /// A depth map.
    Depth {
        mesh: Box<BenchMesh>,
        clip_from_object: DMat4,
        level: Level,
        pool: rayon::ThreadPool,
        map: Vec<f32>,
    },
}

impl Texmap {
    /// The row, and the time of its first frame: mip chains and buffers are made in it, meshes and images before.
    pub(crate) fn new(
        scene: &BenchScene,
        mode: Mode,
        level: Level,
        threads: usize,
    ) -> Option<(Self, Duration)> {
        let (width, height) = scene.size();
        if let Content::Depth { .. } = scene.content {
            // From -w..w to 0..w, 1 at the near plane.
            let reversed = DMat4::from_cols_array(&[
                1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0, 0.0, 0.5, 1.0,
            ]);
            let clip = DMat4::from_cols_array(&scene.matrix().0.map(f64::from));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let mut this = Self::Depth {
                mesh: Box::new(scene.mesh()),
                clip_from_object: reversed * clip,
                level,
                pool: pool.build().ok()?,
                map: Vec::new(),
            };
            let start = Instant::now();
            this.frame();
            return Some((this, start.elapsed()));
        }
        let data: Scene = scene.scene(mode.precision, mode.hidden).ok()??;
        // One leak a row: the renderer borrows its scene for the whole race.
        let data: &'static Scene = Box::leak(Box::new(data));
        let mut settings = RenderSettings::new(width, height);
        settings.threads = Some(threads);
        settings.level = level;
        if let Content::Sphere { samples, .. } = scene.content {
            settings.msaa = samples;
        }
        let start = Instant::now();
        let renderer = Box::new(Renderer::new(data, &settings).ok()?.turned_over());
        let frame = Box::new(renderer.draw(&texmap_render::no_progress).ok()?);
        let first = start.elapsed();
        let with_maps = scene.content == (Content::Lit { shadow_pass: true });
        let row = Self::Frame {
            renderer,
            frame,
            with_maps,
        };
        Some((row, first))
    }

    pub(crate) fn frame(&mut self) {
        match self {
            Self::Frame {
                renderer,
                frame,
                with_maps,
            } => {
                if *with_maps && let Err(why) = renderer.redraw_shadows() {
                    eprintln!("peers: texmap: {why}");
                }
                let in_order = |blocks| (0..blocks).collect();
                if let Err(why) = renderer.draw_into(frame, &texmap_render::no_progress, &in_order)
                {
                    eprintln!("peers: texmap: {why}");
                }
            }
            Self::Depth {
                mesh,
                clip_from_object,
                level,
                pool,
                map,
            } => {
                let draw = DrawCall {
                    positions: &mesh.positions,
                    indices: &mesh.triangles,
                    clip_from_object: *clip_from_object,
                    cull: Cull::Back,
                    ..DrawCall::default()
                };
                let threads = pool.current_num_threads();
                let drawn = pool.install(|| {
                    let size = TargetSize::new(DEPTH_SIZE, DEPTH_SIZE)?;
                    let prepared = BinnedDraws::with_level(size, &[draw], *level, threads)?;
                    prepared.depth_map_into(threads, map);
                    Ok::<_, RasterError>(())
                });
                if let Err(why) = drawn {
                    eprintln!("peers: texmap: {why}");
                }
            }
        }
    }

    /// RGB rows, top row first; a depth map as 16 bits a pixel, high byte first, 0 at the near plane.
    pub(crate) fn picture(&self) -> Vec<u8> {
        match self {
            Self::Frame { frame, .. } => {
                let pixels = frame.rgba.chunks_exact(4);
                pixels.flat_map(|p| [p[0], p[1], p[2]]).collect()
            }
            Self::Depth { map, .. } => map
                .iter()
                .flat_map(|d| (((1.0 - d) * 65535.0 + 0.5) as u16).to_be_bytes())
                .collect(),
        }
    }
}

/// The reference picture if filters differ by right. `None` for scenes whose pictures must agree value by value.
///
/// The anisotropic floor: 8 x 8 trilinear samples a pixel. Normal maps: the same picture with f32 weights, as light shows twice over
/// what bytes round off normals (with f32 weights in both, `GALLIVM_PERF=no_aos_sampling`, these pictures agree value by value).
pub(crate) fn truth(scene: &BenchScene) -> Option<Vec<u8>> {
    let (width, height) = scene.size();
    let settings = RenderSettings::new(width, height);
    let settings = match (scene.lookup, scene.content) {
        (Lookup::Aniso16, _) => RenderSettings {
            supersample: 8,
            filter: Some(Filter::Trilinear),
            ..settings
        },
        (_, Content::Lit { .. }) => settings,
        _ => return None,
    };
    let data = scene.scene(Precision::Exact, Hidden::Skipped).ok()??;
    let frame = Renderer::new(&data, &settings)
        .ok()?
        .draw(&texmap_render::no_progress)
        .ok()?;
    let pixels = frame.rgba.chunks_exact(4);
    Some(pixels.flat_map(|p| [p[0], p[1], p[2]]).collect())
}
