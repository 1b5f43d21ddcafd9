//! Three ways to compute light: at the vertices, along interpolated light vectors, or at every pixel.
//!
//! CS184's lecture on normal maps interpolates the vector to the light across each polygon and takes the normal from the map at every
//! pixel. Here are its two readings (unit vectors, brought back to length 1 or not), the one that is right, and Gouraud's colours,
//! each against f64 light at the point itself.

use texmap_light::{Light, PhongMaterial, lighting};
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;

/// The quantity that is interpolated across a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Nothing but the position: texmap's light per pixel.
    PerPixel,
    /// The difference of light and vertex, brought to length 1 at the pixel. It is linear on the surface, so nothing is lost.
    Difference,
    /// Unit vectors to the light, brought back to length 1 at the pixel.
    Renormalised,
    /// Unit vectors to the light as they are: too short between the vertices.
    Unit,
    /// The colours of the vertices (Gouraud 1971).
    Gouraud,
}

impl Method {
    /// Best to worst.
    pub const ALL: [Self; 5] = [
        Self::PerPixel,
        Self::Difference,
        Self::Renormalised,
        Self::Unit,
        Self::Gouraud,
    ];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::PerPixel => "light per pixel",
            Self::Difference => "difference to the light, interpolated, brought to length 1",
            Self::Renormalised => "unit light vectors, interpolated, brought to length 1",
            Self::Unit => "unit light vectors, interpolated",
            Self::Gouraud => "colours of the vertices (Gouraud)",
        }
    }
}

/// A square of side 2 at y = 0 around the origin under a point light, cut into `cells` x `cells` squares of two triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Squares a side, at least 1.
    pub cells: u32,
    /// Position of the light, above it.
    pub light: DVec3,
    /// Steepest slope of the waves that its normals show, five a side; 0 is flat.
    pub waves: f64,
}

/// Errors of diffuse light, of which 1 is what a surface square to the light returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Root of the mean square.
    pub rmse: f64,
    /// Largest.
    pub max: f64,
}

/// Samples a side.
const SAMPLES: u32 = 160;

impl Floor {
    /// The errors of a method over the square, at 160 x 160 points and at the middle.
    pub fn measure(&self, method: Method) -> Figures {
        let (mut sum, mut max) = (0.0, 0.0f64);
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(SAMPLES) * 2.0 - 1.0;
        for i in 0..SAMPLES * SAMPLES {
            let error = self.error(method, place(i % SAMPLES), place(i / SAMPLES));
            sum += error * error;
            max = max.max(error.abs());
        }
        Figures {
            rmse: (sum / f64::from(SAMPLES * SAMPLES)).sqrt(),
            max: max.max(self.error(method, 0.0, 0.0).abs()),
        }
    }

    /// Error of a method at (x, z).
    pub fn error(&self, method: Method, x: f64, z: f64) -> f64 {
        let point = DVec3::new(x, 0.0, z);
        let normal = self.normal(point);
        let truth = normal.dot(self.toward(point).normalize()).max(0.0);
        let (corners, weights) = self.triangle(x, z);
        let mean = |of: &dyn Fn(DVec3) -> DVec3| -> DVec3 {
            (0..3).map(|k| of(corners[k]) * weights[k]).sum()
        };
        let unit = |p: DVec3| self.toward(p).normalize();
        let found = match method {
            Method::PerPixel => self.per_pixel(point, normal),
            Method::Difference => normal.dot(mean(&|p| self.toward(p)).normalize()).max(0.0),
            Method::Renormalised => normal.dot(mean(&unit).normalize()).max(0.0),
            Method::Unit => normal.dot(mean(&unit)).max(0.0),
            Method::Gouraud => (0..3)
                .map(|k| weights[k] * self.normal(corners[k]).dot(unit(corners[k])).max(0.0))
                .sum(),
        };
        found - truth
    }

    /// texmap's own formula, in f32.
    fn per_pixel(&self, point: DVec3, normal: DVec3) -> f64 {
        let narrow = |v: DVec3| v.as_vec3().to_array();
        let surface = PhongMaterial {
            color: [1.0; 3],
            ka: 0.0,
            kd: 1.0,
            ks: 0.0,
            ns: 1.0,
        };
        let light = Light::Point {
            color: [1.0; 3],
            position: narrow(self.light),
        };
        let eye = [0.0, 9.0, 0.0];
        let found = lighting(&surface, &[light], narrow(point), narrow(normal), eye);
        f64::from(found.diffuse[0])
    }

    fn toward(&self, p: DVec3) -> DVec3 {
        self.light - p
    }

    /// The texel of a normal map there.
    fn normal(&self, p: DVec3) -> DVec3 {
        let slope = |c: f64| self.waves * deterministic_f64::sin(c * 5.0 * std::f64::consts::PI);
        DVec3::new(slope(p.x), 1.0, slope(p.z)).normalize()
    }

    /// Corners of the triangle over (x, z), and their weights.
    fn triangle(&self, x: f64, z: f64) -> ([DVec3; 3], [f64; 3]) {
        let cells = f64::from(self.cells.max(1));
        let grid = |c: f64| (c + 1.0) * 0.5 * cells;
        let low = |c: f64| grid(c).floor().clamp(0.0, cells - 1.0);
        let (i, j) = (low(x), low(z));
        let (s, t) = (grid(x) - i, grid(z) - j);
        let corner = |di: f64, dj: f64| {
            let at = |c: f64| c / cells * 2.0 - 1.0;
            DVec3::new(at(i + di), 0.0, at(j + dj))
        };
        let far = corner(1.0, 1.0);
        if s >= t {
            (
                [corner(0.0, 0.0), corner(1.0, 0.0), far],
                [1.0 - s, s - t, t],
            )
        } else {
            (
                [corner(0.0, 0.0), corner(0.0, 1.0), far],
                [1.0 - t, t - s, s],
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the middle of one square, between two corners: the mean of their unit vectors is h / d long.
    #[test]
    fn unit_vectors_fall_short_by_the_closed_form() {
        for height in [0.1, 0.5, 2.0] {
            let above = |x: f64| Floor {
                cells: 1,
                light: DVec3::new(x, height, 0.0),
                waves: 0.0,
            };
            let floor = above(0.0);
            let short = height / (2.0 + height * height).sqrt() - 1.0;
            for method in [Method::Unit, Method::Gouraud] {
                let error = floor.error(method, 0.0, 0.0);
                assert!(
                    (error - short).abs() < 1e-12,
                    "{method:?}: {error} for {short}"
                );
            }
            assert!(floor.error(Method::Renormalised, 0.0, 0.0).abs() < 1e-12);
            // With all corners as far from the light, unit vectors differ from it by one factor; else they do not.
            assert!(floor.measure(Method::Renormalised).max < 1e-12);
            assert!(above(0.5).measure(Method::Renormalised).max > 0.01);
            assert!(above(0.5).measure(Method::Difference).max < 1e-12);
        }
    }

    /// Finer meshes cure all but the map's own detail, which vertices cannot hold.
    #[test]
    fn finer_meshes_help_light_vectors_and_not_gouraud() {
        let floor = |cells, waves| Floor {
            cells,
            light: DVec3::new(0.5, 0.5, -0.25),
            waves,
        };
        for method in [Method::Renormalised, Method::Unit] {
            let errors = [1, 4, 16].map(|cells| floor(cells, 0.3).measure(method).max);
            assert!(
                errors[0] > 2.0 * errors[1] && errors[1] > 3.0 * errors[2],
                "{errors:?}"
            );
        }
        let gouraud = floor(4, 0.3).measure(Method::Gouraud).max;
        assert!(gouraud > 3.0 * floor(4, 0.3).measure(Method::Unit).max);
    }
}
