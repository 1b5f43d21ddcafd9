"""Look-ups, warps, comparisons, environments, bakes."""

import json

import numpy as np
import pytest
from conftest import icosphere
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
import texmap


@pytest.mark.parametrize("channels", [1, 2, 3, 4, 5, 9])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_bilinear_is_the_oracle_for_any_channels(rng, channels, kind):
    if kind == np.float32:
        image = rng.normal(size=(12, 20, channels)).astype(kind)
        scale = 1.0
    else:
        image = rng.integers(0, np.iinfo(kind).max, (12, 20, channels), dtype=kind)
        scale = np.iinfo(kind).max
    uv = rng.uniform(-1, 2, (33, 7, 2)).astype(np.float32)
    texture = texmap.Texture(image, color="linear", alpha="data", origin="top-left")
    out = texmap.sample(texture, uv)
    expected = reference.texture(image / scale, uv.reshape(-1, 2), "linear", "wrap").reshape(33, 7, channels)
    assert out.shape == (33, 7, channels) and np.abs(out - expected).max() < 2e-4
    upside_down = texmap.sample(image, uv * [1, -1] + [0, 1])
    assert np.abs(upside_down - expected).max() < 1e-3


def test_out_threads_level_and_strides(rng):
    image = rng.uniform(size=(64, 64, 3)).astype(np.float32)
    uv = rng.uniform(size=(100_000, 2)).astype(np.float32)
    duv = (rng.normal(size=(100_000, 2, 2)) * 0.05).astype(np.float32)
    texture = texmap.Texture(image)
    out = np.empty((100_000, 3), np.float32)
    first = texmap.sample(texture, uv, duv, filter="anisotropic:8", out=out)
    assert first is out
    assert np.array_equal(first, texmap.sample(texture, uv, duv, filter="anisotropic:8", threads=1))
    assert np.array_equal(first, texmap.sample(texture, uv[:, ::-1][:, ::-1], duv.reshape(-1, 4), filter="anisotropic:8", threads=3))
    assert not np.array_equal(first, texmap.sample(texture, uv, duv.transpose(0, 2, 1), filter="anisotropic:8"))
    for bad in (np.empty((99_999, 3), np.float32), np.empty((100_000, 3)), np.empty((3, 100_000), np.float32).T):
        with pytest.raises(ValueError, match="out"):
            texmap.sample(texture, uv, out=bad)


def test_srgb_and_alpha(rng):
    image = np.zeros((2, 2, 4), np.uint8)
    image[..., 0], image[..., 3] = 188, 128
    out = texmap.sample(texmap.Texture(image), [0.5, 0.5])
    alpha = 128 / 255
    assert np.allclose(out, [0.5 * alpha, 0, 0, alpha], atol=0.005)
    raw = texmap.sample(image, [0.5, 0.5])
    assert np.allclose(raw, image[0, 0] / 255, atol=1e-6)
    grey = np.zeros((2, 2, 2), np.uint8)
    grey[..., 0], grey[..., 1] = 255, 51
    assert np.allclose(texmap.sample(texmap.Texture(grey, color="linear", alpha="straight"), [0.5, 0.5]), [0.2, 0.2], atol=1e-4)


def test_files_and_pil_are_images(assets, tmp_path):
    path = sorted((assets / "textures").glob("*.png"))[0]
    texture = texmap.Texture(path)
    image_module = pytest.importorskip("PIL.Image")
    same = texmap.Texture(image_module.open(path).convert("RGBA" if texture.shape[2] == 4 else "RGB"))
    assert np.array_equal(texture.level(0), same.level(0)) and texture.levels > 1
    with pytest.raises(FileNotFoundError):
        texmap.Texture(tmp_path / "none.png")
    (tmp_path / "broken.png").write_bytes(b"not a picture")
    with pytest.raises(ValueError, match="broken.png"):
        texmap.Texture(tmp_path / "broken.png")


def test_torch_tensors_are_read_in_place(rng):
    torch = pytest.importorskip("torch")
    uv = torch.rand(50, 2)
    image = rng.uniform(size=(8, 8, 3)).astype(np.float32)
    assert np.array_equal(texmap.sample(image, uv), texmap.sample(image, uv.numpy()))


@given(st.floats(0.01, 100), st.floats(0.01, 100), st.floats(0, 1))
@settings(max_examples=200, deadline=None)
def test_a_span_in_perspective(w1, w2, t):
    (value,), weights = texmap.perspective_interpolate([[0.0], [1.0]], [w1, w2], t)
    s = t * w1 / (w2 + t * (w1 - w2))
    assert abs(value - s) < 1e-12 and abs(weights.sum() - 1) < 1e-12
    # Attribute over w is linear on the screen.
    assert abs(value / (w1 + s * (w2 - w1)) - t / w2) < 1e-9 * max(1, 1 / w1, 1 / w2)
    if abs(w1 / w2 - 1) > 0.1 and 0.1 < t < 0.9:
        assert abs(value - t) > 1e-3  # an affine interpolation would be wrong


@given(st.lists(st.floats(0.05, 50), min_size=3, max_size=3), st.lists(st.floats(0.01, 1), min_size=3, max_size=3))
@settings(max_examples=200, deadline=None)
def test_a_triangle_in_perspective(w, b):
    b = np.array(b) / np.sum(b)
    values = np.array([[1.0, w[0]], [1.0, w[1]], [1.0, w[2]]])
    out, weights = texmap.perspective_interpolate(values, w, b)
    # A constant stays; the interpolated w is the harmonic mean of the corners' w by the weights on the screen.
    assert abs(out[0] - 1) < 1e-12 and abs(1 / out[1] - (b / w).sum()) < 1e-9 * (b / w).sum()
    assert abs(weights.sum() - 1) < 1e-12


def test_perspective_errors():
    with pytest.raises(ValueError, match="above 0"):
        texmap.perspective_interpolate([[0], [1]], [1.0, -1.0], 0.5)
    with pytest.raises(ValueError, match="w: expected"):
        texmap.perspective_interpolate([[0]], [1.0], 0.5)


def test_warp_is_that_of_the_program(program, tmp_path, assets, rng):
    image = rng.integers(0, 255, (40, 60, 3), dtype=np.uint8)
    texmap._picture.write_png(tmp_path / "in.png", image)
    corners = [(5, 4), (55, 8), (50, 36), (8, 30)]
    points = [f"{x},{y}" for x, y in corners]
    program("warp", tmp_path / "in.png", "--from", *points, "--size", "80x50", "-o", tmp_path / "out.png")
    found = texmap.warp(image, source=corners, size=(80, 50))
    assert found.shape == (50, 80, 4)
    assert program("hash", tmp_path / "out.png").split()[0] == texmap.pixel_hash(found)


def test_warp_by_matrix_and_kinds(rng):
    image = rng.uniform(size=(20, 30, 3)).astype(np.float32)
    shift = np.array([[1.0, 0, 4], [0, 1, 2], [0, 0, 1]])
    moved = texmap.warp(image, shift, filter="bilinear", outside="edge")
    assert moved.shape == image.shape and np.abs(moved[2:, 4:] - image[:-2, :-4]).max() < 1e-6
    assert texmap.warp(image, shift).shape == (20, 30, 4) and not texmap.warp(image, shift)[:2].any()
    h = texmap.homography([(0, 0), (1, 0), (1, 1), (0, 1)], [(2, 1), (4, 1), (4, 3), (2, 3)])
    assert np.allclose(h / h[2, 2], [[2, 0, 2], [0, 2, 1], [0, 0, 1]])
    for bad in (np.zeros((3, 3)), np.eye(2)):
        with pytest.raises(ValueError):
            texmap.warp(image, bad)
    with pytest.raises(ValueError, match="convex"):
        texmap.homography([(0, 0), (1, 0), (0.5, 0), (0, 1)], [(0, 0), (1, 0), (1, 1), (0, 1)])


def test_diff_has_the_figures_of_the_program(program, tmp_path, rng):
    one = rng.integers(0, 255, (30, 40, 4), dtype=np.uint8)
    two = one.copy()
    two[3, 5, 1] ^= 64
    for name, image in (("a", one), ("b", two)):
        texmap._picture.write_png(tmp_path / f"{name}.png", image)
    report = json.loads(program("diff", tmp_path / "a.png", tmp_path / "b.png", "--json", code=1))
    found = texmap.diff(one, two)
    assert found["max"] == pytest.approx(64 / 255) and found["max_at"] == (5, 3, 1) and not found["passes"]
    for name in ("mean", "rms", "p999", "max", "psnr", "ssim"):
        assert found[name] == report[name]
    assert texmap.diff(one, one)["passes"] and texmap.diff(one, two, limit=0.3)["passes"]
    floats = rng.normal(size=(9, 11)).astype(np.float32)
    assert texmap.diff(floats, floats + 1)["mean"] == pytest.approx(1, abs=1e-6)
    with pytest.raises(ValueError, match="differ"):
        texmap.diff(one, two[:5])


def test_pixel_hash_is_fnv1a_128():
    expected, prime = 0x6C62272E07BB014262B821756295C58D, (1 << 88) + 0x13B
    image = np.arange(24, dtype=np.uint8).reshape(2, 3, 4)
    for byte in (3).to_bytes(4, "little") + (2).to_bytes(4, "little") + image.tobytes():
        expected = ((expected ^ byte) * prime) % (1 << 128)
    assert texmap.pixel_hash(image) == f"fnv1a-128:{expected:032x}"


def test_environments_keep_their_light(rng):
    sky = np.ones((32, 64, 3), np.float32) * [0.2, 0.4, 0.8]
    cube = texmap.env(sky, "cube")
    assert cube.shape[0] == 6 and np.allclose(cube, [0.2, 0.4, 0.8], atol=1e-5)
    assert np.allclose(texmap.env(cube, "lat-long", layout="cube", size=16), [0.2, 0.4, 0.8], atol=1e-5)
    sky[:16] = 5.0
    blurred = texmap.env(sky, "lat-long", blur=5.0, size=8)
    assert blurred.shape == (8, 16, 3) and blurred[0].mean() > blurred[4].mean() > blurred[7].mean()
    with pytest.raises(ValueError, match="layout"):
        texmap.env(sky, "ball")
    with pytest.raises(ValueError):
        texmap.env(sky[:, :50], "cube")


def test_a_bake_is_lambert(rng):
    square = np.array([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], np.float32)
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    tilt = np.radians(60)
    light = texmap.Light("directional", (1, 1, 1), direction=(np.sin(tilt), -np.cos(tilt), 0))
    floor = texmap.Mesh(square, [[0, 1, 2], [0, 2, 3]], uv, name="floor")
    scene = texmap.Scene([floor], lights=[light])
    assert np.allclose(texmap.bake(scene, "floor", 16, shadow_size=0), 0.5, atol=1e-5)
    points, faces = icosphere(1)
    ball = texmap.Mesh(points * 0.3 + [0, 0.5, 0], faces)
    shaded = texmap.bake(texmap.Scene([floor, ball], lights=[light]), 0, 64)
    assert shaded.min() < 0.01 and shaded.max() == pytest.approx(0.5, abs=1e-5)
    with pytest.raises(ValueError, match="choose from floor"):
        texmap.bake(scene, "roof")


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_more_than_four_channels_are_data(rng, kind):
    image = rng.integers(0, 200, (4, 4, 5)).astype(kind)
    with pytest.raises(ValueError, match="color='srgb': .*5 channels"):
        texmap.Texture(image, color="srgb")
    scale = 1 if kind == np.float32 else np.iinfo(kind).max
    for made in (texmap.Texture(image), texmap.Texture(image, color="linear", alpha="straight")):
        assert np.abs(made.level(0)[::-1] - image / scale).max() < 1e-5


@pytest.mark.parametrize("channels", [3, 4, 5])
def test_words_for_alpha_are_checked(channels):
    with pytest.raises(ValueError, match="alpha='strait': know straight, premultiplied, data"):
        texmap.Texture(np.zeros((4, 4, channels), np.float32), alpha="strait")
