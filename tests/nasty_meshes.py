"""Thirty-one defective meshes of the kinds that exporters, scanners and games produce. Many are not manifold.

`NASTY[name]()` returns V and F. All vertices that faces refer to are finite.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import igl
import numpy as np

Surface = tuple[np.ndarray, np.ndarray]

NASTY: dict[str, Callable[[], Surface]] = {}
CUBE = np.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)], dtype=float)
QUADS = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])


def register_nasty(make: Callable[[], Surface]) -> Callable[[], Surface]:
    """Register a function in `NASTY` under its name with spaces."""
    NASTY[make.__name__.replace("_", " ")] = make
    return make


def triangles(quads: np.ndarray) -> np.ndarray:
    """Split each quadrangle into two triangles."""
    return np.concatenate((quads[:, :3], quads[:, [0, 2, 3]]))


def sphere(times: int = 2) -> Surface:
    V, F = igl.upsample(*igl.icosahedron(), times)
    return V / np.linalg.norm(V, axis=1)[:, None], F.astype(np.int64)


def sheet(n: int = 8, m: int = 8) -> Surface:
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    V = np.column_stack((i, j, 0.3 * np.sin(i) * np.cos(j))).astype(float)
    a = np.flatnonzero((i < n - 1) & (j < m - 1))
    return V, triangles(np.column_stack((a, a + m, a + m + 1, a + 1)))


def concatenate_surfaces(*parts: Surface) -> Surface:
    """Return several surfaces as one mesh."""
    starts = np.cumsum([0, *(len(V) for V, _ in parts)])
    return np.vstack([V for V, _ in parts]), np.vstack(
        [F + s for (_, F), s in zip(parts, starts, strict=False)]
    )


def merge_equal_vertices(V: np.ndarray, F: np.ndarray) -> Surface:
    """Merge vertices with equal positions."""
    V, index = np.unique(np.round(V, 9), axis=0, return_inverse=True)
    return V, index.ravel()[F]


def soup(V: np.ndarray, F: np.ndarray) -> Surface:
    """Give each face its own vertices."""
    return V[F].reshape(-1, 3), np.arange(F.size).reshape(-1, 3)


def band(n: int, width: int, turns: int) -> Surface:
    """Return a closed band with `turns` half twists."""
    t, s = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(width), indexing="ij"))
    angle, half = 2 * np.pi * t / n, np.pi * turns * t / n
    off = 0.8 * (s / (width - 1) - 0.5)
    r = 2 + off * np.cos(half)
    V = np.column_stack((r * np.cos(angle), r * np.sin(angle), off * np.sin(half)))

    def at(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        return i % n * width + np.where((i // n * turns) % 2 == 1, width - 1 - j, j)

    i, j = t[s < width - 1], s[s < width - 1]
    return V, triangles(np.column_stack((at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1))))


def voxels(filled: np.ndarray) -> Surface:
    """Return the faces between filled and empty cells, including edges of four faces and bowties."""
    cells = np.argwhere(filled)
    offsets = np.array([[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]])
    full = np.pad(filled, 1)
    corners = [
        (CUBE[quad] + cell)[[0, 1, 2, 0, 2, 3]]
        for quad, offset in zip(QUADS, offsets, strict=True)
        for cell in cells
        if not full[tuple(cell + offset + 1)]
    ]
    return merge_equal_vertices(np.concatenate(corners), np.arange(6 * len(corners)).reshape(-1, 3))


@register_nasty
def soup_of_triangles() -> Surface:
    return soup(*sphere())


@register_nasty
def soup_of_quadrangles() -> Surface:
    return CUBE[QUADS].reshape(-1, 3), triangles(np.arange(24).reshape(-1, 4))


@register_nasty
def three_sheets_at_an_edge() -> Surface:
    """Return a bent sheet, and another sheet that stands on its line y = 4."""
    V, F = sheet()
    V[:, 2] = 0.3 * np.sin(V[:, 0])
    other = V[:, [0, 2, 1]] * [1, 0, 1] + [0, 4, 0]
    other[:, 2] += V[:, 2]
    return merge_equal_vertices(*concatenate_surfaces((V, F), (other, F)))


@register_nasty
def eight_pages_of_a_book() -> Surface:
    angle = np.arange(8) * np.pi / 4
    V = np.vstack(([[0, 0, 0], [0, 0, 1]], *([[np.cos(a), np.sin(a), z] for z in (0, 1)] for a in angle)))
    return V, np.concatenate([triangles(np.array([[0, 2 + 2 * i, 3 + 2 * i, 1]])) for i in range(8)])


@register_nasty
def two_cubes_at_an_edge() -> Surface:
    return merge_equal_vertices(
        *concatenate_surfaces((CUBE, triangles(QUADS)), (CUBE + np.array([1, 1, 0]), triangles(QUADS)))
    )


@register_nasty
def two_rooms_and_a_wall() -> Surface:
    V, F = merge_equal_vertices(
        *concatenate_surfaces((CUBE, triangles(QUADS)), (CUBE + np.array([1, 0, 0]), triangles(QUADS)))
    )
    return V, F[np.unique(np.sort(F, axis=1), axis=0, return_index=True)[1]]


@register_nasty
def voxels_at_random() -> Surface:
    return voxels(np.random.default_rng(1).random((6, 6, 6)) < 0.4)


@register_nasty
def two_cones_tip_to_tip() -> Surface:
    V, F = igl.upsample(*igl.icosahedron(), 1)
    tip = int(np.argmax(V[:, 2]))
    other = 2 * V[tip] - V
    return merge_equal_vertices(*concatenate_surfaces((V, F), (other, F[:, ::-1])))


@register_nasty
def a_chessboard() -> Surface:
    V, F = sheet(9, 9)
    middle = V[F].mean(axis=1)[:, :2].astype(int)
    return V, F[middle.sum(axis=1) % 2 == 0]


@register_nasty
def a_sphere_with_its_poles_pinched() -> Surface:
    V, F = sphere()
    low, high = int(np.argmin(V[:, 2])), int(np.argmax(V[:, 2]))
    return V, np.where(low == F, high, F)


@register_nasty
def one_face_turned() -> Surface:
    V, F = sphere()
    F[7] = F[7, ::-1]
    return V, F


@register_nasty
def faces_turned_at_random() -> Surface:
    V, F = sphere()
    turned = np.random.default_rng(0).random(len(F)) < 0.5
    return V, np.where(turned[:, None], F[:, ::-1], F)


@register_nasty
def a_one_sided_band() -> Surface:
    return band(40, 5, 1)


@register_nasty
def a_bottle_without_an_inside() -> Surface:
    n, m = 24, 12
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    u, v = 2 * np.pi * i / n, 2 * np.pi * j / m
    r = 3 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    z = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)

    def at(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        return i % n * m + np.where(i >= n, -j, j) % m

    F = triangles(np.column_stack((at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1))))
    return np.column_stack((r * np.cos(u), r * np.sin(u), z)), F


@register_nasty
def a_projective_plane() -> Surface:
    V, F = igl.icosahedron()
    same = [int(np.argmin(np.linalg.norm(V + v, axis=1))) for v in V]  # the opposite vertex
    F = np.minimum(F, np.array(same)[F])
    return V * [1, 0.9, 0.8] + 0.1, F[np.unique(np.sort(F, axis=1), axis=0, return_index=True)[1]]


@register_nasty
def every_face_twice() -> Surface:
    V, F = sphere()
    return V, np.vstack((F, F))


@register_nasty
def a_leaf_of_two_sides() -> Surface:
    V, F = sheet()
    return V, np.vstack((F, F[:, ::-1]))


@register_nasty
def a_bush_of_crossed_cards() -> Surface:
    card = np.array([[-1, 0, 0], [1, 0, 0], [1, 0, 2], [-1, 0, 2]], dtype=float)
    cards = [(card @ [[c, s, 0], [-s, c, 0], [0, 0, 1]] + [k, 0, 0], np.array([[0, 1, 2], [0, 2, 3]]))
             for k in range(20) for c, s in ((1, 0), (0, 1))]  # fmt: skip
    V, F = concatenate_surfaces(*cards)
    return V, np.vstack((F, F[:, ::-1]))


@register_nasty
def faces_with_a_vertex_twice() -> Surface:
    V, F = sphere()
    return V, np.vstack((F, F[:5, [0, 1, 1]], F[3:4, [0, 0, 0]]))


@register_nasty
def a_side_of_no_length() -> Surface:
    V, F = sphere()
    V[F[0, 0]] = V[F[0, 1]]
    return V, F


@register_nasty
def t_junctions_filled_with_caps() -> Surface:
    """Return a cube with 5 points along one side of each diagonal, joined to it by flat triangles."""
    V, F = CUBE, triangles(QUADS)
    points, faces = [V], []
    for a, b, c in F[6:].tolist():  # a - b is the diagonal of a square
        n = sum(map(len, points))
        t = np.linspace(0, 1, 7)[1:-1, None]
        points.append(V[a] * (1 - t) + V[b] * t)
        row = [a, *range(n, n + 5), b]
        faces += [[i, j, c] for i, j in pairwise(row)]
        faces += [[a, j, i] for i, j in pairwise(row[1:])]
    return np.vstack(points), np.vstack((F[:6], faces))


@register_nasty
def a_body_whose_faces_without_area_were_removed() -> Surface:
    V, F = sphere(3)
    return V, F[1:]


@register_nasty
def nan_at_vertices_of_no_face() -> Surface:
    V, F = sphere()
    return np.vstack(([[np.nan, 0, np.inf]], V)), F + 1


@register_nasty
def a_piece_on_a_line() -> Surface:
    V, F = sphere(1)
    line = np.outer(np.arange(5.0), [1, 2, 3]) + 3
    return concatenate_surfaces((V, F), (line, np.array([[0, 1, 2], [1, 2, 3], [2, 3, 4]])))


@register_nasty
def all_on_a_line() -> Surface:
    return np.outer(np.arange(5.0), [1, 2, 3]), np.array([[0, 1, 2], [1, 2, 3], [2, 3, 4]])


@register_nasty
def coordinates_of_1e200() -> Surface:
    V, F = sphere()
    return V * 1e200, F


@register_nasty
def far_from_the_origin_in_single_precision() -> Surface:
    V, F = sphere(3)
    return (V * 10 + [0, 1e7, 0]).astype(np.float32).astype(float), F


@register_nasty
def bodies_through_each_other() -> Surface:
    V, F = sphere()
    return concatenate_surfaces((V, F), (V + np.array([0.5, 0, 0]), F), (V[:, ::-1] * 0.5, F))


@register_nasty
def a_pillow_of_two_triangles() -> Surface:
    return np.eye(3), np.array([[0, 1, 2], [2, 1, 0]])


@register_nasty
def a_thousand_loose_triangles() -> Surface:
    V = np.random.default_rng(0).random((3000, 3))
    return V, np.arange(3000).reshape(-1, 3)


@register_nasty
def indices_at_random() -> Surface:
    rng = np.random.default_rng(0)
    return rng.random((30, 3)), rng.integers(30, size=(300, 3))
