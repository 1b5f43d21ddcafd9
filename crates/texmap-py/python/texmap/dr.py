"""Forward only: the interface of nvdiffrast's rasterization primitives on the CPU. ``import texmap.dr as dr`` instead of
``import nvdiffrast.torch as dr``; gradients of texels and attributes are in :mod:`texmap.grad`, those of positions do not exist.

Conventions are those of its documentation: clip space as in OpenGL (x, y, z from -w to w, z/w grows away); row 0 of images and textures
is the bottom row; pixel and texel centres at (i + 0.5) / n; ``rast`` holds (u, v, z/w, triangle id + 1), 0 where nothing is; no
back-face culling. Arrays are numpy or torch CPU tensors (read in place where float32 or int32 and contiguous); the results are of the
kind of the first argument that is one. An argument that requires a gradient raises NotImplementedError.

Values are computed in f64 from vertices as given; coverage comes from vertices snapped to 1/256 pixel.
"""

from __future__ import annotations

from typing import Any, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _texmap
from ._arrays import array, output, whole

__all__ = [
    "DepthPeeler", "RasterizeContext", "RasterizeCudaContext", "RasterizeGLContext", "antialias",
    "antialias_construct_topology_hash", "get_log_level", "interpolate", "rasterize", "set_log_level", "texture",
    "texture_construct_mip",
]  # fmt: skip


class RasterizeContext:
    """Holds nothing: there is no device. Accepts and ignores the arguments of the contexts that it stands for."""

    def __init__(self, *_: Any, **__: Any):
        pass

    def set_context(self) -> None:
        """Does nothing."""

    def release_context(self) -> None:
        """Does nothing."""


RasterizeCudaContext = RasterizeContext
RasterizeGLContext = RasterizeContext

_log_level = 1


def get_log_level() -> int:
    """The number that was set; nothing is logged."""
    return _log_level


def set_log_level(level: int) -> None:
    """Keeps a number; nothing is logged."""
    global _log_level
    _log_level = level


def _is_tensor(thing: Any) -> bool:
    return hasattr(thing, "requires_grad") and hasattr(thing, "detach")


def _refuse_gradients(**arguments: Any) -> None:
    """Raises NotImplementedError for a tensor that asks for a gradient while gradients are recorded."""
    for name, thing in arguments.items():
        if _is_tensor(thing) and thing.requires_grad:
            import torch

            if torch.is_grad_enabled():
                raise NotImplementedError(
                    f"{name} requires a gradient: texmap.dr is forward only. Call it under torch.no_grad() or with {name}.detach(); "
                    "texmap.grad has texture and interpolate with gradients of texels and attributes; positions have none"
                )


def _like(given: Sequence[Any], *found: np.ndarray) -> Any:
    """The arrays as torch tensors (sharing memory) if an argument is one."""
    if any(_is_tensor(thing) for thing in given):
        import torch

        return tuple(torch.from_numpy(a) for a in found)
    return found


def _triangles(tri: Any) -> np.ndarray:
    found = array(tri, np.int32, "tri")
    if found.ndim != 2 or found.shape[1] != 3:
        raise ValueError(f"tri: expected shape (triangles, 3) of int32, got {found.shape}")
    if found.size and found.min() < 0:
        raise ValueError(f"tri: holds {found.min()}, vertices count from 0")
    return found.view(np.uint32)


def _positions(pos: Any, tri: np.ndarray, ranges: Any) -> Tuple[np.ndarray, List[Tuple[int, int, int, int]]]:
    """Flat positions and, for each picture, first vertex, vertices, first triangle, triangles."""
    found = array(pos, np.float32, "pos")
    if found.ndim == 3 and found.shape[2] == 4:
        if ranges is not None:
            raise ValueError("ranges goes with pos of shape (vertices, 4)")
        batch, vertices, _ = found.shape
        return found, [(k * vertices, vertices, 0, len(tri)) for k in range(batch)]
    if found.ndim == 2 and found.shape[1] == 4:
        if ranges is None:
            raise ValueError("pos of shape (vertices, 4) needs ranges, int32 (pictures, 2): first triangle and number of triangles")
        pairs = array(ranges, np.int32, "ranges")
        if pairs.ndim != 2 or pairs.shape[1] != 2:
            raise ValueError(f"ranges: expected shape (pictures, 2), got {pairs.shape}")
        for k, (first, count) in enumerate(pairs.tolist()):
            if first < 0 or count < 0 or first + count > len(tri):
                raise ValueError(f"ranges[{k}]: triangles {first} to {first + count}, tri holds {len(tri)}")
        return found, [(0, len(found), first, count) for first, count in pairs.tolist()]
    raise ValueError(f"pos: expected shape (pictures, vertices, 4), or (vertices, 4) with ranges, got {found.shape}")


def _resolution(resolution: Any) -> Tuple[int, int]:
    pair = tuple(whole(n, "resolution", 1, 16384) for n in resolution)
    if len(pair) != 2:
        raise ValueError(f"resolution={resolution!r}: expected (height, width), 1 to 16384 each")
    return pair


def rasterize(
    glctx: Any,
    pos: Any,
    tri: Any,
    resolution: Sequence[int],
    ranges: Any = None,
    grad_db: bool = True,
    *,
    out: Optional[Tuple[np.ndarray, np.ndarray]] = None,
    threads: Optional[int] = None,
    level: Optional[str] = None,
) -> Tuple[Any, Any]:
    """Rasterizes triangles in clip space.

    Parameters
    ----------
    glctx : ignored; ``None`` will do.
    pos : (B, V, 4) float32, or (V, 4) with ``ranges``. tri : (T, 3) int32.
    resolution : (height, width). ranges : (B, 2) int32, first triangle and number of triangles of each picture.
    grad_db : compute the derivatives of the barycentrics.
    out : (rast, rast_db) numpy arrays that are filled and returned.

    Returns
    -------
    rast : (B, H, W, 4) float32: u, v (barycentric weights of vertices 0 and 1, correct in perspective), z/w, triangle id + 1. Ids up to
        2^24 are whole numbers; larger ones have the bits 0x4a800000 + id + 1.
    rast_db : (B, H, W, 4) float32: du/dX, du/dY, dv/dX, dv/dY per pixel; (B, H, W, 0) without ``grad_db``.

    Triangles with a vertex that is not finite are not drawn. Of two at one depth the first wins. Raises ValueError.
    """
    _refuse_gradients(pos=pos)
    return _rasterize(pos, tri, resolution, ranges, grad_db, out, None, True, threads, level)


def _rasterize(
    pos: Any,
    tri: Any,
    resolution: Any,
    ranges: Any,
    grad_db: bool,
    out: Any,
    layer: Optional[Tuple[np.ndarray, np.ndarray]],
    first_layer: bool,
    threads: Optional[int],
    level: Optional[str],
) -> Tuple[Any, Any]:
    triangles = _triangles(tri)
    positions, pictures = _positions(pos, triangles, ranges)
    height, width = _resolution(resolution)
    shape = (len(pictures), height, width, 4)
    rast_out, db_out = out if out is not None else (None, None)
    rast = output(rast_out, shape, np.float32, "out[0]", pos=positions, tri=triangles)
    others = {"pos": positions, "tri": triangles, "out[0]": rast}
    db = output(db_out, shape, np.float32, "out[1]", **others) if grad_db else np.empty(shape[:3] + (0,), np.float32)
    flat_layer = None if layer is None else (layer[0].reshape(-1), layer[1].reshape(-1))
    _texmap.rasterize(
        positions.reshape(-1),
        triangles.reshape(-1),
        pictures,
        (width, height),
        rast.reshape(-1),
        db.reshape(-1) if grad_db else None,
        flat_layer,
        first_layer,
        threads,
        level,
    )
    return _like((pos, tri), rast, db)


class DepthPeeler:
    """Layers of surfaces from front to back, as a context manager.

    >>> with dr.DepthPeeler(ctx, pos, tri, (512, 512)) as peeler:  # doctest: +SKIP
    ...     for layer in range(4):
    ...         rast, rast_db = peeler.rasterize_next_layer()

    The arguments are those of :func:`rasterize`. Layers behind the last surface are empty. Surfaces at one depth each have a layer of
    their own, in the order of the triangles.
    """

    def __init__(
        self,
        glctx: Any,
        pos: Any,
        tri: Any,
        resolution: Sequence[int],
        ranges: Any = None,
        grad_db: bool = True,
        *,
        threads: Optional[int] = None,
        level: Optional[str] = None,
    ):
        _refuse_gradients(pos=pos)
        self._arguments = (pos, tri, resolution, ranges, grad_db)
        self._options = (threads, level)
        self._layer: Optional[Tuple[np.ndarray, np.ndarray]] = None
        self._active = False

    def __enter__(self) -> "DepthPeeler":
        self._active = True
        self._layer = None
        return self

    def __exit__(self, *_: Any) -> None:
        self._active = False
        self._layer = None

    def rasterize_next_layer(self) -> Tuple[Any, Any]:
        """(rast, rast_db) of the next layer. Raises RuntimeError outside of the ``with`` block."""
        if not self._active:
            raise RuntimeError("rasterize_next_layer works inside of `with DepthPeeler(..) as peeler:`")
        pos, tri, resolution, ranges, grad_db = self._arguments
        first = self._layer is None
        if self._layer is None:
            height, width = _resolution(resolution)
            _, pictures = _positions(pos, _triangles(tri), ranges)
            shape = (len(pictures), height, width)
            self._layer = (np.zeros(shape, np.float32), np.full(shape, 0xFFFFFFFF, np.uint32))
        return _rasterize(pos, tri, resolution, ranges, grad_db, None, self._layer, first, *self._options)


def _rast(rast: Any, name: str = "rast") -> np.ndarray:
    found = array(rast, np.float32, name)
    if found.ndim != 4 or found.shape[3] != 4:
        raise ValueError(f"{name}: expected shape (B, H, W, 4), got {found.shape}")
    return found


def _attributes(attr: Any, batch: int) -> np.ndarray:
    found = array(attr, np.float32, "attr")
    if found.ndim == 2:
        found = found[None]
    if found.ndim != 3 or found.shape[0] not in (1, batch):
        raise ValueError(f"attr: expected shape (V, A), (1, V, A) or ({batch}, V, A), got {found.shape}")
    return found


def interpolate(
    attr: Any,
    rast: Any,
    tri: Any,
    rast_db: Any = None,
    diff_attrs: Union[None, str, Sequence[int]] = None,
    *,
    out: Optional[np.ndarray] = None,
    threads: Optional[int] = None,
) -> Tuple[Any, Any]:
    """Interpolates vertex attributes.

    attr : (B, V, A), (1, V, A) for all pictures, or (V, A) (range mode). rast, tri : as from and for :func:`rasterize`.
    rast_db, diff_attrs : ``"all"`` or a list of attributes whose derivatives are computed from ``rast_db``.

    Returns (out (B, H, W, A), out_da (B, H, W, 2 * len(diff_attrs))) float32: pairs dA/dX, dA/dY in the order of ``diff_attrs``. Pixels
    without a triangle are 0. Raises ValueError.
    """
    _refuse_gradients(attr=attr, rast=rast, rast_db=rast_db)
    pixels = _rast(rast)
    batch, height, width, _ = pixels.shape
    values = _attributes(attr, batch)
    channels = values.shape[2]
    if diff_attrs is None:
        chosen: List[int] = []
    elif isinstance(diff_attrs, str):
        if diff_attrs != "all":
            raise ValueError(f"diff_attrs={diff_attrs!r}: expected None, 'all' or a list of numbers")
        chosen = list(range(channels))
    else:
        chosen = [whole(c, "diff_attrs") for c in diff_attrs]
        if any(c >= channels for c in chosen):
            raise ValueError(f"diff_attrs={chosen}: there are {channels} attributes")
    db = None
    if chosen:
        if rast_db is None:
            raise ValueError("diff_attrs needs rast_db")
        db = _rast(rast_db, "rast_db")
        if db.shape != pixels.shape:
            raise ValueError(f"rast_db: expected shape {pixels.shape}, got {db.shape}")
    triangles = _triangles(tri)
    found = output(out, (batch, height, width, channels), np.float32, attr=values, rast=pixels, tri=triangles, rast_db=db)
    da = np.empty((batch, height, width, 2 * len(chosen)), np.float32)
    _texmap.interpolate(
        values.reshape(-1),
        (values.shape[1], channels),
        pixels.reshape(-1),
        triangles.reshape(-1),
        None if db is None else db.reshape(-1),
        chosen,
        found.reshape(-1),
        da.reshape(-1),
        batch,
        threads,
    )
    return _like((attr, rast, tri), found, da)


class Mipmap:
    """The mip stack of :func:`texture_construct_mip`: pass it as ``mip``."""

    def __init__(self, textures: List[Any], shape: Tuple[int, ...], max_mip_level: Optional[int], cube: bool):
        self._textures = textures
        self._shape = shape
        self._max_mip_level = max_mip_level
        self._cube = cube


def _last_level(height: int, width: int, max_mip_level: Optional[int]) -> int:
    """The coarsest level that may be read. Raises ValueError where halving meets an odd side before it."""
    level = 0
    while (height > 1 or width > 1) and (max_mip_level is None or level < max_mip_level):
        if (height > 1 and height % 2) or (width > 1 and width % 2):
            raise ValueError(
                f"texture: level {level} has {height} x {width} texels, an odd side above 1: halving needs even sides down to 1 x 1; "
                f"give max_mip_level={level}, or other sizes"
            )
        height, width, level = max(height // 2, 1), max(width // 2, 1), level + 1
    return level


def _texels(tex: Any, cube: bool) -> np.ndarray:
    found = array(tex, np.float32, "tex")
    if cube and (found.ndim != 5 or found.shape[1] != 6 or found.shape[2] != found.shape[3]):
        raise ValueError(f"tex: expected shape (B, 6, N, N, C) of a cube, got {found.shape}")
    if not cube and found.ndim != 4:
        raise ValueError(f"tex: expected shape (B, H, W, C), got {found.shape}")
    if 0 in found.shape:
        raise ValueError(f"tex: shape {found.shape} holds nothing")
    return found


def _make_textures(found: np.ndarray, cube: bool, mips: bool) -> List[Any]:
    if cube:
        return [_texmap.Cube(t.reshape(-1), t.shape[1], t.shape[3], mips) for t in found]
    return [
        _texmap.Texture(t.reshape(-1), (t.shape[1], t.shape[0]), t.shape[2], ("linear", "data", False), mips) for t in found
    ]


def texture_construct_mip(tex: Any, max_mip_level: Optional[int] = None, cube_mode: bool = False) -> Mipmap:
    """The mip stack of a texture, for several calls of :func:`texture`. Raises ValueError for odd sides above 1 within
    ``max_mip_level``."""
    _refuse_gradients(tex=tex)
    found = _texels(tex, cube_mode)
    _last_level(found.shape[-3], found.shape[-2], max_mip_level)
    return Mipmap(_make_textures(found, cube_mode, True), found.shape, max_mip_level, cube_mode)


_FILTERS = ("auto", "nearest", "linear", "linear-mipmap-nearest", "linear-mipmap-linear")


def _mode(filter_mode: str, uv_da: Any, bias: Any) -> str:
    if filter_mode not in _FILTERS:
        raise ValueError(f"filter_mode={filter_mode!r}: know {', '.join(_FILTERS)}")
    if filter_mode == "auto":
        return "linear-mipmap-linear" if uv_da is not None or bias is not None else "linear"
    if "mipmap" in filter_mode and uv_da is None and bias is None:
        raise ValueError(f"filter_mode={filter_mode!r} needs uv_da or mip_level_bias")
    return filter_mode


def texture(
    tex: Any,
    uv: Any,
    uv_da: Any = None,
    mip_level_bias: Any = None,
    mip: Any = None,
    filter_mode: str = "auto",
    boundary_mode: str = "wrap",
    max_mip_level: Optional[int] = None,
    *,
    out: Optional[np.ndarray] = None,
    threads: Optional[int] = None,
    level: Optional[str] = None,
) -> Any:
    """Looks textures up.

    tex : (B or 1, H, W, C) float32, row 0 at v = 0; (B or 1, 6, N, N, C) with boundary mode cube (faces +X -X +Y -Y +Z -Z).
    uv : (B, h, w, 2), or directions (B, h, w, 3). uv_da : (B, h, w, 4): du/dX, du/dY, dv/dX, dv/dY; 6 values for cubes.
    mip_level_bias : (B, h, w), added to the level of detail; without ``uv_da`` it is the level.
    mip : from :func:`texture_construct_mip`. filter_mode : auto, nearest, linear, linear-mipmap-nearest, linear-mipmap-linear; auto is the
    last with ``uv_da`` or ``mip_level_bias``, else linear. boundary_mode : wrap, clamp, zero, cube.
    max_mip_level : coarsest level that is made and read.

    The level of detail is log2 of the longer half axis of the pixel's ellipse in texels (isotropic). Returns (B, h, w, C) float32. Zero
    and non-finite directions give 0. Raises ValueError, for odd sides above 1 on the way to ``max_mip_level`` too.
    """
    _refuse_gradients(tex=tex, uv=uv, uv_da=uv_da, mip_level_bias=mip_level_bias)
    if boundary_mode not in ("wrap", "clamp", "zero", "cube"):
        raise ValueError(f"boundary_mode={boundary_mode!r}: know wrap, clamp, zero, cube")
    cube = boundary_mode == "cube"
    mode = _mode(filter_mode, uv_da, mip_level_bias)
    texels = _texels(tex, cube)
    places, da, bias = _places(uv, uv_da, mip_level_bias, cube)
    batch = places.shape[0]
    if texels.shape[0] not in (1, batch):
        raise ValueError(f"tex: expected 1 or {batch} textures, got {texels.shape[0]}")
    mips = "mipmap" in mode
    last = 0
    if mips:
        if mip is not None:
            if not isinstance(mip, Mipmap):
                raise ValueError("mip: expected what texmap.dr.texture_construct_mip gives; lists of levels are not supported")
            if mip._shape != texels.shape or mip._cube != cube:
                raise ValueError(f"mip: made of a texture of shape {mip._shape}, tex has {texels.shape}")
            if max_mip_level is None:
                max_mip_level = mip._max_mip_level
        last = _last_level(texels.shape[-3], texels.shape[-2], max_mip_level)
    made = mip._textures if mips and mip is not None else _make_textures(texels, cube, mips)
    channels = texels.shape[-1]
    found = output(out, places.shape[:3] + (channels,), np.float32, uv=places, uv_da=da, mip_level_bias=bias)
    for k in range(batch):
        one = made[k if len(made) > 1 else 0]
        own = (None if da is None else da[k].reshape(-1), None if bias is None else bias[k].reshape(-1))
        if cube:
            _texmap.sample_cube(one, places[k].reshape(-1), *own, found[k].reshape(-1), mode, float(last), threads)
        else:
            _texmap.sample_levels(
                one, places[k].reshape(-1), *own, found[k].reshape(-1), mode, boundary_mode, float(last), threads, level
            )
    return _like((tex, uv), found)[0]


def _places(uv: Any, uv_da: Any, bias: Any, cube: bool) -> Tuple[np.ndarray, Optional[np.ndarray], Optional[np.ndarray]]:
    width = 3 if cube else 2
    places = array(uv, np.float32, "uv")
    if places.ndim != 4 or places.shape[3] != width:
        raise ValueError(f"uv: expected shape (B, h, w, {width}), got {places.shape}")
    da = None
    if uv_da is not None:
        da = array(uv_da, np.float32, "uv_da")
        if da.shape != places.shape[:3] + (2 * width,):
            raise ValueError(f"uv_da: expected shape {places.shape[:3] + (2 * width,)}, got {da.shape}")
    shift = None
    if bias is not None:
        shift = array(bias, np.float32, "mip_level_bias")
        if shift.shape != places.shape[:3]:
            raise ValueError(f"mip_level_bias: expected shape {places.shape[:3]}, got {shift.shape}")
    return places, da, shift


class TopologyHash:
    """The vertices beyond the edges of triangles, see :func:`antialias_construct_topology_hash`."""

    def __init__(self, beyond: np.ndarray):
        self._beyond = beyond


def antialias_construct_topology_hash(tri: Any) -> TopologyHash:
    """The edges that triangles share, for several calls of :func:`antialias` with one ``tri``."""
    return TopologyHash(_texmap.topology(_triangles(tri).reshape(-1)))


def antialias(
    color: Any,
    rast: Any,
    pos: Any,
    tri: Any,
    topology_hash: Optional[TopologyHash] = None,
    pos_gradient_boost: float = 1.0,
    *,
    out: Optional[np.ndarray] = None,
) -> Any:
    """Blends pixels across silhouette edges (Laine and others 2020, section 3.5).

    color (B, H, W, C), rast as from :func:`rasterize`, pos and tri as it was given. Where a silhouette edge of the nearer of two
    neighbours crosses the line between their centres, a pixel takes a part of the other's colour: none where it crosses in the middle, half
    at a centre. ``topology_hash`` saves time and changes no value, nor does ``pos_gradient_boost``. Returns (B, H, W, C) float32. Raises ValueError.
    """
    _refuse_gradients(color=color, pos=pos)
    pixels = _rast(rast)
    colors = array(color, np.float32, "color")
    if colors.ndim != 4 or colors.shape[:3] != pixels.shape[:3]:
        raise ValueError(f"color: expected shape {pixels.shape[:3] + ('C',)}, got {colors.shape}")
    triangles = _triangles(tri)
    positions = array(pos, np.float32, "pos")
    batch, height, width, channels = colors.shape
    if positions.ndim == 2 and positions.shape[1] == 4:
        pictures = [(0, len(positions), 0, len(triangles))] * batch
    elif positions.ndim == 3 and positions.shape[2] == 4 and positions.shape[0] == batch:
        count = positions.shape[1]
        pictures = [(k * count, count, 0, len(triangles)) for k in range(batch)]
    else:
        raise ValueError(f"pos: expected shape ({batch}, V, 4) or (V, 4), got {positions.shape}")
    found = output(out, colors.shape, np.float32, color=colors, rast=pixels, pos=positions, tri=triangles)
    _texmap.antialias(
        colors.reshape(-1),
        pixels.reshape(-1),
        positions.reshape(-1),
        triangles.reshape(-1),
        (topology_hash or antialias_construct_topology_hash(tri))._beyond,
        pictures,
        (width, height),
        channels,
        found.reshape(-1),
    )
    return _like((color, rast, pos), found)[0]
