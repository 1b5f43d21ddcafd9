"""Arguments that no function can work with: each is a ValueError that names it."""

import ast
import inspect
import pathlib

import numpy as np
import pytest
from conftest import icosphere

import texmap
import texmap.dr as dr


def test_the_stubs_have_the_names_of_the_kernels():
    stubs = ast.parse((pathlib.Path(texmap.__file__).parent / "_texmap.pyi").read_text())
    checked = 0
    for function in [node for node in stubs.body if isinstance(node, ast.FunctionDef)]:
        names = [argument.arg for argument in function.args.args]
        found = list(inspect.signature(getattr(texmap._texmap, function.name)).parameters)
        assert found == names, function.name
        checked += 1
    assert checked > 20


@pytest.mark.parametrize("threads", [0, -1, 1025, 2**70])
def test_numbers_of_threads_are_checked_for_work_of_any_size(threads):
    points, faces = icosphere(1)
    uv = np.zeros((3, 2), np.float32)
    rast = np.zeros((1, 2, 2, 4), np.float32)
    for call in [
        lambda: texmap.sample(np.zeros((4, 4, 1), np.float32), uv, threads=threads),
        lambda: dr.interpolate(np.zeros((3, 1)), rast, [[0, 1, 2]], threads=threads),
        lambda: dr.texture(np.zeros((1, 4, 4, 1)), np.zeros((1, 1, 1, 2)), threads=threads),
        lambda: texmap.unwrap(points, faces, threads=threads),
        lambda: texmap.render((points, faces), size=(8, 8), threads=threads),
        lambda: texmap.warp(np.zeros((4, 4, 3), np.uint8), np.eye(3), threads=threads),
    ]:
        with pytest.raises(ValueError, match=f"cannot run on {threads} threads"):
            call()
