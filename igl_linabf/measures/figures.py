"""Quality figures of whole flat maps: angles, stretch, areas, flips and overlaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np
from numpy.typing import ArrayLike

from .._notebook import format_html_table
from .._runtime import align_columns
from .._types import FloatArray
from ..errors import format_count, takes_vertices_and_faces
from ..surface import Ragged, Submesh, scale_to_unit_size
from .distances import Distances, check_rings
from .overlapping import find_overlapping_pairs, format_pair_count
from .per_triangle import Change, measure_change


@dataclass(frozen=True)
class QualityReport:
    """Quality figures of a flat map that complement those of `Quality`.

    Attributes
    ----------
    angle_error : float
        Mean of (angle in uv - angle in 3-D)^2, in squared radians.
    conformal_distortion_max : float
        The largest sigma1 / sigma2.
    edge_change_99 : float
        The 99th percentile of `|length in uv / length in 3-D - 1|` over the triangles' sides; 0 is best.
    faces : int
        Number of triangles.
    """

    angle_error: float
    conformal_distortion_max: float
    edge_change_99: float
    faces: int


@dataclass(frozen=True, repr=False)
class Quality:
    """The distortion of a whole flat map; `print` shows it as a table.

    Attributes
    ----------
    angle_distortion : float
        F/3nt of the paper: mean over corners of ((angle in uv - angle in 3-D) / angle in 3-D)^2.
    conformal_distortion : float
        Quasi-conformal distortion sigma1 / sigma2, mean weighted by area in 3-D; 1 is best.
        Infinite if a triangle has collapsed.
    area_distortion : float
        Area-weighted mean of `|log(area in uv / area in 3-D)|`, with both total areas scaled to 1;
        0 is best. Infinite if a triangle has collapsed.
    stretch_l2, stretch_linf : float
        Root mean square and largest stretch of Sander et al. 2001, normalised by area; 1 is best.
        Infinite if a triangle has collapsed.
    symmetric_dirichlet : float
        Area-weighted mean of (s1^2 + s2^2 + s1^-2 + s2^-2) / 4, where s1 and s2 are the singular values,
        with both total areas scaled to 1; 1 is best. Infinite if a triangle has collapsed.
    edge_change : float
        Mean, over the triangles' sides, of `|length in uv / length in 3-D - 1|`, with both total areas scaled
        to 1; 0 is best.
    texel_spread : float
        Ratio of the 99th to the 1st percentile, over the surface area, of area in uv / area in 3-D: how many
        times more texels one part gets than another; 1 is best. Infinite if 1 % of the surface has collapsed.
    flips : int
        Triangles whose area in uv is not positive: flipped (`igl.flipped_triangles`) or collapsed.
    overlaps : int
        Pairs of triangles of one chart that overlap (`igl_linabf.overlaps`). A chart with more than
        5,000,000 pairs counts as 5,000,001.
    report : QualityReport
        Error of angles, extremes of distortion, and the number of triangles.
    distance_error : float or None
        Mean relative error of distances (`measures.distance_error`), without rescaling the map; None unless
        `rings` is given.
    """

    angle_distortion: float
    conformal_distortion: float
    area_distortion: float
    stretch_l2: float
    stretch_linf: float
    symmetric_dirichlet: float
    edge_change: float
    texel_spread: float
    flips: int
    overlaps: int
    report: QualityReport
    distance_error: float | None = None

    def __repr__(self) -> str:
        figures = f"F/3nt {self.angle_distortion:.3g}, L2 stretch {self.stretch_l2:.4g}"
        return (
            f"<Quality of {format_count(self.report.faces, 'triangle')}: {figures}, {self.flips:,} flipped>"
        )

    def __str__(self) -> str:
        return format_table({"": self})

    def _repr_html_(self) -> str:
        return format_html_table(_make_rows({"": self}), header=False)


ROWS = {
    "report.faces": "triangles",
    "flips": "flipped triangles",
    "overlaps": "overlapping pairs",
    "angle_distortion": "angle distortion F/3nt",
    "report.angle_error": "mean squared angle error, rad^2",
    "conformal_distortion": "conformal distortion, mean",
    "report.conformal_distortion_max": "conformal distortion, largest",
    "area_distortion": "area distortion",
    "stretch_l2": "stretch, L2",
    "stretch_linf": "stretch, largest",
    "symmetric_dirichlet": "symmetric Dirichlet energy",
    "edge_change": "change of edge lengths, mean",
    "report.edge_change_99": "change of edge lengths, 99 %",
    "texel_spread": "texel areas, 99 % : 1 %",
    "distance_error": "distance error",
}


def format_table(columns: Mapping[str, Quality], extra: Mapping[str, Mapping[str, str]] | None = None) -> str:
    """Format the qualities of several maps as a text table with one column per map.

    Parameters
    ----------
    columns : mapping of name to Quality
    extra : mapping of label to mapping of name to text, optional
        Additional rows at the bottom.
    """
    cells = [["", *columns]] * any(columns) + _make_rows(columns)
    for label, texts in (extra or {}).items():
        cells.append([label, *(texts.get(name, "") for name in columns)])
    return align_columns(cells)


def _make_rows(columns: Mapping[str, Quality]) -> list[list[str]]:
    """Return a row for each figure: its label and its value in each column."""
    cells = []
    for name, label in ROWS.items():
        values = list(map(attrgetter(name), columns.values()))
        if any(v is not None for v in values):
            cells.append([label, *(_format_value(name, value) for value in values)])
    return cells


def _format_value(name: str, value: float | None) -> str:
    if value is None:
        return ""
    if isinstance(value, int):
        return format_pair_count(value) if name == "overlaps" else f"{value:,d}"
    return f"{value:.4g}"


@takes_vertices_and_faces
def quality(V: ArrayLike, F: ArrayLike, uv: ArrayLike, rings: int | None = None) -> Quality:
    """Measure the distortion of a flat map.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Triangles of any number of components, loops and handles.
    uv : (#V, 2) float
        The map, at any scale; NaN is allowed at vertices that no face uses.
    rings : int, optional
        Also compute `distance_error` with this number of rings, which takes a second or more.

    Returns
    -------
    Quality

    Raises
    ------
    MeshError
        The arrays do not fit together, `V` or `uv` is not finite, or a face has no area in 3-D.
    ValueError
        `rings` is not a positive integer.

    Examples
    --------
    >>> import numpy as np
    >>> V, F = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])
    >>> stretched = quality(V, F, [[0, 0], [1, 0], [0, 1]])
    >>> stretched.conformal_distortion, round(stretched.stretch_l2, 4), stretched.flips
    (2.0, 1.118, 0)
    """
    if rings is not None:
        check_rings(rings)
    surface = Submesh.from_input(V, F)
    map_ = surface.check_map(uv)
    measured = measure_quality(surface, map_)
    if rings is None:
        return measured
    error = Distances.measure_within_rings(surface.as_manifold(), rings).compute_mean_error(map_)
    return replace(measured, distance_error=error)


def measure_quality(
    surface: Submesh, map_: FloatArray, overlaps: int | None = None, changed: Change | None = None
) -> Quality:
    """Measure the `quality` of a checked map of a checked surface.

    The number of overlapping pairs and the change of the triangles are computed unless they are given.
    """
    count = len(find_overlapping_pairs(map_, surface.F)) if overlaps is None else overlaps
    known = measure_change(surface, map_) if changed is None else changed
    return _combine_changes(known, Ragged.from_sizes([len(surface.F)]), [count])[0]


def measure_qualities(charts: Sequence[tuple[Submesh, FloatArray, int]]) -> list[Quality]:
    """Return the quality of each chart, given as a surface, its map, and its number of overlapping pairs."""
    if not charts:
        return []
    surfaces, maps, overlaps = zip(*charts, strict=True)
    vertices = Ragged.from_sizes([len(surface.V) for surface in surfaces])
    faces = Ragged.from_sizes([len(surface.F) for surface in surfaces])
    surface = surfaces[0] if len(surfaces) == 1 else _concatenate_surfaces(surfaces, vertices, faces)
    changed = measure_change(surface, np.concatenate([*map(scale_to_unit_size, maps)]), faces)
    return _combine_changes(changed, faces, overlaps)


def _combine_changes(changed: Change, faces: Ragged, overlaps: Sequence[int]) -> list[Quality]:
    """Compute the quality of each chart from the changes of its faces and its number of `overlaps`."""
    area, conformal = changed.double_area, changed.conformal
    with np.errstate(invalid="ignore"):
        weighted = area * (
            conformal,
            np.abs(changed.log_area_ratio),
            changed.squared_stretch,
            changed.symmetric_dirichlet,
        )
        conformal_mean, area_distortion, squared_stretch, dirichlet = faces.sum(weighted) / faces.sum(area)
        figures = (
            faces.sum(changed.angle_distortion.mean(axis=0)) / faces.sizes,
            conformal_mean,
            area_distortion,
            np.sqrt(squared_stretch),
            faces.max(changed.largest_stretch),
            dirichlet,
            faces.sum(changed.edge_change.mean(axis=0)) / faces.sizes,
            _measure_texel_spread(changed, faces),
        )
        further = (
            faces.sum((changed.angle_error**2).mean(axis=0)) / faces.sizes,
            faces.max(conformal),
            _compute_percentile_99(changed.edge_change, faces),
        )
    flips = faces.sum(changed.is_flipped.astype(np.int64)).tolist()
    reports = map(QualityReport, *np.stack(further).tolist(), faces.sizes.tolist())
    return list(map(Quality, *np.stack(figures).tolist(), flips, overlaps, reports))


def _measure_texel_spread(changed: Change, faces: Ragged) -> FloatArray:
    """Return, for each chart, the area-weighted 99th percentile of the area ratio over the 1st percentile."""
    area, log_ratio = changed.double_area, changed.log_area_ratio
    # sorting each chart separately is faster than sorting all faces by chart and ratio
    order = np.concatenate(list(map(np.argsort, faces.split(log_ratio)))) + faces.repeat(faces.start[:-1])
    below = faces.cumsum(area[order]) / faces.repeat(faces.sum(area))
    counts = faces.sum(np.stack((below < 0.99, below < 0.01)).astype(np.int64))
    index = np.minimum(faces.start[:-1] + counts, faces.start[1:] - 1)
    most, least = log_ratio[order[index]]
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(least), np.exp(most - least), np.inf)


def _compute_percentile_99(sides: FloatArray, faces: Ragged) -> FloatArray:
    """Compute, for each chart, the 99th percentile of values at the sides of its faces, (3, #F)."""
    last = 3 * faces.sizes - 1
    place = 0.99 * last
    low = np.floor(place).astype(np.int64)
    ends = np.stack((low, np.minimum(low + 1, last)), axis=1)
    values = np.empty(ends.shape)
    for k, chart in enumerate(np.split(sides.T, faces.start[1:-1])):
        values[k] = np.partition(chart, ends[k], axis=None)[ends[k]]  # much faster than np.percentile
    below, above = values.T
    with np.errstate(invalid="ignore"):
        between = (place - low) * (above - below)
    return np.where(np.isinf(below), np.inf, below + between)


def _concatenate_surfaces(surfaces: Sequence[Submesh], vertices: Ragged, faces: Ragged) -> Submesh:
    """Concatenate surfaces."""
    F = np.concatenate([surface.F for surface in surfaces]) + faces.repeat(vertices.start[:-1])[:, None]
    V = np.concatenate([surface.V for surface in surfaces])
    return Submesh(V, F, np.arange(len(F)), np.arange(len(V)), len(V))
