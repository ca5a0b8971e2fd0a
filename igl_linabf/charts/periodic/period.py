"""A map whose seams shift a periodic texture by whole periods, so that it goes on across them."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import shapely

from ..._types import FloatArray
from ...errors import MeshError, OutcomeWarning, some, stack_level
from ...measures import quality_of
from ...surface import Submesh
from ..atlas import Atlas, Chart, seams_and_mismatch
from . import constants
from .shifted_maps import Shifted


def with_period(
    surface: Submesh, pack: Callable[[float], Atlas], pieces: list[Submesh], period: float, gap: float
) -> Atlas:
    """The atlas with seams that shift by whole periods; its charts stay `gap` apart if they can.

    `pack(room)` packs the charts with that much more room around each: shifts mostly move them by less than a
    period. `pieces` are the charts' surfaces.

    Raises
    ------
    MeshError
        Triangles would flip; the message has a period that would do.
    """
    for room in period * 2.0 ** np.arange(constants.MAX_ROOMS):
        atlas = _shifted(surface, pack(room), pieces, period)
        if not _near(atlas.TC, pieces, gap):
            return atlas
    said = "parts of charts lie over others, or near to them, as the period moves them: use a shorter period"
    warnings.warn(said, OutcomeWarning, stacklevel=stack_level())
    return atlas


def _near(TC: FloatArray, pieces: list[Submesh], gap: float) -> bool:
    """Whether the boundaries of two charts are nearer than `gap`."""
    maps = np.split(TC, np.cumsum([len(piece.V) for piece in pieces])[:-1])
    rims = [
        shapely.multilinestrings(shapely.linestrings(uv[piece.topology.edges[piece.topology.sides[1] < 0]]))
        for piece, uv in zip(pieces, maps, strict=True)
    ]
    nearer = gap * (1 - constants.GAP_ROUNDING)
    one, other = shapely.STRtree(rims).query(rims, predicate="dwithin", distance=nearer)
    return bool((one != other).any())


def _shifted(surface: Submesh, atlas: Atlas, pieces: list[Submesh], period: float) -> Atlas:
    """The atlas with seams that shift by whole periods; charts may then lie over each other."""
    if not len(atlas.seams):
        return replace(atlas, period=period)
    shifted = Shifted.of(surface, atlas.TC, atlas.FTC)
    TC, charts = _moved(shifted, atlas, pieces, period)
    if flips := _new_flips(charts, atlas.charts):
        advice, shorter = "use other cones", period
        for _ in range(constants.MAX_PERIOD_HALVINGS):
            shorter /= 2
            if not _new_flips(_moved(shifted, atlas, pieces, shorter)[1], atlas.charts):
                advice = f"use {shorter:.3g}, or other cones"
                break
        raise MeshError(f"{flips}, as cones lie too near to each other for this period: {advice}")
    V = np.concatenate([piece.V for piece in pieces])
    whole = Submesh(V, atlas.FTC, surface.faces, atlas.origin, surface.n_given)
    mismatch = seams_and_mismatch(surface.topology, TC, atlas.FTC)[1]
    return replace(
        atlas, TC=TC, charts=charts, period=period, seam_mismatch=mismatch, quality=quality_of(whole, TC)
    )


def _moved(
    shifted: Shifted, atlas: Atlas, pieces: list[Submesh], period: float
) -> tuple[FloatArray, tuple[Chart, ...]]:
    """The texture coordinates for a period, and the charts with the quality that they then have."""
    TC = shifted.by(period)
    parts = np.split(TC, np.cumsum([len(piece.V) for piece in pieces])[:-1])
    charts = []
    for chart, piece, uv in zip(atlas.charts, pieces, parts, strict=True):
        measured = quality_of(piece, uv)
        charts.append(replace(chart, quality=measured, overlapping=measured.overlaps))
    return TC, tuple(charts)


def _new_flips(moved: Sequence[Chart], charts: Sequence[Chart]) -> str:
    """The first chart in which more triangles flip than before, in words; "" if there is none."""
    for i, (now, before) in enumerate(zip(moved, charts, strict=True)):
        if (flips := now.quality.flips - before.quality.flips) > 0:
            return f"{flips} triangles of chart {i} (faces {some(now.faces)}) would flip"
    return ""
