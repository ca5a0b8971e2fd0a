"""Generated bodies with creases; a net flattens most of them exactly."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import igl
import numpy as np
from nasty_meshes import CUBE, QUADS, Surface, triangles, voxels

UP = np.array([0.0, 0.0, 1.0])


def box(x: float, y: float, z: float, times: int = 0) -> Surface:
    V, F = CUBE * [x, y, z], triangles(QUADS)
    return igl.upsample(V, F, times) if times else (V, F)


def extrude(outline: np.ndarray, caps: np.ndarray, height: float, times: int = 0) -> Surface:
    """Extrude an anticlockwise planar outline with a given triangulation to a solid."""
    n = len(outline)
    low = np.column_stack((outline, np.zeros(n)))
    i = np.arange(n)
    j = (i + 1) % n
    sides = triangles(np.column_stack((i, j, j + n, i + n)))
    V, F = np.vstack((low, low + UP * height)), np.vstack((caps[:, ::-1], caps + n, sides))
    return igl.upsample(V, F, times) if times else (V, F)


def prism(n: int, height: float, times: int = 0) -> Surface:
    """Return a prism of n sides; each end is a fan of slivers around one corner."""
    angle = 2 * np.pi * np.arange(n) / n
    caps = np.column_stack((np.zeros(n - 2), np.arange(1, n - 1), np.arange(2, n))).astype(np.int64)
    return extrude(np.column_stack((np.cos(angle), np.sin(angle))), caps, height, times)


def pipe(holes: Sequence[tuple[float, float, float]], around: int = 72, rows: int = 45) -> Surface:
    """Return an open pipe of radius 1 and height 4; `holes` are angles, heights and radii of round holes."""
    angle, height = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(0, 4, rows))
    V = np.column_stack((np.cos(angle).ravel(), np.sin(angle).ravel(), height.ravel()))
    i, j = (index.ravel() for index in np.meshgrid(np.arange(around), np.arange(rows - 1)))
    a, b = j * around + i, j * around + (i + 1) % around
    F = np.concatenate((np.column_stack((a, b, b + around)), np.column_stack((a, b + around, a + around))))
    middle = V[F].mean(axis=1)
    turn = np.angle(middle[:, 0] + 1j * middle[:, 1])
    for at, z, radius in holes:
        away = np.hypot(np.angle(np.exp(1j * (turn - at))), middle[:, 2] - z) > radius
        F, turn, middle = F[away], turn[away], middle[away]
    V, F = igl.remove_unreferenced(V, F)[:2]
    return V, F


def angle_solid(height: float, times: int = 0) -> Surface:
    """Return a solid in the shape of the letter L."""
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], dtype=float)
    return extrude(outline, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]), height, times)


def cone(n: int, height: float) -> Surface:
    angle = 2 * np.pi * np.arange(n) / n
    V = np.vstack((np.column_stack((np.cos(angle), np.sin(angle), 0 * angle)), [[0, 0, height], [0, 0, 0]]))
    i = np.arange(n)
    j = (i + 1) % n
    full = np.full(n, n)
    return V, np.vstack((np.column_stack((i, j, full)), np.column_stack((j, i, full + 1))))


def pencil(n: int, height: float, tip: float) -> Surface:
    """Return a cylinder with a cone on top; both meet in a blunt crease."""
    (V, F), (_, top) = prism(n, height), cone(n, 1)
    apex = np.array([[0, 0, height + tip]])
    lid = (n <= F).all(axis=1)
    return np.vstack((V, apex)), np.vstack((F[~lid], np.where(top[:n] == n, 2 * n, top[:n] + n)))


def rock(roughness: float, times: int = 0) -> Surface:
    """Return an ellipsoid of few triangles, smooth at the bottom and rough at the top."""
    V, F = igl.upsample(*igl.icosahedron(), 2)
    V = V / np.linalg.norm(V, axis=1)[:, None]
    out = roughness * np.random.default_rng(0).random(len(V)) * np.clip(V[:, 2] + 0.6, 0, 1)
    V = V * (1 + out)[:, None] * [1, 1, 1.7]
    return igl.upsample(V, F, times) if times else (V, F)


def plate_with_holes(n: int = 6) -> Surface:
    """Return a closed plate of genus n with n bores, whose planes consist of slivers."""
    import shapely

    around = 2 * np.pi * np.arange(24) / 24
    rings = [0.4 * np.column_stack((np.cos(around), np.sin(around))) + [k, 0] for k in range(n)]
    frame = np.array([[-1, -1], [n, -1], [n, 1], [-1, 1]], dtype=float)
    outline = np.vstack((frame, *rings))
    cap = shapely.constrained_delaunay_triangles(shapely.Polygon(frame, rings)).geoms
    corners = np.array([shapely.get_coordinates(shapely.orient_polygons(t))[:3] for t in cap])
    F = np.linalg.norm(corners[:, :, None] - outline, axis=-1).argmin(axis=-1)
    m = len(outline)
    loops = [
        np.arange(4),
        *(4 + 24 * k + np.arange(24)[::-1] for k in range(n)),
    ]  # the solid is to the left of each loop
    sides = [triangles(np.column_stack((a, np.roll(a, -1), np.roll(a, -1) + m, a + m))) for a in loops]
    low = np.column_stack((outline, np.zeros(m)))
    return np.vstack((low, low + UP / 2)), np.vstack((F[:, ::-1], F + m, *sides))


def rounded_box(x: float, y: float, z: float, radius: float, steps: int = 8) -> Surface:
    """Return a box with fillets of 2 `steps` strips along its edges, and eighths of a ball at its corners."""
    half, V, F = np.array([x, y, z]) / 2, list[np.ndarray](), list[np.ndarray]()
    corner, number = np.linspace(0, radius, steps + 1), 2 * steps + 2
    along = [np.append(corner - h, h - corner[::-1]) for h in half]
    index = np.arange(number * number).reshape(number, number)
    quads = np.stack((index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]), axis=-1).reshape(-1, 4)
    for axis in range(3):
        for sign in (-1, 1):
            side = np.full((number, number, 3), sign * half[axis])
            side[..., (axis + 1) % 3], side[..., (axis + 2) % 3] = np.meshgrid(
                along[(axis + 1) % 3], along[(axis + 2) % 3], indexing="ij"
            )
            F.append(triangles(quads[:, ::sign]) + sum(map(len, V)))
            V.append(side.reshape(-1, 3))
    points = np.concatenate(V)
    inner = np.clip(points, radius - half, half - radius)
    out = points - inner
    points = inner + radius * out / np.linalg.norm(out, axis=1)[:, None]
    _, first, at = np.unique(points.round(9), axis=0, return_index=True, return_inverse=True)
    return points[first], at.ravel()[np.concatenate(F)]


def rounded_plate(radius: float, steps: int = 6, around: int = 96) -> Surface:
    """Return an oblong plate with round ends, a bore, and fillets along all rims."""
    angle = 2 * np.pi * (np.arange(around) + 0.5) / around
    ways = np.column_stack((np.cos(angle), np.sin(angle)))
    outside, inside = ways + np.sign(ways[:, :1]) * [2, 0], 0.5 * ways
    turn = np.pi / 2 * np.arange(steps + 1) / steps
    across, high = radius * np.append(np.sin(turn), np.cos(turn)), np.append(np.cos(turn), -np.sin(turn))
    high = radius * high + np.repeat([0.5 - radius, radius - 0.5], steps + 1)
    rows = [
        np.column_stack((outside + ways * (a - radius), np.full(around, h)))
        for a, h in zip(across, high, strict=True)
    ]
    rows += [
        np.column_stack((inside - ways * (a - radius), np.full(around, h)))
        for a, h in zip(across[::-1], high[::-1], strict=True)
    ]
    index = np.arange(around * len(rows)).reshape(len(rows), around)
    after, below = np.roll(index, -1, axis=1), np.roll(index, -1, axis=0)
    quads = np.stack((index, below, np.roll(below, -1, axis=1), after), axis=-1)
    return np.concatenate(rows), triangles(quads.reshape(-1, 4))


DEVELOPABLE: dict[str, Callable[[], Surface]] = {
    "cuboid": lambda: box(1, 1, 2),
    "cuboid, fine": lambda: box(1, 1, 2, 3),
    "cube": lambda: box(1, 1, 1, 4),
    "cone of few sides": lambda: cone(16, 1),
    "pencil": lambda: pencil(24, 8, 3),
    "plank": lambda: box(1, 1, 40),
    "plate": lambda: box(10, 10, 0.1, 3),
    "prism": lambda: prism(3, 3, 2),
    "L": lambda: angle_solid(1, 2),
    "tall L": lambda: angle_solid(5),
    "cylinder": lambda: prism(32, 3),
    "disk with a rim": lambda: prism(48, 0.3),
    "cone": lambda: cone(32, 2),
    "plate with holes": plate_with_holes,
}

ROUNDED: dict[str, Callable[[], Surface]] = {
    "rounded box": lambda: rounded_box(4, 3, 2, 0.2),
    "rounded sheet": lambda: rounded_box(10, 6, 0.5, 0.2),
    "rounded plate": lambda: rounded_plate(0.1),
    "rounded plate, finer": lambda: rounded_plate(0.15, 10, 240),
}


def surface_of_revolution(profile: np.ndarray, around: int = 48) -> Surface:
    """Return the closed surface of revolution of a closed profile (#P, 2) of radii and heights."""
    angle, n = 2 * np.pi * np.arange(around) / around, len(profile)
    across = [np.outer(way(angle), profile[:, 0]) for way in (np.cos, np.sin)]
    V = np.stack((*across, np.tile(profile[:, 1], (around, 1))), axis=-1)
    index = np.arange(around * n).reshape(around, n)
    after, below = np.roll(index, -1, axis=1), np.roll(index, -1, axis=0)
    return V.reshape(-1, 3), triangles(
        np.stack((index, below, np.roll(below, -1, axis=1), after), -1).reshape(-1, 4)
    )


def washer(bevel: float) -> Surface:
    """Return a flat ring with chamfers along its four rims."""
    r, t, b = (1.0, 2.5), 0.4, bevel
    profile = [
        (r[0] + b, t),
        (r[0], t - b),
        (r[0], b),
        (r[0] + b, 0),
        (r[1] - b, 0),
        (r[1], b),
        (r[1], t - b),
        (r[1] - b, t),
    ]
    return surface_of_revolution(np.array(profile))


def bevelled_disk(bevel: float, around: int = 48) -> Surface:
    """Return a disk with a chamfer along its upper rim; fans of triangles are its planes."""
    angle = 2 * np.pi * np.arange(around) / around
    way = np.column_stack((np.cos(angle), np.sin(angle)))
    rings = [(1.0, 0.0), (1.0, 0.3 - bevel), (1.0 - bevel, 0.3)]
    rows = [np.column_stack((r * way, np.full(around, h))) for r, h in rings]
    i, n = np.arange(around), 3 * around
    j = (i + 1) % around
    walls = [triangles(np.column_stack((i, j, j + around, i + around))) + k * around for k in range(2)]
    fans = (
        np.column_stack((j, i, np.full(around, n))),
        np.column_stack((i + 2 * around, j + 2 * around, np.full(around, n + 1))),
    )
    return np.vstack((*rows, [[0, 0, 0], [0, 0, 0.3]])), np.vstack((*walls, *fans))


def blocks(cells: np.ndarray, times: int = 1) -> Surface:
    """Return the boundary of solid cells of a grid, (nx, ny, nz) bool."""

    return igl.upsample(*voxels(cells), times)


def table() -> Surface:
    """Return a table with four legs, which has two mirror planes."""
    cells = np.zeros((9, 6, 6), dtype=bool)
    cells[:, :, 5] = True
    for x in (0, 8):
        for y in (0, 5):
            cells[x, y] = True
    return blocks(cells)


def robot() -> Surface:
    """Return a body with two legs, two arms and a head, which has a mirror plane."""
    cells = np.zeros((9, 3, 12), dtype=bool)
    cells[2:7, :, 4:9] = True
    cells[2:4, :, :4] = cells[5:7, :, :4] = True
    cells[:2, 1, 7:9] = cells[7:, 1, 7:9] = cells[0, 1, 3:9] = cells[8, 1, 3:9] = True
    cells[3:6, :, 10:] = cells[4, 1, 9] = True
    return blocks(cells)


def cabinet() -> Surface:
    """Return a box with rounded, slightly noisy edges, as in meshes from generative models."""
    V, F = rounded_box(3, 2, 4, 0.15, 3)
    noise = np.random.default_rng(0).normal(size=V.shape)
    return V + 0.004 * noise, F


def bar() -> Surface:
    """Return an oblong bar."""
    return box(6, 1, 1, 2)


def bracket() -> Surface:
    """Return a channel with a wide base."""
    cells = np.zeros((8, 6, 4), dtype=bool)
    cells[:, :, 0] = cells[:2] = cells[-2:] = True
    return blocks(cells)


MACHINED: dict[str, Callable[[], Surface]] = {
    "washer": lambda: washer(0.05),
    "bevelled disk": lambda: bevelled_disk(0.08),
    "low prism": lambda: prism(32, 0.6),
    "table": table,
    "robot": robot,
    "cabinet": cabinet,
    "bar": bar,
    "bracket": bracket,
}
