"""Format text tables."""

from collections.abc import Sequence


def align_columns(rows: Sequence[Sequence[str]]) -> str:
    """Format a text table, with the first column left-aligned and all other columns right-aligned.

    Examples
    --------
    >>> print(align_columns([["", "one"], ["length", "1.5"]]))
            one
    length  1.5
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for first, *rest in rows:
        cells = [cell.rjust(width) for cell, width in zip(rest, widths[1:], strict=True)]
        lines.append("  ".join([first.ljust(widths[0]), *cells]).rstrip())
    return "\n".join(lines)
