"""The options of `unwrap` for charts, and the rules that follow from them."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..errors import MeshError, is_number, some
from ..flattening import Isometric, Method, MethodOptions, resolve_method
from .atlas import ISOMETRY_ENERGY, STRETCH_ROUNDING, UNUSABLE_STRETCH
from .cones import Cones, GivenCones
from .features import Hiding
from .packing import Packing, PackingRequest
from .seams import TRADE, SeamSearch, check_trade

# Maximum expected L2 stretch beyond 1 of the isometric map of an uncut piece, at the default `trade`.
UNEVEN_STRETCH = 0.03
MEASURED_OVER_EXPECTED = 8.0  # maximum measured stretch beyond 1 of an isometric map, over the expected one


@dataclass(frozen=True, eq=False)
class ChartOptions:
    """How `unwrap` makes charts: where it cuts, and which charts it cuts further.

    Attributes
    ----------
    trade : float
        As in `find_seams`: larger values allow longer seams to reduce stretch.
    hide : (3,) or (#F,) float, or "back", optional
        As in `find_seams`: a direction (`[0, -1, 0]` is the back if the front looks to +y), a weight for each
        face, or "back" for the back of a head or figure. The search for seams prefers faces on that side.
    keep_holes : bool
        Leave holes uncut, unless `seams=` cuts them or the map would overlap itself. Holes of planes are
        never cut.
    extend : bool
        Add the seams that are missing in `seams=`, to open handles and closed pieces and to reduce stretch.
    max_stretch : float, optional
        Cut charts, also along edges that are not in `seams=`, until the L2 stretch of each chart is at most
        `max_stretch`, which is at least 1. By default stretch is weighed against the length of seams; only
        charts with an L2 stretch above 10, or above 1.24 for isometric maps at the default `trade`, are cut.
    max_dirichlet : float, optional
        Bound on the mean symmetric Dirichlet energy of the whole atlas: the mean of s1^2 + s2^2 + s1^-2 +
        s2^-2 over the area, which is 4 for an isometry, or 4 times `Quality.symmetric_dirichlet`. The bound
        is met by a search over `trade`, for the shortest seams. 4.1 is the bound of OptCuts and UVgami.
    max_charts : int, optional
        Bound on the number of charts, met by a search over smaller values of `trade`. With `max_dirichlet`,
        the atlas has to meet both.
    repair_overlaps : bool
        If a chart overlaps itself, move its parts apart with `make_bijective` instead of splitting it, and
        report the increase of F/3nt as `Chart.distortion_increase`. Charts with holes, and charts whose
        stretch would increase by more than a fifth, are still split.
    labels : (#F,) int, optional
        Charts do not cross edges between faces of different labels, for example materials:
        `ChartOptions(labels=mesh.extras.materials[1])`. Within a label, charts are cut as usual.

    Raises
    ------
    ValueError
        `trade`, `max_stretch`, `max_dirichlet` or `max_charts` is out of its range.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> short, long = (igl_linabf.unwrap(V, F, charts=ChartOptions(trade=trade)) for trade in (0, 30))
    >>> short.seam_length < long.seam_length
    True
    """

    _: KW_ONLY
    trade: float = TRADE
    hide: Hiding | None = None
    keep_holes: bool = False
    extend: bool = False
    max_stretch: float | None = None
    max_dirichlet: float | None = None
    max_charts: int | None = None
    repair_overlaps: bool = False
    labels: ArrayLike | None = None

    def __post_init__(self) -> None:
        check_trade(self.trade)
        if self.max_stretch is not None and not is_number(self.max_stretch, 1):
            raise ValueError(f"max_stretch is {self.max_stretch!r}: give an L2 stretch from 1 (none) upwards")
        energy, charts = self.max_dirichlet, self.max_charts
        if energy is not None and not is_number(energy, ISOMETRY_ENERGY, above=True):
            raise ValueError(f"max_dirichlet is {energy!r}: give a number above 4, the energy of an isometry")
        if charts is not None and not (is_number(charts, 1, whole=True) and charts < np.inf):
            raise ValueError(f"max_charts is {charts!r}: give a whole number, 1 or larger")

    @property
    def bounds_atlas(self) -> bool:
        """Return True if a bound on the whole atlas is to be met by a search over `trade`."""
        return self.max_dirichlet is not None or self.max_charts is not None

    def label_faces(self, face: IntArray) -> IntArray | None:
        """Return the label of each triangle; `face` has the caller's face of each triangle.

        Raises
        ------
        MeshError
            The labels are not integers, or their number differs from the number of faces.
        """
        if self.labels is None:
            return None
        n_faces = int(face[-1]) + 1
        try:
            given = np.asarray(self.labels, dtype=np.float64)
        except (TypeError, ValueError):
            raise MeshError("labels are not an array of integers: pass one for each face") from None
        if given.shape != (n_faces,):
            raise MeshError(
                f"labels have the shape {given.shape} for {n_faces} faces: pass one for each face"
            )
        bad = np.flatnonzero(~(np.isfinite(given) & (given == np.round(given))))
        if len(bad):
            raise MeshError(f"labels at faces {some(bad)} are not integers: number the materials")
        return np.unique(np.asarray(self.labels), return_inverse=True)[1].ravel()[face]


def resolve_method_of_charts(
    method: str | Method | None, cones: object, options: MethodOptions | None = None
) -> Method:
    """Return the method of a call of `unwrap`, or the default method, with the keywords `options`.

    Cones need a method that preserves angles.

    Raises
    ------
    ValueError
        An option is not an option of the method; the message states where it belongs.
    """
    options = {} if options is None else options
    for name, value in options.items():
        for keyword, home in (("charts", ChartOptions), ("packing", Packing), ("cones", Cones)):
            if name in {field.name for field in fields(home)}:
                passed = f"{keyword}={home.__name__}({name}={value!r})"
                raise ValueError(f"{name} is an option of {home.__name__}: pass {passed}")
    return resolve_method(method or ("isometric" if cones is None else "linabf"), options)


def resolve_options(
    seams: ArrayLike | None,
    charts: ChartOptions | None,
    cones: Cones | GivenCones | None,
    packing: Packing | None,
) -> tuple[ChartOptions, Cones | None, PackingRequest]:
    """Check the options of a call of `unwrap`, replace missing options by defaults, and return them.

    Raises
    ------
    ValueError
        The options cannot be combined.
    """
    for name, given in (("seams", seams), ("charts", charts)):
        if cones is not None and given is not None:
            raise ValueError(
                f"cones= and {name}= do not go together, because seams run through the cones: "
                "leave out one of them"
            )
    asked = ChartOptions() if charts is None else charts
    if not isinstance(asked, ChartOptions):
        raise ValueError(f"charts is {charts!r}: give ChartOptions, and edges as seams=")
    if asked.extend and seams is None:
        raise ValueError("extend=True adds to given seams: give their edges as seams=, or leave it out")
    if asked.bounds_atlas and seams is not None and not asked.extend:
        raise ValueError(
            "max_dirichlet and max_charts are met by the choice of further seams: give extend=True with "
            "seams=, or leave them out"
        )
    coned = cones if cones is None or isinstance(cones, Cones) else Cones(cones)
    request = PackingRequest.of(packing)
    if coned is not None and request.unseen != 1:
        raise ValueError(
            "unseen= and cones= do not go together, because cones match the texels across seams: "
            "leave out one of them"
        )
    if coned is not None and coned.period is not None and request.spacing.aspect != 1:
        raise ValueError("period= is a share of a square page's side: give one number as the resolution")
    return asked, coned, request


@dataclass(frozen=True)
class ChartRules:
    """The rules of `unwrap` for flattening pieces and cutting them further."""

    method: Method
    may_find_seams: bool
    trade: float
    keep_holes: bool
    repair_overlaps: bool
    max_stretch: float | None
    hidden: FloatArray | None

    @classmethod
    def of(
        cls, method: Method, asked: ChartOptions, seams_given: bool, hidden: FloatArray | None
    ) -> ChartRules:
        """Return the rules for a call of `unwrap`; `hidden` are the `hiding_weights`."""
        return cls(
            method,
            not seams_given or asked.extend,
            asked.trade,
            asked.keep_holes,
            asked.repair_overlaps,
            asked.max_stretch,
            hidden,
        )

    @property
    def search(self) -> SeamSearch:
        """The search for seams with the options of these rules."""
        return SeamSearch(self.trade, self.method, self.keep_holes, self.hidden)

    def worth(self, length: float) -> float:
        """Return the decrease of the L2 stretch that justifies a seam of the given length.

        The length is in square roots of the area.
        """
        return length / self.trade if self.trade else np.inf

    @property
    def most_stretch(self) -> float:
        """Maximum L2 stretch of a chart that is not cut further."""
        if self.max_stretch is not None:
            return self.max_stretch * (1 + STRETCH_ROUNDING)
        measured = 1 + MEASURED_OVER_EXPECTED * (self.even_stretch - 1)
        return min(UNUSABLE_STRETCH, measured) if self.may_find_seams else np.inf

    @property
    def even_stretch(self) -> float:
        """Maximum expected L2 stretch of the isometric map of a piece that needs no more seams."""
        if not (self.weighs_stretch and self.trade and isinstance(self.method, Isometric)):
            return np.inf
        return 1 + UNEVEN_STRETCH * max(TRADE / self.trade, 1.0)

    @property
    def weighs_stretch(self) -> bool:
        """Return True if charts are cut further where the saved stretch is worth a seam."""
        return self.may_find_seams and not self.keep_holes and self.max_stretch is None
