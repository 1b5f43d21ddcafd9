"""texmap.dr.texture and texmap.sample against OpenImageIO's texture system and image buffers, where its package is installed."""

import numpy as np
import pytest

import texmap
import texmap.dr as dr

oiio = pytest.importorskip("OpenImageIO")

SIDE = 32
WRAPS = {"wrap": "Periodic", "clamp": "Clamp", "zero": "Black"}


@pytest.fixture(scope="module")
def tex():
    return np.random.default_rng(11).uniform(size=(SIDE, SIDE, 3)).astype(np.float32)


@pytest.fixture(scope="module")
def look_up(tex, tmp_path_factory):
    """Look-ups in the texture with mip levels that are means of 2 x 2 texels: (n, 3). Row 0 is at t = 0, as in ``texmap.dr``."""
    path = str(tmp_path_factory.mktemp("oiio") / "texture.tx")
    config = oiio.ImageSpec()
    config.set_format("float")
    config.attribute("maketx:filtername", "box")
    assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, oiio.ImageBuf(tex), path, config), oiio.geterror()
    system = oiio.TextureSystem(False)

    def run(uv, wrap, interpolation, mip="NoMIP", width=0.0):
        options = oiio.TextureOpt()
        options.swrap = options.twrap = getattr(oiio.Wrap, WRAPS[wrap])
        options.interpmode = getattr(oiio.InterpMode, interpolation)
        options.mipmode = getattr(oiio.MipMode, mip)
        found = [system.texture(path, options, float(s), float(t), width, 0.0, 0.0, width, 3) for s, t in uv]
        assert not system.has_error(), system.geterror()
        return np.array(found, np.float32)

    return run


def points(rng, count=200):
    """Coordinates of which none lies within a hundredth of a texel of an edge or a centre."""
    texel = rng.integers(-SIDE // 2, 3 * SIDE // 2, (count, 2))
    part = rng.choice([rng.uniform(0.01, 0.49, (count, 2)), rng.uniform(0.51, 0.99, (count, 2))])
    return ((texel + part) / SIDE).astype(np.float32)


def by_dr(tex, uv, mode, boundary, width=None):
    da = None if width is None else np.tile(np.array([width, 0, 0, width], np.float32), (1, 1, len(uv), 1))
    return dr.texture(tex[None], uv[None, None], da, filter_mode=mode, boundary_mode=boundary)[0, 0]


@pytest.mark.parametrize("boundary", WRAPS)
@pytest.mark.parametrize("mode, interpolation", [("nearest", "Closest"), ("linear", "Bilinear")])
def test_one_level_is_openimageio(look_up, tex, rng, mode, interpolation, boundary):
    uv = points(rng)
    expected, found = look_up(uv, boundary, interpolation), by_dr(tex, uv, mode, boundary)
    assert np.abs(expected - found).max() < 2e-5
    other = by_dr(tex, uv, "linear" if mode == "nearest" else "nearest", boundary)
    assert np.abs(expected - other).max() > 0.1


@pytest.mark.parametrize("boundary", WRAPS)
@pytest.mark.parametrize("mode, mip", [("linear-mipmap-nearest", "OneLevel"), ("linear-mipmap-linear", "Trilinear")])
@pytest.mark.parametrize("level", [0, 1, 2, 3])
def test_whole_levels_are_openimageio(look_up, tex, rng, mode, mip, boundary, level):
    uv = points(rng)
    width = 2.0**level / SIDE
    expected, found = look_up(uv, boundary, "Bilinear", mip, width), by_dr(tex, uv, mode, boundary, width)
    assert np.abs(expected - found).max() < 2e-5
    assert np.abs(expected - by_dr(tex, uv, mode, boundary, 2 * width)).max() > 0.02


@pytest.mark.parametrize("part", [0.125, 0.5, 0.8])
def test_between_levels_is_openimageio_by_its_blend(look_up, tex, rng, part):
    # It blends two levels in the width of the footprint, from 1 to 2 texels; texmap, as OpenGL, in the logarithm of the width.
    uv = points(rng)
    expected = look_up(uv, "wrap", "Bilinear", "Trilinear", 2 * (1 + part) / SIDE)
    found = by_dr(tex, uv, "linear-mipmap-linear", "wrap", 2 * 2.0**part / SIDE)
    assert np.abs(expected - found).max() < 5e-5
    assert np.abs(expected - by_dr(tex, uv, "linear-mipmap-linear", "wrap", 2 * 2.0 ** (1 - part / 2) / SIDE)).max() > 1e-3


@pytest.mark.parametrize("wrap, name", [("repeat", "periodic"), ("clamp-to-edge", "clamp"), ("mirrored-repeat", "mirror")])
def test_sample_is_an_image_buffer(tex, rng, wrap, name):
    uv = points(rng)
    buffer = oiio.ImageBuf(tex)
    expected = np.array([buffer.interppixel_NDC(float(s), float(t), name) for s, t in uv])
    found = texmap.sample(texmap.Texture(tex, origin="top-left"), uv, filter="bilinear", wrap=wrap)
    assert np.abs(expected - found).max() < 2e-5
