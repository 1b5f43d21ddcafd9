"""Anisotropic filtering on steep planes against OpenImageIO's at each of its widths: whose mean of a pixel is nearer to the texture's own."""

import numpy as np
import pytest

import texmap

oiio = pytest.importorskip("OpenImageIO")

SIDE, WIDTH, HEIGHT = 512, 80, 48
TEXTURES = ("noise", "text", "checker", "photo")
PLANES = [(6, 30), (12, 0), (12, 45), (25, 30), (40, 10)]


@pytest.fixture(scope="module")
def textures(tmp_path_factory, assets):
    """Name to (texels (SIDE, SIDE, 1), the file of OpenImageIO with levels of 2 x 2 means)."""
    image = pytest.importorskip("PIL.Image")
    draw, font = pytest.importorskip("PIL.ImageDraw"), pytest.importorskip("PIL.ImageFont")
    page = image.new("L", (SIDE, SIDE), 255)
    for row in range(0, SIDE, 18):
        words = "".join(chr(97 + (row * 7 + k * k) % 26) if (row + k) % 6 else " " for k in range(SIDE // 5))
        draw.Draw(page).text((0, row), words, fill=0, font=font.load_default())
    brick = image.open(assets / "textures/brick.png").convert("L").resize((SIDE, SIDE))
    y, x = np.indices((SIDE, SIDE))
    values = {
        "noise": np.random.default_rng(3).uniform(size=(SIDE, SIDE)),
        "text": np.asarray(page) / 255,
        "checker": (y // 16 + x // 16) % 2,
        "photo": np.asarray(brick) / 255,
    }
    folder, config = tmp_path_factory.mktemp("steep"), oiio.ImageSpec()
    config.set_format("float")
    config.attribute("maketx:filtername", "box")
    made = {}
    for name, texels in values.items():
        texels = np.ascontiguousarray(texels[..., None], np.float32)
        path = str(folder / f"{name}.tx")
        assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, oiio.ImageBuf(texels), path, config), oiio.geterror()
        made[name] = texels, path
    return made


def plane(elevation, turn):
    """The function from pixels to coordinates of a plane under an eye that looks down by `elevation` degrees. Row 0 is at t = 0."""
    sin, cos = np.sin(np.radians([elevation, turn])), np.cos(np.radians([elevation, turn]))

    def coordinates(x, y):
        across, up = (x - WIDTH / 2) / (0.9 * WIDTH), (HEIGHT / 2 - y) / (0.9 * WIDTH)
        with np.errstate(divide="ignore", invalid="ignore"):
            away = 1 / (sin[0] - up * cos[0])
        x, z = away * across, away * (cos[0] + up * sin[0])
        return 0.45 * np.stack([cos[1] * x - sin[1] * z, sin[1] * x + cos[1] * z], -1)

    return coordinates


def bilinear(texels, st):
    """Texels of a repeated texture between texel centres, in f64."""
    at = st * SIDE - 0.5
    low = np.floor(at)
    part, low = at - low, low.astype(int) % SIDE
    high = (low + 1) % SIDE
    (x, y), (x0, y0), (x1, y1) = part.T, low.T, high.T
    t = texels[..., 0].astype(float)
    return ((t[y0, x0] * (1 - x) + t[y0, x1] * x) * (1 - y) + (t[y1, x0] * (1 - x) + t[y1, x1] * x) * y).T


@pytest.mark.parametrize("elevation, turn", PLANES)
def test_no_width_of_openimageio_is_nearer(textures, elevation, turn):
    at = plane(elevation, turn)
    y, x = (np.indices((HEIGHT, WIDTH)) + 0.5).reshape(2, -1)
    step = 1e-4
    dx = (at(x + step, y) - at(x - step, y)) / (2 * step)
    dy = (at(x, y + step) - at(x, y - step)) / (2 * step)
    # Footprints of at least a texel that 16 probes cover.
    major, minor = np.linalg.svd(np.stack([dx, dy], -1) * SIDE, compute_uv=False).T
    below = (HEIGHT / 2 - y) / (0.9 * WIDTH) < np.tan(np.radians(elevation)) - 0.02
    kept = below & (major > 1) & (major < 100) & (major <= 16 * np.maximum(minor, 1))
    x, y, dx, dy = x[kept], y[kept], dx[kept], dy[kept]
    st = at(x, y)
    uv = np.stack([st[:, 0], 1 - st[:, 1]], -1).astype(np.float32)
    duv = np.stack([dx[:, 0], dy[:, 0], -dx[:, 1], -dy[:, 1]], -1).astype(np.float32)
    system, offsets = oiio.TextureSystem(False), (np.arange(16) + 0.5) / 16 - 0.5
    for name in TEXTURES:
        texels, path = textures[name]
        mean = np.mean([bilinear(texels, at(x + i, y + j)) for i in offsets for j in offsets], 0)

        def error(found):
            return float(np.sqrt(np.mean((found - mean) ** 2)))

        def theirs(width):
            options = oiio.TextureOpt()
            options.swrap = options.twrap = oiio.Wrap.Periodic
            options.interpmode, options.mipmode = oiio.InterpMode.Bilinear, oiio.MipMode.Aniso
            options.anisotropic, options.swidth, options.twidth = 16, width, width
            look_ups = zip(st.tolist(), dx.tolist(), dy.tolist())
            return [system.texture(path, options, *p, *a, *b, 1)[0] for p, a, b in look_ups]

        ours = error(texmap.sample(texels, uv, duv, filter="anisotropic:16")[:, 0])
        least = min(error(theirs(width)) for width in (0.6, 0.7, 0.8, 0.9, 1.0))
        assert ours < least, (name, ours, least)
        # One round probe a pixel blurs what the footprint is narrower in.
        assert error(texmap.sample(texels, uv, duv, filter="trilinear")[:, 0]) > 1.3 * ours, name
