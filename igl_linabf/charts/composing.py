"""The atlas of flattened charts."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np

from ..errors import FallbackWarning, stack_level
from ..measures import quality_of
from ..surface import Submesh
from .atlas import Atlas, Chart
from .given_seams import textured_seams
from .packing import Wish, pack_maps

MARGINS = 0.64  # share of the square that margins around all charts may take


def packed(surface: Submesh, done: list[tuple[Chart, Submesh]], wish: Wish) -> Atlas:
    """Pack the charts; each comes with its surface."""
    most = float(np.sqrt(MARGINS / len(done)))
    closer = wish.spacing.at_most(most)
    if closer != wish.spacing:
        what = f"a margin of {wish.spacing.gap:g} leaves no room for {len(done):,} charts: it is {most:.2g}"
        warnings.warn(what, FallbackWarning, stacklevel=stack_level())
        wish = replace(wish, spacing=closer)
    placed = pack_maps([(chart.result.uv, piece.F) for chart, piece in done], wish)
    pages = np.array([p.page for p in placed])
    FTC, label, base = np.empty_like(surface.F), np.empty(len(surface.F), dtype=np.int64), 0
    for i, (_, piece) in enumerate(done):
        rows = np.searchsorted(surface.faces, piece.faces)
        FTC[rows], label[rows] = piece.F + base, i
        base += len(piece.V)
    TC, origin = np.concatenate([p.uv for p in placed]), np.concatenate([piece.vertices for _, piece in done])
    V = np.concatenate([piece.V for _, piece in done])
    seams, mismatch = textured_seams(surface.topology, TC, FTC)
    return Atlas(
        TC=TC,
        FTC=FTC,
        origin=origin,
        chart=label,
        charts=tuple(chart for chart, _ in done),
        seams=surface.vertices[seams],
        seam_length=float(np.linalg.norm(surface.V[seams[:, 0]] - surface.V[seams[:, 1]], axis=1).sum()),
        seam_mismatch=mismatch,
        splits=len(done) - len(surface.components()),
        fill=sum(p.area for p in placed) / (int(pages.max()) + 1),
        page=pages,
        scale=abs(placed[0].ratio),
        quality=quality_of(Submesh(V, FTC, surface.faces, origin, surface.n_given), TC),
    )
