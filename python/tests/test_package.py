"""The package: version, stubs, import without NumPy, size, Ctrl-C."""

import ast
import inspect
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

from conftest import ROOT, SMALL, program, python

import shadowgauge as sg
from shadowgauge import _shadowgauge


def test_the_version_is_the_crates():
    manifest = (ROOT / "Cargo.toml").read_text()
    assert sg.__version__ == re.search(r'^version = "(.*)"', manifest, re.MULTILINE).group(1)
    assert program("--version").stdout.split() == ["shadowgauge", sg.__version__]


def test_every_native_name_has_a_stub_and_a_docstring():
    stub = (Path(sg.__file__).parent / "_shadowgauge.pyi").read_text()
    for name, value in vars(_shadowgauge).items():
        if name.startswith("__"):
            continue
        assert re.search(rf"^(class|def) {name}\b", stub, re.MULTILINE), name
        assert inspect.getdoc(value), name
        if inspect.isclass(value):
            for method in vars(value):
                if not method.startswith("__"):
                    assert re.search(rf"def {method}\b", stub), f"{name}.{method}"
                    assert inspect.getdoc(getattr(value, method)), f"{name}.{method}"


def test_every_name_of_the_stub_exists():
    stub = ast.parse((Path(sg.__file__).parent / "_shadowgauge.pyi").read_text())
    named = [node for node in stub.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))]
    assert len(named) >= 10
    for node in named:
        native = getattr(_shadowgauge, node.name)
        for method in node.body if isinstance(node, ast.ClassDef) else []:
            if isinstance(method, ast.FunctionDef):
                assert hasattr(native, method.name), f"{node.name}.{method.name}"


def test_every_public_name_is_documented():
    for name in sg.__all__:
        assert name == "__version__" or inspect.getdoc(getattr(sg, name)), name


def test_a_python_without_numpy_is_told_what_to_install():
    code = "import sys; sys.modules['numpy'] = None\nimport shadowgauge"
    done = python("-c", code)
    assert done.returncode != 0 and "pip install numpy" in done.stderr


def test_import_takes_a_moment():
    code = "import numpy, time; t = time.perf_counter(); import shadowgauge; print(time.perf_counter() - t)"
    assert float(python("-c", code).stdout) < 0.3


def heed_interrupts():
    """A shell's background jobs, these tests among them, ignore Ctrl-C, and their children do."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def test_ctrl_c_ends_a_job_and_the_command_line():
    code = f"import shadowgauge as sg\nprint('go', flush=True)\nfor _ in range(9999): list(sg.run({str(SMALL)!r}))"
    for words in (["-c", code], ["-m", "shadowgauge", "study", "coverage", "--scenes", "1000000"]):
        process = subprocess.Popen(
            [sys.executable, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=heed_interrupts
        )
        if words[0] == "-c":
            process.stdout.readline()
        else:
            time.sleep(2.0)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        assert process.returncode in (-signal.SIGINT, 130, 1), (process.returncode, said)
        assert words[0] == "-m" or b"KeyboardInterrupt" in said


def test_ctrl_c_ends_a_loop_that_measures_and_a_study():
    loop = """
import numpy as np, shadowgauge as sg
frame = np.full((512, 512), 210, np.uint8)
frame[100:400] = 12
stream = sg.Stream(sg.Gauge(), sg.Calibration.from_scale(17.4), keep_rows=False)
print("go", flush=True)
while True:
    stream.push(frame)
"""
    study = "import shadowgauge as sg\nprint('go', flush=True)\nsg.study('coverage', scenes=1000000)"
    for code in (loop, study):
        process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        process.stdout.readline()
        time.sleep(0.5)
        begun = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        assert process.returncode in (-signal.SIGINT, 130) and b"KeyboardInterrupt" in said, (process.returncode, said)
        assert time.monotonic() - begun < 10.0


def test_studies_are_values_and_their_refusals_exceptions():
    figures = sg.study("coverage", scenes=2, classes=None, **{"class": ["noise"]})
    assert figures["classes"][0]["scenes"] == 2
    try:
        sg.study("coverage", scenes=0)
        raise AssertionError("it is refused")
    except sg.StudyError as error:
        assert error.exit_code == 2 and "--scenes" in str(error)
