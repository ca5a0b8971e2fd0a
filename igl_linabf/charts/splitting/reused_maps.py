"""Maps that parts of a chart keep when it is split: its largest part, and all without stretch.

The part of a map has only flips of the map, and no overlaps that the cut separates. So the other parts alone
are flattened again: a cut costs little, and what keeps its map cannot overlap itself anew.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..._types import FloatArray, IntArray
from ...flattening import Flattening
from ...measures import Quality, change_of, quality_of_each
from ...surface import Ragged, Submesh, complex_positions, signed_double_areas
from ..atlas import NO_QUALITY, flattening_of_part, scaled_to_surface, uv_of_part
from . import constants


class KnownMap(NamedTuple):
    """A map, its pairs of overlapping faces, its figures, and whether no tip in it is worth a seam.

    A map that overlaps itself, and so is to be cut, may have no figures yet.
    """

    result: Flattening
    pairs: IntArray
    quality: Quality | None
    without_tips: bool = False


def reuse_maps(
    piece: Submesh, result: Flattening, parts: list[Submesh], pairs: IntArray, without_tips: bool
) -> list[KnownMap | None]:
    """The maps of the parts that keep theirs; None for the others. `pairs` of faces overlap in the map.

    A large part keeps pairs that are both in it, and the knowledge that no tip is worth a seam.
    """
    kept: list[KnownMap | None] = [None] * len(parts)
    if not result.outcome.good:
        return kept
    rows = [np.searchsorted(piece.faces, part.faces) for part in parts]
    of, size = np.empty(len(piece.F), dtype=np.int64), np.array([len(own) for own in rows])
    of[np.concatenate(rows)] = np.repeat(np.arange(len(parts)), size)
    low, high = _area_ratios(piece, result, np.concatenate(rows), Ragged.of_sizes(size))
    left = pairs[of[pairs[:, 0]] == of[pairs[:, 1]]]
    apart = np.ones(len(parts), dtype=bool)
    apart[of[left[:, 0]]] = False
    even = apart & (high <= constants.MAX_EXACT_DISTORTION**2 * low)
    asked = np.flatnonzero((size >= constants.MIN_PART_OF_MAP * len(piece.F)) | even).tolist()
    maps = [scaled_to_surface(uv_of_part(result.uv, piece, parts[k]), parts[k]) for k in asked]
    own = [np.searchsorted(rows[k], left[of[left[:, 0]] == k]) for k in asked]
    table = [(parts[k], uv, len(over)) for k, uv, over in zip(asked, maps, own, strict=True)]
    whole = iter(quality_of_each([entry for k, entry in zip(asked, table, strict=True) if even[k]]))
    measured = [next(whole) if even[k] else decisive(*entry) for k, entry in zip(asked, table, strict=True)]
    for k, uv, over, quality in zip(asked, maps, own, measured, strict=True):
        exact = max(quality.stretch_l2, quality.conformal_distortion) <= constants.MAX_EXACT_DISTORTION
        if exact or keeps_map(int(size[k]), len(piece.F), quality.stretch_l2):
            made = flattening_of_part(result, piece, parts[k], uv)
            cut_off = f"a part of this map, {len(piece.F) - len(parts[k].F):,} faces were cut off"
            made = replace(made, message=f"{result.message}; {cut_off}")
            kept[k] = KnownMap(made, over, quality, without_tips)
    return kept


def decisive(piece: Submesh, uv: FloatArray, overlaps: int) -> Quality:
    """The figures of a map that decide whether a part keeps it; all others are those of no faces."""
    changed = change_of(piece, uv)
    return replace(
        NO_QUALITY,
        stretch_l2=changed.mean(changed.squared_stretch) ** 0.5,
        conformal_distortion=changed.mean(changed.conformal),
        angle_distortion=float(changed.angle_distortion.mean()),
        overlaps=overlaps,
    )


def keeps_map(part: int, whole: int, stretch: float) -> bool:
    """Whether a part of so many faces keeps its part of a map, of this L2 stretch."""
    low = stretch <= constants.REUSED_STRETCH
    return part >= (constants.MIN_PART_OF_MAP if low else constants.MIN_PART_OF_STRETCHED_MAP) * whole


def _area_ratios(
    piece: Submesh, result: Flattening, faces: IntArray, parts: Ragged
) -> tuple[FloatArray, FloatArray]:
    """The least and the largest ratio of areas in the map and on the surface, of each part of the faces."""
    ratio = signed_double_areas(complex_positions(result.uv), piece.topology.corner) / piece.measured[0]
    return parts.min(ratio[faces]), parts.max(ratio[faces])
