# Everything runs in .venv, which each target makes or brings up to date by itself.
#   make demo    the paper's experiment: two nodes, two bags, the verdict
#   make test    linters, types, import contracts, every test
SHELL := /bin/bash
# nodes are started hundreds of times: let Python keep what it compiles
unexport PYTHONDONTWRITEBYTECODE
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

VENV := .venv
BIN := $(VENV)/bin
PYTHON ?= $(firstword $(foreach v,3.11 3.12 3.13,$(shell command -v python$(v) 2>/dev/null)) python3)
PYTHONS := 3.11 3.12 3.13
PIP := $(BIN)/python -m pip --disable-pip-version-check --no-input
# the locks name every package: nothing to resolve, and build tools come from them too; bytecode is
# written of what is imported, when it is: to write that of all modules takes half the installation
INSTALL := $(PIP) install --quiet --no-deps --no-build-isolation --no-compile
PYTEST := $(BIN)/python -m pytest
ARGS ?=
CORES := $(shell nproc)
# tests that wait for nodes leave a core to others
WORKERS := $(shell echo $$(($(CORES) + 1)))
# one look into each room, and both nodes once
QUICK := test/config test/cdr test/control/test_law.py test/control/test_experiments.py test/model/test_dynamics.py \
	test/model/test_kinematics.py test/sim/test_plant.py test/sim/test_command_gate.py test/loop \
	test/bag/test_reader.py test/analysis/checks test/cli/test_commands.py test/nodes/test_closed_loop.py

BENCHMARKS := $(wildcard benchmarks/bench_*.py)

.PHONY: evidence help setup setup-all demo test test-quick test-pythons coverage lint types bench faults soak sweep-proof test-browser docs lock clean

help:  ## this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  make \1\t/' | expand -t 22

setup: $(VENV)/runtime.stamp  ## .venv with what the nodes and ur5 need, but for sweeps, bench, Parquet and Rerun

setup-all: $(VENV)/all.stamp  ## the same with these and the test, bench and docs tools

$(VENV)/created.stamp:
	@echo "Making $(VENV) with $(PYTHON)"
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; (3, 11) <= v < (3, 14) or sys.exit(f"Python {v[0]}.{v[1]} found; 3.11 to 3.13 serve: make PYTHON=/path/to/python3.11")'
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@touch $(VENV)/COLCON_IGNORE $@

# pip and setuptools first and from the lock: the ones that came with Python may be years old
$(VENV)/runtime.stamp: requirements/runtime.txt setup.py $(VENV)/created.stamp
	@echo "Installing $$(grep -c == $<) pinned packages into $(VENV); the first time this takes some minutes"
	@$(INSTALL) $$(grep -E '^(pip|setuptools)==' $<)
	@$(INSTALL) -r $<
	@$(INSTALL) --quiet -e .
	@$(BIN)/ur5 warm-up
	@touch $@

$(VENV)/all.stamp: requirements/all.txt $(VENV)/runtime.stamp
	@echo "Installing the test, bench and docs tools: $$(grep -c == $<) pinned packages in all"
	@$(INSTALL) -r $<
	@$(BIN)/ur5 warm-up --all
	@touch $@

demo: setup  ## the paper's experiment, judged (ARGS="--arm ur5_real ...")
	@$(BIN)/ur5 demo $(ARGS)

lint: setup-all  ## ruff and the import contracts
	$(BIN)/ruff check .
	$(BIN)/lint-imports

types: setup-all  ## mypy
	$(BIN)/mypy

test: lint types  ## linters, types, import contracts, every test
	$(PYTEST) -q -n $(WORKERS) --dist loadfile --no-loadscope-reorder -m 'not browser' $(ARGS) </dev/null

test-quick: lint types  ## what a change usually breaks, in two minutes
	$(PYTEST) -q -n $(CORES) --dist loadfile $(QUICK) $(ARGS) </dev/null

test-pythons:  ## the demo and the quick tests on every Python of PYTHONS that is here
	@for version in $(PYTHONS); do python=; \
	for each in $$(command -v python$$version) $(HOME)/.pyenv/versions/$$version.*/bin/python; do \
	! $$each -c '' 2>/dev/null || { python=$$each; break; }; done; \
	[ -n "$$python" ] || { echo "== Python $$version is not here"; continue; }; \
	echo "== Python $$version: $$python"; \
	$(MAKE) --no-print-directory VENV=$(VENV)-$$version PYTHON=$$python demo && \
	$(MAKE) --no-print-directory VENV=$(VENV)-$$version PYTHON=$$python pytest-quick || failed="$${failed:-} $$version"; \
	done; [ -z "$${failed:-}" ] || { echo "Failed on:$$failed"; exit 1; }

pytest-quick: setup-all
	$(PYTEST) -q -n $(CORES) --dist loadfile $(QUICK) </dev/null

coverage: setup-all  ## the same tests under watch: which lines no test runs
	$(PYTEST) -q -m 'not browser' --cov=ur5_ros --cov-report=term:skip-covered $(ARGS) </dev/null

test-browser: setup-all  ## every page in headless Chromium, PyBullet's window in Xvfb, Rerun's viewer
	@command -v chromium >/dev/null || { echo 'No chromium here; on Debian or Ubuntu: apt-get install chromium'; exit 2; }
	@command -v Xvfb >/dev/null || { echo 'No Xvfb here; on Debian or Ubuntu: apt-get install xvfb'; exit 2; }
	@ls /usr/share/vulkan/icd.d/*.json >/dev/null 2>&1 || { echo 'No Vulkan driver here; on Debian or Ubuntu: apt-get install mesa-vulkan-drivers'; exit 2; }
	$(PYTEST) -q -m browser $(ARGS) </dev/null

bench: setup-all  ## figures as ratios to references measured in the same run
	@for script in $(BENCHMARKS); do echo "== $$script"; $(BIN)/python $$script $(ARGS) || failed="$${failed:-} $$script"; done; \
	$(BIN)/python benchmarks/table.py; [ -z "$${failed:-}" ] || { echo "Not met or not run:$$failed"; exit 1; }

faults: setup-all  ## every fault of the catalogue, and the scorecard
	UR5_ROS_THOROUGH=1 $(PYTEST) test -q -m fault --scorecard=docs/faults.md $(ARGS) </dev/null

evidence: setup-all  ## heavy tests at full length: restarts, kills, floods (ARGS="-k restart")
	UR5_ROS_THOROUGH=1 $(PYTEST) test -q -m thorough --evidence=benchmarks/results/evidence.json $(ARGS) </dev/null
	$(BIN)/python benchmarks/table.py

sweep-proof: setup-all  ## 10,000 runs while workers, scheduler and sweep are killed (ARGS="--runs 500")
	$(BIN)/python benchmarks/sweep_proof.py $(ARGS)

soak: setup-all  ## an hour under watch: memory, lateness, bags (ARGS="--minutes 5")
	$(BIN)/python benchmarks/soak.py --page docs/soak.md $(ARGS)

docs: setup-all  ## the documents as a site in site/, their figures compared with what is behind them
	$(PYTEST) -q test/docs/test_figures.py test/docs/test_claims.py $(ARGS) </dev/null
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

lock: setup-all  ## write requirements/*.txt anew
	$(BIN)/python requirements/lock.py

clean:  ## remove what can be made again, bags apart
	rm -rf $(VENV) build install log dist site .pytest_cache .mypy_cache .ruff_cache *.egg-info .coverage
