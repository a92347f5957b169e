"""shadowgauge: a vision-based in-process optical diameter gauge.

Frames are NumPy arrays of rows x columns (uint8, uint16 or float32), read without a copy. All names
have their units: ``d_mm``, ``u_um``, ``angle_deg``. Uncertainties are standard uncertainties (k = 1)
where nothing else is said.

    gauge = Gauge()                                   one frame: gauge.edges, gauge.measure
    Stream(gauge, calibration)                        many frames of one camera
    Calibration.from_scale, .load, .fit               pixels to millimetres
    render(config)                                    frames of a config's shaft, with their truth
    run(config, controller=mine)                      a job, pass after pass, with your controller
    study("coverage", scenes=100)                     what ``shadowgauge study`` computes
    read_image(path), follow_folder(path)             frames from files
"""

try:
    import numpy as _numpy  # noqa: F401
except ImportError as error:
    from .errors import MissingPackage

    raise MissingPackage("shadowgauge needs NumPy, and this Python has none: pip install numpy") from error

from ._shadowgauge import Edges, Measurement, Table, __version__
from .calibration import Calibration
from .controller import Hold, MeasuredPass
from .errors import (
    CalibrationError,
    ConfigError,
    ControllerError,
    Error,
    FrameError,
    FrameRefused,
    MissingPackage,
    SettingError,
    StudyError,
)
from .frames import Frame, follow_folder, read_image
from .gauge import Gauge, Stream
from .jobs import PassResult, run
from .rendering import RenderedFrame, render
from .studies import study

__all__ = [
    "Calibration",
    "CalibrationError",
    "ConfigError",
    "ControllerError",
    "Edges",
    "Error",
    "Frame",
    "FrameError",
    "FrameRefused",
    "Gauge",
    "Hold",
    "Measurement",
    "MeasuredPass",
    "MissingPackage",
    "PassResult",
    "RenderedFrame",
    "SettingError",
    "Stream",
    "StudyError",
    "Table",
    "__version__",
    "follow_folder",
    "read_image",
    "render",
    "run",
    "study",
]
