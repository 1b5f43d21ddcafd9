//! Several textures at the same coordinates: addresses and weights that they share are found once.

use super::{Places, run::Batch};
use crate::{bound_texture::BoundTexture, error::SampleError, sampler::Sampler};
use alloc::{vec, vec::Vec};
use texmap_math::Level;

/// Textures that a batch of coordinates finds the same texels in: levels of the same sides under the same filter, wraps and limits. Their
/// colours take less time together than one after the other.
///
/// ```
/// use texmap_math::Level;
/// use texmap_sample::lanes::{BoundTexture, JointTextures};
/// use texmap_sample::{ColorSpace, Filter, Origin, Places, Sampler, Texture2d};
///
/// let texture = |value, color| Texture2d::from_rgba8(2, 2, [value, 0, 0, 255].repeat(4), color, Origin::TopLeft);
/// let (base, roughness) = (texture(255, ColorSpace::Srgb)?, texture(51, ColorSpace::Linear)?);
/// let sampler = Sampler { filter: Filter::Bilinear, ..Sampler::default() };
/// let view = |texture| BoundTexture::new(&sampler, texture).expect("a texture has texels");
///
/// let mut textures = JointTextures::new(&sampler, view(&base));
/// assert!(textures.add(&view(&roughness)));
/// let larger = Texture2d::from_rgba8(4, 2, vec![0; 32], ColorSpace::Linear, Origin::TopLeft)?;
/// assert!(!textures.add(&view(&larger)));
///
/// let mut found = [[[0.0; 16]; 4]; 2];
/// let mut outs = found.each_mut().map(|columns| columns.each_mut().map(|column| &mut column[..]));
/// let at = Places { u: &[0.3; 16], v: &[0.6; 16], gradients: None };
/// textures.sample_soa(Level::new(), &at, &mut outs)?;
/// assert_eq!(found[0][0][7], 1.0);
/// assert!((found[1][0][7] - 0.2).abs() < 1e-6);
/// # Ok::<(), texmap_sample::SampleError>(())
/// ```
#[derive(Clone, Debug)]
pub struct JointTextures<'a> {
    sampler: &'a Sampler,
    views: Vec<BoundTexture<'a>>,
}

impl<'a> JointTextures<'a> {
    /// One texture, bound with its sampler.
    #[must_use]
    pub fn new(sampler: &'a Sampler, view: BoundTexture<'a>) -> Self {
        let views = vec![view];
        Self { sampler, views }
    }

    /// Adds a texture behind the others; false, with nothing done, if it does not share their texels.
    #[must_use]
    pub fn add(&mut self, view: &BoundTexture<'a>) -> bool {
        let shared = self.views.iter().all(|other| other.shares_cells(view));
        if shared {
            self.views.push(view.clone());
        }
        shared
    }

    /// [`sample_bound_soa`](super::sample_bound_soa) in each texture, with the same bits: one entry of `outs` for each.
    ///
    /// # Errors
    /// Slices of different lengths, or another number of outputs.
    pub fn sample_soa(
        &self,
        level: Level,
        at: &Places<'_>,
        outs: &mut [[&mut [f32]; 4]],
    ) -> Result<(), SampleError> {
        let (textures, got) = (self.views.len(), outs.len());
        if textures != got {
            return Err(SampleError::Outputs { textures, got });
        }
        for column in outs.iter().flatten() {
            at.check(column.len())?;
        }
        if let Some(first) = self.views.first() {
            Batch::new(self.sampler, first, *at).joint_columns(level, &self.views, outs);
        }
        Ok(())
    }
}
