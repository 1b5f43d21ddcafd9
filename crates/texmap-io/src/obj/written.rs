//! Models of other formats as the text of an OBJ.

use std::collections::HashMap;
use std::fmt::Write;

use super::{Model, Part};

/// The text of a model: equal positions are one vertex, faces are the polygons that they were, colours follow positions. Normals are
/// written if they are asked for. Materials are left out.
pub(super) fn text(model: &Model, normals: bool) -> String {
    let mut text = String::new();
    let mut known = HashMap::new();
    let (mut positions, mut others) = (0, 0);
    for part in &model.parts {
        let _ = writeln!(text, "o {}", part.name);
        let colors = if model.colored { &part.colors[..] } else { &[] };
        let mut vertices = Vec::with_capacity(part.positions.len());
        for (k, position) in part.positions.iter().enumerate() {
            let color = colors.get(k);
            // One zero for both signs.
            let key = (
                position.map(|c| (c + 0.0).to_bits()),
                color.map(|c| c.map(f32::to_bits)),
            );
            let number = *known.entry(key).or_insert_with(|| {
                line(
                    &mut text,
                    "v",
                    position.iter().chain(color.into_iter().flatten()),
                );
                positions += 1;
                positions
            });
            vertices.push(number);
        }
        part.uvs.iter().for_each(|uv| line(&mut text, "vt", uv));
        let normals = if normals { &part.normals[..] } else { &[] };
        normals.iter().for_each(|n| line(&mut text, "vn", n));
        polygons(part, |corners| {
            text.push('f');
            for &k in corners {
                let own = others + k as usize + 1;
                let vertex = vertices[k as usize];
                let _ = match (part.uvs.is_empty(), normals.is_empty()) {
                    (true, true) => write!(text, " {vertex}"),
                    (false, true) => write!(text, " {vertex}/{own}"),
                    (true, false) => write!(text, " {vertex}//{own}"),
                    (false, false) => write!(text, " {vertex}/{own}/{own}"),
                };
            }
            text.push('\n');
        });
        others += part.positions.len();
    }
    text
}

/// A line of numbers, each as short as it is read back the same.
fn line<'a>(text: &mut String, word: &str, numbers: impl IntoIterator<Item = &'a f32>) {
    text.push_str(word);
    for c in numbers {
        let _ = write!(text, " {c}");
    }
    text.push('\n');
}

/// The corners of each face whose triangles are a fan; each triangle of others.
fn polygons(part: &Part, mut face: impl FnMut(&[u32])) {
    let mut corners: Vec<u32> = Vec::new();
    let mut last = None;
    for (triangle, number) in part.triangles.iter().zip(&part.faces) {
        let [a, b, c] = *triangle;
        let joins = last == Some(*number) && corners[0] == a && corners.last() == Some(&b);
        if joins {
            corners.push(c);
            continue;
        }
        if !corners.is_empty() {
            face(&corners);
        }
        corners.clear();
        corners.extend([a, b, c]);
        last = Some(*number);
    }
    if !corners.is_empty() {
        face(&corners);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_and_shared_corners_are_kept() {
        let part = Part {
            name: "a".into(),
            positions: vec![
                [0.0; 3],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
                [-0.0, 0.0, 0.0],
                [0.1, 1e-7, 2.0],
            ],
            normals: vec![[0.0, 0.0, 1.0]; 6],
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 1, 5]],
            faces: vec![0, 0, 1],
            ..Part::default()
        };
        let mut model = Model {
            parts: vec![part],
            ..Model::default()
        };
        let points = "o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.1 0.0000001 2\n";
        assert_eq!(text(&model, false), format!("{points}f 1 2 3 4\nf 1 2 5\n"));
        model.parts[0].uvs = vec![[0.5, 0.25]; 6];
        let normals = "vn 0 0 1\n".repeat(6);
        let places = "vt 0.5 0.25\n".repeat(6);
        assert_eq!(
            text(&model, true),
            format!("{points}{places}{normals}f 1/1/1 2/2/2 3/3/3 4/4/4\nf 1/5/5 2/2/2 5/6/6\n")
        );
        // A second part counts on; its corner of another colour is another vertex.
        model.colored = true;
        model.parts[0].colors = vec![[1.0, 0.5, 0.0]; 6];
        let mut other = model.parts[0].clone();
        other.triangles = vec![[0, 1, 2]];
        other.faces = vec![2];
        other.colors[0] = [0.0; 3];
        model.parts.push(other);
        let text = text(&model, false);
        assert!(text.contains("v 0.1 0.0000001 2 1 0.5 0\n"), "{text}");
        assert!(text.contains("v 0 0 0 0 0 0\n"), "{text}");
        assert!(text.ends_with("f 6/7 2/8 3/9\n"), "{text}");
    }
}
