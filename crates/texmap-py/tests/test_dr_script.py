"""A script that a user of nvdiffrast brings, with its import changed and nothing else."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT

import texmap.dr as dr

SCRIPT = pathlib.Path(__file__).with_name("nvdiffrast_script.py")
THEIRS, OURS = "import nvdiffrast.torch as dr\n", "import texmap.dr as dr\n"
MODEL, TEXTURE = ROOT / "assets" / "models" / "head.obj", ROOT / "assets" / "textures" / "face.png"


def run(folder, code):
    for module in ("torch", "trimesh", "PIL"):
        pytest.importorskip(module)
    (folder / "script.py").write_text(code)
    command = [sys.executable, "script.py", str(MODEL), str(TEXTURE), "out.png"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


def test_the_script_runs_with_its_import_changed(tmp_path):
    code = SCRIPT.read_text()
    assert code.count(THEIRS) == 1 and code.count("texmap") == 0
    done = run(tmp_path, code.replace(THEIRS, OURS))
    assert done.returncode == 0, done.stderr
    from PIL import Image

    seen = np.asarray(Image.open(tmp_path / "out.png"))
    assert seen.shape == (360, 360, 3)
    # The model is within the picture and takes a good part of it; the texture has many colours.
    border = np.concatenate([seen[0], seen[-1], seen[:, 0], seen[:, -1]])
    assert (border == 255).all()
    drawn = (seen != 255).any(axis=2)
    assert 0.2 < drawn.mean() < 0.9 and len(np.unique(seen[drawn], axis=0)) > 1000
    # Pixels at the outline are blended, no others. (Not all: the triangles there are narrower than a pixel.)
    without = run(tmp_path, code.replace(THEIRS, OURS).replace("color = dr.antialias(color, rast, clip, faces)", "pass"))
    assert without.returncode == 0, without.stderr
    plain = np.asarray(Image.open(tmp_path / "out.png"))
    changed, inside = (plain != seen).any(axis=2), np.pad((plain != 255).any(axis=2), 1)
    near = [np.roll(inside, shift, axis)[1:-1, 1:-1] for shift in (1, -1) for axis in (0, 1)]
    outline = np.any([side != inside[1:-1, 1:-1] for side in near], axis=0)
    assert changed.sum() > 100 and not (changed & ~outline).any()


def test_the_script_asks_for_gradients_in_vain(tmp_path):
    code = SCRIPT.read_text().replace(THEIRS, OURS)
    code = code.replace("with torch.no_grad():", "texels.requires_grad_()\nif True:")
    done = run(tmp_path, code)
    assert done.returncode != 0 and "NotImplementedError" in done.stderr and "texmap.grad" in done.stderr


def test_tensors_give_what_arrays_give(rng):
    torch = pytest.importorskip("torch")
    pos = rng.uniform(-1, 1, (1, 30, 4)).astype(np.float32)
    pos[..., 3] = 2
    tri = np.arange(30, dtype=np.int32).reshape(-1, 3)
    arrays = dr.rasterize(None, pos, tri, (40, 50))
    tensors = dr.rasterize(None, torch.from_numpy(pos), torch.from_numpy(tri), (40, 50))
    assert all(isinstance(t, torch.Tensor) and np.array_equal(a, t.numpy()) for a, t in zip(arrays, tensors))
