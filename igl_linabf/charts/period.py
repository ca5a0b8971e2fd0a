"""A map whose seams shift a periodic texture by whole periods, so that it goes on across them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .._types import FloatArray
from ..errors import MeshError, some
from ..measures import quality_of
from ..surface import Submesh
from .atlas import Atlas, Chart
from .given_seams import textured_seams
from .shifted import Shifted

MOST_HALVINGS = 8  # of a period that is too long


def with_period(surface: Submesh, atlas: Atlas, pieces: list[Submesh], period: float) -> Atlas:
    """The atlas with seams that shift by whole periods; `pieces` are the surfaces of its charts.

    Raises
    ------
    MeshError
        Triangles would flip; the message has a period that would do.
    """
    if not len(atlas.seams):
        return replace(atlas, period=period)
    shifted = Shifted.of(surface, atlas.TC, atlas.FTC)
    TC, charts = _moved(shifted, atlas, pieces, period)
    if flips := _new_flips(charts, atlas.charts):
        advice, shorter = "use other cones", period
        for _ in range(MOST_HALVINGS):
            shorter /= 2
            if not _new_flips(_moved(shifted, atlas, pieces, shorter)[1], atlas.charts):
                advice = f"use {shorter:.3g}, or other cones"
                break
        raise MeshError(f"{flips}, as cones lie too near to each other for this period: {advice}")
    V = np.concatenate([piece.V for piece in pieces])
    whole = Submesh(V, atlas.FTC, surface.faces, atlas.origin, surface.n_given)
    mismatch = textured_seams(surface.topology, TC, atlas.FTC)[1]
    return replace(
        atlas, TC=TC, charts=charts, period=period, seam_mismatch=mismatch, quality=quality_of(whole, TC)
    )


def _moved(
    shifted: Shifted, atlas: Atlas, pieces: list[Submesh], period: float
) -> tuple[FloatArray, tuple[Chart, ...]]:
    """The texture coordinates for a period, and the charts with what is then measured of them."""
    TC = shifted.by(period)
    parts = np.split(TC, np.cumsum([len(piece.V) for piece in pieces])[:-1])
    charts = []
    for chart, piece, uv in zip(atlas.charts, pieces, parts, strict=True):
        measured = quality_of(piece, uv)
        charts.append(replace(chart, quality=measured, overlapping=measured.overlaps))
    return TC, tuple(charts)


def _new_flips(moved: Sequence[Chart], charts: Sequence[Chart]) -> str:
    """In which chart triangles flip that did not before; "" if in none."""
    for i, (now, before) in enumerate(zip(moved, charts, strict=True)):
        if (flips := now.quality.flips - before.quality.flips) > 0:
            return f"{flips} triangles of chart {i} (faces {some(now.faces)}) would flip"
    return ""
