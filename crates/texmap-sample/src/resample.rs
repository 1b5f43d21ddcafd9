mod edges;

use crate::{
    address::wrap::Wrap,
    batch::{check, sample_slice},
    error::SampleError,
    sampler::{Filter, Sampler, finite_border},
    texture::{Origin, Texture2d},
};
use edges::Edges;
use texmap_math::{
    Homography, Level,
    footprint::Footprint,
    glam::{DMat3, DVec2, DVec3},
};

/// Colour beyond the edge of the source image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum EdgeMode {
    /// Nothing: transparent black, with antialiased edges.
    #[default]
    Transparent,
    /// A linear premultiplied colour, with antialiased edges.
    Border([f32; 4]),
    /// The border texels continue.
    Edge,
    /// The image repeats.
    Repeat,
}

/// An image as a function of real coordinates, drawn through a homography.
///
/// Positions are in pixels: the first pixel's centre is (0.5, 0.5), y grows downward. Each output
/// pixel gets the footprint of the inverse map, so that shrinking is filtered as texturing is
/// (give the texture mips). A pixel that an edge of the image cuts is covered by exactly the area of its square inside of the image
/// (before the horizon), and takes the colour in the middle of that area.
#[derive(Clone, Debug)]
pub struct Resample<'a> {
    /// Rows from the top.
    texture: Texture2d<'a>,
    sampler: Sampler,
    edge_mode: EdgeMode,
    source_from_output: DMat3,
    edges: Edges,
}

/// Pixels per call of the sampler: its arrays stay on the stack.
const RUN: usize = 256;

impl<'a> Resample<'a> {
    /// `output_from_source` takes positions of the source image to positions of the output.
    pub fn new(
        texture: &'a Texture2d<'a>,
        filter: Filter,
        outside: EdgeMode,
        output_from_source: &Homography,
    ) -> Self {
        let wrap = if outside == EdgeMode::Repeat {
            Wrap::Repeat
        } else {
            Wrap::ClampToEdge
        };
        let sampler = Sampler {
            filter,
            wrap_u: wrap,
            wrap_v: wrap,
            ..Sampler::default()
        };
        // The side of the horizon on which the middle of the source lies is the one to draw.
        let middle = DVec2::new(f64::from(texture.width()), f64::from(texture.height())) * 0.5;
        let inverse = output_from_source.inverse();
        let at = output_from_source.apply(middle).unwrap_or(DVec2::ZERO);
        let front = inverse.apply_homogeneous(at).z;
        let matrix = if front < 0.0 {
            inverse.matrix() * -1.0
        } else {
            inverse.matrix()
        };
        Self {
            texture: texture.clone().with_origin(Origin::TopLeft),
            sampler,
            edge_mode: outside,
            source_from_output: matrix,
            edges: Edges::new(&matrix, middle * 2.0),
        }
    }

    /// Draws whole rows of an output `width` pixels wide, from `first_row` on; linear premultiplied.
    ///
    /// # Errors
    /// `out` is not a whole number of rows.
    pub fn rows(
        &self,
        level: Level,
        width: u32,
        first_row: u32,
        out: &mut [[f32; 4]],
    ) -> Result<(), SampleError> {
        let w = width.max(1) as usize;
        check("out (whole rows)", out.len().next_multiple_of(w), out.len())?;
        for (y, row) in out.chunks_mut(w).enumerate() {
            for (i, run) in row.chunks_mut(RUN).enumerate() {
                self.run(level, i * RUN, first_row as usize + y, run)?;
            }
        }
        Ok(())
    }

    fn run(
        &self,
        level: Level,
        x0: usize,
        y: usize,
        out: &mut [[f32; 4]],
    ) -> Result<(), SampleError> {
        let (mut u, mut v) = ([0.0; RUN], [0.0; RUN]);
        let mut grads = [Footprint::default(); RUN];
        let mut cover = [0.0; RUN];
        let n = out.len().min(RUN);
        for i in 0..n {
            let place = self.place((x0 + i) as f64 + 0.5, y as f64 + 0.5);
            (u[i], v[i], grads[i], cover[i]) = place;
        }
        sample_slice(
            level,
            &self.sampler,
            &self.texture,
            &u[..n],
            &v[..n],
            Some(&grads[..n]),
            out,
        )?;
        let background = match self.edge_mode {
            EdgeMode::Border(c) => finite_border(c),
            _ => [0.0; 4],
        };
        for (c, k) in out.iter_mut().zip(cover) {
            if k < 1.0 {
                *c = [0, 1, 2, 3].map(|i| background[i] + (c[i] - background[i]) * k);
            }
        }
        Ok(())
    }

    /// uv, footprint and coverage of the output pixel around a position.
    fn place(&self, x: f64, y: f64) -> (f32, f32, Footprint, f32) {
        let (cover, at) = match self.edge_mode {
            EdgeMode::Edge | EdgeMode::Repeat => (1.0, DVec2::new(x, y)),
            _ => self.edges.cover(DVec2::new(x, y)),
        };
        let m = &self.source_from_output;
        let p = *m * at.extend(1.0);
        if p.z <= 0.0 {
            let beyond = matches!(self.edge_mode, EdgeMode::Edge | EdgeMode::Repeat);
            return (
                0.0,
                0.0,
                Footprint::default(),
                if beyond { 1.0 } else { 0.0 },
            );
        }
        let (w, h) = (
            f64::from(self.texture.width()),
            f64::from(self.texture.height()),
        );
        let (sx, sy) = (p.x / p.z, p.y / p.z);
        let slope = |column: DVec3| {
            [
                (column.x - sx * column.z) / p.z,
                (column.y - sy * column.z) / p.z,
            ]
        };
        let ([ux, vx], [uy, vy]) = (slope(m.x_axis), slope(m.y_axis));
        let d = Footprint::new(
            (ux / w) as f32,
            (vx / h) as f32,
            (uy / w) as f32,
            (vy / h) as f32,
        );
        ((sx / w) as f32, (sy / h) as f32, d, cover as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::ColorSpace;

    /// Numbers that are not finite count as a sampler's border does: NaN is 0.
    #[test]
    fn borders_that_are_not_finite_give_numbers() {
        let white = alloc::vec![255; 16];
        let texture =
            Texture2d::from_rgba8(2, 2, white, ColorSpace::Linear, Origin::TopLeft).unwrap();
        let moved = DMat3::from_translation(DVec2::new(0.5, 0.0));
        let moved = Homography::from_matrix(moved).unwrap();
        let border = EdgeMode::Border([f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0]);
        let resample = Resample::new(&texture, Filter::Bilinear, border, &moved);
        let mut out = [[0.0; 4]; 4];
        resample.rows(Level::new(), 4, 0, &mut out).unwrap();
        assert!(out.as_flattened().iter().all(|c| c.is_finite()), "{out:?}");
        assert_eq!((out[3][0], out[3][3]), (0.0, 1.0));
    }
}
