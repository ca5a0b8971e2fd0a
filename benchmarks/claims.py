"""What the promises of docs/promises.md amount to in figures. Prints Markdown.

    python benchmarks/claims.py cuts [--seeds 120]    closed models cut along trees: how many maps flip
    python benchmarks/claims.py starts                the guarantee from several starts: F/3nt of its maps
    python benchmarks/claims.py solvers               how far the maps of two solvers lie apart

The meshes are the cortex and those of IGL_LINABF_MESHES.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from pathlib import Path

import numpy as np
from meshes import brain, shared

from igl_linabf import FallbackWarning, LinABF, MeshWarning, flatten, quality
from igl_linabf.flattening import Flattening
from igl_linabf.layouts import injective
from igl_linabf.linalg import Solvers
from igl_linabf.plot import fit
from igl_linabf.surface import centred, complex_positions, planar_mesh

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from conftest import tree_cut

LEAVES = (2, 3, 4, 5)


def cuts(seeds: int) -> None:
    """Each closed model without handles cut along trees of random leaves."""
    print(f"{seeds} trees for each number of leaves, their leaves random vertices. Each cell: how many maps")
    print('have flipped triangles (and how many after `guarantee="injective"`); the seeds.\n')
    print(f"| model | triangles | {' | '.join(f'{n} leaves' for n in LEAVES)} |")
    print(f"|{'---|' * (2 + len(LEAVES))}")
    for name, V, F in shared("closed"):
        if len(V) - len(F) // 2 != 2:
            continue
        cells = []
        for leaves in LEAVES:
            bad, left = [], 0
            for seed in range(seeds):
                surface = tree_cut(V, F, leaves, seed)
                if len(flatten(*surface).flipped):
                    bad.append(seed)
                    left += bool(len(flatten(*surface, LinABF(guarantee="injective")).flipped))
            cells.append(f"{len(bad)} ({left}): {', '.join(map(str, bad))}" if bad else "0")
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


def starts() -> None:
    """The last attempt from maps that are no good, on meshes of several kinds."""
    print("Least and largest F/3nt of the guarantee's map over ten starts: igl.lscm, one linear step, ABF,")
    print("a mirror image, a line, and five of random positions. Flips: over all of them.\n")
    print("| mesh | triangles | F/3nt from | to | apart | flips |")
    print("|---|---|---|---|---|---|")
    for name, V, F in [*shared("stress"), *shared("holes"), *_small_disks()]:
        if len(F) > 12_000:
            continue
        mesh = planar_mesh(V, F)
        maps = [flatten(V, F, method).uv for method in ("lscm", LinABF(iterations=1), "abf")]
        rng = np.random.default_rng(0)
        maps += [maps[1] * [1, -1], maps[1] * [1, 0]]
        maps += [rng.normal(size=maps[0].shape) for _ in range(5)]
        distortion, flips = [], 0
        for uv in maps:
            made = injective(
                mesh, complex_positions(uv), lambda z, m=mesh: centred(m.topology, z, m.area), Solvers()
            )
            measured = quality(V, F, np.column_stack((made.z.real, made.z.imag)))
            distortion.append(measured.angle_distortion)
            flips += measured.flips
        low, high = min(distortion), max(distortion)
        print(
            f"| {name} | {len(F):,} | {low:.4g} | {high:.4g} | {100 * (high / low - 1):.1f} % | {flips} |",
            flush=True,
        )


def _small_disks() -> list:
    return [mesh for mesh in shared("disk") if len(mesh[2]) < 4_000]


def solvers() -> None:
    """The default map and the others', at the default tolerances and at 1e-10."""
    print("Largest distance of a vertex from its place in the default map, over the map's larger side, after")
    print("the best similarity: with CHOLMOD, and by one factor of the whole system.\n")
    print("| mesh | triangles | default: cholmod | direct | rtol=1e-10: cholmod | direct |")
    print("|---|---|---|---|---|---|")
    for name, V, F in [brain(), *shared("disk"), *shared("stress")]:
        if name == "flipfree_deer":
            continue  # its map is beyond double precision
        cells = []
        for rtol in (None, 1e-10):
            options = {} if rtol is None else {"rtol": rtol}
            first = _map(V, F, "auto", options)
            for solver in ("cholmod", "direct"):
                other = fit(_map(V, F, solver, options).uv, first.uv)
                far = np.linalg.norm(other - first.uv, axis=1).max() / np.ptp(first.uv, axis=0).max()
                cells.append(f"{far:.1e}")
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


def _map(V: np.ndarray, F: np.ndarray, solver: str, options: dict) -> Flattening:
    return flatten(V, F, LinABF(solver=solver, **options))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=["cuts", "starts", "solvers"])
    parser.add_argument("--seeds", type=int, default=120)
    options = parser.parse_args()
    warnings.simplefilter("ignore", FallbackWarning)
    warnings.simplefilter("ignore", MeshWarning)
    if options.what == "cuts":
        cuts(options.seeds)
    else:
        {"starts": starts, "solvers": solvers}[options.what]()


if __name__ == "__main__":
    main()
