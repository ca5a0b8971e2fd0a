"""Compare flat cortices with the maps of autoflatten and FreeSurfer, and with published figures of both.

    IGL_LINABF_AUTOFLATTEN=PYTHON python benchmarks/cortex.py            # writes docs/cortex.md
    python benchmarks/cortex.py --print --without autoflatten

PYTHON is the interpreter of an environment with autoflatten, for example made by
`python -m venv peer && peer/bin/pip install autoflatten==1.0.7`. The benchmark takes minutes.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

import nibabel.freesurfer as freesurfer
import numpy as np
from nilearn.datasets import fetch_surf_fsaverage
from nilearn.surface import load_surf_mesh
from pages import DOCS, replace_between_marks
from scipy.optimize import minimize
from subjects import fsaverage5, made_up_subject

from igl_linabf import Isometric, flatten, quality
from igl_linabf.cortex import flatten_hemispheres, write_hemisphere
from igl_linabf.io import read_file, write_patch
from igl_linabf.measures import Distances
from igl_linabf.surface import Submesh

AREA_WEIGHT = Isometric().weight
HEAD = (
    "| | seconds | distance error: its scale · best scale | by autoflatten's distances "
    "| area, mean \\|log\\| | flips |\n"
    "|---|---|---|---|---|---|\n"
)
PUBLISHED = {
    "autoflatten 1.0.7, as published (a subject of FreeSurfer)": ("15 to 30 minutes", "14.47 %", "15"),
    "FreeSurfer's mris_flatten, as published": ("2 hours", "13 to 15 %", ""),
}


def fsaverage_patch(folder: Path) -> tuple[Path, np.ndarray]:
    """Write a patch of the left fsaverage5 and its surface; return the path and the flat map of nilearn."""
    white, pial, F = fsaverage5("lh", "white", "pial")
    freesurfer.write_geometry(folder / "lh.fiducial", (white + pial) / 2, F)
    shipped = load_surf_mesh(fetch_surf_fsaverage("fsaverage5")["flat_left"])
    kept = np.asarray(shipped.faces, np.int64)
    edges, faces = np.unique(
        np.sort(kept[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0, return_counts=True
    )
    kept_vertices = np.zeros(len(white), dtype=bool)
    kept_vertices[kept] = True
    # drop vertices along each cut, because faces across the cut would close the cut
    kept_vertices[edges[faces == 1]] = False
    border = np.zeros(len(white), dtype=bool)
    border[F[~kept_vertices[F].all(axis=1)]] = True
    vertex = np.flatnonzero(kept_vertices)
    path = folder / "lh.full.patch.3d"
    write_patch(str(path), vertex, border[vertex], ((white + pial) / 2)[vertex])
    return path, np.asarray(shipped.coordinates, float)[:, :2]


def time_calls(run: Callable[[], np.ndarray], repeat: int) -> tuple[np.ndarray, float]:
    """Return the result of `run` and the median of its times in seconds."""
    seconds, result = [], run()  # warm-up, which includes lazy imports
    for _ in range(repeat):
        begin = perf_counter()
        result = run()
        seconds.append(perf_counter() - begin)
    return result, median(seconds)


def run_autoflatten(
    folder: Path, patch: Path, surface: Submesh, maps: dict[str, np.ndarray], python: str
) -> dict:
    """Return the map of autoflatten, its seconds, and the errors of all maps, by autoflatten's distances."""
    known = {f"map {name}": uv for name, uv in maps.items()}
    np.savez(folder / "maps.npz", V=surface.V, F=surface.F, vertices=surface.vertices, **known)
    script = Path(__file__).with_name("autoflatten_peer.py")
    command = [
        python,
        script,
        patch,
        patch.with_name("lh.fiducial"),
        folder / "maps.npz",
        folder / "out.npz",
        "run",
    ]
    subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with np.load(folder / "out.npz") as out:
        return dict(out)


def peers_table(python: str | None, repeat: int) -> str:
    """Return the table that compares maps of a patch of fsaverage5."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        patch, shipped = fsaverage_patch(folder)
        mesh = read_file(patch)
        surface = Submesh.from_input(mesh.V, mesh.triangles)
        V, F = surface.V, surface.F
        runs = {
            'isometric, fit="lengths"': lambda: flatten(V, F, method="isometric", fit="lengths").uv,
            "isometric": lambda: flatten(V, F, method="isometric").uv,
            "linabf": lambda: flatten(V, F).uv,
        }
        maps, seconds = {}, {}
        for title, run in runs.items():
            maps[title], took = time_calls(run, repeat)
            seconds[title] = f"{took:.2f}"
        maps["FreeSurfer's map in nilearn's wheel"] = shipped[surface.vertices]
        theirs = {} if python is None else run_autoflatten(folder, patch, surface, maps, python)
    if "uv" in theirs:
        maps["autoflatten 1.0.7"] = theirs["uv"]
        seconds["autoflatten 1.0.7"] = f"{float(theirs['seconds']):.0f}"
        theirs["errors autoflatten 1.0.7"] = theirs["errors autoflatten"]
    distances = Distances.measure_within_rings(surface)
    text = HEAD
    for title, uv in maps.items():
        measured = quality(V, F, uv)
        own, best = (
            distances.compute_mean_error(uv),
            distances.compute_mean_error(uv * distances.find_best_scale(uv)),
        )
        peer = theirs.get(f"errors {title}")
        peer_cell = "" if peer is None else f"{100 * peer[0]:.2f} % · {100 * peer[1]:.2f} %"
        text += (
            f"| {title} | {seconds.get(title, '')} | {100 * own:.2f} % · {100 * best:.2f} % | {peer_cell} "
            f"| {measured.area_distortion:.3f} | {measured.flips} |\n"
        )
    for title, (time, error, flips) in PUBLISHED.items():
        text += f"| {title} | {time} | | {error} | | {flips} |\n"
    if "uv" in theirs:
        took = float(theirs["seconds"])
        with_scale, alone = (took / float(seconds[title]) for title in list(runs)[:2])
        text += (
            f"\nIn the same run, autoflatten takes {alone:.0f} times as long as the isometric map, and "
            f'{with_scale:.0f} times as long as the isometric map with `fit="lengths"`.\n'
        )
    return f"Maps of the left hemisphere of fsaverage5, which has {len(F):,} triangles:\n\n{text}"


def energies_table() -> str:
    """Return the table of distance errors for other weights, and for a direct minimization of the error."""
    with tempfile.TemporaryDirectory() as name:
        mesh = read_file(fsaverage_patch(Path(name))[0])
    surface = Submesh.from_input(mesh.V, mesh.triangles)
    V, F, distances = surface.V, surface.F, Distances.measure_within_rings(surface)
    begin = perf_counter()
    all_pairs = Distances.measure_within_rings(surface, most=len(V))
    measuring = perf_counter() - begin
    text = "| map | seconds | distance error | area, mean \\|log\\| | F/3nt | flips | overlaps |\n"
    text += "|---|---|---|---|---|---|---|\n"

    def row(title: str, uv: np.ndarray, seconds: float) -> str:
        measured, error = quality(V, F, uv), distances.compute_mean_error(uv * distances.find_best_scale(uv))
        figures = f"{100 * error:.2f} % | {measured.area_distortion:.3f} | {measured.angle_distortion:.3f}"
        return f"| {title} | {seconds:.1f} | {figures} | {measured.flips} | {measured.overlaps} |\n"

    for weight in (1.0, 1.5, 2.0, 4.0, 8.0):
        begin = perf_counter()
        uv = flatten(V, F, method=Isometric(weight=weight)).uv
        text += row(f"`Isometric(weight={weight:g})`", uv, perf_counter() - begin)
        if weight == AREA_WEIGHT:
            start = uv
    begin = perf_counter()
    nearest = minimize_distance_error(start, all_pairs)
    return text + row(
        "least distance error, by L-BFGS from the map of `Isometric()`",
        nearest,
        measuring + perf_counter() - begin,
    )


def minimize_distance_error(start: np.ndarray, distances: Distances, steps: int = 60) -> np.ndarray:
    """Return a map that minimizes the error of the distances, regardless of flips."""
    (i, j), along = distances.ends, distances.length

    def error(x: np.ndarray) -> tuple[float, np.ndarray]:
        uv = x.reshape(-1, 2)
        apart = uv[i] - uv[j]
        length = np.linalg.norm(apart, axis=1) + 1e-9
        smooth = np.hypot(length - along, 0.1)
        pull = ((length - along) / smooth / length)[:, None] * apart
        slope = [np.bincount(i, of, len(uv)) - np.bincount(j, of, len(uv)) for of in pull.T]
        return float(smooth.sum()), np.column_stack(slope).ravel()

    found = minimize(error, start.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": steps})
    return np.asarray(found.x).reshape(-1, 2)


def subjects_table() -> str:
    """Return the table of synthetic subjects, timed from their files to all files of both hemispheres."""
    text = "| vertices of a hemisphere | seconds for both | distance error, left · right "
    text += "| area, mean \\|log\\|, left · right | flips | overlaps |\n"
    text += "|---|---|---|---|---|---|\n"
    for subdivisions in (5, 6, 7):
        with tempfile.TemporaryDirectory() as name:
            subject = made_up_subject(Path(name) / "subject", subdivisions)
            begin = perf_counter()
            flats = flatten_hemispheres(subject)
            for flat in flats:
                write_hemisphere(Path(name) / "flat", flat)
            took = perf_counter() - begin
        of = [flat.quality for flat in flats]
        errors = " · ".join(f"{100 * q.distance_error:.1f} %" for q in of)
        areas = " · ".join(f"{q.area_distortion:.3f}" for q in of)
        flips, overlaps = (sum(getattr(q, name) for q in of) for name in ("flips", "overlaps"))
        text += f"| {len(flats[0].uv):,} | {took:.1f} | {errors} | {areas} | {flips} | {overlaps} |\n"
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--print", action="store_true", dest="printed")
    parser.add_argument(
        "--without", choices=("autoflatten", "subjects", "energies"), action="append", default=[]
    )
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    python = os.environ.get("IGL_LINABF_AUTOFLATTEN")
    if python is None and "autoflatten" not in options.without:
        sys.exit(
            "IGL_LINABF_AUTOFLATTEN is not set: name a Python with autoflatten, or use --without autoflatten"
        )
    tables = {
        "cortex peers": peers_table(None if "autoflatten" in options.without else python, options.repeat)
    }
    if "subjects" not in options.without:
        tables["cortex subjects"] = subjects_table()
    if "energies" not in options.without:
        tables["cortex energies"] = energies_table()
    for mark, text in tables.items():
        if options.printed:
            print(text)
        else:
            replace_between_marks(DOCS / "cortex.md", mark, text)


if __name__ == "__main__":
    main()
