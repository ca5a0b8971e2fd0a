"""Dihedral angles, flat parts, curvature and tips of a surface, robust against rounding of coordinates."""

import numpy as np

from ..._core import dihedrals, lengths, normals, symmetric_pattern, symmetric_product
from ..._types import BoolArray, FloatArray, IntArray
from ...surface import NEXT, PREV, Ragged, Submesh, connected_labels, sum_by_index
from . import constants

# Minimum height of a face with a reliable normal, in units of the rounding error of its coordinates.
MIN_SURE_HEIGHT = 100.0
MAX_UNSURE_ROW = 8  # maximum number of adjacent slivers that take the normal of the same neighbour
BEND_ROUNDING = 1e-5  # dihedral angle, radians, that rounding can cause between coplanar faces
FLAT_TURN = 0.1  # maximum turn of a flat part's normal, radians, over a distance of sqrt(area)
MIN_CORNER_TURN = 0.01  # minimum turn of a facet's outline at a corner, radians
TIP_PROMINENCE = 4.0  # minimum curvature of a tip on a soft crease, relative to the vertices around it


class Smoothing:
    """Smoothing by averaging over adjacent vertices: n steps reach about sqrt(n) edges.

    Parameters
    ----------
    component : Submesh
    edges : (#E, 2) int64
    length : (#E,) float64
        Length of each edge.
    """

    def __init__(self, component: Submesh, edges: IntArray, length: FloatArray) -> None:
        n = len(component.V)
        indptr, indices, _ = symmetric_pattern(edges.T, n)
        # the upper triangle of the adjacency matrix plus the identity
        self._matrix = indptr, indices, np.ones(len(indices))
        self._number = np.diff(indptr) + np.bincount(indices, minlength=n) - 1.0
        self._length = float(np.median(length)) if len(length) else np.inf

    def count_steps(self, reach: float, most: int) -> int:
        """Return the number of smoothing steps, at most `most`, that average over the distance `reach`."""
        return min(round((reach / self._length) ** 2), most)

    def smooth(self, values: FloatArray, steps: int) -> FloatArray:
        """Smooth values at the vertices, (#V,) or (#V, 2), by a number of averaging steps."""
        pairs = values if values.ndim > 1 else np.column_stack((values, np.zeros(len(values))))
        for _ in range(steps):
            pairs = symmetric_product(*self._matrix, pairs) / self._number[:, None]
        return pairs if values.ndim > 1 else np.ascontiguousarray(pairs[:, 0])


def integrate_mean_curvature(
    component: Submesh, edges: IntArray, length: FloatArray, bend: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return twice the mean curvature, integrated around each vertex, and the area around each vertex."""
    half, corner, double_area = bend * length / 2, component.F.T.ravel(), component.areas_and_products[0]
    turned = sum_by_index(edges.T.ravel(), np.tile(half, 2), len(component.V))
    return turned, sum_by_index(corner, np.tile(double_area / 6, 3), len(component.V))


def measure_extent(V: FloatArray) -> float:
    """Return the longest side of the bounding box of `V`."""
    return float(measure_bounding_box(V).max())


def measure_bounding_box(V: FloatArray) -> FloatArray:
    """Return the sides of the bounding box of `V`."""
    return np.asarray(np.ptp(np.ascontiguousarray(V.T), axis=1))  # ten times as fast as np.ptp(V, axis=0)


def compute_face_normals(component: Submesh, size: FloatArray | None = None) -> FloatArray:
    """Return the unit normals of faces, (#F, 3).

    A sliver takes the normal of the face across its longest side, so that rounding does not bend planes.
    `size` is the extent of the component of each face, (#F,), if there are several components.
    """
    V, F, topology = component.V, component.F, component.topology
    double_area, dot = component.areas_and_products
    normal = normals(V, topology.corner)
    squared_side = dot[NEXT] + dot[PREV]  # squared length of the side opposite to each corner
    least = MIN_SURE_HEIGHT * constants.COORDINATE_NOISE * (measure_extent(V) if size is None else size)
    unsure = double_area < least * np.sqrt(squared_side.max(axis=0))
    if unsure.any():
        m = len(F)
        twin = np.full(3 * m, -1)
        first, second = topology.interior_edge_sides
        twin[first], twin[second] = second, first
        rows = np.flatnonzero(unsure)
        across = twin[squared_side[:, rows].argmax(axis=0) * m + rows]
        other = np.where(across < 0, rows, across % m)
        for _ in range(MAX_UNSURE_ROW):
            found = unsure[rows] & ~unsure[other]
            if not found.any():
                break
            normal[rows[found]], unsure[rows[found]] = normal[other[found]], False
    return np.asarray(normal)


def compute_dihedral_angles(component: Submesh, size: FloatArray | None = None) -> FloatArray:
    """Return the angle between the face normals at each inner edge; negative at concave edges."""
    topology = component.topology
    return dihedrals(
        component.V, topology.corner, topology.interior_edge_sides, compute_face_normals(component, size)
    )


def compute_flat_share(component: Submesh, bend: FloatArray | None = None) -> float:
    """Return the share of the area that is flat: faces that are nearly coplanar with an adjacent face.

    Faces are nearly coplanar if the normal turns by less than `FLAT_TURN` over a distance of the square root
    of the area. Coplanar faces that form one triangle, for example in a subdivided mesh, count as this
    triangle. Therefore the share does not depend on the resolution of the mesh. It is about 0.1 on smooth
    surfaces. `bend` has the dihedral angles if they have been computed before.
    """
    return float(compute_flat_shares(component, np.zeros(len(component.F), dtype=np.int64), bend)[0])


def compute_flat_shares(surface: Submesh, of: IntArray, bend: FloatArray | None = None) -> FloatArray:
    """Return the flat share of each component; `of` is the component of each face."""
    topology, m, number = surface.topology, len(surface.F), int(of.max()) + 1
    sides = topology.interior_edge_faces.T
    double_area = surface.areas_and_products[0]
    total = sum_by_index(of, double_area, number)
    length = lengths(surface.V, topology.interior_edge_ends)
    size = (
        measure_component_extents(surface, of)[of]
        if number > 1
        else np.broadcast_to(measure_extent(surface.V), m)
    )
    if bend is None:
        bend = compute_dihedral_angles(surface, size if number > 1 else None)
    bend = np.abs(bend)
    facet = _find_facets(surface, sides, bend, size)
    area, (one, other), whole = double_area, sides, np.sqrt(total / 2)
    whole = whole[of[one]] if number > 1 else np.broadcast_to(whole, len(bend))
    if facet is not None:
        area, one, other = sum_by_index(facet, double_area, int(facet.max()) + 1), facet[one], facet[other]
        between = np.flatnonzero(one != other)
        one, other, length, bend, whole = (x[between] for x in (one, other, length, bend, whole))
        large = np.bincount(facet) > 1  # only facets of several faces can share more than one edge
        rows = np.flatnonzero(large[one] | large[other])
        low, high = np.minimum(one[rows], other[rows]), np.maximum(one[rows], other[rows])
        pair = np.unique(low * len(area) + high, return_inverse=True)[1]
        length[rows] = sum_by_index(pair, length[rows], int(pair.max(initial=0)) + 1)[pair]
    way = (area[one] + area[other]) / np.maximum(length, np.finfo(float).tiny)
    straight = bend < FLAT_TURN * way / whole + BEND_ROUNDING
    flat = np.zeros(len(area), dtype=bool)
    flat[one[straight]], flat[other[straight]] = True, True
    even = flat if facet is None else flat[facet]
    return np.asarray(sum_by_index(of, np.where(even, double_area, 0.0), number) / total)


def _find_facets(surface: Submesh, sides: IntArray, bend: FloatArray, size: FloatArray) -> IntArray | None:
    """Return the facet of each face: a flat triangle of several faces, or the face alone.

    If no faces form a flat triangle, return None. `sides` has the two faces of each inner edge, (2, #E),
    `bend` the dihedral angle at each inner edge, and `size` the extent of the component of each face.
    """
    m, n = len(surface.F), len(surface.V)
    double_area, dot = surface.areas_and_products
    height = double_area / np.sqrt((dot[NEXT] + dot[PREV]).max(axis=0))
    noise = constants.COORDINATE_NOISE * size[sides[0]] / np.minimum(*height[sides])
    in_plane = bend <= np.minimum(BEND_ROUNDING + 4 * noise, constants.MAX_BEND_ROUNDING)
    if not in_plane.any():
        return None
    plane = connected_labels(sides[:, in_plane].T, m)
    several = np.flatnonzero(np.bincount(plane)[plane] > 1)
    angle = np.arctan2(double_area[several], dot[:, several])
    key, at = np.unique(plane[several] * n + surface.F[several].T, return_inverse=True)
    turn = np.remainder(sum_by_index(at.ravel(), angle.ravel(), len(key)) + MIN_CORNER_TURN, np.pi)
    corners = np.bincount(key[turn > 2 * MIN_CORNER_TURN] // n, minlength=int(plane.max()) + 1)
    triangle = corners == 3
    if not triangle.any():
        return None
    return np.unique(np.where(triangle[plane], m + plane, np.arange(m)), return_inverse=True)[1]


def measure_component_extents(surface: Submesh, of: IntArray) -> FloatArray:
    """Return the extent of each component; `of` is the component of each face."""
    if not of.any():
        return np.full(1, measure_extent(surface.V))
    order = np.argsort(of, kind="stable")
    faces = Ragged(np.searchsorted(of[order], np.arange(int(of.max()) + 2)))
    corner = np.ascontiguousarray(surface.V.T)[:, surface.F[order].T]
    return np.asarray((faces.max(corner.max(axis=1)) - faces.min(corner.min(axis=1))).max(axis=0))


def find_apexes(bent: FloatArray, ends: IntArray, on_sharp: BoolArray, on_soft: BoolArray) -> BoolArray:
    """Return a mask of the vertices that are tips, such as the apex of a cone, and not on sharp creases.

    On a coarse sphere, all vertices are equally curved and on soft creases. Therefore a vertex on a soft
    crease is a tip only if its curvature is much larger than that of adjacent vertices. `bent` is the
    absolute curvature of each vertex, and `ends` are the vertices of each edge.
    """
    tip = (bent > constants.TIP_CURVATURE) & ~on_sharp
    unsure = tip & on_soft
    if unsure.any():
        a, b = np.concatenate((ends, ends[:, ::-1])).T
        rows = np.flatnonzero(unsure[a] & ~on_sharp[b])
        around = np.zeros(len(bent))
        np.maximum.at(around, a[rows], bent[b[rows]])
        tip &= ~on_soft | (bent >= TIP_PROMINENCE * around)
    return np.asarray(tip)
