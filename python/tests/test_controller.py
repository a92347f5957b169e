"""A controller behind lines of JSON, without a job."""

import json

import numpy as np
import pytest

import shadowgauge as sg
from shadowgauge.controller import answers, load

BEGIN = {"type": "begin", "station_z_mm": [1.0, 2.0], "station_relative_mm": [0.0, -4.0]}
READ = {"value": {"d_mm": 26.02, "u_random_mm": 1e-4, "u_common_mm": 2e-4}}
STEP = {"value": {"d_mm": 22.01, "u_random_mm": 1e-4, "u_common_mm": 2e-4}}


def passed(*readings):
    stations = [{"z_mm": float(z), "reading": reading} for z, reading in enumerate(readings, start=1)]
    return json.dumps(
        {"type": "pass", "pass": 1, "nominal_mm": 26.0, "offsets_mm": [0.1, 0.2], "stations": stations, "held": None}
    )


class Seen:
    def __init__(self):
        self.seen = None

    def decide(self, measured):
        self.seen = measured
        return measured.offset_mm


def test_errors_of_a_stepped_shaft_are_each_sections_own():
    controller = Seen()
    answer = answers(controller)
    assert answer(json.dumps(BEGIN)) is None
    assert json.loads(answer(passed(READ, STEP))) == {"pass": 1, "offsets_mm": [0.1, 0.2]}
    assert controller.seen.error_mm == pytest.approx([0.02, 0.01])
    assert answer('{"type": "end"}') is None


def test_a_gap_is_nan_and_a_hold_has_its_reason():
    controller = Seen()
    answers(controller)(passed(READ, {"gap": "contaminated"}))
    assert np.isnan(controller.seen.d_mm).tolist() == [False, True]

    class Holds:
        def decide(self, measured):
            return sg.Hold("chatter")

    assert json.loads(answers(Holds)(passed(READ, READ))) == {"pass": 1, "hold": "chatter"}


def test_a_name_of_a_controller_has_a_module_and_a_class():
    with pytest.raises(ValueError, match="module:Class"):
        load("mine")
