# Everything a checkout needs: `make help`.
# The environment is .venv; it is installed again only when pyproject.toml or constraints.txt change.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin

# The pins are those of Python 3.11; newer versions of Python take the newest packages pyproject.toml allows.
PINS = $(shell $(BIN)/python -c "import sys; print('-c constraints.txt' if sys.version_info[:2] == (3, 11) else '')")
INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check $(PINS)

# Where it is set, every command that a test starts compiles all modules again: a second each.
export PYTHONDONTWRITEBYTECODE =

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo test test-all coverage lint check nightly objects bench gallery reference docs clean

help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-9s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

demo: $(VENV)/.installed  ## install into .venv and compute the first map
	$(BIN)/stickslip run configs/quickstart.yaml

test: $(VENV)/.installed-test  ## run the tests by day, on all processors: minutes, with four kernels that are compiled first
	$(BIN)/python -m pytest -n auto --dist worksteal -m "not slow" $(ARGS)

SEED ?= $(shell date +%Y%j)
CELLS ?= 1000
FITS ?= 500
test-all: $(VENV)/.installed-test  ## run all tests, slow ones and other laws too, with fresh seeds; random cells against a judge; fits
	HYPOTHESIS_PROFILE=fresh STICKSLIP_SEED=$(SEED) $(BIN)/python -m pytest -n auto --dist worksteal $(ARGS)
	$(BIN)/python tests/adversary.py --cells $(CELLS) --seed $(SEED)
	PYTHONPATH=sweep:kernels $(BIN)/python tests/fit_coverage.py --fits $(FITS) --seed $(SEED)
	PYTHONPATH=sweep:kernels $(BIN)/python tests/rig_friction_coverage.py --records $(FITS) --seed $(SEED)

coverage: $(VENV)/.installed-test  ## which lines and branches of sweep/ the tests run, those in other processes included
	$(BIN)/coverage erase
	$(BIN)/coverage run -m pytest -n auto --dist worksteal -m "not slow" $(ARGS)
	$(BIN)/coverage combine --quiet
	$(BIN)/coverage report

lint: $(VENV)/.installed-test  ## lint, formatting and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

check: lint test  ## what continuous integration runs

nightly:  ## test-all with 10,000 random cells and 5,000 fits
	$(MAKE) test-all CELLS=10000 FITS=5000

objects: $(VENV)/.installed  ## kernels for all processors of this kind, for a wheel to bring (five minutes); then build it
	$(BIN)/python benchmarks/objects.py

bench: $(VENV)/.installed-bench  ## measure speed beside other solvers into benchmarks/results/ (five minutes)
	$(BIN)/python benchmarks/run.py $(ARGS)

gallery: $(VENV)/.installed  ## compute the figures of docs/gallery.md again
	PYTHONPATH=docs $(BIN)/python -m article --page docs/gallery.md

reference: $(VENV)/.installed  ## write again what pages of docs/ take from the code: tables, outputs, pictures
	PYTHONPATH=docs $(BIN)/python -m making docs $(ARGS)

docs: $(VENV)/.installed-docs  ## build the site into build/docs; links to elsewhere are tried by: make docs ARGS="-b linkcheck"
	$(BIN)/python -m sphinx -W --keep-going -E -b html $(ARGS) docs build/docs

clean:  ## remove the environment, caches and builds
	rm -rf $(VENV) dist build .mypy_cache .ruff_cache .pytest_cache .hypothesis
	find sweep kernels tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +

$(BIN)/python:
	$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11) and 'stickslip needs Python 3.11 or newer: make PYTHON=python3.11 ...')"
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) -e .
	@touch $@

$(VENV)/.installed-test: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) -e ".[test]"
	@touch $@ $(VENV)/.installed

$(VENV)/.installed-bench: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) -e ".[bench]" || $(INSTALL) -e .
	$(INSTALL) numbalsoda || echo "numbalsoda is left out: it wants CMake and a Fortran compiler"
	@touch $@ $(VENV)/.installed

$(VENV)/.installed-docs: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) -e ".[docs]"
	@touch $@ $(VENV)/.installed
