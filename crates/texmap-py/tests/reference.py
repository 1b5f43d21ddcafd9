"""Slow f64 references that share no code with the package."""

import numpy as np


def rasterize(pos, tri, height, width):
    """(H, W, 4) u, v, z/w, id + 1; (H, W, 4) derivatives; (H, W) distance in pixels from the centre to the nearest edge of any triangle.

    Every pixel is tested against every triangle: edge functions of divided vertices, barycentrics over w, derivatives by the quotient
    rule. Triangles must lie before the near plane and within the depth range.
    """
    pos = np.asarray(pos, np.float64)
    rast, db = np.zeros((height, width, 4)), np.zeros((height, width, 4))
    margin, nearest = np.full((height, width), np.inf), np.full((height, width), np.inf)
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    for number, corners in enumerate(tri):
        clip = pos[corners]
        w = clip[:, 3]
        screen = (clip[:, :2] / w[:, None] + 1) * 0.5 * [width, height]
        depth = clip[:, 2] / w
        (ax, ay), (bx, by) = screen[1] - screen[0], screen[2] - screen[0]
        area = ax * by - ay * bx
        if area == 0:
            continue
        planes = []
        for k in range(3):
            a, b = screen[(k + 1) % 3], screen[(k + 2) % 3]
            d = b - a
            edge = d[0] * (y - a[1]) - d[1] * (x - a[0])
            # The distance to the segment, so that far parts of an edge's line do not count.
            t = np.clip(((x - a[0]) * d[0] + (y - a[1]) * d[1]) / (d @ d), 0, 1)
            margin = np.minimum(margin, np.hypot(x - a[0] - t * d[0], y - a[1] - t * d[1]))
            planes.append((edge / area, -d[1] / area, d[0] / area))
        inside = (planes[0][0] >= 0) & (planes[1][0] >= 0) & (planes[2][0] >= 0)
        z = sum(p[0] * d for p, d in zip(planes, depth))
        seen = inside & (z < nearest)
        over = [(value / wk, dx / wk, dy / wk) for (value, dx, dy), wk in zip(planes, w)]
        total = [sum(o[k] for o in over) for k in range(3)]
        values = [o[0] / total[0] for o in over[:2]]
        slopes = [(o[k] - v * total[k]) / total[0] for o, v in zip(over, values) for k in (1, 2)]
        nearest[seen] = z[seen]
        for k, value in enumerate([*values, z, np.full_like(z, number + 1)]):
            rast[..., k][seen] = value[seen]
        for k, slope in enumerate(slopes):
            db[..., k][seen] = slope[seen]
    return rast, db, margin


def texture(tex, uv, mode, boundary, lod=None):
    """Look-ups in (H, W, C) at (n, 2), row 0 at v = 0, with levels of detail (n,)."""
    levels = [np.asarray(tex, np.float64)]
    while "mipmap" in mode and max(levels[-1].shape[:2]) > 1:
        t = levels[-1]
        t = (t[0::2] + t[1::2]) / 2 if t.shape[0] > 1 else t
        levels.append((t[:, 0::2] + t[:, 1::2]) / 2 if t.shape[1] > 1 else t)

    def fetch(t, x, y):
        height, width = t.shape[:2]
        if boundary == "wrap":
            return t[y % height, x % width]
        inside = ((x >= 0) & (x < width) & (y >= 0) & (y < height))[:, None]
        clamped = t[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
        return clamped if boundary == "clamp" else np.where(inside, clamped, 0.0)

    def linear(t, uv):
        height, width = t.shape[:2]
        x, y = uv[:, 0] * width - 0.5, uv[:, 1] * height - 0.5
        x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
        fx, fy = (x - x0)[:, None], (y - y0)[:, None]
        low = fetch(t, x0, y0) * (1 - fx) + fetch(t, x0 + 1, y0) * fx
        high = fetch(t, x0, y0 + 1) * (1 - fx) + fetch(t, x0 + 1, y0 + 1) * fx
        return low * (1 - fy) + high * fy

    uv = np.asarray(uv, np.float64)
    if mode == "nearest":
        height, width = levels[0].shape[:2]
        return fetch(levels[0], np.floor(uv[:, 0] * width).astype(int), np.floor(uv[:, 1] * height).astype(int))
    if mode == "linear":
        return linear(levels[0], uv)
    lod = np.clip(lod, 0, len(levels) - 1)
    every = np.stack([linear(t, uv) for t in levels])
    at = np.arange(len(uv))
    if mode == "linear-mipmap-nearest":
        return every[np.clip(np.ceil(lod + 0.5) - 1, 0, None).astype(int), at]
    low = np.floor(lod).astype(int)
    high, part = np.minimum(low + 1, len(levels) - 1), (lod - low)[:, None]
    return every[low, at] * (1 - part) + every[high, at] * part
