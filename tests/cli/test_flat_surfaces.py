"""A flat map written as a surface has the size of the original surface."""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pytest
from conftest import load

from igl_linabf.cli import main
from igl_linabf.io import read_file, write_mesh

nibabel = pytest.importorskip("nibabel")


def area(V: np.ndarray, F: np.ndarray) -> float:
    return float(igl.doublearea(V, F).sum() / 2)


@pytest.mark.parametrize("how", ["flatten", "unwrap", "batch"])
def test_a_flat_surface_has_the_area_of_the_surface(how: str, tmp_path: Path) -> None:
    V, F = load("bumps")
    V = 40 * V
    write_mesh(tmp_path / "a.obj", V, F, V[:, :2])
    for suffix in (".surf.gii", ".surf.gii.gz", ".surf"):
        out = tmp_path / f"a{suffix}"
        words = [str(tmp_path / "a.obj"), "-o", str(out), "--quiet"]
        if how == "batch":
            pytest.importorskip("distributed")
            if suffix != ".surf":
                continue
            words = [str(tmp_path / "a.obj"), "-o", str(tmp_path / "maps"), "--format", "surf"]
            words += ["--how", "flatten", "--workers", "1"]
            out = tmp_path / "maps" / "a.surf"
        assert main([how, *words]) == 0
        mesh = read_file(out)
        assert area(mesh.V, mesh.F) == pytest.approx(area(V, F), rel=0.02)
        assert not mesh.V[:, 2].any()


def test_requested_units_are_used(tmp_path: Path) -> None:
    V, F = load("bumps")
    write_mesh(tmp_path / "a.obj", 40 * V, F, V[:, :2])
    sizes = {}
    for units in ("square", "mesh"):
        for suffix in (".surf", ".obj"):
            out = tmp_path / f"{units}{suffix}"
            assert (
                main(["flatten", str(tmp_path / "a.obj"), "-o", str(out), "--units", units, "--quiet"]) == 0
            )
            mesh = read_file(out)
            sizes[units, suffix] = np.ptp(mesh.V[:, :2] if suffix == ".surf" else mesh.TC, axis=0).max()
    assert sizes["square", ".surf"] == pytest.approx(1)
    assert sizes["square", ".obj"] == pytest.approx(1)
    assert sizes["mesh", ".surf"] == pytest.approx(sizes["mesh", ".obj"], rel=1e-4)
    assert sizes["mesh", ".obj"] > 40


def test_batch_accepts_units_only_for_flatten(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    V, F = load("bumps")
    write_mesh(tmp_path / "a.obj", 40 * V, F, V[:, :2])
    words = [str(tmp_path / "a.obj"), "-o", str(tmp_path / "maps"), "--workers", "1", "--units", "mesh"]
    assert main(["batch", *words]) == 2
    assert main(["batch", *words, "--how", "flatten"]) == 0
    assert np.ptp(read_file(tmp_path / "maps" / "a.obj").TC, axis=0).max() > 40
