"""Write docs/results.md: the output of the other benchmarks, each under its command.

python benchmarks/results.py
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
HEAD = """# Results

`make results` writes this page. Each table is the output of the command above it. The meshes are the
cortex of nilearn's wheel and those of the folder that `IGL_LINABF_MESHES` names (files `kind__name.obj`).
Times are ratios to `igl.lscm` within one process: medians, with the checks of the input included.
"""
SECTIONS = [
    ("The paper's Table 1", "table1.py"),
    ("Holes, uncut", "uncut.py"),
    ("Any surface", "unwrap.py"),
    ("Many at once", "many.py"),
    ("Distortion", "distortion.py"),
    ("Time, with CHOLMOD", "timing.py --large"),
    ("Time, without CHOLMOD", "timing.py --large --solver multigrid"),
    ("Another pair of pins", "pins.py"),
]


def main() -> None:
    text = HEAD
    for title, command in SECTIONS:
        script, *options = command.split()
        path = ROOT / "benchmarks" / script
        done = subprocess.run([sys.executable, path, *options], capture_output=True, text=True, check=True)
        text += f"\n## {title}\n\n`python benchmarks/{command}`\n\n{done.stdout}"
        print(title, file=sys.stderr)
    (ROOT / "docs" / "results.md").write_text(text)


if __name__ == "__main__":
    main()
