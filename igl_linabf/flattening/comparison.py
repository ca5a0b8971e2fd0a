"""Compare methods on a mesh by distortion, flips, and time relative to igl.lscm."""

from __future__ import annotations

import statistics
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any

from numpy.typing import ArrayLike

from .._notebook import arrange_html_row, draw_map_as_svg, format_html_table
from .._runtime import advance, align_columns, progress_part
from .._types import FloatArray, IntArray
from ..errors import FallbackWarning, format_count, is_number, stack_level, takes_vertices_and_faces
from ..measures import Quality, format_pair_count, quality
from ..surface import planar_mesh, scatter_to_input
from . import other_programs
from .baselines import make_lscm_call
from .boundary_shapes import BoundaryName
from .functions import flatten
from .methods import Method, resolve_method
from .result import Flattening


@dataclass(frozen=True, eq=False)
class Entry:
    """The map of one method, its quality and its time.

    Attributes
    ----------
    uv : (#V, 2) float64
    quality : Quality
    seconds : float
        Median over the runs, including input checks.
    ratio : float
        `seconds` divided by the median time of `igl.lscm` itself, with given pins.
    iterations : int or None
        Number of linear solves; None if the method has none or does not report them.
    result : Flattening or None
        None for the map of another program.
    """

    uv: FloatArray
    quality: Quality
    seconds: float
    ratio: float
    iterations: int | None
    result: Flattening | None


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """A comparison of methods on a mesh; `print` shows it as a table.

    Attributes
    ----------
    entries : dict of str to Entry
        Entries by label.
    F : (#F, 3) int64
        The triangles.
    """

    entries: dict[str, Entry]
    F: IntArray

    @property
    def maps(self) -> dict[str, FloatArray]:
        """The maps by label, in the form that `plot_compare` expects."""
        return {label: entry.uv for label, entry in self.entries.items()}

    def __repr__(self) -> str:
        return f"<Comparison on {format_count(len(self.F), 'triangle')}: {', '.join(self.entries)}>"

    def __str__(self) -> str:
        return align_columns(self._make_table_rows())

    def _repr_html_(self) -> str:
        maps = [(label, draw_map_as_svg(uv, self.F)) for label, uv in self.maps.items()]
        return format_html_table(self._make_table_rows()) + arrange_html_row(maps)

    def _make_table_rows(self) -> list[tuple[str, ...]]:
        rows: list[tuple[str, ...]] = [
            ("", "F/3nt", "L2 stretch", "flips", "overlaps", "seconds", "/ igl.lscm", "iterations", "outcome")
        ]
        for label, entry in self.entries.items():
            rows.append(
                (
                    label,
                    f"{entry.quality.angle_distortion:.4g}",
                    f"{entry.quality.stretch_l2:.4g}",
                    str(entry.quality.flips),
                    format_pair_count(entry.quality.overlaps),
                    f"{entry.seconds:.3f}",
                    f"{entry.ratio:.2f}",
                    "" if entry.iterations is None else str(entry.iterations),
                    "" if entry.result is None else entry.result.outcome.value,
                )
            )
        return rows


@takes_vertices_and_faces
def compare(
    V: ArrayLike,
    F: ArrayLike,
    methods: Sequence[str | Method] = ("lscm", "linabf", "abf"),
    *,
    repeat: int = 3,
    others: bool = True,
    outer: int | None = None,
    boundary: BoundaryName | ArrayLike = "free",
    corners: ArrayLike | None = None,
) -> Comparison:
    """Flatten a disk, with or without holes, by several methods; compare their distortion and time.

    Parameters
    ----------
    V : (#V, 3) float
    F : (#F, 3) int
    methods : sequence of str or method object
        Methods, as in `flatten`.
    repeat : int
        Number of timed runs of each method, in turn, after one run that is not timed.
    others : bool
        Add ABF of Blender and LSCM of MeshLab if `bpy` and `pymeshlab` are installed.
    outer : int, optional
        As in `flatten`.
    boundary, corners : optional
        As in `flatten`, for methods that can shape the boundary; for other methods, it stays free.

    Returns
    -------
    Comparison

    Raises
    ------
    MeshError
        As in `flatten`.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> table = compare(V, F[1:], ("lscm", "linabf"), repeat=1, others=False)
    >>> list(table.entries), table.entries["linABF"].quality.flips
    (['igl.lscm', 'linABF'], 0)
    """
    listed = isinstance(methods, Iterable) and not isinstance(methods, str)
    chosen = [resolve_method(method, several=True) for method in methods] if listed else []
    if not chosen:
        raise ValueError(f"methods is {methods!r}: give a list of one or more methods, such as ['linabf']")
    if not is_number(repeat, 1, whole=True):
        raise ValueError(f"repeat is {repeat!r}: use a positive integer")
    shaped: dict[str, Any] = {"outer": outer, "boundary": boundary, "corners": corners}
    options = [shaped if method.shapes else {"outer": outer} for method in chosen]
    first = list[Flattening]()
    for i, (method, given) in enumerate(zip(chosen, options, strict=True), 1):
        with progress_part(method.name, i / len(chosen) / (1 + repeat)):
            first.append(flatten(V, F, method=method, **given))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the first runs have already issued all warnings
        mesh = planar_mesh(V, F, outer)
        calls: list[Callable[[], object]] = [make_lscm_call(mesh)]
        calls += [
            partial(flatten, V, F, method=method, progress=False, **given)
            for method, given in zip(chosen, options, strict=True)
        ]
        calls[0]()
        base, *seconds = measure_median_times(calls, repeat)
    entries = {}
    for method, result, taken in zip(chosen, first, seconds, strict=True):
        taken = base if method.name == "lscm" else taken
        measured = quality(V, F, result.uv)
        iterations = result.report.iterations if result.report.steps else None
        label = method.label if method.label not in entries else str(method)
        entries[label] = Entry(result.uv, measured, taken, taken / base, iterations, result)
    for name in other_programs.list_installed_programs() if others else ():
        try:
            uv, taken = other_programs.run_program(name, mesh.V, mesh.faces)
        except RuntimeError as error:
            warnings.warn(f"{error}: it is left out", FallbackWarning, stacklevel=stack_level())
            continue
        uv = scatter_to_input(uv, mesh.vertices, mesh.n_given)
        entries[name] = Entry(uv, quality(V, F, uv), taken, taken / base, None, None)
    return Comparison(entries, first[0].F)


def measure_median_times(
    calls: Sequence[Callable[[], object]], repeat: int, clock: Callable[[], float] = perf_counter
) -> list[float]:
    """Return the median time of each call in seconds. The calls run in turn, `repeat` times each."""
    seconds: list[list[float]] = [[] for _ in calls]
    for done in range(repeat):
        for call, taken in zip(calls, seconds, strict=True):
            start = clock()
            call()
            taken.append(clock() - start)
        advance("timing", 1 / (repeat - done))
    return [statistics.median(taken) for taken in seconds]
