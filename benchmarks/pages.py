"""Pages of the docs with figures between marks."""

from __future__ import annotations

from pathlib import Path

DOCS = Path(__file__).parent.parent / "docs"


def put(page: Path, mark: str, text: str) -> None:
    """Put the text between the marks `<!-- MARK -->` and `<!-- end of MARK -->` of a page."""
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->"
    old = page.read_text(encoding="utf-8")
    page.write_text(
        old[: old.index(begin) + len(begin)] + text.strip() + "\n\n" + old[old.index(end) :], encoding="utf-8"
    )
