"""Flatten a scroll segment: triangulate its grid of points, compute a map, and sample it on a new grid."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from importlib.metadata import version
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import Progress, advance, progress_part, show_progress
from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError, OutcomeWarning, format_count, is_number, stack_level
from ..flattening import Method, flatten, resolve_method
from ..io import Segment, read_tifxyz
from ..measures import format_pair_count
from ..surface import Repair, Submesh, clean, complex_positions, parse_direction, real_coordinates
from .grids import check_scale, triangulate_grid
from .holes import fill_holes
from .report import FlatSegment, SegmentReport, measure_pieces
from .resampling import Sheet, compute_grid_positions, sample_sheets

AXIS = (0.0, 0.0, 1.0)  # axis of the scroll in its volume
BYTES_PER_POINT = 2200  # peak memory per point of a segment with a million points or more
PIECE_GAP = 2  # columns without points between neighbouring pieces
MAPPED_FRACTION = 0.9  # fraction of the progress bar when the maps are finished


def memory_needed(segment: Segment) -> int:
    """Estimate the bytes that `flatten_segment` takes for a segment.

    Parameters
    ----------
    segment : Segment

    Returns
    -------
    int

    Examples
    --------
    >>> from igl_linabf.scrolls import synthetic_segment
    >>> memory_needed(synthetic_segment(50, 100)) < 10_000_000
    True
    """
    return BYTES_PER_POINT * int(segment.valid.sum())


def flatten_segment(
    segment: Segment | str | os.PathLike[str],
    *,
    method: str | Method = "isometric",
    up: str | ArrayLike = "axis",
    pieces: int = 1,
    progress: Progress = None,
) -> FlatSegment:
    """Flatten a scroll segment, and sample it at equal distances in the map.

    Cells of the grid with four valid points are split along their shorter diagonal. Coincident neighbours
    are merged into one vertex. The map has the area of the surface, in voxels, and is not mirrored. Holes are
    not cut. Holes of up to 2,500 points are filled smoothly for the computation only.

    Parameters
    ----------
    segment : Segment or path
        A segment in memory, or the folder of a tifxyz segment.
    method : str or method object
        As in `igl_linabf.flatten`. "isometric" also preserves lengths; "linabf" preserves angles only, in a
        third of the time.
    up : {"axis", "rows"} or (3,) float
        The direction that points up in the flat segment, where the rows begin. "axis": the z axis of the
        volume, which is the axis of the scroll. "rows": the direction against the rows of the given grid.
        Three numbers are a direction in the volume.
    pieces : int
        Number of pieces of the surface that are flattened, largest first. They are placed side by side, in
        the order of the given columns.
    progress : callable or False, optional
        As in `igl_linabf.flatten`.

    Returns
    -------
    FlatSegment
        Its `segment` can be written by `igl_linabf.io.write_tifxyz`.

    Raises
    ------
    MeshError
        The segment is damaged, has no cell with four valid points, or its scale contradicts the distances of
        its points.
    ValueError
        The method, `up` or `pieces` is not allowed.
    MemoryLimitError
        The memory does not suffice.

    Warns
    -----
    OutcomeWarning
        The map has flipped or overlapping triangles.
    MeshWarning
        A channel of the segment does not have the size of the grid, and is left out.

    Examples
    --------
    >>> from igl_linabf.scrolls import synthetic_segment
    >>> flat = flatten_segment(synthetic_segment(60, 200))
    >>> flat.report.flips, flat.report.stretch_l2 < 1.02
    (0, True)
    """
    start, chosen = perf_counter(), resolve_method(method)
    upwards = _check_up_direction(up)
    if not is_number(pieces, 1, whole=True):
        raise ValueError(f"pieces is {pieces!r}: give the number of pieces to flatten, at least 1")
    given = segment if isinstance(segment, Segment) else read_tifxyz(segment)
    check_scale(given)
    with show_progress(progress):
        found, source = _find_pieces(given)
        left_out = tuple(len(piece.F) for piece in found[pieces:])
        taken = _sort_by_column(found[:pieces], source.origin, given.points.shape[1])
        del found
        with progress_part("flatten", MAPPED_FRACTION):
            maps = [_flatten_piece(piece, source.origin, given, chosen, upwards) for piece in taken]
        real = [_drop_fill(piece, uv, source.of_fill) for piece, uv in zip(taken, maps, strict=True)]
        del taken, maps
        distortion = measure_pieces(real)
        advance("measure", 0.5)
        sheets, uv, size = _place_maps(given, real, source.origin)
        flat = sample_sheets(given, sheets, size)
        origin = np.concatenate([sheet.origin for sheet in sheets])
        first = np.cumsum([0, *(len(sheet.origin) for sheet in sheets[:-1])])
        F = np.concatenate([sheet.F + n for sheet, n in zip(sheets, first, strict=True)])
    flat.meta["flattened_from"] = _describe_source(given, chosen.name)
    report = SegmentReport(
        method=chosen.name,
        faces=len(F),
        **distortion,
        left_out=left_out,
        repairs=source.repairs,
        seconds=perf_counter() - start,
    )
    _warn_if_bad(report)
    V = given.points.reshape(-1, 3)[origin]
    return FlatSegment(flat, V, F, uv, _index_points(given, origin, source.merged), report)


@dataclass(frozen=True, eq=False)
class _Source:
    """The origin of the repaired triangles of a segment; the mesh itself is not kept, to save memory.

    Attributes
    ----------
    origin : (#V,) int64
        The index of each vertex's point in the row-major list of grid points.
    merged : (#points,) int64
        The index of the point that each point is merged into; unmerged points have their own index.
    of_fill : (#F,) bool
        Mask of the triangles of filled holes.
    repairs : tuple of Repair
    """

    origin: IntArray
    merged: IntArray
    of_fill: BoolArray
    repairs: tuple[Repair, ...]


def _find_pieces(given: Segment) -> tuple[list[Submesh], _Source]:
    """Return the pieces of the surface with small holes filled, largest first, and their origin."""
    points, filled = fill_holes(given.points)
    F, of_fill = triangulate_grid(points, filled)
    if of_fill.all():
        raise MeshError("the segment has no cell with four valid points: there is no surface to flatten")
    mesh = clean(points.reshape(-1, 3), F)
    found = Submesh.from_arrays(mesh.V, mesh.F).split_components()
    found.sort(key=lambda piece: len(piece.F), reverse=True)
    return found, _Source(mesh.origin, mesh.merged, of_fill[mesh.faces], mesh.repairs)


def _drop_fill(piece: Submesh, uv: FloatArray, of_fill: BoolArray) -> tuple[Submesh, FloatArray]:
    """Return a piece and its map without the triangles of filled holes."""
    rows = np.flatnonzero(~of_fill[piece.faces])
    if len(rows) == len(piece.F):
        return piece, uv
    part = piece.select_faces(rows)
    return part, uv[np.searchsorted(piece.vertices, part.vertices)]


def _sort_by_column(pieces: list[Submesh], origin: IntArray, columns: int) -> list[Submesh]:
    """Return the pieces in the order of their mean columns."""
    return sorted(pieces, key=lambda piece: float((origin[piece.vertices] % columns).mean()))


def _check_up_direction(up: str | ArrayLike) -> FloatArray | None:
    """Return the direction that points up, or None for the rows of the grid."""
    if isinstance(up, str) and up in ("axis", "rows"):
        return parse_direction(AXIS, "up") if up == "axis" else None
    if isinstance(up, str):
        raise ValueError(f"up is {up!r}: use 'axis', 'rows' or a direction in the volume")
    return parse_direction(up, "up")


def _flatten_piece(
    piece: Submesh, origin: IntArray, given: Segment, method: Method, up: FloatArray | None
) -> FloatArray:
    """Return the map of a piece, (#V, 2), with v upwards."""
    uv = flatten(piece.V, piece.F, method=method, up=up).uv
    if up is not None:
        return uv
    row, column = np.divmod(origin[piece.vertices], given.points.shape[1])
    grid = column / given.scale[0] - 1j * row / given.scale[1]
    z = complex_positions(uv)
    turn = np.vdot(z - z.mean(), grid - grid.mean())
    return real_coordinates(z * (turn / abs(turn)))


def _index_points(given: Segment, origin: IntArray, merged: IntArray) -> IntArray:
    """Return the vertex of each point of the grid, (#rows, #columns), or -1."""
    vertex = np.full(given.points.shape[0] * given.points.shape[1], -1)
    vertex[origin[::-1]] = np.arange(len(origin))[::-1]
    return np.asarray(vertex[merged].reshape(given.points.shape[:2]))


def _place_maps(
    given: Segment, pieces: list[tuple[Submesh, FloatArray]], origin: IntArray
) -> tuple[list[Sheet], FloatArray, tuple[int, int]]:
    """Place the maps of pieces side by side in a grid; return sheets, map in voxels, and size of the grid."""
    placed = [compute_grid_positions(uv, given.scale) for _, uv in pieces]
    wide = [columns + PIECE_GAP for _, (columns, _) in placed]
    size = sum(wide) - PIECE_GAP, max(rows for _, (_, rows) in placed)
    sheets, before = [], 0
    for (piece, _), (cells, _), width in zip(pieces, placed, wide, strict=True):
        cells[:, 0] += before
        before += width
        sheets.append(Sheet(origin[piece.vertices], piece.F, cells))
    cells = np.concatenate([sheet.cells for sheet in sheets])
    return sheets, np.column_stack((cells[:, 0], size[1] - 1 - cells[:, 1])) / given.scale, size


def _describe_source(given: Segment, method: str) -> dict[str, Any]:
    """Return the meta data of a flat segment that describe its source."""
    return {
        "uuid": given.meta.get("uuid"),
        "path": None if given.path is None else str(given.path.resolve()),
        "method": method,
        "program": f"igl_linabf {version('igl-linabf')}",
    }


def _warn_if_bad(report: SegmentReport) -> None:
    if report.flips or report.overlaps:
        pairs = format_pair_count(report.overlaps)
        warnings.warn(
            f"the flat segment has {format_count(report.flips, 'flipped triangle')} and "
            f"{pairs} pair{'s' * (report.overlaps != 1)} of overlapping triangles, and shows only one of "
            "each pair: look at the segment there",
            OutcomeWarning,
            stacklevel=stack_level(),
        )
