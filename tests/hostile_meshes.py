"""Numbered hostile cases (random disks, corrupted and damaged meshes), and checks of each.

Each function `check_...` returns the outcome of a case in a few words, and raises `BrokenError` if a promise
is broken.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from fractions import Fraction

import igl
import numpy as np
from bad_input import tetrahedron, torus
from carried import load_pyvista_mesh
from nasty_meshes import NASTY, concatenate_surfaces
from scipy.spatial import Delaunay

import igl_linabf as il
from igl_linabf.flattening import METHODS, Status
from igl_linabf.linalg import has_cholmod
from igl_linabf.surface import Submesh

Surface = tuple[np.ndarray, np.ndarray]


class BrokenError(AssertionError):
    """Error for a broken promise of the package."""


@dataclass(frozen=True)
class Disk:
    """The parameters of a lifted planar Delaunay triangulation.

    Attributes
    ----------
    n : int
        Approximate number of vertices.
    relief : float
        Height of the random waves over the unit square.
    noise : float
        Height of white noise, which makes a spike at each vertex.
    holes, slivers : int
        Number of removed vertex stars, and number of vertices moved almost onto an opposite edge.
    thin : int
        The moved vertices keep 10^-thin of their distance from the opposite edge.
    scale : int
        All coordinates are multiplied by 10^scale.
    seed : int
    """

    n: int = 40
    relief: float = 0.5
    noise: float = 0.0
    holes: int = 0
    slivers: int = 0
    thin: int = 4
    scale: int = 0
    seed: int = 0

    @classmethod
    def random(cls, rng: np.random.Generator, most: int = 250) -> Disk:
        """Return random parameters; properties that make a disk harder are rarer."""
        often = rng.random(5)
        return cls(
            n=int(np.exp(rng.uniform(np.log(4), np.log(most)))),
            relief=float(rng.choice([0, 0.2, 0.5, 1, 2])),
            noise=float(rng.choice([0.03, 0.1, 0.3])) if often[0] < 0.4 else 0.0,
            holes=int(rng.integers(1, 4)) if often[1] < 0.3 else 0,
            slivers=int(rng.integers(1, 4)) if often[2] < 0.3 else 0,
            thin=int(rng.integers(2, 17)),
            scale=int(rng.integers(-200, 201)) if often[3] < 0.1 else 0,
            seed=int(rng.integers(2**32)),
        )

    def build(self) -> Surface:
        """Return the vertices and faces of the disk."""
        rng = np.random.default_rng(self.seed)
        xy = rng.random((max(self.n, 4), 2))
        F = Delaunay(xy).simplices.astype(np.int64)
        turned = _twice_area(xy, F) < 0
        F[turned] = F[turned][:, [0, 2, 1]]
        waves = rng.normal(size=(4, 2)) * 5
        z = self.relief * np.sin(xy @ waves.T + rng.uniform(0, 6, 4)).sum(axis=1) / 4
        z += self.noise * rng.normal(size=len(xy))
        V = np.column_stack((xy, z))
        F = _cut_holes(F, len(V), self.holes, rng)
        for t in rng.choice(len(F), min(self.slivers, len(F)), replace=False):
            i, j, k = rng.permutation(F[t])
            V[i] = (V[j] + V[k]) / 2 + 10.0**-self.thin * (V[i] - (V[j] + V[k]) / 2)
        used = np.unique(F)
        names = rng.permutation(len(used))
        number = np.full(len(V), -1)
        number[used] = names
        placed = np.empty((len(used), 3))
        placed[names] = V[used]
        F = number[rng.permutation(F)]
        start = rng.integers(3, size=len(F))[:, None]
        F = np.take_along_axis(F, (np.arange(3) + start) % 3, axis=1)
        return placed * 10.0**self.scale, F


def _twice_area(xy: np.ndarray, F: np.ndarray) -> np.ndarray:
    a, b, c = xy[F].swapaxes(0, 1)
    u, v = b - a, c - a
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def _cut_holes(F: np.ndarray, n: int, holes: int, rng: np.random.Generator) -> np.ndarray:
    """Remove the stars of disjoint vertices that are away from the boundary."""
    edges = np.sort(F[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edge, count = np.unique(edges, axis=0, return_counts=True)
    taken = np.zeros(n, dtype=bool)
    taken[edge[count == 1]] = True
    for i in rng.permutation(n):
        star = (i == F).any(axis=1)
        if holes and star.any() and not taken[F[star]].any():
            taken[F[star]] = True
            F = F[~star]
            holes -= 1
    return F


def find_flipped_exactly(uv: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Return the faces whose signed area in the map is not positive, in rational arithmetic."""
    rows = [[Fraction(x) for x in row] if np.isfinite(row).all() else None for row in uv.tolist()]
    flipped = []
    for t, (i, j, k) in enumerate(F.tolist()):
        a, b, c = rows[i], rows[j], rows[k]
        if (b[0] - a[0]) * (c[1] - a[1]) <= (b[1] - a[1]) * (c[0] - a[0]):
            flipped.append(t)
    return np.array(flipped, dtype=int)


PLACE = re.compile(
    # indices of elements of the mesh, or rows and lines of a file
    r"\b(faces?|vertex|vertices|edges?|chart|row|line) \[?-?\d"
    r"|^(igl-linabf: )?(V|F|uv|angles|b|bc|outer|pins?) (has|have|is|are|holds?) "  # an argument
    r"|^(igl-linabf: (warning: )?)?the (mesh is closed|mesh has \d|map has an L2)"  # the whole mesh or map
    r"|\S\.(obj|off|ply|stl)\b"  # a file name
    r"|: it is left out$"  # another program, which `compare` runs on the whole mesh
    r"|: the whole system is factored instead$"  # a fallback of the linear solver, which concerns all faces
)


def has_place(message: str) -> bool:
    """Return True if a message names indices of faces, vertices or lines, an argument, or a file."""
    return bool(PLACE.search(message))


def require(holds: bool, what: str) -> None:
    if not holds:
        raise BrokenError(what)


def check_flattened(V: np.ndarray, F: np.ndarray, result: il.flattening.Flattening) -> str:
    """Check the properties of any result."""
    uv, used = result.uv, np.unique(F)
    require(uv.shape == (len(V), 2), f"uv has the shape {uv.shape}")
    require(bool(np.isfinite(uv[used]).all()), f"NaN in a result called {result.outcome.value}")
    require(bool(np.isnan(np.delete(uv, used, axis=0)).all()), "numbers at vertices of no face")
    flipped = find_flipped_exactly(uv, F)
    listed = result.flipped.tolist()
    require(
        listed == flipped.tolist(), f"called {result.outcome.value}, flipped {listed}, not {flipped.tolist()}"
    )
    # invalid target angles are reported even if the map has no flips
    outcomes = il.flattening.Outcome
    good = not len(flipped) and result.outcome not in (outcomes.ANGLES_INVALID, outcomes.OVERLAPPING)
    require(result.outcome.good == good, f"called {result.outcome.value}: {result.message}")
    named = result.outcome.good or result.outcome is outcomes.OVERLAPPING or has_place(result.message)
    require(named, f"no place in {result.message!r}")
    angles = result.angles
    require(bool(np.isfinite(angles).all()), "angles are NaN")
    if result.outcome is not il.flattening.Outcome.ANGLES_INVALID:
        require(bool((angles >= 0).all() and (angles <= np.pi).all()), "angles outside [0, pi]")
        missing = float(np.abs(angles.sum(axis=1) - np.pi).max())
        reported = result.after.triangle
        require(
            missing <= reported + 1e-12,
            f"angles miss a sum of pi by {missing:.1e}, but {reported:.1e} is reported",
        )
    measured = il.quality(V, F, uv)
    require(measured.flips == len(flipped), f"quality counts {measured.flips} flips of {len(flipped)}")
    require_numbers(measured)
    return result.outcome.value


def require_numbers(measured: il.measures.Quality) -> None:
    """Require that no figure of a `Quality` is NaN."""
    figures = asdict(measured)
    figures |= figures.pop("report")
    for name, value in figures.items():
        require(value is None or not np.isnan(value), f"quality's {name} is NaN")


def run_refusable(work: Callable[[], str]) -> str:
    """Return the outcome of `work`, or that the input was refused; the error must name a place and advice."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", il.OutcomeWarning)
        warnings.simplefilter("ignore", il.FallbackWarning)
        warnings.simplefilter("ignore", il.MeshWarning)  # reports that angles near pi are repaired
        try:
            return work()
        except il.MeshError as error:
            require(has_place(str(error)), f"no place in {str(error)!r}")
            require(": " in str(error), f"no advice in {str(error)!r}")
            return (
                "refused: "
                + re.split(r"[0-9(:]", re.sub(r"faces [\d, .]+(\(\d+ in all\) )?", "faces ", str(error)))[
                    0
                ].strip()
            )


def check_disk(disk: Disk, method: str | il.LinABF = "linabf", **where: object) -> str:
    V, F = disk.build()
    return run_refusable(lambda: check_flattened(V, F, il.flatten(V, F, method=method, **where)))


def check_guarantee(seed: int) -> str:
    """Check that the guarantee leaves no flips in exact arithmetic, and does not change maps without flips.

    The disks are spiky, and the methods have fewer fallbacks than by default, so that maps flip.
    """
    disk = Disk.random(np.random.default_rng(seed), 120)
    V, F = replace(disk, noise=(0.0, 1.0, 4.0)[seed % 3]).build()
    methods = (il.LinABF(iterations=1), il.LinABF(), il.ABF())
    method = methods[(0, 0, 0, 0, 1, 1, 1, 2)[seed // 3 % 8]]

    def work() -> str:
        bare, sure = (
            il.flatten(V, F, method=method),
            il.flatten(V, F, method=replace(method, guarantee="injective")),
        )
        end = check_flattened(V, F, sure)
        if not len(bare.flipped):
            require(bool((bare.uv == sure.uv).all()), "the guarantee changed a map without flips")
            return end
        last = sure.report.attempts[-1]
        require(last.name == "injective", f"the guarantee was not tried: {last}")
        if len(find_flipped_exactly(sure.uv, F)):
            require(last.status is Status.NO_VALID_START, f"the guarantee left flips: {last}")
            return "no start"
        return f"{end} by the guarantee"

    return run_refusable(work)


def check_unwrap(disk: Disk) -> str:
    """Check the atlas of a disk; a disk without holes is first closed by a mirrored copy."""
    V, F = disk.build()

    def work() -> str:
        atlas = il.unwrap(V, F)
        require(bool(np.isfinite(atlas.TC).all()), "TC is NaN")
        require(bool((atlas.TC >= 0).all() and (atlas.TC <= 1).all()), "TC outside the square")
        check_atlas(V, F, atlas)
        if not atlas.report.repairs:
            require(bool((atlas.origin[atlas.FTC] == F).all()), "FTC does not match F")
        cleaned = il.clean(V, F)
        solid = atlas.FTC[cleaned.faces]
        oriented = np.where(cleaned.turned[:, None], solid[:, [0, 2, 1]], solid)
        flipped = find_flipped_exactly(atlas.TC, oriented)
        if atlas.good:
            require(not len(flipped), f"called good, but faces {flipped.tolist()} are flipped")
            require(len(il.overlaps(atlas.TC, solid)) == 0, "called good, with overlaps")
        return f"{'good' if atlas.good else 'not good'}"

    if not disk.holes:
        V, F = close_with_copy(V, F)
    return run_refusable(work)


def close_with_copy(V: np.ndarray, F: np.ndarray) -> Surface:
    """Return a closed surface: the disk, and a copy below it, joined along the boundary."""
    loop = igl.boundary_loop(F)
    n = len(V)
    other = np.arange(n) + n
    other[loop] = loop
    extent = np.ptp(V, axis=0).max()
    below = V - [0, 0, 0.5 * extent]
    V, F = np.vstack((V, below)), np.vstack((F, other[F][:, ::-1]))
    used = np.unique(F)
    number = np.full(len(V), -1)
    number[used] = np.arange(len(used))
    return V[used], number[F]


def _set(rows: np.ndarray, i: object, value: object) -> np.ndarray:
    rows = rows.copy()
    rows[i] = value
    return rows


def make_corrupted_meshes(
    V: np.ndarray, F: np.ndarray, rng: np.random.Generator
) -> dict[str, tuple[object, object]]:
    """Return an example of each kind of bad input, with the fault at a random place."""
    n, m = len(V), len(F)
    i, t, k = int(rng.integers(n)), int(rng.integers(m)), int(rng.integers(3))
    sides = np.sort(F[:, :2], axis=1) @ [n, 1]
    others = np.sort(F[:, [[1, 2], [2, 0]]], axis=2) @ [n, 1]
    inner = np.flatnonzero((sides[:, None] == np.append(sides, others)).sum(axis=1) > 1)
    f = int(rng.choice(inner)) if len(inner) else t
    point = V.mean(axis=0) + 3 * np.ptp(V, axis=0) + np.vstack((np.zeros(3), np.eye(3)[1:]))
    return {
        "NaN": (_set(V, (i, k), np.nan), F),
        "infinite": (_set(V, (i, k), -np.inf), F),
        "too large for squares": (_set(V, (i, k), 1e200), F),
        "index too large": (V, _set(F, (t, k), n + int(rng.integers(5)))),
        "index huge": (V, _set(F, (t, k), 2**62 + i)),
        "index negative": (V, _set(F, (t, k), -1 - i)),
        "indices from 1": (V, F + 1),
        "vertex twice": (V, _set(F, (t, k), F[t, (k + 1) % 3])),
        "two vertices in one place": (_set(V, F[t, k], V[F[t, (k + 1) % 3]]), F),
        "collinear": (_set(V, F[t, k], 0.25 * V[F[t, (k + 1) % 3]] + 0.75 * V[F[t, (k + 2) % 3]]), F),
        "all in one point": (np.ones_like(V) * rng.normal(), F),
        "on a line": (np.outer(rng.random(n), [1.0, 2, 3]), F),
        "opposite orientation": (V, _set(F, f, F[f][::-1])),
        "face twice": (V, np.insert(F, int(rng.integers(m)), np.roll(F[t], k), axis=0)),
        "non-manifold edge": (np.vstack((V, point[:1])), np.vstack((F, [*F[f][:2], n], [*F[f][1::-1], n]))),
        "bowtie": (np.vstack((V, point[:2])), np.vstack((F, [F[t, k], n, n + 1]))),
        "bowtie of a closed fan": (
            np.vstack((V, point)),
            np.vstack((F, np.array([F[t, k], n, n + 1, n + 2])[tetrahedron()])),
        ),
        "two components": (np.vstack((V, V + 9)), np.vstack((F, F + n))),
        "closed": close_with_copy(V, F),
        "handle": torus(1 + int(rng.integers(3))),
        "no faces": (V, F[:0]),
        "no vertices": (V[:0], F),
        "flat V": (V.ravel(), F),
        "V in 2-D": (V[:, :2], F),
        "quads": (V, F[:, [0, 1, 2, 0]]),
        "text": (V.astype(str), F),
        "fractional F": (V, F + _set(np.zeros(F.shape), (t, k), 0.5)),
        "NaN in F": (V, _set(F.astype(float), (t, k), np.nan)),
        "boolean F": (V, F > 0),
        "complex V": (V + 0j, F),
        "objects": (V.astype(object), _set(F.astype(object), (t, k), None)),
        "ragged": (V, [*F.tolist()[1:], [0, 1]]),
    }


CORRUPTIONS = tuple(make_corrupted_meshes(*Disk().build(), np.random.default_rng(0)))


def check_corrupted(seed: int) -> str:
    """Check that all methods refuse a corrupted mesh."""
    rng = np.random.default_rng(seed)
    kind, method = CORRUPTIONS[seed % len(CORRUPTIONS)], str(rng.choice(list(METHODS)))
    V, F = make_corrupted_meshes(*Disk(n=int(rng.integers(5, 60)), seed=seed).build(), rng)[kind]
    if kind in REPAIRABLE:
        check_atlas(V, F, il.unwrap(V, F, progress=False))
    ends = [run_refusable(lambda: check_flattened(V, F, il.flatten(V, F, method=method)))]
    if kind not in VALID_FOR_UNWRAP:
        ends.append(run_refusable(lambda: str(il.unwrap(V, F, strict=kind in REPAIRABLE))))
    for end in ends:
        require(end.startswith("refused"), f"a mesh with {kind} ended as {end}")
    return "refused"


VALID_FOR_UNWRAP = {"two components", "closed", "handle", "quads"}
REPAIRABLE = {
    "too large for squares",
    "vertex twice",
    "two vertices in one place",
    "collinear",
    "all in one point",
    "on a line",
    "opposite orientation",
    "face twice",
    "non-manifold edge",
    "bowtie",
    "bowtie of a closed fan",
}


def check_atlas(V: np.ndarray, F: np.ndarray, atlas: il.Atlas) -> None:
    """Check the properties of the atlas of any triangles."""
    TC, FTC = atlas.TC, atlas.FTC
    require(FTC.shape == F.shape, f"FTC has the shape {FTC.shape}")
    require(bool(np.isfinite(TC).all()), "TC is NaN")
    require(bool((TC >= 0).all() and (TC <= 1).all()), "TC outside the square")
    require(bool((FTC >= 0).all() and (len(TC) > FTC).all()), "a corner has no texture")
    clean = np.concatenate([chart.faces for chart in atlas.charts] or [[]]).astype(int)
    require(len(np.unique(clean)) == len(clean), "a face is in two charts")
    labels = [np.full(len(chart.faces), i) for i, chart in enumerate(atlas.charts)]
    require(bool((atlas.chart[clean] == np.concatenate(labels or [[]])).all()), "a face is in another chart")
    if atlas.good and len(clean):
        solid = FTC[clean]
        flat = (FTC[clean] == FTC[clean][:, [1, 2, 0]]).any(axis=1)
        require(not flat.any(), "a face of a chart has a texture corner twice")
        require(len(il.overlaps(TC, solid)) == 0, "called good, with overlaps")
        require(atlas.quality.flips == 0, "called good, with flips")
    omitted = np.delete(FTC, clean, axis=0)
    collapsed = (omitted == omitted[:, [1, 2, 0]]).any(axis=1)
    require(bool(collapsed.all()), "an omitted face has an area")


def check_any(seed: int) -> str:
    """Check that all finite triangles are unwrapped: disks, spheres and tori with several kinds of damage."""
    rng = np.random.default_rng(seed)
    kind = int(rng.integers(4))
    if kind == 0:
        n = int(rng.integers(3, 20))
        V, F = rng.random((n, 3)), rng.integers(n, size=(int(rng.integers(1, 60)), 3))
    elif kind == 1:
        V, F = torus(int(rng.integers(3)))
    else:
        V, F = replace(Disk.random(rng, 60), scale=0).build()
        V, F = close_with_copy(V, F) if kind == 3 and len(igl.boundary_loop_all(F)) == 1 else (V, F)
    return _check_unwrap(V, F, rng, int(rng.integers(4)))


def check_nasty(seed: int) -> str:
    """Check the atlas of one or two nasty or real meshes, with damage and unused vertices that are NaN."""
    rng = np.random.default_rng(seed)
    parts = [_nasty_or_real(rng) for _ in range(int(rng.integers(1, 3)))]
    size = [max(float(np.ptp(V[np.unique(F)], axis=0).max()), 1e-9) for V, F in parts]
    V, F = concatenate_surfaces(*((V / s, F) for (V, F), s in zip(parts, size, strict=True)))
    V[~np.isfinite(V)] = 0
    V, F = damage(V, F, rng) if rng.random() < 0.5 else (V, F)
    V = np.clip(V, -1e300, 1e300)
    order = rng.permutation(len(V) + 3)
    place = np.argsort(order)
    V = np.vstack((V, np.full((3, 3), np.nan)))[order]
    return _check_unwrap(V, place[F], rng, 0)


def _nasty_or_real(rng: np.random.Generator) -> Surface:
    if rng.random() < 0.7:
        return NASTY[sorted(NASTY)[int(rng.integers(len(NASTY)))]]()
    name = str(rng.choice(["airplane", "ant", "nut"]))
    V, F = load_pyvista_mesh(name)
    if rng.random() < 0.5:  # keep only an open part of the mesh
        F = F[(V[F].mean(axis=1) @ rng.normal(size=3)) < 0]
    return (V, F) if len(F) else (V, np.array([[0, 1, 2]]))


def _check_unwrap(V: np.ndarray, F: np.ndarray, rng: np.random.Generator, damages: int) -> str:
    """Damage a mesh further, unwrap it, and check the atlas and the result of `clean`."""
    for _ in range(damages):
        with np.errstate(over="ignore"):
            V, F = damage(V, F, rng)
        V = np.clip(V, -1e300, 1e300)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", il.MeshWarning)
        warnings.simplefilter("ignore", il.OutcomeWarning)
        warnings.simplefilter("ignore", il.FallbackWarning)
        again = il.clean(V, F)
        atlas = il.unwrap(V, F, progress=False)
    check_atlas(V, F, atlas)
    if len(again.F):
        Submesh.manifold_from_input(again.V, again.F)
    return "good" if atlas.good else "not good"


def damage(V: np.ndarray, F: np.ndarray, rng: np.random.Generator) -> Surface:
    """Apply one random kind of damage to part of a mesh."""
    n, m = len(V), len(F)
    some = rng.random(m) < rng.choice([0.02, 0.1, 0.5])
    few = rng.choice(n, max(1, n // 10))
    how = int(rng.integers(14))
    V = V.copy()
    if how == 0:
        return V, np.where(some[:, None], F[:, ::-1], F)
    if how == 1:
        return V, np.vstack((F, F[some]))
    if how == 2:
        return V, np.vstack((F, F[some][:, ::-1]))
    if how == 3:
        return V[F].reshape(-1, 3), np.arange(F.size).reshape(-1, 3)
    if how == 4:
        V[few] = V[rng.choice(n, len(few))]
        return V, F
    if how == 5:  # merge vertices
        name = np.arange(n)
        name[few] = rng.choice(n, len(few))
        return V, name[F]
    if how == 6:  # move vertices to the opposite edge
        for i, j, k in F[some]:
            V[i] = V[j] * 0.75 + V[k] * 0.25
        return V, F
    if how == 7:  # round to a grid, which makes faces collinear
        return np.round(V * 3) / 3, F
    if how == 8:
        return np.vstack((V, rng.random((3, 3)))), np.vstack((F, rng.integers(n + 3, size=(5, 3))))
    if how == 9:
        return V * 10.0 ** rng.integers(-300, 300), F
    if how == 10:
        return V + 10.0 ** rng.integers(0, 16), F
    if how == 11:
        V[few] *= 10.0 ** rng.integers(-100, 100)
        return V, F
    if how == 12:
        return np.vstack((V, V)), np.vstack((F, F + n))
    return (V, F[~some]) if not some.all() else (V, F)


def check_method(seed: int) -> str:
    methods = ("lscm", "scp", "dncp", "one-step-abf++")
    return check_disk(Disk.random(np.random.default_rng(seed)), methods[seed % 4])


def check_options(seed: int) -> str:
    """Check linear ABF with random options and pins."""
    rng = np.random.default_rng(seed)
    disk = Disk.random(rng)
    V, _ = disk.build()
    options: dict[str, object] = {
        "iterations": int(rng.integers(1, 6)),
        "layout": str(rng.choice(["boundary", "least-squares", "greedy"])),
        "solver": str(rng.choice(["auto", "direct", *["cholmod"] * has_cholmod()])),
        "safeguard": False,
        "threshold": float(rng.choice([0, 0.1, 10])),
        "rtol": float(rng.choice([1e-10, 1e-3, 0.5])),
        "tol": float(rng.choice([1e-12, 1e-3])),
        "guarantee": "injective",
        "outer": int(rng.integers(len(V))),
    }
    chosen = {name: value for name, value in options.items() if rng.random() < 0.3}
    where = {"outer": chosen.pop("outer")} if "outer" in chosen else {}
    if rng.random() < 0.3:
        where |= {"b": rng.choice(len(V), 2, replace=False), "bc": rng.normal(size=(2, 2))}
    return check_disk(disk, il.LinABF(**chosen), **where)


def check_dtypes(seed: int) -> str:
    """Check that dtype, order and strides of the arrays do not change a single bit of the map."""
    rng = np.random.default_rng(seed)
    V, F = replace(Disk.random(rng), scale=0).build()
    V = V.astype(np.float32).astype(float)
    index = str(rng.choice([">i4", "u2", "u8", "f8", "i8"]))
    others = (
        (np.asfortranarray(V), np.asfortranarray(F)),
        (V.astype(np.float32), F.astype(index)),
        (V.astype(">f8"), F.astype(index)),
        (np.repeat(V, 2, axis=1)[:, ::2], np.repeat(F, 2, axis=0)[::2]),
        (V.tolist(), F.tolist()),
        (V.astype(np.longdouble), np.ascontiguousarray(F[::-1])[::-1]),
    )
    other_V, other_F = others[int(rng.integers(len(others)))]
    V.setflags(write=False)
    F.setflags(write=False)

    def work() -> str:
        uv = il.flatten(V, F).uv
        require(bool((il.flatten(other_V, other_F).uv == uv).all()), "another map")
        return "the same"

    return run_refusable(work)


def check_map(seed: int) -> str:
    """Check `quality`, `overlaps`, `layout` and `cut` on bad maps."""
    rng = np.random.default_rng(seed)
    V, F = replace(Disk.random(rng, 60), scale=0).build()
    uv = V[:, :2] + rng.choice([0, 0.01, 1]) * rng.normal(size=(len(V), 2))
    uv = uv * 10.0 ** int(rng.choice([0, 0, 0, 0, -200, 60, 150, 300]))
    spoilt = rng.choice(["", "", "NaN", "inf", "one point", "a line", "two in one place"])
    i, j = rng.choice(len(V), 2, replace=False)
    if spoilt in ("NaN", "inf"):
        uv[i, int(rng.integers(2))] = float(spoilt)
    elif spoilt == "one point":
        uv[:] = uv[i]
    elif spoilt == "a line":
        uv[:, 1] = uv[:, 0]
    elif spoilt:
        uv[i] = uv[j]
    angles = rng.dirichlet([3, 3, 3], size=len(F)) * np.pi
    sides = F[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    seams = sides[rng.random(len(sides)) < rng.choice([0, 0.1, 0.5, 1])]

    def check_figures() -> str:
        q = il.quality(V, F, uv)
        require_numbers(q)
        require(spoilt not in ("NaN", "inf"), f"quality of {spoilt}")
        pairs = il.overlaps(uv, F)
        require(bool((pairs[:, 0] < pairs[:, 1]).all()), "overlaps are not i < j")
        scaled = np.ldexp(uv, -np.frexp(np.abs(uv).max())[1] - 40)
        require(pairs.tolist() == il.overlaps(scaled, F).tolist(), "overlaps depend on the scale")
        require(str(q) == str(il.quality(V, F, scaled)), "quality depends on the scale")
        return "measured"

    def check_layout() -> str:
        require(bool(np.isfinite(il.layouts.layout(F, angles)).all()), "layout is NaN")
        return ""

    def check_cut() -> str:
        new_V, new_F, origin = il.cut(V, F, seams)
        require(bool((new_V == V[origin]).all() and (origin[new_F] == F).all()), "cut is another surface")
        il.unwrap(V, F, seams)
        return ""

    run_refusable(check_layout)
    run_refusable(check_cut)
    return run_refusable(check_figures)
