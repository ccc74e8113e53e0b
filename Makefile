# Two commands do everything: `make flutter` and `make test`. Each creates what it needs.
PYTHON ?= python3
VENV := .venv
PY := $(VENV)/bin/python
RUN := $(VENV)/bin/aeroslosh
WORKERS ?= 2
STAMP := $(VENV)/.installed
SOURCES := $(shell find fmus master -name '*.py' -o -name '*.csv' -o -name '*.md' -o -name '*.so' 2>/dev/null)

.PHONY: flutter test fmus validate bench lint docs clean
flutter: dist/fmus/.built
	$(RUN) point cases/isogai_a.toml --out runs/flutter_point
	$(RUN) boundary cases/isogai_a.toml --out runs/flutter_boundary

test: dist/fmus/.built
	$(PY) -m pytest -q -n $(WORKERS) --dist loadfile

validate: dist/fmus/.built $(VENV)/.docs
	$(PY) -m pytest -m validation -s

bench: dist/fmus/.built
	$(PY) -m benchmarks

fmus: dist/fmus/.built

lint: $(STAMP)
	$(VENV)/bin/ruff check .
	$(VENV)/bin/mypy

docs: dist/fmus/.built $(VENV)/.docs
	$(PY) docs/site/stage.py build/site-source
	$(PY) -m sphinx -W --keep-going -q -b html build/site-source build/site
	@echo "build/site/index.html: opens in any browser, needs no network"

$(VENV)/.docs: $(STAMP) requirements-docs.lock
	$(PY) -m pip install --quiet --disable-pip-version-check -r requirements-docs.lock
	@touch $@

$(STAMP): pyproject.toml requirements.lock
	@$(PYTHON) -c 'import sys; sys.exit("aeroslosh needs Python 3.11 or newer; found %d.%d. Remedy: make PYTHON=/path/to/python3.11" % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install --quiet --disable-pip-version-check -r requirements.lock
	$(PY) -m pip install --quiet --disable-pip-version-check --no-deps -e .
	@touch $@

dist/fmus/.built: $(STAMP) $(SOURCES)
	$(PY) -m aeroslosh.fmus.build --out dist/fmus
	@touch $@

clean:
	rm -rf $(VENV) dist runs build *.egg-info .mypy_cache .ruff_cache .pytest_cache
