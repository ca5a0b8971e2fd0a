"""Print the figures behind the promises of docs/promises.md, as Markdown.

    python benchmarks/claims.py cuts [--seeds 120]    number of flipped maps of closed models cut along trees
    python benchmarks/claims.py starts                F/3nt of the guarantee from several starting maps
    python benchmarks/claims.py solvers               distance between the maps of different solvers

The meshes are the cortex and the meshes in IGL_LINABF_MESHES.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from pathlib import Path

import numpy as np
from meshes import brain, load_shared_meshes

from igl_linabf import FallbackWarning, LinABF, MeshWarning, flatten, quality
from igl_linabf.flattening import Flattening
from igl_linabf.layouts import make_injective
from igl_linabf.linalg import Solvers
from igl_linabf.plot import fit
from igl_linabf.surface import complex_positions, normalize_placement, planar_mesh

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from conftest import tree_cut

LEAVES = (2, 3, 4, 5)


def print_cuts(seeds: int) -> None:
    """Print how many maps have flipped triangles if closed models are cut along trees with random leaves."""
    print(
        f"Each model is cut along {seeds} trees for each number of leaves, with random vertices as leaves.\n"
        "Each cell contains the number of maps with flipped triangles (in parentheses: after\n"
        '`guarantee="injective"`), and the random seeds of their trees.\n'
    )
    print(f"| model | triangles | {' | '.join(f'{n} leaves' for n in LEAVES)} |")
    print(f"|{'---|' * (2 + len(LEAVES))}")
    for name, V, F in load_shared_meshes("closed"):
        if len(V) - len(F) // 2 != 2:
            continue
        cells = []
        for leaves in LEAVES:
            flipping_seeds, remaining = [], 0
            for seed in range(seeds):
                surface = tree_cut(V, F, leaves, seed)
                if len(flatten(*surface).flipped):
                    flipping_seeds.append(seed)
                    remaining += bool(len(flatten(*surface, method=LinABF(guarantee="injective")).flipped))
            cells.append(
                f"{len(flipping_seeds)} ({remaining}): {', '.join(map(str, flipping_seeds))}"
                if flipping_seeds
                else "0"
            )
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


def print_starts() -> None:
    """Print the distortion after the last fallback, for several starting maps."""
    print(
        'The table lists the smallest and the largest F/3nt of the maps by `guarantee="injective"` over\n'
        "ten starting maps: igl.lscm, one linear step, ABF, a mirror image, a line, and five random maps.\n"
        "The column flips is the sum over all starting maps.\n"
    )
    print("| mesh | triangles | F/3nt from | to | apart | flips |")
    print("|---|---|---|---|---|---|")
    for name, V, F in [*load_shared_meshes("stress"), *load_shared_meshes("holes"), *_small_disks()]:
        if len(F) > 12_000:
            continue
        mesh = planar_mesh(V, F)
        maps = [flatten(V, F, method=method).uv for method in ("lscm", LinABF(iterations=1), "abf")]
        rng = np.random.default_rng(0)
        maps += [maps[1] * [1, -1], maps[1] * [1, 0]]
        maps += [rng.normal(size=maps[0].shape) for _ in range(5)]
        distortion, flips = [], 0
        for uv in maps:
            result = make_injective(
                mesh,
                complex_positions(uv),
                lambda z, m=mesh: normalize_placement(m.topology, z, m.area),
                Solvers(),
            )
            measured = quality(V, F, np.column_stack((result.z.real, result.z.imag)))
            distortion.append(measured.angle_distortion)
            flips += measured.flips
        low, high = min(distortion), max(distortion)
        print(
            f"| {name} | {len(F):,} | {low:.4g} | {high:.4g} | {100 * (high / low - 1):.1f} % | {flips} |",
            flush=True,
        )


def _small_disks() -> list:
    return [mesh for mesh in load_shared_meshes("disk") if len(mesh[2]) < 4_000]


def print_solvers() -> None:
    """Print the distance of the maps of other solvers from the default map, at two tolerances."""
    print(
        "Each cell is the largest distance of a vertex from its position in the default map, after the\n"
        "best similarity, relative to the larger side of the map. The solvers are CHOLMOD and a\n"
        "factorisation of the whole system.\n"
    )
    print("| mesh | triangles | default: cholmod | direct | rtol=1e-10: cholmod | direct |")
    print("|---|---|---|---|---|---|")
    for name, V, F in [brain(), *load_shared_meshes("disk"), *load_shared_meshes("stress")]:
        if name == "flipfree_deer":
            continue  # the map of the mesh deer exceeds the range of double precision
        cells = []
        for rtol in (None, 1e-10):
            options = {} if rtol is None else {"rtol": rtol}
            first = _flatten(V, F, "auto", options)
            for solver in ("cholmod", "direct"):
                other = fit(_flatten(V, F, solver, options).uv, first.uv)
                distance = np.linalg.norm(other - first.uv, axis=1).max() / np.ptp(first.uv, axis=0).max()
                cells.append(f"{distance:.1e}")
        print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


def _flatten(V: np.ndarray, F: np.ndarray, solver: str, options: dict) -> Flattening:
    return flatten(V, F, method=LinABF(solver=solver, **options))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=["cuts", "starts", "solvers"])
    parser.add_argument("--seeds", type=int, default=120)
    options = parser.parse_args()
    warnings.simplefilter("ignore", FallbackWarning)
    warnings.simplefilter("ignore", MeshWarning)
    if options.what == "cuts":
        print_cuts(options.seeds)
    else:
        {"starts": print_starts, "solvers": print_solvers}[options.what]()


if __name__ == "__main__":
    main()
