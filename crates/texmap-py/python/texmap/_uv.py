"""Texture coordinates: made, judged, drawn into their own space."""

from __future__ import annotations

from typing import Any, Dict, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _texmap
from ._arrays import bottom_up, shaped, size_of, whole
from ._meshes import Mesh, _mesh_of


class Unwrapped(NamedTuple):
    """Vertices that are split where their coordinates differ.

    ``vertex_map`` (k,) uint32: the vertex of the mesh that each new one is, so ``vertices[vertex_map]`` are the new positions; ``faces``
    (m, 3) uint32: the same triangles over the new vertices; ``uv`` (k, 2) float32.
    """

    vertex_map: np.ndarray
    faces: np.ndarray
    uv: np.ndarray


class UvReport(dict):
    """Figures of a mapping by name; ``triangles`` holds arrays with one value a triangle. 1 is best for stretch, angle and area."""

    triangles: Dict[str, np.ndarray]

    def _repr_html_(self) -> str:
        def words(value: Any) -> str:
            if isinstance(value, (list, tuple)):
                return ", ".join(f"{v:.4g}" for v in value)
            return f"{value:.4g}" if isinstance(value, float) else str(value)

        rows = "".join(f"<tr><th>{name}</th><td>{words(value)}</td></tr>" for name, value in self.items())
        return f"<table>{rows}</table>"


def _surface(mesh: Any, faces: Any) -> Tuple[np.ndarray, np.ndarray]:
    vertices = shaped(mesh, np.float32, "vertices", None, 3)
    return vertices, shaped(faces, np.uint32, "faces", None, 3)


def _split(found: Tuple[np.ndarray, np.ndarray, np.ndarray]) -> Unwrapped:
    vertices, faces, uv = found
    return Unwrapped(vertices, faces.reshape(-1, 3), uv.reshape(-1, 2))


def unwrap(
    vertices: Any,
    faces: Any = None,
    *,
    size: int = 1024,
    gutter: int = 4,
    seams: Any = (),
    seam_angle: Optional[float] = None,
    origin: str = "bottom-left",
    threads: Optional[int] = None,
) -> Unwrapped:
    """Unwraps a mesh into islands in one atlas: without overlaps, inside of 0 to 1, the same bytes on any number of threads.

    vertices (n, 3), faces (m, 3), or one mesh. size : texels a side of the atlas, gutter : empty texels between islands. seams : pairs
    of vertices whose edge is cut. seam_angle : cut edges whose faces differ by more degrees. origin : the row at v = 0 of the new
    coordinates, whatever a mesh had before. Ctrl-C ends the work. Raises ValueError.
    """
    if faces is None:
        mesh = _parts(vertices)
        vertices, faces = mesh.vertices, mesh.faces
    points, triangles = _surface(vertices, faces)
    size, gutter = whole(size, "size", 1), whole(gutter, "gutter")
    edges = np.empty((0, 2), np.uint32) if np.size(seams) == 0 else shaped(seams, np.uint32, "seams", None, 2)
    pairs = edges.tolist()
    angle = None if seam_angle is None else float(np.radians(seam_angle))
    return _split(
        _texmap.unwrap(points.reshape(-1), triangles.reshape(-1), size, gutter, bottom_up(origin), pairs, angle, threads)
    )


def uv_map(
    vertices: Any,
    faces: Any = None,
    *,
    shape: str = "box",
    by: str = "position",
    normals: Any = None,
    eye: Sequence[float] = (0.0, 0.0, 0.0),
    repeat: Sequence[float] = (1.0, 1.0),
    fix_seams: bool = True,
    origin: str = "bottom-left",
    level: Optional[str] = None,
) -> Unwrapped:
    """Maps a mesh by a shape around it: plane, cylinder, cone, sphere or box.

    by : vector that the shape maps: position, normal, centroid, reflection (then ``eye`` counts). repeat : pictures on each part.
    fix_seams : unwrap faces across the seam of a round shape. origin : the row at v = 0 of the new coordinates. Raises ValueError.
    """
    if faces is None:
        mesh = _parts(vertices)
        vertices, faces = mesh.vertices, mesh.faces
    points, triangles = _surface(vertices, faces)
    flat = None if normals is None else shaped(normals, np.float32, "normals", len(points), 3).reshape(-1)
    found, _ = _texmap.uv_map(
        points.reshape(-1),
        triangles.reshape(-1),
        flat,
        shape,
        by,
        [float(c) for c in eye],
        [float(c) for c in repeat],
        fix_seams,
        bottom_up(origin),
        level,
    )
    return _split(found)


def uv_report(
    vertices: Any,
    faces: Any = None,
    uv: Any = None,
    *,
    texture_size: int = 1024,
    views: bool = True,
    origin: Optional[str] = None,
) -> UvReport:
    """Figures that say how good the coordinates of a mesh are: stretch, distortion, overlaps, seams, texel density.

    vertices (n, 3), faces (m, 3), uv (n, 2), or one mesh that has uv. texture_size : texels a side, for the density. views : look for
    the seams from 14 sides. origin : the row at v = 0, bottom-left or top-left; default: that of the mesh (``uv_origin``), bottom-left
    for arrays. Raises ValueError.
    """
    if faces is None:
        mesh = _parts(vertices, need_uv=True)
        vertices, faces, uv = mesh.vertices, mesh.faces, mesh.uv
        origin = mesh.uv_origin if origin is None else origin
    points, triangles = _surface(vertices, faces)
    flat = shaped(uv, np.float32, "uv", len(points), 2)
    texture_size = whole(texture_size, "texture_size", 1)
    figures, each = _texmap.uv_report(
        points.reshape(-1), triangles.reshape(-1), flat.reshape(-1), texture_size, views, bottom_up("bottom-left" if origin is None else origin)
    )
    report = UvReport(figures)
    report.triangles = each
    return report


def tangents(vertices: Any, faces: Any, uv: Any, normals: Any = None) -> np.ndarray:
    """MikkTSpace tangents of the corners: (m, 3, 4) float32, a unit vector along growing u and the sign of the bitangent.

    vertices (n, 3), faces (m, 3), uv (n, 2), normals (n, 3; default: area-weighted means). Raises ValueError.
    """
    points, triangles = _surface(vertices, faces)
    flat = shaped(uv, np.float32, "uv", len(points), 2)
    given = None if normals is None else shaped(normals, np.float32, "normals", len(points), 3).reshape(-1)
    return _texmap.tangents(points.reshape(-1), triangles.reshape(-1), flat.reshape(-1), given).reshape(-1, 3, 4)


def uv_raster(
    uv: Any,
    faces: Any = None,
    size: Union[int, Sequence[int]] = 1024,
    *,
    positions: Any = None,
    normals: Any = None,
    conservative: bool = False,
    gutter: int = 0,
    origin: Optional[str] = None,
    threads: Optional[int] = None,
) -> Dict[str, np.ndarray]:
    """Draws a mesh into its texture space, for bakes and transfers.

    uv (n, 2), faces (m, 3), or one mesh that has uv (its vertices are the positions then). size : texels, one number or (width, height).
    positions, normals (n, 3): interpolated too. conservative : also texels that a face only touches. gutter : texels by which islands are
    dilated. origin : the row at v = 0; default: that of the mesh (``uv_origin``), bottom-left for arrays.

    Returns arrays by name, rows from the top (v = 1 is row 0 with a bottom-left origin): face (h, w) uint32, 2^32 - 1 where there is
    none; barycentric (h, w, 3); coverage (h, w) uint8: 0 free, 1 centre covered, 2 touched, 3 gutter; position and normal (h, w, 3) where
    given; lost: faces that own no texel. The first of overlapping faces wins. Raises ValueError.
    """
    if faces is None:
        mesh = _parts(uv, need_uv=True)
        uv, faces = mesh.uv, mesh.faces
        positions = mesh.vertices if positions is None else positions
        origin = mesh.uv_origin if origin is None else origin
    flat = shaped(uv, np.float32, "uv", None, 2)
    triangles = shaped(faces, np.uint32, "faces", None, 3)

    def optional(values: Any, name: str) -> Optional[np.ndarray]:
        return None if values is None else shaped(values, np.float32, name, len(flat), 3).reshape(-1)

    width, height = size_of(size)
    found = _texmap.uv_raster(
        flat.reshape(-1),
        triangles.reshape(-1),
        optional(positions, "positions"),
        optional(normals, "normals"),
        (width, height),
        conservative,
        whole(gutter, "gutter"),
        bottom_up("bottom-left" if origin is None else origin),
        threads,
    )
    shapes = {"face": (height, width), "coverage": (height, width)}
    return {
        name: values if name == "lost" else values.reshape(shapes.get(name, (height, width, 3))) for name, values in found.items()
    }


def _parts(mesh: Any, need_uv: bool = False) -> Mesh:
    meshes = _mesh_of(mesh)
    if len(meshes) != 1:
        raise ValueError(f"expected one mesh, got {len(meshes)}")
    found: Mesh = meshes[0]
    if need_uv and found.uv is None:
        raise ValueError("the mesh has no texture coordinates: texmap.unwrap makes some")
    return found
