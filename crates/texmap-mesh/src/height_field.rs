//! Terrain: a grid over a picture of heights.

use texmap_math::MemoryBudget;
use texmap_math::glam::DVec3;
use texmap_sample::{Origin, Texture2d};

use crate::MeshError;
use texmap_scene::SceneError;
use texmap_scene::{Displacement, Mesh};

/// A height field about the origin: a vertex for every `step`-th texel of each row and column and for the last, the red
/// channel times `size[1]` high. Its first column lies at x = -`size[0]`/2, its last at +`size[0]`/2; its top row at
/// z = -`size[2]`/2 (far), its bottom row at +`size[2]`/2.
///
/// Coordinates are those of the texel centres, so a picture of the same ground lies on it texel for texel. Normals are by
/// central differences between neighbouring texels, one-sided at the border.
///
/// # Errors
/// [`SceneError::Value`] for a map of fewer than 2 x 2 texels, a step of 0, or sizes that are not finite or, across, not
/// above 0; [`MeshError::TooManyTriangles`] beyond [`Displacement::MAX_TRIANGLES`]; [`MeshError::Memory`].
pub fn height_field(
    name: &str,
    heights: &Texture2d<'_>,
    size: [f32; 3],
    step: u32,
) -> Result<Mesh, MeshError> {
    let (width, height) = (heights.width(), heights.height());
    let bad = |what: &str, value: String, expected| -> MeshError {
        SceneError::Value {
            place: format!("height field '{name}'"),
            what: what.to_owned(),
            value,
            expected,
        }
        .into()
    };
    if width < 2 || height < 2 {
        return Err(bad(
            "map",
            format!("{width} x {height}"),
            "it must have 2 texels a side or more",
        ));
    }
    if !(size.iter().all(|s| s.is_finite()) && size[0] > 0.0 && size[2] > 0.0) {
        return Err(bad(
            "size",
            format!("{size:?}"),
            "it must be finite, and above 0 across",
        ));
    }
    if step == 0 {
        return Err(bad("step", "0".to_owned(), "it must be 1 or more"));
    }
    let (columns, rows) = (posts(width, step), posts(height, step));
    let triangles = 2 * (columns.len() as u64 - 1) * (rows.len() as u64 - 1);
    if triangles > u64::from(Displacement::MAX_TRIANGLES) {
        return Err(MeshError::TooManyTriangles {
            mesh: name.to_owned(),
            triangles,
            limit: Displacement::MAX_TRIANGLES,
        });
    }
    // A vertex has position, normal and coordinates; a triangle, of which there are two a vertex, indices and a face.
    MemoryBudget::of_process().ask(
        triangles * ((12 + 12 + 8) / 2 + 12 + 4),
        format_args!("the height field '{name}' of {triangles} triangles"),
        "take a larger step, or a smaller map",
    )?;
    let [sx, sy, sz] = size.map(f64::from);
    // Rows from the top, whatever the texture counts from.
    let heights = heights.clone().with_origin(Origin::TopLeft);
    let at = |x: u32, y: u32| heights.texel(0, x, y).map_or(0.0, |t| sy * f64::from(t[0]));
    let mut mesh = Mesh {
        name: name.to_owned(),
        uv_origin: Origin::TopLeft,
        ..Mesh::default()
    };
    for &y in &rows {
        for &x in &columns {
            let along = |i: u32, n: u32| f64::from(i) / f64::from(n - 1) - 0.5;
            let p = [sx * along(x, width), at(x, y), sz * along(y, height)];
            mesh.positions.push(p.map(|c| c as f32));
            let centre = |i: u32, n: u32| ((f64::from(i) + 0.5) / f64::from(n)) as f32;
            mesh.uvs.push([centre(x, width), centre(y, height)]);
            let (left, right) = (x.saturating_sub(1), (x + 1).min(width - 1));
            let (far, near) = (y.saturating_sub(1), (y + 1).min(height - 1));
            let over_x = (at(right, y) - at(left, y))
                / (sx * f64::from(right - left) / f64::from(width - 1));
            let over_z =
                (at(x, near) - at(x, far)) / (sz * f64::from(near - far) / f64::from(height - 1));
            let normal = DVec3::new(-over_x, 1.0, -over_z).normalize();
            mesh.normals.push(normal.as_vec3().to_array());
        }
    }
    let across = columns.len() as u32;
    for row in 0..rows.len() as u32 - 1 {
        for column in 0..across - 1 {
            let a = row * across + column;
            let [b, c, d] = [a + 1, a + across, a + across + 1];
            mesh.triangles.extend([[a, c, d], [a, d, b]]);
            mesh.faces.extend([row * (across - 1) + column; 2]);
        }
    }
    Ok(mesh)
}

/// Every `step`-th of `n` texels, and the last.
fn posts(n: u32, step: u32) -> Vec<u32> {
    let mut posts: Vec<u32> = (0..n).step_by(step as usize).collect();
    if posts.last() != Some(&(n - 1)) {
        posts.push(n - 1);
    }
    posts
}

#[cfg(test)]
mod tests {
    use texmap_sample::{Alpha, ColorSpace, Image, TexelData};

    use super::*;

    fn map(width: u32, height: u32, at: impl Fn(u32, u32) -> f32) -> Texture2d<'static> {
        let texels: Vec<f32> = (0..width * height)
            .map(|i| at(i % width, i / width))
            .collect();
        Texture2d::new(&Image {
            width,
            height,
            channels: 1,
            texels: TexelData::F32(&texels),
            color: ColorSpace::Linear,
            alpha: Alpha::Straight,
            origin: Origin::TopLeft,
        })
        .unwrap()
    }

    #[test]
    fn vertices_lie_on_the_texels_and_fronts_point_up() {
        // A tilted plane: exact normals, whatever the step.
        let plane = map(9, 5, |x, y| 0.5 * x as f32 + 0.25 * y as f32);
        for step in [1, 3, 100] {
            let mesh = height_field("plane", &plane, [8.0, 2.0, 4.0], step).unwrap();
            let expected = DVec3::new(-1.0, 1.0, -0.5).normalize();
            for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
                assert!(
                    (p[1] - (p[0] + 4.0 + 0.5 * (p[2] + 2.0))).abs() < 1e-5,
                    "{p:?}"
                );
                assert!((DVec3::from(n.map(f64::from)) - expected).length() < 1e-6);
            }
            for t in &mesh.triangles {
                assert!(mesh.cross(*t).dot(expected) > 0.0);
            }
            assert_eq!(mesh.positions[0], [-4.0, 0.0, -2.0]);
            assert_eq!(mesh.positions.last().unwrap(), &[4.0, 10.0, 2.0]);
            assert_eq!(mesh.uvs[0], [0.5 / 9.0, 0.1]);
        }
        let fine = height_field("plane", &plane, [8.0, 2.0, 4.0], 1).unwrap();
        assert_eq!(
            (fine.positions.len(), fine.triangles.len(), fine.faces.len()),
            (45, 64, 64)
        );
        // Rows lie from the top, whatever the texture counts from.
        let flipped = plane.clone().with_origin(Origin::BottomLeft);
        let same = height_field("plane", &flipped, [8.0, 2.0, 4.0], 1).unwrap();
        assert_eq!((same.positions, same.uvs), (fine.positions, fine.uvs));
    }

    #[test]
    fn maps_and_sizes_without_an_area_are_refused() {
        let good = map(4, 4, |_, _| 0.5);
        let size = [1.0, 1.0, 1.0];
        assert!(height_field("a", &map(1, 9, |_, _| 0.0), size, 1).is_err());
        assert!(height_field("a", &good, size, 0).is_err());
        assert!(height_field("a", &good, [1.0, f32::NAN, 1.0], 1).is_err());
        assert!(height_field("a", &good, [0.0, 1.0, 1.0], 1).is_err());
        let large = map(1500, 1500, |_, _| 0.0);
        let error = height_field("a", &large, size, 1).unwrap_err();
        assert!(matches!(error, MeshError::TooManyTriangles { .. }));
        assert!(height_field("a", &large, size, 2).is_ok());
    }
}
