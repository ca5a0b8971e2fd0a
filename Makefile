.PHONY: demo test test-all lint pytest mutants sanitize docs benchmark results fuzz release-check blender clean

PYTHON ?= python3
BIN = .venv/bin
ifeq ($(OS),Windows_NT)
BIN = .venv/Scripts
endif
PY = $(BIN)/python

CORE_TESTS = $(addprefix tests/,reference _core/test_hazards.py _core/test_core_threads.py linalg measures charts/packing)

demo: .venv/demo
	@echo "demo: flattening the cortex by three methods; pictures and meshes go to out/"
	@$(PY) demos/cortex.py

test: lint pytest

# the tests that `make test` leaves out: slow ones of what rarely breaks
test-all: .venv/ready
	$(PY) -m pytest -n 2 --dist loadfile -m slow

lint: .venv/ready
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(MAKE) -j 3 --no-print-directory $(addprefix mypy-,linux win32 darwin)
	$(BIN)/lint-imports --no-logo --no-cache

# each system has its own cache, so that a second run checks only what has changed
mypy-%:
	$(PY) -m mypy --platform $* --cache-dir .mypy_cache/$*

pytest: .venv/ready
	$(PY) -m pytest -n 2 --dist loadfile -m "not slow"

# ROOM="angles layouts" runs only the mutants of these subpackages
mutants: .venv/ready
	$(PY) scripts/mutants.py $(ROOM)

# the core, built with AddressSanitizer and UBSan, and then with ThreadSanitizer
sanitize: .venv/ready
	$(PY) scripts/sanitize.py -m "not slow" $(CORE_TESTS)

docs: .venv/ready
	$(PY) -m sphinx -W --keep-going -n -b html docs docs/_build/html
	@echo "wrote docs/_build/html/index.html"

benchmark: .venv/ready
	$(PY) benchmarks/performance.py

# not made where CHOLMOD could not be built, which is so tried again
.venv/ready: pyproject.toml scripts/bootstrap
	$(PYTHON) scripts/bootstrap

# the demos need neither browsers nor CHOLMOD
.venv/demo: pyproject.toml scripts/bootstrap
	@$(PYTHON) scripts/bootstrap --demo

results: .venv/ready
	$(PY) benchmarks/results.py

fuzz: .venv/ready
	$(PY) benchmarks/fuzz.py

# makes its own environments; what it has checked is in dist then
release-check:
	$(PYTHON) scripts/release_check.py

# the extension for Blender, and a Python with Blender in it, for which there are wheels for some systems only
blender: .venv/ready
	$(PY) scripts/blender_extension.py
	$(PY) scripts/blender_extension.py --blender .venv/blender
	$(PY) -m pytest -q tests/project/test_blender.py

clean:
	rm -rf .venv out demos/out recipes/out docs/_build docs/gallery docs/recipes docs/api/generated docs/_static/scenes build dist *.egg-info
