"""Results as plain data for `--json`: every figure under the name of its attribute."""

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum

import numpy as np

MAPS = {"FTC", "split", "outlines", "sides"}  # of an atlas of polygons, and of a pattern
LISTED = {"flipped", "repaired", "first"}  # the arrays of indices that say where something is wrong


def as_json(figures: Mapping[str, object]) -> str:
    """One line; infinite and undefined numbers are null."""
    return json.dumps(plain(figures), allow_nan=False)


def plain(value: object) -> object:
    """A result as dictionaries, lists, texts and numbers, without the arrays of the map."""
    if is_dataclass(value) and not isinstance(value, type):
        pairs = (
            (field.name, getattr(value, field.name)) for field in fields(value) if field.name not in MAPS
        )
        return {k: plain(v) for k, v in pairs if not isinstance(v, np.ndarray) or k in LISTED}
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, Enum):
        return plain(value.value)
    if isinstance(value, np.generic):
        return plain(value.item())
    return None if isinstance(value, float) and not math.isfinite(value) else value
