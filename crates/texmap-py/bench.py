"""Times of the package, the least of several runs: ``python bench.py`` prints what docs/python.md quotes.

The machine should be idle. Nothing here is a test.
"""

import os
import sys
import time

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "tests"))

from conftest import ROOT, clip_from_world, icosphere, to_clip  # noqa: E402

import texmap  # noqa: E402
import texmap.dr as dr  # noqa: E402


def least(work, runs=15, clock=time.process_time):
    """Milliseconds of the fastest run: of the processor's time, which other programs disturb least."""
    best = float("inf")
    for _ in range(runs):
        begin = clock()
        work()
        best = min(best, clock() - begin)
    return best * 1e3


def grid(side=101):
    """A textured sheet of 2 * (side - 1)^2 triangles that fills the picture."""
    x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side))
    z = 0.3 * np.sin(3 * x) * np.cos(3 * y)
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    k = np.arange(side * side).reshape(side, side)
    a, b, c, d = k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return points, faces.astype(np.int32)


def main():
    rng = np.random.default_rng(1)
    for channels in (3, 4):
        texture = texmap.Texture(rng.uniform(size=(1024, 1024, channels)).astype(np.float32))
        uv = rng.uniform(size=(1_000_000, 2)).astype(np.float32)
        out = np.empty((1_000_000, channels), np.float32)
        for filter in ("bilinear", "trilinear"):
            duv = None if filter == "bilinear" else np.full((1_000_000, 4), 1e-3, np.float32)
            t = least(lambda: texmap.sample(texture, uv, duv, filter=filter, out=out, threads=1), 7)
            print(f"sample, 1 M look-ups, {channels} channels, {filter}, one thread: {t:.2f} ms")
    points, faces = grid()
    pos = to_clip(clip_from_world(eye=(0, 0, 2.2)), points)
    buffers = np.empty((1, 512, 512, 4), np.float32), np.empty((1, 512, 512, 4), np.float32)
    for db in (True, False):
        t = least(lambda: dr.rasterize(None, pos, faces, (512, 512), grad_db=db, out=buffers, threads=1))
        covered = (buffers[0][..., 3] > 0).mean()
        print(f"dr.rasterize, 512 x 512, {len(faces)} triangles, {covered:.0%} covered, grad_db={db}, one thread: {t:.2f} ms")
    rast, rast_db = dr.rasterize(None, pos, faces, (512, 512))
    uv = (points[:, :2] * 0.5 + 0.5).astype(np.float32)
    tex = rng.uniform(size=(1, 512, 512, 3)).astype(np.float32)
    at, da = dr.interpolate(uv, rast, faces, rast_db, "all")
    mip = dr.texture_construct_mip(tex)
    color = dr.texture(tex, at, da, mip=mip)
    print(f"dr.interpolate, 2 attributes with derivatives, one thread: {least(lambda: dr.interpolate(uv, rast, faces, rast_db, 'all', threads=1)):.2f} ms")
    print(f"dr.texture, trilinear of a mip stack, 3 channels, one thread: {least(lambda: dr.texture(tex, at, da, mip=mip, threads=1)):.2f} ms")
    print(f"dr.antialias: {least(lambda: dr.antialias(color, rast, pos, faces)):.2f} ms")
    scene = texmap.load(ROOT / "assets" / "models" / "cow.obj")
    angles = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    poses = np.tile(np.eye(4), (100, 1, 1))
    for pose, a in zip(poses, angles):
        back = np.array([np.sin(a), 0.0, np.cos(a)])
        pose[:3, :3] = np.stack([[np.cos(a), 0, -np.sin(a)], [0, 1, 0], back], axis=1)
        pose[:3, 3] = 16 * back
    cameras = texmap.Poses(poses, "opengl", fov=50)
    triangles = sum(m["triangles"] for m in scene.meshes)
    for samples in (1, 4):
        t = least(lambda: scene.render(cameras, (640, 480), samples=samples), 2, time.perf_counter)
        print(f"render, 100 poses of {triangles} triangles at 640 x 480, {samples} samples, all threads: {t:.0f} ms")


if __name__ == "__main__":
    main()
