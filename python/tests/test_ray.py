"""Studies over a local Ray cluster: the same bytes whatever the workers do."""

import pytest
from conftest import program, python

STUDY = ["study", "coverage", "--scenes", "2", "--class", "noise"]


def over_ray(folder, *words):
    return python("-m", "shadowgauge.ray", *STUDY, "--shard-dir", folder, *words)


def test_without_ray_the_remedy_is_named():
    code = "import sys; sys.modules['ray'] = None\nfrom shadowgauge.ray import main; sys.exit(main(['study', 'coverage']))"
    done = python("-c", code)
    assert done.returncode == 2 and "pip install" in done.stderr


@pytest.mark.parametrize(("workers", "kill"), [(1, 0.0), (2, 0.3)])
def test_workers_and_their_deaths_change_nothing(tmp_path, workers, kill):
    pytest.importorskip("ray")
    whole = program(*STUDY)
    done = over_ray(tmp_path / "shards", "--workers", workers, "--shards", 2, "--kill", kill)
    assert done.returncode == whole.returncode == 0, done.stderr
    assert done.stdout == whole.stdout
    again = over_ray(tmp_path / "shards", "--workers", workers, "--shards", 2)
    assert again.stdout == whole.stdout, "resumed"


def test_a_study_that_is_refused_is_not_tried_for_ever(tmp_path):
    pytest.importorskip("ray")
    done = python("-m", "shadowgauge.ray", "study", "coverage", "--scenes", "0", "--workers", "1", "--shards", "1",
                  "--shard-dir", tmp_path)
    assert done.returncode == 3 and "--scenes" in done.stderr
