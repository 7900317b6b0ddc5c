# gearplay: every command a contributor or a new user needs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# A worker runs whole files, whose tests share what their fixtures make; without the compiler few tests take all the time.
SPREAD := -n logical --dist loadfile --no-loadscope-reorder
SINGLY := -n logical --dist load --maxschedchunk 1
PLAIN := -m "not compiled" tests/elements/test_support.py $(addprefix tests/laws/,test_involute_backlash.py test_event_order.py)

.PHONY: help study extras test test-all platforms test-full torture mutation verification lint format bench docs clean

help: ## print this list
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## (.*)/  make \1|\2/' | column -t -s '|'

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "gearplay needs Python 3.11 or newer; $(PYTHON) is older. Use: make PYTHON=python3.12 ..."; exit 2; }
	$(PYTHON) -m venv $(VENV)

# Without --no-compile pip would turn a thousand modules into bytecode that nobody imports: 15 s.
$(VENV)/user.stamp: pyproject.toml constraints.txt | $(BIN)/python
	@echo "Installing gearplay and compiling its kernels: two to four minutes, once."
	$(BIN)/python -m pip install --no-compile --quiet --disable-pip-version-check -c constraints.txt -e .
	@touch $@

$(VENV)/dev.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(BIN)/python -m pip install --no-compile --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@ $(VENV)/user.stamp

$(VENV)/extras.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(BIN)/python -m pip install --no-compile --quiet --disable-pip-version-check -c constraints.txt -e '.[all]'
	@touch $@ $(VENV)/user.stamp

$(VENV)/mutation.stamp: $(VENV)/dev.stamp
	$(BIN)/python -m pip install --no-compile --quiet --disable-pip-version-check -c constraints.txt -e '.[mutation]'
	@touch $@

$(VENV)/docs.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(BIN)/python -m pip install --no-compile --quiet --disable-pip-version-check -c constraints.txt -e '.[docs]'
	@touch $@ $(VENV)/user.stamp

study: $(VENV)/user.stamp ## set up, then reproduce the article's study into out/han2021/
	$(BIN)/gearplay study han2021 --out out/han2021 --overwrite

extras: $(VENV)/extras.stamp ## add what calibrate, serve, Sobol indices, clusters, PDF and some file formats need

test: $(VENV)/dev.stamp ## set up, then run the tests in some minutes
	$(BIN)/python -m pytest $(SPREAD)

test-all: $(VENV)/dev.stamp ## all tests, the slow ones too, and some physics without the compiler; what CI runs
	GEARPLAY_TESTS=all $(BIN)/python -m pytest $(SPREAD)
	GEARPLAY_INTERPRETED=1 $(BIN)/python -m pytest $(SINGLY) $(PLAIN)

platforms: $(VENV)/dev.stamp ## build the kernel library for Windows and ARM, follow motions with it under wine64 and qemu-aarch64
	GEARPLAY_TESTS=full $(BIN)/python -m pytest -s -rs tests/build/test_platforms.py

test-full: $(VENV)/dev.stamp ## all tests with every repetition, some hours
	GEARPLAY_TESTS=full $(BIN)/python -m pytest $(SPREAD)
	GEARPLAY_INTERPRETED=1 $(BIN)/python -m pytest $(SINGLY) -m "not compiled" tests/elements

torture: $(VENV)/dev.stamp ## hostile trials in full, some hours: damage, kills, Ctrl-C, failing disks, hostile arguments; writes docs/reliability.md
	@GEARPLAY_TESTS=torture $(BIN)/python -m pytest $(SPREAD) -m hostile --junitxml=$(VENV)/torture.xml $(OF); \
	  passed=$$?; $(BIN)/python tests/reliability_page.py $(VENV)/torture.xml && exit $$passed # failures stand on the page too

mutation: $(VENV)/mutation.stamp ## break the physics in 150 random places and see whether a test notices; an hour or more; writes docs/mutation.md
	$(BIN)/python tests/mutation/run.py

verification: $(VENV)/dev.stamp ## write docs/verification.md from a run of the verification tests
	GEARPLAY_TESTS=full $(BIN)/python -m pytest -q $(addprefix tests/,laws cross nonlinear calibration rig signals sweeps) --junitxml=$(VENV)/verification.xml
	$(BIN)/python tests/laws/page.py $(VENV)/verification.xml

lint: $(VENV)/dev.stamp ## style, types and floors
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(VENV)/dev.stamp ## let ruff arrange the code
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(VENV)/dev.stamp ## measure speed and print the ratios of docs/performance.md
	$(BIN)/python -m bench

docs: $(VENV)/docs.stamp ## write the pages and figures that follow from the code, and build the site into site/
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

clean: ## remove what the commands above made
	rm -rf $(VENV) out site .pytest_cache .mypy_cache .ruff_cache .import_linter_cache
