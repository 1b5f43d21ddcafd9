//! Panel 1: interpolation of texture coordinates.

use texmap_math::Level;
use texmap_math::glam::DVec2;
use texmap_raster::{
    AttributePlanes, BinnedDraws, DrawCall, FragmentBlock, Interp, NO_PRIMITIVE, NoAlphaTest,
    TargetSize, TileVisibility, Varyings,
};

use super::spans::{self, Method, Plane, Row};
use super::time::{Effort, timed};
use super::{Across, Error, Panel, Point, SceneChart, Source};
use crate::LabError;
use crate::scenes::{UvImage, UvScene};
use texmap_truth::picture::Picture;
use texmap_truth::strip::heat;

const MODES: [Interp; 12] = [
    Interp::Perspective,
    Interp::Affine,
    Interp::Subdivided(2),
    Interp::Subdivided(4),
    Interp::Subdivided(8),
    Interp::Span(8),
    Interp::Span(16),
    Interp::Span(32),
    Interp::Span(64),
    Interp::WithinError(0.25),
    Interp::WithinError(0.5),
    Interp::WithinError(1.0),
];

/// A scene of this panel.
#[derive(Clone, Debug)]
pub struct QuadScene {
    /// Short name, unique: that of the chart.
    pub id: String,
    /// The drawn scene.
    pub title: String,
    /// The quad.
    pub quad: UvScene,
    /// w at the right edge where it is 1 at the left.
    ratio: Option<f64>,
}

impl QuadScene {
    /// All of them.
    pub fn all() -> Vec<Self> {
        let of = |id: String, title: String, quad: UvScene, ratio: Option<f64>| Self {
            id: format!("interpolation-{id}"),
            title,
            quad,
            ratio,
        };
        let mut scenes = [1.02, 1.1, 2.0, 8.0, 64.0]
            .map(|ratio| {
                let title = format!("A quad that fills the picture, w-ratio {ratio}");
                of(ratio.to_string(), title, UvScene::ratio(ratio), Some(ratio))
            })
            .to_vec();
        let title = "The conformance quad, w = 1.3, 0.8, 0.6, 2.0".to_owned();
        scenes.push(of("cts".to_owned(), title, UvScene::cts_quad(), None));
        let title = "The ground through the eye's plane, half-size 200".to_owned();
        scenes.push(of("ground".to_owned(), title, UvScene::ground(200.0), None));
        scenes
    }

    /// The error of an image over the pixels that both see, in texels, and what it lost or broke.
    ///
    /// # Errors
    /// If the camera has no view.
    pub fn judge(&self, found: &UvImage) -> Result<(Error, Vec<String>), LabError> {
        let truth = self.quad.truth()?;
        Ok((error(&self.quad, &truth, found), lost(&truth, found)))
    }
}

pub(super) fn panel(effort: Effort) -> Result<Panel, LabError> {
    let charts = QuadScene::all()
        .into_iter()
        .map(|scene| chart(effort, scene));
    let charts = charts.collect::<Result<_, _>>()?;
    Ok(Panel {
        id: "interpolation",
        title: "Interpolation",
        about: "Texture coordinates over 256 x 256 pixels, 1024 texels to a unit. Methods of texmap run through the \
                rasterizer's planes, runs of 256 pixels; those of the lab fill whole rows of their own and know no \
                triangles. Nobody computes derivatives here. A method that loses or gains pixels, leaves the hull of its triangle's \
                values or computes a value that is not finite is hollow.",
        charts,
    })
}

fn chart(effort: Effort, of: QuadScene) -> Result<SceneChart, LabError> {
    let scene = &of.quad;
    let truth = scene.truth()?;
    let (positions, attributes) = (scene.positions(), scene.attributes());
    let mut drawn = Vec::new();
    for interp in MODES {
        drawn.push(Drawn::new(scene, &positions, &attributes, interp)?);
    }
    let mut points = Vec::new();
    for (interp, drawn) in MODES.iter().zip(&mut drawn) {
        let image = drawn.image(scene.size);
        points.push(Point {
            failures: lost(&truth, &image),
            ..point(name(*interp), Source::Texmap, scene, &truth, &image)
        });
    }
    let covered = truth.iter().flatten().count();
    let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
    for drawn in &mut drawn {
        runs.push(Box::new(|| drawn.run()));
    }
    timed(&mut points, effort, covered, &mut runs);
    if let Some(ratio) = of.ratio {
        points.extend(rows(effort, scene, ratio));
    }
    Ok(SceneChart {
        id: of.id,
        title: of.title,
        truth: format!("one f64 ray a pixel, {covered} pixels; the larger error of u and v"),
        item: "covered pixel",
        unit: "texels",
        across: Across::Time,
        points,
    })
}

/// As on the command line.
fn name(interp: Interp) -> String {
    texmap_io::scene_file::words::interp(interp)
}

fn point(
    method: String,
    source: Source,
    scene: &UvScene,
    truth: &UvImage,
    found: &UvImage,
) -> Point {
    Point {
        method,
        source,
        time: None,
        error: error(scene, truth, found),
        bytes: None,
        failures: Vec::new(),
        picture: Some(picture(scene, truth, found)),
    }
}

/// The larger of u's and v's, in texels, over the pixels that both see.
fn error(scene: &UvScene, truth: &UvImage, found: &UvImage) -> Error {
    let both = truth.iter().zip(found);
    let off = |(t, f): (&Option<DVec2>, &Option<DVec2>)| {
        Some((f.as_ref()? - t.as_ref()?).abs().max_element() * scene.texels)
    };
    Error::of(both.filter_map(off))
}

fn lost(truth: &UvImage, found: &UvImage) -> Vec<String> {
    let mut out = Vec::new();
    let other = truth
        .iter()
        .zip(found)
        .filter(|(t, f)| t.is_some() != f.is_some());
    match other.count() {
        0 => {}
        n => out.push(format!("{n} pixels on one side only")),
    }
    match found.iter().flatten().filter(|uv| !uv.is_finite()).count() {
        0 => {}
        n => out.push(format!("{n} values that are not finite")),
    }
    out
}

/// A checker of 64 texels and, beside it, the error: white from one texel.
fn picture(scene: &UvScene, truth: &UvImage, found: &UvImage) -> Picture {
    let half = scene.size / 2;
    let mut picture = Picture::new(scene.size + 2, half, [255; 4]);
    for y in 0..half {
        for x in 0..half {
            let index = (2 * y * scene.size + 2 * x) as usize;
            let (x, y) = (i64::from(x), i64::from(y));
            let color = found[index].map_or([96, 96, 128, 255], |uv| {
                let cell = (uv * scene.texels / 64.0).floor();
                let dark = (cell.x + cell.y).rem_euclid(2.0) != 0.0;
                let c = if dark { 40 } else { 225 };
                [c, c, c, 255]
            });
            picture.set(x, y, color);
            let off = match (truth[index], found[index]) {
                (Some(t), Some(f)) => (f - t).abs().max_element() * scene.texels,
                (None, None) => 0.0,
                _ => f64::NAN,
            };
            picture.set(
                x + i64::from(half) + 2,
                y,
                heat((off * 12.0).round() / 12.0),
            );
        }
    }
    picture
}

/// A scene at the door of its inner loop: what is left is the planes of each tile and their values.
struct Drawn<'a> {
    prepared: BinnedDraws<'a>,
    tiles: Vec<(TileVisibility, Vec<Vec<FragmentBlock>>)>,
    planes: AttributePlanes,
    /// One run's, which stays in the nearest cache as the renderer's does.
    values: Varyings,
}

impl<'a> Drawn<'a> {
    fn new(
        scene: &UvScene,
        positions: &'a [[f32; 3]],
        attributes: &'a [f32],
        interp: Interp,
    ) -> Result<Self, LabError> {
        let draw = DrawCall {
            positions,
            indices: &UvScene::TRIANGLES,
            clip_from_object: scene.camera.clip_from_world(1.0)?,
            attributes,
            attribute_count: 2,
            interp,
            interp_scale: scene.texels as f32,
            ..DrawCall::default()
        };
        let prepared = BinnedDraws::new(TargetSize::new(scene.size, scene.size)?, &[draw])?;
        let mut tiles = Vec::new();
        for tile in 0..prepared.tiles() {
            let mut blocks = TileVisibility::new();
            prepared.visible_blocks(tile, &NoAlphaTest, &mut blocks);
            let masks: Vec<FragmentBlock> = blocks
                .slot
                .chunks(16)
                .zip(0u16..)
                .map(|(slots, block)| {
                    let bit = |(i, slot): (usize, &u32)| u16::from(*slot != NO_PRIMITIVE) << i;
                    let mask = slots.iter().enumerate().map(bit).sum();
                    FragmentBlock {
                        block,
                        mask,
                        slot: NO_PRIMITIVE,
                    }
                })
                .filter(|m| m.mask != 0)
                .collect();
            let runs: Vec<Vec<FragmentBlock>> = masks.chunks(16).map(<[_]>::to_vec).collect();
            tiles.push((blocks, runs));
        }
        Ok(Self {
            prepared,
            tiles,
            planes: AttributePlanes::new(),
            values: Varyings::default(),
        })
    }

    fn run(&mut self) {
        self.each(|_, _, values| {
            std::hint::black_box(values);
        });
    }

    /// Values without derivatives, as the rows of the lab have none.
    fn each(&mut self, mut see: impl FnMut((u32, u32), &[FragmentBlock], &Varyings)) {
        let level = Level::new();
        for (tile, (blocks, runs)) in self.tiles.iter().enumerate() {
            self.prepared.planes(tile, &mut self.planes);
            let corner = self.prepared.tile(tile);
            for run in runs {
                let out = &mut self.values;
                self.planes.values(level, blocks, run, &[0, 1], false, out);
                see((corner.x0, corner.y0), run, out);
            }
        }
    }

    fn image(&mut self, size: u32) -> UvImage {
        let mut image = vec![None; (size * size) as usize];
        self.each(|(x0, y0), run, out| {
            for (i, at) in run.iter().enumerate() {
                for bit in (0..16u32).filter(|b| at.mask >> b & 1 == 1) {
                    let block = u32::from(at.block);
                    let (x, y) = (x0 + block % 16 * 4 + bit % 4, y0 + block / 16 * 4 + bit / 4);
                    let k = 16 * i + bit as usize;
                    let [u, v] = [0, 1].map(|c: usize| f64::from(out.varyings[c].value[k]));
                    image[(y * size + x) as usize] = Some(DVec2::new(u, v));
                }
            }
        });
        image
    }
}

/// The lab's rows on the quad whose w runs from 1 at the left to `ratio` at the right.
fn rows(effort: Effort, scene: &UvScene, ratio: f64) -> Vec<Point> {
    let n = scene.size as usize;
    let rows: Vec<Row> = (0..n)
        .map(|y| {
            // u from 0 to 1; v as in the triangle above the diagonal, over the whole row.
            let v = (y as f64 + 0.5) / n as f64 / ratio;
            Row {
                u: Plane::between(0.0, 1.0 / ratio, n),
                v: Plane::between(v, v, n),
                inv_w: Plane::between(1.0, 1.0 / ratio, n),
            }
        })
        .collect();
    let exact = |i: usize| {
        let (x, y) = ((i % n) as f64 + 0.5, (i / n) as f64 + 0.5);
        let t = x / n as f64;
        let w = 1.0 / (1.0 + t * (1.0 / ratio - 1.0));
        Some(DVec2::new(t, y / n as f64) / ratio * w)
    };
    let truth: UvImage = (0..n * n).map(exact).collect();
    let fill = |method: Method, u: &mut [f32], v: &mut [f32]| {
        for ((row, u), v) in rows.iter().zip(u.chunks_mut(n)).zip(v.chunks_mut(n)) {
            method.fill(Level::new(), row, u, v);
        }
    };
    let mut points: Vec<Point> = Method::ALL
        .iter()
        .map(|&method| {
            let (mut u, mut v) = (vec![0.0f32; n * n], vec![0.0f32; n * n]);
            fill(method, &mut u, &mut v);
            let image: UvImage = u
                .iter()
                .zip(&v)
                .map(|(&u, &v)| Some(DVec2::new(u.into(), v.into())))
                .collect();
            Point {
                failures: spans::failures(method),
                ..point(method.name(), Source::Lab, scene, &truth, &image)
            }
        })
        .collect();
    let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
    for method in Method::ALL {
        let (mut u, mut v) = (vec![0.0f32; n], vec![0.0f32; n]);
        let rows = &rows;
        runs.push(Box::new(move || {
            for row in rows {
                method.fill(Level::new(), row, &mut u, &mut v);
                std::hint::black_box((&u, &v));
            }
        }));
    }
    timed(&mut points, effort, n * n, &mut runs);
    points
}
