"""Pictures for notebooks and files: PNG bytes of arrays."""

from __future__ import annotations

import os
import struct
import tempfile
import zlib
from typing import Any

import numpy as np


def png_bytes(image: np.ndarray) -> bytes:
    """An 8-bit PNG of an array (height, width, 1 to 4 channels) of uint8."""
    image = np.ascontiguousarray(image)
    if image.ndim == 2:
        image = image[..., None]
    height, width, channels = image.shape
    kind = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    rows = np.zeros((height, 1 + width * channels), np.uint8)
    rows[:, 1:] = image.reshape(height, -1)

    def chunk(tag: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))

    header = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    body = zlib.compress(rows.tobytes(), 6)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


def srgb_bytes(linear: np.ndarray) -> np.ndarray:
    """Linear light as sRGB bytes, for looking at."""
    x = np.clip(np.nan_to_num(linear), 0.0, 1.0)
    curve = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1 / 2.4) - 0.055)
    return (curve * 255.0 + 0.5).astype(np.uint8)


def write_png(path: Any, image: np.ndarray) -> None:
    """Writes an array (height, width[, 1 to 4 channels]) of uint8 as PNG, under a temporary name that is renamed: no half-written file
    is left. Raises ValueError for other arrays, OSError where it cannot be written."""
    image = np.asarray(image)
    if image.dtype != np.uint8 or image.ndim not in (2, 3) or 0 in image.shape or (image.ndim == 3 and image.shape[2] > 4):
        raise ValueError(f"image: expected (height, width[, 1 to 4 channels]) of uint8, got {image.shape} of {image.dtype}")
    folder = os.path.dirname(os.path.abspath(os.fspath(path)))
    handle, name = tempfile.mkstemp(suffix=".png", dir=folder)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(png_bytes(image))
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise
