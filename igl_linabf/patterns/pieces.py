"""The pieces of a pattern: outlines, seams that belong together, folds, grain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree
from shapely import LineString, polygons, unary_union

from .._runtime import aligned
from .._types import BoolArray, FloatArray, IntArray
from ..charts import Atlas
from ..errors import MeshError
from ..surface import (
    NEXT,
    Polygons,
    Topology,
    Triangles,
    complex_positions,
    connected_labels,
    map_array,
    signed_double_areas,
    topology_of,
    vertex_array,
)

ARROW = 0.3  # half of its length, as a share of the piece along it
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}


@dataclass(frozen=True)
class PatternSeam:
    """Two stretches of outline that are joined.

    Attributes
    ----------
    number : int
        As it is written on both.
    pieces : (int, int)
    lengths : (float, float)
        Of both sides in the pattern, in millimetres.
    length : float
        On the surface.
    sides : two (n, 2) float64
        Their points, in the order in which they are joined. The material is on the left of the first.
    twisted : bool
        Whether it is on the left of the second, too: that side is joined upside down, as a Moebius band's.
    """

    number: int
    pieces: tuple[int, int]
    lengths: tuple[float, float]
    length: float
    sides: tuple[FloatArray, FloatArray]
    twisted: bool = False

    @property
    def change(self) -> float:
        """How much longer the first side is than the second, as a share of the surface's length."""
        return (self.lengths[0] - self.lengths[1]) / self.length


@dataclass(frozen=True, eq=False)
class Pattern:
    """The outlines of a flattened surface at true scale, in millimetres, y upwards.

    Attributes
    ----------
    size : (float, float)
        Width and height of the whole.
    outlines : tuple of (n, 2) float64
        Closed lines, the material on their left; a hole is one more.
    piece : (#outlines,) int64
        The piece that each is of.
    seams : tuple of PatternSeam
    folds : (#folds, 2, 2) float64
        Creases within pieces.
    grain : (#pieces, 2, 2) float64
        From where to where each piece's arrow points.
    error : float
        Largest change of an edge's length, as a share of it.
    units : str
        Of the surface.
    """

    size: tuple[float, float]
    outlines: tuple[FloatArray, ...]
    piece: IntArray
    seams: tuple[PatternSeam, ...]
    folds: FloatArray
    grain: FloatArray
    error: float
    units: str

    @property
    def pieces(self) -> int:
        """Their number."""
        return len(self.grain)

    def __str__(self) -> str:
        rows: list[tuple[str, ...]] = [("seam", "pieces", "mm", "mm", "on the surface", "change")]
        for seam in self.seams:
            pieces = "{} {}".format(*seam.pieces)
            lengths = [f"{length:.2f}" for length in (*seam.lengths, seam.length)]
            rows.append((str(seam.number), pieces, *lengths, f"{round(seam.change, 4) + 0.0:+.2%}"))
        width, height = self.size
        pieces = f"{self.pieces} piece{'s' * (self.pieces != 1)}"
        said = f"{pieces}, {width:.1f} x {height:.1f} mm, {len(self.folds)} fold edges"
        return f"{aligned(rows)}\n{said}; edges change by {self.error:.2%} at most"


def pattern_of(
    V: ArrayLike, F: ArrayLike, atlas: Atlas | ArrayLike, units: str, crease: float, grain: ArrayLike
) -> Pattern:
    """The pattern of a surface; arguments as in `write_pattern`."""
    if units not in MILLIMETRES:
        raise ValueError(f"units is {units!r}: use one of {', '.join(MILLIMETRES)}")
    points = vertex_array(V)
    repaired = isinstance(atlas, Atlas) and bool(atlas.repairs)
    split: Triangles | None
    if isinstance(atlas, Atlas):
        TC, FTC, origin, split = atlas.TC, atlas.triangles, atlas.origin, atlas.split
        if origin.max() >= len(points):
            raise MeshError(
                f"the atlas names vertex {origin.max()} of {len(points)}: pass the unwrapped V and F"
            )
    else:
        split, origin = Polygons.of(F).split(points), np.arange(len(points))
        TC, FTC = map_array(atlas, len(points)), split.F
    solid = (FTC[:, NEXT] != FTC).all(axis=1)
    FTC, inner = FTC[solid], None if split is None else split.inner[solid]
    used, F_flat = np.unique(FTC, return_inverse=True)
    F_flat = F_flat.reshape(-1, 3)
    surface, flat = points[origin[used]] * MILLIMETRES[units], TC[used]
    if not np.isfinite(flat).all():
        raise MeshError("coordinates in uv are NaN or infinite: pass a map of all faces")
    a, b, c = surface[F_flat.T]
    on_surface = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    if not np.isfinite(on_surface):
        raise MeshError(f"the surface has an area of {on_surface} square millimetres: scale V")
    area = signed_double_areas(complex_positions(flat), F_flat.T)
    if not np.abs(area).sum() > 0:
        raise MeshError("uv has no area: pass the map of V and F")
    if repaired:  # faces run as they were given, also those that `unwrap` turned
        F_flat = np.where(area[:, None] < 0, F_flat[:, [0, 2, 1]], F_flat)
    flat = flat * np.sqrt(on_surface / np.abs(area).sum())
    flat -= flat.min(axis=0)
    topology = topology_of(F_flat, used)
    label = connected_labels(topology.edges, len(used))
    _, label = np.unique(label, return_inverse=True)
    loops = topology.loops
    length = [
        np.linalg.norm(of[topology.edges[:, 0]] - of[topology.edges[:, 1]], axis=1) for of in (flat, surface)
    ]
    return Pattern(
        size=(float(flat[:, 0].max()), float(flat[:, 1].max())),
        outlines=tuple(flat[loop] for loop in loops),
        piece=np.array([label[loop[0]] for loop in loops], dtype=np.int64),
        seams=_seams(surface, flat, loops, label),
        folds=flat[_creases(surface, topology, inner, crease)],
        grain=_grain(surface, flat, F_flat, label, loops, np.asarray(grain, dtype=float)),
        error=float(np.max(np.abs(length[0] / np.maximum(length[1], 1e-300) - 1), initial=0)),
        units=units,
    )


def _seams(
    surface: FloatArray, flat: FloatArray, loops: tuple[IntArray, ...], label: IntArray
) -> tuple[PatternSeam, ...]:
    """Runs of outline edges that lie on the same edges of the surface, from both sides.

    These run opposite ways around, but where a one-sided surface was cut.
    """
    if not loops:
        return ()
    start = np.concatenate(loops)
    end = np.concatenate([np.roll(loop, -1) for loop in loops])
    base = np.repeat(np.cumsum([0, *map(len, loops[:-1])]), [len(loop) for loop in loops])
    size = np.repeat([len(loop) for loop in loops], [len(loop) for loop in loops])
    after = base + (np.arange(len(start)) - base + 1) % size
    _, place = np.unique(surface, axis=0, return_inverse=True)  # copies of a vertex are in one place
    place = place.ravel()
    n = int(place.max()) + 1
    own, twin = place[start] * n + place[end], place[end] * n + place[start]
    order = np.lexsort((label[start], own))  # the first of a piece goes with its first the other way around
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order)) - np.searchsorted(own[order], own[order])
    at = np.minimum(np.searchsorted(own[order], twin) + rank, len(order) - 1)
    partner = np.where(own[order][at] == twin, order[at], -1)
    alone = order[partner[order] < 0]  # still in order, so that those of the same direction are neighbours
    same = own[alone[1:]] == own[alone[:-1]]
    pairs = np.flatnonzero(same & ~np.append(False, same[:-1]))
    one, other = alone[pairs], alone[pairs + 1]
    partner[one], partner[other] = other, one
    twisted = np.zeros(len(start), dtype=bool)
    twisted[one] = twisted[other] = True
    on_other = np.where(twisted[after], after[partner], partner)
    goes_on = (partner >= 0) & (partner[after] >= 0) & (twisted == twisted[after])
    goes_on &= np.where(twisted, partner[after], after[partner[after]]) == on_other
    goes_on &= partner != after  # around a tip the other side begins
    length = np.linalg.norm(surface[start] - surface[end], axis=1)
    flat_length = np.linalg.norm(flat[start] - flat[end], axis=1)
    before = np.empty_like(after)
    before[after] = np.arange(len(after))
    seams, done = list[PatternSeam](), np.zeros(len(start), dtype=bool)
    for first in np.flatnonzero(partner >= 0).tolist():
        if done[first]:
            continue
        while goes_on[before[first]] and not done[before[first]]:
            first = int(before[first])
            done[first] = True
        run = [first]
        while goes_on[run[-1]] and after[run[-1]] != first:
            run.append(int(after[run[-1]]))
        one, other = np.array(run), partner[run]
        done[one] = done[other] = True
        tail, head = (start, end) if twisted[first] else (end, start)
        seams.append(
            PatternSeam(
                number=len(seams) + 1,
                pieces=(int(label[start[one[0]]]), int(label[start[other[0]]])),
                lengths=(float(flat_length[one].sum()), float(flat_length[other].sum())),
                length=float(length[one].sum()),
                sides=(
                    flat[np.append(start[one], end[one[-1]])],
                    flat[np.append(tail[other], head[other[-1]])],
                ),
                twisted=bool(twisted[first]),
            )
        )
    return tuple(seams)


def _creases(surface: FloatArray, topology: Topology, inner: BoolArray | None, crease: float) -> IntArray:
    """Edges inside of pieces along which the faces meet at `crease` degrees or more; no diagonals."""
    first, second = topology.sides
    inside = np.flatnonzero(second >= 0)
    if inner is not None:
        half = inner[:, NEXT].T.ravel()
        inside = inside[~(half[first[inside]] & half[second[inside]])]
    F = topology.corner.T
    a, b, c = surface[F.T]
    normal = np.cross(b - a, c - a)
    m = len(F)
    one, other = normal[first[inside] % m], normal[second[inside] % m]
    angle = np.arctan2(np.linalg.norm(np.cross(one, other), axis=1), (one * other).sum(axis=1))
    return np.asarray(topology.edges[inside[angle >= np.deg2rad(crease)]])


def _grain(
    surface: FloatArray,
    flat: FloatArray,
    F: IntArray,
    label: IntArray,
    loops: tuple[IntArray, ...],
    direction: FloatArray,
) -> FloatArray:
    """Arrows: where the direction in space points on each piece, or along it if it points nowhere."""
    if direction.shape != (3,) or not np.linalg.norm(direction) > 0:
        raise ValueError(f"grain is {direction.tolist()}: give a direction in space, three numbers")
    e, f = (surface[F[:, k]] - surface[F[:, 0]] for k in (1, 2))
    u, v = (flat[F[:, k]] - flat[F[:, 0]] for k in (1, 2))
    ee, ef, ff = (e * e).sum(1), (e * f).sum(1), (f * f).sum(1)
    de, df = e @ direction, f @ direction
    det = np.maximum(ee * ff - ef * ef, 1e-300)
    along = ((de * ff - df * ef) / det)[:, None] * u + ((df * ee - de * ef) / det)[:, None] * v
    area = np.sqrt(det) / 2
    arrows = []
    outlines, outline_piece = [flat[loop] for loop in loops], [int(label[loop[0]]) for loop in loops]
    for piece in range(int(label.max()) + 1):
        faces = np.flatnonzero(label[F[:, 0]] == piece)
        mean = (along[faces] * area[faces, None]).sum(axis=0) / area[faces].sum() / np.linalg.norm(direction)
        points = flat[label == piece]
        centre = points.mean(axis=0)
        if np.linalg.norm(mean) < 0.1:
            mean = np.linalg.svd(points - centre, full_matrices=False)[2][0]
        mean = mean / np.linalg.norm(mean)
        own = flat[F[faces]].reshape(-1, 3, 2)
        rim = np.concatenate([line for line, of in zip(outlines, outline_piece, strict=True) if of == piece])
        room, _ = cKDTree(rim).query(own.mean(axis=1))
        at = own.mean(axis=1)[np.argmax(room)]  # far from the outline
        inside = unary_union(polygons(own))
        half = ARROW * np.ptp(points @ mean)
        while half > room.max() and not inside.contains(LineString((at - half * mean, at + half * mean))):
            half *= 0.8
        arrows.append((at - half * mean, at + half * mean))
    return np.array(arrows)
