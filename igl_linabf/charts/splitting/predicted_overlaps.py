"""Overlaps of a map, and tips that it shrinks, predicted on a coarse mesh; and seams for them.

Clusters of a surface are the vertices of the coarse mesh, whose map is much like that of the surface. Where
it overlaps, the surface is cut before it is flattened: seams are found as usual, among far fewer triangles.
"""

from contextlib import suppress

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
from .tips import seams_worth, size_and_stretch, tips_of


def coarse_mesh(graph: SurfaceGraph, corners: IntArray) -> Submesh | None:
    """The mesh of clusters: the triangles whose `corners`, (#F, 3), are three different nodes.

    Holes are open. None if it is no oriented manifold, or lacks many edges of the graph.
    """
    different = (corners != np.roll(corners, 1, axis=1)).all(axis=1) & (corners >= graph.n_holes).all(axis=1)
    F = corners[different]
    tail, head = F, F[:, list(NEXT)]
    key = np.minimum(tail, head) * graph.n + np.maximum(tail, head)
    inner = ~np.isin(key, graph.neighbours[0])  # a diagonal of a polygon
    proper = graph.ends[(graph.ends >= graph.n_holes).all(axis=1)]
    missing = len(proper) - len(np.unique(key[~inner]))  # between two holes, or around a thin handle
    if missing > constants.MAX_MISSING_EDGES * (graph.n_holes + graph.genus):
        return None
    cleaned, mesh = cleaned_surface(graph.position, F)  # a node beside two holes is in two fans
    if {repair.kind for repair in cleaned.repairs} - {"bowtie"}:
        return None
    return Submesh(mesh.V, mesh.F, mesh.faces, cleaned.origin, graph.n, inner if inner.any() else None)


def predicted_seams(
    graph: SurfaceGraph, mesh: Submesh, seam: IntArray, trade: float
) -> tuple[IntArray, IntArray]:
    """Edges to cut besides a seam, and their ends.

    They separate sheets that would lie over each other in the maps of the disks that the seam leaves. Others
    lead to tips that these maps would shrink, where that is worth their length.
    """
    none, nodes, number = np.zeros(0, dtype=np.int64), mesh.vertices, 0
    tip_rounds = constants.MAX_COARSE_TIP_ROUNDS if trade > 0 else 0
    waiting = [(part, tip_rounds, False) for part in mesh.cut_along(graph.ends[seam])]
    tips, ways, sources = none, none, [graph.boundary_nodes(seam)]
    label = np.zeros(len(mesh.F), dtype=np.int64)
    for _ in range(constants.MAX_SPLITS):
        smaller = list[tuple[Submesh, int, bool]]()
        asked = [part for part, *_ in waiting if len(part.F) >= constants.MIN_PREDICTED_SHARE * len(mesh.F)]
        sketches = iter(_sketches(asked))
        for part, rounds, stays_whole in waiting:
            number += 1
            label[part.faces] = number
            if len(part.F) < constants.MIN_PREDICTED_SHARE * len(mesh.F):
                continue
            parts, uv, stays_whole = _parts(part, next(sketches), stays_whole)
            if parts:
                shared, times = np.unique(np.concatenate([p.vertices for p in parts]), return_counts=True)
                sources.append(shared[times > 1])
                smaller += [(p, rounds, False) for p in parts]
            elif uv is not None and rounds:
                new, way = _seams_to_coarse_tips(graph, np.concatenate(sources), part, uv, trade)
                if len(new):
                    tips, ways = np.append(tips, new), np.append(ways, way)
                    sources.append(graph.ends[way].ravel())
                    smaller += [(p, rounds - 1, stays_whole) for p in part.cut_along(graph.ends[way])]
        waiting = smaller
        if number + len(waiting) > constants.MAX_PREDICTED_DISKS:
            return none, none
        if not waiting:
            break
    seam = np.append(seam, ways)
    inside = mesh.cuttable_edges
    ends = nodes[mesh.topology.edges[inside]]
    edge, sides = graph.edges_between(*ends.T), mesh.topology.sides[:, inside] % len(mesh.F)
    of = _with_small_parts_joined(label, sides[:, ~np.isin(edge, seam)])
    for _ in range(2):
        right, left = of[sides]
        more = _joined_to_holes(graph, seam, np.setdiff1d(edge[right != left], seam))
        parts = mesh.cut_along(graph.ends[np.append(seam, more)])
        unsound = [part.faces for part in parts if len(part.topology.loops) != 1 or part.topology.genus]
        if not unsound:
            return np.append(ways, more), np.union1d(
                tips, np.intersect1d(graph.ends[more], graph.boundary_nodes(seam))
            )
        faces = np.concatenate(unsound)
        of[faces] = label[faces]  # small parts that close a ring stay apart
    return none, none


def _joined_to_holes(graph: SurfaceGraph, seam: IntArray, more: IntArray) -> IntArray:
    """The edges `more`, with those that join their loose ends to holes: the coarse mesh leaves these out."""
    if not graph.n_holes:
        return more
    number = np.bincount(graph.ends[np.append(seam, more)].ravel(), minlength=graph.n)
    loose = np.unique(graph.ends[more])
    loose = loose[(number[loose] == 1) & (loose >= graph.n_holes)]
    at_hole = (graph.ends < graph.n_holes).any(axis=1) & np.isin(graph.ends, loose).any(axis=1)
    return np.union1d(more, np.intersect1d(np.flatnonzero(at_hole), graph.neighbours[1]))


def _seams_to_coarse_tips(
    graph: SurfaceGraph, sources: IntArray, part: Submesh, uv: FloatArray, trade: float
) -> tuple[IntArray, IntArray]:
    """Nodes at tips of a part that are worth a seam from some sources, and the edges of these seams."""
    changed = change_of(part, uv)
    # on the surface itself faces shrink about twice as much
    faces, saved = tips_of(part.F, len(part.V), changed, 2 * constants.TIP_AREA_SHARE)
    if not len(faces):
        return faces, faces
    distance, before, _ = graph.shortest_paths(sources)
    corners = part.vertices[part.F[faces]]
    leaves = corners[np.arange(len(faces)), distance[corners].argmax(axis=1)]
    size, total = size_and_stretch(changed)
    chosen = leaves[seams_worth(distance[leaves] / (size * trade), saved, total)[0]]
    return chosen, graph.path_edges(before, chosen)


def _with_small_parts_joined(label: IntArray, sides: IntArray) -> IntArray:
    """The label of each face; a small part takes that of the neighbour with which it shares most edges."""
    label = label.copy()
    for part in np.argsort(np.bincount(label), kind="stable").tolist():
        faces = int((label == part).sum())
        right, left = label[sides]
        around = np.append(left[right == part], right[left == part])
        around = around[around != part]
        if 0 < faces < constants.MIN_PREDICTED_SHARE * len(label) and len(around):
            label[label == part] = np.bincount(around).argmax()
    return label


def _sketches(disks: list[Submesh]) -> list[Flattening | None]:
    """Quick maps of disks, of small ones side by side; None where there is none."""
    results = flatten_together([(disk.V, disk.F) for disk in disks], Rough())
    for k, disk in enumerate(disks):
        if results[k] is None:
            with suppress(MeshError, SingularSystemError):
                results[k] = flatten_piece(disk, Rough())
    return results


def _parts(
    disk: Submesh, result: Flattening | None, stays_whole: bool
) -> tuple[list[Submesh], FloatArray | None, bool]:
    """The parts of a disk whose map overlaps; this map, if no triangle flips; whether the disk stays whole.

    A disk without overlaps has no parts. Nor has one whose largest part would keep its map: to cut it before
    it is flattened gains nothing. Such a disk stays whole also when it is cut to tips.
    """
    if result is None:
        return [], None, stays_whole
    uv = None if len(result.flipped) else result.uv
    if stays_whole or result.holes:
        return [], uv, stays_whole
    pairs = overlapping_pairs_of_chart(disk.topology, result.uv)
    if not len(pairs) or len(np.unique(pairs)) < constants.MIN_PREDICTED_SHARE * len(disk.F) or uv is None:
        return [], uv, False
    most = constants.MAX_PREDICTED_OVERLAPS
    parts = split_at_creases(disk, uv) or split_overlaps(disk, disk.faces[pairs], most)
    _, squared = size_and_stretch(change_of(disk, uv))
    if keeps_map(max(len(part.F) for part in parts), len(disk.F), float(np.sqrt(squared))):
        # so would the fine map, which has fewer overlaps than this one
        return [], uv, True
    return parts, uv, False
