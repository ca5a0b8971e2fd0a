"""The cells of docs/kept.md, and their tests: write a file, read the file, and write the mesh again."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from igl_linabf.io import MeshFile, read_file, write_file

Outcome = Literal["kept", "warning", "error"]


@dataclass(frozen=True)
class Cell:
    """A row of a table in docs/kept.md.

    Attributes
    ----------
    source, to : formats that are read and written, as named on the page
    what : the contents of the file
    outcome : "kept" (without a warning), "warning" (one MeshWarning), or "error" (a MeshError)
    act : writes a file into an empty folder, calls `round_trip`, and checks the result
    says : part of the text of the warning or error, shown on the page
    """

    source: str
    to: str
    what: str
    outcome: Outcome
    act: Callable[[Path], object]
    says: str = ""


def round_trip(folder: Path, name: str, data: bytes | str, to: str = "out.obj") -> tuple[MeshFile, MeshFile]:
    """Read a file, and write it with an atlas that cuts every edge; return both meshes.

    The new file is in another folder, so that relative paths have to change.
    """
    source, out = folder / "in" / name, folder / "out" / to
    for path in (source, out):
        path.parent.mkdir(exist_ok=True)
    source.write_bytes(data if isinstance(data, bytes) else data.encode())
    mesh = read_file(source)
    TC = np.random.default_rng(0).random((len(mesh.polygons.corners), 2))
    FTC = mesh.polygons.reshape_like_faces(np.arange(len(TC)))
    write_file(out, mesh, TC, FTC)
    return mesh.with_texture(TC, FTC), read_file(out, allow_outside=True)


def format_tables(cells: Iterable[Cell]) -> str:
    """Return the text of docs/kept.md: a section for each format that is read, in the order of `cells`."""
    sections: dict[str, list[str]] = {}
    for cell in cells:
        rows = sections.setdefault(
            cell.source, ["| contents of the file | written as | result |", "|---|---|---|"]
        )
        result = {"kept": "preserved"}.get(cell.outcome, f"{cell.outcome}: “{cell.says}”")
        rows.append(f"| {cell.what} | {cell.to} | {result} |")
    return "\n\n".join("\n".join([f"## {name}", "", *rows]) for name, rows in sections.items()) + "\n"
