"""Compare `xatlas.parametrize` with the same call of `igl_linabf.xatlas`: time, memory and the atlas.

    python benchmarks/xatlas_calls.py [--limit 900] [--size 40k ...] [--by xatlas ...]

The meshes are generated (benchmarks/generated.py, blob, noise 0.02). In the last mesh, patches of faces are
doubled with the opposite orientation, as the output of generative models often is; about a quarter of its
edges have three or four faces. Each call runs in a separate process, which is stopped after `--limit`
seconds. CPU seconds count all threads. Stretch does not count flipped faces. xatlas is included if it is
installed. Prints Markdown.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from time import perf_counter, process_time

import igl
import numpy as np
from generated import generate_mesh, measure_peak_memory
from peers import TexelAtlas, relative_seams, unmirror

from igl_linabf import overlaps, quality

# points of the grid along an axis, and the share of faces that are doubled
MESHES = {"40k": (82, 0.0), "150k": (147, 0.0), "400k": (220, 0.0), "455k": (213, 0.24)}
PROGRAMS = {"igl_linabf": "igl_linabf.xatlas", "xatlas": "xatlas"}
PATCH = 0.08  # size of the doubled patches; the body has a width of 2
HEADS = ("s", "CPU s", "MB", "charts", "seam / sqrt(area)", "L2 stretch", "flips", "overlaps")


def double_patches(V: np.ndarray, F: np.ndarray, share: float) -> np.ndarray:
    """Return the faces, and a share of them again with the opposite orientation, in patches."""
    centre = V[F].mean(axis=1)
    wave = np.sin(centre / PATCH).sum(axis=1)
    return np.concatenate((F, F[wave > np.quantile(wave, 1 - share)][:, ::-1]))


def crowded_share(F: np.ndarray) -> float:
    """Return the share of the edges with more than two faces."""
    edges = np.sort(np.concatenate((F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]])), axis=1)
    return float((np.unique(edges, axis=0, return_counts=True)[1] > 2).mean())


def measure_call(program: str, path: str) -> dict[str, float]:
    """Return the figures of one call, in the order of `HEADS`."""
    mesh = np.load(path)
    V, F = mesh["V"], mesh["F"]
    xatlas = importlib.import_module(PROGRAMS[program])
    xatlas.parametrize(*igl.icosahedron())  # a warm-up for lazy imports
    start, cpu = perf_counter(), process_time()
    vmapping, indices, uvs = xatlas.parametrize(V, F)
    seconds, cpu = perf_counter() - start, process_time() - cpu
    peak = measure_peak_memory()
    assert (vmapping[indices] == F).all()
    origin, FTC = vmapping.astype(np.int64), indices.astype(np.int64)
    TC, charts, flipped = unmirror(TexelAtlas(origin, FTC, uvs.astype(float), 1.0, seconds))
    seams, stretch = relative_seams(V, F, FTC), quality(V[origin], FTC[~flipped], TC).stretch_l2
    flips, over = np.count_nonzero(flipped), len(overlaps(uvs, FTC))
    figures = seconds, cpu, peak, charts, seams, stretch, flips, over
    return dict(zip(HEADS, map(float, figures), strict=True))


def format_line(triangles: str, program: str, row: dict[str, float]) -> str:
    kinds = (",.1f", ",.1f", ",.0f", ",.0f", ".1f", ".3f", ",.0f", ",.0f")
    cells = [format(row[head], kind) for head, kind in zip(HEADS, kinds, strict=True)]
    return f"| {triangles} | {program} | {' | '.join(cells)} |"


def main() -> None:
    installed = [program for program, module in PROGRAMS.items() if find_spec(module)]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--limit", type=float, default=900, help="seconds after which a call is stopped")
    parser.add_argument("--size", nargs="+", choices=MESHES, default=list(MESHES))
    parser.add_argument("--by", nargs="+", choices=installed, default=installed)
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure_call(*options.one)))
        return
    print(f"| triangles | by | {' | '.join(HEADS)} |\n|{'---|' * (2 + len(HEADS))}")
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "mesh.npz")
        for size in options.size:
            points, share = MESHES[size]
            V, F = generate_mesh("blob", points, 0.02, 1)
            F = double_patches(V, F, share)
            crowded = f", {crowded_share(F):.0%} of the edges non-manifold" * bool(share)
            np.savez(path, V=V, F=F)
            for program in options.by:
                command = [sys.executable, __file__, "--one", program, path]
                try:
                    done = subprocess.run(
                        command, capture_output=True, encoding="utf-8", check=True, timeout=options.limit
                    )
                except subprocess.TimeoutExpired:
                    empty = " |" * (len(HEADS) - 1)
                    print(
                        f"| {len(F):,}{crowded} | {program} | more than {options.limit:g} |{empty}",
                        flush=True,
                    )
                    continue
                row = json.loads(done.stdout.splitlines()[-1])
                print(format_line(f"{len(F):,}{crowded}", program, row), flush=True)


if __name__ == "__main__":
    main()
