"""Options of `unwrap` for charts, and the rules that follow from the options."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..errors import MeshError, first_few, format_count, is_number
from ..flattening import Isometric, Method, MethodOptions, resolve_method
from .atlas import ISOMETRY_ENERGY, STRETCH_ROUNDING, UNUSABLE_STRETCH
from .cones import Cones, GivenCones
from .features import Hiding
from .packing import Packing, PackingRequest
from .seams import TRADE, SeamSearch, check_trade

# Cut a piece if the expected L2 stretch of its isometric map exceeds 1 by more than this.
# The value holds for the default `trade`.
UNEVEN_STRETCH = 0.03
MEASURED_OVER_EXPECTED = 8.0  # maximum ratio of measured to expected (L2 stretch - 1)


@dataclass(frozen=True, eq=False)
class ChartOptions:
    """Options for the charts of `unwrap`: where to cut, and which charts to cut further.

    Attributes
    ----------
    trade : float
        Seam length that is worth a decrease of the L2 stretch by 1, see `find_seams`. Larger values allow
        longer seams.
    hide : (3,) or (#F,) float, or "back", optional
        Where seams are preferred, see `find_seams`: a direction (`[0, -1, 0]` is the back if the front looks
        to +y), a weight for each face, or "back" for the back of a head or figure.
    keep_holes : bool
        Do not cut from hole to hole, unless `seams=` has such cuts or the map would overlap itself. No seam
        ends at a hole of a plane in any case.
    extend : bool
        Add seams to those in `seams=` where handles or closed pieces are not open, or to reduce stretch.
    max_stretch : float, optional
        Cut charts, also along edges that are not in `seams=`, until the L2 stretch of each chart is at most
        `max_stretch`, which is at least 1. The L2 stretch exceeds 1 by about the square of the changes of
        lengths: 1.01 permits changes of about 8 %, and 1.0001 of 0.8 % (root mean square). By default stretch
        is weighed against the length of seams, and a chart is cut in any case if its L2 stretch is above 10,
        or above 1.24 for isometric maps at the default `trade`.
    max_dirichlet : float, optional
        Bound on the mean symmetric Dirichlet energy of the whole atlas: the mean of s1^2 + s2^2 + s1^-2 +
        s2^-2 over the area. It is 4 for an isometry, and 4 times `Quality.symmetric_dirichlet`. A search over
        `trade` finds the shortest seams that meet the bound. OptCuts and UVgami use the bound 4.1.
    max_charts : int, optional
        Bound on the number of charts. A search over smaller values of `trade` meets the bound. With
        `max_dirichlet`, the atlas has to meet both bounds.
    repair_overlaps : bool
        If a chart overlaps itself, move its parts apart with `make_bijective` instead of splitting it, and
        report the increase of the mean angle distortion F/3nt as `Chart.distortion_increase`. Charts with
        holes, and charts whose stretch would increase by more than a fifth, are still split.
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
        """Return True if there are bounds on the whole atlas, which a search over `trade` has to meet."""
        return self.max_dirichlet is not None or self.max_charts is not None

    def label_faces(self, face: IntArray) -> IntArray | None:
        """Return the label of each triangle; `face` has the input face that each triangle is part of.

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
                f"labels have the shape {given.shape} for {format_count(n_faces, 'face')}: pass one for "
                "each face"
            )
        bad = np.flatnonzero(~(np.isfinite(given) & (given == np.round(given))))
        if len(bad):
            raise MeshError(f"labels at faces {first_few(bad)} are not integers: number the materials")
        return np.unique(np.asarray(self.labels), return_inverse=True)[1].ravel()[face]


def resolve_method_of_charts(
    method: str | Method | None, cones: object, options: MethodOptions | None = None
) -> Method:
    """Return the method object of a call of `unwrap`, with the method's keywords in `options`.

    Cones need a method that preserves angles.

    Raises
    ------
    ValueError
        An option is unknown to the method; the message states where it belongs.
    """
    options = {} if options is None else options
    for name, value in options.items():
        for keyword, home in (("charts", ChartOptions), ("packing", Packing), ("cones", Cones)):
            if name in {field.name for field in fields(home)}:
                passed = f"{keyword}={home.__name__}({name}={value!r})"
                raise ValueError(f"{name} is an option of {home.__name__}: pass {passed}")
    return resolve_method(method or ("isometric" if cones is None else "linabf"), options)


def _list_changed_fields(charts: ChartOptions) -> list[str]:
    """Return the names of the options that do not have their default values."""
    return [field.name for field in fields(charts) if getattr(charts, field.name) is not field.default]


def resolve_options(
    seams: ArrayLike | None,
    charts: ChartOptions | None,
    cones: Cones | GivenCones | None,
    packing: Packing | None,
) -> tuple[ChartOptions, Cones | None, PackingRequest]:
    """Check the options of a call of `unwrap`, and return them with defaults for missing options.

    Raises
    ------
    ValueError
        The options cannot be combined.
    """
    for name, given in (("seams", seams), ("charts", charts)):
        if cones is not None and given is not None:
            names = _list_changed_fields(given) if isinstance(given, ChartOptions) else []
            named = " and ".join(f"{option}=" for option in names or [name])
            raise ValueError(
                f"cones= and {named} do not go together, because seams run through the cones: "
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
    request = PackingRequest.from_packing(packing)
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
    """The rules by which `unwrap` flattens pieces and cuts them further."""

    method: Method
    may_find_seams: bool
    trade: float
    keep_holes: bool
    repair_overlaps: bool
    max_stretch: float | None
    hidden: FloatArray | None

    @classmethod
    def from_options(
        cls, method: Method, asked: ChartOptions, seams_given: bool, hidden: FloatArray | None
    ) -> ChartRules:
        """Return the rules for a call of `unwrap`; `hidden` are the results of `compute_hiding_weights`."""
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
    def seam_search(self) -> SeamSearch:
        """The search for seams with the options of these rules."""
        return SeamSearch(self.trade, self.method, self.keep_holes, self.hidden)

    def get_required_gain(self, length: float) -> float:
        """Return the decrease of the L2 stretch that justifies a seam of the given length.

        The length is in square roots of the area.
        """
        return length / self.trade if self.trade else np.inf

    @property
    def stretch_limit(self) -> float:
        """Maximum L2 stretch of a chart; charts with more stretch are cut further."""
        if self.max_stretch is not None:
            return self.max_stretch * (1 + STRETCH_ROUNDING)
        measured = 1 + MEASURED_OVER_EXPECTED * (self.even_stretch_limit - 1)
        return min(UNUSABLE_STRETCH, measured) if self.may_find_seams else np.inf

    @property
    def even_stretch_limit(self) -> float:
        """Expected L2 stretch of an isometric map up to which a piece needs no more seams."""
        if not (self.weighs_stretch and self.trade and isinstance(self.method, Isometric)):
            return np.inf
        return 1 + UNEVEN_STRETCH * max(TRADE / self.trade, 1.0)

    @property
    def weighs_stretch(self) -> bool:
        """Return True if charts are cut further whenever the saved stretch is worth a seam."""
        return self.may_find_seams and not self.keep_holes and self.max_stretch is None
