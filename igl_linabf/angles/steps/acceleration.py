"""Anderson acceleration of steps whose changes fall slowly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._types import FloatArray
from .linearisation import Direction

LONGEST = 10.0  # sum of the coefficients' sizes, above which the steps are no straight line


@dataclass(frozen=True, eq=False)
class Visited:
    """Angles that an iteration came to.

    Attributes
    ----------
    alpha : (3, #F) float64
    direction : Direction
        The iteration's step from there.
    missing : (n,) float64
        What is to vanish, there.
    """

    alpha: FloatArray
    direction: Direction
    missing: FloatArray

    @cached_property
    def reached(self) -> FloatArray:
        """The angles after the step, (3 #F,)."""
        return np.add(self.alpha, self.direction.e).ravel()


def accelerated(now: Visited, earlier: Sequence[Visited]) -> Direction:
    """The direction towards where the steps lead, were what is missing linear in the angles (Anderson 1965).

    Of all sums of these visits with coefficients c_i that sum to one, it takes the one whose missing parts
    sum to the least, and goes to sum c_i (alpha_i + e_i). Where one mode of the errors falls slowly, it is
    gone after that. The linear constraints stay as they are.
    """
    shares = shares_of([past.missing for past in earlier], now.missing)
    if not shares:
        return now.direction
    e, x = now.direction.e.ravel().copy(), now.direction.x.copy()
    for share, past in zip(shares, earlier, strict=True):
        e += share * (past.reached - now.reached)
        x += share * (past.direction.x - now.direction.x)
    return replace(now.direction, e=e.reshape(now.alpha.shape), x=x)


def shares_of(earlier: Sequence[FloatArray], now: FloatArray) -> list[float]:
    """The coefficients of earlier visits by what was missing there, the rest being of the one now.

    Empty where they are on no straight line.
    """
    if not earlier:
        return []
    change = [past - now for past in earlier]
    size = np.sqrt([_dot(d, d) for d in change])
    between = np.array([[_dot(a, b) for a in change] for b in change]) / np.outer(size, size)
    along = np.array([_dot(d, now) for d in change]) / size
    shares: FloatArray = -np.linalg.lstsq(between, along)[0] / size
    return shares.tolist() if np.abs(shares).sum() < LONGEST else []


def _dot(a: FloatArray, b: FloatArray) -> float:
    """Without a BLAS, whose threads take longer to wake than they save."""
    return float(np.einsum("i,i->", a, b))
