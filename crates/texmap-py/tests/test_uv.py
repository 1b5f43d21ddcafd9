"""Texture coordinates of meshes."""

import numpy as np
import pytest
from conftest import icosphere

import texmap


def test_unwrap_has_no_overlaps_and_keeps_the_mesh():
    points, faces = icosphere(2)
    found = texmap.unwrap(points, faces, size=512)
    assert found.faces.shape == faces.shape and found.uv.shape == (len(found.vertex_map), 2)
    assert np.array_equal(found.vertex_map[found.faces], faces)
    assert found.uv.min() >= 0 and found.uv.max() <= 1
    report = texmap.uv_report(points[found.vertex_map], found.faces, found.uv, views=False)
    assert report["overlapping"] == 0 and report["flipped"] == 0 and report["stretch_l2"] < 1.5
    assert report.triangles["area"].shape == (len(faces),) and "<table>" in report._repr_html_()
    again = texmap.unwrap(points, faces, size=512, threads=1)
    assert all(np.array_equal(a, b) for a, b in zip(found, again))


def test_a_broken_map_is_seen_by_the_report():
    points, faces = icosphere(1)
    flat = points[:, :2] * 0.5 + 0.5  # front and back on top of each other
    report = texmap.uv_report(points, faces, flat, views=False)
    assert report["overlapping"] > 0 and report["flipped"] > 0


@pytest.mark.parametrize("shape", ["plane", "cylinder", "cone", "sphere", "box"])
def test_shapes_map_every_vertex(shape):
    points, faces = icosphere(2)
    found = texmap.uv_map(points, faces, shape=shape)
    assert np.array_equal(found.vertex_map[found.faces], faces) and np.isfinite(found.uv).all()
    if shape == "sphere":
        # v is the latitude, from the bottom.
        latitude = np.arcsin(np.clip(points[found.vertex_map, 1], -1, 1)) / np.pi + 0.5
        assert np.abs(found.uv[:, 1] - latitude).max() < 1e-4
        top = texmap.uv_map(points, faces, shape=shape, origin="top-left")
        assert np.abs(1 - top.uv[:, 1] - found.uv[:, 1]).max() < 1e-5


def test_tangents_follow_u():
    points = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    uv = points[:, [1, 0]]  # u along y: mirrored
    found = texmap.tangents(points, faces, uv)
    assert found.shape == (2, 3, 4) and np.allclose(found[..., :3], [0, 1, 0], atol=1e-6) and (found[..., 3] == -1).all()
    assert (texmap.tangents(points, faces, points[:, :2])[..., 3] == 1).all()


def test_uv_raster_places_points_where_uv_says(rng):
    points = rng.normal(size=(3, 3)).astype(np.float32)
    uv = np.array([[0.1, 0.1], [0.9, 0.2], [0.3, 0.8]], np.float32)
    found = texmap.uv_raster(uv, [[0, 1, 2]], (40, 30), positions=points)
    rows, columns = np.nonzero(found["face"] == 0)
    weights = found["barycentric"][rows, columns]
    assert (found["coverage"][rows, columns] == 1).all() and len(rows) > 100
    at = weights @ uv
    assert np.abs(at[:, 0] - (columns + 0.5) / 40).max() < 1e-4
    assert np.abs(at[:, 1] - (1 - (rows + 0.5) / 30)).max() < 1e-4
    assert np.abs(found["position"][rows, columns] - weights @ points).max() < 1e-4
    free = found["face"] == 0xFFFFFFFF
    wide = texmap.uv_raster(uv, [[0, 1, 2]], (40, 30), gutter=2, conservative=True)
    assert (wide["face"] == 0xFFFFFFFF).sum() < free.sum() and {1, 2, 3} <= set(np.unique(wide["coverage"]))


def test_a_whole_mesh_is_read_from_its_own_origin(rng):
    points = rng.normal(size=(3, 3)).astype(np.float32)
    faces, uv = [[0, 1, 2]], np.array([[0.1, 0.1], [0.9, 0.2], [0.3, 0.8]], np.float32)
    low = texmap.Mesh(points, faces, uv)
    high = texmap.Mesh(points, faces, uv * [1, -1] + [0, 1], uv_origin="top-left")
    drawn = [texmap.uv_raster(mesh, size=32)["face"] for mesh in (low, high)]
    assert np.array_equal(*drawn) and not np.array_equal(drawn[0], drawn[0][::-1])
    assert np.array_equal(texmap.uv_raster(high, size=32, origin="bottom-left")["face"], drawn[0][::-1])
    assert np.array_equal(texmap.uv_raster(high.uv, faces, 32)["face"], drawn[0][::-1])
    flipped = [texmap.uv_report(mesh, views=False)["flipped"] for mesh in (low, high)]
    assert flipped == [0, 0] and texmap.uv_report(high, views=False, origin="bottom-left")["flipped"] == 1


def test_uv_raster_names_lost_faces():
    uv = np.array([[0.1, 0.1], [0.9, 0.1], [0.5, 0.9], [0.001, 0.001], [0.002, 0.001], [0.001, 0.002]], np.float32)
    faces = [[0, 1, 2], [3, 4, 5]]
    assert texmap.uv_raster(uv, faces, 16)["lost"].tolist() == [1]
    assert texmap.uv_raster(uv, faces, 16, conservative=True)["lost"].tolist() == []


def test_errors():
    points, faces = icosphere(1)
    for call, words in [
        (lambda: texmap.unwrap(points[:, :2], faces), "vertices: expected shape"),
        (lambda: texmap.unwrap(points, faces + 100), "vert|position|index"),
        (lambda: texmap.uv_map(points, faces, shape="torus"), "know plane"),
        (lambda: texmap.uv_report(points, faces, np.zeros((3, 2))), "uv: expected shape"),
        (lambda: texmap.uv_raster(np.zeros((3, 2)), [[0, 1, 5]], 8), "5"),
        (lambda: texmap.uv_report((points, faces)), "texmap.unwrap"),
        (lambda: texmap.unwrap(points, faces, origin="middle"), "origin"),
    ]:
        with pytest.raises(ValueError, match=words):
            call()
