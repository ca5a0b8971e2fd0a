.PHONY: demo test docs benchmark results fuzz clean

PY = .venv/bin/python

demo: .venv/ready
	$(PY) demos/cortex.py

test: .venv/ready
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy
	.venv/bin/lint-imports --no-logo --no-cache
	$(PY) -m pytest -n 2 --dist loadfile

docs: .venv/ready
	$(PY) -m sphinx -W --keep-going -n -b html docs docs/_build/html
	@echo "wrote docs/_build/html/index.html"

benchmark: .venv/ready
	$(PY) benchmarks/timing.py

.venv/ready: pyproject.toml scripts/bootstrap
	scripts/bootstrap

results: .venv/ready
	$(PY) benchmarks/results.py

fuzz: .venv/ready
	$(PY) benchmarks/fuzz.py

clean:
	rm -rf .venv out demos/out docs/_build docs/gallery docs/api/generated docs/_static/scenes build *.egg-info
