"""Scenes: from files, from arrays, from meshes of other packages; and their pictures."""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import dataclass, field
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _texmap
from ._arrays import ImageLike, array, bottom_up, output, pixels, shaped, size_of
from ._picture import png_bytes, write_png
from ._texture import Texture

Vector = Sequence[float]


class TexmapWarning(UserWarning):
    """A choice that was made for the caller: a missing map, a scene of which nothing is seen."""


@dataclass
class Material:
    """A surface. Colours are linear light, 0 to 1.

    ``shading`` is pixel, vertex or unlit; ``model`` metallic-roughness or phong (then ``ka``, ``kd``, ``ks``, ``ns`` of the MIT surf
    command). ``alpha`` is opaque, test (cut at ``alpha_threshold``) or blend. ``texture`` is a :class:`Texture`, an image or a path.
    """

    color: Vector = (0.8, 0.8, 0.8)
    texture: Optional[Union[Texture, ImageLike]] = None
    metallic: float = 0.0
    roughness: float = 0.6
    shading: str = "pixel"
    model: str = "metallic-roughness"
    ka: float = 1.0
    kd: float = 1.0
    ks: float = 0.0
    ns: float = 5.0
    alpha: str = "opaque"
    alpha_threshold: float = 0.5
    opacity: float = 1.0
    filter: str = "trilinear"
    wrap: str = "repeat"
    cull: bool = False
    name: str = ""


@dataclass
class Mesh:
    """Triangles of one material.

    vertices (n, 3) float32; faces (m, 3) whole numbers, counter-clockwise seen from the front; uv (n, 2), normals (n, 3), colors (n, 3)
    linear; lightmap_uv (n, 2): a second set for light maps; transform (4, 4): object to world. ``uv_origin`` is the row at v = 0 of the
    pictures that uv speaks of: bottom-left (OBJ, Blender, trimesh) or top-left (glTF).
    """

    vertices: Any
    faces: Any
    uv: Any = None
    normals: Any = None
    colors: Any = None
    lightmap_uv: Any = None
    transform: Any = None
    material: Union[int, Material] = 0
    uv_origin: str = "bottom-left"
    name: str = ""


@dataclass
class Light:
    """A light: kind ambient, directional (``direction`` from the light to the surface), point or spot (angles in degrees: full
    inside of ``inner``, none outside of ``outer``). A white surface that faces a light of colour 1 has the radiance 1."""

    kind: str
    color: Vector = (1.0, 1.0, 1.0)
    position: Vector = (0.0, 0.0, 0.0)
    direction: Vector = (0.0, -1.0, 0.0)
    inner: float = 30.0
    outer: float = 45.0


@dataclass
class Camera:
    """A camera at ``eye`` that looks at ``look``; ``fov`` is the horizontal field of view in degrees. ``near`` defaults to what cuts
    nothing away; ``far`` may be infinite."""

    eye: Vector
    look: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    fov: float = 40.0
    near: Optional[float] = None
    far: float = math.inf


@dataclass
class Poses:
    """One or many calibrated cameras.

    pose : (4, 4) or (n, 4, 4), rows, translation in the last column: from camera to world, or from world to camera with
        ``world_to_camera=True`` (extrinsics).
    axes : ``"opencv"`` (x right, y down, looking along +z: OpenCV, COLMAP) or ``"opengl"`` (y up, looking along -z: OpenGL, Blender,
        NeRF). It has no default: a wrong guess gives a plausible wrong picture.
    K : (3, 3) or (n, 3, 3) intrinsics in pixels, the principal point from the upper left corner of the picture (half a width is the
        middle). Without it ``fov`` is the horizontal field of view in degrees, or that of the scene's camera.
    """

    pose: Any
    axes: str
    K: Any = None
    world_to_camera: bool = False
    fov: Optional[float] = None

    def _arguments(self) -> Tuple[tuple, bool]:
        pose = array(self.pose, np.float64, "pose")
        batch = pose.ndim == 3
        if pose.shape[-2:] != (4, 4) or pose.ndim not in (2, 3):
            raise ValueError(f"pose: expected shape (4, 4) or (n, 4, 4), got {pose.shape}")
        pose = pose.reshape(-1, 4, 4)
        if len(pose) == 0:
            raise ValueError("pose: there is no pose")
        lens = None
        if self.K is not None:
            k = array(self.K, np.float64, "K")
            if k.shape not in ((3, 3), (len(pose), 3, 3)):
                raise ValueError(f"K: expected shape (3, 3) or ({len(pose)}, 3, 3), got {k.shape}")
            k = k.reshape(-1, 3, 3)
            odd = np.abs(k[:, [0, 1, 2, 2], [1, 0, 0, 1]]).max() > 1e-9 * np.abs(k).max() or np.any(k[:, 2, 2] != 1)
            if odd:
                raise ValueError("K: expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]; skew is not supported")
            lens = np.ascontiguousarray(k[:, [0, 1, 0, 1], [0, 1, 2, 2]]).reshape(-1)
        fov = None if self.fov is None else math.radians(self.fov)
        return (pose.reshape(-1), lens, self.axes, self.world_to_camera, fov), batch


def look_at(eye: Vector, target: Vector = (0.0, 0.0, 0.0), up: Vector = (0.0, 1.0, 0.0), axes: str = "opencv") -> np.ndarray:
    """The (4, 4) float64 pose, camera to world, of a camera at ``eye`` that looks at ``target``. Raises ValueError where they are one
    point, or ``up`` is parallel to the line of sight."""
    origin, to, above = (np.asarray(_vector(v, name)) for v, name in ((eye, "eye"), (target, "target"), (up, "up")))
    forward = to - origin
    right = np.cross(forward, above)
    if not np.linalg.norm(right) > 1e-9 * np.linalg.norm(forward) * np.linalg.norm(above):
        raise ValueError(f"look_at: no view from {origin.tolist()} to {to.tolist()} with up {above.tolist()}")
    forward, right = forward / np.linalg.norm(forward), right / np.linalg.norm(right)
    if axes not in ("opencv", "opengl"):
        raise ValueError(f"axes={axes!r}: know opengl, opencv")
    down = np.cross(forward, right)
    columns = (right, down, forward, origin) if axes == "opencv" else (right, -down, -forward, origin)
    pose = np.eye(4)
    pose[:3] = np.stack(columns, axis=1)
    return pose


def project(points: Any, camera: Poses, size: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Where a calibrated camera sees points of the world.

    points (..., 3); camera: :class:`Poses` of one pose with ``K`` or ``fov``; size (width, height) of the picture.

    Returns uv (..., 2) float32, texture coordinates in the picture (v = 0 at its bottom row, as :func:`texmap.sample` reads it), and w (...)
    float32, distances along the line of sight, the inverse of the AOV inv_w. Points that are not before the camera have uv -1. Raises
    ValueError.
    """
    width, height = size_of(size)
    (flat, lens, axes, world_to_camera, fov), _ = camera._arguments()
    if len(flat) != 16:
        raise ValueError(f"camera: expected one pose, got {len(flat) // 16}")
    if lens is None and fov is None:
        raise ValueError("camera: give K or fov")
    if axes not in ("opencv", "opengl"):
        raise ValueError(f"axes={axes!r}: know opengl, opencv")
    found = array(points, np.float64, "points")
    if found.ndim < 1 or found.shape[-1] != 3:
        raise ValueError(f"points: expected shape (..., 3), got {found.shape}")
    matrix = flat.reshape(4, 4) if world_to_camera else np.linalg.inv(flat.reshape(4, 4))
    seen = found @ matrix[:3, :3].T + matrix[:3, 3]
    if axes == "opengl":
        seen = seen * [1.0, -1.0, -1.0]
    if lens is None:
        focal = 0.5 * width / math.tan(0.5 * fov)
        lens = (focal, focal, 0.5 * width, 0.5 * height)
    fx, fy, cx, cy = lens
    w = seen[..., 2]
    before = w > 0
    safe = np.where(before, w, 1.0)
    u = (fx * seen[..., 0] / safe + cx) / width
    v = 1.0 - (fy * seen[..., 1] / safe + cy) / height
    uv = np.where(before[..., None], np.stack([u, v], axis=-1), -1.0)
    return uv.astype(np.float32), w.astype(np.float32)


class Frame(dict):
    """The arrays of a rendering by name: ``frame["rgba"]`` (height, width, 4) uint8, sRGB, straight alpha, rows top to bottom, and
    one array for each AOV; a batch has the number of the picture as first axis. ``warnings`` holds sentences."""

    warnings: List[str]

    @property
    def rgba(self) -> np.ndarray:
        """The picture."""
        return self["rgba"]

    @property
    def hash(self) -> Union[str, List[str]]:
        """The hash of ``texmap render --json``: one string, or one for each picture of a batch."""
        if self.rgba.ndim == 4:
            return [pixel_hash(picture) for picture in self.rgba]
        return pixel_hash(self.rgba)

    def save(self, path: Any) -> None:
        """Writes the picture as PNG; a batch goes to names with ``%``, such as ``view-%02d.png``."""
        if self.rgba.ndim == 3:
            write_png(path, self.rgba)
            return
        pattern = os.fspath(path)
        if "%" not in pattern:
            raise ValueError(f"{pattern}: {len(self.rgba)} pictures need a name such as view-%02d.png")
        for k, picture in enumerate(self.rgba):
            write_png(pattern % k, picture)

    def _repr_png_(self) -> bytes:
        rgba = self.rgba
        return png_bytes(rgba if rgba.ndim == 3 else np.concatenate(list(rgba[:8]), axis=1))

    def __repr__(self) -> str:
        arrays = ", ".join(f"{name} {value.shape} {value.dtype}" for name, value in self.items())
        return f"<texmap.Frame {arrays}>"


def pixel_hash(image: Any) -> str:
    """The hash of decoded pixels that ``texmap render --json`` and ``texmap hash`` print: FNV-1a 128 of width, height and bytes.

    image : (height, width[, channels]); RGBA uint8 for the hash of a rendered picture, other types by their little-endian bytes.
    """
    found = np.asarray(image)
    if found.ndim not in (2, 3) or 0 in found.shape:
        raise ValueError(f"image: expected shape (height, width[, channels]), got {found.shape}")
    found = np.ascontiguousarray(found, dtype=found.dtype.newbyteorder("<"))
    return _texmap.pixel_hash(found.shape[1], found.shape[0], found.reshape(-1).view(np.uint8))


def _mesh_of(thing: Any) -> List[Mesh]:
    """Meshes of the types that are known: :class:`Mesh`, trimesh, Open3D, dictionaries and tuples."""
    if isinstance(thing, Mesh):
        return [thing]
    if isinstance(thing, dict):
        return [Mesh(**thing)]
    if isinstance(thing, tuple) and len(thing) in (2, 3):
        return [Mesh(*thing)]
    if hasattr(thing, "geometry") and hasattr(thing, "dump"):  # trimesh.Scene: copies with their place in the scene applied
        return [mesh for part in thing.dump() for mesh in _mesh_of(part)]
    if hasattr(thing, "vertices") and hasattr(thing, "faces"):  # trimesh.Trimesh
        return [_of_trimesh(thing)]
    if hasattr(thing, "vertices") and hasattr(thing, "triangles"):  # open3d.geometry.TriangleMesh
        return [_of_open3d(thing)]
    raise ValueError(
        f"a mesh is texmap.Mesh, (vertices, faces[, uv]), a dictionary of those, a trimesh or an Open3D mesh; got {type(thing).__name__}"
    )


def _of_trimesh(mesh: Any) -> Mesh:
    visual: Any = getattr(mesh, "visual", None)
    uv = getattr(visual, "uv", None)
    if uv is not None and len(uv) != len(mesh.vertices):
        uv = None
    material = getattr(visual, "material", None)
    image = None
    for name in ("baseColorTexture", "image"):
        image = image if image is not None else getattr(material, name, None)
    color = getattr(material, "baseColorFactor", None)
    if color is None:
        color = getattr(material, "diffuse", None) if image is None else None
    made = Material(texture=image if uv is not None else None)
    if image is not None and uv is not None:
        made.color = (1.0, 1.0, 1.0)
    if color is not None:
        rgb = np.asarray(color, np.float64).reshape(-1)[:3]
        rgb = rgb / 255.0 if np.asarray(color).dtype.kind in "iu" else rgb
        made.color = tuple(float(c) for c in _linear(rgb)) if image is None else tuple(map(float, rgb))
    for name, key in (("metallicFactor", "metallic"), ("roughnessFactor", "roughness")):
        value = getattr(material, name, None)
        if value is not None:
            setattr(made, key, float(value))
    colors = None
    if getattr(visual, "kind", None) == "vertex":
        colors = _linear(np.asarray(visual.vertex_colors, np.float64)[:, :3] / 255.0)
        made.color = (1.0, 1.0, 1.0)
    normals = mesh.vertex_normals if "vertex_normals" in getattr(mesh, "_cache", {}) else None
    return Mesh(mesh.vertices, mesh.faces, uv, normals, colors, material=made, name=str(getattr(mesh, "metadata", {}).get("name", "")))


def _of_open3d(mesh: Any) -> Mesh:
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    corner_uv = np.asarray(getattr(mesh, "triangle_uvs", np.zeros((0, 2))))
    normals = np.asarray(getattr(mesh, "vertex_normals", np.zeros((0, 3))))
    colors = np.asarray(getattr(mesh, "vertex_colors", np.zeros((0, 3))))
    uv = None
    if len(corner_uv) == 3 * len(faces) and len(faces):
        # One coordinate a corner: vertices are split where corners differ.
        keys = np.concatenate([faces.reshape(-1, 1).astype(np.float64), corner_uv], axis=1)
        unique, inverse = np.unique(keys, axis=0, return_inverse=True)
        old = unique[:, 0].astype(np.int64)
        vertices, uv, faces = vertices[old], unique[:, 1:], inverse.reshape(-1, 3)
        normals = normals[old] if len(normals) else normals
        colors = colors[old] if len(colors) else colors
    images = [np.asarray(t) for t in getattr(mesh, "textures", [])]
    images = [t for t in images if t.size]
    made = Material(texture=images[0] if images and uv is not None else None)
    if made.texture is not None or len(colors):
        made.color = (1.0, 1.0, 1.0)
    return Mesh(
        vertices,
        faces,
        uv,
        normals if len(normals) else None,
        _linear(colors) if len(colors) else None,
        material=made,
    )


def _linear(srgb: np.ndarray) -> np.ndarray:
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


class Scene:
    """Everything that is drawn.

    Parameters
    ----------
    meshes : a mesh or a list of them: :class:`Mesh`, ``(vertices, faces[, uv])``, trimesh or Open3D meshes.
    materials : list of :class:`Material` that meshes name by number; a mesh may bring its own instead.
    lights : list of :class:`Light`; ``None``: the neutral studio around the scene.
    camera : :class:`Camera`; ``None``: one that shows everything.
    background : (r, g, b[, a]) in sRGB, 0 to 1.
    up : the axis that points up, ``"y"`` or ``"z"``.

    Arrays are copied: changing them later changes no scene. Raises ValueError.
    """

    def __init__(
        self,
        meshes: Any = (),
        materials: Sequence[Material] = (),
        lights: Optional[Iterable[Light]] = None,
        camera: Optional[Camera] = None,
        *,
        background: Optional[Vector] = None,
        up: str = "y",
        _inner: Any = None,
    ):
        if _inner is not None:
            self._inner = _inner
            return
        self._inner = _texmap.Scene(up)
        numbers = [self._add_material(material) for material in materials]
        parts = list(meshes) if isinstance(meshes, (list, set)) or (isinstance(meshes, tuple) and not _is_triple(meshes)) else [meshes]
        for thing in parts:
            for mesh in _mesh_of(thing):
                self._add_mesh(mesh, numbers)
        if lights is None:
            self._inner.light_as_model()
        else:
            for light in lights:
                self._inner.add_light(
                    light.kind,
                    _vector(light.color, "color"),
                    _vector(light.position, "position"),
                    _vector(light.direction, "direction"),
                    [math.radians(light.inner), math.radians(light.outer)],
                )
        if background is not None:
            self._inner.set_background(_color(background))
        if camera is not None:
            self._inner.set_camera(*_camera(camera))

    def _add_material(self, material: Material) -> int:
        texture = None
        if material.texture is not None:
            made = material.texture if isinstance(material.texture, Texture) else Texture(material.texture)
            texture = self._inner.add_texture(made._inner)
        if material.model not in ("metallic-roughness", "phong"):
            raise ValueError(f"model={material.model!r}: know metallic-roughness, phong")
        metallic = [material.metallic, material.roughness] if material.model == "metallic-roughness" else None
        return self._inner.add_material(
            material.name,
            _vector(material.color, "color"),
            metallic,
            [material.ka, material.kd, material.ks, material.ns],
            material.shading,
            texture,
            material.filter,
            material.wrap,
            (material.alpha, material.alpha_threshold),
            material.opacity,
            material.cull,
        )

    def _add_mesh(self, mesh: Mesh, materials: List[int]) -> None:
        name = f"mesh {mesh.name!r}: " if mesh.name else "mesh: "
        vertices = shaped(mesh.vertices, np.float32, name + "vertices", None, 3)
        faces = shaped(mesh.faces, np.uint32, name + "faces", None, 3)

        def optional(values: Any, what: str, width: int) -> Optional[np.ndarray]:
            return None if values is None else shaped(values, np.float32, name + what, len(vertices), width).reshape(-1)

        if isinstance(mesh.material, Material):
            material = self._add_material(mesh.material)
        elif materials:
            if not 0 <= mesh.material < len(materials):
                raise ValueError(f"{name}material {mesh.material}: there are {len(materials)}")
            material = materials[mesh.material]
        else:
            material = self._add_material(Material())
        transform = None if mesh.transform is None else shaped(mesh.transform, np.float64, name + "transform", 4, 4)
        self._inner.add_mesh(
            mesh.name,
            vertices.reshape(-1),
            faces.reshape(-1),
            optional(mesh.uv, "uv", 2),
            optional(mesh.normals, "normals", 3),
            optional(mesh.colors, "colors", 3),
            optional(mesh.lightmap_uv, "lightmap_uv", 2),
            transform,
            material,
            bottom_up(mesh.uv_origin),
        )

    @property
    def meshes(self) -> List[Dict[str, Any]]:
        """Name, number of vertices and triangles of each mesh, and True if it has texture coordinates."""
        keys = ("name", "vertices", "triangles", "has_uv")
        return [dict(zip(keys, row)) for row in self._inner.meshes()]

    @property
    def warnings(self) -> List[str]:
        """Choices that the loader made, one sentence each."""
        return self._inner.warnings()

    def mesh(self, which: Union[int, str] = 0) -> Mesh:
        """The arrays of a mesh, by its number or name; vertices in world space."""
        index = self._index(which)
        positions, faces, uv, bottom = self._inner.mesh_arrays(index)
        return Mesh(
            np.asarray(positions, np.float32).reshape(-1, 3),
            np.asarray(faces, np.uint32).reshape(-1, 3),
            np.asarray(uv, np.float32).reshape(-1, 2) if uv else None,
            uv_origin="bottom-left" if bottom else "top-left",
            name=self.meshes[index]["name"],
        )

    def _index(self, which: Union[int, str]) -> int:
        names = [mesh["name"] for mesh in self.meshes]
        if isinstance(which, str):
            found = [k for k, name in enumerate(names) if name == which]
            if len(found) != 1:
                raise ValueError(f"mesh {which!r}: {'no' if not found else len(found)} of this name; choose from {', '.join(names)}")
            return found[0]
        if not 0 <= which < len(names):
            raise ValueError(f"mesh {which}: there are {len(names)}")
        return int(which)

    def render(self, camera: Any = None, size: Any = (1024, 768), **options: Any) -> Frame:
        """:func:`texmap.render` of this scene."""
        return render(self, camera, size, **options)

    def _repr_png_(self) -> bytes:
        return self.render(size=(480, 360))._repr_png_()

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{_escape(m['name'])}</td><td>{m['vertices']}</td><td>{m['triangles']}</td><td>{'yes' if m['has_uv'] else 'no'}</td></tr>"
            for m in self.meshes[:50]
        )
        textures, materials, lights = self._inner.counts()
        return (
            f"<p>texmap.Scene: {materials} materials, {textures} textures, {lights} lights</p>"
            f"<table><tr><th>mesh</th><th>vertices</th><th>triangles</th><th>uv</th></tr>{rows}</table>"
        )

    def __repr__(self) -> str:
        meshes = self.meshes
        return f"<texmap.Scene {len(meshes)} meshes, {sum(m['triangles'] for m in meshes)} triangles>"


def _escape(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")


def _is_triple(meshes: tuple) -> bool:
    """A tuple (vertices, faces[, uv]) of arrays, not of meshes."""
    return len(meshes) in (2, 3) and all(m is None or isinstance(m, (np.ndarray, list)) or hasattr(m, "detach") for m in meshes)


def _vector(values: Vector, name: str) -> List[float]:
    found = [float(v) for v in values]
    if len(found) != 3:
        raise ValueError(f"{name}: expected 3 numbers, got {len(found)}")
    return found


def _color(color: Any) -> List[float]:
    found = [float(c) for c in color]
    if len(found) == 3:
        found.append(1.0)
    if len(found) != 4 or not all(0.0 <= c <= 1.0 for c in found):
        raise ValueError(f"background={color!r}: expected 3 or 4 numbers from 0 to 1")
    return found


def _camera(camera: Camera) -> tuple:
    return (
        _vector(camera.eye, "eye"),
        _vector(camera.look, "look"),
        _vector(camera.up, "up"),
        math.radians(camera.fov),
        camera.near,
        camera.far,
    )


def load(
    path: Any,
    *,
    missing: Optional[str] = None,
    raw: Optional[bool] = None,
    up: Optional[str] = None,
    view: Optional[str] = None,
    camera: Optional[str] = None,
    time: Optional[float] = None,
    animation: Optional[str] = None,
    root: Any = None,
) -> Scene:
    """Reads a scene (.scene) or a model (.obj, .gltf, .glb, .ply, .stl) as ``texmap render`` does.

    missing : treatment of missing maps: error, checker or grey (default: as the scene says, checker for models).
    raw : True: no colour is converted. up : axis that points up, y or z (default: z for STL). view : side of the automatic camera of a
    model (three-quarter, front, back, left, right, top, bottom, iso). camera, time, animation : of a glTF model. root : read nothing
    outside of this folder.

    Raises FileNotFoundError and OSError for files that cannot be read, ValueError for faults in them, with the two lines of the program.
    Choices that were made for the caller are warnings (:class:`TexmapWarning`).
    """
    scene = Scene(
        _inner=_texmap.load(
            os.fspath(path), missing, raw, up, view, camera, time, animation, None if root is None else os.fspath(root)
        )
    )
    for sentence in scene.warnings:
        warnings.warn(sentence, TexmapWarning, stacklevel=2)
    return scene


def _as_scene(scene: Any) -> Scene:
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, (str, os.PathLike)):
        return load(scene)
    return Scene(scene)


def _with_environment(scene: Scene, env: Any, rotate: float, exposure: float, tone_map: Optional[str], behind: bool) -> Scene:
    copied = Scene(_inner=scene._inner.copied())
    if isinstance(env, str) and env == "none":
        _texmap.set_environment(copied._inner, None, 0, 0.0, exposure, tone_map, False)
        return copied
    picture = env
    if isinstance(env, (str, os.PathLike)) or hasattr(env, "mode"):
        picture, _ = pixels(env, "env")
    picture = np.asarray(picture)
    if picture.dtype.kind in "iu":
        picture = _linear(picture.astype(np.float64) / np.iinfo(picture.dtype).max)
    if picture.ndim != 3 or picture.shape[2] not in (3, 4) or picture.shape[1] != 2 * picture.shape[0]:
        raise ValueError(f"env: expected a picture of all directions (height, 2 * height, 3), got {picture.shape}")
    light = array(picture[..., :3], np.float32, "env")
    _texmap.set_environment(copied._inner, light.reshape(-1), light.shape[1], math.radians(rotate), exposure, tone_map, behind)
    return copied


_FLOAT_AOVS = {"depth": 1, "inv_w": 1, "uv": 2, "lod": 1, "normal": 3, "position": 3, "color": 4}


def render(
    scene: Any,
    camera: Any = None,
    size: Any = (1024, 768),
    *,
    samples: Optional[int] = None,
    supersample: Optional[int] = None,
    env: Any = None,
    env_rotate: float = 0.0,
    exposure: float = 1.0,
    tone_map: Optional[str] = None,
    background: Any = None,
    aovs: Sequence[str] = (),
    filter: Optional[str] = None,
    wrap: Optional[str] = None,
    interp: Optional[str] = None,
    out: Optional[np.ndarray] = None,
    threads: Optional[int] = None,
    level: Optional[str] = None,
) -> Frame:
    """Draws a scene from one camera, or from each pose of a batch.

    Parameters
    ----------
    scene : :class:`Scene`, the path of a file, or a mesh (:class:`Mesh`, trimesh, Open3D, arrays).
    camera : ``None`` (the scene's own), :class:`Camera`, :class:`Poses` (one or many), or the name of a view (front, top, iso, ..).
    size : (width, height) in pixels, 1 to 16384 each.
    samples : samples of coverage per pixel, 1 or 4; default: 4 for models, 1 for .scene files. supersample : n x n samples instead.
    env : light from all around: a lat-long picture (path or array (h, 2h, 3), floats are linear light), or ``"none"``. env_rotate in
        degrees; exposure is a factor; tone_map: pbr-neutral, aces, agx, none.
    background : colour in sRGB, 0 to 1, or ``"env"`` to show ``env`` behind the scene.
    aovs : names of arrays beside the picture: depth (1 near to 0 far), inv_w, uv, lod, face, mesh, normal, position, color (linear light,
        premultiplied), shadow:LIGHT. Holes are NaN, or 2^32 - 1 in face and mesh. (height, width) for one channel, else with a last axis.
    filter, wrap, interp : replace those of the scene, by the words of the program.
    out : array for ``rgba`` that is filled: (height, width, 4) uint8, or (n, height, width, 4) for a batch.
    threads, level : threads (default: all) and SIMD level; no pixel depends on either.

    Returns
    -------
    :class:`Frame`: a dictionary of arrays. The bytes are those of ``texmap render`` with the same choices.

    The interpreter lock is released; Ctrl-C ends the work. Raises ValueError. Sentences about the picture are warnings.
    """
    scene = _as_scene(scene)
    width, height = size_of(size)
    behind = isinstance(background, str)
    if behind and (background != "env" or env is None):
        raise ValueError(f"background={background!r}: expected a colour, or \"env\" together with env=")
    if env is not None:
        scene = _with_environment(scene, env, env_rotate, exposure, tone_map, behind)
    elif tone_map is not None or exposure != 1.0 or env_rotate != 0.0:
        raise ValueError("exposure, tone_map and env_rotate go with env=")
    if background is not None and not behind:
        if env is None:
            scene = Scene(_inner=scene._inner.copied())
        scene._inner.set_background(_color(background))
    arguments: Any = None
    count, batch = 1, False
    if isinstance(camera, Poses):
        arguments, batch = camera._arguments()
        count = len(arguments[0]) // 16
    elif isinstance(camera, Camera):
        arguments = _camera(camera)
    elif isinstance(camera, str):
        arguments = camera
    elif camera is not None:
        raise ValueError(f"camera: expected texmap.Camera, texmap.Poses or the name of a view, got {type(camera).__name__}")
    if samples is not None and supersample is not None:
        raise ValueError("give samples or supersample, not both")
    lead = (count,) if batch else ()
    rgba = output(out, lead + (height, width, 4), np.uint8)
    frame = Frame(rgba=rgba)
    requested = []
    for name in [aovs] if isinstance(aovs, str) else aovs:
        channels = _FLOAT_AOVS.get(name, 1)
        kind = np.uint32 if name in ("face", "mesh") else np.float32
        shape = lead + (height, width) + ((channels,) if channels > 1 else ())
        frame[name] = np.empty(shape, kind)
        requested.append((name, frame[name].reshape(-1)))
    frame.warnings = _texmap.render(
        scene._inner,
        (width, height),
        arguments,
        rgba.reshape(-1),
        requested,
        supersample,
        samples,
        filter,
        wrap,
        interp,
        threads,
        level,
    )
    known = scene.warnings
    for sentence in frame.warnings:
        if sentence not in known:
            warnings.warn(sentence, TexmapWarning, stacklevel=2)
    return frame
