"""Anderson acceleration of steps whose changes fall slowly."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .._types import FloatArray
from .linearised import Direction

LONGEST = 10.0  # sum of the coefficients' sizes, above which the steps are no straight line


@dataclass(frozen=True, eq=False)
class Past:
    """An earlier step: the angles before it, its errors and its multipliers."""

    alpha: FloatArray
    e: FloatArray
    x: FloatArray


def accelerated(
    alpha: FloatArray, direction: Direction, past: tuple[Past, ...], unit: FloatArray
) -> Direction:
    """The direction towards where the steps lead, were their errors linear in the angles (Anderson 1965).

    Of all means of this step and the `past` ones, with coefficients c that sum to one, it takes the one whose
    errors sum c_i e_i / unit are least, and goes from `alpha` to sum c_i (alpha_i + e_i). Where one mode of
    the errors falls slowly, it is gone after that. The linear constraints stay as they are.
    """
    past = tuple(step for step in past if len(step.x) == len(direction.x))
    if not past:
        return direction
    e = direction.e
    apart = np.array([((e - step.e) / unit).ravel() for step in past])
    coefficients = np.linalg.lstsq(apart @ apart.T, apart @ (e / unit).ravel(), rcond=1e-8)[0]
    if not np.abs(coefficients).sum() < LONGEST:
        return direction
    ahead, x = e, direction.x
    for share, step in zip(coefficients, past, strict=True):
        ahead = ahead - share * ((alpha - step.alpha) + (e - step.e))
        x = x - share * (direction.x - step.x)
    return replace(direction, e=ahead, x=x)
