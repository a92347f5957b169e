# Two commands do all the set-up on a fresh Debian machine with Rust:
#   make demo    the main job: cut, render, measure, correct, cut again -> out/demo/report.html
#   make test    formatting, lints, all tests, doc tests
# Others:  make studies (long measurements -> out/studies; ONLY="coverage edges" for some)   make studies-short (ten minutes)
#          make study-limits (half and double of every threshold of the instrument on the same scenes)
#          make pictures (the pictures of the documents -> docs)
#          make reports-check (reports before axe-core in Chromium: contrast, names, small screens)
#          make pages-check (the pages of serve in Chromium: flows, axe-core, widths, weight)   make store-check (kills, full disk, 10^7 stations)
#          make gpu-check (a hardware adapter against the CPU path; needs the built program alone)   make bench   make bless CASE=all
#          make wheel (the Python package -> out/wheel)   make wheel-test (its tests and examples in a venv; TESTS="-k arrays" for some)
#          make peers (this crate beside other software, in venvs below out/peers; ONLY="nose" for some of run, render, nose, camera,
#                      and onnx: the tests of the feature `onnx`)

CARGO ?= cargo
BIN := target/release/shadowgauge

.PHONY: demo test studies studies-short study-limits pictures reports-check pages-check store-check gpu-check peers bench build vulkan bless wheel wheel-test wheel-smoke

# With wgpu at work where a Vulkan driver is (software drivers are taken by name only), else on the CPU path.
demo: vulkan build
	@if $(BIN) doctor --json | grep -q '"backend": "vulkan",'; then set -x; $(BIN) demo --backend vulkan; \
	else echo "no Vulkan driver: the demo is rendered on the CPU path" >&2; set -x; $(BIN) demo --backend cpu; fi

build:
	$(CARGO) build --release --locked

# Mesa's software Vulkan driver, where it can be had; never an error: without it the CPU path is taken.
vulkan:
	@sh scripts/install_vulkan.sh

# One profile (release) for the program and its tests: what is tested is what is used, and it is compiled once. --workspace
# takes the Python package's smoke test (python/tests/smoke.rs) along: its library is linked from the crate as it is compiled
# for the other tests. The variable keeps the interpreter's own library out of it, as maturin does.
test: export PYO3_BUILD_EXTENSION_MODULE := 1
test: vulkan
	$(CARGO) fmt --check
	$(CARGO) clippy --release --locked --all-targets -- -D warnings
	$(CARGO) test --release --locked --doc
	@if $(CARGO) nextest --version >/dev/null 2>&1; then \
	  $(CARGO) nextest run --workspace --release --locked --no-fail-fast; \
	else \
	  $(CARGO) build --release --locked --examples && \
	  $(CARGO) test --workspace --release --locked --lib --bins --tests --no-fail-fast; \
	fi

studies: vulkan build
	ONLY="$(ONLY)" sh scripts/studies.sh

studies-short: build
	sh scripts/studies_short.sh

# Half and double of every threshold of the instrument on the same scenes -> out/study_limits.
study-limits: build
	mkdir -p out/study_limits
	$(BIN) study limits --csv out/study_limits/limits.csv > out/study_limits/limits.txt
	cat out/study_limits/limits.txt

# The pictures of the documents, by the commands that draw them.
pictures: build
	BIN="$(BIN)" sh scripts/pictures.sh

# A report of measure, of a run and of a calibration before axe-core in Debian's Chromium; SKIPPED, loudly, where that is missing.
reports-check: build
	BIN="$(BIN)" sh scripts/reports_check.sh

# Every page and flow of `serve` in Debian's Chromium: axe-core, two widths, light and dark, pictures in out/pages_check/pictures.
pages-check: build
	BIN="$(BIN)" sh scripts/pages_check.sh

# A hundred kills, a full disk, ten million stations: what the store promises, at length.
store-check:
	CARGO="$(CARGO)" sh scripts/store_check.sh

# Goldens and benches on a hardware adapter, beside the CPU path: needs the built program alone (BIN=PATH), no Rust and no network.
gpu-check:
	@test -x $(BIN) || { echo "no program at $(BIN): build it (make build) or name it (make gpu-check BIN=PATH)" >&2; exit 2; }
	$(BIN) doctor --gpu-check

bench:
	$(CARGO) bench --locked

# Beside other software on the same frames, each script with a venv of its own -> out/peers/NAME.txt; needs Python and PyPI.
peers: build
	@mkdir -p out/peers
	@for name in $(or $(ONLY),run render nose camera onnx); do \
	  VENVS="$(CURDIR)/out/peers" sh benches/peers/$$name.sh > out/peers/$$name.txt && cat out/peers/$$name.txt || exit 1; \
	done

bless:
	BLESS=$(CASE) $(CARGO) test --release --locked --lib render_golden

PYTHON ?= python3
WHEEL := out/wheel
TESTS ?=

# The Python package, one wheel for Python 3.10 and later, with the program's dependencies as they are compiled.
wheel:
	test -x $(WHEEL)/venv/bin/python || $(PYTHON) -m venv $(WHEEL)/venv
	$(WHEEL)/venv/bin/pip install --quiet 'maturin>=1.9,<2'
	rm -f $(WHEEL)/*.whl
	$(WHEEL)/venv/bin/maturin build --release --locked --compression-level 9 --manifest-path python/Cargo.toml --out $(WHEEL)

# Everything of the package: tables in pandas, polars and pyarrow, a local Ray cluster, the examples.
wheel-test: wheel
	$(WHEEL)/venv/bin/pip install --quiet pytest pandas polars pyarrow matplotlib ray
	$(WHEEL)/venv/bin/pip install --quiet --force-reinstall --no-deps $(WHEEL)/*.whl
	$(WHEEL)/venv/bin/python -m pytest -q python/tests $(TESTS)

# The part of it that needs NumPy alone and takes seconds.
wheel-smoke: wheel
	$(WHEEL)/venv/bin/pip install --quiet pytest numpy
	$(WHEEL)/venv/bin/pip install --quiet --force-reinstall --no-deps $(WHEEL)/*.whl
	$(WHEEL)/venv/bin/python -m pytest -q python/tests/test_arrays.py python/tests/test_streams.py
