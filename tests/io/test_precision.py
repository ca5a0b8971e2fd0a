"""Coordinates far from the origin and of tiny bodies keep their digits, or a warning reports the rounding."""

from __future__ import annotations

import warnings
from pathlib import Path

import igl
import numpy as np
import pytest

from igl_linabf import MeshError, MeshWarning
from igl_linabf.io import read_file, write_mesh

V, F = igl.icosahedron()
SURVEY = np.array([5e5, 5.4e6, 412.7])
PACKAGES = {".3mf": "lib3mf", ".vtp": "pyvista"}


def round_trip(path: Path, positions: np.ndarray) -> np.ndarray:
    """Write and read a mesh; return the positions at the corners of its triangles."""
    if path.suffix in PACKAGES:
        pytest.importorskip(PACKAGES[path.suffix])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write_mesh(
            path, positions, F, np.random.default_rng(0).random((3 * len(F), 2)), np.arange(60).reshape(-1, 3)
        )
        mesh = read_file(path)
    return mesh.V[mesh.triangles]


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".3mf", ".vtp", ".ply", ".obj"])
def test_a_body_far_from_the_origin_keeps_its_shape_and_place(suffix: str, tmp_path: Path) -> None:
    for origin in (SURVEY, 3e4 * SURVEY, -SURVEY / 7, np.zeros(3)):
        for size in (1.0, 1e3):
            given = size * V[F] + origin
            if suffix == ".3mf" and np.abs(given).max() > 1e9:
                continue  # 3MF writes translations with six digits
            found = round_trip(tmp_path / f"a{suffix}", size * V + origin)
            # compare in single precision relative to the size, up to a shift by the rounded translation in
            # 3MF
            shift = (found - given).mean(axis=(0, 1))
            assert np.abs(found - given - shift).max() < 2e-5 * size
            assert np.abs(shift).max() <= 1e-7 * np.abs(origin).max() * (suffix == ".3mf") + 1e-6 * size


@pytest.mark.parametrize("suffix", [".glb", ".3mf"])
def test_a_tiny_body_keeps_its_shape(suffix: str, tmp_path: Path) -> None:
    found = round_trip(tmp_path / f"a{suffix}", 1e-7 * V)
    assert np.abs(found / 1e-7 - V[F]).max() < 1e-5


def test_rounding_to_single_precision_is_reported(tmp_path: Path) -> None:
    positions = 1e-42 * V
    with pytest.warns(MeshWarning, match=r"V is rounded by up to .* of its extent, .* write OBJ"):
        write_mesh(tmp_path / "a.glb", positions, F, V[:, :2])
    with pytest.warns(MeshWarning, match=r"TC is rounded by up to .* of its extent"):
        write_mesh(tmp_path / "b.glb", V, F, V[:, :2] + 1e7)


def test_coordinates_too_large_for_lib3mf_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("lib3mf")
    with pytest.raises(MeshError, match=r"the number 1e\+12, and 3MF takes at most 1e\+09"):
        write_mesh(tmp_path / "a.3mf", 1e12 * V / np.abs(V).max(), F, V[:, :2])
    assert not (tmp_path / "a.3mf").exists()
