"""Update the tables in docs/results/ with the output of the other benchmarks.

    python benchmarks/results.py [--only WORD]

Each section of these pages has a title, a conclusion, and the command that prints its tables. This script
runs the command, and replaces the text between the command and the next section by its output. Afterwards,
check that the conclusions still hold.

With --only, sections whose command does not contain WORD are not changed. If a new section would lack a mesh
or a column of the old section, the script lists the losses, leaves the page unchanged, and ends with exit
code 1.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
PAGES = ROOT / "docs" / "results"
COMMAND = re.compile(r"^`python benchmarks/(.+)`\n", re.MULTILINE)


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


def run_benchmark(command: str) -> str:
    """Run a script of this folder with its options, and return its output."""
    script, *options = command.split()
    path = ROOT / "benchmarks" / script
    return subprocess.run(
        [sys.executable, path, *options], capture_output=True, encoding="utf-8", check=True
    ).stdout


def update_section(section: str, only: str) -> str:
    """Return a section with new output below its command, or unchanged if the command lacks a word."""
    title_and_conclusion, command, _ = COMMAND.split(section)
    if only not in command:
        return section
    print(section.split("\n")[0], file=sys.stderr)
    output = run_benchmark(command).rstrip()
    return f"{title_and_conclusion}`python benchmarks/{command}`\n\n{output}\n"


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "--only", default="", metavar="WORD", help="run only the commands that contain this word"
    )
    only = parser.parse_args(arguments).only
    for page in sorted(PAGES.glob("*.md")):
        old = page.read_text("utf-8")
        head, *sections = old.split("\n## ")
        new = "\n## ".join([head, *(update_section(section, only) for section in sections)])
        if missing := find_losses(old, new):
            print(
                f"{page} is unchanged, because it would lose {missing[0]}. Set IGL_LINABF_MESHES "
                "and IGL_LINABF_PEERS, and install the extra `peers`, or remove these entries from the page "
                "first.",
                file=sys.stderr,
            )
            return 1
        page.write_text(new, "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
