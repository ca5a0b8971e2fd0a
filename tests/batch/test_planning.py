"""A batch plans exactly the meshes that are missing, changed or incomplete."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import igl
import pytest

from igl_linabf.batch import places
from igl_linabf.batch.one_mesh import Settings, Task
from igl_linabf.batch.running import _plan_tasks
from igl_linabf.batch.table import Row, Table, append_to_journal
from igl_linabf.flattening import resolve_method

SETTINGS = Settings("unwrap", resolve_method("linabf"), "obj")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Create a folder with two meshes, one of them in a subfolder."""
    (tmp_path / "in" / "deep").mkdir(parents=True)
    for name in ("in/a.obj", "in/deep/b.off"):
        igl.write_triangle_mesh(str(tmp_path / name), *igl.icosahedron())
    return tmp_path / "in"


def plan_tasks(folder: Path, out: Path, settings: Settings = SETTINGS, retry: bool = False) -> list[Task]:
    """Return the tasks of a batch over a folder."""
    with Table(str(out)) as table:
        return _plan_tasks(places.find_inputs([folder], str(out)), table, settings, retry, force=False)


def names(tasks: list[Task]) -> list[str]:
    return [task.row.output for task in tasks]


def write_results(tasks: list[Task], out: Path, outcome: str = "valid") -> None:
    """Create the maps and the table rows that a batch leaves behind."""
    with Table(str(out)) as table:
        for task in tasks:
            path = out / task.row.output
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
            table.add_row(replace(task.row, outcome=outcome, charts=1))


def test_only_missing_and_changed_meshes_are_planned_again(folder: Path) -> None:
    out = folder / "maps"  # maps in the input folder are not inputs
    first = plan_tasks(folder, out)
    assert names(first) == ["a.obj", "deep/b.obj"]
    write_results(first, out)
    assert plan_tasks(folder, out) == []
    (out / "deep/b.obj").unlink()
    assert names(plan_tasks(folder, out)) == ["deep/b.obj"]
    write_results(plan_tasks(folder, out), out)
    now = os.stat(folder / "a.obj").st_mtime_ns
    os.utime(folder / "a.obj", ns=(now, now + 10**9))  # change only the time of the file, not its size
    assert names(plan_tasks(folder, out)) == ["a.obj"]


def test_other_settings_repeat_all_meshes_but_more_memory_repeats_none(folder: Path, tmp_path: Path) -> None:
    write_results(plan_tasks(folder, tmp_path / "out"), tmp_path / "out")
    assert plan_tasks(folder, tmp_path / "out", replace(SETTINGS, memory=2**30)) == []
    assert len(plan_tasks(folder, tmp_path / "out", replace(SETTINGS, method=resolve_method("lscm")))) == 2


@pytest.mark.parametrize(
    ("outcome", "again", "with_retry"),
    [
        ("valid", False, False),
        ("refused", False, False),
        ("failed", False, True),
        ("died", False, True),
        ("out of memory", False, True),
        ("unreadable", True, True),
        ("waiting", True, True),
    ],
)
def test_only_the_expected_outcomes_are_retried(
    outcome: str, again: bool, with_retry: bool, folder: Path, tmp_path: Path
) -> None:
    for retry, expected in ((False, again), (True, with_retry)):
        out = tmp_path / f"out {retry}"
        write_results(plan_tasks(folder, out), out, outcome)
        assert len(plan_tasks(folder, out, retry=retry)) == 2 * expected


def test_complete_rows_of_a_killed_run_are_kept(folder: Path, tmp_path: Path) -> None:
    first, second = plan_tasks(folder, tmp_path / "out")
    for task in (first, second):
        (tmp_path / "out" / task.row.output).parent.mkdir(exist_ok=True)
        (tmp_path / "out" / task.row.output).touch()
        append_to_journal(replace(task.row, outcome="valid", charts=1), str(tmp_path / "out"))
    (journal,) = (tmp_path / "out").glob(".results.journal*")
    journal.write_bytes(journal.read_bytes()[:-20])
    assert names(plan_tasks(folder, tmp_path / "out")) == [second.row.output]


def test_rows_of_other_meshes_are_kept(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_results(plan_tasks(folder, out), out)
    plan_tasks(folder / "deep", out)
    with Table(str(out)) as table:
        row = table.get_row(str(folder / "a.obj"))
    assert row == Row(str(folder / "a.obj"), "a.obj", "valid", charts=1, key=row.key)


def test_names_that_differ_only_in_case_get_different_outputs(folder: Path, tmp_path: Path) -> None:
    (folder / "A.off").write_bytes((folder / "deep/b.off").read_bytes())
    found = [name.casefold() for name in names(plan_tasks(folder, tmp_path / "out"))]
    assert len(found) == len(set(found)) == 3
