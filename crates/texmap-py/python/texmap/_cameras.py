"""Cameras: placed by hand, or calibrated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, List, Optional, Sequence, Tuple

import numpy as np

from . import _texmap
from ._arrays import array, size_of

Vector = Sequence[float]


@dataclass
class Camera:
    """A camera at ``eye`` that looks at ``look``; ``fov`` is the horizontal field of view in degrees. ``near`` defaults to what cuts
    nothing away; ``far`` may be infinite."""

    eye: Vector
    look: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    fov: float = 40.0
    near: Optional[float] = None
    far: float = math.inf


@dataclass
class Poses:
    """One or many calibrated cameras.

    pose : (4, 4) or (n, 4, 4), rows, translation in the last column: from camera to world, or from world to camera with
        ``world_to_camera=True`` (extrinsics).
    axes : ``"opencv"`` (x right, y down, looking along +z: OpenCV, COLMAP) or ``"opengl"`` (y up, looking along -z: OpenGL, Blender,
        NeRF). It has no default: a wrong guess gives a plausible wrong picture.
    K : (3, 3) or (n, 3, 3) intrinsics in pixels, the principal point from the upper left corner of the picture (half a width is the
        middle). Without it ``fov`` is the horizontal field of view in degrees, or that of the scene's camera, 40
        for an automatic one.
    """

    pose: Any
    axes: str
    K: Any = None
    world_to_camera: bool = False
    fov: Optional[float] = None

    def _arguments(self) -> Tuple[tuple, bool]:
        pose = array(self.pose, np.float64, "pose")
        batch = pose.ndim == 3
        if pose.shape[-2:] != (4, 4) or pose.ndim not in (2, 3):
            raise ValueError(f"pose: expected shape (4, 4) or (n, 4, 4), got {pose.shape}")
        pose = pose.reshape(-1, 4, 4)
        if len(pose) == 0:
            raise ValueError("pose: there is no pose")
        lens = None
        if self.K is not None:
            k = array(self.K, np.float64, "K")
            if k.shape not in ((3, 3), (len(pose), 3, 3)):
                raise ValueError(f"K: expected shape (3, 3) or ({len(pose)}, 3, 3), got {k.shape}")
            k = k.reshape(-1, 3, 3)
            odd = np.abs(k[:, [0, 1, 2, 2], [1, 0, 0, 1]]).max() > 1e-9 * np.abs(k).max() or np.any(k[:, 2, 2] != 1)
            if odd:
                raise ValueError("K: expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]; skew is not supported")
            lens = np.ascontiguousarray(k[:, [0, 1, 0, 1], [0, 1, 2, 2]]).reshape(-1)
        fov = None if self.fov is None else math.radians(self.fov)
        return (pose.reshape(-1), lens, self.axes, self.world_to_camera, fov), batch


def look_at(eye: Vector, target: Vector = (0.0, 0.0, 0.0), up: Vector = (0.0, 1.0, 0.0), axes: str = "opencv") -> np.ndarray:
    """The (4, 4) float64 pose, camera to world, of a camera at ``eye`` that looks at ``target``. Raises ValueError where they are one
    point, or ``up`` is parallel to the line of sight."""
    origin, to, above = (np.asarray(_vector(v, name)) for v, name in ((eye, "eye"), (target, "target"), (up, "up")))
    forward = to - origin
    right = np.cross(forward, above)
    if not np.linalg.norm(right) > 1e-9 * np.linalg.norm(forward) * np.linalg.norm(above):
        raise ValueError(f"look_at: no view from {origin.tolist()} to {to.tolist()} with up {above.tolist()}")
    forward, right = forward / np.linalg.norm(forward), right / np.linalg.norm(right)
    if axes not in ("opencv", "opengl"):
        raise ValueError(f"axes={axes!r}: know opengl, opencv")
    down = np.cross(forward, right)
    columns = (right, down, forward, origin) if axes == "opencv" else (right, -down, -forward, origin)
    pose = np.eye(4)
    pose[:3] = np.stack(columns, axis=1)
    return pose


def project(points: Any, camera: Poses, size: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Coordinates at which a calibrated camera sees points of the world.

    points (..., 3); camera: :class:`Poses` of one pose with ``K`` or ``fov``; size (width, height) of the picture.

    Returns uv (..., 2) float32, texture coordinates in the picture (v = 0 at its bottom row, as :func:`texmap.sample` reads it), and w (...)
    float32, distances along the line of sight, the inverse of the AOV inv_w. Points that are not before the camera have uv -1. Raises
    ValueError for what :func:`texmap.render` refuses, too.
    """
    width, height = size_of(size)
    arguments, _ = camera._arguments()
    flat, lens, axes, world_to_camera, fov = arguments
    if len(flat) != 16:
        raise ValueError(f"camera: expected one pose, got {len(flat) // 16}")
    if lens is None and fov is None:
        raise ValueError("camera: give K or fov")
    _texmap.check_cameras(arguments, (width, height))
    found = array(points, np.float64, "points")
    if found.ndim < 1 or found.shape[-1] != 3:
        raise ValueError(f"points: expected shape (..., 3), got {found.shape}")
    to_world = np.linalg.inv(flat.reshape(4, 4)) if world_to_camera else flat.reshape(4, 4)
    # A pose may scale, which changes no picture: distances are those of the world.
    seen = (found - to_world[:3, 3]) @ (to_world[:3, :3] / np.linalg.norm(to_world[:3, :3], axis=0))
    if axes == "opengl":
        seen = seen * [1.0, -1.0, -1.0]
    if lens is None:
        focal = 0.5 * width / math.tan(0.5 * fov)
        lens = (focal, focal, 0.5 * width, 0.5 * height)
    fx, fy, cx, cy = lens
    w = seen[..., 2]
    before = w > 0
    safe = np.where(before, w, 1.0)
    u = (fx * seen[..., 0] / safe + cx) / width
    v = 1.0 - (fy * seen[..., 1] / safe + cy) / height
    uv = np.where(before[..., None], np.stack([u, v], axis=-1), -1.0)
    return uv.astype(np.float32), w.astype(np.float32)


def _vector(values: Vector, name: str) -> List[float]:
    found = [float(v) for v in values]
    if len(found) != 3:
        raise ValueError(f"{name}: expected 3 numbers, got {len(found)}")
    return found


def _camera(camera: Camera) -> tuple:
    return (
        _vector(camera.eye, "eye"),
        _vector(camera.look, "look"),
        _vector(camera.up, "up"),
        math.radians(camera.fov),
        camera.near,
        camera.far,
    )
