//! Scenes: loaded from files, or built from arrays.

use std::path::{Path, PathBuf};
use std::sync::RwLock;

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use texmap_io::framing::{self, Framing, Up};
use texmap_io::scene_file::Missing;
use texmap_io::{FileSource, LoadOptions};
use texmap_light::{Light, PhongMaterial, Roughnesses};
use texmap_math::Camera;
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::Cull;
use texmap_sample::{Filter, Origin, Sampler, Wrap};
use texmap_scene::{AlphaMode, ColorMode, Material, Mesh, MetallicRoughness, Shading, TextureSlot};

use crate::render::near_of;
use crate::support::{interruptible, io, value, word};
use crate::texture::Texture;

/// A scene with the properties that are no part of its data.
#[derive(Clone)]
pub(crate) struct Loaded {
    pub(crate) scene: texmap_scene::Scene,
    /// The automatic camera, which depends on the shape of the picture; a scene with a camera of its own has none.
    pub(crate) framing: Option<Framing>,
    /// It is a model: four samples a pixel, and cameras near to it cut nothing away.
    pub(crate) model: bool,
    pub(crate) up: Up,
    /// True if automatic lights stand in where surfaces would be dark for want of light.
    pub(crate) lit: bool,
    /// The mip chains that its samplers read are built.
    pub(crate) has_mips: bool,
}

/// A scene of the Rust library behind a lock.
#[pyclass(frozen, module = "texmap._texmap")]
pub(crate) struct Scene {
    pub(crate) inner: RwLock<Loaded>,
}

impl Scene {
    pub(crate) fn of(loaded: Loaded) -> Self {
        Self {
            inner: RwLock::new(loaded),
        }
    }

    /// A copy of the data; textures are shared.
    pub(crate) fn copy(&self) -> PyResult<Loaded> {
        Ok(self.inner.read().map_err(value)?.clone())
    }

    fn edit<T>(&self, change: impl FnOnce(&mut Loaded) -> PyResult<T>) -> PyResult<T> {
        change(&mut *self.inner.write().map_err(value)?)
    }
}

/// Reads a scene or model as `texmap render` does.
#[pyfunction]
#[pyo3(signature = (path, missing, raw, up, view, camera, time, animation, root))]
pub(crate) fn load(
    py: Python<'_>,
    path: PathBuf,
    missing: Option<&str>,
    raw: Option<bool>,
    up: Option<&str>,
    view: Option<&str>,
    camera: Option<String>,
    time: Option<f64>,
    animation: Option<String>,
    root: Option<PathBuf>,
) -> PyResult<Scene> {
    let ending = |name: &str| {
        let found = path.extension().and_then(|e| e.to_str());
        found.is_some_and(|found| found.eq_ignore_ascii_case(name))
    };
    let scene_file = ending("scene");
    let up = match up {
        Some("y") => Up::Y,
        Some("z") => Up::Z,
        None if ending("stl") => Up::Z,
        None => Up::Y,
        Some(other) => return Err(value(format!("up={other:?}: know y, z"))),
    };
    let missing = match missing {
        None => (!scene_file).then_some(Missing::Checker),
        Some(name) => {
            let found = Missing::ALL.iter().find(|(word, _)| *word == name);
            let refused = || value(format!("missing={name:?}: know error, checker, grey"));
            Some(found.ok_or_else(refused)?.1)
        }
    };
    let framing = Framing {
        up,
        view: view.map_or(Ok(Default::default()), |name| word("view", name))?,
        ..Framing::default()
    };
    let files = match &root {
        Some(folder) => FileSource::within(folder).map_err(io)?,
        None => FileSource::anywhere(),
    };
    let own_camera = scene_file || camera.is_some();
    let options = LoadOptions {
        missing,
        framing,
        color: raw.map(|raw| if raw { ColorMode::Raw } else { ColorMode::Srgb }),
        files,
        camera,
        time,
        animation,
        ..LoadOptions::default()
    };
    let read = |path: &Path| {
        let mut scene = texmap_io::load(path, &options)?;
        if !scene_file {
            framing::light_as_model(&mut scene, up);
        }
        Ok(scene)
    };
    let scene = interruptible(py, None, |_| read(&path))?.map_err(io)?;
    Ok(Scene::of(Loaded {
        scene,
        framing: (!own_camera).then_some(framing),
        model: !scene_file,
        up,
        lit: !scene_file,
        has_mips: false,
    }))
}

fn triples(array: &PyReadonlyArray1<'_, f32>) -> PyResult<Vec<[f32; 3]>> {
    Ok(array.as_slice()?.as_chunks::<3>().0.to_vec())
}

#[pymethods]
impl Scene {
    /// A scene without meshes whose camera shows all that is added.
    #[new]
    fn new(up: &str) -> PyResult<Self> {
        let up = match up {
            "y" => Up::Y,
            "z" => Up::Z,
            other => return Err(value(format!("up={other:?}: know y, z"))),
        };
        let mut scene = texmap_scene::Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0, 0.0, 0.0]));
        scene.background = [0.22, 0.24, 0.27, 1.0];
        Ok(Self::of(Loaded {
            scene,
            framing: Some(Framing {
                up,
                ..Framing::default()
            }),
            model: true,
            up,
            lit: false,
            has_mips: false,
        }))
    }

    fn add_texture(&self, texture: &Texture) -> PyResult<usize> {
        let [group] = &texture.groups[..] else {
            return Err(value(format!(
                "a material's texture has {} channels, expected 1 to 4",
                texture.channels
            )));
        };
        self.edit(|this| {
            this.scene.textures.push(group.clone());
            this.has_mips = false;
            Ok(this.scene.textures.len() - 1)
        })
    }

    fn add_material(
        &self,
        name: String,
        color: [f32; 3],
        metallic_roughness: Option<[f32; 2]>,
        phong: [f32; 4],
        shading: &str,
        texture: Option<usize>,
        filter: &str,
        wrap: &str,
        alpha: (&str, f32),
        opacity: f32,
        cull: bool,
    ) -> PyResult<usize> {
        let [ka, kd, ks, ns] = phong;
        let wrap: Wrap = word("wrap", wrap)?;
        let base_color = match texture {
            None => None,
            Some(texture) => Some(TextureSlot {
                sampler: Sampler {
                    filter: word::<Filter>("filter", filter)?,
                    wrap_u: wrap,
                    wrap_v: wrap,
                    ..Sampler::default()
                },
                ..TextureSlot::new(texture)
            }),
        };
        let material = Material {
            name,
            phong: PhongMaterial {
                color,
                ka,
                kd,
                ks,
                ns,
            },
            metallic_roughness: metallic_roughness.map(|[metallic, roughness]| MetallicRoughness {
                metallic,
                roughness,
                ..MetallicRoughness::default()
            }),
            opacity,
            base_color,
            shading: match shading {
                "unlit" => Shading::Unlit,
                "vertex" => Shading::PerVertex,
                "pixel" => Shading::PerPixel,
                other => {
                    return Err(value(format!(
                        "shading={other:?}: know unlit, vertex, pixel"
                    )));
                }
            },
            alpha: match alpha {
                ("opaque", _) => AlphaMode::Opaque,
                ("test", threshold) => AlphaMode::Test(threshold),
                ("blend", _) => AlphaMode::Blend,
                (other, _) => {
                    return Err(value(format!("alpha={other:?}: know opaque, test, blend")));
                }
            },
            cull: if cull { Cull::Back } else { Cull::None },
            ..Material::default()
        };
        self.edit(|this| {
            this.scene.materials.push(material);
            framing::renew_studio(&mut this.scene, Roughnesses::NONE);
            this.has_mips = false;
            Ok(this.scene.materials.len() - 1)
        })
    }

    fn add_mesh(
        &self,
        name: String,
        positions: PyReadonlyArray1<'_, f32>,
        faces: PyReadonlyArray1<'_, u32>,
        uvs: Option<PyReadonlyArray1<'_, f32>>,
        normals: Option<PyReadonlyArray1<'_, f32>>,
        colors: Option<PyReadonlyArray1<'_, f32>>,
        lightmap_uvs: Option<PyReadonlyArray1<'_, f32>>,
        transform: Option<PyReadonlyArray2<'_, f64>>,
        material: usize,
        bottom_up: bool,
    ) -> PyResult<()> {
        let pairs = |array: Option<PyReadonlyArray1<'_, f32>>| -> PyResult<Vec<[f32; 2]>> {
            match array {
                Some(array) => Ok(array.as_slice()?.as_chunks::<2>().0.to_vec()),
                None => Ok(Vec::new()),
            }
        };
        let optional = |array: Option<PyReadonlyArray1<'_, f32>>| match array {
            Some(array) => triples(&array),
            None => Ok(Vec::new()),
        };
        let mesh = Mesh {
            name,
            positions: triples(&positions)?,
            triangles: faces.as_slice()?.as_chunks::<3>().0.to_vec(),
            uvs: pairs(uvs)?,
            normals: optional(normals)?,
            colors: optional(colors)?,
            lightmap_uvs: pairs(lightmap_uvs)?,
            world_from_object: match transform {
                Some(rows) => matrix(rows.as_slice()?)?,
                None => DMat4::IDENTITY,
            },
            material,
            uv_origin: if bottom_up {
                Origin::BottomLeft
            } else {
                Origin::TopLeft
            },
            ..Mesh::default()
        };
        // The fields that the check of the scene would meet later, while the name is at hand.
        let count = mesh.positions.len();
        if let Some(index) = mesh
            .triangles
            .as_flattened()
            .iter()
            .find(|i| **i as usize >= count)
        {
            return Err(value(format!(
                "mesh '{}': faces name vertex {index}, there are {count}",
                mesh.name
            )));
        }
        self.edit(|this| {
            this.scene.meshes.push(mesh);
            this.has_mips = false;
            Ok(())
        })
    }

    /// Adds a light: `ambient`, `directional`, `point` or `spot`; angles are half angles in radians.
    fn add_light(
        &self,
        kind: &str,
        color: [f32; 3],
        position: [f32; 3],
        direction: [f32; 3],
        angles: [f32; 2],
    ) -> PyResult<()> {
        let light = match kind {
            "ambient" => Light::Ambient { color },
            "directional" => Light::Directional { color, direction },
            "point" => Light::Point { color, position },
            "spot" => Light::spot(color, position, direction, angles[0], angles[1]),
            other => {
                return Err(value(format!(
                    "light {other:?}: know ambient, directional, point, spot"
                )));
            }
        };
        if !light.is_valid() {
            return Err(value(format!(
                "light {kind:?}: numbers must be finite, colours at least 0, directions not zero"
            )));
        }
        self.edit(|this| {
            this.scene.lights.push(light);
            Ok(())
        })
    }

    /// Lights the scene as a model without lights of its own.
    fn light_as_model(&self) -> PyResult<()> {
        self.edit(|this| {
            framing::light_model(&mut this.scene, this.up, false);
            framing::light_dark_surfaces(&mut this.scene, this.up);
            this.lit = true;
            Ok(())
        })
    }

    /// Samples of the light from all around that cast shadows.
    fn set_environment_shadows(&self, samples: u32) -> PyResult<()> {
        self.edit(|this| {
            this.scene.effects.environment_shadows = samples;
            Ok(())
        })
    }

    fn set_background(&self, color: [f32; 4]) -> PyResult<()> {
        self.edit(|this| {
            this.scene.background = color;
            Ok(())
        })
    }

    /// The camera of pictures that name none. Meshes come first: without `near` it cuts none of them away.
    fn set_camera(
        &self,
        eye: [f64; 3],
        look: [f64; 3],
        up: [f64; 3],
        fov_x: f64,
        near: Option<f64>,
        far: f64,
    ) -> PyResult<()> {
        self.edit(|this| {
            let camera = look_at(eye, look, up, fov_x, near, far);
            this.scene.camera = match near {
                Some(_) => camera,
                None => near_of(this, camera),
            };
            this.framing = None;
            Ok(())
        })
    }

    /// Names and counts of the meshes: (name, vertices, triangles, has uvs).
    fn meshes(&self) -> PyResult<Vec<(String, usize, usize, bool)>> {
        let inner = self.inner.read().map_err(value)?;
        let of = |m: &Mesh| {
            (
                m.name.clone(),
                m.positions.len(),
                m.triangles.len(),
                !m.uvs.is_empty(),
            )
        };
        Ok(inner.scene.meshes.iter().map(of).collect())
    }

    /// Flat positions, faces and uvs of a mesh, positions in world space; uvs count from the bottom row if the last entry is true.
    fn mesh_arrays(&self, index: usize) -> PyResult<(Vec<f32>, Vec<u32>, Vec<f32>, bool)> {
        let inner = self.inner.read().map_err(value)?;
        let meshes = &inner.scene.meshes;
        let mesh = meshes
            .get(index)
            .ok_or_else(|| value(format!("mesh {index}: there are {}", meshes.len())))?;
        let world = |p: &[f32; 3]| {
            let p = mesh
                .world_from_object
                .transform_point3(texmap_math::wide(*p));
            texmap_math::narrow(p)
        };
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(world).collect();
        Ok((
            positions.as_flattened().to_vec(),
            mesh.triangles.as_flattened().to_vec(),
            mesh.uvs.as_flattened().to_vec(),
            mesh.uv_origin == Origin::BottomLeft,
        ))
    }

    fn counts(&self) -> PyResult<(usize, usize, usize)> {
        let inner = self.inner.read().map_err(value)?;
        let scene = &inner.scene;
        Ok((
            scene.textures.len(),
            scene.materials.len(),
            scene.lights.len(),
        ))
    }

    fn warnings(&self) -> PyResult<Vec<String>> {
        Ok(self.inner.read().map_err(value)?.scene.warnings.clone())
    }

    fn copied(&self) -> PyResult<Self> {
        Ok(Self::of(self.copy()?))
    }
}

/// A camera at `eye`; without `near` its near plane is at a thousandth of the distance to `look`.
pub(crate) fn look_at(
    eye: [f64; 3],
    look: [f64; 3],
    up: [f64; 3],
    fov_x: f64,
    near: Option<f64>,
    far: f64,
) -> Camera {
    let (eye, look) = (DVec3::from(eye), DVec3::from(look));
    Camera {
        up: DVec3::from(up),
        fov_x,
        near: near.unwrap_or_else(|| (look - eye).length() * 1e-3),
        far,
        ..Camera::look_at(eye, look)
    }
}

/// A matrix of 16 numbers in rows.
pub(crate) fn matrix(rows: &[f64]) -> PyResult<DMat4> {
    let rows: [f64; 16] = rows
        .try_into()
        .map_err(|_| value("a matrix has 4 x 4 numbers"))?;
    Ok(DMat4::from_cols_array(&rows).transpose())
}
