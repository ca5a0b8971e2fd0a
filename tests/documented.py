"""Names in the docs, and what they stand for."""

from __future__ import annotations

import importlib
import re
import typing
from types import ModuleType

from conftest import ROOT

import igl_linabf
from igl_linabf import Atlas, Chart, Flattening

OBJECTS = {"result": Flattening, "atlas": Atlas, "chart": Chart}  # what the docs call one of them


def attribute(thing: object, name: str) -> object:
    """`thing.name`; of a class, also what its objects have under that name."""
    if hasattr(thing, name):
        return getattr(thing, name)
    if isinstance(thing, ModuleType):
        return importlib.import_module(f"{thing.__name__}.{name}")
    fields = typing.get_type_hints(thing) if isinstance(thing, type) else {}
    if name not in fields:
        raise AttributeError(f"{thing!r} has no attribute {name}")
    return fields[name]


def resolved(dotted: str) -> object:
    """What a dotted name stands for: in the package, of one of its results, or elsewhere."""
    first, *rest = dotted.split(".")
    try:
        thing = OBJECTS.get(first) or attribute(igl_linabf, first)
    except ImportError:
        thing = importlib.import_module(first)
    for name in rest:
        thing = attribute(thing, name)
    return thing


def reference() -> list[str]:
    """Every entry of the reference, docs/api/index.rst, with the module that it is listed under."""
    names, module = [], ""
    for line in (ROOT / "docs" / "api" / "index.rst").read_text("utf-8").splitlines():
        if line.startswith(".. currentmodule::"):
            module = line.split()[-1]
        elif re.fullmatch(r"   \w+", line):
            names.append(f"{module}.{line.strip()}")
    return names
