use texmap_math::float::floor_f32;
use texmap_math::glam::{DVec3, DVec4};
use texmap_math::projector::projector_uv;
use texmap_math::simd::{Isa, Scalar, prelude::*};
use texmap_math::{Footprint, Projector};
use texmap_sample::{Filter, Sampler, Texture2d, Wrap};

use crate::error::{LightError, same_length};
use crate::lanes::{Vector, affine};

/// A projected picture: the colour of a light, or paint.
#[derive(Clone, Debug)]
pub struct ProjectorTexture<'a> {
    /// The projector of the picture.
    pub projector: Projector,
    /// The picture, v = 0 at its top.
    pub texture: &'a Texture2d<'a>,
    /// Filter of the picture. The sampler's wrap modes are not read: `border` is the continuation beyond the picture.
    pub sampler: &'a Sampler,
    /// Continuation beyond the picture.
    pub border: ProjectorBorder,
    /// Width of the band inside the picture's edge, in parts of its width and height, 0..=0.5, over which the light fades out
    /// smoothly. Only with [`ProjectorBorder::Black`].
    pub softness: f32,
}

/// Continuation beyond the picture of a projector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProjectorBorder {
    /// No light, as of a projector.
    #[default]
    Black,
    /// The row and column of texels at the edge, repeated.
    Clamp,
    /// The picture, repeated.
    Repeat,
}

impl ProjectorBorder {
    /// Factor of the texels at coordinates of the picture, and the lanes that the picture reaches.
    #[inline(always)]
    fn fade<I: Isa>(self, i: I, softness: f32, [u, v]: [I::F32; 2]) -> (I::F32, I::Mask) {
        if self != Self::Black {
            return (i.f32(1.0), i.mask(true));
        }
        let inside = u.simd_ge(0.0) & u.simd_le(1.0) & v.simd_ge(0.0) & v.simd_le(1.0);
        if softness > 0.0 {
            (fade(i, softness, u) * fade(i, softness, v), inside)
        } else {
            (i.f32(1.0), inside)
        }
    }
}

impl ProjectorTexture<'_> {
    /// The picture's sampler with the wrap modes of the border.
    fn bordered(&self) -> Sampler {
        let wrap = match self.border {
            ProjectorBorder::Repeat => Wrap::Repeat,
            ProjectorBorder::Black | ProjectorBorder::Clamp => Wrap::ClampToEdge,
        };
        Sampler {
            wrap_u: wrap,
            wrap_v: wrap,
            ..self.sampler.clone()
        }
    }

    /// Premultiplied texel of the picture at homogeneous coordinates `(q, s, t)`. Multiply a light's colour with it, or
    /// compose it over a surface. Zero where `t <= 0` (nothing behind a projector is lit), where a coordinate is not finite,
    /// and beyond the picture under [`ProjectorBorder::Black`]. Source: MIT 6.837, lecture 18, slides 21-26; the tests of t and
    /// of the border are not on the slides.
    ///
    /// `step` holds the change of (q, s, t) per pixel to the right and per pixel down, for the level of detail:
    /// `du/dx = (q_x - u t_x) / t`.
    #[must_use]
    pub fn light(&self, qst: DVec3, step: Option<[DVec3; 2]>) -> [f32; 4] {
        let Some(place) = projector_uv(qst) else {
            return [0.0; 4];
        };
        let uv = [place.x as f32, place.y as f32];
        let (fade, true) = self.border.fade(Scalar, self.softness, uv) else {
            return [0.0; 4];
        };
        let sampler = self.bordered();
        let footprint = step.map(|step| {
            let along = |d: DVec3| {
                [
                    ((d.x - place.x * d.z) / qst.z) as f32,
                    ((d.y - place.y * d.z) / qst.z) as f32,
                ]
            };
            let ([du_dx, dv_dx], [du_dy, dv_dy]) = (along(step[0]), along(step[1]));
            Footprint {
                du_dx,
                dv_dx,
                du_dy,
                dv_dy,
            }
        });
        let texel = match footprint {
            Some(d) => sampler.sample_grad(self.texture, uv, d),
            None => sampler.sample(self.texture, uv),
        };
        texel.map(|c| c * fade)
    }

    /// [`light`](Self::light) at points of space, without level of detail.
    ///
    /// # Errors
    /// [`LightError::Length`] unless both slices have one length.
    pub fn light_slice(&self, points: &[[f32; 3]], out: &mut [[f32; 4]]) -> Result<(), LightError> {
        same_length("points", points.len(), out.len())?;
        for (out, point) in out.iter_mut().zip(points) {
            *out = self.light(
                self.projector.project(DVec3::from(point.map(f64::from))),
                None,
            );
        }
        Ok(())
    }
}

/// A [`ProjectorTexture`] prepared for look-ups in f32 from points of space. [`ProjectorTexture::light`] is the reference;
/// coordinates of the picture are off by about 1e-6.
#[derive(Clone, Debug)]
pub struct BoundProjectorTexture<'a> {
    /// Rows of q, s and t.
    rows: [[f32; 4]; 3],
    /// The picture.
    pub texture: &'a Texture2d<'a>,
    /// Filter of the picture, with the wrap modes of its border.
    pub sampler: Sampler,
    border: ProjectorBorder,
    softness: f32,
    /// The picture continues beyond its edge, and the edge is black.
    dark_edge: bool,
}

/// Coordinates of points in the projected picture.
#[derive(Clone, Copy, Debug)]
pub struct ProjectorUvBatch<I: Isa> {
    /// Lanes that the picture reaches; the coordinates of the others have no meaning.
    pub reached: I::Mask,
    /// Coordinates.
    pub uv: [I::F32; 2],
    /// Factor of the texel.
    pub fade: I::F32,
    /// Divisor of the coordinates.
    t: I::F32,
}

impl<'a> BoundProjectorTexture<'a> {
    /// Prepares a projected picture for look-ups.
    #[must_use]
    pub fn new(projected: &ProjectorTexture<'a>) -> Self {
        let row = |row: DVec4| row.to_array().map(|c| c as f32);
        Self {
            rows: projected.projector.rows().map(row),
            texture: projected.texture,
            sampler: projected.bordered(),
            border: projected.border,
            softness: projected.softness,
            dark_edge: projected.border == ProjectorBorder::Clamp
                && matches!(projected.sampler.filter, Filter::Nearest | Filter::Bilinear)
                && has_dark_edge(projected.texture),
        }
    }

    /// For paint, which black texels cover: there are none to leave out.
    #[must_use]
    pub fn as_decal(mut self) -> Self {
        self.dark_edge = false;
        self
    }

    /// Premultiplied texel at a point of space that changes by `dx` and `dy` from pixel to pixel: see [`ProjectorTexture::light`].
    #[must_use]
    pub fn light(&self, point: [f32; 3], [dx, dy]: [[f32; 3]; 2]) -> [f32; 4] {
        let places = self.place_within(Scalar, point, false);
        if !places.reached {
            return [0.0; 4];
        }
        let [du_dx, dv_dx] = self.changes(Scalar, &places, dx);
        let [du_dy, dv_dy] = self.changes(Scalar, &places, dy);
        let d = Footprint {
            du_dx,
            dv_dx,
            du_dy,
            dv_dy,
        };
        let texel = self.sampler.sample_grad(self.texture, places.uv, d);
        texel.map(|c| c * places.fade)
    }

    /// A sampler that gives the colours of [`sampler`](Self::sampler) where [`uv_at`](Self::uv_at) reaches. Beyond a black edge the
    /// repeated picture is as black as the clamped one, and repeated texels are the quickest to find.
    #[must_use]
    pub fn sampler_within(&self) -> Sampler {
        let mut sampler = self.sampler.clone();
        if self.dark_edge {
            (sampler.wrap_u, sampler.wrap_v) = (Wrap::Repeat, Wrap::Repeat);
        }
        sampler
    }

    /// Coordinates of points in the picture, and the factors of the texels there. The caller looks the texels up.
    /// Lanes in which level 0 can only give black are not reached.
    #[inline(always)]
    pub fn uv_at<I: Isa>(&self, i: I, point: Vector<I>) -> ProjectorUvBatch<I> {
        self.place_within(i, point, self.dark_edge)
    }

    /// [`uv_at`](Self::uv_at); no further than the picture if it has a `dark_edge`.
    #[inline(always)]
    fn place_within<I: Isa>(&self, i: I, point: Vector<I>, dark_edge: bool) -> ProjectorUvBatch<I> {
        let [q, r, t] = affine(&self.rows, point);
        let (u, v) = (q / t, r / t);
        let infinity = f32::INFINITY;
        let finite = u.abs().simd_lt(infinity) & v.abs().simd_lt(infinity);
        let (fade, mut reached) = self.border.fade(i, self.softness, [u, v]);
        reached = reached & t.simd_gt(0.0) & finite;
        if dark_edge {
            reached = reached & u.simd_ge(0.0) & u.simd_le(1.0) & v.simd_ge(0.0) & v.simd_le(1.0);
        }
        ProjectorUvBatch {
            reached,
            // The other lanes read the middle, away from all edges.
            uv: [reached.select(u, i.f32(0.5)), reached.select(v, i.f32(0.5))],
            fade,
            t,
        }
    }

    /// Changes of the coordinates with steps `d` of their points.
    #[inline(always)]
    pub fn changes<I: Isa>(&self, _: I, places: &ProjectorUvBatch<I>, d: Vector<I>) -> [I::F32; 2] {
        let mut qst = d;
        for (k, out) in qst.iter_mut().enumerate() {
            let [x, y, z, _] = self.rows[k];
            *out = d[0] * x + d[1] * y + d[2] * z;
        }
        let ([q, r, t], [u, v]) = (qst, places.uv);
        [(q - u * t) / places.t, (r - v * t) / places.t]
    }
}

/// True if the outermost texels of level 0 are black: then so is everything that a clamped filter reads beyond them.
fn has_dark_edge(texture: &Texture2d<'_>) -> bool {
    let (width, height) = (texture.width(), texture.height());
    let black = |x: u32, y: u32| {
        let texel = texture.texel(0, x, y);
        texel.is_some_and(|[r, g, b, _]| r == 0.0 && g == 0.0 && b == 0.0)
    };
    (0..width).all(|x| black(x, 0) && black(x, height - 1))
        && (0..height).all(|y| black(0, y) && black(width - 1, y))
}

/// 0 at the edge, 1 from `softness` inwards: `3x^2 - 2x^3`.
#[inline(always)]
fn fade<I: Isa>(i: I, softness: f32, c: I::F32) -> I::F32 {
    let from_edge = c.simd_lt(0.5).select(c, i.f32(1.0) - c);
    let x = from_edge / softness;
    let soft = x * x * (i.f32(3.0) - x * 2.0);
    from_edge.simd_lt(softness).select(soft, i.f32(1.0))
}

/// The picture's texel, as column and row, at coordinates of the picture; `None` beyond. For callers with texels of their own.
#[must_use]
pub fn projector_texel(qst: DVec3, (width, height): (u32, u32)) -> Option<(u32, u32)> {
    let place = projector_uv(qst)?;
    let index = |c: f64, n: u32| {
        let c = floor_f32((c * f64::from(n)) as f32);
        (c >= 0.0 && c < n as f32).then_some(c as u32)
    };
    Some((index(place.x, width)?, index(place.y, height)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use texmap_sample::{ColorSpace, Filter, Origin};

    fn picture() -> Texture2d<'static> {
        // Left half red, right half green, white border texels at top.
        let texels: Vec<u8> = (0..64u32)
            .flat_map(|i| {
                if i / 8 == 0 {
                    [255; 4]
                } else if i % 8 < 4 {
                    [255, 0, 0, 255]
                } else {
                    [0, 255, 0, 255]
                }
            })
            .collect();
        Texture2d::from_rgba8(8, 8, texels, ColorSpace::Linear, Origin::TopLeft).unwrap()
    }

    fn check(border: ProjectorBorder, softness: f32, test: impl Fn(&dyn Fn([f64; 3]) -> [f32; 4])) {
        // At the origin, along -Z, 90 degrees, twice as wide as high.
        let projector = Projector::new(
            DVec3::ZERO,
            DVec3::NEG_Z,
            DVec3::Y,
            core::f64::consts::FRAC_PI_2,
            2.0,
        )
        .unwrap();
        let (texture, sampler) = (
            picture(),
            Sampler {
                filter: Filter::Nearest,
                ..Sampler::default()
            },
        );
        let projected = ProjectorTexture {
            projector,
            texture: &texture,
            sampler: &sampler,
            border,
            softness,
        };
        test(&|p| projected.light(projector.project(DVec3::from(p)), None));
    }

    const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
    const GREEN: [f32; 4] = [0.0, 1.0, 0.0, 1.0];

    #[test]
    fn the_picture_is_upright_and_has_its_true_aspect() {
        check(ProjectorBorder::Black, 0.0, |at| {
            assert_eq!(at([-1.0, 0.0, -2.0]), RED);
            assert_eq!(at([1.0, 0.0, -2.0]), GREEN);
            assert_eq!(
                at([0.3, 0.95, -2.0]),
                [1.0; 4],
                "its top row, half as high as wide"
            );
            assert_eq!(at([0.3, 1.05, -2.0]), [0.0; 4]);
        });
    }

    /// Cases P1 and P2, counted over a wall before, beside and behind the projector.
    #[test]
    fn nothing_behind_or_beyond_is_lit() {
        check(ProjectorBorder::Black, 0.0, |at| {
            let mut lit = 0;
            for (i, j) in (0..200).flat_map(|i| (0..200).map(move |j| (i, j))) {
                let (x, y) = (f64::from(i) * 0.05 - 5.0, f64::from(j) * 0.05 - 5.0);
                assert_eq!(at([x, y, 2.0]), [0.0; 4], "behind");
                assert_eq!(at([x, y, 0.0]), [0.0; 4], "in the plane of the lens");
                let inside = x.abs() <= 2.0 && y.abs() <= 1.0;
                let light = at([x, y, -2.0]);
                assert!(inside || light == [0.0; 4], "{x} {y}");
                lit += u32::from(light[3] > 0.0);
            }
            assert!(lit > 2_900, "{lit}");
        });
        // The negative twin: without the test of t a point behind has coordinates in the picture.
        let behind = Projector::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.5, 1.0)
            .unwrap()
            .project(DVec3::new(0.1, 0.1, 2.0));
        assert!((0.0..1.0).contains(&(behind.x / behind.z)) && behind.z < 0.0);
        assert_eq!(projector_texel(behind, (8, 8)), None);
    }

    #[test]
    fn borders_clamp_and_repeat_by_name() {
        check(ProjectorBorder::Clamp, 0.0, |at| {
            assert_eq!((at([-9.0, 0.0, -2.0]), at([9.0, 0.0, -2.0])), (RED, GREEN));
            assert_eq!(
                at([-1.0, 0.0, 2.0]),
                [0.0; 4],
                "behind, whatever the border"
            );
        });
        check(ProjectorBorder::Repeat, 0.0, |at| {
            assert_eq!(at([3.0, 0.0, -2.0]), RED);
        });
    }

    #[test]
    fn soft_edges_fade_to_nothing() {
        check(ProjectorBorder::Black, 0.25, |at| {
            let row: Vec<f32> = (0..=100)
                .map(|i| at([f64::from(i) * 0.02, 0.0, -2.0])[3])
                .collect();
            assert_eq!((row[0], row[100]), (1.0, 0.0));
            assert!(row.windows(2).all(|w| w[0] >= w[1] && w[0] - w[1] < 0.06));
        });
    }

    #[test]
    fn no_number_is_too_large() {
        check(ProjectorBorder::Clamp, 0.1, |at| {
            for p in [
                [1e300, 0.0, -1e-300],
                [f64::NAN; 3],
                [f64::INFINITY, 0.0, -1.0],
                [1e30, -1e30, -1e-30],
            ] {
                assert!(at(p).iter().all(|c| c.is_finite()), "{p:?}");
            }
        });
    }
}
