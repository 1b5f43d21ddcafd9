"""Gradients against finite differences and against the forward functions that they are the adjoint of."""

import numpy as np
import pytest
from conftest import clip_from_world, icosphere, to_clip

import reference
import texmap.dr as dr
import texmap.grad as grad

MODES = ["nearest", "linear", "linear-mipmap-nearest", "linear-mipmap-linear"]


def look_ups(rng, mode):
    uv = rng.uniform(-0.3, 1.3, (2, 10, 12, 2)).astype(np.float32)
    da = (rng.normal(size=(2, 10, 12, 4)) * 0.15).astype(np.float32) if "mipmap" in mode else None
    return uv, da


@pytest.mark.parametrize("boundary", ["wrap", "clamp", "zero"])
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("count", [1, 2])
def test_texture_gradient_is_the_adjoint(rng, mode, boundary, count):
    uv, da = look_ups(rng, mode)
    tex = rng.normal(size=(count, 8, 16, 3)).astype(np.float32)
    weights = rng.normal(size=(2, 10, 12, 3)).astype(np.float32)
    out = dr.texture(tex, uv, da, filter_mode=mode, boundary_mode=boundary)
    found = grad.texture_backward(weights, tex.shape, uv, da, filter_mode=mode, boundary_mode=boundary)
    one, two = (out.astype(float) * weights).sum(), (tex.astype(float) * found).sum()
    assert abs(one - two) < 2e-3 * np.abs(out * weights).sum() ** 0.5
    other = grad.texture_backward(weights[:, ::-1], tex.shape, uv, da, filter_mode=mode, boundary_mode=boundary)
    assert abs((tex.astype(float) * other).sum() - one) > 1e-2


@pytest.mark.parametrize("mode", MODES)
def test_texture_gradient_is_finite_differences_in_f64(rng, mode):
    uv, da = look_ups(rng, mode)
    uv, da = uv[:1], None if da is None else da[:1]
    tex = rng.normal(size=(1, 4, 4, 1)).astype(np.float32)
    weights = rng.normal(size=(1, 10, 12, 1)).astype(np.float32)
    found = grad.texture_backward(weights, tex.shape, uv, da, filter_mode=mode)
    lod = None
    if da is not None:
        lod = np.log2(np.linalg.norm(da.reshape(-1, 2, 2).astype(np.float64) * 4, ord=2, axis=(1, 2)))

    def loss(texels):
        return (reference.texture(texels, uv.reshape(-1, 2), mode, "wrap", lod) * weights.reshape(-1, 1)).sum()

    for k in range(16):
        step = np.zeros(16)
        step[k] = 1e-3
        base = tex[0].astype(np.float64)
        slope = (loss(base + step.reshape(4, 4, 1)) - loss(base - step.reshape(4, 4, 1))) / 2e-3
        assert abs(slope - found.reshape(-1)[k]) < 1e-3


@pytest.mark.parametrize("shape", [(2,), (1,), ()])
def test_interpolate_gradient_is_finite_differences_in_f64(rng, shape):
    points, tri = icosphere(1)
    pos = np.repeat(to_clip(clip_from_world(), points), 2, axis=0)
    rast, _ = dr.rasterize(None, pos, tri, (24, 24))
    attr = rng.normal(size=shape + (len(points), 2)).astype(np.float32)
    weights = rng.normal(size=(2, 24, 24, 2)).astype(np.float32)
    found = grad.interpolate_backward(weights, attr.shape, rast, tri)
    u, v = rast[..., 0, None].astype(float), rast[..., 1, None].astype(float)
    seen = rast[..., 3, None] > 0
    corners = tri[np.clip(rast[..., 3].astype(int) - 1, 0, None)]

    def loss(values):
        sets = np.broadcast_to(values, (2,) + values.shape[-2:])
        c = np.stack([sets[b][corners[b]] for b in range(2)])
        out = u * c[..., 0, :] + v * c[..., 1, :] + (1 - u - v) * c[..., 2, :]
        return (np.where(seen, out, 0) * weights).sum()

    for _ in range(10):
        k = rng.integers(attr.size)
        step = np.zeros(attr.size)
        step[k] = 1e-3
        base, step = attr.astype(np.float64), step.reshape(attr.shape)
        slope = (loss(base + step) - loss(base - step)) / 2e-3
        assert abs(slope - found.reshape(-1)[k]) < 1e-3


def test_positions_have_no_gradient():
    torch = pytest.importorskip("torch")
    pos = torch.zeros(1, 3, 4, requires_grad=True)
    with pytest.raises(NotImplementedError, match="pos requires a gradient"):
        dr.rasterize(None, pos, torch.zeros(1, 3, dtype=torch.int32), (4, 4))
    with torch.no_grad():
        dr.rasterize(None, pos, torch.zeros(1, 3, dtype=torch.int32), (4, 4))
    with pytest.raises(NotImplementedError, match="cube"):
        grad.texture_backward(np.zeros((1, 1, 1, 3)), (1, 4, 4, 3), np.zeros((1, 1, 1, 2)), boundary_mode="cube")


@pytest.mark.parametrize("shape", [(1, 0, 8, 3), (1, 8, 0, 3), (1, 8, 8, 0), (0, 8, 8, 3), (1, -1, 8, 3), (1, 8, 8.5, 3), (8, 8, 3)])
def test_a_texture_without_texels_is_an_error(shape):
    with pytest.raises(ValueError, match="tex_shape"):
        grad.texture_backward(np.ones((1, 4, 4, 3)), shape, np.zeros((1, 4, 4, 2)))


def test_an_unknown_boundary_is_an_error():
    with pytest.raises(ValueError, match="boundary_mode=\"mirror\": know wrap, clamp, zero"):
        grad.texture_backward(np.zeros((1, 1, 1, 3)), (1, 4, 4, 3), np.zeros((1, 1, 1, 2)), boundary_mode="mirror")


def test_autograd_fits_a_texture_and_colours(rng):
    torch = pytest.importorskip("torch")
    points, tri = icosphere(2)
    pos = torch.from_numpy(to_clip(clip_from_world(), points))
    tri = torch.from_numpy(tri)
    rast, db = dr.rasterize(dr.RasterizeContext(), pos, tri, (48, 48))
    uv = torch.from_numpy(points[:, :2] * 0.5 + 0.5)
    at, at_da = dr.interpolate(uv[None], rast, tri, db, "all")
    target = torch.rand(1, 16, 16, 3)
    goal = dr.texture(target, at, at_da)
    seen = rast[..., 3:] > 0
    tex = torch.full((1, 16, 16, 3), 0.5, requires_grad=True)
    first = None
    for _ in range(60):
        loss = (seen * (grad.texture(tex, at, at_da) - goal) ** 2).sum()
        first = first or loss.item()
        loss.backward()
        with torch.no_grad():
            tex -= 0.03 * tex.grad
            tex.grad = None
    assert loss.item() < 0.2 * first
    colors = torch.zeros(len(points), 3, requires_grad=True)
    grad.interpolate(colors, rast, tri).sum().backward()
    assert abs(colors.grad.sum().item() - 3 * (rast[..., 3] > 0).sum().item()) < 1e-1


def test_same_bits_each_time(rng):
    uv, da = look_ups(rng, "linear-mipmap-linear")
    weights = rng.normal(size=(2, 10, 12, 3)).astype(np.float32)
    runs = [grad.texture_backward(weights, (1, 8, 8, 3), uv, da).tobytes() for _ in range(3)]
    assert len(set(runs)) == 1
