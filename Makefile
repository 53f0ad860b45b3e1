# `make help` lists every target with one line each.

.DEFAULT_GOAL := help
SHELL := /bin/bash
.DELETE_ON_ERROR:
MAKEFLAGS += --no-print-directory

VENV := .venv/bin
UV_VERSION := 0.13.8
PYTEST_WORKERS ?= 2
PYTEST_OPTIONS ?=
MUTATIONS ?=
NIGHTLY ?=
BOARD ?= pynq_z2
BAUD ?= 115200
ADAPTER ?= scripts/jtag/ft2232h.cfg
BENCHMARK_OPTIONS ?= $(BLIND)
COVERAGE ?= tb
TIER ?= dev
SCALE ?= small
FLOW ?= vivado
BITSTREAM_OPTIONS = $(if $(LANES),--lanes $(LANES)) $(if $(FOLD),--fold $(FOLD)) \
    $(if $(CAPTURE_DEPTH),--capture-depth $(CAPTURE_DEPTH)) $(if $(SEED),--seed $(SEED)) \
    $(if $(ROTATION),--rotation $(ROTATION)) $(if $(HEADS),--heads $(HEADS)) $(if $(MEAN),--mean $(MEAN)) \
    $(if $(MODULATORS),--modulators $(MODULATORS)) \
    $(if $(FAILOVER),--failover $(FAILOVER)) $(if $(LOCAL_TABLE),--local-table $(LOCAL_TABLE)) \
    $(if $(REAL_ORDERS),--real-orders $(REAL_ORDERS)) $(if $(EVENTS),--events $(EVENTS)) \
    $(if $(TOP),--top $(TOP)) $(if $(PART),--part $(PART)) $(if $(PINS),--pins $(PINS))
GENERATORS := $(addprefix scripts/,generate.py generate_python.py number_formats.py register_block.py register_map.py register_words.py) \
  $(shell find scripts/register_block_templates -name "*.vhd")
REGISTERS := $(wildcard rtl/registers/*.rdl)
C_SOURCES = $(shell find firmware sim/arctrue/instrument scripts/bitstream_models -name '*.[ch]' -o -name '*.cpp' | sort)
VHDL = $(shell find rtl tb -name '*.vhd' | sort)
# Two checks run at a time; the longest begin first.
LINTS := $(addprefix lint-,types vhdl documents style)
# With `worksteal` a worker keeps the tests of a file, which share their builds; a worker that has finished takes
# tests from another worker. Python keeps its bytecode here: otherwise each worker, and each command that a test
# starts, would compile all sources anew.
PYTEST := PYTHONDONTWRITEBYTECODE= $(VENV)/python -m pytest -n $(PYTEST_WORKERS) --dist worksteal

.PHONY: help setup generate demo test test-large lint format docs firmware image flash flash-bitstream bitstream verify-bitstream instrument synth formal bench compare-lanes warming benchmark bound blind peers fuzz coverage-gateware coverage-firmware mutate nightly site lock ci clean distclean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-17s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

setup: ## install what is missing: system packages (root or sudo) and .venv from requirements.lock
	@scripts/setup.sh

generate: build/generated/.made ## generate registers (VHDL, C, Python, HTML) and number formats from their source

# The stamp counts only if the generated Python files exist too: they are outside build/ and may have been removed.
ifeq ($(wildcard sim/arctrue/generated/number_formats.py),)
.PHONY: build/generated/.made
endif
build/generated/.made: $(GENERATORS) rtl/formats/number_formats_pkg.vhd $(REGISTERS) requirements.lock | setup
	$(VENV)/python -m scripts.generate
	@touch $@

demo: generate ## calibrate a simulated table in GHDL; also find and correct a hidden effect at full scale
	$(VENV)/arctrue demo

test: generate lint ## run every check and test except those of make test-large; JUnit report in build/reports/
	@mkdir -p build/reports
	@$(PYTEST) -m "not large" --junitxml=build/reports/junit.xml $(PYTEST_OPTIONS)

test-large: generate ## run the long tests: larger configurations and further cases of benches, proofs and simulated worlds
	@mkdir -p build/reports
	@$(PYTEST) -m large --junitxml=build/reports/junit_large.xml $(PYTEST_OPTIONS)

lint: generate ## check style, types, order of imports (ruff, mypy, import-linter, clang-format, cppcheck, vsg) and generated documents
	@$(MAKE) --jobs 2 --output-sync=target $(LINTS)

.PHONY: $(LINTS)
lint-types:
	$(VENV)/mypy --no-error-summary

lint-vhdl:
	@echo "$(VENV)/vsg -c vsg.yaml (all VHDL files)"
	@$(VENV)/vsg -c vsg.yaml -of syntastic -f $(VHDL)

lint-documents:
	$(VENV)/python -m scripts.make_docs --check
	$(VENV)/python -m scripts.make_effects_page --check

lint-style:
	$(VENV)/ruff check --quiet
	$(VENV)/ruff format --check --quiet
	@$(VENV)/lint-imports --no-cache >build/import_order.txt || { cat build/import_order.txt; exit 1; }
	@echo "$(VENV)/clang-format --dry-run --Werror (all C and C++ files)"
	@$(VENV)/clang-format --dry-run --Werror $(C_SOURCES)
	@echo "$(VENV)/cppcheck (the firmware)"
	@$(MAKE) -C firmware check

format: setup ## correct the style of Python, C and VHDL files
	$(VENV)/ruff check --fix --quiet
	$(VENV)/ruff format --quiet
	$(VENV)/clang-format -i $(C_SOURCES)
	$(VENV)/vsg -c vsg.yaml -p 2 -of summary --fix -f $(VHDL)

docs: generate ## generate the pages of entities, registers and formats, and the pictures (those of README from the last demo)
	$(VENV)/python -m scripts.make_docs
	$(VENV)/python -m scripts.make_effects_page
	$(VENV)/python -m scripts.make_workbench_pictures
	$(VENV)/python -m scripts.page_screenshot
	@for picture in error_before_after hidden_effect; do \
	    if test -f build/demo/$$picture.svg; then cp build/demo/$$picture.svg docs/images/; fi; done

firmware: generate ## build the firmware for the Cortex-A9: ELF, map, size table (BOARD=arty_z7_20: the other board; BAUD=921600: the console's rate)
	@$(MAKE) -C firmware BOARD=$(BOARD) BAUD=$(BAUD)

image: firmware ## build the boot image for the QSPI flash: firmware, and the bitstream of BOARD if it exists
	@$(VENV)/python -m scripts.image build/firmware/$(BOARD)/arctrue.elf \
	    --bitstream build/bitstream/$(BOARD)/arctrue.bit --out build/image/$(BOARD)/BOOT.BIN

flash: firmware ## load the firmware over JTAG and start it (ADAPTER=FILE: another adapter than that of the board)
	@$(VENV)/python -m scripts.flash firmware --adapter $(ADAPTER) build/firmware/$(BOARD)/arctrue.elf

flash-bitstream: setup ## load the bitstream of BOARD into the fabric over JTAG
	@$(VENV)/python -m scripts.flash fabric --adapter $(ADAPTER) build/bitstream/$(BOARD)/arctrue.bit

bitstream: generate ## build the bitstream of the chip (BOARD=... FLOW=vivado or open, LANES=, FOLD=, ROTATION=, HEADS=, MEAN=true, MODULATORS=true, FAILOVER=true, LOCAL_TABLE=true, REAL_ORDERS=true, EVENTS=true, SEED=): docs/device.md
	@if test "$(FLOW)" = open; then scripts/install_ghdl_netlist.sh && \
	    { test -n "$$NEXTPNR" || command -v nextpnr-himbaechel nextpnr-himbaechel-xilinx || \
	      scripts/install_place_and_route.sh; } >/dev/null; fi
	@$(VENV)/python -m scripts.bitstream --flow $(FLOW) --board $(BOARD) $(BITSTREAM_OPTIONS)

verify-bitstream: generate ## decode the open flow's bitstream and compare it with the VHDL in simulation (BOARD=, TOP=, PINS=)
	@$(VENV)/python -m scripts.bitstream_verify --board $(BOARD) $(if $(TOP),--top $(TOP)) \
	    $(if $(PART),--part $(PART)) $(if $(PINS),--pins $(PINS)) $(if $(HEADS),--heads $(HEADS))

instrument: generate ## build the virtual instrument: a compiled netlist of a core with 32 lanes, and the firmware on its bus
	@scripts/install_ghdl_netlist.sh
	$(VENV)/python -m arctrue.instrument

synth: generate ## synthesise with GHDL and Yosys: check LUT, FF, DSP and RAM of every unit and fold against budgets; print the longest paths
	@scripts/install_ghdl_netlist.sh
	$(VENV)/python -m scripts.synth --folds 2 4 8
	$(VENV)/python -m scripts.synth -g ROTATION=table --folds 2 4 8 --output build/synth/table/arctrue_core
	$(VENV)/python -m scripts.synth --everything
	$(VENV)/python -m scripts.timing --netlist build/synth/arctrue_core/arctrue_core.flat.json --limit 7

formal: generate ## prove properties of the netlist, and show that each proof fails on broken VHDL
	@scripts/install_ghdl_netlist.sh
	$(VENV)/python -m scripts.formal

bench: generate ## measure the speed of calibration, firmware, instrument and workbench, each compared with a peer or a limit: build/bench/page.md
	@scripts/install_ghdl_netlist.sh
	@$(VENV)/python -m scripts.bench_page build/bench/page.md

compare-lanes: generate ## compare size, speed and errors of both lanes of the core with a lane that uses a DSP: docs/cordic-comparison.md
	@scripts/install_ghdl_netlist.sh
	$(VENV)/python -m scripts.compare_lanes

warming: generate ## simulate a table that warms, whose eccentricity the firmware follows without a host (SCALE=full: 2²⁴ counts, half an hour)
	@scripts/install_ghdl_netlist.sh
	$(VENV)/python -m scripts.warming $(SCALE)

benchmark: generate ## run the benchmark of the diagnosis, resumable, and write its page (TIER=dev: 650 sets; quick, calibration, public, sealed, cases; SETS="--generator both --limit N --samples N")
	@test -f build/benchmark/$(TIER)/plan.json || $(VENV)/arctrue benchmark make build/benchmark/$(TIER) --tier $(TIER) $(SETS)
	$(VENV)/arctrue benchmark run build/benchmark/$(TIER) $(BENCHMARK_OPTIONS)
	$(VENV)/arctrue benchmark page build/benchmark/$(TIER) $(if $(wildcard build/benchmark/public/*/results*.jsonl),--peers build/benchmark/public) \
	    --to build/benchmark/$(TIER)/page.md --out build/benchmark/$(TIER)

bound: generate ## inject every effect a hundred times at the smallest size that a diagnosis states, resumable (BOUND_OPTIONS="--effect NAME --times N")
	$(VENV)/arctrue benchmark bound build/bound $(BOUND_OPTIONS) --json build/bound.json

blind: benchmark ## former name of benchmark, kept for one release

peers: generate ## run the diagnosis and three simpler methods on the 216 public sets, resumable
	@test -f build/benchmark/public/plan.json || $(VENV)/arctrue benchmark make build/benchmark/public --tier public
	for subject in periodogram_rule gaussian_process stepwise_bic arctrue; do \
	    $(VENV)/arctrue benchmark run build/benchmark/public --subject $$subject $(BENCHMARK_OPTIONS) || exit; done

fuzz: generate ## fuzz the firmware's console, captures and saved records with clang (FUZZ_SECONDS=600)
	@$(MAKE) -C firmware fuzz

coverage-gateware: generate ## measure the share of statements of rtl/ that the benches execute, and check it against its budget (a quarter of an hour; COVERAGE=FILES)
	@scripts/install_ghdl_netlist.sh
	$(VENV)/python -m scripts.gateware_coverage $(COVERAGE)

coverage-firmware: generate ## measure the share of lines of the firmware that its host tests run, and check that it is at least 90 %
	$(VENV)/python -m scripts.firmware_coverage

mutate: generate ## break VHDL, C and guards of the diagnosis, one at a time, and check that a test fails each time
	@scripts/install_ghdl_netlist.sh
	$(VENV)/python -m scripts.mutate $(MUTATIONS)

nightly: generate ## run all long checks of this commit, resumable, and write docs/nightly.md (NIGHTLY="--sample", "--only NAME")
	$(VENV)/python -m scripts.nightly $(NIGHTLY)

site: generate ## build the documentation site: build/site/index.html
	@NO_MKDOCS_2_WARNING=1 $(VENV)/mkdocs build --quiet
	@echo "build/site/index.html"

# --fork-strategy fewest: every Python gets the same version of a package, not the newest one that it supports, so that
# types and figures are the same on all systems.
lock: setup ## resolve requirements.lock again from pyproject.toml (LOCK_OPTIONS=--upgrade: the newest versions)
	@test -x build/lock/bin/uv || { $(VENV)/python -m venv build/lock && build/lock/bin/pip install --quiet uv==$(UV_VERSION); }
	build/lock/bin/uv pip compile --quiet --universal --generate-hashes --python-version 3.11 --extra dev \
	    --fork-strategy fewest --custom-compile-command "make lock" $(LOCK_OPTIONS) pyproject.toml -o requirements.lock

ci: ## run what the hosted workflow runs: all tests, then the demo
	@$(MAKE) test
	@$(MAKE) demo

clean: ## remove everything that make has built, except .venv
	@rm -rf build sim/arctrue/generated sim/*.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find . -path ./.venv -prune -o -name __pycache__ -prune -exec rm -rf {} +

distclean: clean ## remove .venv too
	@rm -rf .venv
