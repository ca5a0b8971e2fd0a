"""The pages in docs/results are the output of the benchmarks; runs with fewer meshes do not change a page."""

from __future__ import annotations

import pytest
import results
import table1
from conftest import ROOT

PAGE = """# Results

## One

It holds.

`python benchmarks/one.py`

| mesh | time |
|---|---|
| lion | 1 |
| cow | 2 |

## Two

It holds, too.

`python benchmarks/two.py --fast`

| mesh | time | xatlas |
|---|---|---|
| lion | 1 | 3 |
"""
OUTPUTS = {
    "one.py": "| mesh | time |\n|---|---|\n| lion | 1 |\n| cow | 2 |\n",
    "two.py --fast": "| mesh | time | xatlas |\n|---|---|---|\n| lion | 1 | 3 |\n",
}


@pytest.fixture
def page(tmp_path, monkeypatch):
    """Return a page in a folder of its own, and replace the benchmarks by their outputs."""
    path = tmp_path / "page.md"
    path.write_text(PAGE)
    monkeypatch.setattr(results, "PAGES", tmp_path)
    monkeypatch.setattr(results, "run_benchmark", OUTPUTS.__getitem__)
    return path


def test_lost_meshes_columns_and_sections_are_named() -> None:
    assert results.find_losses(PAGE, PAGE) == []
    without_cow = PAGE.replace("| cow | 2 |\n", "| horse | 2 |\n| bunny | 1 |\n")
    assert results.find_losses(PAGE, without_cow) == ["One: cow"]
    assert results.find_losses(PAGE, PAGE.replace(" xatlas |", "")) == ["Two: column xatlas"]
    (loss,) = results.find_losses(PAGE, PAGE.split("## Two")[0])
    assert loss.startswith("Two: ")
    assert results.find_losses("", PAGE) == []


def test_a_run_with_fewer_meshes_does_not_change_the_page(page, monkeypatch, capsys) -> None:
    assert results.main([]) == 0
    assert page.read_text() == PAGE
    monkeypatch.setattr(results, "run_benchmark", lambda name: OUTPUTS[name].replace("| cow | 2 |\n", ""))
    assert results.main([]) == 1
    assert page.read_text() == PAGE
    assert "would lose One: cow" in capsys.readouterr().err


def test_only_requested_sections_are_replaced(page, monkeypatch) -> None:
    monkeypatch.setattr(results, "run_benchmark", lambda name: OUTPUTS[name].replace(" 1 ", " 5 "))
    assert results.main(["--only", "two"]) == 0
    assert page.read_text() == PAGE.replace("| lion | 1 | 3 |", "| lion | 5 | 3 |")


@pytest.mark.parametrize("path", sorted(results.PAGES.glob("*.md")), ids=lambda path: path.stem)
def test_every_section_has_a_conclusion_a_command_and_tables(path) -> None:
    text = path.read_text("utf-8")
    for section in text.split("\n## ")[1:]:
        before, command, output = results.COMMAND.split(section)
        title, conclusion, rest = before.split("\n\n", 2)
        assert conclusion.endswith(".") and not rest, title
        assert (ROOT / "benchmarks" / command.split()[0]).is_file(), title
        assert len(results.rows(f"\n## {section}")[title]) > 3, title
        assert output.startswith("\n") and output.endswith("\n"), title


def test_the_first_table_has_its_finding_and_its_differences_from_the_paper() -> None:
    text = (ROOT / "docs" / "results" / "maps.md").read_text("utf-8")
    _, _, output = results.COMMAND.split(text.split("\n## ")[1])
    assert output.strip().startswith("On the paper's cow, cut by Seamster, F/3nt is")
    assert table1.DIFFERS in output
