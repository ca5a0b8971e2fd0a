"""Check JSON values against declared schemas."""

import json
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn, Protocol

from ..parsing import Damaged

MAX_DEPTH = 100  # nesting depth of lists and objects; glTF itself needs about ten
SURROGATE_PATTERN = re.compile("[\ud800-\udfff]")  # characters that UTF-8 cannot encode
MAX_QUOTED = 40  # number of characters of a wrong value shown in a message


class Schema(Protocol):
    """The requirements for a JSON value."""

    def check(self, value: Any, place: str, counts: Mapping[str, int]) -> None:
        """Raise `Damaged` if the value at `place` is invalid; `counts` has the lengths of glTF's lists."""
        ...


@dataclass(frozen=True)
class Integer:
    """The schema of an integer from `low` to `high`."""

    low: int = 0
    high: int = 2**53

    def check(self, value: Any, place: str, counts: Mapping[str, int]) -> None:
        if type(value) is not int or not self.low <= value <= self.high:
            _raise_damaged(value, place, f"an integer from {self.low} to {self.high}")


@dataclass(frozen=True)
class Number:
    """The schema of a finite number."""

    def check(self, value: Any, place: str, counts: Mapping[str, int]) -> None:
        try:
            is_finite = type(value) in (int, float) and math.isfinite(value)
        except OverflowError:  # an integer beyond double precision
            is_finite = False
        if not is_finite:
            _raise_damaged(value, place, "a finite number")


@dataclass(frozen=True)
class OfType:
    """The schema of a string or a Boolean."""

    kind: type

    def check(self, value: Any, place: str, counts: Mapping[str, int]) -> None:
        if type(value) is not self.kind:
            _raise_damaged(value, place, {str: "a text", bool: "true or false"}[self.kind])


@dataclass(frozen=True)
class OneOf:
    """The schema of a value from a fixed set."""

    values: Collection[int | str]

    def check(self, value: Any, place: str, counts: Mapping[str, int]) -> None:
        if type(value) not in (int, str) or value not in self.values:
            _raise_damaged(value, place, f"one of {', '.join(str(known) for known in self.values)}")


@dataclass(frozen=True)
class Index:
    """The schema of an index into the top-level list named `of`."""

    of: str

    def check(self, value: Any, place: str, counts: Mapping[str, int]) -> None:
        count = counts.get(self.of, 0)
        if type(value) is not int or not 0 <= value < count:
            _raise_damaged(value, place, f"the number of one of the {count} {self.of}")


@dataclass(frozen=True)
class ListOf:
    """The schema of a list, with `length` items if `length` is given."""

    item: Schema
    length: int | None = None

    def check(self, value: Any, place: str, counts: Mapping[str, int]) -> None:
        if not isinstance(value, list) or self.length not in (None, len(value)):
            _raise_damaged(
                value, place, "a list" if self.length is None else f"a list of {self.length} values"
            )
        for i, inner in enumerate(value):
            self.item.check(inner, f"{place}[{i}]", counts)


@dataclass(frozen=True)
class ObjectOf:
    """The schema of a JSON object whose values all have the same schema."""

    item: Schema

    def check(self, value: Any, place: str, counts: Mapping[str, int]) -> None:
        if not isinstance(value, dict):
            _raise_damaged(value, place, "an object")
        for key, inner in value.items():
            self.item.check(inner, f"{place}.{key}", counts)


@dataclass(frozen=True)
class Record:
    """The schema of a JSON object with known keys; additional keys are allowed."""

    optional: Mapping[str, Schema] = field(default_factory=dict)
    required: Mapping[str, Schema] = field(default_factory=dict)

    def check(self, value: Any, place: str, counts: Mapping[str, int]) -> None:
        if not isinstance(value, dict):
            _raise_damaged(value, place, "an object")
        for key in self.required:
            if key not in value:
                raise Damaged(f"its {place} lacks {key}, which glTF 2.0 requires")
        for schema in (self.required, self.optional):
            for key in schema.keys() & value.keys():
                schema[key].check(value[key], f"{place}.{key}" if place else key, counts)


def _raise_damaged(value: Any, place: str, expected: str) -> NoReturn:
    text = json.dumps(value)
    shown = text if len(text) <= MAX_QUOTED else f"{text[:MAX_QUOTED]}..."
    raise Damaged(f"its {place or 'description'} is {shown}, but glTF 2.0 requires {expected}")


def check_depth(value: Any) -> None:
    """Raise `Damaged` if lists and objects are nested so deeply that recursive functions could fail."""
    level = [value]
    for _ in range(MAX_DEPTH):
        level = [
            inner
            for outer in level
            for inner in (outer.values() if isinstance(outer, dict) else outer)
            if isinstance(inner, dict | list)
        ]
        if not level:
            return
    raise Damaged(f"its description is nested more than {MAX_DEPTH} levels deep")


def check_values(value: Any, place: str = "") -> None:
    """Raise `Damaged` if JSON holds values that cannot be written: infinite numbers or single surrogates."""
    if isinstance(value, list):
        for i, inner in enumerate(value):
            check_values(inner, f"{place}[{i}]")
    elif isinstance(value, dict):
        for key, inner in value.items():
            inside = f"{place}.{key}" if place else key
            _check_text(key, inside)
            check_values(inner, inside)
    elif isinstance(value, str):
        _check_text(value, place)
    elif isinstance(value, float) and not math.isfinite(value):
        raise Damaged(f"its {place} is a number beyond double precision: write a finite number")


def _check_text(text: str, place: str) -> None:
    if not text.isascii() and SURROGATE_PATTERN.search(text):
        raise Damaged(f"its {place} contains half of a surrogate pair, which is not a character: rename it")
