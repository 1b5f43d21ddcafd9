//! Everything is checked before the first pixel.

mod effects;
mod shapes;

use crate::{Background, Material, Mesh, Scene, SceneError, Shading, TextureSlot, UvSet};

impl Scene {
    /// Checks every number and index of the scene and returns warnings: one sentence for each thing that
    /// can be drawn but is hardly meant. `texmap_render::render` calls it first.
    ///
    /// # Errors
    /// The first fault found, by mesh, material, vertex, triangle and face.
    pub fn check(&self) -> Result<Vec<String>, SceneError> {
        let camera = &self.camera;
        let place = || "camera".to_owned();
        for (what, v) in [
            ("eye", camera.eye),
            ("look", camera.look),
            ("up", camera.up),
        ] {
            finite(place, || what.to_owned(), &v.to_array())?;
        }
        finite(place, || "near".to_owned(), &[camera.near])?;
        camera.view().map_err(SceneError::Camera)?;
        self.check_projection()?;
        unit_range(|| "background".to_owned(), "channel", &self.background)?;
        for (index, light) in self.lights.iter().enumerate() {
            if !light.is_valid() {
                return Err(SceneError::Value {
                    place: format!("light {index}"),
                    what: "it".to_owned(),
                    value: format!("{light:?}"),
                    expected: "numbers must be finite, intensities not negative, directions not zero",
                });
            }
        }
        for material in &self.materials {
            self.check_material(material)?;
        }
        let mut warnings = Vec::new();
        for mesh in &self.meshes {
            self.check_mesh(mesh, &mut warnings)?;
        }
        self.check_effects(&mut warnings)?;
        Ok(warnings)
    }

    /// Checks that all meshes are triangles: what renderers and the planner ask beside [`check`](Self::check).
    ///
    /// # Errors
    /// [`SceneError::NotTessellated`] names the first mesh with a displacement or billboards.
    pub fn check_tessellated(&self) -> Result<(), SceneError> {
        match self.meshes.iter().find(|mesh| !mesh.is_tessellated()) {
            None => Ok(()),
            Some(mesh) => Err(SceneError::NotTessellated {
                mesh: mesh.name.clone(),
            }),
        }
    }

    /// True if the texture frame of a mesh lies in the plane of the picture, as those of mirrors do: it belongs to this camera.
    fn has_frame_of_picture(&self, mesh: &Mesh) -> bool {
        let Some(frame) = mesh.texture_frame else {
            return false;
        };
        let normal = frame.transform(mesh.world_from_object).normal();
        let forward = (self.camera.look - self.camera.eye).normalize_or_zero();
        normal.normalize_or_zero().cross(forward).length() < FLAT
    }

    /// Error if a parallel projection shows parts that are looked up along rays from one eye.
    fn check_projection(&self) -> Result<(), SceneError> {
        if self.camera.lens.parallel_width.is_none() {
            return Ok(());
        }
        let frame = self.meshes.iter().find(|m| m.texture_frame.is_some());
        let sky = matches!(
            self.effects.background,
            Some(Background::Environment(_) | Background::EnvironmentLight)
        );
        let what = match frame {
            Some(mesh) => format!("mesh '{}': its texture frame", mesh.name),
            None if sky => "the environment behind the scene".to_owned(),
            None if !self.effects.volumes.is_empty() => "a volume".to_owned(),
            None => return Ok(()),
        };
        Err(SceneError::ParallelRays { what })
    }

    fn check_material(&self, material: &Material) -> Result<(), SceneError> {
        let place = || format!("material '{}'", material.name);
        if !material.phong.is_valid() {
            return Err(SceneError::Value {
                place: place(),
                what: "surface".to_owned(),
                value: format!("{:?}", material.phong),
                expected: "numbers must be finite and not negative",
            });
        }
        unit_range(place, "opacity", &[material.opacity])?;
        if let crate::AlphaMode::Test(threshold) = material.alpha {
            unit_range(place, "alpha threshold", &[threshold])?;
        }
        if let Some(model) = material
            .metallic_roughness
            .as_ref()
            .filter(|m| !m.is_valid())
        {
            return Err(SceneError::Value {
                place: place(),
                what: "metallic-roughness model".to_owned(),
                value: format!("{model:?}"),
                expected: "factors must be 0 to 1, the index of refraction at least 1",
            });
        }
        for slot in material.slots() {
            self.check_slot(slot, place)?;
        }
        if let (Some(color), Some(opacity)) = (&material.base_color, &material.opacity_map)
            && color.uv_set != opacity.uv_set
        {
            return Err(SceneError::Value {
                place: place(),
                what: "set of coordinates of the opacity map".to_owned(),
                value: format!("{:?}", opacity.uv_set),
                expected: "it must be that of the base colour",
            });
        }
        self.check_material_effects(material)
    }

    pub(crate) fn check_slot(
        &self,
        slot: &TextureSlot,
        place: impl Fn() -> String,
    ) -> Result<(), SceneError> {
        index(&place, "texture", slot.texture as u64, self.textures.len())?;
        let t = &slot.transform;
        finite(
            &place,
            || "texture transform".to_owned(),
            &[t.offset[0], t.offset[1], t.scale[0], t.scale[1], t.rotation],
        )?;
        finite(&place, || "border colour".to_owned(), &slot.sampler.border)?;
        let lod = &slot.sampler.lod;
        if lod.bias.is_finite() && lod.min <= lod.max {
            return Ok(());
        }
        Err(SceneError::Value {
            place: place(),
            what: "level-of-detail limits".to_owned(),
            value: format!("{lod:?}"),
            expected: "bias must be finite and min <= max",
        })
    }

    fn check_mesh(&self, mesh: &Mesh, warnings: &mut Vec<String>) -> Result<(), SceneError> {
        let place = || format!("mesh '{}'", mesh.name);
        index(
            place,
            "material",
            mesh.material as u64,
            self.materials.len(),
        )?;
        let vertices = mesh.positions.len();
        per(mesh, "normals", mesh.normals.len(), "vertices", vertices)?;
        per(mesh, "tangents", mesh.tangents.len(), "vertices", vertices)?;
        per(mesh, "uvs", mesh.uvs.len(), "vertices", vertices)?;
        per(
            mesh,
            "light-map uvs",
            mesh.lightmap_uvs.len(),
            "vertices",
            vertices,
        )?;
        per(mesh, "colours", mesh.colors.len(), "vertices", vertices)?;
        per(
            mesh,
            "face numbers",
            mesh.faces.len(),
            "triangles",
            mesh.triangles.len(),
        )?;
        all_finite(mesh, "position", mesh.positions.as_flattened(), 3)?;
        all_finite(mesh, "normal", mesh.normals.as_flattened(), 3)?;
        all_finite(mesh, "tangent", mesh.tangents.as_flattened(), 4)?;
        all_finite(mesh, "uv", mesh.uvs.as_flattened(), 2)?;
        all_finite(mesh, "light-map uv", mesh.lightmap_uvs.as_flattened(), 2)?;
        all_finite(mesh, "colour", mesh.colors.as_flattened(), 3)?;
        if let Some((t, vertex)) = vertex_out_of_range(&mesh.triangles, vertices) {
            let face = mesh.face(t as u32);
            let place = || format!("mesh '{}' triangle {t} (face {face})", mesh.name);
            index(place, "vertex", u64::from(vertex), vertices)?;
        }
        let matrix = mesh.world_from_object;
        finite(place, || "transform".to_owned(), &matrix.to_cols_array())?;
        let determinant = matrix.determinant();
        if !(determinant.is_finite() && determinant != 0.0) {
            return Err(SceneError::Value {
                place: place(),
                what: "determinant of the transform".to_owned(),
                value: format!("{determinant}"),
                expected: "it must be finite and not 0: a scale of 0 flattens the mesh",
            });
        }
        if let Some(displacement) = &mesh.displacement {
            self.check_slot(&displacement.slot, place)?;
        }
        mesh.check_shape()?;
        let material = &self.materials[mesh.material];
        let lit = material.shading == Shading::PerPixel;
        let textured = material.reads_uv(UvSet::First);
        let second = material.reads_uv(UvSet::Second) && !mesh.triangles.is_empty();
        if (lit && material.light_map.is_some() || second) && mesh.lightmap_uvs.is_empty() {
            return Err(SceneError::MissingLightMapUv {
                mesh: mesh.name.clone(),
                material: material.name.clone(),
            });
        }
        if textured
            && mesh.uvs.is_empty()
            && mesh.texture_frame.is_none()
            && mesh.uv_projection.is_none()
            && !mesh.triangles.is_empty()
        {
            return Err(SceneError::MissingUv {
                mesh: mesh.name.clone(),
                material: material.name.clone(),
            });
        }
        let tilt = mesh.frame_tilt().filter(|angle| *angle > FLAT);
        if let Some(angle) = tilt.filter(|_| !self.has_frame_of_picture(mesh)) {
            warnings.push(format!(
                "mesh '{}': its texture frame leaves the plane of the polygon by {:.3} degrees; the texture will swim as the eye moves",
                mesh.name,
                angle.to_degrees(),
            ));
        }
        if mesh.triangles.is_empty() {
            warnings.push(format!("mesh '{}' has no triangles", mesh.name));
        }
        Ok(())
    }
}

/// Frames closer to the polygon's plane than this (radians) are taken to lie in it: f32 positions of a
/// tilted polygon are no more exact.
const FLAT: f64 = 1e-5;

pub(crate) fn finite<T: Copy + Into<f64>>(
    place: impl Fn() -> String,
    what: impl Fn() -> String,
    values: &[T],
) -> Result<(), SceneError> {
    match values
        .iter()
        .map(|v| (*v).into())
        .find(|v: &f64| !v.is_finite())
    {
        None => Ok(()),
        Some(v) => Err(SceneError::Value {
            place: place(),
            what: what(),
            value: v.to_string(),
            expected: "it must be finite",
        }),
    }
}

/// The first triangle that names a vertex of `count` or above, and that vertex.
fn vertex_out_of_range(triangles: &[[u32; 3]], count: usize) -> Option<(usize, u32)> {
    // The largest number comes first: it takes a fraction of the time of a search, and nearly every mesh is right.
    let largest = triangles.as_flattened().iter().max()?;
    let within = |vertex: u32| (vertex as usize) < count;
    if within(*largest) {
        return None;
    }
    let corner = |corner: usize, vertex: u32| (!within(vertex)).then_some((corner / 3, vertex));
    let mut corners = triangles.as_flattened().iter().enumerate();
    corners.find_map(|(k, vertex)| corner(k, *vertex))
}

fn all_finite(mesh: &Mesh, what: &str, values: &[f32], channels: usize) -> Result<(), SceneError> {
    // Blocks without a branch inside: one added to an exponent whose bits are all set carries into the sign.
    const EXPONENT: u32 = f32::INFINITY.to_bits();
    const ONE: u32 = f32::MIN_POSITIVE.to_bits();
    let carry = |v: &f32| (v.to_bits() & EXPONENT) + ONE;
    let sound = |block: &[f32]| block.iter().fold(0, |all, v| all | carry(v)) >> 31 == 0;
    if values.chunks(1024).all(sound) {
        return Ok(());
    }
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => Err(SceneError::Value {
            place: format!("mesh '{}' vertex {}", mesh.name, i / channels),
            what: what.to_owned(),
            value: values[i].to_string(),
            expected: "it must be finite",
        }),
    }
}

pub(crate) fn unit_range(
    place: impl Fn() -> String,
    what: &str,
    values: &[f32],
) -> Result<(), SceneError> {
    match values.iter().find(|v| !(0.0..=1.0).contains(*v)) {
        None => Ok(()),
        Some(v) => Err(SceneError::Value {
            place: place(),
            what: what.to_owned(),
            value: v.to_string(),
            expected: "it must be 0 to 1",
        }),
    }
}

pub(crate) fn index(
    place: impl Fn() -> String,
    what: &'static str,
    index: u64,
    count: usize,
) -> Result<(), SceneError> {
    if index < count as u64 {
        Ok(())
    } else {
        Err(SceneError::Index {
            place: place(),
            what,
            index,
            count,
        })
    }
}

fn per(
    mesh: &Mesh,
    what: &'static str,
    found: usize,
    of: &'static str,
    expected: usize,
) -> Result<(), SceneError> {
    if found == 0 || found == expected {
        return Ok(());
    }
    Err(SceneError::Count {
        mesh: mesh.name.clone(),
        what,
        found,
        of,
        expected,
    })
}
