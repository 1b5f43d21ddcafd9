//! Maps of roughness and metalness in one texture, as the metallic-roughness model reads them.

use texmap_sample::{Alpha, ColorSpace, Image, Origin, TexelData, Texture2d};

use super::{Content, MapSource, Textures, stand_in};
use crate::scene_file::Missing;
use crate::{IoError, image_io};

impl Textures {
    /// Index of the texture that holds roughness in green and metalness in blue, 1 where there is no map; at least one is there. A map
    /// gives its red channel; one file for both is packed already. The smaller of two sizes is interpolated, with a warning.
    pub(crate) fn load_packed(
        &mut self,
        maps: [Option<MapSource>; 2],
        missing: Missing,
    ) -> Result<usize, IoError> {
        let key = maps.each_ref().map(|m| m.as_ref().map(|m| m.path.clone()));
        if let Some((_, index)) = self.packed.iter().find(|(known, _)| *known == key) {
            return Ok(*index);
        }
        if let [Some(a), Some(b)] = &maps
            && a.path == b.path
        {
            return self.load(&a.path, &a.location, Content::Data, missing);
        }
        let mut sources = [None, None];
        for (source, map) in sources.iter_mut().zip(&maps) {
            if let Some(map) = map {
                *source = Some(self.numbers(map, missing)?);
            }
        }
        let sides = |t: &Texture2d<'_>| (t.width(), t.height());
        let sizes = sources.iter().flatten().map(|(texture, _)| sides(texture));
        let (width, height) = sizes.fold((1, 1), |(w, h), size| (w.max(size.0), h.max(size.1)));
        if let ([Some((a, _)), Some((b, _))], [_, Some(map)]) = (&sources, &maps)
            && sides(a) != sides(b)
        {
            self.warnings.push(format!(
                "{}: map_Pm has {} x {} pixels, map_Pr {} x {}: both are drawn as {width} x {height}",
                map.location,
                b.width(),
                b.height(),
                a.width(),
                a.height(),
            ));
        }
        if let Some(map) = maps.iter().flatten().next() {
            let (path, line) = (&map.path, Some(&map.location));
            image_io::ask_for_texels(&self.source, path, line, (width, height), 8 + 11)?;
        }
        let wide = sources.iter().flatten().any(|(_, bits)| *bits > 8);
        self.textures
            .push(packed(&sources, (width, height), wide).with_mips());
        let index = self.textures.len() - 1;
        self.packed.push((key, index));
        Ok(index)
    }

    /// A map of numbers that is no texture of its own, and the bits of its file.
    fn numbers(
        &mut self,
        map: &MapSource,
        missing: Missing,
    ) -> Result<(Texture2d<'static>, u32), IoError> {
        let MapSource { path, location } = map;
        let known = self.loaded.get(&(path.clone(), Content::Data));
        if let Some(index) = known {
            let file = self.files.iter().find(|file| file.path == *path);
            let bits = file.and_then(|file| file.found.as_ref().ok());
            let bits = bits.map_or(8, |(_, _, bits)| *bits);
            return Ok((self.textures[*index].clone(), bits));
        }
        let ahead = self.ahead.remove(&(path.clone(), Content::Data));
        match ahead.unwrap_or_else(|| self.read(path, location, Content::Data)) {
            Ok((texture, size)) => {
                self.note(path, location, Ok(size));
                Ok((texture, size.2))
            }
            Err(error) => {
                self.forgive(path, location, error, missing)?;
                Ok((stand_in(missing, Content::Data), 8))
            }
        }
    }
}

/// Roughness in green, metalness in blue.
fn packed(
    sources: &[Option<(Texture2d<'static>, u32)>; 2],
    (width, height): (u32, u32),
    wide: bool,
) -> Texture2d<'static> {
    let value = |source: usize, x: u32, y: u32| match &sources[source] {
        Some((texture, _)) => red(texture, (width, height), x, y),
        None => 1.0,
    };
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let texels = texels.flat_map(|(x, y)| [1.0, value(0, x, y), value(1, x, y)]);
    let code = |most: f32| move |c: f32| c.clamp(0.0, 1.0) * most + 0.5;
    let (mut narrow, mut broad): (Vec<u8>, Vec<u16>) = (Vec::new(), Vec::new());
    if wide {
        broad = texels.map(code(65535.0)).map(|c| c as u16).collect();
    } else {
        narrow = texels.map(code(255.0)).map(|c| c as u8).collect();
    }
    Texture2d::new(&Image {
        width,
        height,
        channels: 3,
        texels: match wide {
            true => TexelData::U16(&broad),
            false => TexelData::U8(&narrow),
        },
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    })
    .expect("a picture of the size of a texture is one")
}

/// The red channel at the centre of texel (x, y) of a picture of another size, bilinear and repeating.
fn red(texture: &Texture2d<'_>, (width, height): (u32, u32), x: u32, y: u32) -> f32 {
    let texel = |x: u32, y: u32| {
        let [r, _, _, a] = texture.texel(0, x, y).unwrap_or([1.0; 4]);
        if a > 0.0 { r / a } else { r }
    };
    let (w, h) = (texture.width(), texture.height());
    if (w, h) == (width, height) {
        return texel(x, y);
    }
    // The two texels around, and the way from the first to the second.
    let around = |at: u32, of: u32, sides: u32| {
        let place = (at as f32 + 0.5) / of as f32 * sides as f32 - 0.5;
        let first = place.floor();
        let wrapped = |i: i64| i.rem_euclid(i64::from(sides)) as u32;
        (
            wrapped(first as i64),
            wrapped(first as i64 + 1),
            place - first,
        )
    };
    let (x0, x1, s) = around(x, width, w);
    let (y0, y1, t) = around(y, height, h);
    let mix = |a: f32, b: f32, k: f32| a + (b - a) * k;
    let rows = [y0, y1].map(|y| mix(texel(x0, y), texel(x1, y), s));
    mix(rows[0], rows[1], t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, code: impl Fn(u32, u32) -> u8) -> Texture2d<'static> {
        let texels = (0..width * height).flat_map(|i| {
            let c = code(i % width, i / width);
            [c, c, c, 255]
        });
        Texture2d::from_rgba8(
            width,
            height,
            texels.collect(),
            ColorSpace::Linear,
            Origin::TopLeft,
        )
        .unwrap()
    }

    #[test]
    fn each_map_has_its_channel_and_what_is_absent_is_one() {
        let rough = grey(4, 4, |x, y| (16 * x + y) as u8);
        let both = [Some((rough.clone(), 8)), Some((grey(4, 4, |_, _| 51), 8))];
        for wide in [false, true] {
            let texture = packed(&both, (4, 4), wide);
            let [r, g, b, _] = texture.texel(0, 3, 2).unwrap();
            let near = |a: f32, b: f32| (a - b).abs() < 1e-4;
            assert!(
                near(r, 1.0) && near(g, 50.0 / 255.0) && near(b, 0.2),
                "{wide}"
            );
        }
        let alone = packed(&[None, Some((rough, 8))], (4, 4), false);
        let [_, g, b, _] = alone.texel(0, 3, 2).unwrap();
        assert!(g == 1.0 && b < 0.2);
    }

    #[test]
    fn smaller_maps_are_interpolated() {
        let ramp = grey(2, 1, |x, _| 255 * x as u8);
        let even = [0, 1, 2, 3].map(|x| red(&ramp, (4, 2), x, 0));
        assert_eq!(even, [0.25, 0.25, 0.75, 0.75]);
    }
}
