# Two commands do everything on a machine that has only Python (3.11 or newer) and make:
#   make demo    set up, filter a turning program, explain it and show what changed
#   make test    set up and run all tests
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
SAMPLE := samples/turning.nc
PROFILE := generic-lathe

.PHONY: demo test lint bench wheel clean

$(BIN)/chipbreak: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable .
	$(BIN)/python -m compileall -q src
	@touch $@

$(VENV)/.dev: $(BIN)/chipbreak
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch $@

demo: $(BIN)/chipbreak
	$(BIN)/chipbreak filter -p $(PROFILE) $(SAMPLE) -o $(VENV)/turning.out.nc
	$(BIN)/chipbreak explain -p $(PROFILE) $(SAMPLE)
	@echo
	$(BIN)/chipbreak diff $(SAMPLE) $(VENV)/turning.out.nc || test $$? = 1  # they differ
	@echo
	@echo "The corrected program is $(VENV)/turning.out.nc"

test: $(VENV)/.dev
	@sh tests/linuxcnc/install.sh
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/pytest -n auto

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/mypy

$(VENV)/.bench: $(VENV)/.dev
	$(BIN)/python -m pip install --quiet --editable '.[dev,bench]'
	@touch $@

bench: $(VENV)/.bench
	$(BIN)/python benchmarks/run.py --json benchmarks/results.json

wheel: $(VENV)/.dev
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .

clean:
	rm -rf $(VENV) dist build .pytest_cache .hypothesis .mypy_cache .ruff_cache
