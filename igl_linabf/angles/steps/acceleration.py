"""Anderson acceleration of steps whose changes fall slowly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._types import FloatArray
from .constants import LARGEST_COEFFICIENTS
from .linearisation import Direction


@dataclass(frozen=True, eq=False)
class PastStep:
    """A step that may accelerate later ones.

    Attributes
    ----------
    alpha : (3, #F) float64
        The angles before it.
    direction : Direction
    missing : (n,) float64
        What is to vanish, at these angles.
    """

    alpha: FloatArray
    direction: Direction
    missing: FloatArray

    @cached_property
    def reached(self) -> FloatArray:
        """The angles after the step, (3 #F,)."""
        return np.add(self.alpha, self.direction.e).ravel()


def accelerate(now: PastStep, earlier: Sequence[PastStep]) -> Direction:
    """The direction to where the steps lead, were what is missing linear in the angles (Anderson 1965).

    Of all sums of these steps with coefficients c_i that sum to one, it takes the one whose missing parts
    sum to the least, and goes to sum c_i (alpha_i + e_i). A mode of the errors that falls slowly is gone
    after that. The linear constraints stay as they are.
    """
    coefficients = anderson_coefficients([past.missing for past in earlier], now.missing)
    if not coefficients:
        return now.direction
    e, x = now.direction.e.ravel().copy(), now.direction.x.copy()
    for c, past in zip(coefficients, earlier, strict=True):
        e += c * (past.reached - now.reached)
        x += c * (past.direction.x - now.direction.x)
    return replace(now.direction, e=e.reshape(now.alpha.shape), x=x)


def anderson_coefficients(earlier: Sequence[FloatArray], now: FloatArray) -> list[float]:
    """The coefficients of earlier steps, by what was missing there; the present one's makes them sum to 1.

    Empty if they are large: then what is missing is far from linear.
    """
    if not earlier:
        return []
    change = [past - now for past in earlier]
    size = np.sqrt([_dot(d, d) for d in change])
    between = np.array([[_dot(a, b) for a in change] for b in change]) / np.outer(size, size)
    along = np.array([_dot(d, now) for d in change]) / size
    coefficients: FloatArray = -np.linalg.lstsq(between, along)[0] / size
    return coefficients.tolist() if np.abs(coefficients).sum() < LARGEST_COEFFICIENTS else []


def _dot(a: FloatArray, b: FloatArray) -> float:
    """The scalar product without a BLAS: to wake its threads takes longer than they save."""
    return float(np.einsum("i,i->", a, b))
