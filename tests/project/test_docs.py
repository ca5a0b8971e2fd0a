"""The pages of the docs build without a warning, and refer to existing functions, files and pictures."""

from __future__ import annotations

import importlib
import inspect
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from conftest import ROOT, read_pixels
from documented import read_reference, resolve
from pixels import count_square_changes, find_colour

import igl_linabf
from igl_linabf.plot import DARK, LIGHT

MODULES = ("igl_linabf.plot", "igl_linabf.io")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no chromium to open the pages with")


def list_public_objects() -> Iterator[tuple[str, object]]:
    """Yield each public function and class of the package with its public name.

    Public are the names of the package, the `__all__` of each subpackage, and the API reference.
    """
    # of the adapters, only one function per library needs an example
    yield from ((name, resolve(name)) for name in read_reference() if ".adapters." not in name)
    for name in igl_linabf.__all__:
        if not inspect.ismodule(getattr(igl_linabf, name)):
            yield f"igl_linabf.{name}", getattr(igl_linabf, name)
    for module in MODULES:
        room = importlib.import_module(module)
        for name in room.__all__:
            if inspect.isfunction(getattr(room, name)) or inspect.isclass(getattr(room, name)):
                yield f"{module}.{name}", getattr(room, name)


@pytest.mark.parametrize("name", [name for name, value in list_public_objects() if inspect.isfunction(value)])
def test_every_public_function_has_an_example(name: str) -> None:
    text = inspect.getdoc(dict(list_public_objects())[name]) or ""
    assert ">>> " in text.partition("Examples\n--------\n")[2]


def test_the_reference_has_every_public_name() -> None:
    assert {name for name, _ in list_public_objects()} <= set(read_reference())


@pytest.mark.parametrize("page", ["README.md", "docs/index.md"])
def test_the_examples_of_the_first_pages_run(page, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(pv, "OFF_SCREEN", True)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text("utf-8"), re.DOTALL)
    names: dict[str, object] = {}
    for block in blocks:
        exec(block, names)  # later blocks use the names of earlier blocks
    pv.close_all()
    assert names["atlas"].good
    assert Path("ant.glb").stat().st_size > 10_000


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"])
def test_links_lead_to_files(page: str) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", (ROOT / page).read_text("utf-8")):
        assert target.startswith("https://") or (ROOT / target).is_file(), target


def test_the_tests_of_the_promises_exist() -> None:
    named = set(re.findall(r"`(test_\w+)`", (ROOT / "docs" / "promises.md").read_text("utf-8")))
    tests = "\n".join(path.read_text("utf-8") for path in (ROOT / "tests").rglob("test_*.py"))
    assert len(named) > 30
    assert named <= set(re.findall(r"^def (test_\w+)", tests, re.MULTILINE))


def test_citation_and_changelog_have_the_current_version() -> None:
    version = metadata.version("igl-linabf")
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text("utf-8")
    assert f" version = {{{version}}},\n" in (ROOT / "docs" / "citing.md").read_text("utf-8")
    assert f"\n## {version} - " in (ROOT / "CHANGELOG.md").read_text("utf-8")


@pytest.mark.parametrize(
    "script", sorted([*ROOT.glob("demos/*.py"), *ROOT.glob("recipes/*.py")]), ids=lambda p: p.stem
)
def test_the_galleries_can_show_what_a_script_draws(script: Path) -> None:
    text = script.read_text(encoding="utf-8")
    # the galleries take the picture that `show` draws, even after the plotter is closed
    assert ".screenshot(" not in text
    if script.stem != "compare_lscm":  # the galleries do not run this demo
        assert "sys.exit" not in text  # sys.exit would end the build without an error


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """Build the docs; the only demo that runs is the one with an interactive scene."""
    pytest.importorskip(
        "sphinx", "8.2", reason="older versions, as on Python 3.10, do not support type aliases"
    )
    folder = tmp_path_factory.mktemp("site")
    made = shutil.ignore_patterns("_build", "gallery", "recipes", "generated", "scenes", "out", "__pycache__")
    for name in ("docs", "demos", "recipes"):
        shutil.copytree(ROOT / name, folder / name, ignore=made)
    for name in ("CONTRIBUTING.md", "CHANGELOG.md"):
        shutil.copy(ROOT / name, folder)
    only = "sphinx_gallery_conf.filename_pattern=in_the_browser"
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-n", "-q", "-D", only, "docs", "html"]
    process = subprocess.run(command, cwd=folder, capture_output=True, encoding="utf-8", timeout=3600)
    assert process.returncode == 0, process.stderr
    return folder / "html"


def run_chromium(page: Path, folder: Path, *arguments: str) -> str:
    """Open a page in Chromium without a display, and return the output of Chromium."""
    command = [
        CHROMIUM,
        "--headless",
        "--no-sandbox",
        "--enable-unsafe-swiftshader",  # WebGL without a graphics card
        "--use-angle=swiftshader",
        "--hide-scrollbars",
        "--virtual-time-budget=20000",
        f"--user-data-dir={folder}",
        *arguments,
        page.as_uri(),
    ]
    process = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=3600)
    assert process.returncode == 0, process.stderr
    return process.stdout


@pytest.mark.slow
def test_every_page_of_the_folder_is_in_the_site(site) -> None:
    docs = ROOT / "docs"
    names = {
        path.relative_to(docs).with_suffix(".html")
        for path in (*docs.glob("*.md"), *docs.glob("results/*.md"))
    }
    assert all((site / name).is_file() for name in names)
    assert "igl_linabf.linabf" in (site / "api" / "index.html").read_text("utf-8")
    for folder, pages in (("demos", "gallery"), ("recipes", "recipes")):
        for script in (ROOT / folder).glob("*.py"):
            assert (site / pages / f"{script.stem}.html").is_file()


@pytest.mark.slow
@needs_chromium
def test_the_interactive_page_shows_the_scene(site, tmp_path) -> None:
    frame = re.search(
        r'<iframe class="scene"[^>]* src="([^"]+)"', (site / "gallery/in_the_browser.html").read_text("utf-8")
    )
    picture = tmp_path / "scene.png"
    run_chromium(site / "gallery" / frame[1], tmp_path, "--window-size=1400,700", f"--screenshot={picture}")
    image = read_pixels(picture)
    surface, flat = image[:, :700], image[:, 700:]
    light, dark = find_colour(flat, LIGHT).mean(), find_colour(flat, DARK).mean()
    assert 0.08 < light < 0.4
    assert 0.7 < light / dark < 1.4  # half of a checkerboard is light
    assert find_colour(flat, "black").any()  # the boundary of the map is drawn in black
    assert 20 <= count_square_changes(flat) <= 30
    drawn = ~find_colour(surface, "white")
    assert 0.15 < drawn.mean() < 0.8
    assert np.unique(surface[drawn], axis=0).shape[0] > 1000  # the surface is shaded
    blue = (
        surface[..., 2].astype(int) - surface[..., 0]
    )  # whatever the shading, dark squares are blue and light squares are yellow
    assert 0.5 < (blue[drawn] > 15).sum() / (blue[drawn] < 0).sum() < 2


@pytest.mark.slow
@needs_chromium
def test_formulas_are_typeset_without_a_network(site, tmp_path) -> None:
    text = run_chromium(site / "method.html", tmp_path, "--dump-dom")
    written = len(
        re.findall(r'class="math notranslate nohighlight"', (site / "method.html").read_text("utf-8"))
    )
    assert text.count("<mjx-container") >= written > 50
    assert "<mjx-merror" not in text
