"""Atlases of any surfaces: distortion, seams and time, beside xatlas.

    python benchmarks/unwrap.py

The meshes are the bunny and those of the kinds closed, handles and multi in IGL_LINABF_MESHES. xatlas is
added if it is installed. Prints Markdown.
"""

from __future__ import annotations

import warnings
from importlib.util import find_spec
from time import perf_counter

import numpy as np
from meshes import shared, stanford

from igl_linabf import OutcomeWarning, flatten, quality, texture_seams, unwrap


def seam_length(V: np.ndarray, F: np.ndarray, FTC: np.ndarray) -> float:
    """Seam length of texture coordinates, relative to the diagonal of the bounding box."""
    a, b = V[texture_seams(F, FTC).T]
    return float(np.linalg.norm(a - b, axis=1).sum() / np.linalg.norm(np.ptp(V, axis=0)))


def lscm_on(V: np.ndarray, F: np.ndarray, FTC: np.ndarray, origin: np.ndarray) -> str:
    """F/3nt and flips of igl.lscm on the charts of an atlas."""
    total, flips = 0.0, 0
    _, chart = np.unique(components(FTC), return_inverse=True)
    for i in range(chart.max() + 1):
        used, own = np.unique(FTC[chart == i], return_inverse=True)
        own, points = own.reshape(-1, 3), V[origin[used]]
        q = quality(points, own, flatten(points, own, "lscm").uv)
        total += q.angle_distortion * len(own)
        flips += q.flips
    return f"{total / len(F):.3g}, {flips}"


def components(FTC: np.ndarray) -> np.ndarray:
    """The chart of each face."""
    from igl_linabf.surface import face_components

    return face_components(FTC, int(FTC.max()) + 1)


def by_xatlas(V: np.ndarray, F: np.ndarray) -> str:
    """Charts, seam length and F/3nt of xatlas."""
    import xatlas

    start = perf_counter()
    origin, FTC, TC = xatlas.parametrize(V, F)
    seconds = perf_counter() - start
    FTC = FTC.astype(np.int64)
    q = quality(V[origin], FTC, TC.astype(float))
    charts = len(np.unique(components(FTC)))
    return f"{charts} | {seam_length(V, F, FTC):.2f} | {q.angle_distortion:.3g} | {seconds:.1f}"


def main() -> None:
    warnings.simplefilter("ignore", OutcomeWarning)
    print("Seams: length over the diagonal of the bounding box. s: seconds. igl.lscm: F/3nt, flips.\n")
    heads = "mesh | triangles | charts | splits | overlaps | seams | F/3nt | L2 stretch | flips | s"
    other = " | igl.lscm, same cut"
    if find_spec("xatlas"):
        other += " | xatlas: charts | seams | F/3nt | s"
    print(f"| {heads}{other} |\n|{'---|' * (heads + other).count('|')}---|")
    for name, V, F in [stanford(), *shared("closed", "handles", "multi")]:
        start = perf_counter()
        atlas = unwrap(V, F)
        seconds = perf_counter() - start
        q = atlas.quality
        cells = [name, f"{len(F):,}", str(len(atlas.charts)), str(atlas.splits), str(q.overlaps)]
        cells += [f"{seam_length(V, F, atlas.FTC):.2f}", f"{q.angle_distortion:.3g}", f"{q.stretch_l2:.4g}"]
        cells += [str(q.flips), f"{seconds:.1f}", lscm_on(V, F, atlas.FTC, atlas.origin)]
        if find_spec("xatlas"):
            cells.append(by_xatlas(V, F))
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
