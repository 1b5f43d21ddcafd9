"""Forked processes: none of the parent's threads live on in them, so that each call makes its own."""

import os
import subprocess
import sys

import pytest

SCRIPT = """
import os, sys, time
import numpy as np, texmap
picture = np.random.default_rng(1).random((64, 64, 4), np.float32)
points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
mesh = texmap.Mesh(points, [[0, 1, 2], [0, 2, 3]], points[:, :2] / 2 + 0.5)
works = {
    "automatic camera": lambda: texmap.load(sys.argv[1]).render(size=(40, 30)).hash,
    "named view": lambda: texmap.load(sys.argv[1]).render("top", size=(40, 30)).hash,
    "environment": lambda: texmap.load(sys.argv[1]).render(size=(40, 30), env=np.ones((16, 32, 3))).hash,
    "OpenEXR": lambda: texmap.pixel_hash(texmap.Texture(sys.argv[3]).level(0)),
    "diff": lambda: str(texmap.diff(picture, picture[::-1])["ssim"]),
    "sample": lambda: texmap.pixel_hash(texmap.sample(picture, picture[..., :2], picture)),
    "uv": lambda: str(texmap.uv_report(mesh)["faces"]),
    "unwrap": lambda: str(texmap.unwrap(mesh).uv.sum()),
    "bake": lambda: str(texmap.bake(texmap.Scene(mesh, lights=[texmap.Light("ambient")]), size=16).sum()),
}
work = works[sys.argv[2]]
expected = work()
child = os.fork()
if child == 0:
    os._exit(7 if work() == expected else 1)
for _ in range(400):
    done, status = os.waitpid(child, os.WNOHANG)
    if done:
        print(os.waitstatus_to_exitcode(status))
        break
    time.sleep(0.05)
else:
    os.kill(child, 9)
    print("does not end")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.parametrize("work", ["automatic camera", "named view", "environment", "OpenEXR", "diff", "sample", "uv", "unwrap", "bake"])
def test_a_forked_process_works_as_its_parent(program, assets, tmp_path, work):
    model, light = assets / "models" / "house.obj", tmp_path / "light.exr"
    program("warp", assets / "textures" / "face.png", "-o", light, "--size", "256x256", "--filter", "nearest", "--quiet")
    command = [sys.executable, "-W", "ignore", "-c", SCRIPT, model, work, light]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.stdout == "7\n", done.stdout + done.stderr
