# `make run` and `make test` set up what they need: .venv holds the project and its tools.

PYTHON ?= python3
# Python finds modules where it and the project are installed: neither in the current folder nor where the user's environment says.
unexport PYTHONPATH PYTHONHOME MICROPYPATH
export PYTHONSAFEPATH = 1
VENV = .venv
BIN = $(VENV)/bin
PIP = $(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check
# What a target needs is installed for it, and no more: the command, what draws, the emulator, or all of it with the tests.
TOOLS = $(VENV)/.installed-tools
DRAW = $(VENV)/.installed-draw
EMULATE = $(VENV)/.installed-emulate
STAMP = $(VENV)/.installed
# Tests that share an emulated machine are a group, for one worker. Three for two cores: some wait for a browser or a program;
# those of `make check` do not.
JOBS ?= 3
PYTEST = $(BIN)/python -m pytest -n $(JOBS) --dist loadgroup --durations=20 --durations-min=2

MINOR = import sys; print(*sys.version_info[:2])

.DEFAULT_GOAL := help
.PHONY: help venv run check test test-all soak bench build flash uf2 emulate site pictures wheel release lock clean

help:  ## this list
	@grep -E '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 10
	@echo
	@echo 'build and flash take BOARD=name (a file of boards/), flash PORT=/dev/ttyACM0 and DRY=1; test takes ARGS=...'

# $(1): extras of the project, $(2): what for, $(3): how much is new, $(4): the lock that says which versions, if any. Modules are compiled when they are first imported:
# compiling all of them would take longer than fetching them, and a third more room.
define install
@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
    { echo "Passo wants Python 3.11 or later, and $(PYTHON) is $$($(PYTHON) -V 2>&1): make PYTHON=python3.11 $(MAKECMDGOALS)" >&2; exit 2; }
@if test -e $(BIN)/python && test "$$($(BIN)/python -c '$(MINOR)' 2>&1)" != "$$($(PYTHON) -c '$(MINOR)')"; then \
    echo "$(VENV) is of another Python than $(PYTHON): it is made anew."; rm -rf $(VENV); fi
@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
@echo "Installing what $(2) needs into $(VENV): some $(3) MB, a minute or two; once."
$(if $(4),@$(PIP) --no-deps --require-hashes -r $(4))
@$(PIP) $(if $(4),--no-deps --no-build-isolation) -e '.$(1)'
@du -sm $(VENV) | { read size rest; echo "Installed: $(VENV) has $$size MB."; }
@touch $@
endef

venv: $(DRAW)  ## make .venv and install the project into it, without what only the tests need

$(TOOLS): pyproject.toml
	$(call install,,passo,20)

$(DRAW): pyproject.toml
	$(call install,[draw],drawing,165)
	@touch $(TOOLS)

$(EMULATE): pyproject.toml
	$(call install,[emulate],the emulator,40)
	@touch $(TOOLS)

$(STAMP): pyproject.toml locks/test.txt
	$(call install,[test],testing,670,locks/test.txt)
	@touch $(TOOLS) $(DRAW) $(EMULATE)

run: $(DRAW)  ## draw on the virtual board; pictures and traces in out/
	$(BIN)/python -m host_tools.cli.run

# A sender that some tests drive, without the 60 MB of camera software it would bring along; they skip where it is missing.
CLIENTS = $(VENV)/.clients
$(CLIENTS): $(STAMP) locks/clients.txt
	-$(PIP) --no-deps --require-hashes -r locks/clients.txt
	@touch $@

# Type stubs of MicroPython's modules, each port's in a folder of its own, because they clash; without them a test skips.
STUBS = $(VENV)/typings/.stubs
$(STUBS): $(STAMP)
	-for port in esp32 rp2 stdlib; do \
	    $(PIP) --no-deps --upgrade --target $(VENV)/typings/$$port --require-hashes -r locks/stubs-$$port.txt; \
	done
	@mkdir -p $(VENV)/typings && touch $@

# How much each of them runs is said in tests_host/tiers.py.
check: JOBS = 2
check: $(STAMP)  ## the quick tests, in 90 s: rules, digests, a few examples of each property
	$(PYTEST) --tier check $(ARGS)

# What ARGS chooses is run whole, slow tests included, and without coverage: of a part of the tests it says nothing.
test: $(STAMP) $(CLIENTS) $(STUBS)  ## what guards a commit, with coverage, in 15 minutes; ARGS=tests_host/tools/test_x.py
ifdef ARGS
	$(PYTEST) $(ARGS)
else
	$(PYTEST) --tier test --cov --cov-report=term
endif

test-all: $(STAMP) $(CLIENTS) $(STUBS)  ## all tests, the slow ones and all of the emulated Pico included
	$(PYTEST) --tier all $(if $(ARGS),,--cov --cov-report=term) $(ARGS)

soak: $(STAMP)  ## machines for virtual days while everything fails, an hour; ARGS="--seed 7 --minutes 5", ARGS=--help
	PYTHONPATH=$(CURDIR)/tests_host/sims:$(CURDIR)/tests_host/properties:$(CURDIR)/tests_host/tools $(BIN)/python tests_host/sims/soak.py $(ARGS)

bench: $(STAMP)  ## the slower measurements
	$(BIN)/python -m host_tools.bench $(ARGS)

build: $(TOOLS)  ## compile the firmware of BOARD into build/BOARD
	@test -n '$(BOARD)' || { echo 'which board? make build BOARD=plotter_2014' >&2; exit 2; }
	$(BIN)/passo build --board $(BOARD)

flash: $(TOOLS)  ## copy the firmware of BOARD to the board on PORT; DRY=1 only prints
	@test -n '$(BOARD)' || { echo 'which board? make flash BOARD=plotter_2014 PORT=/dev/ttyACM0' >&2; exit 2; }
	$(BIN)/passo flash --board $(BOARD) $(if $(PORT),--port $(PORT)) $(if $(DRY),--dry-run)

uf2: $(TOOLS)  ## MicroPython with the firmware in it for CHIP (rp2040, rp2040_w, rp2350, rp2350_w); MICROPYTHON=its source
	@test -n '$(CHIP)' || { echo 'which chip? make uf2 CHIP=rp2040' >&2; exit 2; }
	$(BIN)/python -m host_tools.build.uf2 $(CHIP)

emulate: $(EMULATE)  ## the firmware on an emulated Pico; ARGS='--board NAME --tcp 5001'
	$(BIN)/passo emulate $(ARGS)

site: $(TOOLS)  ## the page with the firmware in it, for any web server: build/site; ARGS='--serve 8000'
	$(BIN)/passo site $(ARGS)

pictures: $(STAMP)  ## the wiring drawings of docs/ and README's picture of the page, by chromium
	$(BIN)/python -m host_tools.build.pictures --page

wheel: $(STAMP)  ## what pip installs, with the kernels compiled for every chip: dist/
	$(BIN)/python -m host_tools.build.ship
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps -w dist .

# Environment or command line: DRY=1, ARGS= for the tests, CHIPS="rp2040 …", PYTHONS="python3.11 …", MICROPYTHON=.
release:  ## a release, built in a clean clone and tried: build/release/assets; DRY=1 without a tag
	PYTHONSAFEPATH= $(PYTHON) -m host_tools.build.release

# The versions that a lock has stay, unless UPGRADE=--upgrade.
LOCK = $(VENV)/bin/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-header $(UPGRADE)
lock: $(STAMP)  ## what tests and releases install, with hashes: locks/; UPGRADE=--upgrade takes the newest versions
	$(PIP) 'uv>=0.9,<1'
	$(LOCK) --extra test pyproject.toml -o locks/test.txt
	$(LOCK) --extra release --constraint locks/test.txt pyproject.toml -o locks/release.txt
	printf '%s\n' 'bCNC>=0.9.16,<0.10' 'shxparser>=0.0.2,<0.1' | $(LOCK) --no-deps - -o locks/clients.txt
	for port in esp32 rp2 stdlib; do echo "micropython-$$port-stubs>=1.27,<2" | $(LOCK) --no-deps - -o locks/stubs-$$port.txt; done

clean:  ## remove what was made, except .venv
	rm -rf out build dist host_tools/kernels/modules .pytest_cache .hypothesis .coverage .coverage.* *.egg-info
	find . -path ./$(VENV) -prune -o -name __pycache__ -type d -exec rm -rf {} +
