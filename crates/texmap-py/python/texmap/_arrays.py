"""Arrays of the caller as the kernels take them: contiguous, of one type, checked by shape."""

from __future__ import annotations

import operator
import os
from typing import Any, Optional, Sequence, Tuple, Union

import numpy as np

from . import _texmap

ImageLike = Any
"""An array (height, width[, channels]), a PIL image, or the path of an image file."""


def untracked(values: Any, name: str) -> np.ndarray:
    """The values as an array of any type: torch CPU tensors without their gradients."""
    if hasattr(values, "detach") and hasattr(values, "device"):
        if getattr(values.device, "type", "cpu") != "cpu":
            raise ValueError(f"{name}: the tensor is on {values.device}; texmap works on the CPU, pass {name}.cpu()")
        values = values.detach().numpy()
    try:
        return np.asarray(values)
    except Exception as error:  # what an object's __array__ raises
        raise ValueError(f"{name}: cannot be read as an array: {error}") from error


def array(values: Any, dtype: Any, name: str) -> np.ndarray:
    """The values as a C-contiguous array of ``dtype``: without a copy where they are one already (torch CPU tensors too)."""
    found = untracked(values, name)
    if found.dtype == object or found.dtype.kind not in "biuf":
        raise ValueError(f"{name}: expected numbers, got an array of {found.dtype}")
    want = np.dtype(dtype)
    if want.kind in "iu" and found.dtype.kind == "f":
        raise ValueError(f"{name}: expected whole numbers, got {found.dtype}")
    if want.kind in "iu" and found.dtype != want and found.size:
        low, high = found.min(), found.max()
        info = np.iinfo(want)
        if low < info.min or high > info.max:
            raise ValueError(f"{name}: holds {low if low < info.min else high}, beyond the range of {want}")
    return np.ascontiguousarray(found, dtype=want)


def shaped(values: Any, dtype: Any, name: str, *shape: Optional[int]) -> np.ndarray:
    """As :func:`array`, of this shape; ``None`` is any length. Raises ValueError with both shapes."""
    found = array(values, dtype, name)
    fits = found.ndim == len(shape) and all(n is None or n == m for n, m in zip(shape, found.shape))
    if not fits:
        want = ", ".join("n" if n is None else str(n) for n in shape)
        raise ValueError(f"{name}: expected shape ({want}), got {found.shape}")
    return found


def output(
    out: Optional[np.ndarray], shape: Sequence[int], dtype: Any, name: str = "out", **inputs: Optional[np.ndarray]
) -> np.ndarray:
    """A new array, or ``out`` if it is one of this shape and type that can be written in place and shares no memory with ``inputs``."""
    if out is None:
        return np.empty(shape, dtype)
    if hasattr(out, "numpy") and not isinstance(out, np.ndarray):
        out = out.detach().numpy()
    if not isinstance(out, np.ndarray):
        raise ValueError(f"{name}: expected an array, got {type(out).__name__}")
    if out.shape != tuple(shape) or out.dtype != np.dtype(dtype):
        raise ValueError(f"{name}: expected shape {tuple(shape)} of {np.dtype(dtype)}, got {out.shape} of {out.dtype}")
    if not (out.flags.c_contiguous and out.flags.writeable):
        raise ValueError(f"{name}: must be C-contiguous and writable")
    for other, given in inputs.items():
        if given is not None and np.may_share_memory(out, given):
            raise ValueError(f"{name}: shares memory with {other}, which is read meanwhile; give another array")
    return out


def is_pil(image: Any) -> bool:
    """True for the images of Pillow, which need not be installed."""
    return any(base.__module__.startswith("PIL.") for base in type(image).__mro__)


def _of_pil(image: Any, name: str) -> np.ndarray:
    """The texels of a PIL image in the depth that its mode has."""
    if image.mode.startswith("I;16"):
        return np.asarray(image).astype(np.uint16)
    if image.mode == "F":
        return np.asarray(image).astype(np.float32)
    if image.mode == "I":
        # Pillow gives 16-bit PNG this mode, which has no scale of its own.
        found = np.asarray(image)
        if found.size and not 0 <= found.min() <= found.max() <= 65535:
            raise ValueError(f"{name}: a PIL image of mode I holds {found.min()} to {found.max()}; expected 16-bit codes, or give an array")
        return found.astype(np.uint16)
    keyed = "transparency" in image.info
    if keyed or image.mode not in ("L", "LA", "RGB", "RGBA"):
        # RGBa and La are premultiplied, which the conversion divides out.
        other = {"La": "LA", "RGBa": "RGBA", "PA": "RGBA"}.get(image.mode, "RGBA" if keyed else "RGB")
        image = image.convert(other)
    return np.asarray(image)


def pixels(image: ImageLike, name: str = "image") -> Tuple[np.ndarray, bool]:
    """The texels of an image as (height, width, channels) of uint8, uint16 or float32, and True if they came from a file or PIL.

    Raises OSError for files that cannot be read, ValueError for arrays of another shape or type.
    """
    if isinstance(image, (str, os.PathLike)):
        width, height, channels, flat = _texmap.read_image(os.fspath(image))
        texels = flat.reshape(height, width, 4)
        # The file's own number of channels; the reader gives four.
        return (np.ascontiguousarray(texels[..., :3]) if channels in (1, 3) else texels), True
    if is_pil(image):
        found = _of_pil(image, name)
        return np.ascontiguousarray(found.reshape(found.shape[0], found.shape[1], -1)), True
    if hasattr(image, "detach"):
        image = image.detach().cpu().numpy()
    found = np.asarray(image)
    if found.ndim == 2:
        found = found[..., None]
    if found.ndim != 3 or 0 in found.shape:
        raise ValueError(f"{name}: expected shape (height, width[, channels]), got {np.asarray(image).shape}")
    if found.dtype == np.float64 or found.dtype == np.float16:
        found = found.astype(np.float32)
    if found.dtype not in (np.uint8, np.uint16, np.float32):
        raise ValueError(f"{name}: expected uint8, uint16 or float32, got {found.dtype}")
    return np.ascontiguousarray(found), False


def whole(number: Any, name: str, least: int = 0, most: int = 1 << 31) -> int:
    """A whole number of a range. Raises ValueError with its name, TypeError for what is no number."""
    try:
        found = operator.index(number)
    except TypeError:
        if not isinstance(number, (float, np.floating)):
            raise TypeError(f"{name}: expected a whole number, got {type(number).__name__}") from None
        raise ValueError(f"{name}={number!r}: expected a whole number") from None
    if not least <= found <= most:
        raise ValueError(f"{name}={found}: expected a number from {least} to {most}")
    return found


def bottom_up(origin: str) -> bool:
    """True for ``bottom-left``. Raises ValueError for other words than it and ``top-left``."""
    if origin not in ("bottom-left", "top-left"):
        raise ValueError(f"origin={origin!r}: know bottom-left, top-left")
    return origin == "bottom-left"


def size_of(size: Union[int, Sequence[int]], name: str = "size") -> Tuple[int, int]:
    """(width, height) from both or from one number for a square."""
    pair = (size, size) if isinstance(size, (int, float, np.number)) else tuple(size)
    if len(pair) != 2 or not all(isinstance(n, (int, np.integer)) and 1 <= n <= 16384 for n in pair):
        raise ValueError(f"{name}={size!r}: expected (width, height), 1 to 16384 each")
    return int(pair[0]), int(pair[1])
