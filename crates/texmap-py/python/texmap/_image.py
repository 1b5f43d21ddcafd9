"""Images warped and compared; interpolation in perspective."""

from __future__ import annotations

import math
import os
from typing import Any, Dict, Optional, Sequence, Tuple

import numpy as np

from . import _texmap
from ._arrays import ImageLike, array, is_pil, output, pixels, size_of, untracked
from ._texture import Texture


def homography(source: Any, target: Any) -> np.ndarray:
    """The (3, 3) float64 matrix that maps four points (4, 2) to four others. Raises ValueError where there is none."""
    quads = [array(points, np.float64, name) for points, name in ((source, "source"), (target, "target"))]
    for quad, name in zip(quads, ("source", "target")):
        if quad.shape != (4, 2):
            raise ValueError(f"{name}: expected shape (4, 2), got {quad.shape}")
    return np.asarray(_texmap.homography(quads[0].tolist(), quads[1].tolist())).reshape(3, 3)


def warp(
    image: ImageLike,
    H: Any = None,
    *,
    source: Any = None,
    target: Any = None,
    size: Any = None,
    filter: str = "anisotropic:16",
    outside: str = "transparent",
    border: Sequence[float] = (0.0, 0.0, 0.0, 1.0),
    color: str = "srgb",
    threads: Optional[int] = None,
    level: Optional[str] = None,
) -> np.ndarray:
    """Draws an image through a homography, filtered as texturing is.

    Parameters
    ----------
    image : (height, width[, channels]) uint8, uint16 or float32, at most 4 channels; a PIL image or a path.
    H : (3, 3), from pixels of the image to pixels of the result; the first pixel's centre is (0.5, 0.5).
    source, target : instead of ``H`` four points (4, 2) of the image and of the result, in order around; one that is left out is the
        corners from the upper left clockwise. ``warp(photo, source=corners, size=(400, 300))`` rectifies.
    size : (width, height) of the result; default: that of the image.
    outside : transparent, border (``border`` is linear, premultiplied), edge or repeat. filter : as in :func:`texmap.sample`.
    color : srgb decodes whole numbers before filtering, raw takes them as they are.

    Returns
    -------
    uint8 images give (height, width, 4) uint8, the bytes of ``texmap warp``, without the alpha where the image has none and ``outside``
    makes none. Others give float32, linear light, premultiplied, with the same channels. Raises ValueError, OSError.
    """
    texels, _ = pixels(image)
    height, width, channels = texels.shape
    if channels > 4:
        raise ValueError(f"image: {channels} channels, expected 1 to 4")
    if color not in ("srgb", "raw"):
        raise ValueError(f"color={color!r}: know srgb, raw")
    out_width, out_height = size_of(size) if size is not None else (width, height)
    if H is None:
        if source is None and target is None:
            raise ValueError("give H, or source or target points")
        corners = lambda w, h: [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]]  # noqa: E731
        H = homography(
            corners(width, height) if source is None else source, corners(out_width, out_height) if target is None else target
        )
    elif source is not None or target is not None:
        raise ValueError("give H, or points, not both")
    matrix = array(H, np.float64, "H")
    if matrix.shape != (3, 3):
        raise ValueError(f"H: expected shape (3, 3), got {matrix.shape}")
    mips = filter.split(":")[0] not in ("nearest", "bilinear", "bicubic")
    whole = texels.dtype != np.float32
    space = "srgb" if whole and color == "srgb" else "linear"
    with_alpha = channels in (2, 4)
    texture = Texture(texels, color=space, alpha=("straight" if whole else "premultiplied") if with_alpha else "data", origin="top-left", mips=mips)
    codes = texels.dtype == np.uint8
    result = np.empty((out_height, out_width, 4), np.uint8 if codes else np.float32)
    _texmap.warp(
        texture._inner,
        matrix.reshape(-1).tolist(),
        out_width,
        filter,
        outside,
        [float(c) for c in border],
        None if codes else result.reshape(-1),
        result.reshape(-1) if codes else None,
        color == "raw",
        threads,
        level,
    )
    if outside == "transparent" or (outside == "border" and border[3] != 1.0) or channels == 4:
        return result
    if channels == 2:
        return np.ascontiguousarray(result[..., [0, 3]])
    return np.ascontiguousarray(result[..., :channels])


def _side(thing: Any, name: str) -> Tuple[np.ndarray, Optional[bool]]:
    """Values as they are compared, and True if they are those of an image file or a PIL image, False if those of a file of an array."""
    image = None
    if isinstance(thing, (str, os.PathLike)):
        if os.fspath(thing).lower().endswith(".npy"):
            found, image = np.load(thing, allow_pickle=False), False
        else:
            width, height, _, flat = _texmap.read_image(os.fspath(thing))
            return flat.reshape(height, width, 4), True
    elif is_pil(thing):
        return pixels(thing, name)[0], True
    else:
        found = untracked(thing, name)
    if found.dtype == np.float16:
        found = found.astype(np.float32)
    elif found.dtype == np.uint32:
        found = found.astype(np.float64)
    if found.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        raise ValueError(f"{name}: expected uint8, uint16, uint32 or floats, got {found.dtype}")
    return found, image


def _rgba(found: np.ndarray, name: str) -> np.ndarray:
    """An image of 1 to 4 channels with four of them: opaque where it has no alpha."""
    if found.ndim == 2:
        found = found[..., None]
    if found.ndim != 3 or not 1 <= found.shape[2] <= 4:
        raise ValueError(f"{name}: expected an image (height, width[, 1 to 4 channels]), got {found.shape}")
    if found.dtype == np.float64:
        found = found.astype(np.float32)
    if found.shape[2] == 4:
        return found
    opaque = 1.0 if found.dtype == np.float32 else np.iinfo(found.dtype).max
    colors = found[..., :3] if found.shape[2] == 3 else found[..., [0, 0, 0]]
    alpha = found[..., 1:] if found.shape[2] == 2 else np.full(found.shape[:2] + (1,), opaque, found.dtype)
    return np.concatenate([colors, alpha], axis=2)


def diff(expected: ImageLike, actual: ImageLike, *, limit: float = 0.0) -> Dict[str, Any]:
    """The figures of ``texmap diff``: mean, rms, p999, max, max_at (x, y, channel), over_limit, psnr, ssim, passes, alpha.

    Files and PIL images, the arrays beside them, and two uint8 arrays (height, width, 3 or 4) are images: codes of 8 and 16 bits count 0
    to 1, grey counts as three equal channels, alpha has figures of its own and is opaque where there is none. Other arrays and ``.npy``
    files are compared by their numbers, in f64, and have one shape and, but for floats, one type; those of more than 3 axes are stacked.

    ``passes`` is False where a value differs by more than ``limit``, at least 0. Raises ValueError, OSError.
    """
    if not limit >= 0.0:
        raise ValueError(f"limit={limit!r}: give a number of at least 0")
    (one, first), (two, second) = _side(expected, "expected"), _side(actual, "actual")
    plain = all(a.dtype == np.uint8 and a.ndim == 3 and a.shape[2] in (3, 4) for a in (one, two))
    image = bool(first or second or (plain and first is None and second is None))
    if image:
        one, two = _rgba(one, "expected"), _rgba(two, "actual")
        if (one.dtype.kind == "f") != (two.dtype.kind == "f"):
            raise ValueError(f"the images hold values of unlike kinds: {one.dtype} and {two.dtype}; sRGB codes are no linear light")
    elif one.dtype.kind == two.dtype.kind == "f" and one.dtype != two.dtype:
        one, two = one.astype(np.float64), two.astype(np.float64)
    if one.shape != two.shape or (one.dtype != two.dtype and not image):
        raise ValueError(f"the images differ: {one.shape} of {one.dtype} and {two.shape} of {two.dtype}")
    one, two = np.ascontiguousarray(one), np.ascontiguousarray(two)
    if one.dtype == np.float64:
        *rows, width, channels = {0: (1, 1, 1), 1: (1, *one.shape, 1), 2: (*one.shape, 1)}.get(one.ndim, one.shape)
        size = (width, math.prod(rows), channels)
        return _texmap.diff_f64(one.reshape(-1), two.reshape(-1), size, float(limit))
    return _texmap.diff(one.reshape(-1), two.reshape(-1), list(one.shape), image, float(limit))


def perspective_interpolate(values: Any, w: Any, screen: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Attributes at positions on the screen, interpolated in perspective, and the weights of the corners on the surface.

    values (k, channels) at k = 2 corners of a span or k = 3 of a triangle; w (k,), their distances (clip w), above 0; screen: for a
    triangle (..., 3) barycentrics on the screen, for a span (...) fractions t of the way on the screen.

    Returns (values (..., channels), weights (..., k)), float64. The weights of a span are (1 - s, s) with ``s = t w1 / (w2 + t (w1 - w2))``,
    those of a triangle ``b_i / w_i`` over their sum. Raises ValueError.
    """
    values = array(values, np.float64, "values")
    w = array(w, np.float64, "w")
    if w.ndim != 1 or len(w) not in (2, 3):
        raise ValueError(f"w: expected shape (2,) or (3,), got {w.shape}")
    if values.ndim == 1:
        values = values[:, None]
    if values.ndim != 2 or len(values) != len(w):
        raise ValueError(f"values: expected shape ({len(w)}, channels), got {values.shape}")
    screen = array(screen, np.float64, "screen")
    if len(w) == 2:
        screen = np.stack([1.0 - screen, screen], axis=-1)
    elif screen.ndim < 1 or screen.shape[-1] != 3:
        raise ValueError(f"screen: expected shape (..., 3), got {screen.shape}")
    screen = np.ascontiguousarray(screen)
    out = np.empty(screen.shape[:-1] + (values.shape[1],))
    weights = np.empty(screen.shape)
    _texmap.perspective_interpolate(values.reshape(-1), w, screen.reshape(-1), out.reshape(-1), weights.reshape(-1))
    return out, weights
