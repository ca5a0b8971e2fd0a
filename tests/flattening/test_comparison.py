"""The comparison table: figures of all methods, and other programs if they are installed."""

from __future__ import annotations

import re

import igl
import numpy as np
import pytest
from commands import run
from conftest import load, read_pixels

from igl_linabf import FallbackWarning, LinABF, MeshError, compare, flatten, quality
from igl_linabf.flattening import METHODS
from igl_linabf.flattening import other_programs as peers


def test_every_method_has_its_row_with_its_figures() -> None:
    V, F = load("bumps")
    table = compare(V, F, list(METHODS), repeat=1, others=False)
    assert list(table.entries) == [method.label for method in METHODS.values()]
    for method, (label, entry) in zip(METHODS, table.entries.items(), strict=True):
        assert (entry.uv == flatten(V, F, method=method).uv).all()
        assert entry.quality == quality(V, F, entry.uv)
        assert entry.ratio > 0
        (line,) = (line for line in str(table).splitlines() if line.startswith(label + "  "))
        cells = re.split(r"\s{2,}", line.strip())
        assert cells[1:4] == [
            f"{entry.quality.angle_distortion:.4g}",
            f"{entry.quality.stretch_l2:.4g}",
            str(entry.quality.flips),
        ]
        assert cells[4] == str(entry.quality.overlaps)
        assert cells[5:7] == [f"{entry.seconds:.3f}", f"{entry.ratio:.2f}"]
        assert cells[-1] == entry.result.outcome.value
    assert table.entries["igl.lscm"].ratio == 1
    assert table.entries["igl.lscm"].iterations is None
    assert table.entries["linABF"].iterations == 2
    assert (table.maps["ABF"] == table.entries["ABF"].uv).all()


def test_options_reach_linear_abf_and_unused_vertices_are_ignored() -> None:
    V, F = load("bumps")
    with pytest.warns(UserWarning, match="belong to no face"):
        table = compare(
            np.vstack(([[9, 9, 9]], V)), F + 1, ["lscm", LinABF(iterations=3), "abf"], repeat=1, others=False
        )
    assert table.entries["linABF"].iterations == 3
    for uv in table.maps.values():
        assert np.isnan(uv[0]).all()
        assert np.isfinite(uv[1:]).all()


def test_compare_refuses_unknown_methods_and_closed_surfaces() -> None:
    with pytest.raises(ValueError, match="use some of 'linabf'"):
        compare(*load("bumps"), ["magic"])
    with pytest.raises(MeshError, match="closed"):
        compare(*igl.icosahedron())


@pytest.mark.parametrize("name", peers.PEERS)
def test_maps_of_other_installed_programs_are_compared(name: str) -> None:
    if name not in peers.list_installed_programs():
        pytest.skip(f"{peers.PEERS[name][0]} is not installed")
    V, F = load("bumps")
    entry = compare(V, F, ["lscm"], repeat=1).entries[name]
    assert entry.quality.flips == 0
    assert (
        entry.quality.angle_distortion < 1.2 * quality(V, F, flatten(V, F, method="lscm").uv).angle_distortion
    )
    assert entry.ratio > 0


def test_another_program_that_fails_is_left_out_with_a_warning(monkeypatch) -> None:
    monkeypatch.setattr(peers, "list_installed_programs", lambda: ["Blender ABF"])
    monkeypatch.setattr("sys.executable", "/bin/false")
    with pytest.warns(FallbackWarning, match=r"Blender ABF failed: exit code 1: it is left out"):
        table = compare(*load("bumps"), ["lscm"], repeat=1)
    assert list(table.entries) == ["igl.lscm"]


def test_the_command_prints_the_table_and_draws_the_maps(tmp_path) -> None:
    mesh, picture = tmp_path / "bumps.off", tmp_path / "maps.png"
    igl.write_triangle_mesh(str(mesh), *load("bumps"))
    process = run("compare", mesh, "--methods", "lscm,abf", "--repeat", 1, "--picture", picture)
    assert process.returncode == 0, process.stderr
    head, lscm, abf, *_ = process.stdout.splitlines()
    assert head.split("  ")[0] == ""
    assert lscm.startswith("igl.lscm ")
    assert abf.startswith("ABF ")
    assert read_pixels(picture).shape[0] % 700 == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bumps.off", "maps.png"]
