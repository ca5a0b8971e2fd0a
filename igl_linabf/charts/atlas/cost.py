"""What an atlas costs."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AtlasCost:
    """What an atlas costs, in units of L2 stretch: stretch, seams, and what is wasted of the pages.

    `unwrap` weighs the first two against each other by `Seams.trade`, and with a resolution the third, too.
    Of several components the first two are means, weighted by area. No term depends on the surface's size.

    Attributes
    ----------
    stretch : float
        L2 stretch of the charts less 1, the mean by area; of an isometric method times the factor by which
        its stretch counts for seams. 0: no length changes. Infinite if a triangle has collapsed.
    seams : float
        Length of the seams, in square roots of the component's area, over `Seams.trade`. Edges along a
        crease of a right angle or more count half, others at creases in proportion to their angle; edges
        that `Seams.hide` hides or shows are multiplied by a third to three. Given seams cost what others do.
        Infinite if `trade` is 0 and there are seams.
    page : float
        Texels of the pages beside charts, over those that charts cover: 1 / fill - 1.

    Examples
    --------
    >>> import igl_linabf
    >>> V = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    >>> F = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    >>> net = igl_linabf.unwrap(V, F)  # of a cube: seven of its edges are seams
    >>> round(net.cost.stretch, 9), round(net.cost.seams * igl_linabf.Seams().trade * 6**0.5, 9)
    (0.0, 3.5)
    """

    stretch: float = 0.0
    seams: float = 0.0
    page: float = 0.0

    @property
    def total(self) -> float:
        """The sum of the three."""
        return self.stretch + self.seams + self.page

    def __str__(self) -> str:
        terms = f"stretch {self.stretch:.3g}, seams {self.seams:.3g}, page {self.page:.3g}"
        return f"cost {self.total:.3g}, in units of L2 stretch: {terms}"


def page_cost(fill: float) -> float:
    """The cost of pages of which charts cover this share."""
    return 1 / fill - 1 if fill > 0 else float("inf")
