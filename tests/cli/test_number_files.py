"""Text files of numbers: each fault is reported with its line and the expected content."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from igl_linabf import MeshError
from igl_linabf.cli.arguments import read_rows


@pytest.mark.parametrize(
    ("text", "line", "shown"),
    [
        ("0 1\n1 2.5\n", 2, "'1 2.5'"),
        ("0 1\n\n1 2 3\n", 3, "'1 2 3'"),
        ("# edges\n0\n", 2, "'0'"),
        ("0,1\n", 1, "'0,1'"),
        ("0 99999999999999999999\n", 1, "'0 99999999999999999999'"),
        ("v " + 99 * "x", 1, "'v xx"),
    ],
)
def test_a_fault_in_a_file_of_numbers_names_the_line(
    text: str, line: int, shown: str, tmp_path: Path
) -> None:
    path = tmp_path / "pairs.txt"
    path.write_text(text)
    with pytest.raises(MeshError) as fault:
        read_rows(path, np.int64, 2, "two vertices")
    message = str(fault.value)
    assert f"line {line} of {path} is {shown}" in message and "write two vertices on each line" in message
    assert len(message) < len(str(path)) + 100


def test_comments_and_empty_lines_are_skipped(tmp_path: Path) -> None:
    path = tmp_path / "pairs.txt"
    path.write_text("\ufeff# edges\n0 1  # the front\n\n 3\t2\n", encoding="utf-8")
    assert read_rows(path, np.int64, 2, "").tolist() == [[0, 1], [3, 2]]
    path.write_text("")
    assert read_rows(path, np.int64, 2, "").shape == (0, 2)
