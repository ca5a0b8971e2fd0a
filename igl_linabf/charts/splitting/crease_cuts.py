"""Cuts along creases, where an isometric map overlaps itself.

Creases bound regions: planes, cylinders, cones. An isometric map lays each out in the same place, whichever
creases are cut. So all creases are cut at first. Then regions are merged, those with the longest common
crease first, unless one lies over the other.
"""

from heapq import heapify, heappop, heappush

import numpy as np

from ..._types import FloatArray, IntArray
from ...measures import change_of
from ...surface import Submesh, complex_positions, connected_labels, signed_double_areas
from ..features import SHARP_CREASE_ANGLE, dihedral_angles
from .constants import MAX_ISOMETRIC_DISTORTION

Lengths = list[dict[int, float]]  # of the creases to each neighbour of a region


def split_at_creases(piece: Submesh, uv: FloatArray, pairs: IntArray) -> list[Submesh]:
    """The parts of a piece whose faces `pairs` overlap in its map; none if creases do not part them."""
    if not is_isometric(piece, uv):
        return []
    region, sides, length = _regions(piece)
    number = int(region.max()) + 1
    over = np.unique(_pair_codes(region[pairs], number))
    if not len(over):
        return []
    touching, of = np.unique(_pair_codes(region[sides], number), return_inverse=True)
    common = np.bincount(of, length, minlength=len(touching))
    ends, apart = (np.column_stack(np.divmod(code, number)).tolist() for code in (touching, over))
    return piece.divided(_merged(number, ends, common.tolist(), apart)[region])


def is_isometric(piece: Submesh, uv: FloatArray) -> bool:
    """Whether L2 stretch and conformal distortion are nearly 1; ratios of areas rule out most maps."""
    double_area = piece.measured[0]
    flat = np.abs(signed_double_areas(complex_positions(uv), piece.topology.corner))
    with np.errstate(divide="ignore"):
        least = float(double_area @ (double_area / flat)) * float(flat.sum()) / float(double_area.sum()) ** 2
    if not least < MAX_ISOMETRIC_DISTORTION**2:  # 1 / s1^2 + 1 / s2^2 >= 2 / (s1 s2) of the singular values
        return False
    changed = change_of(piece, uv)
    stretch, shear = changed.mean(changed.squared_stretch) ** 0.5, changed.mean(changed.conformal)
    return bool(max(stretch, shear) < MAX_ISOMETRIC_DISTORTION)


def _regions(piece: Submesh) -> tuple[IntArray, IntArray, FloatArray]:
    """The region of each face; the two faces at each edge between two regions, and its length."""
    topology, m = piece.topology, len(piece.F)
    every = np.flatnonzero(topology.sides[1] >= 0)
    faces = topology.sides[:, every].T % m
    sharp = np.abs(dihedral_angles(piece)) >= SHARP_CREASE_ANGLE
    sharp &= np.isin(every, piece.cuttable_edges)  # diagonals of polygons are no creases
    region = connected_labels(faces[~sharp], m)
    between = sharp & (region[faces[:, 0]] != region[faces[:, 1]])
    a, b = topology.edges[every[between]].T
    return region, faces[between], np.linalg.norm(piece.V[a] - piece.V[b], axis=1)


def _pair_codes(pairs: IntArray, number: int) -> IntArray:
    """A number for each pair of two different regions, the same in either order."""
    a, b = pairs.T
    code = np.minimum(a, b) * number + np.maximum(a, b)
    return np.asarray(code[a != b])


def _merged(number: int, touching: list[list[int]], common: list[float], over: list[list[int]]) -> IntArray:
    """The group of each region, when those that touch are merged, unless one lies over another."""
    lengths: Lengths = [{} for _ in range(number)]
    apart: list[set[int]] = [set() for _ in range(number)]
    for (a, b), length in zip(touching, common, strict=True):
        lengths[a][b] = lengths[b][a] = length
    for a, b in over:
        apart[a].add(b)
        apart[b].add(a)
    waiting = [(-length, a, b) for (a, b), length in zip(touching, common, strict=True)]
    heapify(waiting)
    members = [[region] for region in range(number)]
    while waiting:
        length, a, b = heappop(waiting)
        if lengths[a].get(b) != -length or b in apart[a]:
            continue  # merged meanwhile, or their crease got longer; or one lies over the other
        if len(lengths[a]) + len(apart[a]) < len(lengths[b]) + len(apart[b]):
            a, b = b, a
        for other, more in lengths[b].items():
            del lengths[other][b]
            if other != a:
                total = lengths[a].get(other, 0.0) + more
                lengths[a][other] = lengths[other][a] = total
                heappush(waiting, (-total, min(a, other), max(a, other)))
        for other in apart[b]:
            apart[other].discard(b)
            apart[other].add(a)
        apart[a] |= apart[b]
        members[a] += members[b]
        lengths[b], apart[b], members[b] = {}, set(), []
    group = np.empty(number, dtype=np.int64)
    for a, regions in enumerate(members):
        group[regions] = a
    return group
