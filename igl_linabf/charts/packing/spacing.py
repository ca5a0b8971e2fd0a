"""What lies between charts: of a page's side, or in texels."""

from __future__ import annotations

from dataclasses import dataclass

from ...errors import is_number

PADDING = 2.0  # texels, where none are asked for
WIDEST = 0.1  # of the side between two charts


@dataclass(frozen=True)
class Spacing:
    """Distances as shares of a page's side.

    Attributes
    ----------
    gap : float
        Between two charts, in u or in v.
    border : float
        To the page's border.
    """

    gap: float
    border: float

    @classmethod
    def of(cls, margin: float, resolution: int | None, padding: float) -> Spacing:
        """The margin on all sides; or, with a resolution, the padding, half of it at the border.

        A point's bilinear footprint reaches less than a texel far, so charts two texels apart share none.

        Raises
        ------
        ValueError
            One is out of its range.
        """
        if resolution is None:
            if not is_number(margin, 0, WIDEST):
                raise ValueError(
                    f"margin is {margin!r}: give a share of the square's side, from 0 to {WIDEST}"
                )
            if not (is_number(padding) and padding == PADDING):
                raise ValueError(
                    f"padding is {padding!r}, and texels need a resolution: give the texels along a page's "
                    "side, too, or a margin instead"
                )
            return cls(margin, margin)
        if not is_number(resolution, 1, whole=True):
            raise ValueError(
                f"resolution is {resolution!r}: give the texels along a square page's side, like 1024"
            )
        most = WIDEST * resolution
        if not is_number(padding, 0, most):
            raise ValueError(
                f"padding is {padding!r} texels of {resolution} along a page: give 0 to {most:g}"
            )
        return cls(padding / resolution, padding / resolution / 2)

    @property
    def inner(self) -> float:
        """The side of what charts may cover."""
        return 1 - 2 * self.border

    def wider(self, by: float) -> Spacing:
        """The same and `by` more on all sides."""
        return Spacing(self.gap + by, self.border + by)

    def at_most(self, gap: float) -> Spacing:
        """The same, made smaller in proportion, if the gap is larger than this."""
        return self if self.gap <= gap else Spacing(gap, self.border * gap / self.gap)
