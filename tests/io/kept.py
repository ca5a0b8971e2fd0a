"""What a cell of docs/kept.md is, and how each is tried: a file is written, read, and written again."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from igl_linabf.io import MeshFile, read_file, write_file

Outcome = Literal["kept", "told", "refused"]


@dataclass(frozen=True)
class Cell:
    """A row of the page.

    Attributes
    ----------
    source, to : the formats that are read and written, by the names that the page has
    what : what the file has
    outcome : "kept" (and no warning), "told" (one MeshWarning), or "refused" (a MeshError)
    act : writes a file into an empty folder, carries it over with `carried`, and asserts what is there
    says : words of the warning or error; the page shows them
    """

    source: str
    to: str
    what: str
    outcome: Outcome
    act: Callable[[Path], object]
    says: str = ""


def carried(folder: Path, name: str, data: bytes | str, to: str = "out.obj") -> tuple[MeshFile, MeshFile]:
    """A file read and written with an atlas that cuts every edge; what it was, and what it is then.

    It is written to another folder than it is read from, so that relative names have something to lose.
    """
    source, out = folder / "in" / name, folder / "out" / to
    for path in (source, out):
        path.parent.mkdir(exist_ok=True)
    source.write_bytes(data if isinstance(data, bytes) else data.encode())
    mesh = read_file(source)
    TC = np.random.default_rng(0).random((len(mesh.polygons.corners), 2))
    FTC = mesh.polygons.shape(np.arange(len(TC)))
    write_file(out, mesh, TC, FTC)
    return mesh.textured(TC, FTC), read_file(out)


def tables(cells: Iterable[Cell]) -> str:
    """The sections of the page: a format that is read each, in the order of the cells."""
    sections: dict[str, list[str]] = {}
    for cell in cells:
        rows = sections.setdefault(
            cell.source, ["| what it has | written as | what becomes of it |", "|---|---|---|"]
        )
        said = f": “{cell.says}”" if cell.says else ""
        rows.append(f"| {cell.what} | {cell.to} | {cell.outcome}{said} |")
    return "\n\n".join("\n".join([f"## {name}", "", *rows]) for name, rows in sections.items()) + "\n"
