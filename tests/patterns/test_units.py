"""A pattern has the size that its file states, and the command reports the unit."""

from __future__ import annotations

import json
from pathlib import Path

import igl
import numpy as np
import pytest

from igl_linabf import unwrap
from igl_linabf.cli import main
from igl_linabf.io import MeshFile, read_file, write_file, write_mesh
from igl_linabf.io.parsing import Extras
from igl_linabf.patterns import write_pattern
from igl_linabf.surface import Polygons

V, F = igl.icosahedron()
LENGTH = {"meter": 1000.0, "inch": 25.4, "centimeter": 10.0, "foot": 304.8, "micron": 1e-3, "millimeter": 1.0}


def icosahedron(path: Path, unit: str | None) -> Path:
    """Write an icosahedron with edges of length one in the given unit."""
    pytest.importorskip("lib3mf" if path.suffix == ".3mf" else "numpy")
    side = np.linalg.norm(V[F[0, 0]] - V[F[0, 1]])
    mesh = MeshFile(V / side, Polygons.from_faces(F), extras=Extras(units=unit))
    write_file(path, mesh, np.zeros((len(V), 2)) + V[:, :2])
    return path


def run_pattern_command(path: Path, capsys: pytest.CaptureFixture[str], *more: str) -> dict:
    """Run the command `pattern`, and return its JSON output."""
    pytest.importorskip("svgwrite")
    assert main(["pattern", str(path), "-o", str(path.with_suffix(".svg")), "--json", *more]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("unit", LENGTH)
def test_a_pattern_has_the_unit_of_its_file(
    unit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = {"a.3mf": 1.0, "b.glb": 1000.0}  # lengths in GLB are in metres
    for name, edge in paths.items():
        path = icosahedron(tmp_path / name, unit)
        output = run_pattern_command(path, capsys)
        edge = LENGTH[unit]
        lengths = [seam["length"] for seam in output["pattern"]["seams"]]
        assert np.allclose(np.mod(np.array(lengths) / edge + 0.5, 1), 0.5, atol=1e-3)
        assert output["units_given_by"] == "file"
        mesh = read_file(path)
        made = write_pattern(tmp_path / "c.svg", mesh.V, mesh.F, unwrap(mesh.V, mesh.F), mesh.units)
        assert made.units == mesh.units == output["pattern"]["units"]
        assert min(seam.length for seam in made.seams) == pytest.approx(min(lengths))


def test_millimetres_are_the_reported_default(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.obj"
    write_mesh(path, V, F, V[:, :2])
    assert read_file(path).units is None
    assert run_pattern_command(path, capsys)["units_given_by"] == "default"
    assert main(["pattern", str(path), "-o", str(tmp_path / "a.svg"), "--force"]) == 0
    assert (
        "the surface is in mm (the default, because its file does not state a unit: see --units)"
        in capsys.readouterr().out
    )
    asked = run_pattern_command(icosahedron(tmp_path / "b.glb", "meter"), capsys, "--units", "cm")
    assert (asked["units_given_by"], asked["pattern"]["units"]) == ("option", "cm")
    assert min(seam["length"] for seam in asked["pattern"]["seams"]) == pytest.approx(10, rel=1e-5)
