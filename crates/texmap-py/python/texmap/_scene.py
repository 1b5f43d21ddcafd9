"""Scenes: from files and from arrays."""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Optional, Sequence, Union

import numpy as np

from . import _texmap
from ._arrays import bottom_up, shaped, whole
from ._cameras import Camera, _camera, _vector
from ._meshes import Material, Mesh, _mesh_of
from ._texture import Texture

if TYPE_CHECKING:
    from ._render import Frame

Vector = Sequence[float]


class TexmapWarning(UserWarning):
    """A choice that was made for the caller: a missing map, a scene of which nothing is seen."""


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
        if not 0 <= whole(which, "mesh") < len(names):
            raise ValueError(f"mesh {which}: there are {len(names)}")
        return int(which)

    def render(self, camera: Any = None, size: Any = (1024, 768), **options: Any) -> Frame:
        """:func:`texmap.render` of this scene."""
        from ._render import render

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


def _color(color: Any) -> List[float]:
    found = [float(c) for c in color]
    if len(found) == 3:
        found.append(1.0)
    if len(found) != 4 or not all(0.0 <= c <= 1.0 for c in found):
        raise ValueError(f"background={color!r}: expected 3 or 4 numbers from 0 to 1")
    return found


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
