"""Textures and look-ups."""

from __future__ import annotations

from typing import Any, Optional, Sequence, Tuple, Union

import numpy as np

from . import _texmap
from ._arrays import ImageLike, array, bottom_up, output, pixels
from ._picture import png_bytes, srgb_bytes


class Texture:
    """An image that is looked up, with its mip chain.

    Parameters
    ----------
    image : array (height, width[, channels]) of uint8, uint16 or float32, rows top to bottom; a PIL image; or a path.
        Whole numbers stand for 0 to 1. Floats must be finite.
    color : ``"srgb"`` (decoded before filtering; at most 4 channels) or ``"linear"``. Default: sRGB for images of whole numbers, linear for
        floats and for more than 4 channels.
    alpha : meaning of the last of 2 or 4 channels: ``"straight"``, ``"premultiplied"`` or ``"data"`` (just another number). Default:
        straight for files, PIL images and four channels of whole numbers, else data. More than 4 channels are always data.
    origin : the row at v = 0: ``"bottom-left"`` (OBJ, Blender, trimesh) or ``"top-left"`` (glTF).
    mips : build the mip chain, which every filter but nearest, bilinear and bicubic reads.

    Raises ValueError for a shape, type or texel that no texture may have, OSError for a file that cannot be read.
    """

    def __init__(
        self,
        image: ImageLike,
        *,
        color: Optional[str] = None,
        alpha: Optional[str] = None,
        origin: str = "bottom-left",
        mips: bool = True,
    ):
        texels, from_file = pixels(image)
        height, width, channels = texels.shape
        whole = texels.dtype != np.float32
        if alpha not in (None, "straight", "premultiplied", "data"):
            raise ValueError(f"alpha={alpha!r}: know straight, premultiplied, data")
        if color is None:
            color = "srgb" if whole and channels <= 4 else "linear"
        if channels > 4:
            if color == "srgb":
                raise ValueError(f"color='srgb': an image of {channels} channels is data; leave color out, or give at most 4 channels")
            alpha = "data"
        if alpha is None:
            if from_file and not whole:
                alpha = "premultiplied"
            else:
                alpha = "straight" if from_file or (whole and channels == 4) else "data"
        self._inner = _texmap.Texture(
            texels.reshape(-1), (width, height), channels, (color, alpha, bottom_up(origin)), mips
        )
        self.origin = origin

    @property
    def shape(self) -> Tuple[int, int, int]:
        """(height, width, channels) of level 0."""
        width, height, channels, _ = self._inner.shape()
        return height, width, channels

    @property
    def levels(self) -> int:
        """Number of levels of the mip chain."""
        return self._inner.shape()[3]

    def level(self, index: int) -> np.ndarray:
        """The texels of a level: (height, width, channels) float32, linear light, premultiplied, row 0 at v = 0."""
        sizes = self._inner.level_sizes()
        if not 0 <= index < len(sizes):
            raise ValueError(f"level {index}: there are {len(sizes)}")
        width, height = sizes[index]
        out = np.empty((height, width, self.shape[2]), np.float32)
        self._inner.level(index, out.reshape(-1))
        return out

    def sample(self, uv: Any, duv: Any = None, **options: Any) -> np.ndarray:
        """:func:`texmap.sample` of this texture."""
        return sample(self, uv, duv, **options)

    def _repr_png_(self) -> bytes:
        texels = self.level(0)
        if self.origin == "bottom-left":
            texels = texels[::-1]
        channels = texels.shape[2]
        return png_bytes(srgb_bytes(texels[..., : 3 if channels >= 3 else 1]))

    def __repr__(self) -> str:
        height, width, channels = self.shape
        return f"<texmap.Texture {width} x {height}, {channels} channels, {self.levels} levels>"


def as_texture(texture: Any) -> Texture:
    """A texture as it is; an array as data (linear); a PIL image or a path as colours."""
    if isinstance(texture, Texture):
        return texture
    plain = not isinstance(texture, (str,)) and not hasattr(texture, "__fspath__") and not hasattr(texture, "mode")
    return Texture(texture, color="linear", alpha="data") if plain else Texture(texture)


def sample(
    texture: Union[Texture, ImageLike],
    uv: Any,
    duv: Any = None,
    *,
    filter: Optional[str] = None,
    wrap: Union[str, Tuple[str, str]] = "repeat",
    border: Sequence[float] = (0.0, 0.0, 0.0, 0.0),
    lod_bias: float = 0.0,
    lod_min: float = 0.0,
    lod_max: float = 1000.0,
    out: Optional[np.ndarray] = None,
    threads: Optional[int] = None,
    level: Optional[str] = None,
) -> np.ndarray:
    """Looks a texture up at many coordinates.

    Parameters
    ----------
    texture : a :class:`Texture`, or an image to make one of for this call. Arrays are taken as data (linear, any number of channels),
        files and PIL images as colours.
    uv : (..., 2) float32; 0 to 1 is the image, texel centres at (i + 0.5) / n. NaN reads as 0.
    duv : (..., 2, 2) or (..., 4) float32: du/dx, du/dy, dv/dx, dv/dy, the change of uv per pixel. Without it filters that choose a
        level take level 0.
    filter : nearest, bilinear, bicubic:catmull-rom|mitchell|b-spline, mip-nearest, bilinear-mip-nearest, trilinear, anisotropic:2..16,
        ewa:1..16[:0.25..2], summed-area. Default: trilinear with ``duv``, else bilinear.
    wrap : repeat, mirrored-repeat, clamp-to-edge, clamp-to-border, mirror-clamp-to-edge, or a pair of them for u and v.
    border : colour of clamp-to-border, linear, premultiplied.
    lod_bias, lod_min, lod_max : shift and limits of the level of detail.
    out : array (..., channels) float32 that is filled and returned.
    threads, level : threads (default: all) and SIMD level (auto, avx512, avx2, sse4.2, sse2). No value depends on either.

    Returns
    -------
    (..., channels) float32: linear light, premultiplied by alpha (data as it is).

    Inputs must not be written to while the call runs: the interpreter lock is released. Raises ValueError.
    """
    texture = as_texture(texture)
    uv = array(uv, np.float32, "uv")
    if uv.ndim < 1 or uv.shape[-1] != 2:
        raise ValueError(f"uv: expected shape (..., 2), got {uv.shape}")
    lead = uv.shape[:-1]
    if duv is not None:
        duv = array(duv, np.float32, "duv")
        if duv.shape not in (lead + (2, 2), lead + (4,)):
            raise ValueError(f"duv: expected shape {lead + (2, 2)} or {lead + (4,)}, got {duv.shape}")
        duv = duv.reshape(-1)
    channels = texture.shape[2]
    out = output(out, lead + (channels,), np.float32, uv=uv, duv=duv)
    wraps = (wrap, wrap) if isinstance(wrap, str) else tuple(wrap)
    _texmap.sample(
        texture._inner,
        uv.reshape(-1),
        duv,
        out.reshape(-1),
        filter or ("bilinear" if duv is None else "trilinear"),
        wraps,
        list(border),
        [lod_bias, lod_min, lod_max],
        threads,
        level,
    )
    return out
