//! Materials by their content: a scene with many of them finds an equal one at once.

use std::collections::HashMap;
use std::fmt::{self, Write};
use std::hash::{DefaultHasher, Hasher};

use texmap_scene::Material;

/// The materials of a scene by a hash of their content. They must not change any more.
#[derive(Debug, Default)]
pub(super) struct Known {
    by_content: HashMap<u64, Vec<usize>>,
    /// Materials that it knows.
    len: usize,
}

impl Known {
    /// Index of the last equal material.
    pub(super) fn find(&mut self, materials: &[Material], material: &Material) -> Option<usize> {
        // Faces of one kind follow each other.
        if materials.last() == Some(material) {
            return Some(materials.len() - 1);
        }
        for (index, known) in materials.iter().enumerate().skip(self.len) {
            self.by_content.entry(hash(known)).or_default().push(index);
        }
        self.len = materials.len();
        let alike = self.by_content.get(&hash(material))?;
        alike.iter().copied().rfind(|&i| materials[i] == *material)
    }
}

/// Equal for equal materials.
fn hash(material: &Material) -> u64 {
    let mut text = Text(DefaultHasher::new());
    // Writing into a hash does not fail.
    let _ = write!(text, "{material:?}");
    text.0.finish()
}

/// Text that is hashed. Signs are left out: 0 and -0 are equal.
struct Text(DefaultHasher);

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for part in text.split('-') {
            self.0.write(part.as_bytes());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_equal_material_is_found() {
        let of = |ns: f32| {
            let mut material = Material::default();
            material.phong.ns = ns;
            material
        };
        let mut known = Known::default();
        let mut all = vec![of(1.0), of(0.0), of(2.0)];
        assert_eq!(known.find(&all, &of(1.0)), Some(0));
        assert_eq!(known.find(&all, &of(2.0)), Some(2));
        assert_eq!(known.find(&all, &of(-0.0)), Some(1));
        assert_eq!(known.find(&all, &of(3.0)), None);
        // Added behind its back.
        all.extend([of(3.0), of(1.0), of(4.0)]);
        assert_eq!(known.find(&all, &of(3.0)), Some(3));
        assert_eq!(known.find(&all, &of(1.0)), Some(4));
        // Signs do not tell hashes apart, but materials.
        assert_eq!(known.find(&all, &of(-3.0)), None);
        assert_eq!(known.find(&all, &of(f32::NAN)), None);
    }
}
