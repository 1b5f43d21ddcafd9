"""texmap.dr.rasterize against OpenGL (llvmpipe by EGL), where moderngl and a context can be had."""

import numpy as np
import pytest
from conftest import clip_from_world, icosphere, to_clip
from test_dr import random_triangles

import texmap.dr as dr

VERTEX = """#version 330
in vec4 position; in vec2 weights; in float number; out vec2 bary; flat out float id;
void main() { gl_Position = position; bary = weights; id = number; }"""
FRAGMENT = """#version 330
in vec2 bary; flat in float id; out vec4 color;
void main() { color = vec4(bary, 2.0 * gl_FragCoord.z - 1.0, id); }"""


@pytest.fixture(scope="module")
def gl():
    moderngl = pytest.importorskip("moderngl")
    try:
        return moderngl.create_standalone_context(backend="egl")
    except Exception as error:  # no EGL, no driver
        pytest.skip(f"no OpenGL context: {error}")


def by_gl(gl, pos, tri, height, width):
    """rast of one picture, drawn by OpenGL; row 0 is the bottom row there too."""
    weights = np.tile(np.array([[1, 0], [0, 1], [0, 0]], np.float32), (len(tri), 1))
    number = np.repeat(np.arange(1, len(tri) + 1, dtype=np.float32), 3)[:, None]
    data = np.concatenate([pos[tri.reshape(-1)], weights, number], axis=1).astype(np.float32)
    program = gl.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
    array = gl.vertex_array(program, [(gl.buffer(data.tobytes()), "4f 2f 1f", "position", "weights", "number")])
    target = gl.framebuffer([gl.texture((width, height), 4, dtype="f4")], gl.depth_renderbuffer((width, height)))
    target.use()
    gl.enable_only(0x2)  # depth test, no culling
    target.clear()
    array.render()
    return np.frombuffer(target.read(components=4, dtype="f4"), np.float32).reshape(height, width, 4)


@pytest.mark.parametrize("what", ["sphere", "triangles", "through the eye"])
def test_rasterize_is_opengl(gl, rng, what):
    if what == "sphere":
        points, tri = icosphere(3)
        pos = to_clip(clip_from_world(), points)[0]
    elif what == "triangles":
        pos, tri = random_triangles(rng, 30, 20.0)
    else:
        pos, tri = np.array([[-8, -1, 4, 5], [8, -1, 4, 5], [0, -1, -6, -4]], np.float32), np.array([[0, 1, 2]], np.int32)
    expected = by_gl(gl, pos, tri, 120, 160)
    found = dr.rasterize(None, pos[None], tri, (120, 160))[0][0]
    same = expected[..., 3] == found[..., 3]
    # Along edges the grid to which vertices are snapped decides.
    assert same.mean() > 0.995 and (expected[..., 3] > 0).sum() > 500
    seen = same & (found[..., 3] > 0)
    inner = seen & (found[..., :2].min(axis=-1) > 0) & (found[..., :2].sum(axis=-1) < 1)
    off = np.abs(expected[..., :3] - found[..., :3])[inner]
    # llvmpipe interpolates in f32 from snapped vertices.
    assert np.quantile(off, 0.99) < 5e-3 and np.median(off) < 2e-4
    assert np.abs(expected[::-1, :, :2] - found[..., :2])[inner].mean() > 0.01 or what == "sphere"
