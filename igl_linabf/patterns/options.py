"""Check the options of a pattern, and convert lengths to millimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray
from ..errors import is_number
from ..surface import parse_direction

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8, "um": 1e-3}
DEFAULT_UNITS = "mm"  # unit of length if the file of a surface does not state a unit
MIN_COMPENSATION, MAX_COMPENSATION = 0.5, 2.0  # range of valid factors; larger numbers may be percentages


@dataclass(frozen=True, eq=False)
class PatternOptions:
    """How pieces are turned, enlarged and finished; all lengths are in millimetres.

    Attributes
    ----------
    units : str
        Unit of length of the surface.
    crease : float
        Smallest dihedral angle at a fold line, in degrees.
    grain : (3,) float64
        Unit direction of the arrows in space.
    up : (3,) float64, or None
        Unit direction in space that points up on the pieces; None for the direction of the grain.
    tabs, allowance : float
        Widths of glue tabs and of the seam allowance; 0 for none.
    compensation : (float, float)
        Factors that enlarge the pieces across and along the grain.
    """

    units: str
    crease: float
    grain: FloatArray
    up: FloatArray | None
    tabs: float
    allowance: float
    compensation: tuple[float, float]

    @classmethod
    def from_arguments(
        cls,
        units: str | None,
        crease: float,
        grain: ArrayLike,
        up: ArrayLike | None = None,
        tabs: float | None = None,
        allowance: float | None = None,
        compensation: ArrayLike = (1.0, 1.0),
    ) -> PatternOptions:
        """Check the options of `write_pattern`, or raise a `ValueError`."""
        units = units or DEFAULT_UNITS
        if units not in MILLIMETRES:
            raise ValueError(f"units is {units!r}: use one of {', '.join(MILLIMETRES)}")
        if not is_number(crease, 0, 180):
            raise ValueError(f"crease is {crease!r}: use an angle from 0 to 180 degrees")
        if tabs is not None and allowance is not None:
            raise ValueError(
                "tabs and allowance cannot be combined, because both fill the space beside a seam: "
                "use tabs for paper that is glued, and allowance for cloth that is sewn"
            )
        for name, width in (("tabs", tabs), ("allowance", allowance)):
            if width is not None and not (is_number(width, 0, above=True) and np.isfinite(width)):
                raise ValueError(f"{name} is {width!r}: use a positive width in {units}, or leave it out")
        return cls(
            units,
            float(crease),
            parse_direction(grain, "grain"),
            None if up is None else parse_direction(up, "up"),
            float(tabs or 0) * MILLIMETRES[units],
            float(allowance or 0) * MILLIMETRES[units],
            _check_compensation(compensation),
        )

    @property
    def unit_in_mm(self) -> float:
        """The length of the surface's unit in millimetres."""
        return MILLIMETRES[self.units]

    def check_widths(self, extent: float) -> None:
        """Raise a `ValueError` if tabs or allowance are as wide as the largest piece, in millimetres."""
        for name, width in (("tabs", self.tabs), ("allowance", self.allowance)):
            if width >= extent:
                raise ValueError(
                    f"{name} is {width / self.unit_in_mm:g} {self.units}, but the largest piece measures "
                    f"only {extent / self.unit_in_mm:.3g} {self.units}: use a smaller width, in the unit of "
                    "the surface"
                )


def _check_compensation(compensation: ArrayLike) -> tuple[float, float]:
    """Return the factors across and along the grain, or raise a `ValueError`."""
    given = np.ravel(np.array(compensation, dtype=object)).tolist()
    if len(given) != 2 or not all(is_number(f, MIN_COMPENSATION, MAX_COMPENSATION) for f in given):
        raise ValueError(
            f"compensation is {compensation!r}: use two factors, across and along the grain, from "
            f"{MIN_COMPENSATION:g} to {MAX_COMPENSATION:g}, such as (1.03, 1.05) for cloth that shrinks by "
            "3 % and 5 %"
        )
    return float(given[0]), float(given[1])
