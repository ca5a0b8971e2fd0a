"""Lookup of the names that the docs use."""

from __future__ import annotations

import importlib
import re
import typing
from types import ModuleType

from conftest import ROOT

import igl_linabf
from igl_linabf import Atlas
from igl_linabf.charts import Chart
from igl_linabf.flattening import Flattening
from igl_linabf.uv import UVCheck

OBJECTS = {
    "result": Flattening,
    "atlas": Atlas,
    "chart": Chart,
    "check": UVCheck,
}  # objects whose variable names the examples in the docs use


def get_attribute(thing: object, name: str) -> object:
    """Return attribute `name` of an object, or the type of a field of a class."""
    if hasattr(thing, name):
        return getattr(thing, name)
    if isinstance(thing, ModuleType):
        return importlib.import_module(f"{thing.__name__}.{name}")
    fields = typing.get_type_hints(thing) if isinstance(thing, type) else {}
    if name not in fields:
        raise AttributeError(f"{thing!r} has no attribute {name}")
    return fields[name]


def resolve(dotted: str) -> object:
    """Return the object with a dotted name, in the package, in a result, or in another package.

    Names that the API reference lists may be given without their module.
    """
    first, *rest = dotted.split(".")
    for full in read_reference():
        if full.endswith(f".{first}") and not hasattr(igl_linabf, first):
            return resolve(".".join((full, *rest)))
    try:
        thing = OBJECTS.get(first) or get_attribute(igl_linabf, first)
    except ImportError:
        thing = importlib.import_module(first)
    for name in rest:
        thing = get_attribute(thing, name)
    return thing


def read_reference() -> list[str]:
    """Return all entries of the reference, docs/api/index.rst, with their modules."""
    names, module = [], ""
    for line in (ROOT / "docs" / "api" / "index.rst").read_text("utf-8").splitlines():
        if line.startswith(".. currentmodule::"):
            module = line.split()[-1]
        elif re.fullmatch(r"   \w+", line):
            names.append(f"{module}.{line.strip()}")
    return names
