"""A turntable on a Dask cluster; each worker loads the model once.   python batch_dask.py model.obj out 48 [scheduler]"""
import functools
import math
import os
import sys

from dask.distributed import Client


@functools.lru_cache(maxsize=1)
def scene(path):
    import texmap
    return texmap.load(path)


def draw(frame, of, path, folder):
    import texmap
    angle = 2 * math.pi * frame / of
    camera = texmap.Camera(eye=(5 * math.sin(angle), 2, 5 * math.cos(angle)))
    picture = texmap.render(scene(path), camera=camera, size=(512, 512), threads=1)
    picture.save(os.path.join(folder, f"frame-{frame:04}.png"))
    return picture.hash


if __name__ == "__main__":
    path, folder, of = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), int(sys.argv[3])
    os.makedirs(folder, exist_ok=True)
    with Client(sys.argv[4] if len(sys.argv) > 4 else None) as client:
        tasks = client.map(draw, range(of), of=of, path=path, folder=folder)
        for frame, digest in enumerate(client.gather(tasks)):
            print(frame, digest)
