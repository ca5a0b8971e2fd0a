"""Overlaps of a map, and tips that it shrinks, foreseen on the clusters of a surface; and seams for them.

Clusters are the vertices of a coarse mesh, whose map is much like the one of the surface. Where it overlaps,
the surface is cut before it is flattened at all: that is the same search for seams on far fewer triangles.
"""

import numpy as np

from .._types import FloatArray, IntArray
from ..errors import MeshError, SingularSystemError
from ..flattening import Sketch
from ..measures import change_of, overlapping_pairs_of_chart
from ..surface import NEXT, Submesh
from .crease_cuts import parted
from .cut_graph import ClosedSurface
from .overlap_seams import MAX_SPLITS, seams_between
from .pieces import flattened
from .tips import tips_of, worth_a_seam

MANY = 300  # disks, beyond which the surface is parted when its map is known
FEW = 0.02  # share of faces that overlap, up to which the part cut off is small: the other part keeps its map
SHRUNK = 1 / 8  # of the area that a tip has in the map; on the surface itself faces shrink twice as much
MOST_BRIDGES = 4  # edges that are missing at each hole
CHIP = 0.02  # share of a component's faces, below which a part is left to a neighbour: it overlaps little


Map = tuple[Submesh, FloatArray]  # a part, and where its vertices are in the plane


def coarse_mesh(piece: ClosedSurface, corners: IntArray) -> Submesh | None:
    """The triangles of a closed surface, from the nodes at the corners of those that it came from.

    Holes are open. None if the triangles are no oriented manifold, or edges are missing elsewhere.
    """
    different = (corners != np.roll(corners, 1, axis=1)).all(axis=1) & (corners >= piece.holes).all(axis=1)
    F = corners[different]
    tail, head = F, F[:, list(NEXT)]
    key = np.minimum(tail, head) * piece.n + np.maximum(tail, head)
    inner = ~np.isin(key, piece.key)  # a diagonal of a polygon
    proper = piece.ends[(piece.ends >= piece.holes).all(axis=1)]
    bridges = len(proper) - len(np.unique(key[~inner]))  # between two triangles at holes, or around a handle
    if bridges > MOST_BRIDGES * piece.holes:
        return None
    try:
        mesh = Submesh.checked_manifold(piece.position, F)
    except MeshError:
        return None
    return Submesh(mesh.V, mesh.F, mesh.faces, mesh.vertices, mesh.n_given, inner if inner.any() else None)


def overlaps_and_tips(
    piece: ClosedSurface, mesh: Submesh, seam: IntArray, trade: float
) -> tuple[IntArray, IntArray]:
    """Edges between the sheets that would lie over each other, were the surface cut to disks along a seam.

    And nodes at tips that the maps of the parts would shrink, if seams to them are worth it.
    """
    none = np.zeros(0, dtype=np.int64)
    nodes, waiting, number, maps = mesh.vertices, mesh.cut_along(piece.ends[seam]), 0, list[Map]()
    label = np.zeros(len(mesh.F), dtype=np.int64)
    for _ in range(MAX_SPLITS):
        smaller: list[Submesh] = []
        for part in waiting:
            number += 1
            label[part.faces] = number
            parts, uv = _parts(part)
            smaller += parts
            maps += [] if parts or uv is None else [(part, uv)]
        waiting = smaller
        if number + len(waiting) > MANY:
            return none, none
        if not waiting:
            break
    inside = mesh.cells[1]
    ends = nodes[mesh.topology.edges[inside]]
    edge, sides = piece.between(*ends.T), mesh.topology.sides[:, inside] % len(mesh.F)
    right, left = _with_chips_joined(label, sides[:, ~np.isin(edge, seam)])[sides]
    more = _up_to_holes(piece, seam, np.setdiff1d(edge[right != left], seam))
    parts = mesh.cut_along(piece.ends[np.append(seam, more)])
    sound = all(len(part.topology.loops) == 1 and not part.topology.genus for part in parts)
    return (more, _tips(piece, np.append(seam, more), maps, trade)) if sound else (none, none)


def _up_to_holes(piece: ClosedSurface, seam: IntArray, more: IntArray) -> IntArray:
    """Edges that part a coarse mesh, with those from its boundary to the holes."""
    if not piece.holes:
        return more
    number = np.bincount(piece.ends[np.append(seam, more)].ravel(), minlength=piece.n)
    loose = np.unique(piece.ends[more])
    loose = loose[(number[loose] == 1) & (loose >= piece.holes)]
    at_hole = (piece.ends < piece.holes).any(axis=1) & np.isin(piece.ends, loose).any(axis=1)
    return np.union1d(more, np.intersect1d(np.flatnonzero(at_hole), piece.shortest))


def _tips(piece: ClosedSurface, seam: IntArray, maps: list[Map], trade: float) -> IntArray:
    """Nodes at tips that are worth a seam."""
    leaves = list[int]()
    distance = piece.search(piece.on(seam))[0]
    for part, uv in maps if trade > 0 else ():
        changed = change_of(part, uv)
        size = float(np.sqrt(changed.double_area.sum() / 2))
        faces, saved = tips_of(part.F, len(part.V), changed, SHRUNK)
        corners = part.vertices[part.F[faces]]
        tip = corners[np.arange(len(faces)), distance[corners].argmax(axis=1)]
        total = float(changed.double_area @ changed.squared_stretch) / (2 * size**2)
        leaves += tip[worth_a_seam(saved, distance[tip] / size / trade, total)].tolist()
    return np.array(leaves, dtype=np.int64)


def _with_chips_joined(label: IntArray, sides: IntArray) -> IntArray:
    """The label of each face, small parts having that of the neighbour with which they share most edges."""
    label = label.copy()
    for chip in np.argsort(np.bincount(label), kind="stable").tolist():
        faces = int((label == chip).sum())
        right, left = label[sides]
        around = np.append(left[right == chip], right[left == chip])
        around = around[around != chip]
        if 0 < faces < CHIP * len(label) and len(around):
            label[label == chip] = np.bincount(around).argmax()
    return label


def _parts(disk: Submesh) -> tuple[list[Submesh], FloatArray | None]:
    """The parts of a disk whose map overlaps, none if it is sound; and this map, if no triangle flips."""
    try:
        result = flattened(disk, Sketch())
    except (MeshError, SingularSystemError):
        return [], None
    pairs = overlapping_pairs_of_chart(disk.topology, result.uv)
    few = len(np.unique(pairs)) < FEW * len(disk.F)
    if few or not len(pairs) or len(result.flipped) or result.holes:
        return [], None if len(result.flipped) else result.uv
    parts = parted(disk, result.uv, pairs) or disk.cut_along(seams_between([disk], disk.faces[pairs]))
    return parts, result.uv
