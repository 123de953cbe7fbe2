# make run        make the environment, install, open the bench
# make test       install what the tests need and run the quick ones, in two processes
# make test-slow  run the rest, which are marked `slow`
# make wheel      a wheel in dist/ with compiled kernels for x86-64-v3 and v4 (three minutes)
# make lint       style (ruff), order of imports (isort) and types (mypy)
# make fuzz       damage every sample file of every reader 2,000 times in each way (half an hour;
#                 LENSBENCH_LENS_FILES=FOLDER adds files of your own); the tests run a short form
# make abuse      4,000 random commands of odd and impossible values (a quarter of an hour); the tests run a short form
# make numbers    trace 20,000 random lenses and cameras: finite numbers and unit directions, or a refusal
# make impossible  twenty minutes of impossible lenses under the mouse: does any panel fail?
# make soak       two hours of random use of the window by mouse and keyboard: does its memory grow? (MINUTES=10)
# make interrupts 20,000 small renders interrupted at random moments, with bounds checked (half an hour)
# make mutants    put known kinds of one-line faults into the core, and list those that the nearest tests miss
# make compat     the quick tests with the lowest and with the newest versions of the dependencies
# make choices    choose the model of 400 random cameras: good enough, and the simplest that is? (ten minutes)
# make peers      trace the same rays in rayoptics, Optiland and batoid, and render exported cameras in Mitsuba and, if
#                 its module is installed there, in Blender; in an environment of its own
#
# Another Python: make PYTHON=python3.13 run. pip uses the configuration of the user.

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
PACKAGES := libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libx11-6 libxext6

.PHONY: run test test-slow wheel lint fuzz abuse numbers soak impossible interrupts mutants compat choices peers needs clean

run: $(VENV)/.installed
	@$(BIN)/lensbench

# Worksteal gives each process a run of neighbouring tests, which share fixtures and compiled kernels
WORKERS ?= 2
MINUTES ?= 120

test: needs $(VENV)/.installed-test
	$(BIN)/python -m pytest -m "not slow" -n $(WORKERS) --dist worksteal

test-slow: needs $(VENV)/.installed-test
	$(BIN)/python -m pytest -m slow -n $(WORKERS) --dist worksteal

# From a copy, so that compiled kernels of this moment never lie next to sources that change
wheel: $(VENV)/.installed
	rm -rf build/tree && mkdir -p build/tree
	cp -r lensbench core lenses shaders app pyproject.toml setup.py README.md LICENSE THIRD_PARTY.md build/tree
	$(BIN)/python -m lensbench.app.workers.shipped_kernels build/tree/core/kernels/shipped
	$(BIN)/python -m pip wheel -q --no-deps -w dist build/tree

lint: $(VENV)/.installed-test
	$(BIN)/ruff check .
	$(BIN)/isort --check-only --quiet .
	@# The rooms as the one package that they are installed as: mypy does not see an editable install
	@rm -rf build/typed && mkdir -p build/typed/lensbench
	@ln -s $(CURDIR)/lensbench/* $(CURDIR)/core $(CURDIR)/lenses $(CURDIR)/shaders $(CURDIR)/app build/typed/lensbench/
	MYPYPATH=build/typed $(BIN)/mypy -p lensbench -p trials

fuzz: $(VENV)/.installed-test
	$(BIN)/python -m pytest trials/test_fuzz.py

abuse: $(VENV)/.installed-test
	$(BIN)/python -m pytest trials/test_abuse.py

numbers: $(VENV)/.installed-test
	$(BIN)/python -m pytest trials/test_numbers.py

soak: $(VENV)/.installed-test
	$(BIN)/python -m trials.soak --minutes $(MINUTES)

impossible: $(VENV)/.installed-test
	$(BIN)/python -m trials.impossible_lenses

interrupts: $(VENV)/.installed-test
	$(BIN)/python -m trials.interrupts

mutants: $(VENV)/.installed-test
	$(BIN)/python -m trials.mutants

# Each in an environment of its own; another Python: make PYTHON=python3.14 compat
compat: needs
	@for versions in lowest newest; do [ -x build/$$versions/bin/python ] || $(PYTHON) -m venv build/$$versions; done
	$(PYTHON) trials/lowest_versions.py > build/lowest/versions.txt
	build/lowest/bin/python -m pip install -q -c build/lowest/versions.txt -e '.[test]'
	build/newest/bin/python -m pip install -q --upgrade --upgrade-strategy eager -e '.[test]'
	for versions in lowest newest; do \
		build/$$versions/bin/python -m pytest -m "not slow" -n $(WORKERS) --dist worksteal || exit 1; done

choices: $(VENV)/.installed-test
	$(BIN)/python -m pytest -s trials/test_choices.py

# The peers need half a gigabyte: they have an environment of their own
peers:
	@[ -x build/peers/bin/python ] || $(PYTHON) -m venv build/peers
	build/peers/bin/python -m pip install -q -e '.[test,peers]'
	build/peers/bin/python -m pytest -s trials/test_peers.py trials/test_renderers.py

# The stamps depend on pyproject.toml, so that the next run installs a new dependency
$(VENV)/.installed: pyproject.toml | $(BIN)/pip
	$(BIN)/python -m pip install -e .
	@touch $@

$(VENV)/.installed-test: pyproject.toml | $(BIN)/pip
	$(BIN)/python -m pip install -e '.[test]'
	@touch $@ $(VENV)/.installed

$(BIN)/pip:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "lensbench needs Python 3.11 or newer: make PYTHON=python3.13 $(MAKECMDGOALS)" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
		echo "$(PYTHON) cannot make environments: on Debian or Ubuntu, apt-get install python3-venv" >&2; exit 1; }
	@# An environment that uv made has no pip yet
	if [ -x $(BIN)/python ]; then $(BIN)/python -m ensurepip --default-pip; else $(PYTHON) -m venv $(VENV); fi

# System libraries of the window on Debian and Ubuntu: installed for root, listed for other users
needs:
	@if command -v dpkg-query >/dev/null; then \
		missing=$$(for package in $(PACKAGES); do \
			dpkg-query -W -f='$${Status}' $$package 2>/dev/null | grep -q 'ok installed' || echo $$package; done); \
		if [ -n "$$missing" ] && [ "$$(id -u)" = 0 ]; then \
			apt-get update -q && apt-get install -q -y --no-install-recommends $$missing; \
		elif [ -n "$$missing" ]; then \
			echo "the window's tests need: sudo apt-get install" $$missing >&2; \
		fi; \
	fi

clean:
	rm -rf build dist $(VENV) *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
