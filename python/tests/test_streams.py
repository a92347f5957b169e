"""Streams, sources and tables."""

import threading
import time

import numpy as np
import pytest
from conftest import shadow

import shadowgauge as sg

SCALE = sg.Calibration.from_scale(17.4)


def growing(count):
    """A source of one's own: a shaft that grows by two pixels a frame, and one frame without it."""
    for number in range(count):
        if number == 2:
            yield np.full((140, 64), 200, np.uint8)
        else:
            yield sg.Frame(shadow(bottom=90.5 + 2 * number), {"frame_id": number, "angle_deg": 10.0 * number})


def table():
    stream = sg.Stream(sg.Gauge(), SCALE)
    measured = list(stream.measure(growing(5)))
    assert [m.refusal is None for m in measured] == [True, True, False, True, True]
    return stream.table(), stream


def test_a_source_in_python_is_measured():
    rows, stream = table()
    assert list(rows["frame_id"]) == [0, 1, 2, 3, 4]
    steps_um = 1e3 * np.diff(rows["max_diameter_mm"])
    assert steps_um[[0, 3]] == pytest.approx([34.8, 34.8], abs=0.5)
    assert np.isnan(rows["max_diameter_mm"][2]) and rows["flag"][2] != "" and rows["flag"][0] == ""
    assert rows["angle_deg"][3] == 30.0
    assert "statistics" in stream.finish()
    with pytest.raises(sg.Error, match="finished"):
        stream.push(shadow())


def test_what_a_source_raises_comes_out():
    def broken():
        yield shadow()
        raise OSError("the cable is out")

    with pytest.raises(OSError, match="the cable is out"):
        list(sg.Stream(sg.Gauge(), SCALE).measure(broken()))


def test_pandas_polars_and_pyarrow_read_the_tables():
    pandas, polars, pyarrow = map(pytest.importorskip, ["pandas", "polars", "pyarrow"])
    rows, _ = table()
    arrow = pyarrow.table(rows)
    assert arrow.column_names == rows.keys() and arrow.num_rows == 5
    assert pyarrow.record_batch(rows).num_rows == 5
    frames = polars.DataFrame(rows)
    assert frames["flag"].to_list() == list(rows["flag"])
    assert frames["max_diameter_mm"][0] == rows["max_diameter_mm"][0]
    # Which dtype text has depends on the version of pandas.
    pandas.testing.assert_frame_equal(pandas.DataFrame(dict(rows)), arrow.to_pandas(), check_dtype=False)
    del rows
    assert arrow["frame_id"].to_pylist() == [0, 1, 2, 3, 4], "the memory outlives the table"


def test_unknown_settings_and_keys_are_named():
    with pytest.raises(sg.SettingError, match="stretch_cm"):
        sg.Stream(sg.Gauge(), SCALE, stretch_cm=3)
    with pytest.raises(sg.SettingError, match="blurr"):
        sg.Gauge({"blurr": 1})
    with pytest.raises(sg.FrameError, match="angle_rad"):
        sg.Stream(sg.Gauge(), SCALE).push(shadow(), angle_rad=1.0)
    with pytest.raises(sg.SettingError, match="um_per_px"):
        sg.Calibration.from_scale(-1.0)


def test_the_lock_is_released_while_measuring():
    frames = [shadow(2048, 2048, top=500.5, bottom=1499.5) for _ in range(2)]
    counted = threading.Event()
    seen = []

    def count():
        while not counted.is_set():
            seen.append(time.perf_counter())
            time.sleep(0)

    other = threading.Thread(target=count)
    stream = sg.Stream(sg.Gauge(), SCALE)
    stream.push(frames[0])
    other.start()
    begun = time.perf_counter()
    for _ in range(5):
        stream.push(frames[1])
    ended = time.perf_counter()
    counted.set()
    other.join()
    assert any(begun < at < ended for at in seen)


def test_two_pins_calibrate():
    gauge = sg.Gauge()
    pins = [(40 * 0.02, 1e-4, 80.5), (60 * 0.02, 1e-4, 100.5)]
    fitted = sg.Calibration.fit([(d, u, [gauge.edges(shadow(bottom=bottom))]) for d, u, bottom in pins])
    assert fitted.scale_um_per_px == pytest.approx(20.0, rel=1e-3)


def test_a_calibration_file_is_read_again(tmp_path):
    SCALE.save(tmp_path / "scale.json")
    assert sg.Calibration.load(tmp_path / "scale.json").scale_um_per_px == SCALE.scale_um_per_px
    (tmp_path / "none.json").write_text("{}")
    with pytest.raises(sg.CalibrationError, match="none.json"):
        sg.Calibration.load(tmp_path / "none.json")


def test_a_folder_is_followed(tmp_path):
    def write(number):
        header = b"P5\n64 140\n255\n"
        (tmp_path / f"frame{number}.pgm").write_bytes(header + shadow(bottom=90.5 + number).tobytes())

    for number in (9, 10):
        write(number)
    late = threading.Timer(0.2, write, [11])
    late.start()
    names = [frame.name for frame in sg.follow_folder(tmp_path, idle_s=1.0)]
    assert names == ["frame9", "frame10", "frame11"]
