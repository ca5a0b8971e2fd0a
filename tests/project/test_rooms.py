"""Subpackages ("rooms") are small, and are imported by other subpackages only through their `__init__`.

import-linter checks which subpackages a subpackage may import, with the contracts in pyproject.toml.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
import re
from collections import Counter
from pathlib import Path

import grimp
from conftest import ROOT
from documented import resolve

import igl_linabf

MODULES = [module.name for module in pkgutil.walk_packages(igl_linabf.__path__, "igl_linabf.")]
FACES = ["igl_linabf", *(name for name in MODULES if name.count(".") == 1)]
PACKAGE = Path(igl_linabf.__file__).parent
MAX_MODULES = 12  # maximum number of modules in a folder


def room_of(module: str) -> str:
    return module.rpartition(".")[0]


def test_rooms_import_only_the_init_of_other_rooms() -> None:
    graph = grimp.build_graph("igl_linabf", cache_dir=None)
    faces = {name for name in graph.modules if graph.find_children(name)}
    reached_into = [
        f"{importer} imports {imported}"
        for importer in sorted(graph.modules)
        for imported in sorted(graph.find_modules_directly_imported_by(importer))
        # allowed: the `__init__` of any subpackage, and modules of subpackages that contain the importer
        if not f"{importer if importer in faces else room_of(importer)}.".startswith(f"{room_of(imported)}.")
    ]
    assert not reached_into, reached_into


def test_a_folder_has_at_most_a_dozen_modules() -> None:
    folders = Counter(path.parent for path in PACKAGE.rglob("*.py") if path.name != "__init__.py")
    full = {str(folder.relative_to(PACKAGE)): n for folder, n in folders.items() if n > MAX_MODULES}
    assert not full, full


def test_no_room_imports_the_package_itself() -> None:
    graph = grimp.build_graph("igl_linabf", cache_dir=None)
    assert graph.find_modules_that_directly_import("igl_linabf") == set()


def test_a_module_with_the_name_of_a_public_function_defines_it() -> None:
    functions = [
        function
        for face in map(importlib.import_module, FACES)
        for function in (getattr(face, name) for name in getattr(face, "__all__", ()))
        if inspect.isfunction(function)
    ]
    wrong = [
        f"{module} does not define {function.__module__}.{function.__name__}"
        for function in functions
        for module in MODULES
        if module.rpartition(".")[2] == function.__name__ and module != function.__module__
    ]
    assert len(functions) > 30
    assert not wrong, wrong


def test_the_picture_of_the_rooms_matches_the_contracts() -> None:
    spec = importlib.util.spec_from_file_location("rooms_picture", ROOT / "docs" / "rooms_picture.py")
    picture = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(picture)
    assert picture.PICTURE.read_text(encoding="utf-8") == picture.draw_rooms()
    assert {f"igl_linabf.{name}" for layer in picture.read_layers()[""] for name in layer} >= set(FACES[1:])


def test_each_step_of_the_architecture_page_names_a_function() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    lines = re.findall(r"^\d+\. (.*)$", page, re.MULTILINE)
    assert len(lines) == 20
    for line in lines:
        named = [resolve(name) for name in re.findall(r"`(\w+(?:\.\w+)+)`", line)]
        assert any(inspect.isroutine(thing) for thing in named), line
