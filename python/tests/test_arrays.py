"""Arrays of every layout: the values of a plain copy, or an exception that names dtype and strides."""

import json

import numpy as np
import pytest
from conftest import program, shadow

import shadowgauge as sg

SCALE = sg.Calibration.from_scale(17.4)


def diameter(array, **options):
    return sg.Gauge().measure(array, SCALE, **options).max_diameter_mm


def test_a_width_is_known(frame):
    assert diameter(frame) == pytest.approx(59 * 0.0174, abs=1e-3)
    edges = sg.Gauge().edges(frame)
    assert edges.width_px == pytest.approx(np.full(64, 59.0), abs=0.05)
    assert len(edges) == edges.valid == 64


def padded(frame):
    whole = np.zeros((frame.shape[0], frame.shape[1] + 7), frame.dtype)
    whole[:, 3:-4] = frame
    return whole[:, 3:-4]


def read_only(frame):
    frame = frame.copy()
    frame.flags.writeable = False
    return frame


def every_other(frame):
    return np.repeat(np.repeat(frame, 2, axis=0), 3, axis=1)[::2, ::3]


@pytest.mark.parametrize("laid", [padded, read_only, every_other, np.asfortranarray])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_view_measures_as_its_copy(laid, dtype):
    plain = shadow(dtype=dtype)
    view = laid(plain)
    assert np.array_equal(view, plain)
    assert diameter(view) == diameter(plain)
    assert np.array_equal(sg.Gauge().edges(view).top_px, sg.Gauge().edges(plain).top_px)


def test_a_transposed_frame_is_a_vertical_shaft(frame):
    upright = np.ascontiguousarray(frame.T)
    assert diameter(upright, vertical=True) == diameter(frame)
    assert diameter(frame.T, vertical=True) == diameter(frame)


def test_the_command_line_reads_the_same(tmp_path, frame):
    header = f"P5\n{frame.shape[1]} {frame.shape[0]}\n255\n".encode()
    (tmp_path / "frame1.pgm").write_bytes(header + frame.tobytes())
    done = program("measure", tmp_path / "frame1.pgm", "--um-per-px", "17.4", "--json")
    assert done.returncode == 0, done.stderr
    (expected,) = json.loads(done.stdout)["frames"]
    read = sg.read_image(tmp_path / "frame1.pgm")
    assert np.array_equal(read.pixels, frame)
    assert diameter(read.pixels) == expected["max_diameter_mm"]


REFUSED = [
    (lambda f: f[::-1], ["uint8", "|u1", "-64", "negative"]),
    (lambda f: f[:, ::-1], ["-1", "negative"]),
    (lambda f: f.astype(">u2"), [">u2", "other order"]),
    (lambda f: f.astype(np.float16), ["<f2", "strides"]),
    (lambda f: f.astype(np.float64), ["<f8", "float32"]),
    (lambda f: f.astype(np.int32), ["<i4", "uint16"]),
    (lambda f: f > 100, ["|b1"]),
    (lambda f: f[0], ["1", "two dimensions"]),
    (lambda f: np.stack([f] * 3, axis=-1), ["3", "one channel"]),
    (lambda f: f[:0], ["no pixel"]),
    (lambda f: np.broadcast_to(f[:, :1], f.shape), ["stride is 0"]),
    (lambda f: f.tolist(), ["list"]),
    (lambda f: None, ["NoneType"]),
]


@pytest.mark.parametrize(("spoilt", "words"), REFUSED)
def test_what_cannot_be_viewed_is_refused_with_its_type_and_strides(frame, spoilt, words):
    with pytest.raises(sg.FrameError) as refused:
        diameter(spoilt(frame))
    for word in words[1:] if words[0] == "uint8" else words:
        assert word in str(refused.value)


def test_a_depth_that_does_not_fit_is_refused(frame):
    with pytest.raises(sg.FrameError, match="bits = 12"):
        diameter(frame, bits=12)
    assert diameter(shadow(dtype=np.uint16), bits=10) > 1.0


def test_a_frame_without_a_part_is_refused_in_words():
    with pytest.raises(sg.FrameRefused) as refused:
        sg.Gauge().edges(np.full((140, 64), 200, np.uint8))
    assert str(refused.value)
