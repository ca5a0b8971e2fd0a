"""`scripts/bootstrap`: one missing system package costs nothing else, and what is there is left alone."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from conftest import ROOT
from scripts_of_repo import script

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the stand-ins here are shell scripts")


def program(folder: Path, name: str, text: str) -> Path:
    """A shell script that notes how it is called, in the file `calls` beside it."""
    folder.mkdir(exist_ok=True, parents=True)
    path = folder / name
    path.write_text(f'#!/bin/sh\necho "{name} $*" >> {folder}/calls\n{text}\n')
    path.chmod(0o755)
    return path


def calls(folder: Path) -> list[str]:
    path = folder / "calls"
    return path.read_text().splitlines() if path.exists() else []


@pytest.fixture
def bootstrap(tmp_path, monkeypatch) -> ModuleType:
    """The script, for a `.venv` in a folder of its own whose Python is a stand-in: no network, no pip."""
    module = script("bootstrap")
    for name, path in {"VENV": "", "INSTALLED": "installed", "READY": "ready", "LOG": "cholmod.log"}.items():
        monkeypatch.setattr(module, name, tmp_path / ".venv" / path)
    monkeypatch.setattr(module, "PYTHON", tmp_path / ".venv" / "bin" / "python")
    monkeypatch.setattr(module, "ROOT", tmp_path)
    (tmp_path / "pyproject.toml").write_text("one")
    monkeypatch.setenv("PYTHON", sys.executable)
    monkeypatch.setattr(module, "missing_packages", lambda python: [])
    return module


def stand_in(tmp_path: Path, cholmod: bool) -> Path:
    """A Python that "installs" all but, maybe, scikit-sparse."""
    fails = "" if cholmod else 'case "$*" in *cholmod*) echo no cholmod.h; exit 1;; esac'
    return program(tmp_path / ".venv" / "bin", "python", fails)


def test_a_package_that_fails_costs_only_itself(bootstrap, tmp_path, monkeypatch, capsys) -> None:
    program(tmp_path / "bin", "apt-get", 'case "$*" in *chromium*) exit 100;; esac')
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}:{os.environ['PATH']}")
    monkeypatch.setattr(bootstrap, "sudo_prefix", list)
    bootstrap.install_packages(["chromium", "libsuitesparse-dev", "xvfb"])
    assert [call.split()[-1] for call in calls(tmp_path / "bin")] == [
        "-qq",
        "chromium",
        "libsuitesparse-dev",
        "xvfb",
    ]
    said = capsys.readouterr().err
    assert "chromium could not be installed" in said
    assert "libsuitesparse-dev could not" not in said


def test_where_installing_is_not_allowed_it_says_what_is_missing(bootstrap, monkeypatch, capsys) -> None:
    monkeypatch.setattr(bootstrap, "sudo_prefix", lambda: None)
    bootstrap.install_packages(["chromium", "xvfb"])
    assert "not allowed to install chromium xvfb" in capsys.readouterr().err


def test_a_failed_build_of_cholmod_is_said_and_tried_again(bootstrap, tmp_path, capsys) -> None:
    stand_in(tmp_path, cholmod=False)
    for _ in range(2):
        bootstrap.main()
        said = capsys.readouterr().err
        assert "scikit-sparse could not be built (see .venv/cholmod.log)" in said
        assert "no cholmod.h" in bootstrap.LOG.read_text()
        assert not bootstrap.READY.exists()
    builds = [call for call in calls(tmp_path / ".venv" / "bin") if "[cholmod]" in call]
    assert len(builds) == 2
    assert len([call for call in calls(tmp_path / ".venv" / "bin") if "[test]" in call]) == 1
    stand_in(tmp_path, cholmod=True)
    bootstrap.main()
    assert bootstrap.READY.exists()


def test_what_is_there_is_not_touched(bootstrap, tmp_path, monkeypatch, capsys) -> None:
    stand_in(tmp_path, cholmod=True)
    bootstrap.main()
    capsys.readouterr()
    (tmp_path / ".venv" / "bin" / "calls").unlink()
    program(tmp_path / "bin", "apt-get", "")
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}:{os.environ['PATH']}")
    bootstrap.main()
    assert capsys.readouterr().err == ""
    assert calls(tmp_path / "bin") == []
    assert [call for call in calls(tmp_path / ".venv" / "bin") if "pip" in call] == []
    (tmp_path / "pyproject.toml").write_text("two")  # other dependencies
    bootstrap.main()
    assert [call for call in calls(tmp_path / ".venv" / "bin") if "[test]" in call]


def test_an_old_python_is_refused(tmp_path) -> None:
    old = program(tmp_path, "python", "exit 1")
    process = subprocess.run(
        [sys.executable, str(ROOT / "scripts" / "bootstrap")],
        env={**os.environ, "PYTHON": str(old)},
        capture_output=True,
        encoding="utf-8",
        timeout=500,
    )
    assert process.returncode == 1
    assert process.stderr == f"bootstrap: Python 3.10 or later is needed, {old} is not\n"
