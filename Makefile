.PHONY: demo test benchmark results clean

PY = .venv/bin/python

demo: .venv/ready
	$(PY) demos/cortex.py

test: .venv/ready
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy
	$(PY) -m pytest

benchmark: .venv/ready
	$(PY) benchmarks/timing.py

.venv/ready: pyproject.toml scripts/bootstrap
	scripts/bootstrap

results: .venv/ready
	$(PY) benchmarks/results.py

clean:
	rm -rf .venv out build *.egg-info
