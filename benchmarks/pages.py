"""Write figures into pages of the docs, between marks."""

from __future__ import annotations

import argparse
from pathlib import Path

DOCS = Path(__file__).parent.parent / "docs"


def replace_between_marks(page: Path, mark: str, text: str) -> None:
    """Replace the text between the marks `<!-- MARK -->` and `<!-- end of MARK -->` of a page."""
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->"
    old = page.read_text(encoding="utf-8")
    page.write_text(
        old[: old.index(begin) + len(begin)] + text.strip() + "\n\n" + old[old.index(end) :], encoding="utf-8"
    )


def arguments(doc: str | None, repeat: int) -> argparse.ArgumentParser:
    """Return a parser for a script that writes tables to docs/performance.md, or prints the tables."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=repeat)
    parser.add_argument("--print", action="store_true", dest="printed")
    return parser


def publish(mark: str, text: str, printed: bool) -> None:
    """Write a text between the marks of docs/performance.md, or print the text."""
    if printed:
        print(text)
    else:
        replace_between_marks(DOCS / "performance.md", mark, text)
