"""Calls of the scripts of the repository, in a new process or as a module."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import subprocess
import sys
from pathlib import Path

from conftest import ROOT


def run(folder, *arguments: object) -> str:
    """Run a Python script in a folder, and return its output."""
    process = subprocess.run(
        [sys.executable, *map(str, arguments)], cwd=folder, capture_output=True, encoding="utf-8", timeout=500
    )
    assert process.returncode == 0, process.stderr
    return process.stdout


def script(name: str) -> object:
    """Import a script of the folder `scripts` as a module."""
    loader = importlib.machinery.SourceFileLoader(Path(name).stem, str(ROOT / "scripts" / name))
    spec = importlib.util.spec_from_loader(loader.name, loader)
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module
