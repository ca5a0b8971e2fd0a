"""The rooms of the package: entered by their faces, under names that nothing else has.

Their order is import-linter's to check, by the contract in pyproject.toml.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil

import grimp

import igl_linabf

MODULES = [module.name for module in pkgutil.walk_packages(igl_linabf.__path__, "igl_linabf.")]
FACES = ["igl_linabf", *(name for name in MODULES if name.count(".") == 1)]


def test_from_another_room_only_the_face_is_imported() -> None:
    graph = grimp.build_graph("igl_linabf", cache_dir=None)
    reached_into = [
        f"{importer} imports {imported}"
        for importer in sorted(graph.modules)
        for imported in sorted(graph.find_modules_directly_imported_by(importer))
        if imported not in FACES and importer.split(".")[:2] != imported.split(".")[:2]
    ]
    assert not reached_into, reached_into


def test_no_room_imports_the_package_itself() -> None:
    graph = grimp.build_graph("igl_linabf", cache_dir=None)
    assert graph.find_modules_that_directly_import("igl_linabf") == set()


def test_no_module_bears_the_name_of_a_public_function() -> None:
    functions = {
        f"{face}.{name}": name
        for face in FACES
        for name in getattr(importlib.import_module(face), "__all__", ())
        if inspect.isfunction(getattr(importlib.import_module(face), name))
    }
    modules = {name.rpartition(".")[2]: name for name in MODULES}
    both = [f"{modules[name]} and {function}" for function, name in functions.items() if name in modules]
    assert len(functions) > 30
    assert not both, both
