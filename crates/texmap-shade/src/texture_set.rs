//! Textures that are read once a batch for all stages: opaque ones at the coordinates of the vertices as they are. Coordinates and levels
//! of detail are computed once, and addresses of texels once for all textures of one size.

use texmap_math::Level;
use texmap_raster::{AttributePlanes, FragmentBlock, TileVisibility, Varyings};
use texmap_sample::lanes::{BoundTexture, JointTextures};

use crate::Slot;
use crate::batch::LANES;
use crate::fetch::{PackedTexels, pixel_samples};
use crate::metallic::METALLIC_MAPS;
use crate::texels::{Pixels, TexelAddresses, packed_view, read_pair};

/// The base color map.
pub const BASE_COLOR: usize = 0;
/// The normal map.
pub const NORMAL: usize = 1;
/// The first map of a metallic-roughness model, in the order of [`slots`](crate::metallic::slots).
pub const METALLIC: usize = 2;
/// The map of emitted light.
pub const EMISSION: usize = METALLIC + METALLIC_MAPS;
/// The textures that a set may have.
pub const TEXTURES: usize = EMISSION + 1;

/// The source of the texels of a map.
#[derive(Clone, Copy)]
pub enum MapSource<'a> {
    /// There is no such map.
    None,
    /// The texture, which the stage reads.
    Own(&'a Slot<'a>),
    /// The texture of this number in the [`TextureSet`] of the surface.
    Set(usize),
}

/// The textures of a surface that several stages share the coordinates of.
#[derive(Default)]
pub struct TextureSet<'a> {
    /// Base color and normal map as bytes, if all there are of them are read so.
    packed: Option<[Option<BoundTexture<'a>>; 2]>,
    /// The levels of both are the same.
    same_mips: bool,
    /// The other textures.
    joint: Vec<Joint<'a>>,
    /// True if some filter of these reads derivatives.
    derivatives: bool,
}

/// Textures of one size.
struct Joint<'a> {
    textures: JointTextures<'a>,
    /// The first of them: the filters of all are the same.
    slot: &'a Slot<'a>,
    /// True for those of the set, which stand in `textures` in this order.
    members: [bool; TEXTURES],
}

impl<'a> TextureSet<'a> {
    /// The textures in the order of the numbers of this module: base color and normal map as packed words if both have that form.
    pub fn new(slots: [Option<&'a Slot<'a>>; TEXTURES]) -> Self {
        let [base, normal, ..] = slots;
        let views =
            [base, normal].map(|slot| slot.map(|slot| packed_view(&slot.sampler, &slot.texture)));
        // A slot without a view spoils it.
        let packed = match views {
            [None, None] | [Some(None), _] | [_, Some(None)] => None,
            [base, normal] => Some([base.flatten(), normal.flatten()]),
        };
        let same_mips = match (base, normal, &packed) {
            (Some(base), Some(normal), Some([Some(a), Some(b)])) => {
                a.kind == b.kind && a.size() == b.size() && base.sampler.lod == normal.sampler.lod
            }
            _ => false,
        };
        let first = if packed.is_some() {
            METALLIC
        } else {
            BASE_COLOR
        };
        let mut set = Self {
            packed,
            same_mips,
            ..Self::default()
        };
        set.add_all(slots, first);
        set
    }

    /// [`new`](Self::new) without packed words: it gives the same bits in more time.
    pub fn unpacked(slots: [Option<&'a Slot<'a>>; TEXTURES]) -> Self {
        let mut set = Self::default();
        set.add_all(slots, BASE_COLOR);
        set
    }

    /// Adds the textures from number `first` on.
    fn add_all(&mut self, slots: [Option<&'a Slot<'a>>; TEXTURES], first: usize) {
        for (number, slot) in slots.into_iter().enumerate().skip(first) {
            if let Some(slot) = slot {
                self.add(number, slot);
            }
        }
    }

    /// Adds a texture to those of its size.
    fn add(&mut self, number: usize, slot: &'a Slot<'a>) {
        let Some(view) = BoundTexture::new(&slot.sampler, &slot.texture) else {
            return;
        };
        self.derivatives |= slot.reads_derivatives();
        for joint in &mut self.joint {
            if joint.textures.add(&view) {
                joint.members[number] = true;
                return;
            }
        }
        let mut members = [false; TEXTURES];
        members[number] = true;
        self.joint.push(Joint {
            textures: JointTextures::new(&slot.sampler, view),
            slot,
            members,
        });
    }

    /// True if base color and normal map have levels of the same sizes and one level of detail serves both.
    pub fn shares_mips(&self) -> bool {
        self.same_mips
    }

    /// Reads the texels of a batch into the entries of their numbers.
    pub fn fetch(
        &self,
        level: Level,
        planes: &AttributePlanes,
        blocks: &TileVisibility,
        batch: &[FragmentBlock],
        scratch: &mut SetScratch,
        out: &mut Vec<PackedTexels>,
    ) {
        if self.packed.is_none() && self.joint.is_empty() {
            return;
        }
        out.resize_with(TEXTURES, PackedTexels::default);
        let SetScratch { values, addresses } = scratch;
        if let (Some(views), [base, normal, ..]) = (&self.packed, &mut out[..]) {
            let pixels = Pixels::Blocks(planes, blocks);
            let words = [base, normal].map(|out| {
                out.packed = true;
                &mut out.words
            });
            read_pair(
                level,
                views,
                self.same_mips,
                &pixels,
                batch,
                addresses,
                words,
            );
        }
        if self.joint.is_empty() {
            return;
        }
        planes.values(level, blocks, batch, &[0, 1], self.derivatives, values);
        let count = batch.len() * LANES;
        for joint in &self.joint {
            let mut outs: [[&mut [f32]; 4]; TEXTURES] = Default::default();
            let read = joint.members.iter().zip(&mut *out);
            let mut textures = 0;
            for (columns, (_, out)) in outs.iter_mut().zip(read.filter(|(member, _)| **member)) {
                out.packed = false;
                *columns = out.colors.columns_mut(count);
                textures += 1;
            }
            let at = pixel_samples(joint.slot, values, count);
            joint
                .textures
                .sample_soa(level, &at, &mut outs[..textures])
                .expect("the columns have one length");
        }
    }
}

/// Columns that a [`TextureSet`] reads.
#[derive(Default)]
pub struct SetScratch {
    values: Varyings,
    addresses: TexelAddresses,
}
