"""Studies over a Ray cluster: ``python -m shadowgauge.ray study coverage --scenes 1000000``.

A study is split into shards (``study … --shard I/N``), each a task on one CPU. A task writes its shard
in a folder of its own and returns the file's bytes, so that the machines need no disk in common; the
driver writes them beside each other under a temporary name, renamed, and joins them by ``study
merge``. Ray runs the task of a worker that died again; a shard that is in the folder already is not
run again, so that a driver that was ended is resumed by the same command. What a shard holds follows
from the study's settings, its seed and the shard's number alone: the joined result has the same bytes
whatever machines, workers and deaths there were.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from .errors import MissingPackage, StudyError
from .studies import command

#: Studies that can be split.
STUDIES = ("contamination", "coverage", "machine-coverage")

#: Shards a worker where nothing is said: enough that the last ones to end leave few idle.
SHARDS_A_WORKER = 8


def _ray() -> Any:
    try:
        import ray
    except ImportError:
        raise MissingPackage(
            "studies over many machines need Ray, which is not installed: pip install 'shadowgauge[ray]'"
        ) from None
    return ray


def shard_name(study: str, number: int, of: int) -> str:
    """Name of a shard's file, as the program gives it."""
    return f"{study}-{number:0{len(str(of))}}-of-{of}.parquet"


def make_shard(study: str, words: list[str], number: int, of: int, kill: float = 0.0) -> tuple[bytes, float]:
    """A shard's file and the seconds that it took. ``kill`` is the probability with which this process
    dies instead: for tests of what deaths change."""
    begun = time.monotonic()
    if kill > 0.0:
        import random

        if random.SystemRandom().random() < kill:
            os._exit(137)
    with tempfile.TemporaryDirectory() as folder:
        done = command("study", study, *words, "--shard", f"{number}/{of}", "--shard-dir", folder, threads=1)
        if done.returncode != 0:
            raise StudyError(f"shard {number} of {of}: {done.stderr.strip() or done.returncode}")
        return (Path(folder) / shard_name(study, number, of)).read_bytes(), time.monotonic() - begun


def _write(path: Path, data: bytes) -> None:
    temporary = path.with_name(f".tmp-{path.name}")
    temporary.write_bytes(data)
    temporary.replace(path)


def shards(
    study: str, words: list[str], folder: Path, of: int, *, kill: float = 0.0
) -> Iterator[tuple[int, float | None]]:
    """Makes the shards that ``folder`` lacks, as tasks of the Ray that is initialised; yields each
    shard's number as it is there, with the seconds of its task, None for one that was there before.
    """
    ray = _ray()
    folder.mkdir(parents=True, exist_ok=True)
    # A task that dies with its worker is run again; one that the program refuses is not.
    task = ray.remote(num_cpus=1, max_retries=-1)(make_shard)
    due = {}
    for number in range(1, of + 1):
        if (folder / shard_name(study, number, of)).exists():
            yield number, None
        else:
            due[task.remote(study, words, number, of, kill)] = number
    while due:
        (ready,), _ = ray.wait(list(due), num_returns=1)
        number = due.pop(ready)
        data, seconds = ray.get(ready)
        _write(folder / shard_name(study, number, of), data)
        yield number, seconds


def _arguments(given: list[str]) -> tuple[argparse.Namespace, list[str]]:
    parser = argparse.ArgumentParser(
        prog="python -m shadowgauge.ray",
        allow_abbrev=False,
        description="A study over a Ray cluster; options that are not below are the study's own.",
    )
    parser.add_argument("command", choices=["study"])
    parser.add_argument("study", choices=STUDIES)
    parser.add_argument("--address", help="of a cluster (ray://HOST:10001, or auto); without it this machine")
    parser.add_argument("--workers", type=int, help="CPUs of this machine, without --address; all by default")
    parser.add_argument("--shards", type=int, help=f"tasks; {SHARDS_A_WORKER} a worker by default")
    parser.add_argument("--shard-dir", type=Path, default=Path("shards"), help="folder of the shards' files (shards)")
    parser.add_argument("--cost-per-cpu-hour", type=float, help="for the cost of a million scenes, in any currency")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--kill", type=float, default=0.0, help=argparse.SUPPRESS)
    return parser.parse_known_args(given)


def main(given: list[str] | None = None) -> int:
    """The command; returns its exit code."""
    options, words = _arguments(sys.argv[1:] if given is None else given)
    try:
        ray = _ray()
    except MissingPackage as error:
        print(error, file=sys.stderr)
        return 2
    if options.workers is not None and options.workers < 1:
        print("--workers: a number of at least 1 is needed", file=sys.stderr)
        return 2
    where = {"address": options.address} if options.address else {"num_cpus": options.workers}
    # Ray states on stdout that a worker died; what stands there is the study's alone.
    with contextlib.redirect_stdout(sys.stderr):
        code = _over_ray(ray, where, options, words)
    if code != 0:
        return code
    of = options.shards
    files = [str(options.shard_dir / shard_name(options.study, number, of)) for number in range(1, of + 1)]
    merged = command("study", "merge", *files, *(["--json"] if options.json else []))
    sys.stdout.write(merged.stdout)
    sys.stderr.write(merged.stderr)
    return merged.returncode


def _over_ray(ray: ModuleType, where: dict[str, object], options: argparse.Namespace, words: list[str]) -> int:
    """Has every shard computed, or found; `options.shards` is how many there are then. The exit code."""
    ray.init(include_dashboard=False, log_to_driver=False, logging_level="ERROR", **where)
    try:
        cpus = int(ray.cluster_resources().get("CPU", 1))
        of = options.shards = options.shards or SHARDS_A_WORKER * cpus
        begun, computed, seconds = time.monotonic(), 0, 0.0
        for done, (number, took) in enumerate(
            shards(options.study, words, options.shard_dir, of, kill=options.kill), start=1
        ):
            if took is not None:
                computed, seconds = computed + 1, seconds + took
            print(f"\rshard {number}: {done} of {of} are there", end="", file=sys.stderr, flush=True)
        print(file=sys.stderr)
        _report(options, of, computed, seconds, time.monotonic() - begun)
    except (StudyError, ray.exceptions.RayTaskError) as error:
        print(f"\n{getattr(error, 'cause', None) or error}", file=sys.stderr)
        return 3
    finally:
        ray.shutdown()
    return 0


def _report(options: argparse.Namespace, of: int, computed: int, seconds: float, elapsed: float) -> None:
    """The rate of the tasks, and what a million scenes take by it."""
    if computed == 0:
        return
    first = options.shard_dir / shard_name(options.study, 1, of)
    scenes = scenes_of(first)
    if scenes is None or seconds <= 0.0:
        return
    hours = seconds / 3600.0 * (1e6 / (scenes * computed / of))
    text = f"{scenes * computed / of / elapsed:.2f} scenes/s over {elapsed:.0f} s; {hours:.1f} CPU hours a million scenes"
    if options.cost_per_cpu_hour is not None:
        text += f", at {options.cost_per_cpu_hour} a CPU hour {hours * options.cost_per_cpu_hour:.2f}"
    print(text, file=sys.stderr)


def scenes_of(path: Path) -> int | None:
    """Scenes of all shards, by a shard's metadata; None without pyarrow."""
    try:
        from pyarrow import parquet
    except ImportError:
        return None
    metadata = parquet.read_metadata(path).metadata or {}
    return int(metadata.get(b"shadowgauge.scenes", b"0")) or None


if __name__ == "__main__":
    sys.exit(main())
