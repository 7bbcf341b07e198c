# Two commands are enough: `make paper` and `make test`. Both make .venv where it is missing.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
INSTALL := $(PIP) install --quiet --constraint constraints.txt

.DEFAULT_GOAL := help
.PHONY: help paper paper-sensitivity test test-slow test-all fuzz docs browser lint types contracts bench clean

help:
	@echo "make paper      run the paper's study into results/paper"
	@echo "make paper-sensitivity  vary what the paper does not print, into results/nozzle"
	@echo "make test       run the tests, but for the slow ones"
	@echo "make test-slow  run those alone: whole pages' commands, processes that are killed, fine meshes"
	@echo "make test-all   run both"
	@echo "make fuzz       run the tests that draw examples, with FUZZ=20 times as many of them"
	@echo "make docs       build the documentation into docs/_build/html, running the examples"
	@echo "make browser    install the browser that the report is tested in (Debian, as root)"
	@echo "make lint       check style"
	@echo "make types      check types"
	@echo "make contracts  check who imports whom"
	@echo "make bench      run the benchmarks"
	@echo "make clean      remove what was made here, results excepted"

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: $(BIN)/python pyproject.toml constraints.txt
	$(INSTALL) --editable .
	@touch $@

$(VENV)/.installed-test: $(VENV)/.installed
	$(INSTALL) --editable ".[test]"
	@touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	$(INSTALL) --editable ".[docs]"
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(INSTALL) --editable ".[dev]"
	@touch $@

paper: $(VENV)/.installed
	$(BIN)/fibermelt run paper --out results/paper
	@echo "Look at results/paper/report.html, and at the numbers in results/paper/summary.json."

paper-sensitivity: $(VENV)/.installed
	$(BIN)/fibermelt sweep nozzle --out results/nozzle
	@echo "Look at results/nozzle/report.html: which claims depend on the nozzle's dimensions."

# One process for each core, one solver thread in each: a file's tests stay together.
PYTEST := OMP_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses auto --dist loadfile

test: $(VENV)/.installed-test
	$(PYTEST) -m 'not slow'

test-slow: $(VENV)/.installed-test
	$(PYTEST) -m slow

test-all: test test-slow

# A warning is an error, as is a name in a docstring that does not exist.
docs: $(VENV)/.installed-docs
	OMP_NUM_THREADS=1 $(BIN)/python -m sphinx -W --keep-going -q docs docs/_build/html
	@echo "Look at docs/_build/html/index.html."

# Another draw each time: what fails is told with the seed that repeats it (--hypothesis-seed).
FUZZ ?= 20
fuzz: $(VENV)/.installed-test
	FUZZ=$(FUZZ) OMP_NUM_THREADS=1 $(BIN)/python -m pytest -m hypothesis \
		--numprocesses auto --dist worksteal

# The page is tested in Debian's Chromium; without it those tests are skipped, and say so.
browser:
	@command -v chromium >/dev/null || (apt-get update -qq && apt-get install -y -qq chromium)

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.installed-dev
	$(BIN)/mypy

contracts: $(VENV)/.installed-dev
	$(BIN)/lint-imports

bench: $(VENV)/.installed-dev
	$(BIN)/python -m pytest benchmarks/bench_*.py --benchmark-only -s

clean:
	rm -rf $(VENV) build dist docs/_build docs/gallery .pytest_cache .mypy_cache .ruff_cache .import_linter_cache
	rm -rf .hypothesis .benchmarks
	find src tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
