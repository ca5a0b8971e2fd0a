"""Measure the effect of `trade`: cost, seams and stretch of atlases from few charts to little stretch.

    python benchmarks/trade.py [--picture docs/images/trade.png]

The models are the bunny, two generated models, and the cow, the horse and fandisk in IGL_LINABF_MESHES. Other
programs are included if they are installed. Prints Markdown. With `--picture`, the script plots the stretch
against the seam length instead, with curves for `unwrap` and points for the other programs.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import igl
import numpy as np
from generated import generate_mesh
from meshes import Mesh, load_shared_meshes, stanford
from peers import peers, relative_seams, unmirror

from igl_linabf import ChartOptions, quality, unwrap

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from hard_surfaces import plate_with_holes

TRADES = (1, 3, 10, 30, 100, 300, 1000)
SHARED = {"igl_cow": "cow", "optcuts_horse_f10000": "horse", "igl_fandisk": "fandisk"}
HEADS = "by | charts | seams / sqrt(area) | L2 stretch | fill | E | its stretch | its seams | its page"
ROUNDING = 1e-3  # smaller relative differences do not count


class AtlasFigures(NamedTuple):
    """The figures of one atlas."""

    charts: int
    seams: float
    stretch: float
    fill: float
    cost: tuple[float, ...] = ()


MONOTONE: dict[
    str, tuple[Callable[[AtlasFigures], float], int]
] = {  # name of a figure: (function, 1 if the figure should rise with the trade, or -1 if it should fall)
    "charts": (lambda at: at.charts, 1),
    "seams": (lambda at: at.seams, 1),
    "L2 stretch": (lambda at: at.stretch, -1),
    "E without the page": (lambda at: at.cost[1] + at.cost[2], -1),
    "E": (lambda at: at.cost[0], -1),
}


def models() -> Iterator[Mesh]:
    yield stanford()
    yield "generated", *generate_mesh("blob", 64, 0.03, 1)
    yield "plate with holes", *plate_with_holes()
    for name, V, F in load_shared_meshes("closed"):
        if name in SHARED:
            yield SHARED[name], V, F


def unwrap_by_trade(V: np.ndarray, F: np.ndarray) -> dict[float, AtlasFigures]:
    """Return the figures of the atlas for each trade."""
    found = {}
    for trade in TRADES:
        atlas = unwrap(V, F, charts=ChartOptions(trade=trade))
        seams, cost = relative_seams(V, F, atlas.FTC), atlas.cost
        terms = cost.total, cost.stretch, cost.seams, cost.page
        found[trade] = AtlasFigures(len(atlas.charts), seams, atlas.quality.stretch_l2, atlas.fill, terms)
    return found


def unwrap_with_peers(V: np.ndarray, F: np.ndarray) -> dict[str, AtlasFigures]:
    """Return the figures of the atlases of other programs; the stretch does not count flipped faces."""
    found = {}
    for name, make in peers().items():
        atlas = make(V, F)
        TC, charts, flipped = unmirror(atlas)
        keep = ~flipped & (igl.doublearea(TC, atlas.FTC) > 0)
        stretch = quality(V[atlas.origin], atlas.FTC[keep], TC).stretch_l2
        fill = igl.doublearea(TC, atlas.FTC).sum() / 2 / atlas.page
        found[name] = AtlasFigures(charts, relative_seams(V, F, atlas.FTC), stretch, fill)
    return found


def find_wrong_steps(points: dict[float, AtlasFigures]) -> dict[str, list[str]]:
    """Return, by figure, the steps between successive trades that change the figure the wrong way."""
    steps: dict[str, list[str]] = {figure: [] for figure in MONOTONE}
    for (t, a), (u, b) in pairwise(points.items()):
        for figure, (of, sign) in MONOTONE.items():
            before, after = of(a), of(b)
            if sign * (after - before) < -ROUNDING * before:
                steps[figure].append(f"{before:.3f} to {after:.3f} from {t} to {u}")
    return steps


def format_row(name: str, by: str, at: AtlasFigures) -> str:
    figures = f"{at.charts} | {at.seams:.2f} | {at.stretch:.4f} | {at.fill:.2f}"
    cost = " | ".join(f"{term:.3f}" for term in at.cost) or "| | |"
    return f"| {name} | {by} | {figures} | {cost} |"


def print_table() -> None:
    print(
        "E is `atlas.cost`, in units of L2 stretch. The last three columns are the stretch, seam and page\n"
        "terms of E for each value of `trade`; the stretch term of an isometric map is 6 (L2 stretch - 1).\n"
        "The other programs have no option like `trade`. Flipped faces are not included in the stretch.\n"
    )
    print(f"| model | {HEADS} |\n|{'---|' * (HEADS.count('|') + 2)}")
    wrong_steps: dict[str, list[str]] = {figure: [] for figure in MONOTONE}
    model_count = 0
    for name, V, F in models():
        points = unwrap_by_trade(V, F)
        for trade, at in points.items():
            print(format_row(name, f"trade {trade}", at), flush=True)
        for peer, at in unwrap_with_peers(V, F).items():
            print(format_row(name, peer, at), flush=True)
        model_count += 1
        for figure, steps in find_wrong_steps(points).items():
            wrong_steps[figure] += [f"{name} {step}" for step in steps]
    total = model_count * (len(TRADES) - 1)
    print(
        f"\nOf the {total} steps between successive values of `trade`, the list contains those that\n"
        "change a figure in the wrong direction by more than a thousandth:\n"
    )
    for figure, (_, sign) in MONOTONE.items():
        verb, wrong = "increases" if sign > 0 else "decreases", wrong_steps[figure]
        print(f"- {figure}: {verb} in all but {len(wrong)} steps{': ' * bool(wrong)}{'; '.join(wrong)}")


def draw(path: str) -> None:
    """Draw the stretch against the seam length, one panel per model."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    shown = list(models())
    figure, axes = plt.subplots(2, (len(shown) + 1) // 2, figsize=(11, 6.4), layout="constrained")
    marks = dict(zip(("xatlas", "uvunwrap", "Blender"), "s^D", strict=True))
    for ax in axes.ravel()[len(shown) :]:
        ax.axis("off")
    for (name, V, F), ax in zip(shown, axes.ravel(), strict=False):
        points = unwrap_by_trade(V, F)
        ax.plot(
            [p.seams for p in points.values()], [p.stretch for p in points.values()], "o-", label="unwrap"
        )
        for trade, at in points.items():
            ax.annotate(f"{trade}", (at.seams, at.stretch), xytext=(3, 4), textcoords="offset points", size=7)
        for peer, at in unwrap_with_peers(V, F).items():
            ax.plot(at.seams, at.stretch, marks[peer], label=f"{peer}, {at.charts} charts")
        ax.set_title(f"{name}: {points[1].charts} to {points[1000].charts} charts", size=10)
        ax.set_xlim(left=0)
        ax.set_ylim(0.99, max(1.1, 1.02 * points[1].stretch))
        ax.set_xlabel("seams / square root of the area")
        ax.set_ylabel("L2 stretch")
        ax.legend(fontsize=7)
    figure.savefig(path, dpi=110)


def main() -> None:
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--picture", metavar="FILE", help="draw the curves instead")
    picture = parser.parse_args().picture
    if picture:
        draw(picture)
    else:
        print_table()


if __name__ == "__main__":
    main()
