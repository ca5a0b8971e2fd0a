"""Every cell of docs/kept.md is correct, and the page lists all cells.

Run as a script, this file writes the tables of the page.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest
from kept import Cell, format_tables
from kept_of_gltf import CELLS as GLTF
from kept_of_packages import CELLS as PACKAGES
from kept_of_text_formats import CELLS as TEXT_FORMATS

from igl_linabf import MeshError, MeshWarning

PAGE = Path(__file__).parents[2] / "docs" / "kept.md"
CELLS = [*TEXT_FORMATS, *GLTF, *PACKAGES]


@pytest.mark.parametrize("cell", CELLS, ids=lambda cell: f"{cell.source}-{cell.to}-{cell.what}")
def test_the_result_of_each_cell_is_as_the_page_says(cell: Cell, tmp_path: Path) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        if cell.outcome == "error":
            with pytest.raises(MeshError) as error:
                cell.act(tmp_path)
            assert cell.says in str(error.value)
        else:
            cell.act(tmp_path)
    messages = [str(warning.message) for warning in caught if issubclass(warning.category, MeshWarning)]
    assert len(messages) == (cell.outcome == "warning"), messages
    assert all(cell.says in text for text in messages)


def test_the_page_lists_all_cells() -> None:
    head, *_ = PAGE.read_text("utf-8").partition("\n## ")
    assert PAGE.read_text("utf-8") == f"{head}\n{format_tables(CELLS)}", "run python tests/io/test_kept.py"


if __name__ == "__main__":
    head, *_ = PAGE.read_text("utf-8").partition("\n## ")
    PAGE.write_text(f"{head}\n{format_tables(CELLS)}", "utf-8")
