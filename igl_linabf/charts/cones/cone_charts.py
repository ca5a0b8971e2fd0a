"""Charts of components with cones, cut along one seam whose two sides are equally long in the map."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from ..._runtime import advance, progress_part
from ..._types import FloatArray, IntArray
from ...angles import HolonomyAngles, SchurColumns
from ...errors import MeshError, SingularSystemError, some
from ...flattening import (
    DivergedError,
    Flattening,
    KnownLaplacian,
    Method,
    PrescribedHolonomy,
    flatten_with_cones,
    holonomy_angles_of,
)
from ...measures import overlapping_pairs_of_chart, quality_of
from ...surface import Submesh, check_finite, planar_mesh_of
from ..atlas import Chart, flattening_of_part, uv_of_part
from ..splitting import MAX_SPLITS, seams_of_overlaps
from .angle_sums import cone_angles_of
from .component import ConeComponent
from .constants import CONE_TRADE, LARGE_COMPONENT, LARGEST_RESIDUAL, QUARTER_TURN, THIN_SHARE
from .moves import ConeMoves
from .placement import find_on_component
from .quantisation import QuantisedCurvatures, quantise_holonomy
from .scale import ConeScale
from .seams import seam_through
from .surface_cones import SurfaceCones

NO_CONES = (np.zeros(0, dtype=np.int64), np.zeros(0))  # vertices and angles


@dataclass(frozen=True, eq=False)
class ComponentCones:
    """The cones on a component, and their angle sums.

    Attributes
    ----------
    component : ConeComponent
    vertices : (#C,) int64
        The component's own.
    sums : (#C,) float64
        Angle sums of the cones, radians.
    scale : ConeScale or None
        The conformal scale that the sums follow from; None if there are no cones, or the sums are given.
    quantised : QuantisedCurvatures or None
        The curvatures in quarter turns, if these may still go from cone to cone.
    columns : SchurColumns or None
        Those of the holonomy constraints along `component.paths`, once they are known.
    """

    component: ConeComponent
    vertices: IntArray
    sums: FloatArray
    scale: ConeScale | None
    quantised: QuantisedCurvatures | None
    columns: SchurColumns | None = None

    @property
    def all_sums(self) -> FloatArray:
        """The angle sums of the component's vertices; NaN at its boundary."""
        sums = np.where(self.component.submesh.topology.interior, 2 * np.pi, np.nan)
        sums[self.vertices] = self.sums
        return sums

    @property
    def known_laplacian(self) -> KnownLaplacian | None:
        """The factored Laplacian that gave the cones their angle sums."""
        if self.scale is None:
            return None
        ground, closed = self.scale.ground_cone, self.component.closed
        left_out = None if ground < 0 else int(self.component.vertices_of(np.array([ground]))[0])
        even = closed.graph.n >= LARGE_COMPONENT and closed.laplacian.thin_share <= THIN_SHARE
        return KnownLaplacian(self.scale.inner_factor, left_out, even, self.columns)


def place_cones(component: ConeComponent, wanted: SurfaceCones) -> ComponentCones:
    """The cones on a component: given ones, or found ones."""
    if wanted.vertices is None or isinstance(wanted.vertices, int):
        own = find_on_component(component, wanted.vertices, CONE_TRADE)
        assert not isinstance(wanted.angles, np.ndarray)
        return _moved_to_holonomy(
            ComponentCones(component, own, *cone_angles_of(component, own, wanted.angles))
        )
    submesh = component.submesh
    here = np.flatnonzero(np.isin(wanted.vertices, submesh.vertices))
    own = np.searchsorted(submesh.vertices, wanted.vertices[here])
    angles = wanted.angles[here] if isinstance(wanted.angles, np.ndarray) else wanted.angles
    return ComponentCones(component, own, *cone_angles_of(component, own, angles))


def _moved_to_holonomy(found: ComponentCones) -> ComponentCones:
    """Cones in quarter turns moved to where holonomy angles are nearly quarter turns, if that pays."""
    component, quantised = found.component, found.quantised
    submesh, closed = component.submesh, component.closed
    if quantised is None or closed.laplacian.thin_share > THIN_SHARE or not component.paths:
        return found
    predicted = holonomy_angles_of(
        submesh.topology,
        np.arctan2(*submesh.measured),
        found.all_sums,
        component.paths,
        found.known_laplacian,
    )
    if predicted is None:
        return found
    holonomy, columns = predicted
    by_node = np.zeros((closed.graph.n, len(component.paths)))
    by_node[closed.graph.n_holes :] = holonomy.by_vertex[component.interior]
    moved = ConeMoves(component, quantised, replace(holonomy, by_vertex=by_node)).best()
    if moved is None:
        return replace(found, columns=columns)
    vertices, sums = component.vertices_of(moved.scale.nodes), 2 * np.pi - moved.k * QUARTER_TURN
    return ComponentCones(component, vertices, np.asarray(sums), moved.scale, None, columns)


@dataclass(frozen=True, eq=False)
class ConeCharts:
    """The charts of a surface with cones.

    Attributes
    ----------
    charts : list of (Chart, Submesh)
    cones : (#C,) int64
        Vertices of the surface.
    angles : (#C,) float64
        Their angle sums, radians.
    """

    charts: list[tuple[Chart, Submesh]]
    cones: IntArray
    angles: FloatArray


def charts_with_cones(
    surface: Submesh, wanted: SurfaceCones, method: Method, ends: tuple[float, float]
) -> ConeCharts:
    """Cut each component along a seam through its cones, and flatten it.

    `ends` are the fractions of the progress at which all cones are placed, and all components are flat.
    """
    components = surface.components()
    with progress_part("cones", ends[0]):
        placed = [place_cones(ConeComponent(component), wanted) for component in components]
    charts: list[tuple[Chart, Submesh]] = []
    done, vertices, angles = 0, [], []
    for submesh, cones in zip(components, placed, strict=True):
        done += len(submesh.F)
        with progress_part("charts", ends[0] + (ends[1] - ends[0]) * done / len(surface.F)):
            cut, flattening, sums = _flattened_along_seam(cones, isinstance(wanted.angles, str), method)
            charts += _without_overlaps(cut, flattening)
        vertices.append(submesh.vertices[cones.vertices])
        angles.append(sums)
    return ConeCharts(charts, np.concatenate(vertices), np.concatenate(angles))


def _flattened_along_seam(
    cones: ComponentCones, quarter: bool, method: Method
) -> tuple[Submesh, Flattening, FloatArray]:
    """The component cut along its seam, its map, and the angle sums of its cones in the map.

    With `quarter`, the map turns by multiples of 90 degrees along closed paths.
    """
    start, component = perf_counter(), cones.component
    submesh, closed = component.submesh, component.closed
    seam = seam_through(closed, closed.node[cones.vertices], component.handles)
    (cut,) = submesh.cut_at(submesh.cuttable_edges[seam])
    advance("seams", 0.2)
    mesh = replace(planar_mesh_of(cut), vertices=np.arange(len(cut.V)), n_given=len(cut.V))
    paths, sums = component.paths, cones.sums

    def prescribe(holonomy: HolonomyAngles) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        """Angle sums of the cones, holonomy angles of the paths, and the log scale at all vertices."""
        nonlocal sums
        if cones.quantised is None:
            turns = quantise_holonomy(holonomy.angle[None] / QUARTER_TURN, holonomy.cost)[0]
            return sums, turns * QUARTER_TURN, None
        k, turns = cones.quantised.for_holonomy(holonomy)
        curvature: FloatArray = np.asarray(k * QUARTER_TURN)
        sums = 2 * np.pi - curvature
        return sums, turns * QUARTER_TURN, cones.quantised.scale.log_scale_of(curvature)[closed.node]

    cutting = perf_counter() - start
    prescribed = PrescribedHolonomy(cones.vertices, prescribe) if quarter and paths else None
    try:
        made = flatten_with_cones(
            mesh, submesh.topology, cones.all_sums, paths, prescribed, method, cones.known_laplacian
        )
    except SingularSystemError as error:
        raise SingularSystemError(_no_map_message(cones, quarter, str(error))) from error
    except DivergedError as error:
        raise MeshError(_no_map_message(cones, quarter, str(error))) from error
    missing = max(made.after.vertex, made.after.wheel)
    if not made.outcome.good and missing > LARGEST_RESIDUAL and len(made.attempts) > 1:
        raise MeshError(_no_map_message(cones, quarter, f"the angle sums end {missing:.2g} away from them"))
    seconds = {"check": cutting, **made.seconds, "total": perf_counter() - start}
    return cut, replace(made, seconds=seconds), sums


def _no_map_message(cones: ComponentCones, quarter: bool, why: str) -> str:
    other = "leave out angles='quarter'" if quarter else "cut along seams instead"
    vertices = cones.component.submesh.vertices[cones.vertices]
    return (
        f"no map with the {len(vertices)} cones {some(vertices)} was found: give more cones, or {other} "
        f"({why})"
    )


def _without_overlaps(cut: Submesh, flattening: Flattening) -> list[tuple[Chart, Submesh]]:
    """Charts of one map, cut until none overlaps itself.

    No chart is flattened anew: both sides of each seam stay equally long.
    """
    check_finite(flattening.uv, cut.vertices, "uv")
    done: list[tuple[Chart, Submesh]] = []
    waiting = [(cut, flattening, 0)]
    while waiting:
        submesh, made, splits = waiting.pop()
        pairs = overlapping_pairs_of_chart(submesh.topology, made.uv)
        if len(pairs) and splits < MAX_SPLITS:
            parts = submesh.cut_along(seams_of_overlaps([submesh], submesh.faces[pairs]))
            if len(parts) > 1:
                for part in reversed(parts):
                    uv = uv_of_part(made.uv, submesh, part)
                    waiting.append((part, flattening_of_part(made, submesh, part, uv), splits + 1))
                continue
        quality = quality_of(submesh, made.uv, len(pairs))
        done.append((Chart(submesh.faces, made, quality, splits, len(pairs), 0.0), submesh))
    return done
