"""The methods of `flatten`: one frozen dataclass per method, with the options as fields."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, TypedDict

from .._runtime import stopwatch
from ..errors import is_number
from ..layouts import LayoutName, check_method
from ..linalg import SolverName
from ..surface import Mesh, Pins
from . import baselines
from .boundary_shapes import FREE, Shape
from .constants import ABF_TOL, TOL
from .fallbacks import (
    ACTIVE_SET_RTOL,
    STEP_AND_CHORD_RTOL,
    ProblemOptions,
    Stage,
    build_result,
    continue_active_set,
    fall_back_to_linear,
    iterate_active_set,
    make_injective_map,
    make_isometric_map,
    reach_prescribed_sums,
    run_anchored_abf,
    run_feasible_abf,
    run_stages,
    set_up_problem,
    solve_one_system,
)
from .result import Flattening, Guarantee

Iterations = int | Literal["auto"]

AREA_WEIGHT = 1.5  # default exponent of the area term of the isometric energy; minimises the L2 stretch
MAX_AREA_WEIGHT = 8.0
ISOMETRIC_TOL = 1e-3  # default of `tol`: stop if further steps would save less than this share of the energy
LARGEST_FOR_ABF = 20_000  # maximum number of triangles for converged ABF as a fallback

STAGES = ("estimate", "layout", "assembly", "analysis", "factor", "solve")


class Method:
    """Base class of the methods; an unknown option raises an error that lists the known options."""

    name: str
    label: str  # name of the method in tables
    shapes: bool = False  # whether the method can shape the boundary

    def __new__(cls, *_: object, **options: object) -> Method:
        known: tuple[str, ...] = cls.__match_args__  # type: ignore[attr-defined]
        if not options.keys() <= set(known):
            unknown = next(option for option in options if option not in known)
            has = f"its options are {', '.join(known)}" if known else "it has no options"
            raise ValueError(f"{cls.__name__} has no option {unknown!r}: {has}")
        return super().__new__(cls)

    def run(self, mesh: Mesh, pinned: Pins | None, shape: Shape = FREE) -> Flattening:
        """Flatten a checked mesh, with checked pins and a checked shape of the boundary."""
        raise NotImplementedError


@dataclass(frozen=True)
class LinABF(Method):
    """Linear angle based parameterization (Zayer, Levy, Seidel, SGP 2007).

    Attributes
    ----------
    iterations, layout, rtol, tol, threshold, safeguard, guarantee, solver : see `linabf`
        As in `igl_linabf.linabf`.

    Raises
    ------
    ValueError
        An option has a value that is not allowed.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> igl_linabf.flatten(V, F[1:], method=LinABF(iterations=1)).report.iterations
    1
    """

    name = "linabf"
    label = "linABF"
    shapes = True

    iterations: Iterations = "auto"
    layout: LayoutName = "auto"
    rtol: float | None = None
    tol: float = TOL
    threshold: float = 1.0
    safeguard: bool = True
    guarantee: Guarantee | None = None
    solver: SolverName = "auto"

    def __post_init__(self) -> None:
        if not (isinstance(self.iterations, str) and self.iterations == "auto"):
            if not (is_number(self.iterations, 1) and hasattr(self.iterations, "__index__")):
                raise ValueError(f"iterations is {self.iterations!r}: use 'auto' or a positive integer")
            object.__setattr__(self, "iterations", operator.index(self.iterations))
        _check_options(self.guarantee, self.layout, self.threshold)
        if self.rtol is not None and not is_number(self.rtol, 0, above=True):
            raise ValueError(f"rtol is {self.rtol!r}: use a positive number")
        if not is_number(self.tol, 0):
            raise ValueError(f"tol is {self.tol!r}: use a number, 0 or larger")

    def run(self, mesh: Mesh, pinned: Pins | None, shape: Shape = FREE) -> Flattening:
        rtol = self.rtol or (STEP_AND_CHORD_RTOL if shape.circles else ACTIVE_SET_RTOL)
        stages: list[Stage]
        if self.iterations != "auto":
            stages = [partial(iterate_active_set, rtol=rtol, tol=self.tol, max_steps=self.iterations)]
        elif shape.sums is None:
            stages = _list_default_stages(self.rtol, self.tol)
        else:
            stages = [
                partial(reach_prescribed_sums, rtol=rtol, tol=self.tol),
                partial(run_anchored_abf, tol=ABF_TOL, residual_tol=self.tol),
                partial(run_feasible_abf, tol=ABF_TOL, residual_tol=self.tol),
            ]
        return _run_with_stages(self, mesh, pinned, shape, stages, self.safeguard)


@dataclass(frozen=True)
class ABF(Method):
    """Converged angle based flattening (Sheffer, de Sturler 2001).

    Attributes
    ----------
    layout, tol, threshold, guarantee, solver : see `linabf`
        As in `igl_linabf.abf`.

    Raises
    ------
    ValueError
        An option has a value that is not allowed.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> igl_linabf.flatten(V, F[1:], method=ABF(tol=1e-7)).outcome.value
    'converged'
    """

    name = "abf"
    label = "ABF"
    shapes = True

    layout: LayoutName = "auto"
    tol: float = ABF_TOL
    threshold: float = 1.0
    guarantee: Guarantee | None = None
    solver: SolverName = "auto"

    def __post_init__(self) -> None:
        _check_options(self.guarantee, self.layout, self.threshold)
        if not is_number(self.tol, 0, above=True):
            raise ValueError(f"tol is {self.tol!r}: use a positive number, at least 1e-10")

    def run(self, mesh: Mesh, pinned: Pins | None, shape: Shape = FREE) -> Flattening:
        stages: list[Stage] = [
            partial(run_anchored_abf, tol=self.tol),
            partial(run_feasible_abf, tol=self.tol),
        ]
        if shape.sums is not None:
            rtol = STEP_AND_CHORD_RTOL if shape.circles else ACTIVE_SET_RTOL
            stages.append(
                partial(fall_back_to_linear, linear=partial(reach_prescribed_sums, rtol=rtol, tol=TOL))
            )
        return _run_with_stages(self, mesh, pinned, shape, stages)


@dataclass(frozen=True)
class Isometric(Method):
    """The map that preserves lengths as well as possible, for textures, fabrics, and comparisons of areas.

    The start is the map of `LinABF`, from which flips are removed if needed (guarantee="injective"). Newton's
    method then reduces the area-weighted mean of the energy c a^weight until it stalls. Here, c = (s1 / s2 +
    s2 / s1) / 2 measures the angles, a = (s1 s2 + 1 / (s1 s2)) / 2 measures the areas, and s1 and s2 are the
    singular values (Degener, Meseth, Klein 2003). No triangle can flip.

    Attributes
    ----------
    weight : float
        Weight of areas against angles, from 0 to 8. 0: angles only. 1: the symmetric Dirichlet energy. Larger
        weights make areas more equal. The default minimises the L2 stretch.
    tol : float
        The steps end when further steps would reduce the mean energy by less than the share `tol`, predicted
        from the last two steps. The default leaves no visible difference. At 0, the steps continue until a
        step gains less than 1e-8 of the mean.
    solver : str
        As in `igl_linabf.linabf`.

    Raises
    ------
    ValueError
        An option has a value that is not allowed.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> maps = [igl_linabf.flatten(V, F[1:], method=Isometric(weight=w)).uv for w in (0, 1, 4)]
    >>> [round(igl_linabf.quality(V, F[1:], uv).area_distortion, 2) for uv in maps]
    [1.08, 0.53, 0.21]
    """

    name = "isometric"
    label = "isometric"

    weight: float = AREA_WEIGHT
    tol: float = ISOMETRIC_TOL
    solver: SolverName = "auto"

    def __post_init__(self) -> None:
        if not is_number(self.weight, 0, MAX_AREA_WEIGHT):
            raise ValueError(
                f"weight is {self.weight!r}: use a number from 0 (angles) over 1 (symmetric Dirichlet) "
                f"to {MAX_AREA_WEIGHT:g} (areas)"
            )
        if not is_number(self.tol, 0):
            raise ValueError(f"tol is {self.tol!r}: use a number, 0 or larger")

    def run(self, mesh: Mesh, pinned: Pins | None, shape: Shape = FREE) -> Flattening:
        with stopwatch(*STAGES) as seconds:
            problem = set_up_problem(mesh, ProblemOptions(solver=self.solver))
            results = run_stages(problem, [*_list_default_stages(None, TOL), make_injective_map])
            made = make_isometric_map(problem, results, self.weight, self.tol, pinned)
            if made is not None:
                # with pins, list only this stage, because earlier stages ignore the pins
                results = (made,) if pinned is not None else (*results, made)
            return build_result(problem, self.name, results, seconds)


@dataclass(frozen=True)
class OneStepABFpp(Method):
    """A single Newton step of ABF++ (Sheffer et al. 2005), for comparison.

    Attributes
    ----------
    layout, threshold, solver : see `linabf`
        As in `igl_linabf.linabf`.
    """

    name = "one-step-abf++"
    label = "ABF++, one step"

    layout: LayoutName = "auto"
    threshold: float = 1.0
    solver: SolverName = "auto"

    def __post_init__(self) -> None:
        _check_options(None, self.layout, self.threshold)

    def run(self, mesh: Mesh, pinned: Pins | None, shape: Shape = FREE) -> Flattening:
        with stopwatch(*STAGES) as seconds:
            options = ProblemOptions(self.layout, self.threshold, self.solver, safeguard=False)
            problem = set_up_problem(mesh, options, pinned)
            return build_result(
                problem, self.name, run_stages(problem, [baselines.take_newton_step]), seconds
            )


@dataclass(frozen=True)
class LSCM(Method):
    """Least squares conformal maps by `igl.lscm`, with two distant boundary vertices as the default pins."""

    name = "lscm"
    label = "igl.lscm"

    def run(self, mesh: Mesh, pinned: Pins | None, shape: Shape = FREE) -> Flattening:
        return baselines.flatten_by_lscm(mesh, pinned)


@dataclass(frozen=True)
class SCP(Method):
    """The spectral conformal map without pins (Mullen et al. 2008), by `igl.spectra.lscm`."""

    name = "scp"
    label = "igl.spectra.lscm"

    def run(self, mesh: Mesh, pinned: Pins | None, shape: Shape = FREE) -> Flattening:
        return baselines.flatten_by_scp(mesh, pinned)


@dataclass(frozen=True)
class DNCP(Method):
    """Discrete natural conformal parameterization (Desbrun, Meyer, Alliez 2002).

    Attributes
    ----------
    solver : str
        As in `igl_linabf.linabf`.
    """

    name = "dncp"
    label = "DNCP"

    solver: SolverName = "auto"

    def run(self, mesh: Mesh, pinned: Pins | None, shape: Shape = FREE) -> Flattening:
        return baselines.flatten_by_dncp(mesh, pinned, self.solver)


METHODS: dict[str, Callable[..., Method]] = {
    method.name: method for method in (LinABF, ABF, Isometric, OneStepABFpp, LSCM, SCP, DNCP)
}


class MethodOptions(TypedDict, total=False):
    """The options of all methods, for functions that accept them as keywords."""

    iterations: Iterations
    layout: LayoutName
    rtol: float | None
    tol: float
    threshold: float
    safeguard: bool
    guarantee: Guarantee | None
    weight: float
    solver: SolverName


def resolve_method(
    method: str | Method, options: MethodOptions | None = None, *, several: bool = False
) -> Method:
    """Return the given method, or the method of this name, with the given options.

    Options that are not given keep their values.
    """
    if isinstance(method, Method):
        return replace(method, **options) if options else method  # type: ignore[type-var]
    if not isinstance(method, str) or method not in METHODS:
        amount = "some" if several else "one"
        raise ValueError(f"method is {method!r}: use {amount} of {', '.join(map(repr, METHODS))}")
    return METHODS[method](**options or {})


def get_guaranteed_method(method: Method) -> Method | None:
    """Return the method with guarantee="injective"; None if it has this guarantee or cannot have it."""
    if not isinstance(method, LinABF | ABF) or method.guarantee is not None:
        return None
    return replace(method, guarantee="injective")


def _run_with_stages(
    method: LinABF | ABF,
    mesh: Mesh,
    pinned: Pins | None,
    shape: Shape,
    stages: list[Stage],
    safeguard: bool = True,
) -> Flattening:
    """Run the stages of a method on its initial problem."""
    if method.guarantee:
        stages = [*stages, make_injective_map]
    with stopwatch(*STAGES) as seconds:
        options = ProblemOptions(method.layout, method.threshold, method.solver, safeguard)
        problem = set_up_problem(mesh, options, pinned, shape)
        return build_result(problem, method.name, run_stages(problem, stages), seconds)


def _list_default_stages(rtol: float | None, tol: float) -> list[Stage]:
    """Return the default stages of linear ABF, in the order of increasing cost."""
    return [
        partial(solve_one_system, rtol=rtol, tol=tol),
        partial(continue_active_set, rtol=rtol, tol=tol),
        partial(run_anchored_abf, tol=ABF_TOL, residual_tol=tol, largest=LARGEST_FOR_ABF),
        partial(run_feasible_abf, tol=ABF_TOL, residual_tol=tol),
    ]


def _check_options(guarantee: str | None, layout: LayoutName, threshold: float) -> None:
    """Raise an error for an invalid option that several methods share."""
    check_method(layout)
    if guarantee not in (None, "injective"):
        raise ValueError(f"guarantee is {guarantee!r}: use 'injective' or None")
    if not is_number(threshold, 0):
        raise ValueError(f"threshold is {threshold!r}: use a number of radians, 0 or larger")
