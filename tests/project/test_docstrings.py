"""The API reference documents all parameters and results, according to the checks of numpydoc."""

from __future__ import annotations

import dataclasses
import enum

import pytest
from documented import read_reference, resolve
from numpydoc.docscrape import get_doc_object
from numpydoc.validate import Validator, validate

CHECKS = {
    "PR01",  # a parameter is not documented
    "PR02",  # a documented parameter does not exist
    "PR03",
    "PR04",  # a parameter has no type
    "PR10",  # a space is missing before the colon after a parameter
    "RT01",  # the returned value is not documented
    "YD01",  # the yielded value is not documented
    "GL06",  # a section has an unknown title
    "GL08",  # the docstring is missing
}


class DataclassValidator(Validator):
    """A validator that accepts the public fields of a dataclass as documented attributes."""

    def __init__(self, obj_name: str) -> None:
        super().__init__(get_doc_object(resolve(obj_name)))

    @property
    def signature_parameters(self) -> tuple[str, ...]:
        return tuple(name for name in super().signature_parameters if not name.startswith("_"))

    @property
    def doc_all_parameters(self) -> dict[str, tuple[str, str]]:
        if not dataclasses.is_dataclass(self.obj):
            return super().doc_all_parameters
        described = self._doc_parameters(["Attributes"])
        properties = {name for name in described if isinstance(getattr(self.obj, name, None), property)}
        return {name: value for name, value in described.items() if name not in properties}


@pytest.mark.parametrize("name", read_reference())
def test_parameters_and_returns_are_documented(name: str) -> None:
    thing = resolve(name)
    wrong = [error for error in validate(name, DataclassValidator)["errors"] if error[0] in CHECKS]
    if isinstance(thing, type) and issubclass(thing, enum.Enum):
        # enumerations inherit undocumented parameters from Enum
        wrong = [error for error in wrong if not error[0].startswith("PR")]
    assert not wrong, wrong
