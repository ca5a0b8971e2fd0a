"""The options of `unwrap`: of its seams, and what follows for its charts."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..errors import MeshError, is_number, some
from ..flattening import Isometric, Method
from .atlas import STRETCH_ROUNDING, UNUSABLE_STRETCH
from .cones import Cones, GivenCones
from .features import Hiding
from .packing import Packing, Wish
from .seams import TRADE, SeamSearch, check_trade

# Expected isometric L2 stretch beyond 1, at the default `trade`, from which a piece gets more seams.
UNEVEN_STRETCH = 0.03


@dataclass(frozen=True, eq=False)
class Seams:
    """Where `unwrap` cuts, and what for; `seams=edges` is short for `Seams(edges)`.

    Attributes
    ----------
    at : (#E, 2) int or (#F, 3) bool, optional
        The edges to cut, as `cut` takes them; a mask has the shape of `F`. By default `find_seams`
        finds them. If a chart has flipped faces, its seams are extended; if that does not help,
        `guarantee="injective"` is used.
    trade : float
        As in `find_seams`: larger allows longer seams for less stretch.
    hide : (3,) or (#F,) float, or "back", optional
        As in `find_seams`: a direction, as `[0, -1, 0]` for what looks back if the front looks to +y, or
        a weight for each face, or "back" of a head or figure. The seams that are found prefer the faces
        of that side.
    holes : bool
        Leave holes uncut, if the edges are not given.
    complete : bool
        The given edges are a beginning: the others that handles, closed pieces and stretch need are found.
    max_stretch : float, optional
        Cut or split charts, beyond given edges, too, until the L2 stretch of each is at most this.
        At least 1; by default stretch is only weighed against seam length.
    bijective : bool
        If a chart overlaps itself, move its parts apart with `make_bijective` instead of splitting
        it. The chart's `cost` is the increase of F/3nt. Charts with holes are split, and those
        that it would stretch by more than a fifth.
    labels : (#F,) int, optional
        Charts do not cross edges between faces of different labels, as of materials:
        `Seams(labels=mesh.extras.materials[1])`. They are cut further as without them.

    Raises
    ------
    ValueError
        `trade` or `max_stretch` is out of its range, or there is nothing to complete.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> short, long = (igl_linabf.unwrap(V, F, Seams(trade=trade)).seam_length for trade in (0, 30))
    >>> short < long
    True
    """

    at: ArrayLike | None = None
    _: KW_ONLY
    trade: float = TRADE
    hide: Hiding | None = None
    holes: bool = False
    complete: bool = False
    max_stretch: float | None = None
    bijective: bool = False
    labels: ArrayLike | None = None

    def __post_init__(self) -> None:
        check_trade(self.trade)
        if self.max_stretch is not None and not is_number(self.max_stretch, 1):
            raise ValueError(f"max_stretch is {self.max_stretch!r}: give an L2 stretch from 1 (none) upwards")
        if self.complete and self.at is None:
            raise ValueError("complete is for seams that are a beginning: give their edges, or leave it out")

    @property
    def are_found(self) -> bool:
        """Whether seams are found, all or beyond the given ones."""
        return self.at is None or self.complete

    def labels_of(self, face: IntArray) -> IntArray | None:
        """The label of each triangle; `face` is the caller's face of each.

        Raises
        ------
        MeshError
            They are no integers, or not as many as there are faces.
        """
        if self.labels is None:
            return None
        n_faces = int(face[-1]) + 1
        try:
            given = np.asarray(self.labels, dtype=np.float64)
        except (TypeError, ValueError):
            raise MeshError("labels are no array of integers: pass one for each face") from None
        if given.shape != (n_faces,):
            raise MeshError(
                f"labels have the shape {given.shape} for {n_faces} faces: pass one for each face"
            )
        bad = np.flatnonzero(~(np.isfinite(given) & (given == np.round(given))))
        if len(bad):
            raise MeshError(f"labels at faces {some(bad)} are no integers: number the materials")
        return np.unique(np.asarray(self.labels), return_inverse=True)[1].ravel()[face]


def asked_for(
    seams: Seams | ArrayLike | None, cones: Cones | GivenCones | None, packing: Packing | None
) -> tuple[Seams, Cones | None, Wish]:
    """The options of a call of `unwrap`, as objects.

    Raises
    ------
    ValueError
        They do not go together.
    """
    if cones is not None and seams is not None:
        raise ValueError(
            "cones= does not go together with seams=, as seams run through the cones: leave out one of them"
        )
    asked = seams if isinstance(seams, Seams) else Seams(seams)
    coned = cones if cones is None or isinstance(cones, Cones) else Cones(cones)
    wish = Wish.of(packing)
    if coned is not None and wish.unseen != 1:
        raise ValueError("unseen= and cones= do not go together, as cones match the texels across seams")
    if coned is not None and coned.period is not None and wish.spacing.aspect != 1:
        raise ValueError("period= is a share of a square page's side: give one number as the resolution")
    return asked, coned, wish


@dataclass(frozen=True)
class ChartOptions:
    """The method and the options of the charts of a call of `unwrap`."""

    method: Method
    may_find_seams: bool
    trade: float
    holes: bool
    bijective: bool
    max_stretch: float | None
    hidden: FloatArray | None

    @classmethod
    def of(cls, method: Method, seams: Seams, hidden: FloatArray | None) -> ChartOptions:
        """Those of a call of `unwrap`; `hidden` are the `hiding_weights`."""
        return cls(
            method, seams.are_found, seams.trade, seams.holes, seams.bijective, seams.max_stretch, hidden
        )

    @property
    def search(self) -> SeamSearch:
        """The search for seams by these options."""
        return SeamSearch(self.trade, self.method, self.holes, self.hidden)

    def worth(self, length: float) -> float:
        """The L2 stretch that a seam of this length, in square roots of the area, is worth."""
        return length / self.trade if self.trade else np.inf

    @property
    def most_stretch(self) -> float:
        """L2 stretch above which a chart is cut further."""
        if self.max_stretch is not None:
            return self.max_stretch * (1 + STRETCH_ROUNDING)
        return UNUSABLE_STRETCH if self.may_find_seams else np.inf

    @property
    def even_stretch(self) -> float:
        """L2 stretch to expect of an isometric map above which a piece gets more seams."""
        if not (self.weighs_stretch and self.trade and isinstance(self.method, Isometric)):
            return np.inf
        return 1 + UNEVEN_STRETCH * max(TRADE / self.trade, 1.0)

    @property
    def weighs_stretch(self) -> bool:
        """Whether charts are cut further where a seam is worth the stretch that it saves."""
        return self.may_find_seams and not self.holes and self.max_stretch is None
