"""Ctrl-C ends long work: a timer raises SIGINT while a kernel runs, and the call raises KeyboardInterrupt long before its end.

The works below take many seconds, most of them minutes. One that goes on after the signal is ended with the whole run by a watchdog.
"""

import faulthandler
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import clip_from_world, icosphere, to_clip

import texmap
import texmap.dr as dr

if os.name == "nt":
    pytest.skip("no SIGINT can be sent to the own process there", allow_module_level=True)


def interrupted(work):
    """True if a SIGINT that comes a moment later ends the call; False if the call returns before."""
    returned = False
    timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
    faulthandler.dump_traceback_later(40, exit=True)
    try:
        timer.start()
        work()
        returned = True
        timer.join()
        time.sleep(0.05)  # the signal of a work that is done comes here
    except KeyboardInterrupt:
        pass
    finally:
        faulthandler.cancel_dump_traceback_later()
    return not returned


def grid(side):
    """Vertices and faces of a rough sheet."""
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    points = np.stack([x, y, np.random.default_rng(3).uniform(size=x.shape)], axis=-1).reshape(-1, 3).astype(np.float32)
    k = np.arange(side * side, dtype=np.int32).reshape(side, side)
    a, b, c, d = k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]
    return points, np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])


def render(assets):
    scene = texmap.load(assets / "models" / "head.obj")
    poses = texmap.Poses([texmap.look_at((0, 0, 6))] * 200, "opencv", fov=50)
    return lambda: scene.render(poses, (1024, 1024), supersample=4, threads=1)


def small_pictures(assets):
    scene = texmap.load(assets / "models" / "head.obj")
    poses = texmap.Poses([texmap.look_at((0, 0, 6))] * 60_000, "opencv", fov=50)
    return lambda: scene.render(poses, (120, 120), threads=2)


def bake(_):
    square, faces = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    mesh = texmap.Mesh(square, faces, uv=[[0, 0], [1, 0], [1, 1], [0, 1]])
    scene = texmap.Scene([mesh], lights=[texmap.Light("point", position=(0, 0, 1 + 1e-3 * k)) for k in range(10_000)])
    return lambda: texmap.bake(scene, size=2048, shadow_size=0, threads=1)


def env(_):
    sky = np.ones((256, 512, 3), np.float32)
    return lambda: texmap.env(sky, "cube", size=1000, blur=60, threads=1)


def uv_raster(_):
    # Each face reaches every texel.
    uv = np.tile(np.array([[-1, -1], [3, -1], [-1, 3]], np.float32), (60_000, 1))
    faces = np.arange(len(uv), dtype=np.int32).reshape(-1, 3)
    return lambda: texmap.uv_raster(uv, faces, size=2048, conservative=True, threads=1)


def unwrap(_):
    points, faces = grid(300)
    return lambda: texmap.unwrap(points, faces, size=8192, threads=1)


@pytest.mark.parametrize("work", [render, small_pictures, bake, env, uv_raster, unwrap], ids=lambda work: work.__name__)
def test_ctrl_c_ends_long_work(assets, work):
    assert interrupted(work(assets))


def test_ctrl_c_leaves_the_rest_of_an_array(assets):
    uv = np.linspace(0, 30, 1 << 25, dtype=np.float32).reshape(-1, 2)
    out = np.full((len(uv), 3), np.nan, np.float32)
    assert interrupted(lambda: texmap.sample(np.ones((64, 64, 3), np.float32), uv, out=out, filter="bicubic", threads=1))
    assert np.isnan(out[-1]).all() and not np.isnan(out[0]).any()
    points, faces = icosphere(6)
    pos = np.repeat(to_clip(clip_from_world(), points), 200, axis=0)
    out = tuple(np.full((200, 256, 256, 4), np.nan, np.float32) for _ in range(2))
    assert interrupted(lambda: dr.rasterize(None, pos, faces, (256, 256), out=out, threads=1))
    assert np.isnan(out[0][-1]).all()


def test_ctrl_c_ends_a_warp():
    assert interrupted(lambda: texmap.warp(np.ones((64, 64, 3), np.float32), np.diag([100.0, 100.0, 1.0]), size=(8000, 8000), threads=1))


def test_short_work_is_not_mistaken_for_an_interrupted_one():
    assert not interrupted(lambda: texmap.sample(np.ones((4, 4, 3), np.float32), np.zeros((5, 2), np.float32)))


FIRST = """
import builtins
import numpy as np, texmap
texels, uv = np.ones((4, 4, 3), np.float32), np.zeros((1, 2), np.float32)
def interrupted(name, *_, **__):
    raise KeyboardInterrupt(name)
builtins.__import__ = interrupted
try:
    import colorsys
except KeyboardInterrupt:
    print("interrupted", flush=True)
print(texmap.sample(texels, uv).shape)
"""


def test_the_first_kernel_imports_nothing():
    # A signal in an import of NumPy's functions was a panic: they are looked up when the module is loaded.
    done = subprocess.run([sys.executable, "-c", FIRST], capture_output=True, text=True, timeout=60)
    assert done.stdout == "interrupted\n(1, 3)\n", done.stderr
