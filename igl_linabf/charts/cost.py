"""The cost of an atlas, E = stretch + seams / trade + page, and the price of a seam along each edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._types import BoolArray, FloatArray

CREASE_DISCOUNT = 0.5  # relative price reduction of seams at dihedral angles of 90 degrees or more
SHARP_CREASE_PRICE = 0.15  # additional factor on the price of a seam along a sharp crease
CREASE_ANGLE = np.deg2rad(15.0)  # minimum dihedral angle of a crease
SHARP_CREASE_ANGLE = np.deg2rad(40.0)  # minimum dihedral angle of a sharp crease, where shading breaks


def compute_edge_prices(length: FloatArray, bend: FloatArray, is_hard: BoolArray) -> FloatArray:
    """Return the price of a seam along each edge.

    A seam is less visible along a crease. It is hardly visible along a sharp crease of a body with planes,
    where the shading is discontinuous anyway.

    Parameters
    ----------
    length : (#E,) float64
        Length of each edge, multiplied by the factor of `ChartOptions.hide`.
    bend : (#E,) float64
        Dihedral angle at each edge, radians.
    is_hard : (#E,) bool
        Whether the edge is on a body with planes. On other bodies, large angles are noise or due to coarse
        triangles.

    Returns
    -------
    price : (#E,) float64
        In units of length.
    """
    crease = 1 - CREASE_DISCOUNT * np.minimum(np.abs(bend) / (np.pi / 2), 1)
    sharpness = is_hard * np.clip((np.abs(bend) - CREASE_ANGLE) / (SHARP_CREASE_ANGLE - CREASE_ANGLE), 0, 1)
    sharp = 1 - (1 - SHARP_CREASE_PRICE) * sharpness
    return np.asarray(length * crease * sharp)


@dataclass(frozen=True)
class AtlasCost:
    """The cost of an atlas in units of L2 stretch: stretch, seams, and the unused part of the pages.

    `unwrap` weighs stretch against seams by `ChartOptions.trade` and, if a resolution is given, also against
    the unused part of the pages. Stretch and seams are means over the components, weighted by area. No term
    depends on the size of the surface.

    Attributes
    ----------
    stretch : float
        Mean L2 stretch of the charts, weighted by area, minus 1. For isometric maps the result is multiplied
        by 6. The value is 0 if all lengths are preserved, and infinite if a triangle has collapsed.
    seams : float
        Length of the seams, in square roots of the component's area, divided by `ChartOptions.trade`. An edge
        with a dihedral angle of 90 degrees or more counts half; for smaller angles the reduction is
        proportional to the angle. On bodies with planes, sharp creases count 0.15 of the reduced length. With
        `ChartOptions.hide`, the length of each edge is multiplied by a factor from 1/3 (hidden) to 3 (in full
        view). Given seams cost the same as seams that are found. The value is infinite if `trade` is 0 and
        there are seams.
    page : float
        Ratio of unused to covered area of the pages: 1 / fill - 1.

    Examples
    --------
    >>> import igl_linabf
    >>> V = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    >>> F = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    >>> net = igl_linabf.unwrap(V, F)  # of a cube: eight sharp edges are seams
    >>> round(net.cost.stretch, 9), round(net.cost.seams * igl_linabf.ChartOptions().trade * 6**0.5, 9)
    (0.0, 0.6)
    """

    stretch: float = 0.0
    seams: float = 0.0
    page: float = 0.0

    @property
    def total(self) -> float:
        """The cost of the atlas: the sum of `stretch`, `seams` and `page`."""
        return self.stretch + self.seams + self.page

    def __str__(self) -> str:
        terms = f"stretch {self.stretch:.3g}, seams {self.seams:.3g}, page {self.page:.3g}"
        return f"cost {self.total:.3g}, in units of L2 stretch: {terms}"


def compute_page_cost(fill: float) -> float:
    """Return the cost of pages; `fill` is the share of the pages that charts cover."""
    return 1 / fill - 1 if fill > 0 else float("inf")
