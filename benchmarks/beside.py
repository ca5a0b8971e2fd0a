"""Compare atlases of `unwrap` with atlases of OptCuts, PartUV and UVAtlas.

    IGL_LINABF_PEERS=FOLDER python benchmarks/beside.py [--picture docs/images/beside.png]

These commands fill the folder. OptCuts takes minutes to compile, is compiled once, and needs the headers of
TBB, X11 and OpenGL (on Debian libtbb-dev, xorg-dev and libgl1-mesa-dev):

    git clone https://github.com/liminchen/OptCuts
    git clone https://github.com/EricWang12/PartUV
    python3.11 -m venv partuv && partuv/bin/pip install partuv==0.1.2
    python3.11 -m venv open3d && open3d/bin/pip install open3d==0.20.0

OptCuts runs on the meshes of its own benchmark, PartUV on the meshes of its demo, and UVAtlas on the meshes
of kind closed in IGL_LINABF_MESHES. Programs that are not in the folder are skipped. All programs run on one
core. Prints Markdown. With `--picture`, the script only draws two meshes.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import warnings
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from statistics import median
from textwrap import fill
from time import process_time
from typing import NamedTuple

import igl
import numpy as np
import optcuts_peer
import partuv_peer
from drawing import Row, draw_atlases
from meshes import Mesh, load_shared_meshes
from peers import Maker, TexelAtlas, find_peers_folder, find_python, relative_seams, unmirror
from uvatlas_peer import unwrap_with_uvatlas

from igl_linabf import ChartOptions, quality, unwrap

HEADS = ("charts", "seams", "L2 stretch", "area distortion", "mean energy", "flips", "overlaps", "CPU s")
FORMATS = (",.0f", ".2f", ".3f", ".3f", ".3f", ",.0f", ",.0f", ".1f")
Figures = dict[str, float]
NOTES = f"""
The column seams is the length of the seams divided by the square root of the area. Mean energy is the
symmetric Dirichlet energy, which is 4 for an isometry. OptCuts and the row of `unwrap` below it have the
bound {optcuts_peer.BOUND} on this energy. The other programs run with their default options. The first row
of `unwrap` below them has default options, too, and the second one has the energy of the other program as
its bound. Distortion does not include flipped faces, and overlaps are pairs of triangles of one chart.
PartUV's tree of parts comes from the normals of the faces instead of its neural network, which needs a GPU.
With the network, its charts may be better. They are measured before packing.
"""


class Peer(NamedTuple):
    """A program that makes atlases, its meshes, and the bound on the mean energy that the program gets."""

    name: str
    make: Maker
    meshes: Iterable[Mesh]
    bound: float | None


def list_peers(folder: Path) -> Iterator[Peer]:
    """Yield the programs of the folder that make atlases."""
    sources = folder / "OptCuts"
    if sources.exists():
        program = optcuts_peer.OptCuts.build(sources, folder / "build" / "optcuts")
        yield Peer("OptCuts", program.unwrap, optcuts_peer.load_meshes(sources), optcuts_peer.BOUND)
    sources = folder / "PartUV"
    if (python := find_python(folder, "partuv")) and sources.exists():
        by_partuv = partial(partuv_peer.unwrap_with_partuv, python)
        yield Peer("PartUV", by_partuv, partuv_peer.load_meshes(sources), None)
    if python := find_python(folder, "open3d"):
        yield Peer("UVAtlas", partial(unwrap_with_uvatlas, python), load_shared_meshes("closed"), None)


def measure(V: np.ndarray, F: np.ndarray, atlas: TexelAtlas, seconds: float) -> Figures:
    """Return the figures of one atlas, in the order of `HEADS`."""
    if len(atlas.FTC) != len(F):
        raise ValueError(f"the atlas has {len(atlas.FTC):,} faces instead of {len(F):,}")
    TC, charts, flipped = unmirror(atlas)
    q = quality(V[atlas.origin], atlas.FTC[~flipped & (igl.doublearea(V[atlas.origin], atlas.FTC) > 0)], TC)
    seams = relative_seams(V, atlas.origin[atlas.FTC], atlas.FTC)
    figures = charts, seams, q.stretch_l2, q.area_distortion, 4 * q.symmetric_dirichlet
    return dict(zip(HEADS, (*figures, np.count_nonzero(flipped), q.overlaps, seconds), strict=True))


def unwrap_with_bound(V: np.ndarray, F: np.ndarray, bound: float | None) -> TexelAtlas:
    """Return the isometric atlas of `unwrap`, with a bound on the mean energy."""
    atlas = unwrap(V, F, method="isometric", charts=ChartOptions(max_dirichlet=bound))
    return TexelAtlas(atlas.origin, atlas.FTC, atlas.TC, 1, 0)


def measure_ours(V: np.ndarray, F: np.ndarray, bound: float | None) -> Figures:
    """Return the figures of `unwrap`, with a bound on the mean energy."""
    start = process_time()
    atlas = unwrap_with_bound(V, F, bound)
    return measure(V, F, atlas, process_time() - start)


def format_row(name: str, triangles: int, program: str, row: Figures) -> str:
    cells = (format(row[head], form) for head, form in zip(HEADS, FORMATS, strict=True))
    return f"| {name} | {triangles:,} | {program} | {' | '.join(cells)} |"


def compare(peer: Peer) -> tuple[list[str], list[tuple[Figures, Figures]]]:
    """Return table rows of a program, and pairs of figures: its own, and of `unwrap` at equal energy."""
    rows, pairs = [], []
    for name, V, F in peer.meshes:
        try:
            atlas = peer.make(V, F)
            theirs = measure(V, F, atlas, atlas.seconds)
        except (subprocess.SubprocessError, ValueError) as error:  # becomes a row of the table
            rows.append(f"| {name} | {len(F):,} | {peer.name} | {type(error).__name__} |{' |' * 7}")
            print(name, peer.name, error, file=sys.stderr)
            continue
        bound, figures = peer.bound or theirs["mean energy"], {peer.name: theirs}
        if peer.bound is None:
            figures["unwrap"] = measure_ours(V, F, None)
        mine = measure_ours(V, F, bound)
        figures[f"unwrap, energy at most {bound:.4g}"] = mine
        rows += [format_row(name, len(F), program, row) for program, row in figures.items()]
        pairs.append((theirs, mine))
        print(peer.name, name, file=sys.stderr, flush=True)
    return rows, pairs


def conclude(name: str, pairs: list[tuple[Figures, Figures]]) -> str:
    """Return an item of a list that compares a program with `unwrap`, by the pairs of `compare`."""
    ratio = sorted(mine["seams"] / theirs["seams"] for theirs, mine in pairs)
    there, here = ({head: median(pair[k][head] for pair in pairs) for head in HEADS} for k in (0, 1))
    shown = zip(HEADS, FORMATS, strict=True)
    medians = [f"{head} {here[head]:{form}} and {there[head]:{form}}" for head, form in shown]
    better = [head for head in HEADS if there[head] < here[head]]
    text = (
        f"- {name}: on {len(pairs)} meshes, the seams of `unwrap` are {median(ratio):.2f} times as long in "
        f"the median ({ratio[0]:.2f} to {ratio[-1]:.2f}) at the same mean energy. Medians of `unwrap` and "
        f"{name}: {', '.join(medians)}. {name} is better in: {', '.join(better) or 'nothing'}."
    )
    return fill(text, 110, subsequent_indent="  ", break_on_hyphens=False)


def print_tables(folder: Path) -> None:
    """Print the conclusions, and then the tables."""
    unwrap(*igl.icosahedron(), method="isometric")  # warm-up, which includes lazy imports
    conclusions, rows = [], [f"| mesh | triangles | by | {' | '.join(HEADS)} |", "|---" * 11 + "|"]
    for peer in list_peers(folder):
        new_rows, pairs = compare(peer)
        rows += new_rows
        conclusions.append(conclude(peer.name, pairs))
    print("\n".join(conclusions))
    print(NOTES)
    print("\n".join(rows))


def draw(path: str, folder: Path) -> None:
    """Draw one mesh of OptCuts and one of PartUV, with their atlases and the atlases of `unwrap`."""
    views: dict[str, tuple[str, tuple[float, float, float]]] = {
        "OptCuts": ("cow_param_closed", (1, 0.4, 1)),
        "PartUV": ("0c3ca2b3", (1, 0.5, 1)),
    }
    rows = []
    for peer in list_peers(folder):
        if peer.name in views:
            shown, view = views[peer.name]
            V, F = next((V, F) for name, V, F in peer.meshes if name == shown)
            theirs = peer.make(V, F)
            bound = peer.bound or measure(V, F, theirs, 0)["mean energy"]
            mine = unwrap_with_bound(V, F, bound)
            rows.append(Row(V, {peer.name: theirs, "unwrap": mine}, view, (0, 1, 0)))
    draw_atlases(path, rows, panel=(550, 500))


def main() -> None:
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--picture", metavar="FILE", help="draw two meshes instead")
    picture = parser.parse_args().picture
    folder = find_peers_folder()
    if folder is None:
        return
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, [max(os.sched_getaffinity(0))])
    if picture:
        draw(picture, folder)
    else:
        print_tables(folder)


if __name__ == "__main__":
    main()
