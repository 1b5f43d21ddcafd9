"""The shards of a batch as tasks of Dask, on two workers."""
import subprocess
import sys

from dask.distributed import Client, LocalCluster

SETTINGS = sys.argv[1:]
COUNT = 20


def run(shard):
    words = ["texmap", "batch", "render", *SETTINGS, "--resume", "--jobs=1", f"--shard={shard}/{COUNT}"]
    return subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode


if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        codes = client.gather(client.map(run, range(1, COUNT + 1)))
    sys.exit(any(codes))
