"""The names that docs, docstrings and messages use are there, under just these names."""

from __future__ import annotations

import ast
import inspect
import pkgutil
import re
import typing
from pathlib import Path
from types import ModuleType

import pytest
from conftest import ROOT
from documented import reference, resolved

import igl_linabf

PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), ROOT / "docs" / "api" / "index.rst"]
SCRIPTS = [path for name in ("demos", "recipes", "benchmarks") for path in (ROOT / name).rglob("*.py")]
SOURCES = [*(ROOT / "igl_linabf").rglob("*.py"), *SCRIPTS]
FILE = re.compile(r"\.(md|py|toml|cff|yml|yaml|obj|off|ply|stl|glb|png|html|csv|mtl)")


def check(names: list[str]) -> None:
    """Fail by those names that stand for nothing."""
    wrong = {}
    for name in names:
        try:
            resolved(name)
        except (AttributeError, ImportError) as error:
            wrong[name] = str(error)
    assert not wrong, wrong


def label(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", [*PAGES, *SOURCES], ids=label)
def test_every_name_of_the_package_and_of_igl_is_there(path: Path) -> None:
    check(re.findall(r"\b(?:igl_linabf|igl)(?:\.[A-Za-z_]\w*)+", path.read_text(encoding="utf-8")))


def imported(source: str) -> list[str]:
    """What a script imports from the package and from igl, and what it uses of modules among these."""
    tree, names = ast.parse(source), {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and not node.level:
            names |= {name.asname or name.name: f"{node.module}.{name.name}" for name in node.names}
        if isinstance(node, ast.Import):
            names |= {name.asname: name.name for name in node.names if name.asname}
    names = {short: name for short, name in names.items() if name.split(".")[0] in ("igl_linabf", "igl")}
    modules = [short for short, name in names.items() if isinstance(resolved(name), ModuleType)]
    used = [
        f"{names[node.value.id]}.{node.attr}"
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in modules
    ]
    return [*names.values(), *used]


@pytest.mark.parametrize("path", SCRIPTS, ids=label)
def test_every_name_that_a_script_takes_of_a_module_is_there(path: Path) -> None:
    check(imported(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("path", PAGES, ids=label)
def test_every_dotted_name_in_backticks_is_there(path: Path) -> None:
    names = re.findall(r"`([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)+)(?:\([^`]*\))?`", path.read_text(encoding="utf-8"))
    check([name for name in names if not FILE.fullmatch(name, name.rindex("."))])


def test_every_entry_of_the_reference_is_there() -> None:
    assert len(reference()) > 40
    check(reference())


def rows_of(page: str, head: str) -> list[list[str]]:
    """The cells of the table whose first line begins with `head`."""
    table = re.search(
        rf"^\| {head} \|.*\n\|[-| ]+\|\n((?:\|.*\n?)+)", (ROOT / page).read_text("utf-8"), re.MULTILINE
    )
    assert table is not None, f"{page} has no table of {head}"
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in table[1].splitlines()]


def named(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def test_the_map_shows_every_room_and_every_file_that_it_names_is_there() -> None:
    rooms = [name.rstrip("/") for row in rows_of("CONTRIBUTING.md", "room") for name in named(row[0])]
    check([f"igl_linabf.{name}" for name in rooms])
    assert set(rooms) == {module.name for module in pkgutil.iter_modules(igl_linabf.__path__)}
    for folders, files, *_ in rows_of("CONTRIBUTING.md", "folder"):
        (folder,) = named(folders)
        missing = [n for n in named(files) if n.endswith(".py") and not (ROOT / folder / n).is_file()]
        assert not missing, missing


def equations(text: str) -> set[int]:
    """The numbers after "eq.": of "eq. 5, 6 and 11-13" 5, 6, 11, 12 and 13."""
    found = set()
    for several in re.findall(r"\beq\. (\d+(?:-\d+)?(?:(?:, | and )\d+(?:-\d+)?)*)", text):
        for first, last in re.findall(r"(\d+)(?:-(\d+))?", several):
            found.update(range(int(first), int(last or first) + 1))
    return found


@pytest.mark.parametrize("row", rows_of("docs/method.md", "in the paper"), ids=lambda row: row[1])
def test_what_the_paper_numbers_is_where_the_method_says_and_says_so(row: list[str]) -> None:
    number, _, places = row
    assert named(places)
    for place in named(places):
        if "/" in place:
            source = (ROOT / place).read_text("utf-8")
        else:
            source = inspect.getsource(typing.cast("type", resolved(place)))
        if number.startswith("eq."):
            assert equations(number) <= equations(source), place
        else:
            assert number.lower() in source.lower(), place


def test_the_method_has_every_equation_that_the_code_cites() -> None:
    listed = set().union(*(equations(row[0]) for row in rows_of("docs/method.md", "in the paper")))
    cited = set().union(*(equations(path.read_text("utf-8")) for path in (ROOT / "igl_linabf").rglob("*.py")))
    assert cited <= listed
