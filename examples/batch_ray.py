"""A turntable on a Ray cluster; each worker loads the model once.   python batch_ray.py model.obj out 48"""
import math
import os
import sys

import ray
from ray.util import ActorPool


@ray.remote(num_cpus=1)
class Worker:
    def __init__(self, path):
        import texmap
        self.texmap, self.scene = texmap, texmap.load(path)

    def draw(self, frame, of, folder):
        angle = 2 * math.pi * frame / of
        camera = self.texmap.Camera(eye=(5 * math.sin(angle), 2, 5 * math.cos(angle)))
        picture = self.texmap.render(self.scene, camera=camera, size=(512, 512), threads=1)
        picture.save(os.path.join(folder, f"frame-{frame:04}.png"))
        return picture.hash


if __name__ == "__main__":
    path, folder, of = sys.argv[1], sys.argv[2], int(sys.argv[3])
    os.makedirs(folder, exist_ok=True)
    ray.init()
    workers = [Worker.remote(os.path.abspath(path)) for _ in range(int(ray.cluster_resources()["CPU"]))]
    pool = ActorPool(workers)
    for frame, digest in enumerate(pool.map(lambda worker, n: worker.draw.remote(n, of, os.path.abspath(folder)), range(of))):
        print(frame, digest)
