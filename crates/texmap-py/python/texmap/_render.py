"""Pictures of scenes."""

from __future__ import annotations

import math
import os
import warnings
from typing import Any, List, Optional, Sequence, Union

import numpy as np

from . import _texmap
from ._arrays import output, size_of, whole
from ._cameras import Camera, Poses, _camera
from ._meshes import light_of
from ._picture import png_bytes, write_png
from ._scene import Scene, TexmapWarning, _as_scene, _color


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


def _with_environment(scene: Scene, env: Any, rotate: float, exposure: float, tone_map: Optional[str], behind: bool) -> Scene:
    copied = Scene(_inner=scene._inner.copied())
    if isinstance(env, str) and env == "none":
        _texmap.set_environment(copied._inner, None, 0, 0.0, exposure, tone_map, False)
        return copied
    light = light_of(env, "env")
    if light.ndim != 3 or light.shape[1] != 2 * light.shape[0]:
        raise ValueError(f"env: expected a picture of all directions (height, 2 * height, 3), got {light.shape}")
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
    env_shadows: int = 0,
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
    env : light from all around: a lat-long picture (path or array (h, 2h, 3), floats are linear light), or ``"none"``: then the lights of
        the scene alone, and automatic ones where surfaces would be dark, unless ``Scene`` was given ``lights``. env_rotate in degrees;
        env_shadows: directions, up to 256, from which that light casts shadows and darkens corners (64 are smooth);
        exposure is a factor; tone_map: pbr-neutral, aces, agx, none (clipped at 1), unclipped (for the array `color` of floats).
    background : colour in sRGB, 0 to 1, or ``"env"`` to show ``env`` behind the scene.
    aovs : names of arrays beside the picture: depth (1 near to 0 far), inv_w, uv, lod, face, mesh, normal, position, color (linear light,
        premultiplied), shadow:LIGHT. Holes are NaN, or 2^32 - 1 in face and mesh. (height, width) for one channel, else with a last axis.
    filter, wrap, interp : replace those of the scene, by the words of the program.
    out : array for ``rgba`` that is filled: (height, width, 4) uint8, or (n, height, width, 4) for a batch.
    threads, level : threads (default: all) and SIMD level; no pixel depends on either. Small pictures of a batch are drawn one a thread.

    Returns
    -------
    :class:`Frame`: a dictionary of arrays. The bytes are those of ``texmap render`` with the same choices.

    The interpreter lock is released; Ctrl-C ends the work. Raises ValueError. Sentences about the picture are warnings.
    """
    scene = _as_scene(scene)
    width, height = size_of(size)
    behind = isinstance(background, str)
    if behind and (background != "env" or env is None or (isinstance(env, str) and env == "none")):
        raise ValueError(f"background={background!r}: expected a colour, or \"env\" together with a picture as env=")
    if env is not None:
        scene = _with_environment(scene, env, env_rotate, exposure, tone_map, behind)
    elif tone_map is not None or exposure != 1.0 or env_rotate != 0.0:
        raise ValueError("exposure, tone_map and env_rotate go with env=")
    env_shadows = whole(env_shadows, "env_shadows", 0, 256)
    if env is None and (env_shadows or (background is not None and not behind)):
        scene = Scene(_inner=scene._inner.copied())
    if env_shadows:
        scene._inner.set_environment_shadows(env_shadows)
    if background is not None and not behind:
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
    samples = None if samples is None else whole(samples, "samples", 1)
    supersample = None if supersample is None else whole(supersample, "supersample", 1)
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
