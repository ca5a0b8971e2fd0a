"""Write docs/results.md from the output of the other benchmarks, each section under its command.

    python benchmarks/results.py [--only WORD]

With --only, sections whose command does not contain WORD are not changed. If the new page would lack a mesh
or a column of the old page, the script lists the losses, leaves the page unchanged, and ends with exit code
1.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
HEAD = """# Results

{found}

`make results` writes this page. Each section is the output of the command below its heading. The meshes are
the cortex of the package nilearn, and the files `kind__name.obj` in the folder that the environment variable
`IGL_LINABF_MESHES` names. Unless a section states otherwise, times are ratios of medians to the time of
`igl.lscm` in the same process, and include the checks of the input. F/3nt is the angle distortion of the
paper, L2 stretch is 1 for an isometry ([Reading the numbers](numbers.md)), and E is the cost of an atlas
([The method](method.md#what-an-atlas-costs)).
"""
SECTIONS = [
    ("The paper's Table 1", "table1.py"),
    ("Holes, uncut", "uncut.py"),
    ("Boundaries to order", "boundaries.py"),
    ("Any surface, beside other programs", "unwrap.py"),
    ("What trade buys", "trade.py"),
    ("Bounds on the whole atlas", "bounds.py"),
    ("What each mechanism is for", "mechanisms.py"),
    ("What each mechanism of maps is for", "map_mechanisms.py"),
    ("Nasty meshes", "nasty.py"),
    ("Hard surfaces", "parts.py"),
    ("Planes and pages", "hard.py"),
    ("Time of an atlas", "unwrap_time.py"),
    ("Even texels", "isometric.py"),
    ("Generated meshes", "generated.py"),
    ("Large meshes", "large.py"),
    ("Many at once", "many.py"),
    ("Distortion", "distortion.py"),
    ("Time", "timing.py --large --repeat 3"),
    ("Time, with CHOLMOD", "timing.py --large --solver cholmod --repeat 3"),
    ("Another pair of pins", "pins.py"),
    ("Another solver", "claims.py solvers"),
    ("The guarantee from other starts", "claims.py starts"),
    ("Closed models cut along few edges", "claims.py cuts"),
]
PAGE = ROOT / "docs" / "results.md"


def rows(page: str) -> dict[str, list[str]]:
    """Return the mesh names (first columns) and the column heads of the tables, by section."""
    found: dict[str, list[str]] = {}
    for section in page.split("\n## ")[1:]:
        title, *lines = section.splitlines()
        tables = [line for line in lines if line.startswith("| ")]
        found[title] = [line.split(" | ")[0].removeprefix("| ") for line in tables]
        found[title] += [f"column {head}" for head in "".join(tables[:1]).strip("| ").split(" | ")]
    return found


def find_losses(old: str, new: str) -> list[str]:
    """Return the meshes and columns of the old page that are missing in the new page, by section."""
    new_rows, losses = rows(new), []
    for title, names in rows(old).items():
        if missing := [name for name in names if name not in new_rows.get(title, [])]:
            losses.append(f"{title}: {', '.join(missing)}")
    return losses


def run_section(title: str, command: str) -> str:
    """Run a command, and return its output as a section of the page."""
    script, *options = command.split()
    path = ROOT / "benchmarks" / script
    process = subprocess.run(
        [sys.executable, path, *options], capture_output=True, encoding="utf-8", check=True
    )
    return f"\n## {title}\n\n`python benchmarks/{command}`\n\n{process.stdout}"


def first_paragraph(text: str) -> str:
    """Return the first paragraph of a section, after its title and command."""
    return text.strip().split("\n\n")[2]


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "--only", default="", metavar="WORD", help="run only the commands that contain this word"
    )
    only = parser.parse_args(arguments).only
    old = PAGE.read_text("utf-8") if PAGE.exists() else ""
    old_sections = {part.split("\n")[0]: f"\n## {part.rstrip()}\n" for part in old.split("\n## ")[1:]}
    parts = []
    for title, command in SECTIONS:
        text = run_section(title, command) if only in command else old_sections.get(title, "")
        if missing := find_losses(old_sections.get(title, ""), text):
            print(
                f"{PAGE} is unchanged, because it would lose {missing[0]}. Set IGL_LINABF_MESHES and install "
                "the extra `peers`, or remove these entries from the page first.",
                file=sys.stderr,
            )
            return 1
        parts.append(text)
        print(title, file=sys.stderr)
    PAGE.write_text(HEAD.format(found=first_paragraph(parts[0])) + "".join(parts), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
