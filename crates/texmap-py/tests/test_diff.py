"""`texmap.diff` against the program, and of arrays that no file of the program holds."""

import json

import numpy as np
import pytest

import texmap


def agrees(program, one, two):
    """The figures of two files, which are those of the program."""
    found = texmap.diff(one, two)
    report = json.loads(program("diff", one, two, "--json", code=0 if found["passes"] else 1))
    assert report["pass"] == found["passes"]
    for key in ("mean", "rms", "p999", "max", "over_limit"):
        assert report[key] == found[key], key
    assert (report.get("alpha") or {}).get("max") == (found["alpha"] or {}).get("max")
    return found


def test_files_are_compared_as_by_the_program(program, tmp_path, rng):
    image_module = pytest.importorskip("PIL.Image")
    codes = rng.integers(0, 255, (12, 16, 4), dtype=np.uint8)
    words = rng.integers(0, 65535, (12, 16), dtype=np.uint16)

    def saved(name, array):
        image_module.fromarray(array).save(tmp_path / name)
        return tmp_path / name

    grey16, other16 = saved("a16.png", words), saved("b16.png", words ^ np.uint16(4096))
    assert agrees(program, grey16, other16)["max"] == 4096 / 65535
    rgba, rgb = saved("rgba.png", codes), saved("rgb.png", codes[..., :3])
    assert agrees(program, rgb, rgba)["alpha"]["max"] > 0.9
    grey = saved("grey.png", codes[..., 0])
    agrees(program, grey, rgb)
    agrees(program, grey, grey16)
    # An array beside a file is an image, too.
    assert texmap.diff(rgba, codes)["passes"] and texmap.diff(words, grey16)["passes"]
    assert texmap.diff(image_module.open(rgb), codes[..., :3])["passes"]
    with pytest.raises(ValueError, match="unlike kinds"):
        texmap.diff(rgba, codes.astype(np.float32))
    np.save(tmp_path / "a.npy", codes)
    np.save(tmp_path / "b.npy", codes ^ np.uint8(16))
    assert agrees(program, tmp_path / "a.npy", tmp_path / "b.npy")["max"] == 16


def test_doubles_are_compared_as_they_are():
    one = np.full((12, 12, 3), 1.0)
    two = one.copy()
    two[3, 2, 1] += 1e-12
    found = texmap.diff(one, two)
    assert not found["passes"] and found["max_at"] == (2, 3, 1) and 0 < found["max"] < 2e-12 and found["ssim"] == 1.0
    assert texmap.diff(one, two, limit=1e-11)["passes"]
    assert texmap.diff(one, one.astype(np.float32))["passes"] and not texmap.diff(two.astype(np.float32), two)["passes"]
    assert not texmap.diff(np.float64(1), np.float64(1 + 1e-12))["passes"]
    stacked = np.zeros((2, 3, 4, 5))
    changed = stacked.copy()
    changed[1, 2, 3, 4] = np.nan
    assert texmap.diff(stacked, changed)["non_finite"] == 1
    faces = np.array([[1, 0xFFFFFFFF]], np.uint32)
    assert texmap.diff(faces, faces)["passes"] and texmap.diff(faces, faces - np.uint32(1))["max"] == 1


def test_limits_and_types_are_checked():
    one = np.zeros((2, 2, 3), np.uint8)
    for limit in (float("nan"), -0.1):
        with pytest.raises(ValueError, match="limit="):
            texmap.diff(one, one + 1, limit=limit)
    assert texmap.diff(one, one + 1, limit=float("inf"))["passes"]
    for other in (np.zeros((2, 3, 3), np.uint8), np.zeros((2, 2, 3), np.uint16), np.zeros((2, 2, 3), np.int64)):
        with pytest.raises(ValueError):
            texmap.diff(one, other)
