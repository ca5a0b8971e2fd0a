"""`scripts/bootstrap` continues if a system package fails, and does not change existing parts."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from conftest import ROOT
from scripts_of_repo import script

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the fake programs are shell scripts")


def write_program(folder: Path, name: str, text: str) -> Path:
    """Write a shell script that logs its calls to the file `calls` in its folder."""
    folder.mkdir(exist_ok=True, parents=True)
    path = folder / name
    path.write_text(f'#!/bin/sh\necho "{name} $*" >> {folder}/calls\n{text}\n')
    path.chmod(0o755)
    return path


def read_calls(folder: Path) -> list[str]:
    """Return the calls that programs in a folder have logged."""
    path = folder / "calls"
    return path.read_text().splitlines() if path.exists() else []


@pytest.fixture
def bootstrap(tmp_path, monkeypatch) -> ModuleType:
    """Import `scripts/bootstrap` for a temporary `.venv` with a fake Python, without the network or pip."""
    module = script("bootstrap")
    files = {"VENV": "", "INSTALLED": "installed", "DEMO": "demo", "READY": "ready", "LOG": "cholmod.log"}
    for name, path in files.items():
        monkeypatch.setattr(module, name, tmp_path / ".venv" / path)
    monkeypatch.setattr(module, "PYTHON", tmp_path / ".venv" / "bin" / "python")
    monkeypatch.setattr(module, "ROOT", tmp_path)
    (tmp_path / "pyproject.toml").write_text("one")
    monkeypatch.setenv("PYTHON", sys.executable)
    monkeypatch.setattr(module, "missing_packages", lambda python, for_tests: [])
    return module


def write_fake_python(tmp_path: Path, cholmod: bool) -> Path:
    """Write a fake Python that succeeds, except for scikit-sparse if `cholmod` is False."""
    fails = "" if cholmod else 'case "$*" in *cholmod*) echo no cholmod.h; exit 1;; esac'
    return write_program(tmp_path / ".venv" / "bin", "python", fails)


def test_other_packages_are_installed_if_one_fails(bootstrap, tmp_path, monkeypatch, capsys) -> None:
    write_program(tmp_path / "bin", "apt-get", 'case "$*" in *chromium*) exit 100;; esac')
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}:{os.environ['PATH']}")
    monkeypatch.setattr(bootstrap, "sudo_prefix", list)
    bootstrap.install_packages(["chromium", "libsuitesparse-dev", "xvfb"])
    assert [call.split()[-1] for call in read_calls(tmp_path / "bin")] == [
        "-qq",
        "chromium",
        "libsuitesparse-dev",
        "xvfb",
    ]
    errors = capsys.readouterr().err
    assert "chromium could not be installed" in errors
    assert "libsuitesparse-dev could not" not in errors


def test_missing_packages_are_named_if_installing_is_not_allowed(bootstrap, monkeypatch, capsys) -> None:
    monkeypatch.setattr(bootstrap, "sudo_prefix", lambda: None)
    bootstrap.install_packages(["chromium", "xvfb"])
    assert "not allowed to install chromium xvfb" in capsys.readouterr().err


def test_a_failed_build_of_cholmod_is_reported_and_retried(bootstrap, tmp_path, capsys) -> None:
    write_fake_python(tmp_path, cholmod=False)
    for _ in range(2):
        bootstrap.main()
        errors = capsys.readouterr().err
        assert "scikit-sparse could not be built (see .venv/cholmod.log)" in errors
        assert "no cholmod.h" in bootstrap.LOG.read_text()
        assert not bootstrap.READY.exists()
    builds = [call for call in read_calls(tmp_path / ".venv" / "bin") if "[cholmod]" in call]
    assert ["scikit-sparse<0.5" in call for call in builds] == [False, True] * 2
    assert len([call for call in read_calls(tmp_path / ".venv" / "bin") if "[test]" in call]) == 1
    write_fake_python(tmp_path, cholmod=True)
    bootstrap.main()
    assert bootstrap.READY.exists()


def test_existing_parts_are_not_changed(bootstrap, tmp_path, monkeypatch, capsys) -> None:
    write_fake_python(tmp_path, cholmod=True)
    bootstrap.main()
    capsys.readouterr()
    (tmp_path / ".venv" / "bin" / "calls").unlink()
    write_program(tmp_path / "bin", "apt-get", "")
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}:{os.environ['PATH']}")
    bootstrap.main()
    assert capsys.readouterr().err == ""
    assert read_calls(tmp_path / "bin") == []
    assert [call for call in read_calls(tmp_path / ".venv" / "bin") if "pip" in call] == []
    (tmp_path / "pyproject.toml").write_text("two")  # the dependencies change
    bootstrap.main()
    assert [call for call in read_calls(tmp_path / ".venv" / "bin") if "[test]" in call]


def test_the_demo_needs_neither_browsers_nor_cholmod(bootstrap, tmp_path, capsys) -> None:
    write_fake_python(tmp_path, cholmod=False)
    bootstrap.main("--demo")
    calls = read_calls(tmp_path / ".venv" / "bin")
    assert [call for call in calls if "[viz]" in call]
    assert not [call for call in calls if "[test]" in call or "cholmod" in call]
    assert bootstrap.DEMO.exists() and not bootstrap.READY.exists()
    bootstrap.main()  # the tests need more
    assert [call for call in read_calls(tmp_path / ".venv" / "bin") if "[test]" in call]
    packages = set(script("bootstrap").missing_packages("no python", for_tests=False))
    assert packages <= {"g++", "gcc", "libc6-dev", "python3-venv", "python3-dev", "libegl1", "libgl1"}


@pytest.mark.parametrize("options", [("--demo",), ()])
def test_each_long_step_is_announced_after_a_line_about_the_total(
    options: tuple[str, ...], bootstrap, tmp_path, monkeypatch, capsys
) -> None:
    write_fake_python(tmp_path, cholmod=True)
    heard: list[str] = []

    def install(*arguments: str, **_: object) -> subprocess.CompletedProcess[str]:
        said = capsys.readouterr().err
        assert said.startswith("bootstrap: ")
        heard.append(said)
        return subprocess.CompletedProcess(arguments, 0)

    monkeypatch.setattr(bootstrap, "pip", install)
    bootstrap.main(*options)
    assert "into .venv: about 3 minutes" in heard[0].splitlines()[0]
    assert "compiling the core" in heard[1]


def test_the_demo_takes_the_environment_of_the_tests(bootstrap, tmp_path, capsys) -> None:
    write_fake_python(tmp_path, cholmod=True)
    bootstrap.main()
    capsys.readouterr()
    bootstrap.main("--demo")
    assert bootstrap.DEMO.exists() and capsys.readouterr().err == ""


def test_an_old_python_is_refused(tmp_path) -> None:
    old = write_program(tmp_path, "python", "exit 1")
    process = subprocess.run(
        [sys.executable, str(ROOT / "scripts" / "bootstrap")],
        env={**os.environ, "PYTHON": str(old)},
        capture_output=True,
        encoding="utf-8",
        timeout=3600,
    )
    assert process.returncode == 1
    assert process.stderr == f"bootstrap: Python 3.10 or later is needed, {old} is not\n"
