"""Convert the atlas of a repaired mesh to an atlas of the original mesh."""

from dataclasses import replace

import numpy as np

from ..._types import BoolArray, IntArray
from ...measures import Quality, QualityReport
from ...surface import Cleaned, make_seam_mask, multiply_by_power_of_two
from .atlas import Atlas, AtlasReport

NO_QUALITY = Quality(  # quality of an empty mesh
    0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0, 0, QualityReport(0.0, 1.0, 0.0, 0)
)


def map_sides_to_cleaned(mask: BoolArray, cleaned: Cleaned) -> BoolArray:
    """Convert a mask, (#F, 3), of the sides k to k + 1 of the original faces to the repaired faces."""
    mask = mask[cleaned.faces]
    mask = np.where(cleaned.turned[:, None], mask[:, ::-1], mask)
    return make_seam_mask(mask, cleaned.F, len(cleaned.V))  # marks both sides of an edge that was welded


def convert_to_given_mesh(atlas: Atlas, cleaned: Cleaned, F: IntArray) -> Atlas:
    """Convert the atlas of the repaired mesh to an atlas of the original mesh.

    The result refers to the original vertices and has a row for each original face, in its orientation.
    """
    FTC, chart = np.full(F.shape, -1), np.full(len(F), -1)
    FTC[cleaned.faces] = np.where(cleaned.turned[:, None], atlas.FTC[:, [0, 2, 1]], atlas.FTC)
    chart[cleaned.faces] = atlas.chart
    FTC, chart = _fill_rows_of_removed_faces(FTC, chart, cleaned.merged[F])
    return replace(
        atlas,
        FTC=FTC,
        chart=chart,
        origin=cleaned.origin[atlas.origin],
        seams=cleaned.origin[atlas.seams],
        seam_length=multiply_by_power_of_two(atlas.seam_length, -cleaned.power),
        report=replace(
            atlas.report,
            given_seams=cleaned.origin[atlas.report.given_seams],
            scale=multiply_by_power_of_two(atlas.report.scale, cleaned.power),
            cones=cleaned.origin[atlas.report.cones],
            repairs=cleaned.repairs,
        ),
    )


def make_empty_atlas(cleaned: Cleaned, F: IntArray) -> Atlas:
    """Return the atlas of a mesh whose faces all have zero area: all corners are at one point."""
    return Atlas(
        TC=np.full((1, 2), 0.5),
        FTC=np.zeros(F.shape, dtype=np.int64),
        origin=F.ravel()[:1].astype(np.int64),
        chart=np.full(len(F), -1),
        page=np.zeros(0, dtype=np.int64),
        charts=(),
        seams=np.zeros((0, 2), dtype=np.int64),
        seam_length=0.0,
        fill=0.0,
        quality=NO_QUALITY,
        report=AtlasReport(repairs=cleaned.repairs),
    )


def _fill_rows_of_removed_faces(FTC: IntArray, chart: IntArray, F: IntArray) -> tuple[IntArray, IntArray]:
    """Return `FTC` and `chart` with filled rows for the faces without area, which the repair removed.

    In the texture, such a face collapses to an edge or a corner of a neighbour. On input, its row of `FTC` is
    -1. `F` has all original faces, with the same index for all vertices at the same position.
    """
    aside = np.flatnonzero(FTC[:, 0] < 0)
    while len(aside):
        known = np.flatnonzero(FTC[:, 0] >= 0)
        lender = _find_edge_neighbours(F, aside, known)
        found = lender >= 0
        if not found.any():
            lender = _find_vertex_neighbours(F, aside, known)
            found = lender >= 0
        if not found.any():  # a component without area: map it to any point
            FTC[aside], chart[aside] = FTC[known[0], 0], chart[known[0]]
            break
        for t, other in zip(aside[found].tolist(), lender[found].tolist(), strict=True):
            same = F[t][:, None] == F[other]
            at = np.where(same.any(axis=1), same.argmax(axis=1), -1)
            at[at < 0] = at[at >= 0][0]
            if len(set(at.tolist())) == 3:  # a duplicate of its neighbour: collapse it in the map
                at[2] = at[1]
            FTC[t], chart[t] = FTC[other][at], chart[other]
        aside = aside[~found]
    return FTC, chart


def _find_edge_neighbours(F: IntArray, aside: IntArray, known: IntArray) -> IntArray:
    """Return for each face in `aside` a face in `known` with a common edge, or -1."""
    n = int(F.max()) + 1
    side = np.stack((F, F[:, [1, 2, 0]]), axis=-1)
    key = side.min(axis=-1) * n + side.max(axis=-1)
    proper = side[aside, :, 0] != side[aside, :, 1]
    return _find_row_with_common_value(key[known], known, key[aside], proper)


def _find_vertex_neighbours(F: IntArray, aside: IntArray, known: IntArray) -> IntArray:
    """Return for each face in `aside` a face in `known` with a common vertex, or -1."""
    return _find_row_with_common_value(F[known], known, F[aside], np.ones((len(aside), 3), dtype=bool))


def _find_row_with_common_value(
    table: IntArray, rows: IntArray, wanted: IntArray, usable: BoolArray
) -> IntArray:
    """For each row of `wanted`, find a row k of `table` with a common value; return `rows[k]`, or -1.

    Only the values of `wanted` that are marked in `usable` are compared.
    """
    values, first = np.unique(table.ravel(), return_index=True)
    place = np.minimum(np.searchsorted(values, wanted), len(values) - 1)
    hit = (values[place] == wanted) & usable
    at = rows[first[place] // 3]
    return np.where(hit.any(axis=1), at[np.arange(len(at)), hit.argmax(axis=1)], -1)
