"""Gradients of ``texmap.dr.texture`` with respect to texels and of ``texmap.dr.interpolate`` with respect to attributes.

Both are linear in what they are differentiated by, so the gradients are exact up to rounding. Sums run in f64 in the order of the pixels on
one thread: the same bits each time. Gradients of positions, of texture coordinates and of levels of detail do not exist yet: a tensor that asks
for one raises NotImplementedError.

``texture_backward`` and ``interpolate_backward`` are plain functions of arrays; ``texture`` and ``interpolate`` record themselves for
``torch.autograd`` (torch is needed for these two alone).
"""

from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np

from . import _texmap, dr
from ._arrays import array, whole

__all__ = ["interpolate", "interpolate_backward", "texture", "texture_backward"]


def texture_backward(
    grad: Any,
    tex_shape: Tuple[int, int, int, int],
    uv: Any,
    uv_da: Any = None,
    mip_level_bias: Any = None,
    filter_mode: str = "auto",
    boundary_mode: str = "wrap",
    max_mip_level: Optional[int] = None,
) -> np.ndarray:
    """The gradient with respect to the texels.

    grad (B, h, w, C): that with respect to the result of :func:`texmap.dr.texture`, whose further arguments are the same; tex_shape
    (B or 1, H, W, C). Returns tex_shape float32. Cubes are not supported (NotImplementedError). Raises ValueError.
    """
    if boundary_mode == "cube":
        raise NotImplementedError("gradients of cube textures do not exist yet")
    mode = dr._mode(filter_mode, uv_da, mip_level_bias)
    places, da, bias = dr._places(uv, uv_da, mip_level_bias, False)
    sides = [whole(n, "tex_shape", 1) for n in tex_shape]
    if len(sides) != 4:
        raise ValueError(f"tex_shape={tuple(tex_shape)!r}: expected 4 numbers, (B or 1, H, W, C)")
    count, height, width, channels = sides
    found = array(grad, np.float32, "grad")
    if found.shape != places.shape[:3] + (channels,):
        raise ValueError(f"grad: expected shape {places.shape[:3] + (channels,)}, got {found.shape}")
    if count not in (1, places.shape[0]):
        raise ValueError(f"tex_shape: expected 1 or {places.shape[0]} textures, got {count}")
    last = dr._last_level(height, width, max_mip_level) if "mipmap" in mode else 0
    out = np.empty(tuple(tex_shape), np.float32)
    for k in range(count):
        one = slice(None) if count == 1 else slice(k, k + 1)
        _texmap.texture_gradient(
            places[one].reshape(-1),
            None if da is None else da[one].reshape(-1),
            None if bias is None else bias[one].reshape(-1),
            found[one].reshape(-1),
            (width, height),
            channels,
            mode,
            boundary_mode,
            last,
            out[k].reshape(-1),
        )
    return out


def interpolate_backward(grad: Any, attr_shape: Tuple[int, ...], rast: Any, tri: Any) -> np.ndarray:
    """The gradient with respect to the attributes.

    grad (B, H, W, A): that with respect to the first result of :func:`texmap.dr.interpolate`; attr_shape (V, A), (1, V, A) or (B, V, A).
    Returns attr_shape float32. Raises ValueError.
    """
    pixels = dr._rast(rast)
    found = array(grad, np.float32, "grad")
    vertices, channels = attr_shape[-2:]
    if found.shape != pixels.shape[:3] + (channels,):
        raise ValueError(f"grad: expected shape {pixels.shape[:3] + (channels,)}, got {found.shape}")
    if len(attr_shape) == 3 and attr_shape[0] not in (1, pixels.shape[0]):
        raise ValueError(f"attr_shape: expected 1 or {pixels.shape[0]} sets, got {attr_shape[0]}")
    out = np.empty(tuple(attr_shape), np.float32)
    _texmap.interpolate_gradient(
        (vertices, channels),
        pixels.reshape(-1),
        dr._triangles(tri).reshape(-1),
        found.reshape(-1),
        out.reshape(-1),
        pixels.shape[0],
    )
    return out


def _torch() -> Any:
    try:
        import torch
    except ImportError as error:
        raise ImportError("texmap.grad.texture and interpolate need torch; texture_backward and interpolate_backward do not") from error
    return torch


_functions: Any = None


def _autograd() -> Any:
    """The autograd functions, made when they are first asked for: torch is optional."""
    global _functions
    if _functions is not None:
        return _functions
    torch: Any = _torch()

    class Texture(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, tex: Any, uv: Any, uv_da: Any, bias: Any, options: dict) -> Any:
            ctx.save_for_backward(uv, uv_da, bias)
            ctx.options, ctx.shape = options, tuple(tex.shape)
            return dr.texture(tex.detach(), uv, uv_da, bias, **options)

        @staticmethod
        def backward(ctx: Any, grad: Any) -> Any:
            uv, uv_da, bias = ctx.saved_tensors
            found = texture_backward(grad, ctx.shape, uv, uv_da, bias, **ctx.options)
            return torch.from_numpy(found), None, None, None, None

    class Interpolate(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, attr: Any, rast: Any, tri: Any) -> Any:
            ctx.save_for_backward(rast, tri)
            ctx.shape = tuple(attr.shape)
            return dr.interpolate(attr.detach(), rast, tri)[0]

        @staticmethod
        def backward(ctx: Any, grad: Any) -> Any:
            rast, tri = ctx.saved_tensors
            return torch.from_numpy(interpolate_backward(grad, ctx.shape, rast, tri)), None, None

    _functions = (Texture, Interpolate)
    return _functions


def texture(
    tex: Any,
    uv: Any,
    uv_da: Any = None,
    mip_level_bias: Any = None,
    filter_mode: str = "auto",
    boundary_mode: str = "wrap",
    max_mip_level: Optional[int] = None,
) -> Any:
    """:func:`texmap.dr.texture` of torch tensors, with a gradient for ``tex``."""
    dr._refuse_gradients(uv=uv, uv_da=uv_da, mip_level_bias=mip_level_bias)
    if boundary_mode == "cube":
        raise NotImplementedError("gradients of cube textures do not exist yet")
    options = {"filter_mode": filter_mode, "boundary_mode": boundary_mode, "max_mip_level": max_mip_level}
    return _autograd()[0].apply(tex, uv, uv_da, mip_level_bias, options)


def interpolate(attr: Any, rast: Any, tri: Any) -> Any:
    """The first result of :func:`texmap.dr.interpolate` of torch tensors, with a gradient for ``attr``."""
    dr._refuse_gradients(rast=rast)
    return _autograd()[1].apply(attr, rast, tri)
