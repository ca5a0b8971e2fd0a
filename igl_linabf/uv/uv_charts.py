"""The charts of existing texture coordinates: connected, mirrored and stacked charts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core import common_areas, find_overlaps
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..errors import MeshError, first_few, format_count
from ..measures import MAX_PAIRS
from ..surface import (
    Polygons,
    Triangles,
    complex_positions,
    connected_labels,
    find_faces_without_area,
    has_distinct_corners,
    merge_coincident,
    orient_faces,
    scale_to_unit_size,
    signed_double_areas,
    vertex_array,
)

OF_SINGLE_PRECISION = 2.0**29  # ratio of rounding errors in single precision to those in double precision
LEAST_MIRRORED_SHARE = 0.25  # share of a UV island from which a reversed part is mirrored, not flipped
SAME_POINT_TOL = 1e-6  # points of a map within this distance are equal; relative to the largest coordinate
PAIRS_AT_ONCE = 200_000  # number of overlapping pairs of triangles in a batch, for large stacks of charts
MIN_STACKED_SHARE = 0.9  # charts are stacked if they share at least this part of the larger chart's area


@dataclass(frozen=True, eq=False)
class UVCharts:
    """Triangles of a surface, cut along the seams of its texture coordinates.

    Attributes
    ----------
    split : Triangles
        The triangles of the faces.
    rows : (#T,) int64
        Rows of the triangles with texture coordinates and an area in space.
    unmapped : (#U,) int64
        Faces with a corner without texture coordinates.
    V, uv : (#C, 3) and (#C, 2) float64
        Position and texture coordinates of each distinct corner.
    F : (#T, 3) int64
    rows_aside, F_aside : (#A,) and (#A, 3) int64
        Rows and corners of the triangles with texture coordinates but no area in space, or an area within
        single-precision rounding both in space and in the map.
    image : (#T,) int64
        The image of each triangle. Charts on different images do not overlap.
    images : array
        The label of each image.
    """

    split: Triangles
    rows: IntArray
    unmapped: IntArray
    V: FloatArray
    uv: FloatArray
    F: IntArray
    rows_aside: IntArray
    F_aside: IntArray
    image: IntArray
    images: NDArray[Any]

    @classmethod
    def from_arrays(
        cls, V: ArrayLike, F: ArrayLike, TC: ArrayLike, FTC: ArrayLike, labels: ArrayLike | None = None
    ) -> UVCharts:
        """Check the arrays, and merge equal corners; `labels` has the texture image of each face.

        Raises
        ------
        MeshError
            The arrays are malformed or do not match, or a coordinate at a face is NaN or infinite.
        """
        polygons = Polygons.from_faces(F)
        texture = polygons.parse_texture_indices(FTC)
        positions, points = vertex_array(V), vertex_array(TC, 2, "TC")
        polygons.check_vertices(len(positions))
        without = texture.corners < 0
        unmapped = np.unique(polygons.polygon_of_corner[without])
        bad = np.unique(polygons.polygon_of_corner[texture.corners >= len(points)])
        if len(bad):
            raise MeshError(
                f"faces {first_few(bad)} refer to texture coordinates outside 0..{len(points) - 1}: "
                "correct FTC or complete TC"
            )
        for array, used, name in (
            (positions, polygons.corners, "V"),
            (points, texture.corners[~without], "TC"),
        ):
            bad = np.unique(used[~np.isfinite(array[used]).all(axis=1)])
            if len(bad):
                raise MeshError(f"rows {first_few(bad)} of {name} are NaN or infinite: correct them")
        split = polygons.triangulate(positions)
        rows = np.flatnonzero(~np.isin(split.face, unmapped))
        at = split.place[rows]
        pair = np.concatenate((positions[polygons.corners[at]], points[texture.corners[at]]), axis=2).reshape(
            -1, 5
        )
        used, faces = _merge_equal_rows(pair)
        own, uv, faces = pair[used, :3], pair[used, 3:], faces.reshape(-1, 3)
        solid = np.ones(len(faces), dtype=bool)
        if len(faces):
            # also exclude faces that have no area in space and in the map up to errors of single precision,
            # because files may round coordinates
            in_space, in_map = own, np.pad(uv, ((0, 0), (0, 1)))
            thin, flat = (find_faces_without_area(x, faces, OF_SINGLE_PRECISION) for x in (in_space, in_map))
            solid[find_faces_without_area(own, faces)] = False
            solid[np.intersect1d(thin, flat)] = False
        images, image = np.unique(_check_labels(labels, len(polygons)), return_inverse=True)
        aside = rows[~solid], faces[~solid]
        rows = rows[solid]
        return cls(split, rows, unmapped, own, uv, faces[solid], *aside, image[split.face[rows]], images)

    @cached_property
    def _triangles_and_shared_sides(self) -> tuple[IntArray, IntArray]:
        """Triangles, including those without area in space, and pairs of their sides that share an edge.

        An edge is shared if its ends agree in space and in the map. Side 3 t + k begins at corner k.
        """
        F = np.concatenate((self.F, self.F_aside[has_distinct_corners(self.F_aside)]))
        tail, head = F.ravel(), F[:, [1, 2, 0]].ravel()
        key = np.minimum(tail, head) * len(self.V) + np.maximum(tail, head)
        order = np.argsort(key, kind="stable")
        same = np.flatnonzero(key[order[1:]] == key[order[:-1]])
        return F, np.column_stack((order[same], order[same + 1]))

    @cached_property
    def is_reversed(self) -> BoolArray:
        """Mask of the triangles whose orientation in space differs from most of the surface around them.

        The faces of a mesh may be oriented at random. Therefore, a triangle of the map is called flipped
        only if its orientation differs from that of its neighbours.
        """
        F, links = self._triangles_and_shared_sides
        number = np.bincount(links.ravel(), minlength=3 * len(F))
        of_two = (number[links] == 1).all(axis=1)  # ignore edges with more than two triangles
        return orient_faces(F, links[of_two])[0][: len(self.F)]

    @cached_property
    def double_area(self) -> FloatArray:
        """Twice the signed area of each triangle in the map, with all triangles oriented alike in space."""
        areas = signed_double_areas(complex_positions(self.uv), np.ascontiguousarray(self.F.T))
        return np.where(self.is_reversed, -areas, areas)

    @cached_property
    def area_in_space(self) -> FloatArray:
        """The area of each triangle in space."""
        a, b, c = self.V[self.F.T]
        return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)

    @cached_property
    def _adjacent_triangles(self) -> IntArray:
        """Pairs of triangles that share an edge in space, in the map and in the image.

        Two triangles also count as adjacent if only triangles without area in space, such as caps at
        T-junctions, separate them.
        """
        F, links = self._triangles_and_shared_sides
        n, pairs = len(self.F), np.sort(links // 3, axis=1)
        solid, between = pairs[pairs[:, 1] < n], pairs[pairs[:, 0] >= n]
        first, cap = pairs[(pairs[:, 0] < n) & (pairs[:, 1] >= n)].T
        group = connected_labels(between - n, len(F) - n)[cap - n]
        order = np.argsort(group, kind="stable")
        same = np.flatnonzero(group[order[1:]] == group[order[:-1]])
        pairs = np.concatenate((solid, np.column_stack((first[order[same]], first[order[same + 1]]))))
        return np.asarray(pairs[self.image[pairs[:, 0]] == self.image[pairs[:, 1]]])

    @cached_property
    def chart_of_triangle(self) -> IntArray:
        """The chart of each triangle.

        If the map folds over along edges, for example between two halves that share their texture, the parts
        on the two sides of the fold are different charts.
        """
        islands = _renumber(connected_labels(self._adjacent_triangles, len(self.F)))
        sign = self.double_area > 0
        one, other = self._adjacent_triangles.T
        parts = _renumber(connected_labels(self._adjacent_triangles[sign[one] == sign[other]], len(self.F)))
        share = (
            np.bincount(parts, self.area_in_space)
            / np.bincount(islands, self.area_in_space)[get_first_of_each_label(islands, parts)]
        )
        # large reversed parts are mirrored charts; the triangles of small reversed parts are flipped
        large = share >= LEAST_MIRRORED_SHARE
        joined = self._adjacent_triangles[
            (parts[one] == parts[other]) | ~(large[parts[one]] & large[parts[other]])
        ]
        return _renumber(connected_labels(joined, len(self.F)))

    @cached_property
    def n_charts(self) -> int:
        """The number of charts."""
        return int(self.chart_of_triangle.max(initial=-1)) + 1

    @cached_property
    def image_of_chart(self) -> IntArray:
        """The image of each chart."""
        return get_first_of_each_label(self.image, self.chart_of_triangle)

    @cached_property
    def bounding_boxes(self) -> tuple[FloatArray, FloatArray]:
        """The lower left and the upper right corner of the box around each chart, (#charts, 2) each."""
        low, high = np.full((2, self.n_charts, 2), np.inf) * np.array([1, -1])[:, None, None]
        for k in range(3):
            np.minimum.at(low, self.chart_of_triangle, self.uv[self.F[:, k]])
            np.maximum.at(high, self.chart_of_triangle, self.uv[self.F[:, k]])
        return low, high

    @cached_property
    def page_corners(self) -> FloatArray:
        """The lower left corner of the page of each chart, (#charts, 2)."""
        low, high = self.bounding_boxes
        return np.floor((low + high) / 2)

    @cached_property
    def sheet_of_chart(self) -> IntArray:
        """The sheet of each chart, which is a page of one image; sheets are sorted by image and page."""
        keys = np.column_stack((self.image_of_chart, self.page_corners[:, ::-1]))
        return np.unique(keys, axis=0, return_inverse=True)[1].ravel().astype(np.int64)

    @cached_property
    def is_mirrored(self) -> BoolArray:
        """Mask of the charts that are mirrored."""
        return np.asarray(np.bincount(self.chart_of_triangle, self.double_area, self.n_charts) < 0)

    @cached_property
    def is_flipped(self) -> BoolArray:
        """Mask of the triangles that are flipped within their chart, or have no area in the map."""
        return ~(np.where(self.is_mirrored[self.chart_of_triangle], -1, 1) * self.double_area > 0)

    @cached_property
    def upright_triangles(self) -> IntArray:
        """The triangles in counterclockwise order in the map, with mirrored charts reversed."""
        reverse = self.is_mirrored[self.chart_of_triangle] ^ self.is_reversed
        return np.where(reverse[:, None], self.F[:, ::-1], self.F)

    @cached_property
    def accidental_overlaps(self) -> tuple[IntArray, IntArray]:
        """Pairs of triangles (#P, 2) that overlap by accident, and the first chart stacked with each chart.

        Two charts are stacked if each covers most of the other. A chart that is not stacked is a stack by
        itself. Of charts with the same triangles, only the first chart is compared with other charts. If more
        than `MAX_PAIRS` pairs overlap, only the first chart of each stack is compared. The list of pairs is
        incomplete if it has more than `MAX_PAIRS` rows.
        """
        same = self._first_with_same_triangles
        firsts = np.flatnonzero(same == np.arange(self.n_charts))
        pairs, stack = self._find_accidental_overlaps(firsts, MAX_PAIRS)
        if len(pairs) > MAX_PAIRS:
            halves = self._stack_halves(firsts)
            kept = np.unique(halves)
            pairs, stack = self._find_accidental_overlaps(kept, MAX_PAIRS)
            stack = stack[np.searchsorted(kept, halves)]
        first = np.zeros(self.n_charts, dtype=np.int64)
        first[firsts] = stack
        return pairs, first[same]

    def _stack_halves(self, charts: IntArray) -> IntArray:
        """Return the first chart of each chart's stack.

        Split the charts into halves until each part has at most `PAIRS_AT_ONCE` overlapping pairs.
        """
        pairs, stack = self._find_accidental_overlaps(charts, PAIRS_AT_ONCE)
        if len(pairs) <= PAIRS_AT_ONCE or len(charts) < 2:
            return stack
        halves = np.concatenate([self._stack_halves(half) for half in np.array_split(charts, 2)])
        firsts = np.unique(halves)
        if len(firsts) == len(charts):
            return halves
        return self._find_accidental_overlaps(firsts, PAIRS_AT_ONCE)[1][np.searchsorted(firsts, halves)]

    def _find_accidental_overlaps(self, charts: IntArray, limit: int) -> tuple[IntArray, IntArray]:
        """Return the pairs of triangles that overlap by accident, and the first chart of each chart's stack.

        Only the given charts are compared. If there are more pairs than `limit`, the list is incomplete, and
        no charts are stacked.
        """
        z = self._scaled_map
        is_compared = np.zeros(self.n_charts, dtype=bool)
        is_compared[charts] = True
        rows = np.flatnonzero(is_compared[self.chart_of_triangle])
        pairs = rows[find_overlaps(z, self.upright_triangles[rows], self.image[rows], limit)]
        of = self.chart_of_triangle[pairs]
        between = np.flatnonzero(of[:, 0] != of[:, 1])
        if not len(between) or len(pairs) > limit:
            return pairs, charts
        ends = np.sort(of[between], axis=1)
        key, number = np.unique(ends[:, 0] * self.n_charts + ends[:, 1], return_inverse=True)
        one, other = np.divmod(key, self.n_charts)
        common = np.bincount(number, common_areas(z, self.upright_triangles, pairs[between]))
        on_purpose = common >= MIN_STACKED_SHARE * np.maximum(*self._scaled_area[[one, other]])
        kept = np.ones(len(pairs), dtype=bool)
        kept[between] = ~on_purpose[number]
        return pairs[kept], _stack_on_first(one[on_purpose], other[on_purpose], self.n_charts)[charts]

    @cached_property
    def _scaled_map(self) -> ComplexArray:
        """The map, scaled such that products of coordinates cannot overflow."""
        return complex_positions(scale_to_unit_size(self.uv))

    @cached_property
    def _scaled_area(self) -> FloatArray:
        """The area of each chart in the scaled map."""
        area = np.abs(signed_double_areas(self._scaled_map, np.ascontiguousarray(self.F.T))) / 2
        return np.asarray(np.bincount(self.chart_of_triangle, area, self.n_charts))

    @cached_property
    def _first_with_same_triangles(self) -> IntArray:
        """For each chart, the first chart with the same image and the same triangles in the map."""
        step = max(float(np.abs(self.uv).max(initial=0)), 1.0) * SAME_POINT_TOL
        place = _merge_equal_rows(np.round(self.uv / step))[1]
        kind = _merge_equal_rows(np.sort(place[self.F], axis=1).astype(np.float64))[1]
        order = np.lexsort((kind, self.chart_of_triangle))
        rows = np.split(
            kind[order], np.searchsorted(self.chart_of_triangle[order], np.arange(1, self.n_charts))
        )
        known: dict[tuple[int, bytes], int] = {}
        keys = zip(self.image_of_chart.tolist(), map(np.ndarray.tobytes, rows), strict=True)
        return np.array([known.setdefault(key, i) for i, key in enumerate(keys)], dtype=np.int64)

    def get_input_faces(self, triangles: IntArray | BoolArray) -> IntArray:
        """Return the caller's faces that contain the given triangles."""
        return np.unique(self.split.face[self.rows[triangles]])


def _check_labels(labels: ArrayLike | None, n: int) -> NDArray[Any]:
    """Return the labels of n faces as an array; by default, all labels are 0."""
    given = np.zeros(n, dtype=np.int64) if labels is None else np.asarray(labels)
    if given.shape != (n,):
        raise MeshError(
            f"labels have the shape {given.shape}: pass one for each of the {format_count(n, 'face')}"
        )
    return given


def _merge_equal_rows(points: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the rows of the distinct points, and the index of each point among them."""
    if not len(points):
        return np.zeros((2, 0), dtype=np.int64)[0], np.zeros(0, dtype=np.int64)
    used, number = np.unique(merge_coincident(points, np.arange(len(points))), return_inverse=True)
    return used, number


def _stack_on_first(one: IntArray, other: IntArray, number: int) -> IntArray:
    """Return the first chart of each chart's stack.

    The charts `one` and `other`, one < other, cover each other; the pairs are sorted. A chart is stacked on
    the earliest chart that it covers and that is not itself stacked.
    """
    stack = np.arange(number)
    starts = np.flatnonzero(np.diff(one, prepend=-1))
    for start, end in pairwise([*starts.tolist(), len(one)]):
        if stack[one[start]] == one[start]:
            above = other[start:end]
            stack[above[stack[above] == above]] = one[start]
    return stack


def _renumber(label: IntArray) -> IntArray:
    """Renumber labels as 0, 1, ... in order of first appearance."""
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[inverse.ravel()])


def get_first_of_each_label(values: IntArray, label: IntArray) -> IntArray:
    """Return the first value of each label 0, 1, ..."""
    return np.asarray(values[np.unique(label, return_index=True)[1]])
