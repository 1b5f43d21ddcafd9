//! Draw calls.

use texmap_math::Level;
use texmap_math::glam::{DMat4, DVec4};
use texmap_raster::{
    BinnedDraws, Cull, DepthTest, DrawCall, Fragment, Interp, NO_PRIMITIVE, NoAlphaTest, Pass,
    TargetSize, VisibilityBuffer,
};

use super::choices::Choices;

/// A mesh and how it is drawn.
struct Submitted {
    positions: Vec<[f32; 3]>,
    attributes: Vec<f32>,
    indices: Vec<[u32; 3]>,
    state: DrawCall<'static>,
}

impl Submitted {
    fn new(c: &mut Choices<'_>) -> Self {
        let vertices = c.below(24);
        let attribute_count = [2, 2, 0, 1, 5, 16, 17][c.below(7)];
        let positions = (0..vertices).map(|_| [0; 3].map(|_| c.number())).collect();
        let surplus = usize::from(c.byte() == 255);
        let attributes = (0..vertices * attribute_count + surplus)
            .map(|_| c.number())
            .collect();
        // Seldom one beyond the last vertex.
        let range = vertices.max(1) + usize::from(c.byte() > 240);
        let indices = (0..c.below(24))
            .map(|_| [0; 3].map(|_| c.below(range) as u32))
            .collect();
        let interp = match c.byte() {
            0..100 => Interp::Perspective,
            100..130 => Interp::Affine,
            130..170 => Interp::Subdivided(c.below(6) as u32),
            170..210 => Interp::Span(c.below(9) as u32),
            _ => Interp::WithinError(c.number()),
        };
        let clip_from_object = match c.byte() {
            0..90 => DMat4::IDENTITY,
            // (x w, y w, w): every vertex has a w of its own.
            90..200 => DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::W, DVec4::Z * 1e-3),
            _ => DMat4::from_cols_array(&[0.0; 16].map(|_: f64| f64::from(c.number()))),
        };
        let state = DrawCall {
            clip_from_object,
            attribute_count,
            screen_linear: u32::from(c.byte()),
            interp,
            cull: [Cull::None, Cull::Back, Cull::Front][c.below(3)],
            depth_test: [DepthTest::Less, DepthTest::LessOrEqual, DepthTest::Always][c.below(3)],
            depth_write: c.byte() < 200,
            pass: [Pass::Opaque, Pass::CutOut, Pass::Blended][c.below(3)],
            ..DrawCall::default()
        };
        Self {
            positions,
            attributes,
            indices,
            state,
        }
    }

    fn draw(&self) -> DrawCall<'_> {
        DrawCall {
            positions: &self.positions,
            attributes: &self.attributes,
            indices: &self.indices,
            ..self.state
        }
    }
}

/// Draw calls: refused by name, or the same in many lanes and in one, with every value within its triangle's.
pub fn draw(bytes: &[u8]) {
    let mut c = Choices(bytes);
    let size = match TargetSize::new(c.below(141) as u32, c.below(97) as u32) {
        Ok(size) => size,
        Err(refusal) => return assert!(!refusal.to_string().is_empty()),
    };
    let submitted: Vec<Submitted> = (0..1 + c.below(4))
        .map(|_| Submitted::new(&mut c))
        .collect();
    let draws: Vec<DrawCall<'_>> = submitted.iter().map(Submitted::draw).collect();
    let one_lane = BinnedDraws::with_level(size, &draws, Level::fallback(), 1);
    let (fast, one) = match (BinnedDraws::new(size, &draws), one_lane) {
        (Ok(fast), Ok(one)) => (fast, one),
        (Err(a), Err(b)) => {
            // Not by value: a tolerance may be NaN.
            assert_eq!(a.to_string(), b.to_string());
            return;
        }
        (fast, one) => panic!("{:?} but {:?}", fast.err(), one.err()),
    };
    assert_eq!(fast.stats(), one.stats());
    let (mut a, mut b) = (VisibilityBuffer::new(), VisibilityBuffer::new());
    let mut fragment = Fragment::default();
    for index in 0..fast.tiles() {
        let tile = fast.tile(index);
        fast.visible(index, &NoAlphaTest, &mut a);
        one.visible(index, &NoAlphaTest, &mut b);
        for (y, x) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (y, x))) {
            let slot = (y * texmap_raster::TILE + x) as usize;
            let source = |p: &BinnedDraws<'_>, id: u32| (id != NO_PRIMITIVE).then(|| p.source(id));
            let found = source(&fast, a.id[slot]);
            assert_eq!(found, source(&one, b.id[slot]), "tile {index}, {x}, {y}");
            if let Some(place) = found {
                fast.evaluate(a.id[slot], tile.x0 + x, tile.y0 + y, &mut fragment);
                check(&draws, place, &fragment);
            }
        }
        fast.blended(index, &a, &mut |id, x, y| {
            fast.evaluate(id, x, y, &mut fragment);
            check(&draws, fast.source(id), &fragment);
        });
    }
}

/// Values between those of the vertices, derivatives and depth finite.
fn check(draws: &[DrawCall<'_>], (draw, triangle): (u32, u32), fragment: &Fragment) {
    let draw = &draws[draw as usize];
    let corners = draw.indices[triangle as usize];
    for k in 0..draw.attribute_count {
        let v = corners.map(|i| draw.attributes[i as usize * draw.attribute_count + k]);
        let (low, high) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
        let value = fragment.values[k];
        assert!(low <= value && value <= high, "{value} of {v:?}");
        assert!(fragment.ddx[k].is_finite() && fragment.ddy[k].is_finite());
    }
    assert!((0.0..=1.0).contains(&fragment.depth), "{}", fragment.depth);
    assert!(fragment.inv_w > 0.0 && fragment.inv_w.is_finite());
}
