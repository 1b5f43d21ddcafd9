"""Times of the package, the least of several runs: ``python bench.py`` prints what docs/python.md quotes, ``python bench.py peers`` the
batch of poses of F3D's module and of pyrender (EGL) too, where they are installed, and ``python bench.py overhead PROGRAM`` what a
call of ``sample`` costs beside the Rust function, by turns with the program ``sample-slice`` of the benches:

    cargo build --release -p texmap-benches --bin sample-slice
    python bench.py overhead target/release/sample-slice

The machine should be idle. Nothing here is a test.
"""

import os
import subprocess
import sys
import time

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "tests"))

from conftest import ROOT, clip_from_world, icosphere, to_clip  # noqa: E402

import texmap  # noqa: E402
import texmap.dr as dr  # noqa: E402


def least(work, runs=15, clock=time.process_time):
    """Milliseconds of the fastest run: of the processor's time, which other programs disturb least."""
    best = float("inf")
    for _ in range(runs):
        begin = clock()
        work()
        best = min(best, clock() - begin)
    return best * 1e3


def grid(side=101):
    """A textured sheet of 2 * (side - 1)^2 triangles that fills the picture."""
    x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side))
    z = 0.3 * np.sin(3 * x) * np.cos(3 * y)
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    k = np.arange(side * side).reshape(side, side)
    a, b, c, d = k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return points, faces.astype(np.int32)


def overhead(program, rounds=20):
    """Prints times of bilinear and trilinear look-ups by both, and their ratios: by the clock, as `chrt -f 10` lets nobody interrupt."""
    rng = np.random.default_rng(1)
    filters = ("Bilinear", "Trilinear")
    ours, theirs = (dict.fromkeys(filters, float("inf")) for _ in range(2))
    for _ in range(rounds):
        # Each round has memory of its own, as each run of the program has: where it lies decides up to a third of the time.
        texture = texmap.Texture(rng.uniform(size=(1024, 1024, 4)).astype(np.float32))
        uv, out = rng.uniform(size=(1_000_000, 2)).astype(np.float32), np.empty((1_000_000, 4), np.float32)
        duv = np.full((1_000_000, 4), 1e-3, np.float32)
        for name, derivatives in zip(filters, (None, duv)):
            t = least(lambda: texmap.sample(texture, uv, derivatives, filter=name.lower(), out=out, threads=1), 9, time.perf_counter)
            ours[name] = min(ours[name], t)
        for line in subprocess.run([program], capture_output=True, text=True, check=True).stdout.splitlines():
            name, t = line.split(", ")[-1].removesuffix(" ms").split(": ")
            theirs[name] = min(theirs[name], float(t))
    for name in filters:
        print(f"sample, {name}: {ours[name]:.2f} ms, Rust {theirs[name]:.2f} ms, ratio {ours[name] / theirs[name]:.3f}")


def main():
    if sys.argv[1:2] == ["overhead"]:
        return overhead(sys.argv[2])
    rng = np.random.default_rng(1)
    for channels in (3, 4):
        texture = texmap.Texture(rng.uniform(size=(1024, 1024, channels)).astype(np.float32))
        uv = rng.uniform(size=(1_000_000, 2)).astype(np.float32)
        out = np.empty((1_000_000, channels), np.float32)
        for filter in ("bilinear", "trilinear"):
            duv = None if filter == "bilinear" else np.full((1_000_000, 4), 1e-3, np.float32)
            t = least(lambda: texmap.sample(texture, uv, duv, filter=filter, out=out, threads=1), 7)
            print(f"sample, 1 M look-ups, {channels} channels, {filter}, one thread: {t:.2f} ms")
    points, faces = grid()
    pos = to_clip(clip_from_world(eye=(0, 0, 2.2)), points)
    buffers = np.empty((1, 512, 512, 4), np.float32), np.empty((1, 512, 512, 4), np.float32)
    for db in (True, False):
        t = least(lambda: dr.rasterize(None, pos, faces, (512, 512), grad_db=db, out=buffers, threads=1))
        covered = (buffers[0][..., 3] > 0).mean()
        print(f"dr.rasterize, 512 x 512, {len(faces)} triangles, {covered:.0%} covered, grad_db={db}, one thread: {t:.2f} ms")
    rast, rast_db = dr.rasterize(None, pos, faces, (512, 512))
    uv = (points[:, :2] * 0.5 + 0.5).astype(np.float32)
    tex = rng.uniform(size=(1, 512, 512, 3)).astype(np.float32)
    at, da = dr.interpolate(uv, rast, faces, rast_db, "all")
    mip = dr.texture_construct_mip(tex)
    color = dr.texture(tex, at, da, mip=mip)
    print(f"dr.interpolate, 2 attributes with derivatives, one thread: {least(lambda: dr.interpolate(uv, rast, faces, rast_db, 'all', threads=1)):.2f} ms")
    print(f"dr.texture, trilinear of a mip stack, 3 channels, one thread: {least(lambda: dr.texture(tex, at, da, mip=mip, threads=1)):.2f} ms")
    print(f"dr.antialias: {least(lambda: dr.antialias(color, rast, pos, faces)):.2f} ms")
    for samples in (1, 4):
        poses(f"texmap, {samples} samples", texmap_poses(samples))
    if "peers" in sys.argv:
        for name, peer in (("F3D", f3d_poses), ("pyrender", pyrender_poses)):
            try:
                work = peer()
            except Exception as error:  # whatever a missing module or display raises
                print(f"LEFT OUT {name}: {error}")
            else:
                poses(name, work)


MODEL = ROOT / "assets" / "models" / "cow.obj"
ANGLES = np.linspace(0, 2 * np.pi, 100, endpoint=False)
FOV = 39.0


def poses(name, work):
    work()
    begin, used = time.perf_counter(), time.process_time()
    picture = work()
    wall, used = time.perf_counter() - begin, time.process_time() - used
    assert (picture != picture[0, 0]).any(), "an empty picture"
    print(f"100 poses at 640 x 480, {name}: {wall * 1e3:.0f} ms, {used * 1e3:.0f} ms of processors")


def around():
    """Poses with OpenGL axes, around the model."""
    found = np.tile(np.eye(4), (len(ANGLES), 1, 1))
    for pose, a in zip(found, ANGLES):
        back = np.array([np.sin(a), 0.0, np.cos(a)])
        pose[:3, :3] = np.stack([[np.cos(a), 0, -np.sin(a)], [0, 1, 0], back], axis=1)
        pose[:3, 3] = 5 * back
    return found


def texmap_poses(samples):
    scene = texmap.load(MODEL)
    fov = np.degrees(2 * np.arctan(np.tan(np.radians(FOV) / 2) * 4 / 3))
    cameras = texmap.Poses(around(), "opengl", fov=fov)
    return lambda: scene.render(cameras, (640, 480), samples=samples).rgba[-1]


def f3d_poses():
    import f3d

    engine = f3d.Engine.create(True)
    engine.window.size = (640, 480)
    engine.scene.add(str(MODEL))
    camera = engine.window.camera

    def work():
        for pose in around():
            camera.position, camera.focal_point, camera.view_up = tuple(pose[:3, 3]), (0, 0, 0), (0, 1, 0)
            camera.view_angle = FOV
            image = engine.window.render_to_image()
        return np.frombuffer(image.content, np.uint8).reshape(480, 640, -1)

    return work


def pyrender_poses():
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
    np.infty = np.inf
    import pyrender
    import trimesh

    loaded = trimesh.load(MODEL)
    scene = pyrender.Scene()
    for mesh in loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]:
        scene.add(pyrender.Mesh.from_trimesh(mesh))
    node = scene.add(pyrender.PerspectiveCamera(yfov=np.radians(FOV), aspectRatio=4 / 3))
    scene.add(pyrender.DirectionalLight(intensity=3))
    renderer = pyrender.OffscreenRenderer(640, 480)

    def work():
        for pose in around():
            scene.set_pose(node, pose)
            color, _ = renderer.render(scene)
        return color

    return work


if __name__ == "__main__":
    main()
