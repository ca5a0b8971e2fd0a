"""Cut components along a seam through cones, and flatten them so that both sides of each seam edge match."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import Literal

import numpy as np

from ..._runtime import advance, progress_part
from ..._types import FloatArray, IntArray
from ...angles import HolonomyAngles
from ...errors import MeshError, SingularSystemError, first_few
from ...flattening import (
    DivergedError,
    Flattening,
    KnownLaplacian,
    Method,
    PrescribedHolonomy,
    flatten_with_cones,
    report_overlaps,
)
from ...measures import find_overlapping_pairs_of_chart, measure_quality
from ...surface import Cleaned, Submesh, build_planar_mesh, check_finite
from ..atlas import Chart, restrict_flattening, restrict_uv
from ..constants import MAX_OVERLAP_ROUNDS
from ..splitting import find_overlap_seams
from .constants import CONES_PER_STRETCH, QUARTER_TURN
from .options import Cones
from .placement import ConeComponent, choose_cone_angles, find_cones_on_component
from .quantisation import QuantisedCurvatures, quantise_holonomy
from .scale import ConeScale
from .seams import find_seam

# From this number of nodes, linear ABF reuses the Laplacian factored to place cones.
MIN_KNOWN_FACTOR_NODES = 5_000
# Linear ABF reuses the Laplacian of the cones up to this share of negative cotangent weights.
MAX_KNOWN_FACTOR_THIN_SHARE = 0.15
MAX_ANGLE_RESIDUAL = 0.5  # cones with a larger error of the map's angle sums, radians, are infeasible

NO_CONES = (np.zeros(0, dtype=np.int64), np.zeros(0))  # vertices and angle sums of an empty set of cones


@dataclass(frozen=True, eq=False)
class SurfaceCones:
    """The cones that are requested on a surface.

    Attributes
    ----------
    vertices : (#C,) int64, int or None
        Vertices of the surface, or the number of cones to find on each component. None finds cones as long as
        they reduce the stretch enough.
    angles : (#C,) float64, "quarter" or None
        Angle sums, radians; "quarter" for multiples of 90 degrees; None for the angles at which the conformal
        map has the same scale at all cones.
    """

    vertices: IntArray | int | None
    angles: FloatArray | Literal["quarter"] | None

    @classmethod
    def from_options(cls, cones: Cones, surface: Submesh, cleaned: Cleaned) -> SurfaceCones:
        """Convert the requested cones to vertices of the repaired surface.

        Raises
        ------
        MeshError
            A cone is not a vertex of the surface, is on its boundary, or is given twice.
        """
        given, angles = np.asarray(cones.at), cones.angles
        if given.ndim == 0:
            return cls(None if cones.at == "auto" else int(given), None if angles is None else "quarter")
        given = given.astype(np.int64)
        outside = (given < 0) | (given >= len(cleaned.merged))
        if outside.any():
            raise MeshError(f"cones {first_few(given[outside])} are not within 0..{len(cleaned.merged) - 1}")
        cone, vertex = _find_vertices(given, surface, cleaned)
        if angles is None or isinstance(angles, str):
            return cls(vertex, None if angles is None else "quarter")
        return cls(vertex, np.asarray(angles, dtype=np.float64)[cone])

    def resolve_on_component(self, component: Submesh) -> ComponentCones:
        """Return the cones on a component; find cones if only their number was requested."""
        place = ConeComponent(component)
        if self.vertices is None or isinstance(self.vertices, int):
            own = find_cones_on_component(place, self.vertices, CONES_PER_STRETCH)
            assert not isinstance(self.angles, np.ndarray)
            return ComponentCones(place, own, *choose_cone_angles(place, own, self.angles))
        here = np.flatnonzero(np.isin(self.vertices, component.vertices))
        own = np.searchsorted(component.vertices, self.vertices[here])
        wanted = self.angles[here] if isinstance(self.angles, np.ndarray) else self.angles
        return ComponentCones(place, own, *choose_cone_angles(place, own, wanted))


@dataclass(frozen=True, eq=False)
class ComponentCones:
    """The cones on a component.

    Attributes
    ----------
    place : ConeComponent
    own : (#C,) int64
        The cones, as vertices of the component.
    sums : (#C,) float64
        The angle sums at the cones, radians.
    scale : ConeScale or None
        The scale that determines `sums`; None if angle sums were requested, or there are no cones.
    quarters : QuantisedCurvatures or None
        The curvatures of the cones if they are multiples of 90 degrees, otherwise None.
    """

    place: ConeComponent
    own: IntArray
    sums: FloatArray
    scale: ConeScale | None
    quarters: QuantisedCurvatures | None


def _list_angle_sums(chosen: ComponentCones) -> FloatArray:
    """Return the angle sum at each vertex of the component, radians; NaN at the boundary."""
    sums = np.where(chosen.place.component.topology.is_interior, 2 * np.pi, np.nan)
    sums[chosen.own] = chosen.sums
    return sums


def _find_vertices(given: IntArray, surface: Submesh, cleaned: Cleaned) -> tuple[IntArray, IntArray]:
    """Return the cones that are on the repaired surface: indices into `given`, and surface vertices."""
    own = cleaned.merged[cleaned.origin]  # input vertex of each vertex of the surface
    order = np.argsort(own, kind="stable")
    wanted = cleaned.merged[given]
    first, end = (np.searchsorted(own[order], wanted, side) for side in ("left", "right"))
    if (first == end).any():
        raise MeshError(
            f"cones {first_few(given[first == end])} belong to no face: give vertices of the surface"
        )
    cone = np.repeat(np.arange(len(given)), end - first)
    at = np.concatenate(
        [order[a:b] for a, b in zip(first.tolist(), end.tolist(), strict=True)] or [order[:0]]
    )
    if len(np.unique(at)) < len(at):
        number = np.bincount(at)
        raise MeshError(
            f"cones {first_few(given[cone[number[at] > 1]])} are the same vertices: give each once"
        )
    rim = ~surface.topology.is_interior[at]
    if rim.any():
        raise MeshError(
            f"cones {first_few(given[cone[rim]])} are on the boundary, whose angles are free: "
            "give interior vertices"
        )
    return cone, surface.vertices[at]


@dataclass(frozen=True, eq=False)
class ConeCharts:
    """The charts of a surface with cones.

    Attributes
    ----------
    charts : list of (Chart, Submesh)
    cones : (#C,) int64
        The cones, as vertices of the surface.
    angles : (#C,) float64
        The angle sums at the cones, radians.
    """

    charts: list[tuple[Chart, Submesh]]
    cones: IntArray
    angles: FloatArray


def make_charts_with_cones(
    surface: Submesh, cones: SurfaceCones, method: Method, ends: tuple[float, float]
) -> ConeCharts:
    """Cut each component along a seam through its cones, and flatten the component.

    `ends` has the progress, from 0 to 1, after all cones are placed and after all charts are flat.
    """
    components = surface.split_components()
    with progress_part("cones", ends[0]):
        placed = [cones.resolve_on_component(component) for component in components]
    charts: list[tuple[Chart, Submesh]] = []
    reached = 0
    names, angles = [], []
    for component, chosen in zip(components, placed, strict=True):
        reached += len(component.F)
        with progress_part("charts", ends[0] + (ends[1] - ends[0]) * reached / len(surface.F)):
            cut, result, sums = _flatten_component(chosen, isinstance(cones.angles, str), method)
            charts += _split_overlaps(cut, result)
        names.append(component.vertices[chosen.own])
        angles.append(sums)
    return ConeCharts(charts, np.concatenate(names), np.concatenate(angles))


def _flatten_component(
    chosen: ComponentCones, quarter: bool, method: Method
) -> tuple[Submesh, Flattening, FloatArray]:
    """Return the component cut along its seam, its map, and the angle sums of the cones in the map."""
    start, place = perf_counter(), chosen.place
    component, piece = place.component, place.closed_surface
    seam = find_seam(piece, piece.node[chosen.own], place.handle_cut_graph)
    (cut,) = component.cut_at_edges(component.cuttable_edges[seam])
    advance("seams", 0.2)
    mesh = replace(build_planar_mesh(cut), vertices=np.arange(len(cut.V)), n_given=len(cut.V))
    paths, angles = place.closed_paths, chosen.sums

    def choose_quarter_angles(holonomy: HolonomyAngles) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        nonlocal angles
        if chosen.quarters is None:
            whole = quantise_holonomy(holonomy.angle[None] / QUARTER_TURN, holonomy.cost)[0]
            return angles, whole * QUARTER_TURN, None
        k, whole = chosen.quarters.fit_path_turns(holonomy)
        curvature: FloatArray = np.asarray(k * QUARTER_TURN)
        angles = 2 * np.pi - curvature
        return angles, whole * QUARTER_TURN, chosen.quarters.scale.compute_log_scale(curvature)[piece.node]

    checked = perf_counter() - start
    prescribed = PrescribedHolonomy(chosen.own, choose_quarter_angles) if quarter and paths else None
    try:
        made = flatten_with_cones(
            mesh,
            component.topology,
            _list_angle_sums(chosen),
            paths,
            prescribed,
            method,
            _reuse_laplacian(chosen),
        )
    except SingularSystemError as error:
        raise SingularSystemError(_describe_failure(chosen, quarter, str(error))) from error
    except DivergedError as error:
        raise MeshError(_describe_failure(chosen, quarter, str(error))) from error
    missing = max(made.after.vertex, made.after.wheel)
    if not made.outcome.good and missing > MAX_ANGLE_RESIDUAL and len(made.report.attempts) > 1:
        raise MeshError(
            _describe_failure(chosen, quarter, f"the angle sums end {missing:.2g} away from them")
        )
    seconds = {"check": checked, **made.seconds, "total": perf_counter() - start}
    return cut, replace(made, seconds=seconds), angles


def _describe_failure(chosen: ComponentCones, quarter: bool, why: str) -> str:
    """Return the error message for a component on which no map with the requested cones was found."""
    other = "leave out angles='quarter'" if quarter else "cut along seams instead"
    return (
        f"no map with the {len(chosen.own)} cones {first_few(chosen.place.component.vertices[chosen.own])} "
        f"was found: give more cones, or {other} ({why})"
    )


def _reuse_laplacian(chosen: ComponentCones) -> KnownLaplacian | None:
    """Return the Laplacian that determined the cone angles, which linear ABF can reuse; None without one."""
    if chosen.scale is None:
        return None
    first = chosen.scale.first
    left_out = None if first < 0 else int(chosen.place.convert_to_vertices(np.array([first]))[0])
    piece = chosen.place.closed_surface
    large = piece.graph.n >= MIN_KNOWN_FACTOR_NODES
    even = large and piece.laplacian.thin_bond_share <= MAX_KNOWN_FACTOR_THIN_SHARE
    return KnownLaplacian(chosen.scale.ground_free_factor, left_out, even)


def _split_overlaps(cut: Submesh, result: Flattening) -> list[tuple[Chart, Submesh]]:
    """Split an overlapping map into charts without overlaps; no chart moves, so that seams still match."""
    check_finite(result.uv, cut.vertices, "uv")
    done: list[tuple[Chart, Submesh]] = []
    waiting = [(cut, result, 0)]
    while waiting:
        piece, made, splits = waiting.pop()
        pairs = find_overlapping_pairs_of_chart(piece.topology, made.uv)
        if len(pairs) and splits < MAX_OVERLAP_ROUNDS:
            parts = piece.cut_along(find_overlap_seams([piece], piece.faces[pairs]))
            if len(parts) > 1:
                waiting += [
                    (
                        part,
                        restrict_flattening(made, piece, part, restrict_uv(made.uv, piece, part)),
                        splits + 1,
                    )
                    for part in reversed(parts)
                ]
                continue
        quality = measure_quality(piece, made.uv, len(pairs))
        chart = Chart(
            piece.faces, report_overlaps(made, piece.faces[pairs]), quality, splits, len(pairs), 0.0
        )
        done.append((chart, piece))
    return done
