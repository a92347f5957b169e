"""What a second Ray worker gains, beside what a second process gains without Ray: in turn, so that both meet the same
load of the machine.

    python scaling.py [SCENES] [ROUNDS]

A round times four ways to compute the same scenes of `study coverage --class noise`: one process, two processes at
once, one Ray worker, two Ray workers. Every way makes the same shards, each a process with one thread. Printed are the
gains and their ratio, of the medians over the rounds, and what a million
scenes of all classes cost by CPU time.
"""

import os
import resource
import statistics
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import ray

from shadowgauge.ray import make_shard, scenes_of, shard_name, shards
from shadowgauge.studies import command

#: Shards of a round; even, so that two workers have as many each.
SHARDS = 4


def by_processes(words: list[str], workers: int) -> float:
    """Seconds of the shards by so many processes at once."""
    begun = time.monotonic()
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(lambda number: make_shard("coverage", words, number, SHARDS), range(1, SHARDS + 1)))
    return time.monotonic() - begun


def by_ray(words: list[str], workers: int) -> float:
    """Seconds of the shards by so many workers of a Ray that runs, their first start left out."""
    ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
    try:
        ready = ray.remote(num_cpus=1)(lambda seconds: time.sleep(seconds))
        ray.get([ready.remote(1.0) for _ in range(workers)])
        with tempfile.TemporaryDirectory() as folder:
            begun = time.monotonic()
            list(shards("coverage", words, Path(folder), SHARDS))
            return time.monotonic() - begun
    finally:
        ray.shutdown()


def main(scenes: str = "400", rounds: str = "3") -> None:
    """Prints the figures."""
    words = ["--scenes", scenes, "--class", "noise"]
    ways = [(by_processes, 1), (by_processes, 2), (by_ray, 1), (by_ray, 2)]
    seconds = {way: [] for way in ways}
    for number in range(int(rounds)):
        for way in ways:
            seconds[way].append(way[0](words, way[1]))
        took = ", ".join(f"{seconds[way][-1]:.2f}" for way in ways)
        print(f"round {number + 1}: {took} s; load {os.getloadavg()[0]:.1f}", flush=True)
    one, two, ray_one, ray_two = (statistics.median(seconds[way]) for way in ways)
    print(f"two processes  {one / two:.3f} times one")
    print(f"two workers    {ray_one / ray_two:.3f} times one, {(ray_one / ray_two) / (one / two):.3f} of it")
    cost(scenes)


def cost(scenes: str) -> None:
    """CPU time of the scenes of all classes, as one shard on one thread."""
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = command("study", "coverage", "--scenes", scenes, "--shard", "1/1", "--shard-dir", folder, threads=1)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            sys.exit(done.stderr)
        drawn = scenes_of(Path(folder) / shard_name("coverage", 1, 1))
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(f"study coverage --scenes {scenes}: {drawn} scenes in {cpu_s:.1f} CPU s, {cpu_s / drawn / 3.6e-3:.1f} CPU hours a million")


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
