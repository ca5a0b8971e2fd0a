"""The options of `unwrap` for cones."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ...errors import first_few, format_count, is_number

GivenCones = Literal["auto"] | ArrayLike
ConeAngles = Literal["quarter"] | ArrayLike | None


@dataclass(frozen=True, eq=False)
class Cones:
    """Options for cones, the vertices at which the map keeps all curvature. `cones=4` means `cones=Cones(4)`.

    The seam is a tree through the cones and the holes, with loops that open the handles. In the map, both
    sides of each seam edge are equally long (docs/cones.md).

    Attributes
    ----------
    at : (#C,) int, int or "auto"
        Interior vertices, or the number of cones that `find_cones` finds on each component. "auto" adds cones
        as long as the saved stretch is worth another cone.
    angles : (#C,) float or "quarter", optional
        Angle sums at the cones, radians. By default the angles of the conformal map that has the same scale
        at all cones and the boundary. "quarter" chooses multiples of 90 degrees that need little stretch. The
        two sides of each seam then differ by a rotation by a multiple of 90 degrees and a translation.
    period : float, optional
        Period of a texture, as a share of the page's side, for cones with `angles="quarter"`. The two sides
        of each seam are then shifted by whole periods. Therefore the texture continues across the seams.
        Points of the map move by about half a period.

    Raises
    ------
    ValueError
        The vertices or their angles are malformed, `period` is out of its range, or an option needs another
        option that is not given.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F, cones=Cones(4, angles="quarter"))
    >>> bool(atlas.report.seam_mismatch < 1e-6)
    True
    >>> float(atlas.report.cone_angles.sum() / np.pi)  # 4 x 2 pi, less 4 pi
    4.0
    """

    at: GivenCones = "auto"
    _: KW_ONLY
    angles: ConeAngles = None
    period: float | None = None

    def __post_init__(self) -> None:
        angles, given = self.angles, np.asarray(self.at)
        if isinstance(angles, str) and angles != "quarter":
            raise ValueError(f"angles is {angles!r}: use 'quarter', an angle sum for each cone, or None")
        if given.ndim == 0:
            found = isinstance(self.at, str) and self.at == "auto"
            if not found and (given.dtype.kind not in "iu" or given < 0):
                raise ValueError(f"cones is {self.at!r}: give 'auto', a number of cones, or their vertices")
            if not (angles is None or isinstance(angles, str)):
                raise ValueError(
                    "angles need the vertices of the cones, which are yet to be found: give their vertices"
                )
        elif given.ndim != 1 or (given.dtype.kind not in "iu" and given.size):
            raise ValueError(
                f"cones has the shape {given.shape} and the dtype {given.dtype}: give a number of cones, or "
                "the indices of their vertices"
            )
        elif not (angles is None or isinstance(angles, str)):
            _check_sums(angles, len(given))
        period = self.period
        if period is not None and (angles is None or not is_number(period, 0, 0.5, above=True)):
            raise ValueError(
                f"period is {period!r}: give a share of the page's side, above 0 and at most a half, with "
                'cones and angles="quarter"'
            )


def _check_sums(angles: ArrayLike, n: int) -> None:
    """Raise a `ValueError` unless `angles` are valid angle sums of `n` cones."""
    sums = np.asarray(angles)
    if sums.shape != (n,) or sums.dtype.kind not in "iuf":
        raise ValueError(
            f"angles has the shape {sums.shape} for {format_count(n, 'cone')}: give a number of radians "
            "for each"
        )
    bad = np.flatnonzero(~(np.isfinite(sums) & (sums > 0)))
    if len(bad):
        raise ValueError(
            f"angles {first_few(bad)} of cones are not positive (the first: {sums[bad[0]]:g}): an angle sum "
            "is above zero; a cone of curvature k has 2 pi - k"
        )
