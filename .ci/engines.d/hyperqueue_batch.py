"""The shards of a batch as tasks of HyperQueue by its Python API, one unit each, on 4 workers of a LocalCluster.

Workers of a LocalCluster are threads of this process and cannot be killed one by one. A cluster runs in a process of its own instead, with
one of the workers; that process is killed in the middle, and its tasks run again on the other cluster.
"""
import os
import signal
import sys
import time

from hyperqueue import Job, LocalCluster
from hyperqueue.cluster import WorkerConfig

SETTINGS = sys.argv[1:]
COUNT = sum(1 for _ in open("list.txt"))


def run(shards, workers, ready=None):
    with LocalCluster() as cluster:
        for _ in range(workers):
            cluster.start_worker(WorkerConfig(cores=1))
        job = Job(max_fails=None)
        for shard in shards:
            words = ["texmap", "batch", "render", *SETTINGS, "--resume", "--jobs=1", f"--shard={shard}/{COUNT}"]
            job.program(words, stdout=None, stderr=None)
        client = cluster.client()
        submitted = client.submit(job)
        if not client.wait_for_jobs([submitted], raise_on_error=False):
            print("failed:", client.get_failed_tasks(submitted))
            sys.exit(1)


def done():
    reports = os.listdir("out/.texmap") if os.path.isdir("out/.texmap") else []
    return {int(name.split("-")[1]) for name in reports if name.startswith("report-")}


lost = range(1, COUNT // 4 + 1)
pid = os.fork()
if pid == 0:
    os.setsid()
    run(lost, 1)
    os._exit(0)
# The machine with the fourth worker is lost once a part of its tasks is done.
while len(done()) < len(lost) // 3:
    time.sleep(0.02)
os.killpg(pid, signal.SIGKILL)
os.waitpid(pid, 0)
before = done()
print(f"killed a worker after {len(before)} of its {len(lost)} tasks")
assert 0 < len(before) < len(lost)
run([shard for shard in range(1, COUNT + 1) if shard not in before], 3)
