"""Scenes and pictures: the bytes of the program, batches, cameras, errors."""

import json
import os
import subprocess
import sys
import threading
import warnings

import numpy as np
import pytest
from conftest import icosphere

import texmap


def the_hash(program, tmp_path, *arguments):
    report = json.loads(program("render", *arguments, "-o", tmp_path / "picture.png", "--json", "--quiet"))
    found = []

    def walk(value):
        if isinstance(value, dict):
            found.extend(v for k, v in value.items() if k == "pixel_hash")
            [walk(v) for v in value.values()]
        elif isinstance(value, list):
            [walk(v) for v in value]

    walk(report)
    return found[0]


@pytest.mark.parametrize("name", ["scenes/purple_cow.scene", "scenes/shadows.scene", "models/house.obj", "gltf/materials.glb", "models/cube.stl"])
def test_hash_is_that_of_the_program(program, tmp_path, assets, name):
    expected = the_hash(program, tmp_path, assets / name, "--resolution", "200x150")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", texmap.TexmapWarning)
        frame = texmap.load(assets / name).render(size=(200, 150))
    assert frame.hash == expected
    assert texmap.pixel_hash(frame.rgba[::-1]) != expected
    frame.save(tmp_path / "mine.png")
    assert program("hash", tmp_path / "mine.png").split()[0].strip() == expected


def test_options_are_those_of_the_program(program, tmp_path, assets):
    model = assets / "models" / "house.obj"
    expected = the_hash(program, tmp_path, model, "--resolution", "120x90", "--view", "front", "--filter", "nearest", "--msaa", "1")
    assert texmap.render(model, "front", (120, 90), filter="nearest", samples=1).hash == expected


def test_any_number_of_threads_gives_the_same_bytes(assets):
    scene = texmap.load(assets / "models" / "house.obj")
    frames = [scene.render(size=(150, 100), threads=n, aovs=["normal", "face"]) for n in (1, 2, None)]
    for frame in frames[1:]:
        assert all(np.array_equal(frame[key], frames[0][key], equal_nan=key == "normal") for key in frame)


def looking_at(eye, target=(0, 0, 0), up=(0, 1, 0)):
    """A camera-to-world matrix with OpenGL axes."""
    back = np.subtract(eye, target) / np.linalg.norm(np.subtract(eye, target))
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :4] = np.stack([right, np.cross(back, right), back, eye], axis=1)
    return pose


def test_batch_equals_single_pictures(assets):
    scene = texmap.load(assets / "models" / "cow.obj")
    angles = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    poses = np.stack([looking_at((12 * np.sin(a), 3, 12 * np.cos(a))) for a in angles])
    k = np.array([[70.0, 0, 32], [0, 70, 24], [0, 0, 1]])
    all_at_once = scene.render(texmap.Poses(poses, "opengl", K=k), (64, 48), aovs=["depth", "face"])
    assert all_at_once.rgba.shape == (100, 48, 64, 4) and all_at_once["face"].dtype == np.uint32
    hashes = set()
    for i in range(100):
        one = scene.render(texmap.Poses(poses[i], "opengl", K=k), (64, 48), aovs=["depth", "face"])
        hashes.add(one.hash)
        assert all(np.array_equal(one[key], all_at_once[key][i], equal_nan=key == "depth") for key in one)
    assert len(hashes) == 100


@pytest.mark.parametrize("count", [1, 2, 7])
def test_threads_that_draw_poses_change_no_byte(assets, count):
    # Warnings come in the order of the poses, too: every second camera looks away.
    scene = texmap.load(assets / "models" / "house.obj")
    poses = np.stack([looking_at((9 * np.sin(a), 3, 9 * np.cos(a))) for a in np.arange(count)])
    poses[1::2, :3, :3] *= [-1, 1, -1]
    aovs = ["normal", "depth", "mesh", "color"]
    frames = []
    for threads in (1, 2, 3):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", texmap.TexmapWarning)
            frames.append(scene.render(texmap.Poses(poses, "opengl", fov=50), (150, 100), aovs=aovs, threads=threads))
    for frame in frames[1:]:
        assert all(np.array_equal(frame[key], frames[0][key], equal_nan=key in ("normal", "depth")) for key in frame)
        assert frame.warnings == frames[0].warnings
    assert len(frames[0].warnings) == (count > 1)


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_the_first_pose_without_a_view_is_named(assets, threads):
    scene = texmap.load(assets / "models" / "cow.obj")
    poses = [looking_at((0, 3, 12))] * 40
    k = np.tile([[70.0, 0, 32], [0, 70, 24], [0, 0, 1]], (40, 1, 1))
    assert scene.render(texmap.Poses(poses, "opengl", K=k), (64, 48), threads=threads).rgba.shape == (40, 48, 64, 4)
    k[[17, 18, 30], :2, :2] *= 1e-300  # so near that the field of view is 180 degrees
    with pytest.raises(ValueError, match=r"^pose\[17\]: camera: [^\n]*field of view[^\n]*$"):
        scene.render(texmap.Poses(poses, "opengl", K=k), (64, 48), threads=threads)
    with pytest.raises(ValueError, match="^camera: "):
        scene.render(texmap.Poses(poses[0], "opengl", K=k[17]), (64, 48), threads=threads)
    # Faults of the call are no pose's.
    with pytest.raises(ValueError, match="^settings: msaa"):
        scene.render(texmap.Poses(poses, "opengl", fov=50), (64, 48), samples=3, threads=threads)


SHORT_OF_MEMORY = """
import resource, sys
import numpy as np, texmap
scene = texmap.load(sys.argv[1])
poses = texmap.Poses([texmap.look_at((0, 1, 5 + k)) for k in range(4)], "opencv", fov=50)
render = lambda: scene.render(poses, (1400, 1400), aovs=["normal", "position"], samples=1, threads=4).hash
free = render()
kept = [np.empty(4 * 1400 * 1400 * 28, np.uint8)]  # what the arrays of the call will take
with open("/proc/self/statm") as file:
    used = int(file.read().split()[0]) * resource.getpagesize()
kept.clear()
resource.setrlimit(resource.RLIMIT_AS, (used + (int(sys.argv[2]) << 20), resource.RLIM_INFINITY))
print(free == render())
"""


def render_short_of_memory(model, mebibytes):
    run = [sys.executable, "-c", SHORT_OF_MEMORY, model, str(mebibytes)]
    return subprocess.run(run, capture_output=True, text=True, timeout=120, env=os.environ | {"MALLOC_ARENA_MAX": "1"})


@pytest.mark.skipif(sys.platform != "linux", reason="RLIMIT_AS and /proc are Linux's")
def test_poses_that_do_not_fit_in_memory_together_are_drawn_one_by_one(assets):
    # A picture has 55 MiB, four have more than the 130 MiB that are left.
    model = assets / "models" / "cow.obj"
    done = render_short_of_memory(model, 130)
    assert done.stdout == "True\n", done.stderr
    # The limit holds: where not even one picture fits, the call says so.
    done = render_short_of_memory(model, 30)
    assert done.returncode == 1 and "ValueError: no memory for a frame of 1400 x 1400 pixels" in done.stderr, done.stderr


LARGE_WORK = """
import resource, sys
import numpy as np, texmap
works = {
    "env": lambda: texmap.env(np.ones((8, 16, 3), np.float32), "cube", size=6000, threads=1),
    "texture": lambda: texmap.Texture(np.zeros((6000, 6000, 4), np.float32)),
    "channels": lambda: texmap.Texture(np.zeros((4000, 4000, 9), np.float32)),
}
limit = {"env": 900, "texture": 1200, "channels": 1200}[sys.argv[1]] << 20
resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
try:
    works[sys.argv[1]]()
    print("done")
except ValueError as error:
    print(str(error)[:13])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="RLIMIT_AS is Linux's")
@pytest.mark.parametrize("work", ["env", "texture", "channels"])
def test_a_shortage_of_memory_is_an_error(work):
    variables = os.environ | {"MALLOC_ARENA_MAX": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, "-c", LARGE_WORK, work], capture_output=True, text=True, timeout=120, env=variables)
    assert done.stdout == "no memory for\n", (done.returncode, done.stderr)


def test_axes_and_directions_of_poses_agree(assets):
    scene = texmap.load(assets / "models" / "cow.obj")
    pose = looking_at((5, 4, 12))
    flip = np.diag([1.0, -1, -1, 1])
    size = (64, 48)
    first = scene.render(texmap.Poses(pose, "opengl", fov=50), size).hash
    assert first == scene.render(texmap.Poses(pose @ flip, "opencv", fov=50), size).hash
    inverse = scene.render(texmap.Poses(np.linalg.inv(pose), "opengl", world_to_camera=True, fov=50), size)
    forward = scene.render(texmap.Poses(pose, "opengl", fov=50), size)
    assert texmap.diff(forward.rgba, inverse.rgba)["mean"] < 1e-3
    with pytest.warns(texmap.TexmapWarning, match="nothing was drawn"):
        scene.render(texmap.Poses(pose @ flip, "opengl", fov=50), size)
    wide = 32 / np.tan(np.radians(25))
    k = [[wide, 0, 32], [0, wide, 24], [0, 0, 1]]
    calibrated = scene.render(texmap.Poses(pose, "opengl", K=k), size)
    assert texmap.diff(forward.rgba, calibrated.rgba)["mean"] < 1e-3


def test_poses_without_a_lens_have_that_of_the_automatic_camera(assets):
    points, faces = icosphere(1)
    pose, size = texmap.look_at((0, 1, 4)), (48, 32)
    for scene in (texmap.Scene(texmap.Mesh(points, faces)), texmap.load(assets / "models" / "cube.obj")):
        found = scene.render(texmap.Poses(pose, "opencv"), size).hash
        assert found == scene.render(texmap.Poses(pose, "opencv", fov=40), size).hash
        assert found != scene.render(texmap.Poses(pose, "opencv", fov=60), size).hash
    own = texmap.Scene(texmap.Mesh(points, faces), camera=texmap.Camera((0, 0, 3), fov=55))
    assert own.render(texmap.Poses(pose, "opencv"), size).hash == own.render(texmap.Poses(pose, "opencv", fov=55), size).hash


def test_a_camera_of_the_scene_cuts_nothing_away():
    # The near plane would be at a thousandth of the distance to the point looked at, beyond the mesh.
    points, faces = icosphere(1)
    camera = texmap.Camera((0, 0, 3), look=(0, 0, -1e4))
    own = texmap.Scene(texmap.Mesh(points, faces), camera=camera).render(size=(32, 32))
    given = texmap.Scene(texmap.Mesh(points, faces)).render(camera, size=(32, 32))
    assert own.hash == given.hash and (own.rgba[16, 16] != own.rgba[0, 0]).any()


def test_k_projects_points_where_opencv_does():
    # A small square at a known place must be seen where K and the pose say.
    at = np.array([0.3, -0.2, 0.1])
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.02 + at
    scene = texmap.Scene(texmap.Mesh(square, [[0, 1, 2], [0, 2, 3]], material=texmap.Material(shading="unlit")), lights=[])
    pose = looking_at((0.5, 0.4, 3))
    extrinsics = np.linalg.inv(pose @ np.diag([1.0, -1, -1, 1]))
    k = np.array([[300.0, 0, 150], [0, 320, 90], [0, 0, 1]])
    seen = extrinsics[:3, :3] @ at + extrinsics[:3, 3]
    x, y, _ = k @ seen / seen[2]
    frame = scene.render(texmap.Poses(extrinsics, "opencv", K=k, world_to_camera=True), (320, 200), aovs=["face"])
    rows, columns = np.nonzero(frame["face"] != 0xFFFFFFFF)
    assert abs(columns.mean() + 0.5 - x) < 0.5 and abs(rows.mean() + 0.5 - y) < 0.5


@pytest.mark.parametrize("axes", ["opencv", "opengl"])
@pytest.mark.parametrize("calibrated", [False, True])
def test_project_is_the_inverse_of_a_picture(assets, axes, calibrated):
    scene = texmap.load(assets / "models" / "head.obj")
    pose = texmap.look_at((2, 1.5, 5), axes=axes)
    k = np.array([[90.0, 0, 40], [0, 85, 33], [0, 0, 1]]) if calibrated else None
    camera = texmap.Poses(pose, axes, K=k, fov=None if calibrated else 50)
    frame = scene.render(camera, (80, 60), aovs=["position", "inv_w"])
    rows, columns = np.nonzero(np.isfinite(frame["inv_w"]))
    assert len(rows) > 300
    uv, w = texmap.project(frame["position"][rows, columns], camera, (80, 60))
    assert np.abs(uv[:, 0] * 80 - columns - 0.5).max() < 1e-2 and np.abs((1 - uv[:, 1]) * 60 - rows - 0.5).max() < 1e-2
    assert np.abs(w * frame["inv_w"][rows, columns] - 1).max() < 1e-4
    behind, _ = texmap.project([pose[:3, 3] * 2], camera, (80, 60))
    assert (behind == -1).all()
    world_to_camera = texmap.Poses(np.linalg.inv(pose), axes, K=k, world_to_camera=True, fov=None if calibrated else 50)
    assert np.allclose(texmap.project(frame["position"][rows, columns], world_to_camera, (80, 60))[0], uv, atol=1e-4)


def test_project_refuses_the_cameras_that_pictures_refuse():
    pose, size = texmap.look_at((0, 1, 4)), (64, 48)
    sheared, affine = pose.copy(), pose.copy()
    sheared[:3, 0] += pose[:3, 1]
    affine[3] = (0, 0, 0.1, 1)
    k = np.array([[60.0, 0, 32], [0, 60, 24], [0, 0, 1]])
    points, faces = icosphere(0)
    scene = texmap.Scene(texmap.Mesh(points, faces))
    for camera, words in [
        (texmap.Poses(pose, "opencv", fov=0), "field of view"),
        (texmap.Poses(pose, "opencv", fov=-20), "field of view"),
        (texmap.Poses(pose, "opencv", fov=180), "field of view"),
        (texmap.Poses(pose, "opencv", fov=float("nan")), "field of view"),
        (texmap.Poses(pose, "opencv", K=k * [[-1], [1], [1]]), "focal lengths"),
        (texmap.Poses(pose, "opencv", K=k * [[0], [1], [1]]), "focal lengths"),
        (texmap.Poses(pose @ np.diag([-1.0, 1, 1, 1]), "opencv", fov=50), "mirrors"),
        (texmap.Poses(sheared, "opencv", fov=50), "lengths|right angles"),
        (texmap.Poses(affine, "opencv", fov=50), "last row"),
        (texmap.Poses(np.zeros((4, 4)), "opencv", fov=50), "last row"),
        (texmap.Poses(pose * np.nan, "opencv", fov=50), "finite"),
        (texmap.Poses(pose, "blender", fov=50), "opencv"),
    ]:
        for call in (lambda: texmap.project([[0, 0, 0]], camera, size), lambda: scene.render(camera, size)):
            with pytest.raises(ValueError, match=words):
                call()
    uv, w = texmap.project([[0.2, 0.1, 0]], texmap.Poses(pose, "opencv", K=k), size)
    larger = texmap.project([[0.2, 0.1, 0]], texmap.Poses(pose @ np.diag([3.0, 3, 3, 1]), "opencv", K=k), size)
    assert np.allclose(uv, larger[0]) and np.allclose(w, larger[1])


def test_look_at_refuses_what_has_no_view():
    for eye, up in (((0, 0, 0), (0, 1, 0)), ((0, 5, 0), (0, 1, 0)), ((1, 0, 0), (0, 0, 0))):
        with pytest.raises(ValueError, match="no view"):
            texmap.look_at(eye, up=up)
    with pytest.raises(ValueError, match="K or fov"):
        texmap.project([[0, 0, 0]], texmap.Poses(texmap.look_at((0, 0, 3)), "opencv"), (8, 8))


def test_arrays_make_the_scene_that_a_file_makes(tmp_path, assets, rng):
    points, faces = icosphere(1)
    uv = rng.uniform(size=(len(points), 2)).astype(np.float32)
    image = rng.integers(0, 255, (8, 8, 3), dtype=np.uint8)
    material = texmap.Material(color=(1, 1, 1), texture=image, shading="unlit")
    scene = texmap.Scene([texmap.Mesh(points, faces, uv, material=material)])
    frame = scene.render(size=(100, 80), samples=1)
    texmap._picture.write_png(tmp_path / "t.png", image)
    lines = ["mtllib m.mtl", "usemtl m"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()] + [f"vt {u!r} {v!r}" for u, v in uv.tolist()]
    lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in faces + 1]
    (tmp_path / "m.obj").write_text("\n".join(lines))
    (tmp_path / "m.mtl").write_text("newmtl m\nKd 1 1 1\nillum 0\nmap_Kd t.png\n")
    loaded = texmap.load(tmp_path / "m.obj").render(size=(100, 80), samples=1)
    assert texmap.diff(frame.rgba[..., 3], loaded.rgba[..., 3])["max"] == 0
    mesh = texmap.load(tmp_path / "m.obj").mesh(0)
    assert np.allclose(mesh.vertices[mesh.faces], points[faces]) and np.allclose(mesh.uv[mesh.faces], uv[faces])


def test_lights_environments_and_backgrounds():
    points, faces = icosphere(2)
    scene = texmap.Scene(texmap.Mesh(points, faces))
    sky = np.zeros((16, 32, 3), np.float32)
    sky[:8] = (0, 0, 2)
    sky[8:] = (2, 0, 0)
    lit = scene.render(size=(64, 64), env=sky, tone_map="none").rgba.astype(int)
    top, bottom = lit[12, 32], lit[52, 32]
    assert top[2] > top[0] + 50 and bottom[0] > bottom[2] + 50
    behind = scene.render("front", (64, 64), env=sky, background="env").rgba
    assert behind[1, 1, 2] > behind[1, 1, 0] and behind[62, 1, 0] > behind[62, 1, 2]
    assert (scene.render(size=(8, 8), background=(1, 0, 0, 0.5)).rgba[0, 0] == [255, 0, 0, 128]).all()
    dark = texmap.Scene(texmap.Mesh(points, faces), lights=[], background=(0, 0, 0))
    one = texmap.Scene(texmap.Mesh(points, faces), lights=[texmap.Light("directional", direction=(0, 0, -1))], background=(0, 0, 0))
    assert dark.render("front", (32, 32)).rgba[..., :3].max() == 0
    assert one.render("front", (32, 32)).rgba[16, 16].min() > 100


@pytest.mark.parametrize("name", ["models/house.obj", "models/cube.stl", "gltf/materials.glb"])
def test_no_environment_is_that_of_the_program(program, tmp_path, assets, name):
    expected = the_hash(program, tmp_path, assets / name, "--resolution", "80x60", "--env", "none")
    frame = texmap.load(assets / name).render(size=(80, 60), env="none")
    assert frame.hash == expected and frame.rgba[..., :3].max() > 100


@pytest.mark.parametrize("kind", [np.int64, np.int32, np.uint32, bool])
def test_whole_numbers_without_a_scale_are_no_light(kind):
    sky = np.ones((8, 16, 3), kind)
    points, faces = icosphere(0)
    for call in (
        lambda: texmap.render((points, faces), size=(8, 8), env=sky),
        lambda: texmap.env(sky),
        lambda: texmap.env(np.ones((6, 8, 8, 3), kind), "lat-long", layout="cube"),
    ):
        with pytest.raises(ValueError, match="expected .*uint8.*got"):
            call()
    assert texmap.env(np.full((8, 16, 3), 255, np.uint8)).max() == 1


@pytest.mark.parametrize("blur", [None, 40.0])
@pytest.mark.parametrize("to", ["cube", "octahedron", "lat-long", "dual-paraboloid"])
def test_environments_have_the_default_size_of_the_program(program, tmp_path, rng, to, blur):
    sky = rng.random((31, 62, 3), np.float32)
    image_module = pytest.importorskip("PIL.Image")
    codes = (sky * 255).astype(np.uint8)
    image_module.fromarray(codes).save(tmp_path / "sky.png")
    more = [] if blur is None else ["--blur", blur]
    words = program("env", tmp_path / "sky.png", "--to", to, "-o", tmp_path / "out.exr", "--quiet", *more)
    assert not words or "texels" in words
    made = texmap.env(tmp_path / "sky.png", to, blur=blur)
    written = sorted(tmp_path.glob("out*.exr"))
    sizes = [texmap.Texture(path).shape[:2] for path in written]
    assert made.size // 3 == sum(h * w for h, w in sizes)


def test_an_environment_in_its_own_layout_is_a_copy(rng):
    sky = rng.random((16, 32, 3), np.float32)
    assert np.array_equal(texmap.env(sky, "lat-long"), sky)
    assert np.array_equal(texmap.env(sky, "lat-long", size=16), sky)
    assert not np.array_equal(texmap.env(sky, "lat-long", blur=40.0, size=16), sky)


def test_shadows_of_the_environment_are_those_of_the_program(program, tmp_path, assets):
    scene = texmap.load(assets / "models/teapot.obj")
    open_ = scene.render(size=(80, 60))
    shadowed = scene.render(size=(80, 60), env_shadows=24)
    expected = the_hash(program, tmp_path, assets / "models/teapot.obj", "--resolution", "80x60", "--env-shadows", "24")
    assert shadowed.hash == expected != open_.hash
    assert scene.render(size=(80, 60)).hash == open_.hash
    with pytest.raises(ValueError, match="env_shadows"):
        scene.render(size=(8, 8), env_shadows=257)


def test_no_environment_leaves_the_lights_that_were_given():
    points, faces = icosphere(1)
    mesh = texmap.Mesh(points, faces)
    black = {"background": (0, 0, 0), "size": (16, 16)}
    assert texmap.Scene(mesh, lights=[]).render("front", env="none", **black).rgba[..., :3].max() == 0
    assert texmap.Scene(mesh).render("front", env="none", **black).rgba[..., :3].max() > 100
    with pytest.raises(ValueError, match="background='env': .*picture"):
        texmap.Scene(mesh).render("front", env="none", background="env", size=(16, 16))


def test_trimesh_and_open3d_shapes_are_accepted():
    points, faces = icosphere(1)

    class Open3d:
        vertices, triangles = points, faces
        triangle_uvs = np.zeros((3 * len(faces), 2))
        textures = [np.full((4, 4, 3), 200, np.uint8)]

    frame = texmap.render(Open3d(), size=(32, 32))
    assert frame.rgba.shape == (32, 32, 4)
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box()
    whole = texmap.render(box, size=(64, 48))
    parts = texmap.render(trimesh.Scene([box]), size=(64, 48))
    assert whole.hash == parts.hash and (whole.rgba[24, 32] != whole.rgba[0, 0]).any()


def test_colours_of_trimesh_materials_are_linear_or_srgb_as_trimesh_has_them():
    trimesh = pytest.importorskip("trimesh")
    points, faces = icosphere(0)
    materials = trimesh.visual.material

    def color(material):
        visual = trimesh.visual.TextureVisuals(uv=np.zeros((len(points), 2)), material=material)
        return texmap._meshes._mesh_of(trimesh.Trimesh(points, faces, visual=visual, process=False))[0].material.color

    factor = [102, 51, 26, 255]
    assert np.allclose(color(materials.PBRMaterial(baseColorFactor=factor)), np.array(factor[:3]) / 255)
    assert np.allclose(color(materials.SimpleMaterial(diffuse=factor)), [0.1329, 0.0331, 0.0103], atol=1e-3)


def test_textured_trimesh_shows_its_image():
    trimesh = pytest.importorskip("trimesh")
    image_module = pytest.importorskip("PIL.Image")
    image = image_module.new("RGB", (4, 4), (255, 0, 0))
    image.putpixel((0, 3), (0, 0, 255))  # lower left, where uv is 0
    quad = trimesh.Trimesh(
        [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
        [[0, 1, 2], [0, 2, 3]],
        visual=trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 1], [0, 1]], image=image),
        process=False,
    )
    rgba = texmap.render(quad, "front", (64, 64), filter="nearest").rgba.astype(int)
    low, high = rgba[56, 8], rgba[8, 56]
    assert low[2] > low[0] and high[0] > high[2]


def test_errors_are_those_of_the_program(tmp_path, assets):
    with pytest.raises(FileNotFoundError, match="no such file\ncheck the spelling"):
        texmap.load(tmp_path / "no.obj")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(OSError, match="not a regular file"):
        texmap.load(tmp_path / "folder.obj")
    broken = tmp_path / "broken.obj"
    broken.write_text("v 0 0 0\nv 1 0 0\nv 0 x 0\nf 1 2 3\n")
    with pytest.raises(ValueError, match=r"broken\.obj:3:5"):
        texmap.load(broken)
    scene = texmap.load(assets / "models" / "cube.obj")
    for call, words in [
        (lambda: scene.render(size=(0, 5)), "size"),
        (lambda: scene.render(size=(16, 16), samples=3), "msaa is 3"),
        (lambda: scene.render(size=(16, 16), aovs=["uvw"]), "unknown AOV"),
        (lambda: scene.render(size=(16, 16), filter="cubic"), "filter"),
        (lambda: scene.render(size=(16, 16), threads=0), "0 threads"),
        (lambda: scene.render(size=(16, 16), level="avx9"), "level"),
        (lambda: scene.render("behind", size=(16, 16)), "three-quarter"),
        (lambda: scene.render(texmap.Poses(np.eye(3), "opencv")), "pose"),
        (lambda: scene.render(texmap.Poses(np.eye(4), "blender")), "opencv"),
        (lambda: scene.render(texmap.Poses(np.diag([1.0, 1, -1, 1]), "opencv")), "mirrors"),
        (lambda: scene.render(texmap.Poses(np.eye(4), "opencv", K=[[1, 1, 0], [0, 1, 0], [0, 0, 1]])), "skew"),
        (lambda: texmap.Scene(texmap.Mesh(np.zeros((3, 3)), [[0, 1, 3]], name="tri")), "'tri': faces name vertex 3"),
        (lambda: texmap.Scene(texmap.Mesh(np.zeros((3, 2)), [[0, 1, 2]])), "vertices: expected shape"),
        (lambda: texmap.Scene(5), "int"),
    ]:
        with pytest.raises(ValueError, match=words):
            call()


def test_a_missing_map_is_a_warning(tmp_path):
    (tmp_path / "m.obj").write_text("mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n")
    (tmp_path / "m.mtl").write_text("newmtl m\nmap_Kd gone.png\n")
    with pytest.warns(texmap.TexmapWarning, match="gone.png"):
        texmap.load(tmp_path / "m.obj")
    with pytest.raises(OSError, match="gone.png"):
        texmap.load(tmp_path / "m.obj", missing="error")


def test_ctrl_c_ends_a_long_picture(assets, tmp_path):
    import signal
    import subprocess
    import sys
    import time

    script = (
        "import signal, texmap\n"
        # A suite that a shell started in the background has it ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"s = texmap.load({str(assets / 'models' / 'cow.obj')!r})\n"
        "print('ready', flush=True)\n"
        "while True: s.render(size=(8000, 8000), supersample=2, threads=1)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert child.stdout.readline() == "ready\n"
        time.sleep(1.0)
        child.send_signal(signal.SIGINT)
        _, words = child.communicate(timeout=60)
        assert "KeyboardInterrupt" in words and child.returncode != 0
    finally:
        # One that does not end would take a core for ever.
        child.kill()


def test_threads_of_python_draw_side_by_side(assets):
    scene = texmap.load(assets / "models" / "cube.obj")
    expected = scene.render(size=(80, 60)).hash
    found = []
    threads = [threading.Thread(target=lambda: found.append(scene.render(size=(80, 60)).hash)) for _ in range(4)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    assert found == [expected] * 4


def test_notebooks_see_pictures_and_tables(assets):
    scene = texmap.load(assets / "models" / "cube.obj")
    assert scene._repr_png_().startswith(b"\x89PNG") and "<table>" in scene._repr_html_()
    frame = scene.render(size=(20, 10))
    assert frame._repr_png_().startswith(b"\x89PNG") and "rgba" in repr(frame)
    assert texmap.Texture(np.zeros((4, 4, 3), np.uint8))._repr_png_().startswith(b"\x89PNG")
