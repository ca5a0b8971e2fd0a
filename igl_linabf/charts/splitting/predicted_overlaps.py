"""Overlaps of a map, and tips that it shrinks, foreseen on the clusters of a surface; and seams for them.

Clusters are the vertices of a coarse mesh, whose map is much like the one of the surface. Where it overlaps,
the surface is cut before it is flattened at all: that is the same search for seams on far fewer triangles.
"""

import numpy as np

from ..._types import FloatArray, IntArray
from ...errors import MeshError, SingularSystemError
from ...flattening import Flattening, Rough, flatten_together
from ...measures import change_of, overlapping_pairs_of_chart
from ...surface import NEXT, Submesh, cleaned_surface
from ..atlas import flatten_piece
from ..cut_graphs import SurfaceGraph
from . import constants
from .crease_cuts import split_at_creases
from .overlap_seams import split_overlaps
from .reused_maps import keeps_map
from .tips import size_and_stretch, tips_of, worth_a_seam


def coarse_mesh(graph: SurfaceGraph, corners: IntArray) -> Submesh | None:
    """The triangles of a closed surface, from the nodes at the corners of those that it came from.

    Holes are open. None if the triangles are no oriented manifold, or many edges are missing.
    """
    different = (corners != np.roll(corners, 1, axis=1)).all(axis=1) & (corners >= graph.n_holes).all(axis=1)
    F = corners[different]
    tail, head = F, F[:, list(NEXT)]
    key = np.minimum(tail, head) * graph.n + np.maximum(tail, head)
    inner = ~np.isin(key, graph.neighbours[0])  # a diagonal of a polygon
    proper = graph.ends[(graph.ends >= graph.n_holes).all(axis=1)]
    bridges = len(proper) - len(np.unique(key[~inner]))  # between two triangles at holes, or around a handle
    if bridges > constants.MAX_MISSING_EDGES * (graph.n_holes + graph.genus):
        return None
    cleaned, mesh = cleaned_surface(graph.position, F)  # a node beside two holes is in two fans
    if {repair.kind for repair in cleaned.repairs} - {"bowtie"}:
        return None
    return Submesh(mesh.V, mesh.F, mesh.faces, cleaned.origin, graph.n, inner if inner.any() else None)


def predicted_seams(
    graph: SurfaceGraph, mesh: Submesh, seam: IntArray, trade: float
) -> tuple[IntArray, IntArray]:
    """Edges between the sheets that would lie over each other, were the surface cut to disks along a seam.

    And those to tips that the maps of the parts would shrink, if they are worth it. With the ends of both.
    """
    none, nodes, number = np.zeros(0, dtype=np.int64), mesh.vertices, 0
    tip_rounds = constants.MAX_COARSE_TIP_ROUNDS if trade > 0 else 0
    waiting = [(part, tip_rounds, False) for part in mesh.cut_along(graph.ends[seam])]
    tips, ways, walls = none, none, [graph.boundary_nodes(seam)]
    label = np.zeros(len(mesh.F), dtype=np.int64)
    for _ in range(constants.MAX_SPLITS):
        smaller = list[tuple[Submesh, int, bool]]()
        asked = [part for part, *_ in waiting if len(part.F) >= constants.MIN_PREDICTED_PART * len(mesh.F)]
        sketches = iter(_sketches(asked))
        for part, rounds, stays in waiting:
            number += 1
            label[part.faces] = number
            if len(part.F) < constants.MIN_PREDICTED_PART * len(mesh.F):
                continue
            parts, uv, stays = _parts(part, next(sketches), stays)
            if parts:
                shared, times = np.unique(np.concatenate([p.vertices for p in parts]), return_counts=True)
                walls.append(shared[times > 1])
                smaller += [(p, rounds, False) for p in parts]
            elif uv is not None and rounds:
                new, way = _tips(graph, np.concatenate(walls), part, uv, trade)
                if len(new):
                    tips, ways = np.append(tips, new), np.append(ways, way)
                    walls.append(graph.ends[way].ravel())
                    smaller += [(p, rounds - 1, stays) for p in part.cut_along(graph.ends[way])]
        waiting = smaller
        if number + len(waiting) > constants.MAX_PREDICTED_DISKS:
            return none, none
        if not waiting:
            break
    seam = np.append(seam, ways)
    inside = mesh.cuttable_edges
    ends = nodes[mesh.topology.edges[inside]]
    edge, sides = graph.edges_between(*ends.T), mesh.topology.sides[:, inside] % len(mesh.F)
    of = _with_chips_joined(label, sides[:, ~np.isin(edge, seam)])
    for _ in range(2):
        right, left = of[sides]
        more = _up_to_holes(graph, seam, np.setdiff1d(edge[right != left], seam))
        parts = mesh.cut_along(graph.ends[np.append(seam, more)])
        unsound = [part.faces for part in parts if len(part.topology.loops) != 1 or part.topology.genus]
        if not unsound:
            return np.append(ways, more), np.union1d(
                tips, np.intersect1d(graph.ends[more], graph.boundary_nodes(seam))
            )
        faces = np.concatenate(unsound)
        of[faces] = label[faces]  # chips that close a ring stay apart
    return none, none


def _up_to_holes(graph: SurfaceGraph, seam: IntArray, more: IntArray) -> IntArray:
    """Edges that part a coarse mesh, with those from its boundary to the holes."""
    if not graph.n_holes:
        return more
    number = np.bincount(graph.ends[np.append(seam, more)].ravel(), minlength=graph.n)
    loose = np.unique(graph.ends[more])
    loose = loose[(number[loose] == 1) & (loose >= graph.n_holes)]
    at_hole = (graph.ends < graph.n_holes).any(axis=1) & np.isin(graph.ends, loose).any(axis=1)
    return np.union1d(more, np.intersect1d(np.flatnonzero(at_hole), graph.neighbours[1]))


def _tips(
    graph: SurfaceGraph, walls: IntArray, part: Submesh, uv: FloatArray, trade: float
) -> tuple[IntArray, IntArray]:
    """Nodes at tips of a part that are worth a seam from the nodes `walls`, and the edges of the seams."""
    changed = change_of(part, uv)
    faces, saved = tips_of(part.F, len(part.V), changed, constants.COARSE_TIP_AREA_SHARE)
    if not len(faces):
        return faces, faces
    distance, before, _ = graph.shortest_paths(walls)
    corners = part.vertices[part.F[faces]]
    tip = corners[np.arange(len(faces)), distance[corners].argmax(axis=1)]
    size, total = size_and_stretch(changed)
    chosen = tip[worth_a_seam(saved, distance[tip] / size / trade, total)]
    return chosen, graph.path_edges(before, chosen)


def _with_chips_joined(label: IntArray, sides: IntArray) -> IntArray:
    """The label of each face, small parts having that of the neighbour with which they share most edges."""
    label = label.copy()
    for chip in np.argsort(np.bincount(label), kind="stable").tolist():
        faces = int((label == chip).sum())
        right, left = label[sides]
        around = np.append(left[right == chip], right[left == chip])
        around = around[around != chip]
        if 0 < faces < constants.MIN_PREDICTED_PART * len(label) and len(around):
            label[label == chip] = np.bincount(around).argmax()
    return label


def _sketches(disks: list[Submesh]) -> list[Flattening | None]:
    """Quick maps of disks, of small ones side by side; None where there is none."""
    results = flatten_together([(disk.V, disk.F) for disk in disks], Rough())
    return [_sketch(disk) if known is None else known for disk, known in zip(disks, results, strict=True)]


def _sketch(disk: Submesh) -> Flattening | None:
    try:
        return flatten_piece(disk, Rough())
    except (MeshError, SingularSystemError):
        return None


def _parts(
    disk: Submesh, result: Flattening | None, stays: bool
) -> tuple[list[Submesh], FloatArray | None, bool]:
    """The parts of a disk whose map overlaps; this map, if no triangle flips; whether the disk stays whole.

    There are no parts if it is sound, or if the largest part keeps the map: nothing is gained by cutting
    before. Then it stays so when it is cut to tips.
    """
    if result is None:
        return [], None, stays
    uv = None if len(result.flipped) else result.uv
    if stays or result.holes:
        return [], uv, stays
    pairs = overlapping_pairs_of_chart(disk.topology, result.uv)
    if not len(pairs) or len(np.unique(pairs)) < constants.MIN_PREDICTED_OVERLAP * len(disk.F) or uv is None:
        return [], uv, False
    most = constants.MAX_PREDICTED_OVERLAPS
    parts = split_at_creases(disk, uv, pairs) or split_overlaps(disk, disk.faces[pairs], most)
    _, squared = size_and_stretch(change_of(disk, uv))
    if keeps_map(max(len(part.F) for part in parts), len(disk.F), float(np.sqrt(squared))):
        # so would the fine map, which has fewer overlaps than this one
        return [], uv, True
    return parts, uv, False
