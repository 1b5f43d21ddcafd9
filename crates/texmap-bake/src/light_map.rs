//! Light maps: direct light with shadows, baked onto the second uv set of a mesh.

use std::collections::{BTreeMap, BTreeSet};

use texmap_light::{PhongMaterial, ShadowBias, ShadowMap, SpecularModel, shade_with_visibility};
use texmap_math::MemoryBudget;
use texmap_math::glam::DVec3;
use texmap_math::parallel;
use texmap_math::progress::{Progress, Steps, no_progress};
use texmap_raster::{Atlas, AtlasMesh, AtlasOptions, Coverage, RasterError, TargetSize};
use texmap_sample::Origin;
use texmap_scene::SceneError;

use texmap_math::color::luminance;

use texmap_render::RenderError;
use texmap_scene::Scene;

/// A shadow map with the index of its light, its bias and the PCF comparisons a side.
type LightShadow = (usize, ShadowMap, ShadowBias, u32);

/// Options of a baked light map.
#[derive(Clone, Debug)]
pub struct BakeOptions<'a> {
    /// Texels a side, 1..=16384.
    pub size: u32,
    /// Texels by which islands are dilated: 1 for bilinear look-ups, 2^L for mips down to level L.
    pub gutter: u32,
    /// Shadow maps, each with the index of its light, its bias and the PCF comparisons a side.
    pub shadows: &'a [(usize, ShadowMap, ShadowBias, u32)],
    /// Lights that count, by index; all of them if `None`.
    pub lights: Option<&'a [usize]>,
}

/// A baked map: the light that a white matte surface returns, linear, not clipped. It is `sum La + sum max(0, N.L) Ll`.
#[derive(Clone, Debug, PartialEq)]
pub struct LightMap {
    /// Texels a side.
    pub size: u32,
    /// Rows top to bottom; black where no island and no gutter is.
    pub texels: Vec<[f32; 3]>,
    /// Coverage of each texel.
    pub coverage: Vec<Coverage>,
    /// Faces that own no texel: their light is that of their neighbours in the map.
    pub lost: Vec<u32>,
}

/// Bakes the light maps of the meshes of a scene that was checked once.
#[derive(Clone, Copy, Debug)]
pub struct Baker<'s> {
    scene: &'s Scene,
}

impl<'s> Baker<'s> {
    /// For a scene without faults.
    ///
    /// # Errors
    /// Those of [`Scene::check`].
    pub fn new(scene: &'s Scene) -> Result<Self, RenderError> {
        scene.check()?;
        Ok(Self { scene })
    }

    /// The light map of a mesh: see [`bake`].
    ///
    /// # Errors
    /// Those of [`bake`], but for faults of the scene.
    pub fn bake(&self, mesh: usize, options: &BakeOptions<'_>) -> Result<LightMap, RenderError> {
        self.bake_with_progress(mesh, options, &no_progress)
    }

    /// [`bake`](Self::bake) with a callback that hears of the steps of the atlas and then of each lit row, and may end the work.
    ///
    /// # Errors
    /// Those of [`bake`](Self::bake); [`RenderError::Cancelled`] after a break.
    pub fn bake_with_progress(
        &self,
        mesh: usize,
        options: &BakeOptions<'_>,
        progress: Progress<'_>,
    ) -> Result<LightMap, RenderError> {
        let scene = self.scene;
        let count = scene.meshes.len();
        let mesh = scene.meshes.get(mesh).ok_or(SceneError::Index {
            place: "bake".to_owned(),
            what: "mesh",
            index: mesh as u64,
            count,
        })?;
        let uvs = if mesh.lightmap_uvs.is_empty() {
            &mesh.uvs
        } else {
            &mesh.lightmap_uvs
        };
        if uvs.is_empty() {
            return Err(SceneError::MissingUv {
                mesh: mesh.name.clone(),
                material: "a light map".to_owned(),
            }
            .into());
        }
        let refused = |error| match error {
            RasterError::Memory(refused) => RenderError::Memory(refused),
            RasterError::Cancelled => RenderError::Cancelled,
            error => RenderError::Raster {
                mesh: mesh.name.clone(),
                error,
            },
        };
        let normals: Vec<[f32; 3]> = mesh
            .world_normals()
            .iter()
            .map(|n| n.to_array().map(|c| c as f32))
            .collect();
        let positions: Vec<[f32; 3]> = mesh
            .positions
            .iter()
            .map(|p| {
                let p = DVec3::from(p.map(f64::from));
                let world = mesh.world_from_object.transform_point3(p);
                world.to_array().map(|c| c as f32)
            })
            .collect();
        let atlas = Atlas::with_progress(
            TargetSize::new(options.size, options.size).map_err(refused)?,
            &AtlasMesh {
                uvs,
                positions: &positions,
                normals: &normals,
                indices: &mesh.triangles,
                bottom_up: mesh.uv_origin == Origin::BottomLeft,
            },
            AtlasOptions {
                conservative: true,
                gutter: options.gutter,
                threads: parallel::threads(),
                memory: MemoryBudget::of_process(),
            },
            progress,
        )
        .map_err(refused)?;
        let flat = mesh.triangle_normals();
        let matte = PhongMaterial {
            color: [1.0; 3],
            ka: 1.0,
            kd: 1.0,
            ks: 0.0,
            ns: 1.0,
        };
        let named = options.lights.into_iter().flatten().copied();
        let shadowed = options.shadows.iter().map(|shadow| shadow.0);
        let count = scene.lights.len();
        if let Some(light) = named.chain(shadowed).find(|light| *light >= count) {
            return Err(SceneError::Index {
                place: "bake".to_owned(),
                what: "light",
                index: light as u64,
                count,
            }
            .into());
        }
        let wanted: Option<BTreeSet<usize>> =
            options.lights.map(|all| all.iter().copied().collect());
        let counts = |light: usize| wanted.as_ref().is_none_or(|all| all.contains(&light));
        let (numbers, lights): (Vec<usize>, Vec<_>) = scene
            .lights
            .iter()
            .enumerate()
            .filter(|(i, _)| counts(*i))
            .map(|(i, light)| (i, *light))
            .unzip();
        let shadows = by_light(options.shadows, &numbers);
        let eye = scene.camera.eye.to_array().map(|c| c as f32);
        let width = options.size as usize;
        let size = options.size;
        MemoryBudget::of_process().ask(
            (atlas.face.len() * size_of::<[f32; 3]>()) as u64,
            format_args!("a light map of {size} x {size} texels"),
            "take a smaller light map",
        )?;
        let mut texels = vec![[0.0; 3]; atlas.face.len()];
        let steps = Steps::new(progress, width);
        parallel::for_each(texels.chunks_mut(width).enumerate(), |(row, out)| {
            if steps.is_cancelled() {
                return;
            }
            for (x, texel) in out.iter_mut().enumerate() {
                let at = row * width + x;
                if atlas.coverage[at] == Coverage::None {
                    continue;
                }
                let (point, normal) = (atlas.position[at], atlas.normal[at]);
                let plane = flat[atlas.face[at] as usize];
                let received = |light: usize| {
                    let mut share = 1.0;
                    for (_, map, bias, pcf_size) in &shadows[light] {
                        let point = DVec3::from(point.map(f64::from));
                        share *= map.visibility(point, plane, *bias, *pcf_size);
                    }
                    [share; 3]
                };
                *texel = shade_with_visibility(
                    &matte,
                    SpecularModel::Phong,
                    &lights,
                    point,
                    normal,
                    eye,
                    received,
                )
                .diffuse;
            }
            steps.step();
        });
        if steps.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        Ok(LightMap {
            size: options.size,
            texels,
            coverage: atlas.coverage,
            lost: atlas.lost,
        })
    }
}

/// The shadow maps of each of these lights, in the order of the list.
fn by_light<'a>(shadows: &'a [LightShadow], lights: &[usize]) -> Vec<Vec<&'a LightShadow>> {
    let mut of_index: BTreeMap<usize, Vec<&LightShadow>> = BTreeMap::new();
    for shadow in shadows {
        of_index.entry(shadow.0).or_default().push(shadow);
    }
    let of_light = |index| of_index.remove(index).unwrap_or_default();
    lights.iter().map(of_light).collect()
}

/// Bakes the light that reaches a mesh, at the centre of every texel of its light-map coordinates. [`Baker`] checks a scene once for
/// many meshes.
///
/// The coordinates are [`Mesh::lightmap_uvs`](texmap_scene::Mesh::lightmap_uvs), or `uvs` if it has no second
/// set.
///
/// Texels that a face touches without covering their centre are lit at the nearest point of that face, so that no texel in use is
/// lit off the mesh; then islands are dilated. The same bits for any number of threads.
///
/// # Errors
/// Those of [`Scene::check`]; [`SceneError::Index`] for a mesh or a light that does not exist, [`SceneError::MissingUv`] for one without
/// coordinates, [`RenderError::Raster`] for a size out of range, [`RenderError::Memory`] for a map beyond the memory budget of the process.
pub fn bake(
    scene: &Scene,
    mesh: usize,
    options: &BakeOptions<'_>,
) -> Result<LightMap, RenderError> {
    Baker::new(scene)?.bake(mesh, options)
}

impl LightMap {
    /// One channel: the luminance of each texel (Rec. ITU-R BT.709), 0.2126 R + 0.7152 G + 0.0722 B.
    #[must_use]
    pub fn luminance(&self) -> Vec<f32> {
        self.texels.iter().map(|c| luminance(*c)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_light::{Light, ShadowKind};
    use texmap_math::Camera;
    use texmap_math::glam::DMat4;
    use texmap_scene::{Material, Mesh};

    /// A floor under many equal lights from above.
    fn floor(lights: usize) -> Scene {
        let light = Light::Directional {
            color: [1.0 / lights as f32; 3],
            direction: [0.0, -1.0, 0.0],
        };
        Scene {
            lights: vec![light; lights],
            materials: vec![Material::default()],
            meshes: vec![Mesh::quad([
                [-1.0, 0.0, -1.0],
                [1.0, 0.0, -1.0],
                [1.0, 0.0, 1.0],
                [-1.0, 0.0, 1.0],
            ])],
            ..Scene::new(Camera::look_at([0.0, 2.0, 2.0], [0.0; 3]))
        }
    }

    /// A map of one texel for a light, in which all is in shadow or all is lit.
    fn shadow(light: usize, dark: bool) -> LightShadow {
        let kind = ShadowKind::Directional {
            light_from_world: DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2),
            half: 4.0,
        };
        let depth = if dark { -8.0 } else { 8.0 };
        let map = ShadowMap::new(kind, 1, vec![depth]).unwrap();
        (light, map, ShadowBias::Constant(0.01), 1)
    }

    fn options<'a>(shadows: &'a [LightShadow], lights: Option<&'a [usize]>) -> BakeOptions<'a> {
        BakeOptions {
            size: 4,
            gutter: 0,
            shadows,
            lights,
        }
    }

    #[test]
    fn every_light_has_its_own_shadows() {
        let scene = floor(4);
        // Out of order, two for light 3, and one for a light that is left out.
        let shadows = [(3, false), (1, true), (3, true), (0, false)];
        let shadows = shadows.map(|(light, dark)| shadow(light, dark));
        let light = |lights| bake(&scene, 0, &options(&shadows, lights)).unwrap().texels[5][0];
        assert_eq!(light(None), 0.5);
        assert_eq!(light(Some(&[2, 3])), 0.25);
        assert_eq!(light(Some(&[1, 3])), 0.0);
    }

    #[test]
    fn lights_that_do_not_exist_are_named() {
        let scene = floor(2);
        let far = [shadow(7, true)];
        for (shadows, lights) in [(&far[..], None), (&[], Some(&[0, 7][..]))] {
            let error = bake(&scene, 0, &options(shadows, lights)).unwrap_err();
            assert!(
                error.to_string().contains("light 7 does not exist"),
                "{error}"
            );
        }
    }
}
