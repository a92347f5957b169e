"""Rendered frames, and jobs with controllers in Python."""

import numpy as np
import pytest
from conftest import EXAMPLES, SMALL, program, python

import shadowgauge as sg


def test_rendered_frames_have_their_truth():
    frames = list(sg.render(SMALL, 2))
    assert [frame.meta["frame_id"] for frame in frames] == [0, 1]
    edges = sg.Gauge().edges(frames[0].pixels, bits=frames[0].bits)
    assert np.nanmax(np.abs(edges.top_px - frames[0].true_top_px)) < 0.5
    again = next(sg.render(SMALL, 1))
    assert np.array_equal(again.pixels, frames[0].pixels), "the same config and seed give the same bytes"


def test_a_config_that_is_refused_has_the_words_of_the_program(tmp_path):
    (tmp_path / "bad.toml").write_text(SMALL.read_text().replace("length_mm", "lenght_mm", 1))
    with pytest.raises(sg.ConfigError) as refused:
        next(sg.render(tmp_path / "bad.toml"))
    assert "lenght_mm" in str(refused.value) and "bad.toml" in str(refused.value)
    said = program("render", tmp_path / "bad.toml", "--out", tmp_path / "out")
    assert said.returncode == 2 and "lenght_mm" in said.stderr


class Plain:
    """Takes every error off the next pass."""

    def decide(self, measured):
        return measured.offset_mm + np.nan_to_num(measured.error_mm)


def test_a_controller_in_python_corrects_the_part():
    passes = list(sg.run(SMALL, controller=Plain()))
    none = list(sg.run(SMALL, controller="none"))
    assert [p.number for p in passes] == [1, 2]
    worst = [np.max(np.abs(p[-1].stations["true_mm"] - p[-1].stations["nominal_mm"])) for p in (passes, none)]
    assert worst[0] < 0.5 * worst[1]
    assert np.array_equal(passes[0].stations["d_mm"], none[0].stations["d_mm"])
    assert np.any(passes[1].stations["offset_mm"] != 0.0)


class Raises:
    def decide(self, measured):
        raise ValueError("no idea")


class Nan:
    def decide(self, measured):
        return np.full(len(measured.z_mm), np.nan)


class Short:
    def decide(self, measured):
        return [0.0]


class Nothing:
    def decide(self, measured):
        return None


@pytest.mark.parametrize(
    ("controller", "words"), [(Raises, "no idea"), (Nan, "NaN"), (Short, "1 offsets"), (Nothing, "None")]
)
def test_a_controller_that_cannot_decide_is_named_with_its_fault(controller, words):
    with pytest.raises(sg.ControllerError) as failed:
        list(sg.run(SMALL, controller=controller))
    assert words in str(failed.value) and controller.__name__ in str(failed.value)
    if controller is Raises:
        assert isinstance(failed.value.__cause__, ValueError)


def test_an_object_that_is_no_controller_is_refused():
    with pytest.raises(TypeError, match="decide"):
        sg.run(SMALL, controller=object())
    with pytest.raises(sg.SettingError, match="nobody"):
        sg.run(SMALL, controller="nobody")


def test_a_controller_in_python_stands_in_the_study():
    words = ["study", "controllers", SMALL, "--shafts", "1", "--controllers", "pid", "--json", "--backend", "cpu"]
    done = program(*words, "--with", "own_controller:HalfTheError", cwd=EXAMPLES)
    assert done.returncode == 0, done.stderr
    assert "HalfTheError" in done.stdout
    wrong = program(*words, "--with", "own_controller:Missing", cwd=EXAMPLES)
    assert wrong.returncode != 0 and "Missing" in wrong.stderr and "module:Class" in wrong.stderr


def test_the_examples_run(tmp_path):
    done = python(EXAMPLES / "own_controller.py", SMALL)
    assert done.returncode == 0 and "pass 2" in done.stdout, done.stderr
    done = python(EXAMPLES / "choose_optics.py")
    assert done.returncode == 0 and "0.200" in done.stdout, done.stderr
    drawn = program("render", SMALL, "--out", tmp_path / "drawn", "--frames", "3")
    assert drawn.returncode == 0, drawn.stderr
    pytest.importorskip("pandas")
    folder = tmp_path / "drawn" / "frames"
    done = python(EXAMPLES / "follow_folder.py", folder, "30", "0.5", cwd=tmp_path)
    assert done.returncode == 0 and "max_diameter_mm" in done.stdout, done.stderr
