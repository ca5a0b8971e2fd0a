"""Print F/3nt, L2 stretch and flips of igl.lscm and linear ABF: one iteration, default, converged.

    python benchmarks/distortion.py

The meshes are the cortex and the meshes of kinds disk, flat2d and stress in IGL_LINABF_MESHES. Prints
Markdown.
"""

from __future__ import annotations

import warnings

from meshes import brain, load_shared_meshes

from igl_linabf import LinABF, OutcomeWarning, flatten, quality
from igl_linabf.flattening import Flattening


def main() -> None:
    warnings.simplefilter("ignore", OutcomeWarning)
    print(
        "Each cell contains F/3nt, the L2 stretch and the number of flipped triangles; the number of\n"
        "linear solves (and of conjugate gradient steps), and the layout.\n"
    )
    print("| mesh | triangles | igl.lscm | one iteration | default | converged |")
    print("|---|---|---|---|---|---|")
    for name, V, F in [brain(), *load_shared_meshes("disk", "flat2d", "stress")]:

        def cell(result: Flattening, V=V, F=F) -> str:
            q = quality(V, F, result.uv)
            text = f"{q.angle_distortion:.3g}, {q.stretch_l2:.4g}, {q.flips}"
            if result.report.steps:
                text += f"; {result.report.iterations} ({result.report.inner_steps}), {result.report.layout}"
            return text

        results = [flatten(V, F, method="lscm")]
        results += [flatten(V, F, method=LinABF(iterations=iterations)) for iterations in (1, "auto", 12)]
        print(f"| {name} | {len(F):,} | {' | '.join(map(cell, results))} |", flush=True)


if __name__ == "__main__":
    main()
