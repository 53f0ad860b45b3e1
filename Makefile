# Every target, one line each: make help

.DEFAULT_GOAL := help
SHELL := /bin/bash
.DELETE_ON_ERROR:
MAKEFLAGS += --no-print-directory

VENV := .venv/bin
UV_VERSION := 0.13.8
PYTEST_WORKERS ?= 2
PYTEST_OPTIONS ?=
MUTATIONS ?=
BOARD ?= pynq_z2
ADAPTER ?= scripts/jtag/ft2232h.cfg
BLIND ?=
REGISTERS := $(wildcard rtl/registers/*.rdl)
VHDL = $(shell find rtl tb -name '*.vhd' | sort)

.PHONY: help setup generate demo test lint format docs firmware flash flash-bitstream synth formal bench blind mutate lock ci clean distclean

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-15s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

setup: ## install what is missing: system packages (root or sudo) and .venv from requirements.lock
	@scripts/setup.sh

generate: build/generated/.made ## registers (VHDL, C, Python, HTML) and number formats from their source

# When the Python half has been removed, the stamp of the other half says nothing.
ifeq ($(wildcard sim/arctrue/generated/number_formats.py),)
.PHONY: build/generated/.made
endif
build/generated/.made: scripts/generate.py rtl/formats/number_formats_pkg.vhd $(REGISTERS) requirements.lock | setup
	$(VENV)/python scripts/generate.py
	@touch $@

demo: generate ## the main job: simulated table, VHDL in GHDL, calibration, error before and after
	$(VENV)/arctrue demo

test: generate lint ## every check and test; JUnit report in build/reports/
	@mkdir -p build/reports
	@$(VENV)/python -m pytest -n $(PYTEST_WORKERS) --junitxml=build/reports/junit.xml $(PYTEST_OPTIONS)

lint: generate ## style and types: ruff, mypy, vsg; and documents that are out of date
	$(VENV)/ruff check --quiet
	$(VENV)/ruff format --check --quiet
	$(VENV)/mypy --no-error-summary
	@echo "$(VENV)/vsg -c vsg.yaml (all VHDL files)"
	@$(VENV)/vsg -c vsg.yaml -p 2 -of syntastic -f $(VHDL)
	$(VENV)/python -m scripts.make_docs --check
	$(VENV)/python -m scripts.make_effects_page --check

format: setup ## mend the style of Python and VHDL files
	$(VENV)/ruff check --fix --quiet
	$(VENV)/ruff format --quiet
	$(VENV)/vsg -c vsg.yaml -p 2 -of summary --fix -f $(VHDL)

docs: generate ## write entity pages, registers, formats and pictures anew (README's: from the last demo)
	$(VENV)/python -m scripts.make_docs
	$(VENV)/python -m scripts.make_effects_page
	$(VENV)/python -m scripts.make_workbench_pictures
	@if test -f build/demo/error_before_after.svg; then cp build/demo/error_before_after.svg docs/images/; fi

firmware: generate ## the calibrator for the Cortex-A9: ELF, map, size table (BOARD=arty_z7_20: the other board)
	@$(MAKE) -C firmware BOARD=$(BOARD)

flash: firmware ## load the firmware over JTAG and start it (ADAPTER=FILE: another adapter than the board's)
	@$(VENV)/python -m scripts.flash firmware --adapter $(ADAPTER) build/firmware/$(BOARD)/arctrue.elf

flash-bitstream: setup ## load the bitstream of BOARD into the fabric over JTAG
	@$(VENV)/python -m scripts.flash fabric --adapter $(ADAPTER) build/bitstream/$(BOARD)/arctrue.bit

synth: generate ## GHDL and Yosys: LUT, FF, DSP, RAM of every unit and of the core, budgets checked
	@scripts/install_ghdl_netlist.sh
	$(VENV)/python -m scripts.synth

formal: generate ## proofs on the netlist, each shown to fail on broken VHDL
	@scripts/install_ghdl_netlist.sh
	$(VENV)/python -m scripts.formal

bench: generate ## how long a diagnosis and the firmware's calibration take, and how that grows
	$(VENV)/python -m scripts.bench_workbench
	$(VENV)/python -m scripts.bench_firmware

blind: generate ## sealed sets with a hidden effect, judged by the diagnosis alone (an hour or more; BLIND=--quick)
	$(VENV)/python -m scripts.blind $(BLIND)

mutate: generate ## break the VHDL on purpose, one mutation a time, and see each caught by its test
	$(VENV)/python -m scripts.mutate $(MUTATIONS)

lock: setup ## work out requirements.lock anew from pyproject.toml (LOCK_OPTIONS=--upgrade: the newest)
	@test -x build/lock/bin/uv || { $(VENV)/python -m venv build/lock && build/lock/bin/pip install --quiet uv==$(UV_VERSION); }
	build/lock/bin/uv pip compile --quiet --universal --generate-hashes --python-version 3.11 --extra dev \
	    --custom-compile-command "make lock" $(LOCK_OPTIONS) pyproject.toml -o requirements.lock

ci: ## what the hosted workflow runs: all tests, then the demo
	@$(MAKE) test
	@$(MAKE) demo

clean: ## remove everything that was made here, but not .venv
	@rm -rf build sim/arctrue/generated sim/*.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find . -path ./.venv -prune -o -name __pycache__ -prune -exec rm -rf {} +

distclean: clean ## remove .venv too
	@rm -rf .venv
