//! texmap's side of the race.

use texmap_lab::bench_scenes::{BenchScene, Content, Hidden, Lookup};
use texmap_render::{Frame, Renderer, Scene, Settings};
pub(crate) use texmap_sample::Precision;

/// How texmap draws a row: sampler precision, and what happens to hidden layers.
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

    /// The modes in which a row is drawn: `fill` twice, with hidden layers shaded and skipped.
    pub(crate) fn of(scene: &BenchScene) -> Vec<Self> {
        let precisions: &[Precision] = match scene.lookup {
            Lookup::None | Lookup::Flat => &[Precision::Fast],
            _ => &[Precision::Fast, Precision::Exact],
        };
        let hidden: &[Hidden] = match scene.content {
            Content::Layers { blend: false, .. } => &[Hidden::Shaded, Hidden::Skipped],
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
pub(crate) struct Texmap {
    renderer: Renderer<'static>,
    frame: Frame,
}

impl Texmap {
    pub(crate) fn new(scene: &BenchScene, mode: Mode, threads: usize) -> Option<Self> {
        let data: Scene = scene.scene(mode.precision, mode.hidden).ok()??;
        // One leak a row: the renderer borrows its scene for the whole race.
        let data: &'static Scene = Box::leak(Box::new(data));
        let (width, height) = scene.size();
        let mut settings = Settings::new(width, height);
        settings.threads = Some(threads);
        if let Content::Sphere { samples, .. } = scene.content {
            settings.msaa = samples;
        }
        let renderer = Renderer::new(data, &settings).ok()?;
        let frame = renderer.draw(&|_, _| {}).ok()?;
        Some(Self { renderer, frame })
    }

    pub(crate) fn frame(&mut self) {
        let in_order = |blocks| (0..blocks).collect();
        if let Err(why) = self
            .renderer
            .draw_into(&mut self.frame, &|_, _| {}, &in_order)
        {
            eprintln!("peers: texmap: {why}");
        }
    }

    /// RGB rows, top row first.
    pub(crate) fn picture(&self) -> Vec<u8> {
        self.frame
            .rgba
            .chunks_exact(4)
            .flat_map(|p| [p[0], p[1], p[2]])
            .collect()
    }
}
