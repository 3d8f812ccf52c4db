# Everything a newcomer or CI needs; each target does its own set-up.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

.PHONY: install docs demo test lint types check accuracy bench clean

install: $(STAMP)

# Python code is installed editable; entry points and the compiled kernels are not.
$(STAMP): pyproject.toml hatch_build.py $(wildcard gateway/gaitway/estimation/_*.[ch])
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

docs: install
	$(BIN)/python docs/write_payloads.py

demo: install
	$(BIN)/gaitway demo

test: install
	$(BIN)/python -m pytest

lint: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: install
	$(BIN)/mypy

check: lint types test

accuracy: install
	$(BIN)/python tests/accuracy

bench: install
	$(BIN)/python tests/bench

clean:
	rm -f gateway/gaitway/estimation/_kernels.*.so
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis dist
