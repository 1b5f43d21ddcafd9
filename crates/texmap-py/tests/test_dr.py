"""texmap.dr against references, and its errors."""

import numpy as np
import pytest
from conftest import clip_from_world, icosphere, to_clip

import reference
import texmap.dr as dr
import texmap.grad as grad


def random_triangles(rng, count, w_ratio, size=0.5):
    """Clip positions of separate triangles around random places of the screen, w from 1 to ``w_ratio``."""
    middle = rng.uniform(-0.9, 0.9, (count, 1, 2))
    ndc = middle + rng.uniform(-size, size, (count, 3, 2))
    z = rng.uniform(-0.9, 0.9, (count, 3))
    w = w_ratio ** rng.uniform(0, 1, (count, 3))
    pos = np.concatenate([ndc * w[..., None], (z * w)[..., None], w[..., None]], axis=2)
    return pos.reshape(-1, 4).astype(np.float32), np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


@pytest.mark.parametrize("w_ratio", [1.0, 3.0, 100.0])
def test_rasterize_is_the_f64_reference(rng, w_ratio):
    height, width = 96, 130
    for _ in range(4):
        pos, tri = random_triangles(rng, 12, w_ratio)
        rast, db = dr.rasterize(None, pos[None], tri, (height, width))
        expected, slopes, margin = reference.rasterize(pos, tri, height, width)
        clear = margin > 1 / 256
        assert clear.mean() > 0.9
        assert np.array_equal(rast[0, ..., 3][clear], expected[..., 3][clear])
        seen = clear & (expected[..., 3] > 0)
        screen = pos[tri, :2] / pos[tri, 3:]
        (ax, ay), (bx, by) = (screen[:, k].T - screen[:, 0].T for k in (1, 2))
        areas = np.abs(ax * by - ay * bx)
        large = areas * width * height / 8 >= 1.0
        seen &= large[np.clip(expected[..., 3].astype(int) - 1, 0, None)]
        assert seen.sum() > 1000
        assert np.abs(rast[0, ..., :3] - expected[..., :3])[seen].max() < 1e-6
        scale = np.maximum(1.0, np.abs(slopes[seen]))
        assert (np.abs(db[0][seen] - slopes[seen]) / scale).max() < 1e-5
        assert not rast[0][clear & (expected[..., 3] == 0)].any()


def test_the_reference_sees_a_wrong_interpolation(rng):
    pos, tri = random_triangles(rng, 3, 100.0)
    flat = pos.copy()
    flat[:, :3] /= flat[:, 3:]
    flat[:, 3] = 1.0
    rast, _ = dr.rasterize(None, flat[None], tri, (64, 64))
    expected, _, margin = reference.rasterize(pos, tri, 64, 64)
    seen = (margin > 1 / 256) & (expected[..., 3] > 0)
    assert np.abs(rast[0, ..., 0] - expected[..., 0])[seen].max() > 0.01


def test_conventions_by_hand():
    # The lower left half of the picture, vertex 0 at the lower left corner.
    pos = np.array([[[-1, -1, 0, 1], [1, -1, 0, 1], [-1, 1, 0.5, 1]]], np.float32)
    tri = np.array([[0, 1, 2]], np.int32)
    rast, db = dr.rasterize(None, pos, tri, (4, 8))
    assert rast.shape == db.shape == (1, 4, 8, 4) and rast.dtype == np.float32
    u, v, z, triangle = rast[0, 0, 0]
    # Row 0 is the bottom row: its first centre is at 1/16 of the width and 1/8 of the height.
    assert np.allclose([u, v, z], [1 - 1 / 16 - 1 / 8, 1 / 16, 0.5 / 8]) and triangle == 1
    assert np.allclose(db[0, 0, 0], [-1 / 8, -1 / 4, 1 / 8, 0])
    assert not rast[0, 3, 7].any()
    assert dr.rasterize(None, pos, tri, (4, 8), grad_db=False)[1].shape == (1, 4, 8, 0)


def test_ranges_count_triangles_of_the_whole_list(rng):
    pos, tri = random_triangles(rng, 6, 2.0)
    ranges = np.array([[0, 2], [2, 4], [6, 0]], np.int32)
    rast, _ = dr.rasterize(None, pos, tri, (32, 32), ranges=ranges)
    assert rast.shape[0] == 3 and not rast[2].any()
    assert set(np.unique(rast[1, ..., 3])) <= {0, 3, 4, 5, 6}
    alone, _ = dr.rasterize(None, pos[None], tri[2:], (32, 32))
    found = alone.copy()
    found[..., 3] += 2 * (found[..., 3] > 0)
    assert np.array_equal(rast[1], found[0])


def test_ids_beyond_24_bits():
    # One triangle of 16,777,300, drawn by a range of one.
    pos = np.array([[-1, -1, 0, 1], [3, -1, 0, 1], [-1, 3, 0, 1]], np.float32)
    number = (1 << 24) + 77
    tri = np.zeros((number + 1, 3), np.int32)
    tri[number] = [0, 1, 2]
    rast, _ = dr.rasterize(None, pos, tri, (2, 2), ranges=[[number, 1]], grad_db=False)
    assert rast.view(np.int32)[0, 0, 0, 3] == 0x4A800000 + number + 1
    out, _ = dr.interpolate(np.eye(3, dtype=np.float32), rast, tri)
    assert np.allclose(out.sum(axis=-1), 1.0)


def test_clipping_keeps_depth_and_weights():
    # A floor that passes the eye: two vertices lie behind it.
    pos = np.array([[[-8, -1, 4, 5], [8, -1, 4, 5], [0, -1, -6, -4]]], np.float32)
    rast, _ = dr.rasterize(None, pos, [[0, 1, 2]], (64, 64))
    seen = rast[0, ..., 3] > 0
    assert seen.any() and not seen.all()
    u, v = rast[0, ..., 0][seen], rast[0, ..., 1][seen]
    clip = u[:, None] * pos[0, 0] + v[:, None] * pos[0, 1] + (1 - u - v)[:, None] * pos[0, 2]
    y, x = np.nonzero(seen)
    assert np.abs(clip[:, 0] / clip[:, 3] - ((x + 0.5) / 32 - 1)).max() < 1e-4
    assert np.abs(clip[:, 2] / clip[:, 3] - rast[0, ..., 2][seen]).max() < 1e-4


@pytest.mark.parametrize("threads,level", [(1, "sse2"), (2, None), (3, "auto")])
def test_same_bytes_for_any_threads_and_level(rng, threads, level):
    import platform

    if level == "sse2" and platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("no SSE2")
    pos, tri = random_triangles(rng, 300, 4.0, size=0.1)
    expected = dr.rasterize(None, pos[None], tri, (200, 300))
    found = dr.rasterize(None, pos[None], tri, (200, 300), threads=threads, level=level)
    assert all(np.array_equal(a, b) for a, b in zip(expected, found))


def test_interpolate_and_its_derivatives(rng):
    pos, tri = random_triangles(rng, 8, 3.0)
    rast, db = dr.rasterize(None, np.stack([pos, pos]), tri, (64, 64))
    attr = rng.normal(size=(2, len(pos), 5)).astype(np.float32)
    out, da = dr.interpolate(attr, rast, tri, rast_db=db, diff_attrs=[4, 1])
    corners = attr[1][tri[rast[1, ..., 3].astype(int) - 1]].astype(np.float64)
    u, v = rast[1, ..., 0, None], rast[1, ..., 1, None]
    expected = u * corners[:, :, 0] + v * corners[:, :, 1] + (1 - u - v) * corners[:, :, 2]
    empty = rast[1, ..., 3] == 0
    assert np.abs(out[1] - np.where(empty[..., None], 0, expected)).max() < 1e-5
    for place, channel in enumerate([4, 1]):
        du = (corners[:, :, 0] - corners[:, :, 2])[..., channel]
        dv = (corners[:, :, 1] - corners[:, :, 2])[..., channel]
        for axis in (0, 1):
            slope = np.where(empty, 0, db[1, ..., axis] * du + db[1, ..., 2 + axis] * dv)
            assert np.allclose(da[1, ..., 2 * place + axis], slope, rtol=1e-4, atol=1e-5)
    every = dr.interpolate(attr[:1], rast, tri, db, "all")
    assert every[1].shape == (2, 64, 64, 10) and np.array_equal(every[0][0], out[0])


@pytest.mark.parametrize("boundary", ["wrap", "clamp", "zero"])
@pytest.mark.parametrize("mode", ["nearest", "linear", "linear-mipmap-nearest", "linear-mipmap-linear"])
@pytest.mark.parametrize("channels", [1, 2, 3, 4, 7])
def test_texture_is_the_numpy_oracle(rng, mode, boundary, channels):
    tex = rng.normal(size=(1, 16, 32, channels)).astype(np.float32)
    uv = rng.uniform(-1.2, 2.2, (1, 40, 50, 2)).astype(np.float32)
    if mode == "nearest":  # away from the borders of texels, which rounding decides
        near = np.abs(uv * [32, 16] - np.round(uv * [32, 16])) < 1e-4
        uv[near] += 0.01
    da = (rng.normal(size=(1, 40, 50, 4)) * 0.1).astype(np.float32) if "mipmap" in mode else None
    bias = rng.uniform(-1, 1, (1, 40, 50)).astype(np.float32) if "mipmap" in mode else None
    lod = None
    if da is not None:
        jacobian = da.reshape(-1, 2, 2).astype(np.float64) * np.array([32, 16])[None, :, None]
        lod = np.log2(np.linalg.norm(jacobian, ord=2, axis=(1, 2))) + bias.reshape(-1)
    out = dr.texture(tex, uv, da, bias, filter_mode=mode, boundary_mode=boundary)
    expected = reference.texture(tex[0], uv.reshape(-1, 2), mode, boundary, lod)
    wrong = np.abs(out.reshape(-1, channels) - expected).max(axis=1) > 2e-4
    if mode == "linear-mipmap-nearest":  # a level is chosen by rounding
        wrong &= np.abs(lod - np.floor(lod) - 0.5) > 1e-4
    assert not wrong.any()


def test_bias_alone_is_the_level():
    tex = np.arange(16, dtype=np.float32).reshape(1, 4, 4, 1)
    uv = np.full((1, 1, 3, 2), 0.5, np.float32)
    bias = np.array([[[0.0, 2.0, 9.0]]], np.float32)
    assert np.allclose(dr.texture(tex, uv, mip_level_bias=bias).reshape(-1), 7.5)
    corner = np.full((1, 1, 3, 2), 0.125, np.float32)
    assert np.allclose(dr.texture(tex, corner, mip_level_bias=bias, boundary_mode="clamp").reshape(-1), [0, 7.5, 7.5])


def test_mip_stacks_and_odd_sides(rng):
    tex = rng.normal(size=(1, 8, 8, 3)).astype(np.float32)
    uv = rng.uniform(0, 1, (1, 9, 9, 2)).astype(np.float32)
    da = np.full((1, 9, 9, 4), 0.2, np.float32)
    mip = dr.texture_construct_mip(tex, max_mip_level=1)
    a = dr.texture(tex, uv, da, mip=mip)
    assert np.array_equal(a, dr.texture(tex, uv, da, max_mip_level=1))
    assert not np.array_equal(a, dr.texture(tex, uv, da))
    odd = np.ones((1, 6, 8, 3), np.float32)
    with pytest.raises(ValueError, match="odd side"):
        dr.texture(odd, uv, da)
    with pytest.raises(ValueError, match="max_mip_level=1"):
        dr.texture_construct_mip(odd)
    assert np.allclose(dr.texture(odd, uv, da, max_mip_level=1), 1.0)
    assert np.allclose(dr.texture(np.ones((1, 5, 7, 3), np.float32), uv), 1.0)


def test_cube_faces_and_invalid_directions():
    tex = np.zeros((1, 6, 4, 4, 1), np.float32)
    tex[0] += np.arange(6, dtype=np.float32)[:, None, None, None]
    axes = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [0, 0, 0]], np.float32)
    out = dr.texture(tex, axes.reshape(1, 1, 7, 3), boundary_mode="cube").reshape(-1)
    assert np.allclose(out, [0, 1, 2, 3, 4, 5, 0])


def test_peeling_shows_all_layers_in_order(rng):
    planes = []
    for z in (0.5, -0.5, 0.0):
        planes += [[-1, -1, z, 1], [3, -1, z, 1], [-1, 3, z, 1]]
    pos = np.array([planes], np.float32)
    tri = np.arange(9, dtype=np.int32).reshape(3, 3)
    with dr.DepthPeeler(None, pos, tri, (8, 8)) as peeler:
        ids = [np.unique(peeler.rasterize_next_layer()[0][..., 3]).tolist() for _ in range(4)]
    assert ids == [[2], [3], [1], [0]]
    # Surfaces at one depth each have a layer.
    same = pos.copy()
    same[..., 2] = 0.25
    with dr.DepthPeeler(None, same, tri, (8, 8)) as peeler:
        ids = [np.unique(peeler.rasterize_next_layer()[0][..., 3]).tolist() for _ in range(4)]
    assert ids == [[1], [2], [3], [0]]
    with pytest.raises(RuntimeError, match="with"):
        peeler.rasterize_next_layer()


def test_layers_of_a_sphere_are_front_and_back():
    points, tri = icosphere(3)
    pos = to_clip(clip_from_world(), points)
    with dr.DepthPeeler(None, pos, tri, (64, 64)) as peeler:
        first, second, third = (peeler.rasterize_next_layer()[0][0] for _ in range(3))
    plain, _ = dr.rasterize(None, pos, tri, (64, 64))
    assert np.array_equal(first, plain[0]) and not third.any()
    both = second[..., 3] > 0
    assert (both == (first[..., 3] > 0)).mean() > 0.999 and (second[..., 2] > first[..., 2])[both].all()


def test_antialias_moves_the_mean_to_the_true_area():
    # A closed square of two triangles whose edges lie at fractions of pixels.
    for shift in (0.1, 0.25, 0.4):
        edge = 0.5 + 2 * shift / 16
        pos = np.array([[[-edge, -edge, 0, 1], [edge, -edge, 0, 1], [edge, edge, 0, 1], [-edge, edge, 0, 1]]], np.float32)
        tri = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
        rast, _ = dr.rasterize(None, pos, tri, (16, 16))
        color = (rast[..., 3:] > 0).astype(np.float32)
        smooth = dr.antialias(color, rast, pos, tri)
        true_row = 8 + 2 * shift
        assert abs(smooth[0, 8, :, 0].sum() - true_row) < 1e-5
        # The diagonal is no silhouette: inside nothing changes.
        assert np.array_equal(smooth[0, 6:10, 6:10], color[0, 6:10, 6:10])


def test_antialias_leaves_inner_edges(rng):
    points, tri = icosphere(2)
    pos = to_clip(clip_from_world(), points)
    rast, _ = dr.rasterize(None, pos, tri, (64, 64))
    color = rng.uniform(size=(1, 64, 64, 3)).astype(np.float32)
    smooth = dr.antialias(color, rast, pos, tri)
    changed = np.abs(smooth - color).max(axis=-1)[0] > 0
    inside = rast[0, ..., 3] > 0
    edge = np.zeros_like(inside)
    edge[1:] |= inside[1:] != inside[:-1]
    edge[:-1] |= inside[1:] != inside[:-1]
    edge[:, 1:] |= inside[:, 1:] != inside[:, :-1]
    edge[:, :-1] |= inside[:, 1:] != inside[:, :-1]
    assert changed.any() and not (changed & ~edge).any()


def test_errors_name_argument_and_shape():
    pos, tri = np.zeros((1, 3, 4), np.float32), [[0, 1, 2]]
    for call, words in [
        (lambda: dr.rasterize(None, pos[0], tri, (4, 4)), "ranges"),
        (lambda: dr.rasterize(None, pos[..., :3], tri, (4, 4)), r"pos: expected shape .* got \(1, 3, 3\)"),
        (lambda: dr.rasterize(None, pos, [[0, 1, 3]], (4, 4)), "3"),
        (lambda: dr.rasterize(None, pos, [[0, 1, -1]], (4, 4)), "count from 0"),
        (lambda: dr.rasterize(None, pos, [[0.5, 1, 2]], (4, 4)), "whole numbers"),
        (lambda: dr.rasterize(None, pos, tri, (0, 4)), "resolution"),
        (lambda: dr.interpolate(np.zeros((2, 1)), np.ones((1, 1, 1, 4)), tri), "vertex 2, there are 2"),
        (lambda: dr.interpolate(np.zeros((3, 1)), np.full((1, 1, 1, 4), 9.0), tri), "triangle 8, tri holds 1"),
        (lambda: dr.texture(np.zeros((4, 4, 3)), np.zeros((1, 1, 1, 2))), "tex: expected shape"),
        (lambda: dr.texture(np.zeros((1, 4, 4, 3)), np.zeros((1, 1, 1, 2)), filter_mode="cubic"), "filter_mode"),
        (lambda: dr.texture(np.full((1, 4, 4, 3), np.nan), np.zeros((1, 1, 1, 2))), "texel"),
    ]:
        with pytest.raises(ValueError, match=words):
            call()


def test_out_is_filled_in_place():
    pos = np.array([[[-1, -1, 0, 1], [3, -1, 0, 1], [-1, 3, 0, 1]]], np.float32)
    out = np.empty((1, 4, 4, 4), np.float32), np.empty((1, 4, 4, 4), np.float32)
    rast, db = dr.rasterize(None, pos, [[0, 1, 2]], (4, 4), out=out)
    assert rast is out[0] and db is out[1] and (rast[..., 3] == 1).all()
    with pytest.raises(ValueError, match="out"):
        dr.rasterize(None, pos, [[0, 1, 2]], (4, 4), out=(out[0][:, :2], out[1]))


@pytest.mark.parametrize("size", [1e10, 1e19, 3e38, np.inf])
@pytest.mark.parametrize("axes", [[[1, 0], [0, 1]], [[1, 1], [1, -1]], [[0, 1], [1, 0]], [[1, 0], [0, 0]]])
def test_huge_footprints_read_the_coarsest_level(rng, size, axes):
    tex = rng.random((1, 8, 8, 2), np.float32)
    with np.errstate(invalid="ignore"):
        da = np.where(np.array(axes) == 0, 0, np.array(axes) * size).astype(np.float32).reshape(1, 1, 1, 4)
    uv = np.full((1, 1, 1, 2), 0.3, np.float32)
    mean = tex.mean(axis=(1, 2))
    assert np.allclose(dr.texture(tex, uv, da), mean, atol=1e-5)
    assert np.allclose(dr.texture(tex, uv, da, np.full((1, 1, 1), 200.0)), mean, atol=1e-5)
    ones = np.ones((1, 1, 1, 2), np.float32)
    assert np.allclose(grad.texture_backward(ones, tex.shape, uv, da), 1 / 64)
