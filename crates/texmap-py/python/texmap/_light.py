"""Light maps, and environments in other layouts."""

from __future__ import annotations

import math
from typing import Any, Optional, Union

import numpy as np

from . import _texmap
from ._arrays import whole
from ._meshes import light_of
from ._scene import _as_scene


def bake(
    scene: Any,
    mesh: Union[int, str] = 0,
    size: int = 512,
    *,
    gutter: int = 2,
    shadow_size: int = 1024,
    shadow_taps: int = 3,
    threads: Optional[int] = None,
) -> np.ndarray:
    """Bakes the direct light that reaches a mesh, with shadows, onto its light-map coordinates (its uv without a second set).

    mesh : number or name. size : texels a side. gutter : texels by which islands are dilated. shadow_size : texels a side of each shadow
    map, 0 for no shadows; shadow_taps : comparisons a side of its filter, odd, 1 to 15.

    Returns (size, size, 3) float32, linear light of a white matte surface, rows top to bottom, as ``texmap bake --light``. Lights of the
    scene count; light from all around does not. Raises ValueError.
    """
    scene = _as_scene(scene)
    size, gutter, shadow_size = whole(size, "size", 1), whole(gutter, "gutter"), whole(shadow_size, "shadow_size")
    if whole(shadow_taps, "shadow_taps", 1, 15) % 2 == 0:
        raise ValueError(f"shadow_taps={shadow_taps}: expected an odd number from 1 to 15")
    texels, _ = _texmap.bake(scene._inner, scene._index(mesh), size, gutter, shadow_size, shadow_taps, threads)
    return texels.reshape(size, size, 3)


_FACES = {"cube": 6, "tan-cube": 6, "dual-paraboloid": 2}


def env(
    picture: Any,
    to: str = "cube",
    *,
    layout: str = "lat-long",
    size: Optional[int] = None,
    blur: Optional[float] = None,
    threads: Optional[int] = None,
) -> np.ndarray:
    """An environment in another layout, or blurred to a specular map, as ``texmap env``.

    picture : (height, width, 3) or (faces, height, width, 3): linear light where float, sRGB where uint8 or uint16; or a path. Several faces
    may stand below each other. layout, to : cube, tan-cube, lat-long, octahedron, equal-area-octahedron, dual-paraboloid, sphere-map.
    size : height of a face in texels; default: no more texels in all than the picture has. The layout that the picture has at its own
    size is a copy. blur : exponent of the highlight whose light is
    gathered around each direction.

    Returns (height, width, 3) float32, or (faces, height, width, 3) for layouts of several faces. Raises ValueError, OSError.
    """
    light = light_of(picture, "picture")
    width = light.shape[-2]
    texels = light.size // 3
    if size is None:
        faces = _FACES.get(to, 1)
        aspect = 2 if to == "lat-long" else 1
        wanted = texels if blur is None else 6 * int(np.ceil(np.clip(10.0 * np.sqrt(blur), 8.0, 256.0))) ** 2
        size = max(1, math.isqrt(wanted // (faces * aspect)))
    w, h, faces, flat = _texmap.env(light.reshape(-1), width, layout, to, whole(size, "size", 1), blur, threads)
    return flat.reshape(faces, h, w, 3) if faces > 1 else flat.reshape(h, w, 3)
