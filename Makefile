# Everything a newcomer needs: `make demo` builds the IMU housing, `make test` runs every check.
# Both make their own virtual environment on first use and are quick from then on.

PYTHON ?= python3
VENV ?= .venv
TEST_VENV ?= .venv-test
LOCK_VENV ?= .venv-lock
DEMO_DIR ?= demo-housing
PYTEST_ARGS ?=

# --no-deps: the lock files name every package, and the tests' one leaves out cadquery-ocp-novtk, whose files
# cadquery-ocp provides as well (see requirements/README.md).
PIP_INSTALL = -m pip install --quiet --disable-pip-version-check --no-deps
COMPILE = $(LOCK_VENV)/bin/uv pip compile pyproject.toml --universal --python-version 3.11 --generate-hashes \
	--group build --no-config --quiet --custom-compile-command "make lock"

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo test lint types docs pytest bench lock clean

help:
	@echo "make demo   build the IMU housing into $(DEMO_DIR)/"
	@echo "make test   lint, types, documentation, tests"
	@echo "make docs   the documentation, into site/"
	@echo "make bench  the measured numbers of docs/benchmarks.md"
	@echo "make lock   renew the pinned packages in requirements/"
	@echo "make clean  remove what the other targets made"
	@echo "Another interpreter: make PYTHON=python3.12 demo"

demo: $(VENV)/.installed
	$(VENV)/bin/gomboc-cad build imu-housing -o $(DEMO_DIR) --force
	@echo
	@echo "The housing is in $(CURDIR)/$(DEMO_DIR):"
	@ls -1 $(DEMO_DIR)

test: lint types docs pytest

lint: $(TEST_VENV)/.installed
	$(TEST_VENV)/bin/ruff check
	$(TEST_VENV)/bin/ruff format --check

types: $(TEST_VENV)/.installed
	$(TEST_VENV)/bin/mypy

# Not with --quiet: it hides the warnings from --strict as well, and everything passes.
docs: $(TEST_VENV)/.installed
	NO_MKDOCS_2_WARNING=1 $(TEST_VENV)/bin/mkdocs build --strict

pytest: $(TEST_VENV)/.installed
	$(TEST_VENV)/bin/python -m pytest -n 2 --dist loadfile $(PYTEST_ARGS)

bench: $(VENV)/.installed
	$(VENV)/bin/python benchmarks/run.py

lock: $(LOCK_VENV)/.installed
	$(COMPILE) --upgrade -o requirements/demo.txt
	$(COMPILE) --upgrade --extra test --extra dev --extra docs --no-emit-package cadquery-ocp-novtk -o requirements/test.txt

clean:
	rm -rf $(VENV) $(TEST_VENV) $(LOCK_VENV) $(DEMO_DIR) site dist .pytest_cache .mypy_cache .ruff_cache .hypothesis

# A changed lock makes the environment anew, so that no package of the old one stays behind.
$(VENV)/.locked: requirements/demo.txt
$(TEST_VENV)/.locked: requirements/test.txt
$(VENV)/.locked $(TEST_VENV)/.locked:
	@$(PYTHON) -c "import sys; sys.exit('gomboc-cad needs Python 3.11 or newer: make PYTHON=python3.11 ...' if sys.version_info < (3, 11) else 0)"
	$(PYTHON) -m venv --clear $(@D)
	$(@D)/bin/python $(PIP_INSTALL) --require-hashes -r $<
	@touch $@

# The package itself is installed in place, so that a change of its source needs no new install.
$(VENV)/.installed $(TEST_VENV)/.installed: %/.installed: %/.locked pyproject.toml
	$(@D)/bin/python $(PIP_INSTALL) --no-build-isolation --editable .
	@touch $@

$(LOCK_VENV)/.installed:
	$(PYTHON) -m venv $(@D)
	$(@D)/bin/python -m pip install --quiet --disable-pip-version-check "uv>=0.7"
	@touch $@
