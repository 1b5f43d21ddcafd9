//! Normals, positions and tangents of a batch: read where a stage asks for them, then turned to the side that is seen.

use texmap_light::lanes::unit;
use texmap_math::Level;
use texmap_math::simd::Isa;
use texmap_raster::{AttributePlanes, FragmentBlock, Varying, Varyings};

use crate::batch::{Batch, columns, flip, load_vector, parts};
use crate::projector::{ProjectorStage, ProjectorTexels};
use crate::stage::{Inputs, Kernel, ShadeColumns};

/// Vectors in columns.
pub(crate) struct Vectors<'a> {
    pub(crate) normal: &'a [Varying; 3],
    pub(crate) position: Option<&'a [Varying; 3]>,
    /// Tangents and the sign of the bitangent.
    pub(crate) tangent: &'a [Varying; 4],
}

/// Reads vectors; numbers are first attributes.
pub struct VectorReader {
    /// First attribute of the normal.
    pub normal: Option<usize>,
    /// First attribute of the position.
    pub position: Option<usize>,
    /// First attribute of the tangent.
    pub tangent: Option<usize>,
    /// The values of the batch hold them.
    pub in_values: bool,
    /// Every block asks for the normal; else those that a projector reaches.
    pub normal_everywhere: bool,
    /// A stage reads the changes of normals.
    pub normal_changes: bool,
}

/// Scratch of a [`VectorReader`].
#[derive(Default)]
pub(crate) struct VectorScratch {
    early: Varyings,
    /// Normals and tangents that are read after the projectors.
    late: Varyings,
    reached: Vec<FragmentBlock>,
}

impl VectorReader {
    /// Reads the vectors of a batch, the texels of the projectors at its positions, and the blocks whose normals are asked for: the
    /// others have an empty mask.
    pub(crate) fn read<'b>(
        &self,
        level: Level,
        planes: &AttributePlanes,
        batch: &Batch<'b>,
        projectors: &[ProjectorStage<'_>],
        scratch: &'b mut VectorScratch,
        texels: &mut Vec<ProjectorTexels>,
    ) -> (Vectors<'b>, &'b [FragmentBlock]) {
        let VectorScratch {
            early,
            late,
            reached,
        } = scratch;
        let values = |list, wanted: &[usize], changes, out: &mut Varyings| {
            planes.values(level, batch.blocks, list, wanted, changes, out);
        };
        let [n, p, t] = [self.normal, self.position, self.tangent].map(|first| first.unwrap_or(0));
        let all = [p, p + 1, p + 2, n, n + 1, n + 2, t, t + 1, t + 2, t + 3];
        let all = &all[..if self.tangent.is_some() { 10 } else { 6 }];
        let (positions, normals) = all.split_at(3);
        if !self.in_values {
            let leveled = |stage: &ProjectorStage<'_>| stage.projected.reads_derivatives();
            let changes = self.normal_changes || projectors.iter().any(leveled);
            match (self.position, self.normal_everywhere) {
                (Some(_), true) => values(batch.list, all, changes, early),
                (Some(_), false) => values(batch.list, positions, changes, early),
                (None, true) => values(batch.list, normals, changes, early),
                (None, false) => {}
            }
        }
        let early = &*early;
        let position = self.position.map(|first| match self.in_values {
            true => columns(batch.values, first),
            false => columns(early, 0),
        });
        texels.resize_with(projectors.len(), ProjectorTexels::default);
        if let Some(position) = position {
            for (stage, out) in projectors.iter().zip(&mut *texels) {
                stage.fetch(level, position, batch.list.len(), out);
            }
        }
        let mut asked = batch.list;
        if !self.normal_everywhere {
            reached.clear();
            reached.extend_from_slice(batch.list);
            for (block, at) in reached.iter_mut().enumerate() {
                if !texels.iter().any(|texels| texels.reaches(block)) {
                    at.mask = 0;
                }
            }
            if !self.in_values && !texels.is_empty() {
                values(reached, normals, false, late);
            }
            asked = reached;
        }
        let (from, [n, t]) = match (self.in_values, self.normal_everywhere, position) {
            (true, ..) => (batch.values, [n, t]),
            (false, false, _) => (&*late, [0, 3]),
            (false, true, None) => (early, [0, 3]),
            (false, true, Some(_)) => (early, [3, 6]),
        };
        let vectors = Vectors {
            normal: columns(from, n),
            position,
            tangent: columns(from, t),
        };
        (vectors, asked)
    }
}

/// Unit normals of the vertices on the side that is seen, and unit directions to the eye where they are asked for.
pub struct SmoothNormals {
    /// Position of the eye; `None` for parallel rays.
    pub eye: Option<[f32; 3]>,
}

impl Kernel for SmoothNormals {
    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        let vectors = &inputs.vectors;
        for part in parts(i, inputs.reached) {
            let back = part.mask(i, inputs.sides.back[part.index]);
            let smooth = flip(i, back, load_vector(i, vectors.normal, part.at));
            columns.normal.store(i, part.at, unit(i, smooth));
            if let Some(eye) = self.eye {
                let mut toward = match vectors.position {
                    Some(position) => load_vector(i, position, part.at),
                    None => [i.f32(0.0); 3],
                };
                for k in 0..3 {
                    toward[k] = i.f32(eye[k]) - toward[k];
                }
                columns.toward_eye.store(i, part.at, unit(i, toward));
            }
        }
    }
}
