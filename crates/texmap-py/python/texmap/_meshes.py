"""Meshes and surfaces: from arrays, trimesh and Open3D."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List, Optional, Sequence, Union

import numpy as np

from ._arrays import ImageLike, array, pixels
from ._texture import Texture

Vector = Sequence[float]


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
    # The factor of a PBR material is linear as in glTF, the colour of a simple one is sRGB.
    color, decoded = getattr(material, "baseColorFactor", None), True
    if color is None and image is None:
        color, decoded = getattr(material, "diffuse", None), False
    made = Material(texture=image if uv is not None else None)
    if image is not None and uv is not None:
        made.color = (1.0, 1.0, 1.0)
    if color is not None:
        rgb = np.asarray(color, np.float64).reshape(-1)[:3]
        rgb = rgb / 255.0 if np.asarray(color).dtype.kind in "iu" else rgb
        made.color = tuple(float(c) for c in (rgb if decoded else _linear(rgb)))
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


def light_of(picture: Any, name: str) -> np.ndarray:
    """A picture of light (.., height, width, 3) as float32: floats are linear light, codes of 8 and 16 bits are sRGB."""
    several = isinstance(picture, np.ndarray) and picture.ndim == 4
    found = picture if several else pixels(picture, name)[0]
    if found.dtype in (np.uint8, np.uint16):
        found = _linear(found.astype(np.float64) / np.iinfo(found.dtype).max)
    if found.dtype.kind != "f":
        raise ValueError(f"{name}: expected floats, uint8 or uint16, got {found.dtype}")
    if found.shape[-1] not in (3, 4):
        raise ValueError(f"{name}: expected 3 channels, got shape {found.shape}")
    return array(found[..., :3], np.float32, name)


def _linear(srgb: np.ndarray) -> np.ndarray:
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
