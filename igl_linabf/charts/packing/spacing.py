"""Options for packing charts, and the distances between charts on a page."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...errors import is_number

DEFAULT_PADDING = 2.0  # default distance between charts, in texels, if a resolution is given
DEFAULT_MARGIN = 0.005  # default distance between charts without a resolution, as a share of the page's side
DEFAULT_MARGIN_OF_CELL = 0.05  # the default margin of n charts is at most this / sqrt(n)
MAX_GAP = 0.1  # maximum gap between two charts, as a share of the page's side


@dataclass(frozen=True)
class Spacing:
    """Distances on a page: shares of its width in u, and of its height in v.

    Attributes
    ----------
    gap : float
        Distance between two charts, in u or in v.
    border : float
        Distance to the page's border.
    aspect : float
        Height of the page over its width.
    is_default : bool
        Whether the distances are the defaults, which depend on the number of charts.
    """

    gap: float
    border: float
    aspect: float = 1.0
    is_default: bool = False

    @classmethod
    def from_packing(cls, packing: Packing) -> Spacing:
        """Return the spacing of a packing: the margin, or the padding if there is a resolution.

        The margin applies between charts and at the border of the page. The padding applies between charts,
        and half of it at the border. The bilinear footprint of a point extends less than one texel to each
        side. Therefore charts two texels apart share no texels.
        On pages that are not square, the padding is at least as wide along the longer side.
        """
        if packing.resolution is None:
            margin = DEFAULT_MARGIN if packing.margin is None else packing.margin
            return cls(margin, margin, is_default=packing.margin is None)
        width, height = parse_page_size(packing.resolution)
        share = packing.padding / min(width, height)
        return cls(share, share / 2, height / width)

    @property
    def inner_width(self) -> float:
        """The width of the page without its borders."""
        return 1 - 2 * self.border

    def adapt_to_number_of_charts(self, number: int) -> Spacing:
        """Return the spacing for a number of charts, with a smaller default margin if there are many."""
        return self.limit_gap(DEFAULT_MARGIN_OF_CELL / np.sqrt(number)) if self.is_default else self

    def widen(self, by: float) -> Spacing:
        """Return the spacing with `by` added to the gap and to the border."""
        return replace(self, gap=self.gap + by, border=self.border + by, is_default=False)

    def limit_gap(self, gap: float) -> Spacing:
        """Return the spacing, scaled down if necessary so that the gap is at most `gap`."""
        return self if self.gap <= gap else replace(self, gap=gap, border=self.border * gap / self.gap)


def parse_page_size(resolution: Any) -> tuple[int, int]:
    """Return the width and height of a page in texels for the option `resolution`.

    Raises
    ------
    ValueError
        The resolution is neither a positive integer nor a pair of them.
    """
    sides = tuple(resolution) if isinstance(resolution, tuple | list) else (resolution, resolution)
    if len(sides) != 2 or not all(is_number(side, 1, whole=True) for side in sides):
        raise ValueError(
            f"resolution is {resolution!r}: give the texels along a square page's side, like 1024, or width "
            "and height, like (2048, 1024)"
        )
    return int(sides[0]), int(sides[1])


@dataclass(frozen=True, kw_only=True)
class Packing:
    """Options for packing charts: for a texture, or into the unit square with a margin.

    Attributes
    ----------
    resolution : int or (int, int), optional
        Texels along a square page's side, or a page's width and height. In texture coordinates, every page is
        a unit square, even if width and height differ. With a resolution, distances
        are given by `padding` instead of `margin`.
    padding : float
        Texels between two charts, in u or in v, and half as many at the border. With 2 or more, no two
        charts share a texel of a bilinear lookup. Needs `resolution`.
    texel_density : float, optional
        Texels per unit of length of V, averaged over a chart. Needs `resolution`. `unwrap` cuts charts that
        are larger than a page, unless seams are given. By default charts are as large as the pages allow.
    pages : int, optional
        Maximum number of pages; the result may use fewer (`Atlas.pages`). The default is 1, or as many as
        necessary with `texel_density`. Page k is the unit square with the lower left corner
        (k % 10, k // 10), UDIM tile 1001 + k.
    margin : float, optional
        Distance between charts, and to the border, as a share of the unit square's side, if there is no
        `resolution`. If there are too many charts for the margin, `unwrap` reduces it with a warning. The
        default is 0.005 for up to 100 charts, and 0.05 / sqrt(#charts) for more.
    cut_below : float, optional
        If charts cover less than this share of the page, `unwrap` cuts charts with many limbs further until
        this share is covered. Each cut must be worth its seam (see `ChartOptions.trade`). With a value below
        1, the cuts also have to make the page a quarter fuller. The default is 0.5, and 1 with a
        `resolution`. With 0, charts are never cut for a fuller page. Not available with `texel_density`.
    unseen : float
        Texel density of charts that are invisible from outside, such as cavities, relative to all other
        charts: above 0, up to 1. Available in `unwrap` without cones, and in `pack`. Visibility is tested
        from 8 faces of each chart in 100 directions.

    Raises
    ------
    ValueError
        A number is out of its range, or an option needs another option that is not given.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F, packing=Packing(resolution=1024, texel_density=100))
    >>> round(atlas.report.scale * 1024, 6), atlas.pages
    (100.0, 1)
    """

    resolution: int | tuple[int, int] | None = None
    padding: float = DEFAULT_PADDING
    texel_density: float | None = None
    pages: int | None = None
    margin: float | None = None
    cut_below: float | None = None
    unseen: float = 1.0

    def __post_init__(self) -> None:
        resolution, padding, density = self.resolution, self.padding, self.texel_density
        if self.margin is not None and not is_number(self.margin, 0, MAX_GAP):
            raise ValueError(
                f"margin is {self.margin!r}: give a share of the square's side, from 0 to {MAX_GAP}"
            )
        if resolution is None:
            if not (is_number(padding) and padding == DEFAULT_PADDING):
                raise ValueError(
                    f"padding is {padding!r}, and texels need a resolution: give the texels along a page's "
                    "side, too, or a margin instead"
                )
        else:
            least = min(parse_page_size(resolution))
            if self.margin is not None:
                raise ValueError(
                    f"margin is {self.margin!r}, and with a resolution distances are in texels: "
                    "give padding instead"
                )
            most = MAX_GAP * least
            if not is_number(padding, 0, most):
                raise ValueError(f"padding is {padding!r} texels of {least} along a page: give 0 to {most:g}")
        if self.cut_below is not None and not is_number(self.cut_below, 0, 1):
            raise ValueError(
                f"cut_below is {self.cut_below!r}: give the share of a page that is full enough, from 0 to 1"
            )
        if not is_number(self.unseen, 0, 1, above=True):
            raise ValueError(
                f"unseen is {self.unseen!r}: give a share of the texel density, above 0, up to 1"
            )
        pages = self.pages
        if not (pages is None or (isinstance(pages, int | np.integer) and is_number(pages, 1))):
            raise ValueError(f"pages is {pages!r}: give a whole number from 1 upwards, or None")
        if density is not None:
            if self.cut_below is not None:
                raise ValueError("cut_below is for pages whose scale is free: leave it or texel_density out")
            if resolution is None:
                raise ValueError("texel_density needs a resolution: give the texels along a page's side, too")
            if not is_number(density, 0, np.finfo(float).max, above=True):
                raise ValueError(f"texel_density is {density!r}: give texels per unit of length, above 0")


def resolve_packing(packing: Packing | None) -> Packing:
    """Return the packing options; by default one page with a margin.

    Raises
    ------
    ValueError
        `packing` is not a `Packing`.
    """
    if packing is None:
        return Packing()
    if not isinstance(packing, Packing):
        raise ValueError(f"packing is {packing!r}: give igl_linabf.Packing(resolution=1024), or another")
    return packing
