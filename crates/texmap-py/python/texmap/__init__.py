"""Texture mapping on the CPU: arrays in, arrays out.

>>> import texmap
>>> frame = texmap.load("model.obj").render(size=(640, 480))  # doctest: +SKIP
>>> frame.save("model.png")  # doctest: +SKIP

Shapes are (height, width[, channels]), rows top to bottom; texture coordinates have v = 0 at the bottom row unless ``origin`` or
``uv_origin`` says top-left. Every function gives the same bytes for any number of threads and any SIMD level. The interpreter lock is
released while a function works: its inputs must not be written to meanwhile. Inputs that are contiguous and of the type that is named
are read in place, others are copied once.

``texmap.dr`` has the forward interface of nvdiffrast, ``texmap.grad`` gradients with respect to texels and attributes.
"""

from ._batch import batch
from ._cameras import Camera, Poses, look_at, project
from ._image import diff, homography, perspective_interpolate, warp
from ._light import bake, env
from ._meshes import Material, Mesh
from ._picture import write_png
from ._render import Frame, pixel_hash, render
from ._scene import Light, Scene, TexmapWarning, load
from ._texmap import __version__
from ._texture import Texture, sample
from ._uv import Unwrapped, UvReport, tangents, unwrap, uv_map, uv_raster, uv_report

__all__ = [
    "Camera", "Frame", "Light", "Material", "Mesh", "Poses", "Scene", "TexmapWarning", "Texture", "Unwrapped", "UvReport",
    "__version__", "bake", "batch", "diff", "env", "homography", "load", "look_at", "perspective_interpolate", "pixel_hash", "project", "render",
    "sample", "tangents", "unwrap", "uv_map", "uv_raster", "uv_report", "warp", "write_png",
]  # fmt: skip
