"""Boundaries to order beside a free one: F/3nt, L2 stretch, flips, solves, and time over the free map.

    python benchmarks/boundaries.py [--repeat 3]

The meshes are the cortex and those of the kinds disk, flat2d and stress in IGL_LINABF_MESHES; for circles
of holes, the crown and those of kind `holes` with up to 20,000 triangles. Their chords are split, since
ears cannot be straight. Prints Markdown.
"""

from __future__ import annotations

import argparse
import warnings
from functools import partial

import numpy as np
from meshes import brain, crown, shared

from igl_linabf import FallbackWarning, Flattening, OutcomeWarning, flatten, quality, split_chords
from igl_linabf.flattening import medians
from igl_linabf.surface import planar

FREE = "free"
MOST = 20_000  # triangles of a mesh with holes


def off(result: Flattening, loop: np.ndarray) -> float:
    """How far the loop is from the circle or the upright rectangle, over its size."""
    z = result.uv[loop]
    if len(result.corners):
        low, high = (end(result.uv[result.corners], axis=0) for end in (np.min, np.max))
        beside = np.minimum(np.abs(z - low), np.abs(z - high)).min(axis=1)
        return float(beside.max() / np.linalg.norm(high - low))
    centre = np.linalg.lstsq(np.column_stack((z, np.ones(len(z)))), (z**2).sum(axis=1), rcond=None)[0][:2] / 2
    radius = np.linalg.norm(z - centre, axis=1)
    return float(np.ptp(radius) / radius.mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    warnings.simplefilter("ignore", OutcomeWarning)
    warnings.simplefilter("ignore", FallbackWarning)
    print("Each cell: F/3nt, L2 stretch, flips; solves (conjugate gradient steps), distance of the boundary")
    print("from the shape over its size, **time over the free map**.\n")
    print("| mesh | triangles | free | circle | rectangle |")
    print("|---|---|---|---|---|")
    for name, V, F in [brain(), *shared("disk", "flat2d", "stress")]:
        row(name, *split_chords(V, F), (FREE, "circle", "rectangle"), options.repeat)
    print("\n| with holes | triangles | free | circle | circles |")
    print("|---|---|---|---|---|")
    for name, V, F in [crown(), *(mesh for mesh in shared("holes") if len(mesh[2]) <= MOST)]:
        row(name, *split_chords(V, F), (FREE, "circle", "circles"), options.repeat)


def row(name: str, V: np.ndarray, F: np.ndarray, shapes: tuple[str, ...], repeat: int) -> None:
    mesh, cells = planar(V, F), []
    results = {shape: flatten(V, F, boundary=shape, progress=False) for shape in shapes}
    calls = [partial(flatten, V, F, boundary=shape, progress=False) for shape in shapes]
    times = dict(zip(shapes, medians(calls, repeat), strict=True))
    for shape, result in results.items():
        q = quality(V, F, result.uv)
        cell = f"{q.angle_distortion:.3g}, {q.stretch_l2:.3g}, {q.flips}; "
        cell += f"{result.iterations} ({result.inner_steps})"
        if shape != FREE:
            loops = mesh.topology.loops[: None if shape == "circles" else 1]
            worst = max(off(result, mesh.vertices[loop]) for loop in loops)
            cell += f", {worst:.0e}, **{times[shape] / times[FREE]:.1f}**"
        cells.append(cell)
    print(f"| {name} | {len(F):,} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
