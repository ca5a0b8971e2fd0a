"""Text tables have left-aligned names and right-aligned figures."""

from __future__ import annotations

from igl_linabf._runtime import align_columns


def test_names_are_left_aligned_and_figures_right_aligned() -> None:
    rows = [("", "mean", "most"), ("stretch", "1.5", "10"), ("flips", "12,345", "")]
    assert align_columns(rows).splitlines() == [
        "           mean  most",
        "stretch     1.5    10",
        "flips    12,345",
    ]
