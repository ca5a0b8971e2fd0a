"""Scripts of the repository: run in a process of their own, or imported."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import subprocess
import sys
from pathlib import Path

from conftest import ROOT


def run(folder, *arguments: object) -> str:
    process = subprocess.run(
        [sys.executable, *map(str, arguments)], cwd=folder, capture_output=True, encoding="utf-8", timeout=500
    )
    assert process.returncode == 0, process.stderr
    return process.stdout


def script(name: str) -> object:
    """A module of the folder `scripts`."""
    loader = importlib.machinery.SourceFileLoader(Path(name).stem, str(ROOT / "scripts" / name))
    spec = importlib.util.spec_from_loader(loader.name, loader)
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module
