"""Paths and inputs of the tests."""

import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(os.environ.get("TEXMAP_ROOT", pathlib.Path(__file__).resolve().parents[3]))


@pytest.fixture(scope="session")
def assets():
    """The folder of models, scenes and textures."""
    return ROOT / "assets"


@pytest.fixture
def program():
    """Runs the program of the installed package and returns its standard output."""

    def run(*arguments, code=0):
        done = subprocess.run([sys.executable, "-m", "texmap", *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == code, done.stderr
        return done.stdout

    return run


@pytest.fixture
def rng():
    """Random numbers, the same in each run."""
    return np.random.default_rng(7)


def icosphere(rounds=2):
    """A closed mesh: unit vertices and faces of a subdivided octahedron, counter-clockwise from outside."""
    points = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    points = [np.array(p, float) for p in points]
    for _ in range(rounds):
        middle, split = {}, []

        def between(a, b):
            key = (min(a, b), max(a, b))
            if key not in middle:
                p = points[a] + points[b]
                points.append(p / np.linalg.norm(p))
                middle[key] = len(points) - 1
            return middle[key]

        for a, b, c in faces:
            d, e, f = between(a, b), between(b, c), between(c, a)
            split += [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]
        faces = split
    return np.array(points, np.float32), np.array(faces, np.int32)


def clip_from_world(eye=(0, 0, 3), near=0.5, far=10.0, fov=50.0, aspect=1.0):
    """A matrix as OpenGL has it: from world to clip space, looking along -z from ``eye``."""
    f = 1 / np.tan(np.radians(fov) / 2)
    projection = np.array(
        [
            [f / aspect, 0, 0, 0],
            [0, f, 0, 0],
            [0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)],
            [0, 0, -1, 0],
        ]
    )
    view = np.eye(4)
    view[:3, 3] = -np.asarray(eye, float)
    return projection @ view


def to_clip(matrix, vertices):
    """(1, n, 4) float32 clip positions."""
    homogeneous = np.concatenate([vertices, np.ones((len(vertices), 1))], axis=1)
    return (homogeneous @ matrix.T).astype(np.float32)[None]
