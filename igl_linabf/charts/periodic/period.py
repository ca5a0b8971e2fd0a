"""Shift the seams of a map by whole periods of a texture, which then continues across the seams."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import shapely

from ..._types import FloatArray
from ...errors import MeshError, OutcomeWarning, first_few, stack_level
from ...measures import measure_quality
from ...surface import Submesh
from ..atlas import Atlas, Chart, find_seams_and_mismatch
from .shifted_maps import ShiftedMaps

MAX_PERIOD_HALVINGS = 8  # halve the period this many times in search of one that flips no triangles
MAX_ROOMS = 4  # maximum number of times charts are packed, each time with more room around them
GAP_ROUNDING = 1e-6  # tolerance for rounding errors of the gap between charts, relative to the gap


def shift_by_period(
    surface: Submesh, pack: Callable[[float], Atlas], pieces: list[Submesh], period: float, gap: float
) -> Atlas:
    """Return the atlas with seams shifted by whole periods and, if possible, charts at least `gap` apart.

    `pack(room)` packs the charts with the additional distance `room` around each chart. One period is usually
    enough room, because points of the map move less. `pieces` are the surfaces of the charts.

    Raises
    ------
    MeshError
        Triangles would flip. The message suggests a shorter period, if one is feasible.
    """
    for room in period * 2.0 ** np.arange(MAX_ROOMS):
        atlas = _shift_atlas(surface, pack(room), pieces, period)
        if not _are_near(atlas.TC, pieces, gap):
            return atlas
    said = "the period moves charts over or near to other charts: use a shorter period"
    warnings.warn(said, OutcomeWarning, stacklevel=stack_level())
    return atlas


def _are_near(TC: FloatArray, pieces: list[Submesh], gap: float) -> bool:
    """Return True if the boundaries of two charts are closer than `gap`."""
    maps = np.split(TC, np.cumsum([len(piece.V) for piece in pieces])[:-1])
    rims = [
        shapely.multilinestrings(shapely.linestrings(uv[piece.topology.boundary_edges]))
        for piece, uv in zip(pieces, maps, strict=True)
    ]
    nearer = gap * (1 - GAP_ROUNDING)
    one, other = shapely.STRtree(rims).query(rims, predicate="dwithin", distance=nearer)
    return bool((one != other).any())


def _shift_atlas(surface: Submesh, atlas: Atlas, pieces: list[Submesh], period: float) -> Atlas:
    """Return the atlas with seams shifted by whole periods. Charts may overlap each other."""
    if not len(atlas.seams):
        return replace(atlas, report=replace(atlas.report, period=period))
    shifted = ShiftedMaps.from_map(surface, atlas.TC, atlas.FTC)
    TC, charts = _shift_charts(shifted, atlas, pieces, period)
    if flips := _describe_new_flips(charts, atlas.charts):
        advice, shorter = "use other cones", period
        for _ in range(MAX_PERIOD_HALVINGS):
            shorter /= 2
            if not _describe_new_flips(_shift_charts(shifted, atlas, pieces, shorter)[1], atlas.charts):
                advice = f"use {shorter:.3g}, or other cones"
                break
        raise MeshError(f"{flips}, because cones are too close to each other for this period: {advice}")
    V = np.concatenate([piece.V for piece in pieces])
    whole = Submesh(V, atlas.FTC, surface.faces, atlas.origin, surface.n_given)
    mismatch = find_seams_and_mismatch(surface.topology, TC, atlas.FTC)[1]
    report = replace(atlas.report, period=period, seam_mismatch=mismatch)
    return replace(atlas, TC=TC, charts=charts, quality=measure_quality(whole, TC), report=report)


def _shift_charts(
    shifted: ShiftedMaps, atlas: Atlas, pieces: list[Submesh], period: float
) -> tuple[FloatArray, tuple[Chart, ...]]:
    """Return the texture coordinates after shifts by whole periods, and the charts with their new quality."""
    TC = shifted.shift_seams(period)
    parts = np.split(TC, np.cumsum([len(piece.V) for piece in pieces])[:-1])
    charts = []
    for chart, piece, uv in zip(atlas.charts, pieces, parts, strict=True):
        measured = measure_quality(piece, uv)
        charts.append(replace(chart, quality=measured, overlapping=measured.overlaps))
    return TC, tuple(charts)


def _describe_new_flips(moved: Sequence[Chart], charts: Sequence[Chart]) -> str:
    """Describe the first chart with more flipped triangles than before the shift; return "" if none has."""
    for i, (now, before) in enumerate(zip(moved, charts, strict=True)):
        if (flips := now.quality.flips - before.quality.flips) > 0:
            return f"{flips} triangles of chart {i} (faces {first_few(now.faces)}) would flip"
    return ""
