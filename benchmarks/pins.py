"""How much another pair of pins changes the least-squares map, up to the best similarity.

    python benchmarks/pins.py

For each disk, ten other pairs of boundary vertices are pinned. Printed are the root mean square and the
largest distance to the default map, relative to the map's size, of the worst pair; and the range of
F/3nt. After one step the target angles are not quite those of a flat mesh, so the pins matter a
little. After convergence they do not.
"""

from __future__ import annotations

import igl
import numpy as np
from meshes import brain, shared

from igl_linabf import LinABF, flatten, layout, quality
from igl_linabf.plot import fit


def spread(V: np.ndarray, F: np.ndarray, iterations: int) -> tuple[float, float, float, float]:
    """Largest rms and largest maximal distance, and the range of F/3nt, over all pairs of pins."""
    angles = flatten(V, F, LinABF(iterations=iterations)).angles
    default = layout(F, angles, method="least-squares")
    size = np.ptp(default, axis=0).max()
    loop = np.array(igl.boundary_loop(F))
    rng = np.random.default_rng(0)
    rms, far, distortion = [], [], [quality(V, F, default).angle_distortion]
    for _ in range(10):
        b = rng.choice(loop, 2, replace=False)
        other = fit(layout(F, angles, b, [[0, 0], [1, 0]], method="least-squares"), default)
        distance = np.linalg.norm(other - default, axis=1) / size
        rms.append(np.sqrt((distance**2).mean()))
        far.append(distance.max())
        distortion.append(quality(V, F, other).angle_distortion)
    return max(rms), max(far), min(distortion), max(distortion)


def main() -> None:
    print("| mesh | one step: rms | largest | F/3nt | converged: rms | largest | F/3nt |")
    print("|---|---|---|---|---|---|---|")
    for name, V, F in [brain(), *shared("disk")]:
        cells = []
        for iterations in (1, 12):
            rms, far, low, high = spread(V, F, iterations)
            cells.append(f"{rms:.1e} | {far:.1e} | {low:.3e} to {high:.3e}")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
