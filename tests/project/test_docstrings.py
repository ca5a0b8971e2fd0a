"""What the reference says of parameters and of what is returned, by numpydoc's own checks."""

from __future__ import annotations

import dataclasses
import enum

import pytest
from documented import reference, resolved
from numpydoc.docscrape import get_doc_object
from numpydoc.validate import Validator, validate

CHECKS = {
    "PR01",  # a parameter is not documented
    "PR02",  # one is documented that is not there
    "PR03",  # they come in another order than in the signature
    "PR04",  # a parameter has no type
    "PR10",  # no space before the colon after its name
    "RT01",  # something is returned, which is not documented
    "YD01",  # or yielded
    "GL06",  # a section has a title that numpydoc does not know
    "GL08",  # there is no docstring
}


class Documented(Validator):
    """As numpydoc's, but the fields of a dataclass are documented as attributes, which its class has."""

    def __init__(self, obj_name: str) -> None:
        super().__init__(get_doc_object(resolved(obj_name)))

    @property
    def doc_all_parameters(self) -> dict[str, tuple[str, str]]:
        if not dataclasses.is_dataclass(self.obj):
            return super().doc_all_parameters
        described = self._doc_parameters(["Attributes"])
        properties = {name for name in described if isinstance(getattr(self.obj, name, None), property)}
        return {name: value for name, value in described.items() if name not in properties}


@pytest.mark.parametrize("name", reference())
def test_parameters_and_returns_are_documented(name: str) -> None:
    thing = resolved(name)
    wrong = [error for error in validate(name, Documented)["errors"] if error[0] in CHECKS]
    if isinstance(thing, type) and issubclass(thing, enum.Enum):
        wrong = [error for error in wrong if not error[0].startswith("PR")]  # Enum's own parameters
    assert not wrong, wrong
