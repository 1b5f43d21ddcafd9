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


@pytest.mark.parametrize("number", [-1, 2**40, 1.5])
def test_sizes_are_whole_numbers_of_a_range(number):
    points, faces = icosphere(0)
    uv = points[:, :2] / 2 + 0.5
    scene = texmap.Scene(texmap.Mesh(points, faces, uv), lights=[])
    rast = np.zeros((1, 2, 2, 4), np.float32)
    for call, name in [
        (lambda: texmap.bake(scene, size=number), "size"),
        (lambda: texmap.bake(scene, number, 8), "mesh"),
        (lambda: texmap.bake(scene, size=8, gutter=number), "gutter"),
        (lambda: texmap.bake(scene, size=8, shadow_size=number), "shadow_size"),
        (lambda: texmap.bake(scene, size=8, shadow_taps=number), "shadow_taps"),
        (lambda: texmap.env(np.ones((4, 8, 3)), size=number), "size"),
        (lambda: texmap.unwrap(points, faces, size=number), "size"),
        (lambda: texmap.unwrap(points, faces, gutter=number), "gutter"),
        (lambda: texmap.unwrap(points, faces, seams=[[0, number]]), "seams"),
        (lambda: texmap.uv_report(points, faces, uv, texture_size=number), "texture_size"),
        (lambda: texmap.uv_raster(uv, faces, 8, gutter=number), "gutter"),
        (lambda: texmap.uv_raster(uv, faces, number), "size"),
        (lambda: scene.render(size=(8, 8), samples=number), "samples"),
        (lambda: scene.render(size=(8, 8), supersample=number), "supersample"),
        (lambda: scene.mesh(number), "mesh"),
        (lambda: dr.rasterize(None, np.zeros((1, 3, 4)), [[0, 1, 2]], (8, number)), "resolution"),
        (lambda: dr.interpolate(np.zeros((3, 1)), rast, [[0, 1, 2]], rast, [number]), "diff_attrs"),
    ]:
        with pytest.raises(ValueError, match=f"^{name}[ =:]"):
            call()
    assert len(texmap.unwrap(points, faces, seams=np.array([[0, 2]])).faces) == len(faces)


@pytest.mark.parametrize("taps", [0, 2, 16, 17])
def test_the_filter_of_shadows_has_an_odd_side(taps):
    points, faces = icosphere(0)
    scene = texmap.Scene(texmap.Mesh(points, faces, points[:, :2] / 2 + 0.5), lights=[])
    with pytest.raises(ValueError, match=f"shadow_taps={taps}: "):
        texmap.bake(scene, size=8, shadow_taps=taps)
    assert texmap.bake(scene, size=8, shadow_taps=15).shape == (8, 8, 3)


def test_outputs_that_are_inputs_are_refused():
    both = np.zeros((1, 4, 4, 4), np.float32)
    tri = [[0, 1, 2]]
    pos = np.zeros((1, 16, 4), np.float32)
    other = np.zeros_like(both)
    for call, name in [
        (lambda: texmap.sample(np.zeros((2, 2, 2), np.float32), both.reshape(-1, 2), out=both.reshape(-1, 2)), "uv"),
        (lambda: texmap.sample(np.zeros((2, 2, 4), np.float32), other[..., :2], both, out=both), "duv"),
        (lambda: dr.rasterize(None, pos, tri, (4, 4), out=(pos.reshape(1, 4, 4, 4), other)), "pos"),
        (lambda: dr.rasterize(None, pos, tri, (4, 4), out=(both, both)), r"out\[0\]"),
        (lambda: dr.interpolate(np.zeros((3, 4)), both, tri, out=both), "rast"),
        (lambda: dr.texture(np.zeros((1, 4, 4, 4)), other[..., :2], both, out=both), "uv_da"),
        (lambda: dr.antialias(both, other, pos, tri, out=both), "color"),
    ]:
        with pytest.raises(ValueError, match=f"out.*: shares memory with {name},"):
            call()
    sampled = texmap.sample(np.ones((2, 2, 4), np.float32), both[..., :2].copy(), out=both)
    assert sampled is both and (both == 1).all()


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
