"""Pack the charts of several atlases together, so that the surfaces share a texture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..._types import FloatArray, IntArray
from ...errors import MeshError
from ...surface import Ragged, complex_positions, real_coordinates
from ..atlas import Atlas
from ..cost import compute_page_cost
from .packing import PackingRequest, pack_maps
from .spacing import Packing


def pack_together(atlases: Sequence[Atlas], packing: Packing | None = None) -> list[Atlas]:
    """Pack the charts of several atlases onto common pages, at one scale for all surfaces.

    The meshes of a scene can then share a texture. A single atlas can be packed again for another resolution.

    Parameters
    ----------
    atlases : sequence of Atlas
        Atlases returned by `unwrap`.
    packing : Packing, optional
        Options of the common pages. The texel density applies to all surfaces.

    Returns
    -------
    list of Atlas
        The same atlases with new `TC`, `page`, `scale` and `fill`. The fill is the share of the common pages
        that the atlas covers. The page cost of each atlas is the cost of all common pages.

    Raises
    ------
    MeshError
        The charts do not fit on the pages at the texel density.
    ValueError
        `packing` is not a `Packing`.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> both = [igl_linabf.unwrap(W, F) for W in (2 * V, V)]
    >>> large, small = pack_together(both, igl_linabf.Packing(resolution=512))
    >>> round(large.report.scale / small.report.scale, 9), round(large.fill / small.fill, 6)
    (1.0, 4.0)
    """
    parted = [_extract_charts(atlas) for atlas in atlases]
    request = PackingRequest.for_maps_without_surface(packing)
    placed = pack_maps([chart for charts, _ in parted for chart in charts], request)
    if not placed:
        return list(atlases)
    last = max(p.page for p in placed) + 1
    page = compute_page_cost(sum(p.area for p in placed) / last)
    made, first = [], 0
    for atlas, (charts, rows) in zip(atlases, parted, strict=True):
        own = placed[first : first + len(charts)]
        first += len(charts)
        if not own:
            made.append(atlas)
            continue
        TC = atlas.TC.copy()
        TC[rows] = np.concatenate([p.uv for p in own])
        made.append(
            replace(
                atlas,
                TC=TC,
                page=np.array([p.page for p in own], dtype=np.int64),
                fill=sum(p.area for p in own) / last,
                cost=replace(atlas.cost, page=page),
                report=replace(atlas.report, scale=abs(own[0].ratio), aspect=request.spacing.aspect),
            )
        )
    return made


def _extract_charts(atlas: Atlas) -> tuple[list[tuple[FloatArray, IntArray]], IntArray]:
    """Return the charts of an atlas in the surface's units of length, and the rows of `TC` of each chart."""
    n = len(atlas.charts)
    if not n:
        return [], np.zeros(0, dtype=np.int64)
    if not atlas.report.scale > 0:
        raise MeshError("an atlas has no scale: pass atlases that unwrap returned")
    triangles = atlas.triangles
    chart = atlas.chart if atlas.report.split is None else atlas.chart[atlas.report.split.face]
    chart_of_row = np.full(len(atlas.TC), -1)
    chart_of_row[triangles] = chart[:, None]
    rows = np.argsort(chart_of_row, kind="stable")
    rows = rows[np.searchsorted(chart_of_row[rows], 0) :]
    vertices = Ragged(np.searchsorted(chart_of_row[rows], np.arange(n + 1)))
    local = np.zeros(len(atlas.TC), dtype=np.int64)
    local[rows] = np.arange(len(rows)) - vertices.repeat(vertices.start[:-1])
    order = np.argsort(chart, kind="stable")
    start = np.searchsorted(chart[order], np.arange(n + 1))
    z = complex_positions(atlas.flat[rows]) / atlas.report.scale
    z -= vertices.repeat(vertices.min(z.real) + 1j * vertices.min(z.imag))
    uv, F = real_coordinates(z), local[triangles[order]]
    bounds = vertices.start
    return [(uv[bounds[i] : bounds[i + 1]], F[start[i] : start[i + 1]]) for i in range(n)], rows
