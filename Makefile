# Two commands do everything on a machine that has only Python (3.11 or newer) and make:
#   make demo    set up, filter a turning program, explain it and show what changed
#   make test    set up and run the tests: the same ones every time
# one that looks at many more cases of the same, and one that is never the same:
#   make test-long
#   make fuzz    search with new seeds for FUZZ_SECONDS
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
SAMPLE := samples/turning.nc
PROFILE := generic-lathe
CODE := src tests benchmarks
FUZZ_SECONDS ?= 120
# Runs on simulated machines wait more than they compute.
CORES := $(shell $(PYTHON) -c 'import os; print(os.cpu_count() or 1)')
WORKERS := $(shell expr 2 '*' $(CORES))
# So do runs of a cluster and of other processes, but less.
MEASURING := $(shell expr 3 '*' $(CORES) / 2)
# Otherwise each of them, and each Python that a test starts, compiles everything anew.
export PYTHONDONTWRITEBYTECODE :=
SUBMAKE := $(MAKE) --no-print-directory

.PHONY: test-long judges linuxcnc klipper compiled-tests lock machine-test real-control demo test check-table fuzz lint mutants man site cookbook diagnostics test-pythons hooks bench wheel release-dry-run clean

# pip comes last into a new environment.
$(BIN)/pip:
	$(PYTHON) -m venv $(VENV)

$(BIN)/chipbreak: pyproject.toml | $(BIN)/pip
	$(BIN)/python -m pip install --quiet --editable .
	$(BIN)/python -m compileall -q src
	@touch $@

# Every tool by its version and hash: the same ones everywhere, every time.  Among them is what builds the project, which
# is therefore installed once and without an environment for that alone.
$(VENV)/.dev: pyproject.toml tests/requirements.txt | $(BIN)/pip
	$(BIN)/python -m pip install --quiet --no-compile --require-hashes --requirement tests/requirements.txt
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	$(BIN)/python -m compileall -q src
	@touch $(BIN)/chipbreak $@

# Newer tools: resolves them anew, for every Python and system at once.
RESOLVE = $(BIN)/uv pip compile --quiet --upgrade --universal --generate-hashes --no-header --no-annotate \
	--python-version 3.11 --no-emit-package chipbreak pyproject.toml
lock: $(BIN)/chipbreak
	$(BIN)/python -m pip install --quiet uv
	$(RESOLVE) --extra dev --output-file tests/requirements.txt
	$(RESOLVE) --extra bench --constraint tests/requirements.txt --output-file benchmarks/requirements.txt
	$(RESOLVE) --extra mutants --constraint tests/requirements.txt --output-file tests/mutants-requirements.txt

demo: $(BIN)/chipbreak
	$(BIN)/chipbreak filter -p $(PROFILE) $(SAMPLE) -o $(VENV)/turning.out.nc
	$(BIN)/chipbreak explain -p $(PROFILE) $(SAMPLE)
	@echo
	$(BIN)/chipbreak diff $(SAMPLE) $(VENV)/turning.out.nc || test $$? = 1  # they differ
	@echo
	@echo "The corrected program is $(VENV)/turning.out.nc"

# What needs neither LinuxCNC nor Klipper; "make test-pythons" runs it on every Python.
FAST := tests/test_advise.py tests/test_api.py tests/test_bad.py tests/test_bounds.py tests/test_cases.py \
	tests/test_cli.py tests/test_faults.py tests/test_long_files.py tests/test_messages.py tests/test_outcome.py tests/test_streams.py \
	tests/batch tests/checks tests/cycle_time tests/cycles tests/dialects tests/editing tests/figures tests/hooks \
	tests/machine_files tests/machine_test tests/model tests/operations/test_kinds.py \
	tests/operations/test_linear_pattern.py tests/passes tests/restart tests/settings tests/text tests/tools \
	tests/trajectory tests/syntax/test_blocks.py tests/vibration/test_several_paths.py \
	tests/vibration/test_wishes.py tests/vibration/test_left_cuts.py tests/vibration/test_large_changes.py \
	tests/vibration/test_refusals.py

# Coverage is measured on these, because that takes half as long again: all others reach little that these do not.
MEASURED := tests/test_advise.py tests/test_api.py tests/test_bad.py tests/test_cases.py tests/test_cli.py \
	tests/test_long_files.py tests/test_outcome.py tests/test_streams.py tests/batch/test_batch.py \
	tests/checks/test_calls.py tests/checks/test_clashes.py tests/checks/test_makers.py \
	tests/checks/test_plan.py tests/checks/test_tool_data.py tests/checks/test_touch_plate.py \
	tests/cycle_time/test_cycle_time.py tests/cycles/test_any_words.py tests/cycles/test_corner_runs.py \
	tests/cycles/test_patterns.py tests/cycles/test_pecks.py \
	tests/cycles/test_single_passes.py tests/cycles/test_unrolling.py tests/dialects/test_dialect_plug_ins.py \
	tests/editing/test_diff.py tests/editing/test_diff_shop.py tests/figures/test_figures.py \
	tests/hooks/test_hooks.py tests/hooks/test_notes.py tests/machine_files/test_fanuc_parameters.py \
	tests/machine_files/test_linuxcnc_ini.py tests/machine_files/test_profile_commands.py \
	tests/machine_test/test_machine_test.py tests/model/test_callers.py \
	tests/model/test_code_systems.py tests/model/test_modes.py tests/model/test_offsets.py \
	tests/model/test_shown_points.py tests/model/test_stops.py tests/model/test_words_beside_codes.py \
	tests/operations/test_kinds.py tests/operations/test_linear_pattern.py tests/passes/test_contract.py \
	tests/passes/test_plug_ins.py tests/restart/test_resume.py tests/settings/test_settings.py \
	tests/settings/test_spindle_codes.py tests/text/test_record.py tests/tools/test_plug_ins.py \
	tests/tools/test_tool_commands.py tests/tools/test_tool_readers.py tests/tools/test_tool_sources.py \
	tests/trajectory/test_junction.py tests/trajectory/test_planner.py tests/trajectory/test_stretches.py \
	tests/vibration/test_large_changes.py tests/vibration/test_several_paths.py

# What others wrote, to judge by.
judges: linuxcnc klipper
linuxcnc:
	@sh tests/linuxcnc/install.sh
klipper:
	@sh tests/klipper/install.sh $(VENV)/klipper

# Once, before all workers do it at the same time.
compiled-tests: $(VENV)/.dev
	@$(BIN)/pytest --collect-only -qq > /dev/null || true  # what is wrong, the tests themselves say

# Workers are more than cores: threads of theirs would only wait for each other.
test test-long: export OPENBLAS_NUM_THREADS := 1
test:
	@$(SUBMAKE) -j 2 $(VENV)/.dev judges
	@$(SUBMAKE) -j 2 lint compiled-tests
	$(BIN)/pytest -n $(MEASURING) --dist worksteal -m "not long" --cov --cov-report= $(MEASURED)
	$(BIN)/pytest -n $(WORKERS) --dist worksteal -m "not long" $(MEASURED:%=--ignore=%)

# What "make test" has a choice of: every tool, every drawn cut, every program.
test-long: $(VENV)/.dev judges
	$(BIN)/pytest -n $(WORKERS) --dist worksteal -m long
	$(BIN)/pytest -n $(WORKERS) --dist worksteal -m "hypothesis and not long" --hypothesis-profile=many

# Faults, tools, controls, units and speeds: the macros and numpy must say the same (some minutes).
check-table: $(VENV)/.dev
	$(BIN)/python tests/macros/table.py
	$(BIN)/python tests/macros/table.py --random 1000
	$(BIN)/python tests/macros/table.py --linuxcnc

fuzz: $(VENV)/.dev
	$(BIN)/python tests/fuzz.py $(FUZZ_SECONDS)
	$(BIN)/python tests/fuzz_inputs.py $(FUZZ_SECONDS)

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check $(CODE)
	$(BIN)/mypy
	$(BIN)/complexipy --failed --color no $(CODE)

# Changes of the code at random places: does a test notice? (an hour; tests/mutants.py alone takes a room and a number)
mutants: $(VENV)/.dev
	$(BIN)/python -m pip install --quiet --require-hashes --requirement tests/mutants-requirements.txt
	$(BIN)/python tests/mutants.py all

test-pythons:
	sh tests/pythons.sh $(VENV) -m "not long" $(FAST)

# Checks before every commit, with the tools of this environment.
hooks: $(VENV)/.dev
	$(BIN)/python -m pip install --quiet pre-commit
	$(BIN)/pre-commit install

$(VENV)/.bench: $(VENV)/.dev benchmarks/requirements.txt
	$(BIN)/python -m pip install --quiet --require-hashes --requirement benchmarks/requirements.txt
	@touch $@

bench: $(VENV)/.bench
	$(BIN)/python benchmarks/run.py --json benchmarks/results.json

# Cuts drawn at random on LinuxCNC's simulated machine, and the tables of docs/real-control.md; needs root.
real-control: $(VENV)/.dev
	$(BIN)/python benchmarks/real_control.py --write

# Machines drawn at random, measured by the machine test, and new cuts on them (some minutes).
machine-test: $(VENV)/.dev
	$(BIN)/python benchmarks/machine_test.py

wheel: $(VENV)/.dev
	rm -f dist/chipbreak-*.whl
	$(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir dist .

# Manual pages in build/man, from the text of the commands themselves.
man: $(VENV)/.dev
	mkdir -p build/man
	$(BIN)/python -c "from click_man.core import write_man_pages as w; import chipbreak; from chipbreak.cli import cli; \
	    w('chipbreak', cli, version=chipbreak.__version__, target_dir='build/man')"

# The table and the figures of docs/cookbook.md, by the commands that stand in it.
cookbook: $(VENV)/.dev
	$(BIN)/python benchmarks/cookbook.py

# docs/diagnostics.md, from docs/diagnostics.toml and what is said of the programs in tests/bad.
diagnostics: $(VENV)/.dev
	$(BIN)/python benchmarks/diagnostics_page.py

# The pages as a site in build/site, looked after.  With --quiet mkdocs would not count what --strict forbids.
site: $(VENV)/.dev
	$(BIN)/python -m pip install --quiet mkdocs-material
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	$(BIN)/pytest --quiet tests/test_site.py

# Everything of a release but the upload; VERSION=1.2.3 tries it under that number.
release-dry-run:
	sh tests/release_dry_run.sh $(PYTHON) $(VERSION)

clean:
	rm -rf $(VENV) dist build .pytest_cache .hypothesis .mypy_cache .ruff_cache .complexipy_cache .coverage
