"""Find the fold lines of a pattern, and whether they are mountain or valley folds."""

from __future__ import annotations

import numpy as np

from .._types import FloatArray, IntArray
from ..surface import NEXT, normalize_vectors
from .joined_pieces import CutSurface
from .seam_pairs import OutlineSides, SeamSides

MAX_TURN = 45.0  # largest angle between consecutive segments of a drawn fold line, in degrees


def find_folds(cut: CutSurface, crease: float) -> tuple[IntArray, FloatArray]:
    """Return the fold edges inside pieces, (#folds, 2), and their angles in degrees.

    An edge is a fold if its dihedral angle is at least `crease` degrees and if it is not a diagonal of a
    polygon. Angles of mountain folds are positive.
    """
    topology = cut.topology
    first, second = topology.sides
    inside = np.flatnonzero(second >= 0)
    if cut.inner is not None:
        half = cut.inner[:, NEXT].T.ravel()
        inside = inside[~(half[first[inside]] & half[second[inside]])]
    normal = _find_normals(cut)
    m = len(normal)
    tail, head = cut.surface[topology.edges[inside].T]
    angle = _measure_angles(normal[first[inside] % m], normal[second[inside] % m], head - tail)
    kept = np.abs(angle) >= crease
    return topology.edges[inside[kept]], angle[kept]


def find_seam_angles(cut: CutSurface, sides: OutlineSides, seams: tuple[SeamSides, ...]) -> FloatArray:
    """Return the signed dihedral angle in degrees at each side of a seam, as in `find_folds`; 0 elsewhere."""
    topology, n = cut.topology, len(cut.flat)
    border = np.flatnonzero(topology.sides[1] < 0)
    key = topology.edges[border] @ [n, 1]
    order = np.argsort(key)
    at = border[order[np.searchsorted(key[order], sides.start * n + sides.end)]]
    normal = _find_normals(cut)
    normal = normal[topology.sides[0, at] % len(normal)]
    along = cut.surface[sides.end] - cut.surface[sides.start]
    angle = np.zeros(len(at))
    for seam in seams:
        other = -normal[seam.other] if seam.twisted else normal[seam.other]
        angle[seam.one] = angle[seam.other] = _measure_angles(normal[seam.one], other, along[seam.one])
    return angle


def join_segments(segments: FloatArray) -> list[FloatArray]:
    """Join adjacent segments (n, 2, 2) into polylines, because a dash may be longer than a segment.

    A line ends where it turns by more than `MAX_TURN`, or where three segments meet.
    """
    places, node = np.unique(segments.reshape(-1, 2), axis=0, return_inverse=True)
    node = node.ravel()  # the ends 2 i and 2 i + 1 belong to segment i
    order = np.argsort(node, kind="stable")
    first = np.searchsorted(node[order], np.flatnonzero(np.bincount(node, minlength=len(places)) == 2))
    one, other = order[first], order[first + 1]
    away = normalize_vectors(places[node[np.arange(len(node)) ^ 1]] - places[node])
    straight = (away[one] * away[other]).sum(axis=1) <= -np.cos(np.radians(MAX_TURN))
    following = np.full(len(node), -1)
    following[one[straight]], following[other[straight]] = other[straight], one[straight]
    done, lines = np.zeros(len(segments), dtype=bool), []
    for end in np.argsort(following >= 0, kind="stable").tolist():  # trace open lines before closed lines
        rows = [node[end]]
        while end >= 0 and not done[end // 2]:
            done[end // 2] = True
            rows.append(node[end ^ 1])
            end = int(following[end ^ 1])
        if len(rows) > 1:
            lines.append(places[rows])
    return lines


def _find_normals(cut: CutSurface) -> FloatArray:
    """Return the unit normals of the faces."""
    a, b, c = cut.surface[cut.topology.corner]
    return normalize_vectors(np.cross(b - a, c - a))


def _measure_angles(one: FloatArray, other: FloatArray, along: FloatArray) -> FloatArray:
    """Return the angles between normals in degrees, positive at convex edges.

    `along` is the direction of each edge, with the face of the normal `one` on its left.
    """
    cross = np.cross(one, other)
    angle = np.degrees(np.arctan2(np.linalg.norm(cross, axis=1), (one * other).sum(axis=1)))
    return np.asarray(np.where((cross * along).sum(axis=1) < 0, -angle, angle))
