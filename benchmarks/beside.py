"""Compare this package with OptCuts, PartUV, UVAtlas and OpenABF.

    IGL_LINABF_PEERS=FOLDER python benchmarks/beside.py [--picture docs/images/beside.png]

The folder contains what these commands make there (the packages on Debian are libtbb-dev, libeigen3-dev,
xorg-dev and libgl1-mesa-dev; OptCuts takes minutes to compile, and is compiled once):

    git clone https://github.com/liminchen/OptCuts
    git clone https://github.com/educelab/OpenABF
    git clone https://github.com/EricWang12/PartUV
    python3.11 -m venv partuv && partuv/bin/pip install partuv==0.1.2
    python3.11 -m venv open3d && open3d/bin/pip install open3d==0.20.0

The meshes are those of OptCuts' benchmark and of PartUV's demo, the meshes of kind closed in
IGL_LINABF_MESHES for UVAtlas, and the surfaces of scrolls.py for OpenABF. Programs that are not in the
folder are skipped. All programs run on one core. Prints Markdown. With `--picture`, the script only draws
two meshes.
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
from time import process_time
from typing import NamedTuple

import igl
import numpy as np
import optcuts_peer
import partuv_peer
from drawing import Row, draw_atlases
from meshes import Mesh, load_shared_meshes
from openabf_peer import OpenAbf
from peers import Maker, TexelAtlas, relative_seams, unmirror
from uvatlas_peer import unwrap_with_uvatlas

from igl_linabf import ChartOptions, quality, unwrap

HEADS = ("charts", "seams", "L2 stretch", "area distortion", "mean energy", "flips", "overlaps", "CPU s")
FORMATS = (",.0f", ".2f", ".3f", ".3f", ".3f", ",.0f", ",.0f", ".1f")
Figures = dict[str, float]
NOTES = f"""
The column seams is the length of the seams over the square root of the area. Mean energy is the symmetric
Dirichlet energy, which is 4 for an isometry. OptCuts and the row of `unwrap` below it have the bound
{optcuts_peer.BOUND} on it. The other programs run with their default options. The first row of `unwrap` below
them has the energy of the other program as its bound, and the second one has default options.
Distortion does not include flipped faces, and overlaps are pairs of triangles of one chart. PartUV's tree of
parts comes from the normals of the faces instead of its neural network, which needs a GPU. With the network,
its charts may be better. They are measured before packing.
"""


class Peer(NamedTuple):
    """A program that makes atlases, its meshes, and the bound on the mean energy that it is given."""

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
    python, sources = folder / "partuv" / "bin" / "python", folder / "PartUV"
    if python.exists() and sources.exists():
        by_partuv = partial(partuv_peer.unwrap_with_partuv, str(python))
        yield Peer("PartUV", by_partuv, partuv_peer.load_meshes(sources), None)
    python = folder / "open3d" / "bin" / "python"
    if python.exists():
        yield Peer("UVAtlas", partial(unwrap_with_uvatlas, str(python)), load_shared_meshes("closed"), None)


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
    """Return the rows of a program, and its figures with those of `unwrap` at the same mean energy."""
    rows, pairs = [], []
    for name, V, F in peer.meshes:
        try:
            atlas = peer.make(V, F)
            theirs = measure(V, F, atlas, atlas.seconds)
        except (subprocess.SubprocessError, ValueError) as error:  # becomes a row of the table
            rows.append(f"| {name} | {len(F):,} | {peer.name} | {type(error).__name__} |{' |' * 7}")
            print(name, peer.name, error, file=sys.stderr)
            continue
        bound = peer.bound or theirs["mean energy"]
        mine = measure_ours(V, F, bound)
        figures = {peer.name: theirs, f"unwrap, energy at most {bound:.4g}": mine}
        if peer.bound is None:
            figures["unwrap"] = measure_ours(V, F, None)
        rows += [format_row(name, len(F), program, row) for program, row in figures.items()]
        pairs.append((theirs, mine))
        print(peer.name, name, file=sys.stderr, flush=True)
    return rows, pairs


def conclude(name: str, pairs: list[tuple[Figures, Figures]]) -> str:
    """Return a sentence that compares the figures of a program with those of `unwrap` at the same energy."""
    ratio = sorted(mine["seams"] / theirs["seams"] for theirs, mine in pairs)
    there, here = ({head: median(pair[k][head] for pair in pairs) for head in HEADS} for k in (0, 1))
    shown = zip(HEADS, FORMATS, strict=True)
    medians = [f"{head} {here[head]:{form}} and {there[head]:{form}}" for head, form in shown]
    better = [head for head in HEADS if there[head] < here[head]]
    return (
        f"- {name}: on {len(pairs)} meshes, the seams of `unwrap` are {median(ratio):.2f} times as long\n"
        f"  in the median ({ratio[0]:.2f} to {ratio[-1]:.2f}) at the same mean energy. Medians of `unwrap`\n"
        f"  and {name}: {', '.join(medians)}. {name} is better in: {', '.join(better) or 'nothing'}."
    )


def print_tables(folder: Path) -> None:
    """Print the conclusions, and then the tables."""
    unwrap(*igl.icosahedron(), method="isometric")  # warm-up, which includes lazy imports
    conclusions, rows = [], [f"| mesh | triangles | by | {' | '.join(HEADS)} |", "|---" * 11 + "|"]
    for peer in list_peers(folder):
        new_rows, pairs = compare(peer)
        rows += new_rows
        conclusions.append(conclude(peer.name, pairs))
    sources = folder / "OpenABF"
    if sources.exists():
        program = OpenAbf.build(sources, folder / "build" / "openabf")
        new_rows, conclusion = program.compare()
        rows += ["", *new_rows]
        conclusions.append(conclusion)
    print("\n".join(conclusions))
    print(NOTES)
    print("\n".join(rows))


def draw(path: str, folder: Path) -> None:
    """Draw the atlases of one mesh of OptCuts and one of PartUV beside those of `unwrap`."""
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
    draw_atlases(path, rows)


def main() -> None:
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--picture", metavar="FILE", help="draw two meshes instead")
    picture = parser.parse_args().picture
    if "IGL_LINABF_PEERS" not in os.environ:
        print("IGL_LINABF_PEERS is not set: there is no program to compare with", file=sys.stderr)
        return
    folder = Path(os.environ["IGL_LINABF_PEERS"]).resolve()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, [max(os.sched_getaffinity(0))])
    if picture:
        draw(picture, folder)
    else:
        print_tables(folder)


if __name__ == "__main__":
    main()
