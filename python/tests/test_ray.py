"""Studies over a local Ray cluster: the same bytes whatever the workers do."""

import subprocess
import sys
import time

import pytest
from conftest import program, python

STUDY = ["study", "coverage", "--scenes", "8", "--class", "noise", "--json"]
SHARDS = 8


def over_ray(folder, *words):
    return python("-m", "shadowgauge.ray", *STUDY, "--shard-dir", folder, *words)


def test_without_ray_the_remedy_is_named():
    code = "import sys; sys.modules['ray'] = None\nfrom shadowgauge.ray import main; sys.exit(main(['study', 'coverage']))"
    done = python("-c", code)
    assert done.returncode == 2 and "pip install" in done.stderr


@pytest.fixture(scope="module")
def whole():
    """The study of one process."""
    pytest.importorskip("ray")
    done = program(*STUDY)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(("workers", "kill"), [(1, 0.0), (2, 0.3), (8, 0.3)])
def test_workers_and_their_deaths_change_nothing(tmp_path, whole, workers, kill):
    done = over_ray(tmp_path / "shards", "--workers", workers, "--shards", SHARDS, "--kill", kill)
    assert done.returncode == 0, done.stderr
    assert done.stdout == whole


def test_a_driver_that_was_killed_is_resumed(tmp_path, whole):
    folder = tmp_path / "shards"
    words = ["-m", "shadowgauge.ray", *STUDY, "--shard-dir", folder, "--workers", 1, "--shards", SHARDS]
    driver = subprocess.Popen([sys.executable, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    ended = time.monotonic() + 120.0
    while not list(folder.glob("coverage-*.parquet")) and time.monotonic() < ended:
        time.sleep(0.02)
    driver.kill()
    driver.wait()
    there = {path: path.stat().st_mtime_ns for path in folder.glob("coverage-*.parquet")}
    assert 1 <= len(there) < SHARDS, "it was killed in the middle"
    done = over_ray(folder, "--workers", 2, "--shards", SHARDS)
    assert done.returncode == 0, done.stderr
    assert done.stdout == whole
    assert all(path.stat().st_mtime_ns == time_ns for path, time_ns in there.items()), "they are left as they are"


def test_pandas_polars_and_pyarrow_read_a_shard(tmp_path):
    pandas, polars, parquet = map(pytest.importorskip, ["pandas", "polars", "pyarrow.parquet"])
    done = program(*STUDY, "--shard", "2/3", "--shard-dir", tmp_path)
    assert done.returncode == 0, done.stderr
    (path,) = tmp_path.iterdir()
    columns = ["scene", "error_mm", "u_mm", "half_width_mm", "flag"]
    rows = pandas.read_parquet(path)
    assert list(rows) == columns and list(rows["scene"]) == [1, 4, 7]
    assert polars.read_parquet(path)["u_mm"].to_list() == list(rows["u_mm"])
    stated = parquet.read_metadata(path).metadata
    assert stated[b"shadowgauge.shard"] == b"2" and stated[b"shadowgauge.shards"] == b"3"


def test_a_study_that_is_refused_is_not_tried_for_ever(tmp_path):
    pytest.importorskip("ray")
    done = python("-m", "shadowgauge.ray", "study", "coverage", "--scenes", "0", "--workers", "1", "--shards", "1",
                  "--shard-dir", tmp_path)
    assert done.returncode == 3 and "--scenes" in done.stderr
