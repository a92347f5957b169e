# Two commands do all the set-up on a fresh Debian machine with Rust:
#   make demo    the main job: cut, render, measure, correct, cut again -> out/demo/report.html
#   make test    formatting, lints, all tests, doc tests
# Others:  make studies (long measurements -> out/studies; ONLY="coverage edges" for some)   make bench   make bless CASE=all

CARGO ?= cargo
BIN := target/release/shadowgauge

.PHONY: demo test studies bench build vulkan bless

demo: vulkan build
	$(BIN) demo

build:
	$(CARGO) build --release --locked

# Mesa's software Vulkan driver, where it can be had; never an error: without it the CPU path is taken.
vulkan:
	@sh scripts/install_vulkan.sh

# One profile (release) for the program and its tests: what is tested is what is used, and it is compiled once.
test: vulkan
	$(CARGO) fmt --check
	$(CARGO) clippy --release --locked --all-targets -- -D warnings
	$(CARGO) test --release --locked --doc
	@if $(CARGO) nextest --version >/dev/null 2>&1; then \
	  $(CARGO) nextest run --release --locked --no-fail-fast; \
	else \
	  $(CARGO) test --release --locked --lib --bins --tests --no-fail-fast; \
	fi

studies: vulkan build
	ONLY="$(ONLY)" sh scripts/studies.sh

bench:
	$(CARGO) bench --locked

bless:
	BLESS=$(CASE) $(CARGO) test --release --locked --test render_golden
