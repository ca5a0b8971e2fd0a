"""The map of a chart that is split, kept on its largest part.

A part of a map has no flips that the map has not, and no overlaps that the split has parted. So only the
small parts are flattened again: a split costs little, and the largest part cannot overlap itself anew.
"""

from dataclasses import replace

import numpy as np

from .._types import IntArray
from ..flattening import Flattening
from ..measures import Quality, quality_of
from ..surface import Submesh
from .pieces import cut_out, of_own_size, on_part

KEPT = 0.9  # share of its faces from which on a part keeps the map: a smaller one gains by a new one
EVEN = 1.3  # L2 stretch up to which it does: of more, a new map has less, and fewer overlaps

Known = tuple[Flattening, IntArray, Quality]  # a map, its pairs of overlapping faces, its figures


def kept_maps(
    piece: Submesh, result: Flattening, parts: list[Submesh], pairs: IntArray
) -> list[Known | None]:
    """The map of the part that keeps it; None for the others. `pairs` of faces overlap in the map."""
    kept: list[Known | None] = [None] * len(parts)
    largest = int(np.argmax([len(part.F) for part in parts]))
    inside = np.zeros(len(piece.F), dtype=bool)
    inside[np.searchsorted(piece.faces, parts[largest].faces)] = True
    apart = not (inside[pairs[:, 0]] & inside[pairs[:, 1]]).any()
    if apart and len(parts[largest].F) >= KEPT * len(piece.F) and result.outcome.good:
        made = _on_part(piece, result, parts[largest])
        kept[largest] = made if made[2].stretch_l2 <= EVEN else None
    return kept


def _on_part(piece: Submesh, result: Flattening, part: Submesh) -> Known:
    uv = of_own_size(on_part(result.uv, piece, part), part)
    made = cut_out(result, piece, part, uv)
    message = f"{result.message}; a part of this map, {len(piece.F) - len(part.F):,} faces were cut off"
    return replace(made, message=message), np.zeros((0, 2), dtype=np.int64), quality_of(part, uv, overlaps=0)
