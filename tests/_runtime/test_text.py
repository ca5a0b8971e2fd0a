"""Tables of text: names flush left, figures flush right."""

from __future__ import annotations

from igl_linabf._runtime import aligned


def test_names_begin_and_figures_end_below_each_other() -> None:
    rows = [("", "mean", "most"), ("stretch", "1.5", "10"), ("flips", "12,345", "")]
    assert aligned(rows).splitlines() == ["           mean  most", "stretch     1.5    10", "flips    12,345"]
