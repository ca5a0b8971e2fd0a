"""Hostile meshes and files cause no crash, no NaN in good results, no incomplete file, and no message without
a place.

`benchmarks/fuzz.py` runs ten thousand of these cases.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import gltf_files
import igl
import numpy as np
import pytest
from fuzzing import KINDS, run_all
from hostile_files import good_files, mutate
from hostile_meshes import Disk, check_disk, check_guarantee, find_flipped_exactly, has_place
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import igl_linabf as il
from igl_linabf.io import read_file, write_file, write_mesh
from igl_linabf.io.formats import parse_bytes
from igl_linabf.io.mesh_file import gather_at_triangles

# cases that broke a promise in earlier versions
FOUND = [
    ("`flatten`, random disks", 18),  # fourth powers overflowed, and a result was NaN
    ("`flatten`, random disks", 1303),  # an internal error in the rows that close holes
    ("`quality`, `overlaps`, `layout`, `cut`", 0),  # NaN for a map as large as 1e300
    ("`quality`, `overlaps`, `layout`, `cut`", 94),  # an infinite loop for three overlapping faces
    ("`unwrap`, any triangles", 11633),  # a singular system of angles in the last attempt
    ("`unwrap`, any triangles", 14417),  # a singular layout
    ("`unwrap`, any triangles", 14435),  # a chart as thin as the rounding error
    ("`unwrap`, mixtures of nasty and real meshes", 459),  # a singular layout while seams are compared
    ("damaged files, `igl-linabf flatten`", 350),  # an index beyond 64 bits
]
SUFFIXES = [".obj", ".off", ".ply", ".stl"]
steady = settings(
    derandomize=True, deadline=None, database=None, suppress_health_check=[HealthCheck.too_slow]
)


def test_some_cases_of_every_kind_keep_the_promises() -> None:
    share = 300 / sum(number for _, number in KINDS.values())
    cases = [(kind, seed) for kind, (_, number) in KINDS.items() for seed in range(int(share * number))]
    results = run_all(cases + FOUND)
    broken = [line for _, lines in results.values() for line in lines]
    assert not broken, "\n".join(broken)
    ends = {end.split(":")[0] for count, _ in results.values() for end in count}
    assert {"converged", "valid", "flipped", "refused", "good", "measured", "the same"} <= ends


disks = st.builds(
    Disk,
    n=st.integers(4, 120),
    relief=st.floats(0, 3),
    noise=st.sampled_from([0, 0.05, 0.3]),
    holes=st.integers(0, 3),
    slivers=st.integers(0, 3),
    thin=st.integers(2, 17),
    scale=st.sampled_from([0, 0, 0, -50, 50, -150, 150]),
    seed=st.integers(0, 2**32 - 1),
)


@settings(steady, max_examples=60)
@given(disks, st.sampled_from(["linabf", "linabf", "abf", "lscm"]))
def test_a_disk_is_flattened_or_refused_with_its_place(disk: Disk, method: str) -> None:
    check_disk(disk, method)


def check_bytes(data: bytes, suffix: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", il.MeshWarning)
        try:
            mesh = parse_bytes(data, suffix, f"a/file{suffix}")
        except il.MeshError as error:
            assert has_place(str(error)), error
            assert "a/file" in str(error)
            return
    F = gather_at_triangles(mesh, mesh.polygons.corners)
    assert mesh.V.shape[1:] == F.shape[1:] == (3,)
    if mesh.texture is not None:
        assert gather_at_triangles(mesh, mesh.texture).shape == F.shape
    if len(F):
        assert F.min() >= 0
        assert F.max() < len(mesh.V)


@settings(steady, max_examples=150)
@given(
    st.binary(max_size=300), st.sampled_from(SUFFIXES), st.sampled_from([b"", b"OFF\n", b"ply\n", b"solid"])
)
@example(b"f " + b"9" * 5000, ".obj", b"")
@example(b"4000000000 4000000000 0\n", ".off", b"OFF\n")
@example(b"1 1 0\n0 0 0 " + b"9" * 5000, ".off", b"OFF\n")
@example(
    b"format binary_little_endian 1.0\nelement vertex 4000000000\nproperty int x\nend_header\n",
    ".ply",
    b"ply\n",
)
def test_any_bytes_are_read_or_refused(data: bytes, suffix: str, head: bytes) -> None:
    check_bytes(head + data, suffix)


@settings(steady, max_examples=150)
@given(st.integers(0, 2**32 - 1), st.sampled_from(SUFFIXES))
def test_damaged_files_are_read_or_refused(seed: int, suffix: str) -> None:
    rng = np.random.default_rng(seed)
    files = good_files(rng)[suffix[1:]]
    check_bytes(mutate(files[rng.integers(len(files))], rng), suffix)


def write_file_of_format(folder: Path, name: str) -> None:
    """Write an undamaged file of a scene format, or of a format that another package reads."""
    if name == "a.glb":
        gltf_files.write_scene(folder / name)
        return
    V, F = igl.icosahedron()
    atlas = il.unwrap(V, F)
    TC, FTC = (il.linabf(V, F[1:]), None) if name in ("a.surf.gii", "a.surf") else (atlas.TC, atlas.FTC)
    write_mesh(folder / name, V, F if FTC is not None else F[1:], TC, FTC)


@pytest.mark.parametrize("name", ["a.glb", "a.gltf", "a.vtp", "a.surf.gii", "a.surf", "a.3mf"])
def test_damaged_scenes_and_files_of_packages_are_read_or_refused_in_one_sentence(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    package = {".vtp": "pyvista", ".gii": "nibabel", ".surf": "nibabel", ".3mf": "lib3mf"}
    pytest.importorskip(package.get(Path(name).suffix, "igl_linabf"))
    write_file_of_format(tmp_path, name)
    data, refused = (tmp_path / name).read_bytes(), 0
    for seed in range(100):
        (tmp_path / name).write_bytes(mutate(data, np.random.default_rng(seed)))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", il.MeshWarning)
            try:
                mesh = read_file(tmp_path / name)
            except il.MeshError as error:
                assert name in str(error)
                assert "\n" not in str(error)
                refused += 1
                continue
        assert mesh.triangles.min() >= 0
        assert mesh.triangles.max() < len(mesh.V)
    assert refused > 50
    # nothing is printed, although readers such as VTK print errors and continue
    assert capfd.readouterr() == ("", "")


def test_a_vtp_array_with_one_texture_coordinate_is_data_and_not_a_map(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    V, F = igl.icosahedron()
    given = pyvista.PolyData.from_regular_faces(V, F)
    given.point_data["ramp"] = np.arange(12.0)
    given.GetPointData().SetActiveTCoords("ramp")
    given.save(tmp_path / "a.vtp")
    mesh, atlas = read_file(tmp_path / "a.vtp"), il.unwrap(V, F)
    assert mesh.TC is None
    write_file(tmp_path / "b.vtp", mesh, atlas.TC, atlas.FTC)
    found = pyvista.read(tmp_path / "b.vtp")
    assert np.allclose(found.points[found["ramp"] == 5], V[5])
    with pytest.warns(il.MeshWarning, match="the arrays ramp"):
        write_file(tmp_path / "b.obj", mesh, atlas.TC, atlas.FTC)


def test_a_gifti_with_a_broken_transform_is_read_and_its_loss_reported(tmp_path: Path) -> None:
    pytest.importorskip("nibabel")
    write_file_of_format(tmp_path, "a.surf.gii")
    text = (tmp_path / "a.surf.gii").read_text("utf-8")
    head, _, rest = text.partition("<MatrixData>")
    assert rest
    (tmp_path / "a.surf.gii").write_text(f"{head}<MatrixData>1 0 0 0\n{rest}", "utf-8")
    mesh = read_file(tmp_path / "a.surf.gii")
    with pytest.warns(il.MeshWarning, match="its coordinate systems"):
        write_file(tmp_path / "b.obj", mesh, mesh.V[:, :2])


@pytest.mark.parametrize(
    ("message", "names"),
    [
        ("faces 3, 7 have zero area: remove them", True),
        ("F has the shape (4, 2): pass #F by 3", True),
        ("the mesh has 2 components: use unwrap", True),
        ("a/b.ply cannot be read: its header has no end_header", True),
        ("it failed after 3 tries: use another mesh", False),
        ("and/or the mesh is bad", False),
        ("40 faces are bad: remove them", False),
        ("some face is bad (residual 3.2e-5): remove it", False),
    ],
)
def test_a_digit_or_a_slash_is_not_a_place(message: str, names: bool) -> None:
    assert has_place(message) == names


def test_the_guarantee_is_used_where_maps_flip() -> None:
    ends = [check_guarantee(seed) for seed in range(12)]
    assert sum(end.endswith("by the guarantee") for end in ends) >= 2


def test_the_exact_test_of_orientation_is_exact() -> None:
    # points 1e-17 away from a line, which products in double precision do not distinguish from the line
    uv = np.array([[0, 0], [1, 1], [0.5, 0.5 + 2.0**-53], [0.5, 0.5], [0.5, 0.5 - 2.0**-54]])
    F = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    assert find_flipped_exactly(uv, F).tolist() == [1, 2]


def test_random_disks_have_their_parameters() -> None:
    for seed in range(40):
        disk = Disk(n=100, holes=seed % 4, slivers=seed % 3, thin=3, seed=seed)
        V, F = disk.build()
        assert len(il.flatten(V, F).holes) == disk.holes
        assert np.unique(F).tolist() == list(range(len(V)))


@pytest.mark.slow
def test_crashes_and_hangs_are_attributed_to_their_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    results = run_all([("to crash", 1), ("`flatten`, random disks", 1), ("to break a promise", 3)])
    monkeypatch.setattr("fuzzing.LIMIT", 1.0)
    results |= run_all([("to hang", 2)])
    assert sum(results["`flatten`, random disks"][0].values()) == 1
    for kind, said in (
        ("to crash", "Fatal Python error"),
        ("to hang", "Timeout"),
        ("to break a promise", "BrokenError: 3"),
    ):
        assert results[kind][0].total() == 0
        assert said in results[kind][1][0]
