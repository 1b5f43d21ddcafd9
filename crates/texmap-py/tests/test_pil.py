"""PIL images of every mode: the values that the same picture has as a file or array."""

import numpy as np
import pytest

import texmap

image_module = pytest.importorskip("PIL.Image")


def texels(image):
    """The texels from the top, as data of linear colour space."""
    return texmap.Texture(image, color="linear", origin="top-left").level(0)


@pytest.mark.parametrize("mode", ["I;16", "I;16B", "I;16L"])
def test_16_bits_are_kept(rng, mode):
    words = rng.integers(0, 65535, (4, 6), dtype=np.uint16)
    stored = words.astype(">u2" if mode == "I;16B" else "<u2").tobytes()
    found = texels(image_module.frombytes(mode, (6, 4), stored))
    assert found.shape == (4, 6, 1) and np.abs(found[..., 0] - words / 65535).max() < 1e-6


def test_mode_i_is_16_bits_or_refused(rng):
    words = rng.integers(0, 65535, (4, 6)).astype(np.int32)
    assert np.abs(texels(image_module.fromarray(words))[..., 0] - words / 65535).max() < 1e-6
    for beyond in (words - 1 - words.min(), words + 65536):
        with pytest.raises(ValueError, match="mode I"):
            texmap.Texture(image_module.fromarray(beyond.astype(np.int32)))


def test_floats_are_linear_light(rng):
    light = (rng.random((4, 6)) * 3).astype(np.float32)
    found = texmap.Texture(image_module.fromarray(light), origin="top-left").level(0)
    assert np.array_equal(found[..., 0], light)
    assert np.array_equal(texmap.warp(image_module.fromarray(light), np.eye(3), filter="nearest", outside="edge")[..., 0], light)


@pytest.mark.parametrize("mode", ["L", "RGB", "P"])
def test_a_transparent_colour_is_alpha_as_in_the_file(tmp_path, mode):
    grey = (np.arange(24, dtype=np.uint8) * 10).reshape(4, 6)
    image = image_module.fromarray(np.dstack([grey, grey, 255 - grey]))
    image = image.convert(mode) if mode != "RGB" else image
    key = image.getpixel((2, 1))
    image.save(tmp_path / "keyed.png", transparency=key)
    opened = image_module.open(tmp_path / "keyed.png")
    assert opened.mode == mode and "transparency" in opened.info
    found, expected = texels(opened), texels(tmp_path / "keyed.png")
    assert found.shape[2] == 4 and found[1, 2, 3] == 0 and np.array_equal(found, expected)
    assert found[..., 3].sum() == 23


def test_premultiplied_modes_keep_their_alpha():
    straight = image_module.new("RGBA", (4, 4), (200, 100, 40, 128))
    found = texels(straight.convert("RGBa"))
    assert found.shape == (4, 4, 4) and np.abs(found - texels(straight)).max() < 0.01
    grey = image_module.new("LA", (4, 4), (200, 128))
    found = texels(grey.convert("La"))
    assert found.shape == (4, 4, 2) and np.abs(found - texels(grey)).max() < 0.01


@pytest.mark.parametrize("mode", ["CMYK", "YCbCr", "HSV", "1"])
def test_other_modes_are_converted(mode):
    image = image_module.new("RGB", (4, 4), (255, 255, 255)).convert(mode)
    assert np.abs(texels(image) - 1).max() < 0.01 and texels(image).shape == (4, 4, 3)
