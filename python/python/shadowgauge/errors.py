"""The exceptions of shadowgauge, with the words of the library and of the program."""


class Error(Exception):
    """What shadowgauge raises; the classes below are its kinds."""


class SettingError(Error, ValueError):
    """A setting that is unknown, of the wrong type or out of its range."""


class ConfigError(Error, ValueError):
    """A config that is refused: the file, the key, and what would be right."""


class CalibrationError(Error, ValueError):
    """A calibration that cannot be fitted, read or used."""


class FrameError(Error, ValueError):
    """An array that cannot be read as a frame: its dtype, shape and strides, and what would be right."""


class FrameRefused(Error):
    """A frame that shows no part with two edges; ``measurement`` is what is known of it."""

    measurement = None


class ControllerError(Error):
    """A controller that raised, or whose reply is none; what it raised is the cause."""


class MissingPackage(Error, ImportError):
    """A package that is not installed, and how to install it."""


class StudyError(Error):
    """A study that the program refuses (``exit_code`` 2) or that fails (3), in the program's words."""

    exit_code = None
