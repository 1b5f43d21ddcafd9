//! Planes of attributes over the screen, from three vertices.

use glam::DVec2;

/// A value that is linear over the screen: `value + dx (x - x0) + dy (y - y0)` with the anchor (x0, y0). Evaluate it near its anchor:
/// the farther off, the more digits go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Position at which `value` holds, in pixels.
    pub anchor: DVec2,
    /// The value at the anchor.
    pub value: f64,
    /// Change per pixel to the right.
    pub dx: f64,
    /// Change per pixel down.
    pub dy: f64,
}

impl Plane {
    /// The value at (x, y).
    #[inline]
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> f64 {
        self.value + ((x - self.anchor.x) * self.dx + (y - self.anchor.y) * self.dy)
    }

    /// The same plane with another anchor.
    #[inline]
    #[must_use]
    pub fn anchored(&self, x: f64, y: f64) -> Self {
        Self {
            anchor: DVec2::new(x, y),
            value: self.at(x, y),
            ..*self
        }
    }

    /// The plane for f32 kernels, anchored at (x, y): evaluate with offsets from there.
    #[inline]
    #[must_use]
    pub fn to_f32(&self, x: f64, y: f64) -> PlaneF32 {
        PlaneF32 {
            value: self.at(x, y) as f32,
            dx: self.dx as f32,
            dy: self.dy as f32,
        }
    }
}

/// A plane in f32 over offsets from an anchor that the caller keeps (the corner of a tile).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneF32 {
    /// The value at the anchor.
    pub value: f32,
    /// Change per pixel to the right.
    pub dx: f32,
    /// Change per pixel down.
    pub dy: f32,
}

impl PlaneF32 {
    /// The value at an offset from the anchor, evaluated directly (never stepped): multiply, multiply, add, add.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, x: f32, y: f32) -> f32 {
        self.value + (x * self.dx + y * self.dy)
    }
}

/// The set-up of a screen triangle, from which the plane of any attribute follows by two differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneSetup {
    anchor: DVec2,
    to_dx: DVec2,
    to_dy: DVec2,
}

impl PlaneSetup {
    /// Set-up from screen positions in pixels. None without area and for numbers that are not finite (or overflow). The anchor is the first vertex, where every
    /// plane gives the vertex value exactly.
    #[must_use]
    pub fn new(p: [DVec2; 3]) -> Option<Self> {
        let (e1, e2) = (p[1] - p[0], p[2] - p[0]);
        let area = e1.perp_dot(e2);
        let setup = Self {
            anchor: p[0],
            to_dx: DVec2::new(e2.y, -e1.y) / area,
            to_dy: DVec2::new(-e2.x, e1.x) / area,
        };
        (area != 0.0 && p[0].is_finite() && setup.to_dx.is_finite() && setup.to_dy.is_finite())
            .then_some(setup)
    }

    /// The plane through the three values.
    #[must_use]
    pub fn plane(&self, values: [f64; 3]) -> Plane {
        let d = DVec2::new(values[1] - values[0], values[2] - values[0]);
        Plane {
            anchor: self.anchor,
            value: values[0],
            dx: self.to_dx.dot(d),
            dy: self.to_dy.dot(d),
        }
    }
}

/// The plane through three screen positions and values; None as for [`PlaneSetup::new`].
#[must_use]
pub fn plane_from_vertices(p: [DVec2; 3], values: [f64; 3]) -> Option<Plane> {
    Some(PlaneSetup::new(p)?.plane(values))
}

/// A value with its change per pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gradient {
    /// The value.
    pub value: f64,
    /// Change per pixel to the right.
    pub dx: f64,
    /// Change per pixel down.
    pub dy: f64,
}

/// u = (u/w) / (1/w) at (x, y) from the planes of `u * inv_w` and `inv_w`, and du/dx, du/dy by the quotient rule
/// `(U_x - u W_x) / W`. Not finite where the plane of `inv_w` passes zero.
#[must_use]
pub fn perspective_gradient(u_inv_w: &Plane, inv_w: &Plane, x: f64, y: f64) -> Gradient {
    let w = 1.0 / inv_w.at(x, y);
    let value = u_inv_w.at(x, y) * w;
    Gradient {
        value,
        dx: (u_inv_w.dx - value * inv_w.dx) * w,
        dy: (u_inv_w.dy - value * inv_w.dy) * w,
    }
}
