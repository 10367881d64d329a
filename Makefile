# Everything runs in .venv, which the first target that needs it creates. `make` alone lists the targets.

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
SOURCES := pyproject.toml

# GTSAM has wheels for CPython 3.11 to 3.14: take the first interpreter in that range. Override with PYTHON=...
IN_RANGE := import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.14 python3.11 python; do \
	"$$p" -c '$(IN_RANGE)' 2>/dev/null && { command -v "$$p"; break; }; done)

# One thread for linear algebra: the fastest at these matrix sizes, and two test workers do not get in each other's way.
export OMP_NUM_THREADS ?= 1

.PHONY: help demo test bench pages docs clean
.DELETE_ON_ERROR:

help:
	@echo "make demo   solve a shipped log, write pictures into navfix-demo/"
	@echo "make test   everything that CI runs: format, lint, types, layers, tests with coverage"
	@echo "make bench  the long studies and the timings (minutes)"
	@echo "make pages  write again what is generated: validation page, data list, first example, output and picture in README"
	@echo "make docs   the documentation as a site, in site/"
	@echo "make clean  remove .venv and everything that was built"

demo: $(VENV)/.installed
	$(BIN)/navfix demo

# Counting lines doubles the time of what computes long: the Monte Carlo runs and replays go without.
test: $(VENV)/.test
	$(BIN)/python -m ruff format --check .
	$(BIN)/python -m ruff check .
	$(BIN)/python -m mypy
	$(BIN)/lint-imports
	$(BIN)/python -m pytest -n 2 -m "not study" tests/montecarlo tests/replay
	$(BIN)/python -m pytest -n 2 -m "not study" --cov=navfix --cov-report=term:skip-covered \
		--ignore=tests/montecarlo --ignore=tests/replay

# pytest ends with 5 where nothing is marked: not an error here.
bench: $(VENV)/.dev
	$(BIN)/python -m pytest -m study -s || [ $$? -eq 5 ]
	@for script in tests/benchmarks/*.py; do \
		[ -e "$$script" ] || continue; echo "== $$script"; $(BIN)/python "$$script" || exit 1; done

pages: $(VENV)/.installed
	$(BIN)/python docs/make_validation.py
	$(BIN)/python docs/make_data_page.py
	$(BIN)/python docs/make_readme.py
	$(BIN)/python docs/make_first_example.py

docs: $(VENV)/.docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict

clean:
	rm -rf $(VENV) build dist site navfix-demo .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .coverage

# pip >= 25.1 knows dependency groups.
$(VENV)/.pip: $(SOURCES)
	@[ -n "$(PYTHON)" ] && "$(PYTHON)" -c '$(IN_RANGE)' || { \
		echo "navfix needs CPython 3.11 to 3.14, found: $$(python3 --version 2>&1). Name one: make PYTHON=/path/to/python3.12" >&2; exit 1; }
	@"$(PYTHON)" -m venv $(VENV) || { \
		rm -rf $(VENV); echo "$(PYTHON) cannot make a virtual environment (on Debian and Ubuntu: apt install python3-venv)" >&2; exit 1; }
	$(PIP) install --quiet --upgrade "pip>=25.1"
	@touch $@

$(VENV)/.installed: $(VENV)/.pip
	$(PIP) install --quiet --editable .
	@touch $@

$(VENV)/.test: $(VENV)/.installed
	$(PIP) install --quiet --group test
	@touch $@

$(VENV)/.dev: $(VENV)/.installed
	$(PIP) install --quiet --group dev
	@touch $@

$(VENV)/.docs: $(VENV)/.installed
	$(PIP) install --quiet --group docs
	@touch $@
