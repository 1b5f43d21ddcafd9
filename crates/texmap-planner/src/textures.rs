//! Facts about the textures of a scene, each found once however many surfaces have it.

use std::cell::OnceCell;

use texmap_sample::Texture2d;

/// Textures, and what was asked about them.
pub(super) struct Textures<'s> {
    all: &'s [Texture2d<'static>],
    facts: Vec<Facts>,
}

#[derive(Clone, Default)]
struct Facts {
    constant: OnceCell<Option<[f32; 4]>>,
    brightest: OnceCell<[f32; 3]>,
    with_mips: OnceCell<Texture2d<'static>>,
}

impl<'s> Textures<'s> {
    pub(super) fn new(all: &'s [Texture2d<'static>]) -> Self {
        Self {
            all,
            facts: vec![Facts::default(); all.len()],
        }
    }

    pub(super) fn has_alpha(&self, texture: usize) -> bool {
        self.all[texture].has_alpha()
    }

    /// The one colour of a texture, if it has but one. Premultiplied, linear.
    pub(super) fn constant(&self, texture: usize) -> Option<[f32; 4]> {
        let fact = &self.facts[texture].constant;
        *fact.get_or_init(|| constant(&self.all[texture]))
    }

    /// The greatest value of each channel in the picture itself.
    pub(super) fn brightest(&self, texture: usize) -> [f32; 3] {
        let fact = &self.facts[texture].brightest;
        *fact.get_or_init(|| brightest(&self.all[texture]))
    }

    /// The texture with its mip chain.
    pub(super) fn with_mips(&self, texture: usize) -> Texture2d<'static> {
        let fact = &self.facts[texture].with_mips;
        let made = fact.get_or_init(|| {
            let texture = self.all[texture].clone();
            match texture.levels() {
                1 => texture.with_mips(),
                _ => texture,
            }
        });
        made.clone()
    }
}

fn texels<'a>(texture: &'a Texture2d<'_>) -> impl Iterator<Item = [f32; 4]> + 'a {
    let all = (0..texture.height()).flat_map(|y| (0..texture.width()).map(move |x| (x, y)));
    all.map(|(x, y)| texture.texel(0, x, y).unwrap_or_default())
}

fn constant(texture: &Texture2d<'_>) -> Option<[f32; 4]> {
    let first = texels(texture).next()?;
    texels(texture).all(|texel| texel == first).then_some(first)
}

fn brightest(texture: &Texture2d<'_>) -> [f32; 3] {
    texels(texture).fold([0.0f32; 3], |most, texel| {
        [0, 1, 2].map(|k| most[k].max(texel[k]))
    })
}
