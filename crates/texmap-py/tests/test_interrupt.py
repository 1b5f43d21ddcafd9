"""Ctrl-C ends long work: a timer raises SIGINT while a kernel runs, and the call raises KeyboardInterrupt."""

import os
import signal
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
    """True if the call ends by a SIGINT that comes once it runs; False if it returns before."""
    timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    try:
        work()
        timer.join()
        time.sleep(0.05)  # the signal of a work that is done comes here
    except KeyboardInterrupt:
        return not work.returned
    finally:
        timer.cancel()
    return False


class Work:
    """A call that remembers that it came to its end."""

    def __init__(self, call):
        self.call, self.returned = call, False

    def __call__(self):
        self.call()
        self.returned = True


def long_works(assets):
    """Calls of many seconds, one thread each."""
    head = texmap.load(assets / "models" / "head.obj")
    sheet = texmap.Scene(
        [texmap.Mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]], uv=[[0, 0], [1, 0], [1, 1], [0, 1]])],
        lights=[texmap.Light("point", position=(0, 0, 1 + 0.1 * k)) for k in range(40)],
    )
    points, faces = icosphere(6)
    pos = to_clip(clip_from_world(), points)
    sky = np.ones((256, 512, 3), np.float32)
    photo = np.ones((64, 64, 3), np.float32)
    many = np.linspace(0, 30, 1 << 25, dtype=np.float32).reshape(-1, 2)
    corner = np.array([[0.01, 0.01], [0.02, 0.01], [0.01, 0.02]], np.float32)
    return {
        "render": lambda: head.render(size=(8000, 8000), supersample=2, threads=1),
        "bake": lambda: texmap.bake(sheet, size=2048, shadow_size=0, threads=1),
        "env": lambda: texmap.env(sky, "cube", size=1024, blur=3, threads=1),
        "uv_raster": lambda: texmap.uv_raster(corner, [[0, 1, 2]], size=3000, gutter=3000, threads=1),
        "unwrap": lambda: texmap.unwrap(points, faces, size=4096, threads=1),
        "warp": lambda: texmap.warp(photo, np.diag([100.0, 100.0, 1.0]), size=(8000, 8000), threads=1),
        "sample": lambda: texmap.sample(photo, many, filter="trilinear", threads=1),
        "dr.rasterize": lambda: dr.rasterize(None, np.repeat(pos, 60, axis=0), faces, (512, 512), threads=1),
    }


@pytest.mark.parametrize("name", ["render", "bake", "env", "uv_raster", "unwrap", "warp", "sample", "dr.rasterize"])
def test_ctrl_c_ends_long_work(assets, name):
    assert interrupted(Work(long_works(assets)[name])), f"{name} came to its end"


def test_short_work_is_not_mistaken_for_an_interrupted_one():
    assert not interrupted(Work(lambda: texmap.sample(np.ones((4, 4, 3), np.float32), np.zeros((5, 2), np.float32))))
