"""docs/results.md is the output of the benchmarks; runs with fewer meshes do not change the page."""

from __future__ import annotations

import results
import table1
from conftest import ROOT

PAGE = """# Results

## One

`python benchmarks/one.py`

It holds.

| mesh | time |
|---|---|
| lion | 1 |
| cow | 2 |

## Two

`python benchmarks/two.py`

| mesh | time | xatlas |
|---|---|---|
| lion | 1 | 3 |
"""


def test_lost_meshes_columns_and_sections_are_named() -> None:
    assert results.find_losses(PAGE, PAGE) == []
    without_cow = PAGE.replace("| cow | 2 |\n", "| horse | 2 |\n| bunny | 1 |\n")
    assert results.find_losses(PAGE, without_cow) == ["One: cow"]
    assert results.find_losses(PAGE, PAGE.replace(" xatlas |", "")) == ["Two: column xatlas"]
    (loss,) = results.find_losses(PAGE, PAGE.split("## Two")[0])
    assert loss.startswith("Two: ")
    assert results.find_losses("", PAGE) == []


def test_a_run_with_fewer_meshes_does_not_change_the_page(tmp_path, monkeypatch, capsys) -> None:
    page = tmp_path / "results.md"
    page.write_text(PAGE)
    monkeypatch.setattr(results, "PAGE", page)
    monkeypatch.setattr(results, "SECTIONS", [("One", "one.py"), ("Two", "two.py")])
    sections = {part.split("\n")[0]: f"\n## {part}" for part in PAGE.split("\n## ")[1:]}
    monkeypatch.setattr(results, "run_section", lambda title, _: sections[title].replace("| cow | 2 |\n", ""))
    assert results.main([]) == 1
    assert page.read_text("utf-8") == PAGE
    assert "would lose One: cow" in capsys.readouterr().err
    monkeypatch.setattr(results, "run_section", lambda title, _: sections[title])
    assert results.main([]) == 0
    assert results.rows(page.read_text("utf-8")) == results.rows(PAGE)


def test_the_page_has_every_section_under_its_command() -> None:
    page = (ROOT / "docs" / "results.md").read_text("utf-8")
    for title, command in results.SECTIONS:
        assert f"## {title}\n\n`python benchmarks/{command}`\n" in page
        assert len(results.rows(page)[title]) > 3
    assert table1.DIFFERS in page


def test_the_page_starts_with_the_finding_of_the_first_table() -> None:
    page = (ROOT / "docs" / "results.md").read_text("utf-8")
    first = page.split("\n\n")[1]
    title, command = results.SECTIONS[0]
    assert first.startswith("On the paper's cow, cut by Seamster, F/3nt is")
    assert f"## {title}\n\n`python benchmarks/{command}`\n\n{first}" in page


def test_only_requested_sections_are_replaced(tmp_path, monkeypatch) -> None:
    page = tmp_path / "results.md"
    page.write_text(PAGE)
    monkeypatch.setattr(results, "PAGE", page)
    monkeypatch.setattr(results, "SECTIONS", [("One", "one.py"), ("Two", "two.py")])
    sections = {part.split("\n")[0]: f"\n## {part}" for part in PAGE.split("\n## ")[1:]}
    monkeypatch.setattr(results, "run_section", lambda title, _: sections[title].replace(" 1 ", " 5 "))
    assert results.main(["--only", "two"]) == 0
    assert "| lion | 1 |" in page.read_text() and "| lion | 5 | 3 |" in page.read_text()
