"""Flatten a patch with autoflatten, and measure maps by autoflatten's distances.

    python benchmarks/autoflatten_peer.py PATCH SURFACE MAPS.npz OUT.npz [run]

benchmarks/cortex.py runs this script. MAPS.npz contains V and F of the patch and maps of its vertices. The
script writes OUT.npz: for each map, the mean error of distances divided by the mean distance, at the scale of
the map and at the scale with the smallest error. With `run`, it also writes the map of autoflatten and its
time in seconds.
"""

from __future__ import annotations

import sys
from time import perf_counter

import numpy as np


def distance_errors(
    uv: np.ndarray, near: list[np.ndarray], distance: list[np.ndarray]
) -> tuple[float, float]:
    """Return the relative error of the distances at the scale of the map, and at the best scale."""
    i = np.repeat(np.arange(len(near)), list(map(len, near)))
    j, d = np.concatenate(near), np.concatenate(distance)
    flat = np.linalg.norm(uv[i] - uv[j], axis=1)
    ratio = d / flat
    order = np.argsort(ratio)
    below = np.cumsum(flat[order])
    scale = ratio[order][np.searchsorted(below, below[-1] / 2)]
    return tuple(float(np.abs(s * flat - d).sum() / d.sum()) for s in (1.0, scale))


def main(patch: str, surface: str, maps: str, out: str) -> None:
    from autoflatten.backends.pyflatten import PyflattenBackend
    from autoflatten.flatten.distance import compute_kring_geodesic_distances_angular

    with np.load(maps) as given:
        V, F, vertices = (given[name] for name in ("V", "F", "vertices"))
        known = {name[4:]: given[name] for name in given.files if name.startswith("map ")}
    output: dict[str, object] = {}
    if "run" in sys.argv:
        flat = out.replace(".npz", ".flat.patch.3d")
        begin = perf_counter()
        PyflattenBackend().flatten(patch, surface, flat, verbose=False)
        output["seconds"] = perf_counter() - begin
        rows = np.fromfile(flat, dtype=[("vertex", ">i4"), ("place", ">f4", 3)], offset=8)
        uv = np.full((int(vertices.max()) + 1, 2), np.nan)
        uv[np.abs(rows["vertex"]) - 1] = rows["place"][:, :2]
        known["autoflatten"] = output["uv"] = uv[vertices]
    near, distance = compute_kring_geodesic_distances_angular(V, F, 7, 12)
    for name, uv in known.items():
        output[f"errors {name}"] = distance_errors(uv, near, distance)
    np.savez(out, **output)


if __name__ == "__main__":
    main(*sys.argv[1:5])
