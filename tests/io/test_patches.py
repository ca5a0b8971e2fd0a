"""FreeSurfer patches are read on their surface, with warnings, and written for FreeSurfer's tools."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import igl
import numpy as np
import pytest
from conftest import load

from igl_linabf import MeshError, MeshWarning, flatten
from igl_linabf.io import read_file, write_file, write_patch

freesurfer = pytest.importorskip("nibabel.freesurfer")
ROW = [("vertex", ">i4"), ("place", ">f4", 3)]


def make_ball() -> tuple[np.ndarray, np.ndarray]:
    V, F = igl.upsample(*igl.icosahedron(), 4)
    return V / np.linalg.norm(V, axis=1)[:, None] * 50, F


def read_rows(path: Path) -> np.ndarray:
    return np.frombuffer(path.read_bytes(), ROW, offset=8)


def write_ball_patch(folder: Path, stays: np.ndarray, border: np.ndarray | None = None) -> Path:
    """Write a patch of the ball and its surface; the patch has other positions than the surface."""
    V, F = make_ball()
    freesurfer.write_geometry(folder / "lh.fiducial", V, F)
    path = folder / "lh.full.patch.3d"
    vertex = np.flatnonzero(stays)
    edge = np.zeros(len(V), dtype=bool) if border is None else border
    write_patch(str(path), vertex, edge[vertex], V[vertex] * 1.2)
    return path


def test_a_patch_keeps_the_numbers_and_flags_of_its_vertices_from_file_to_flat_file(tmp_path: Path) -> None:
    V, F = make_ball()
    stays = V[:, 2] < 20
    border = np.zeros(len(V), dtype=bool)
    # a border that differs from the default border
    border[igl.boundary_loop(F[stays[F].all(axis=1)])[::2]] = True
    mesh = read_file(write_ball_patch(tmp_path, stays, border))
    assert len(mesh.V) == len(V)
    # the positions come from the surface, not from the patch
    np.testing.assert_allclose(mesh.V, V, atol=1e-4)
    assert {tuple(face) for face in mesh.F.tolist()} == {tuple(f) for f in F[stays[F].all(axis=1)].tolist()}
    with pytest.warns(MeshWarning, match="belong to no face"):
        uv = flatten(mesh.V, mesh.F, method="isometric").uv
    flat = tmp_path / "lh.full.flat.patch.3d"
    write_file(flat, mesh, uv)
    rows = read_rows(flat)
    assert (np.abs(rows["vertex"]) - 1 == np.flatnonzero(stays)).all()
    assert ((rows["vertex"] < 0) == border[stays]).all()
    again = read_file(flat)
    assert again.TC is not None and again.FTC is not None
    np.testing.assert_allclose(again.TC[again.FTC], uv[mesh.F], rtol=1e-5, atol=1e-4)


def test_a_patch_needs_a_surface_found_by_name_or_passed(tmp_path: Path) -> None:
    V, F = make_ball()
    path = write_ball_patch(tmp_path, V[:, 2] < 20)
    (tmp_path / "lh.fiducial").rename(tmp_path / "lh.mine")
    with pytest.raises(MeshError, match=r"no faces, and its surface is not beside it: .*lh\.fiducial"):
        read_file(path)
    given = read_file(path, surface=tmp_path / "lh.mine")
    for name, scale in (("smoothwm", 0.9), ("pial", 1.1)):
        freesurfer.write_geometry(tmp_path / f"lh.{name}", V * scale, F)
    between = read_file(path)  # without a fiducial surface, the mean of smoothwm and pial
    np.testing.assert_allclose(between.V, given.V, atol=1e-4)
    with pytest.raises(ValueError, match="leave out the surface"):
        read_file(tmp_path / "lh.mine", surface=tmp_path / "lh.pial")
    freesurfer.write_geometry(tmp_path / "lh.small", *igl.icosahedron())
    with pytest.raises(MeshError, match=r"lh\.small has 12: pass the surface"):
        read_file(path, surface=tmp_path / "lh.small")


def test_pieces_crumbs_pinched_borders_and_closed_slits_are_reported(tmp_path) -> None:
    V, F = make_ball()
    stays = (V[:, 2] < 20) | (V[:, 2] > 30)  # a second piece: a cap
    neighbours = igl.adjacency_list(F)
    lowest = int(V[:, 2].argmin())
    ring = set(neighbours[lowest])
    second = {far for near in ring for far in neighbours[near]} - ring - {lowest}
    stays[list(ring)] = False  # isolates the lowest vertex
    beyond = next(  # a vertex with a single neighbour in the second ring
        far for near in second for far in neighbours[near] if len(second.intersection(neighbours[far])) == 1
    )
    stays[beyond] = False  # a second hole that touches the first one at a vertex
    border = np.zeros(len(V), dtype=bool)
    inside = int(np.argmin(np.linalg.norm(V - [50, 0, 0], axis=1)))
    border[[inside, neighbours[inside][0]]] = True
    path = write_ball_patch(tmp_path, stays, border)
    with pytest.warns(MeshWarning) as caught:
        mesh = read_file(path)
    (warning,) = caught
    text = str(warning.message)
    cap = int((V[:, 2] > 30).sum())
    assert f"another piece of {cap} vertices" in text
    assert f"vertices {lowest}, which have no face" in text
    assert "at which the border touches itself" in text
    assert "closed slits at vertices" in text
    assert str(inside) in text
    result = flatten(*igl.remove_unreferenced(mesh.V, mesh.triangles)[:2])
    assert result.outcome.good
    assert len(result.holes) == 1  # both holes share a vertex and form a single hole


@pytest.mark.parametrize("damage", ["short", "zero", "twice", "nan", "other"])
def test_damaged_patches_are_refused_by_name(tmp_path: Path, damage: str) -> None:
    V, _ = make_ball()
    path = write_ball_patch(tmp_path, V[:, 2] < 20)
    data, rows = path.read_bytes(), read_rows(path).copy()
    if damage == "zero":
        rows["vertex"][3] = 0
    elif damage == "twice":
        rows["vertex"][3] = -rows["vertex"][4]
    elif damage == "nan":
        rows["place"][3] = np.nan
    path.write_bytes(
        b"off" if damage == "other" else data[:-5] if damage == "short" else data[:8] + rows.tobytes()
    )
    with pytest.raises(MeshError, match=r"lh\.full\.patch\.3d cannot be read as a patch: it"):
        read_file(path)


def find_pycortex_python() -> str:
    """Return a Python with pycortex: this one or the one in IGL_LINABF_PYCORTEX; otherwise skip the test."""
    with suppress(PackageNotFoundError):
        version("pycortex")
        return sys.executable
    named = os.environ.get("IGL_LINABF_PYCORTEX")
    if named is None:
        pytest.skip("pycortex is not installed: set IGL_LINABF_PYCORTEX to a Python that has it")
    return named


def test_pycortex_opens_written_patches(tmp_path: Path) -> None:
    python = find_pycortex_python()
    surf = tmp_path / "sub" / "surf"
    surf.mkdir(parents=True)
    V, F = load("bumps")
    freesurfer.write_geometry(surf / "lh.smoothwm", V, F)
    mesh = read_file(surf / "lh.smoothwm")
    uv = flatten(mesh.V, mesh.F).uv
    with pytest.warns(MeshWarning, match="positions in space"):
        write_file(surf / "lh.mine.flat.patch.3d", mesh, uv)
    script = (
        "import numpy as np, cortex.freesurfer as f\n"
        "if not hasattr(np, 'fromstring') or np.lib.NumpyVersion(np.__version__) >= '2.3.0':\n"
        "    np.fromstring = lambda data, dtype: np.frombuffer(data, dtype).copy()\n"
        f"folder = r'{tmp_path}'\n"
        "read = f.get_surf('sub', 'lh', 'patch', 'mine.flat', freesurfer_subject_dir=folder)\n"
        "np.savez(folder + '/read.npz', pts=read[0], polys=read[1], at=read[2])"
    )
    done = subprocess.run([python, "-c", script], capture_output=True, encoding="utf-8", timeout=500)
    assert done.returncode == 0, done.stderr
    with np.load(tmp_path / "read.npz") as read:
        np.testing.assert_allclose(read["pts"][:, :2], uv, atol=1e-5 * np.ptp(uv))
        assert (read["polys"] == F).all()
        assert set(np.flatnonzero(read["at"] < 0)) == set(igl.boundary_loop(F).tolist())
