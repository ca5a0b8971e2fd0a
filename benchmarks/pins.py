"""Measure how much the least-squares map depends on the pair of pins, up to the best similarity.

    python benchmarks/pins.py

For each disk, ten other pairs of boundary vertices are pinned. The table has the root mean square distance
and the largest distance from the default map for the worst pair, relative to the size of the map, and the
range of F/3nt. After one step, the target angles do not fit together exactly in the plane, so the pins have a
small effect. After convergence, they have none.
"""

from __future__ import annotations

import igl
import numpy as np
from meshes import brain, load_shared_meshes

from igl_linabf import LinABF, flatten, quality
from igl_linabf.layouts import layout
from igl_linabf.plot import fit


def spread(V: np.ndarray, F: np.ndarray, iterations: int) -> tuple[float, float, float, float]:
    """Return the largest rms and maximum distance from the default map, and the range of F/3nt."""
    angles = flatten(V, F, method=LinABF(iterations=iterations)).angles
    default = layout(F, angles, method="least-squares")
    size = np.ptp(default, axis=0).max()
    loop = np.array(igl.boundary_loop(F))
    rng = np.random.default_rng(0)
    rms, largest, distortion = [], [], [quality(V, F, default).angle_distortion]
    for _ in range(10):
        b = rng.choice(loop, 2, replace=False)
        other = fit(layout(F, angles, b, [[0, 0], [1, 0]], method="least-squares"), default)
        distance = np.linalg.norm(other - default, axis=1) / size
        rms.append(np.sqrt((distance**2).mean()))
        largest.append(distance.max())
        distortion.append(quality(V, F, other).angle_distortion)
    return max(rms), max(largest), min(distortion), max(distortion)


def main() -> None:
    print("| mesh | one step: rms | largest | F/3nt | converged: rms | largest | F/3nt |")
    print("|---|---|---|---|---|---|---|")
    for name, V, F in [brain(), *load_shared_meshes("disk")]:
        cells = []
        for iterations in (1, 12):
            rms, largest, low, high = spread(V, F, iterations)
            cells.append(f"{rms:.1e} | {largest:.1e} | {low:.3e} to {high:.3e}")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
