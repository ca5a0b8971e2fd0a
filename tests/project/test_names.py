"""All names that the docs, docstrings and messages use exist."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import pkgutil
import re
import typing
from pathlib import Path
from types import ModuleType

import pytest
from conftest import ROOT
from documented import read_reference, resolve

import igl_linabf

DOCS = ROOT / "docs"
PAGES = [*ROOT.glob("*.md"), *DOCS.glob("*.md"), *DOCS.glob("results/*.md"), DOCS / "api" / "index.rst"]
SCRIPTS = [path for name in ("demos", "recipes", "benchmarks") for path in (ROOT / name).rglob("*.py")]
SOURCES = [*(ROOT / "igl_linabf").rglob("*.py"), *SCRIPTS]
FILE = re.compile(r"\.(md|py|toml|cff|yml|yaml|obj|off|ply|stl|glb|png|html|csv|mtl|json|tif)")


def check_names(names: list[str]) -> None:
    """Assert that all names can be resolved."""
    wrong = {}
    for name in names:
        try:
            resolve(name)
        except (AttributeError, ImportError) as error:
            wrong[name] = str(error)
    assert not wrong, wrong


def label(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", [*PAGES, *SOURCES], ids=label)
def test_every_name_of_the_package_and_of_igl_exists(path: Path) -> None:
    check_names(re.findall(r"\b(?:igl_linabf|igl)(?:\.[A-Za-z_]\w*)+", path.read_text(encoding="utf-8")))


def find_imports(source: str) -> list[str]:
    """Return the names that a script imports from the package and igl, or uses of their modules."""
    tree, names = ast.parse(source), {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and not node.level:
            names |= {name.asname or name.name: f"{node.module}.{name.name}" for name in node.names}
        if isinstance(node, ast.Import):
            names |= {name.asname: name.name for name in node.names if name.asname}
    names = {short: name for short, name in names.items() if name.split(".")[0] in ("igl_linabf", "igl")}
    modules = [short for short, name in names.items() if isinstance(resolve(name), ModuleType)]
    used = [
        f"{names[node.value.id]}.{node.attr}"
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in modules
    ]
    return [*names.values(), *used]


@pytest.mark.parametrize("path", SCRIPTS, ids=label)
def test_every_module_attribute_that_a_script_uses_exists(path: Path) -> None:
    check_names(find_imports(path.read_text(encoding="utf-8")))


# the changelog also names objects that later versions removed
@pytest.mark.parametrize("path", [path for path in PAGES if path.name != "CHANGELOG.md"], ids=label)
def test_every_dotted_name_in_backticks_exists(path: Path) -> None:
    names = re.findall(r"`([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)+)(?:\([^`]*\))?`", path.read_text(encoding="utf-8"))
    check_names([name for name in names if not FILE.fullmatch(name, name.rindex("."))])


def test_every_entry_of_the_reference_exists() -> None:
    assert len(read_reference()) > 40
    check_names(read_reference())


@pytest.mark.parametrize("name", read_reference())
def test_results_and_options_have_at_most_twelve_public_fields(name: str) -> None:
    thing = resolve(name)
    if not isinstance(thing, type):
        return
    fields = dataclasses.fields(thing) if dataclasses.is_dataclass(thing) else ()
    names = getattr(thing, "_fields", [field.name for field in fields])
    assert len([one for one in names if not one.startswith("_")]) <= 12


def read_rows(page: str, head: str) -> list[list[str]]:
    """Return the cells of the table whose first line starts with `head`."""
    table = re.search(
        rf"^\| {head} \|.*\n\|[-| ]+\|\n((?:\|.*\n?)+)", (ROOT / page).read_text("utf-8"), re.MULTILINE
    )
    assert table is not None, f"{page} has no table of {head}"
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in table[1].splitlines()]


def find_code_names(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def test_the_table_of_rooms_is_complete_and_names_existing_files() -> None:
    rooms = [
        name.rstrip("/")
        for row in read_rows("CONTRIBUTING.md", "subpackage")
        for name in find_code_names(row[0])
    ]
    check_names([f"igl_linabf.{name}" for name in rooms])
    assert set(rooms) == {module.name for module in pkgutil.iter_modules(igl_linabf.__path__)}
    for folders, files, *_ in read_rows("CONTRIBUTING.md", "folder"):
        (folder,) = find_code_names(folders)
        missing = [
            n for n in find_code_names(files) if n.endswith(".py") and not (ROOT / folder / n).is_file()
        ]
        assert not missing, missing


def find_equations(text: str) -> set[int]:
    """Return the numbers after "eq."; for "eq. 5, 6 and 11-13", these are 5, 6, 11, 12 and 13."""
    found = set()
    for several in re.findall(r"\beq\. (\d+(?:-\d+)?(?:(?:, | and )\d+(?:-\d+)?)*)", text):
        for first, last in re.findall(r"(\d+)(?:-(\d+))?", several):
            found.update(range(int(first), int(last or first) + 1))
    return found


@pytest.mark.parametrize("row", read_rows("docs/method.md", "in the paper"), ids=lambda row: row[1])
def test_the_places_of_numbered_items_of_the_paper_cite_them(row: list[str]) -> None:
    number, _, places = row
    assert find_code_names(places)
    for place in find_code_names(places):
        if "/" in place:
            source = (ROOT / place).read_text("utf-8")
        else:
            source = inspect.getsource(typing.cast("type", resolve(place)))
        if number.startswith("eq."):
            assert find_equations(number) <= find_equations(source), place
        else:
            assert number.lower() in source.lower(), place


def test_the_method_has_every_equation_that_the_code_cites() -> None:
    listed = set().union(*(find_equations(row[0]) for row in read_rows("docs/method.md", "in the paper")))
    cited = set().union(
        *(find_equations(path.read_text("utf-8")) for path in (ROOT / "igl_linabf").rglob("*.py"))
    )
    assert cited <= listed
