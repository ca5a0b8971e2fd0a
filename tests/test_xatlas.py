"""`igl_linabf.xatlas` returns what xatlas-python promises, for any mesh and for its options."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable

import igl
import nasty_meshes
import numpy as np
import pytest
import trimesh

import igl_linabf.xatlas as xatlas
from igl_linabf import FallbackWarning, MeshError, Packing, overlaps, unwrap
from igl_linabf.io import read_file

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float), np.array([[0, 1, 2], [0, 2, 3]])
Mesh = tuple[np.ndarray, np.ndarray]


def areas_in_map(uv: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """Return the signed areas of the faces in the map."""
    a, b, c = uv[indices.T].astype(float)
    (x, y), (z, w) = (b - a).T, (c - a).T
    return (x * w - y * z) / 2


def check_arrays(F: np.ndarray, vmapping: np.ndarray, indices: np.ndarray, uvs: np.ndarray) -> None:
    """Assert the documented dtypes, and that the arrays describe the given faces."""
    assert [array.dtype for array in (vmapping, indices, uvs)] == [np.uint32, np.uint32, np.float32]
    assert all(array.flags.c_contiguous for array in (vmapping, indices, uvs))
    assert (vmapping[indices] == F).all()
    assert len(np.unique(indices)) == len(vmapping) == len(uvs)
    assert uvs.min() >= 0 and uvs.max() <= 1


@pytest.mark.parametrize(
    "make",
    [
        nasty_meshes.three_sheets_at_an_edge,
        nasty_meshes.faces_turned_at_random,
        nasty_meshes.every_face_twice,
        nasty_meshes.faces_with_a_vertex_twice,
        nasty_meshes.t_junctions_filled_with_caps,
        nasty_meshes.a_piece_on_a_line,
        nasty_meshes.nan_at_vertices_of_no_face,
    ],
    ids=lambda make: make.__name__,
)
def test_all_faces_keep_their_order_without_a_warning_of_repairs(make: Callable[[], Mesh]) -> None:
    """Any warning is an error in these tests."""
    V, F = make()
    vmapping, indices, uvs = xatlas.parametrize(V, F)
    check_arrays(F, vmapping, indices, uvs)
    solid = areas_in_map(uvs, indices) != 0
    assert len(overlaps(uvs.astype(float), indices[solid].astype(int))) == 0


def test_a_mesh_without_area_keeps_its_faces_and_has_no_chart() -> None:
    V, F = nasty_meshes.all_on_a_line()
    atlas = xatlas.Atlas()
    atlas.add_mesh(V, F)
    atlas.generate()
    check_arrays(F, *atlas[0])
    assert (atlas.chart_count, atlas.get_mesh_chart_count(0), atlas.texels_per_unit) == (0, 0, 0)
    assert set(np.concatenate(atlas.get_mesh_vertex_assignment(0))) == {2**32 - 1}


def test_a_soup_of_triangles_gets_the_atlas_of_the_connected_mesh() -> None:
    V, F = nasty_meshes.sphere()
    whole = unwrap(V, F, method="isometric", packing=Packing(resolution=1024))
    vmapping, indices, uvs = xatlas.parametrize(*nasty_meshes.soup(V, F))
    check_arrays(nasty_meshes.soup(V, F)[1], vmapping, indices, uvs)
    atlas = xatlas.Atlas()
    atlas.add_mesh(*nasty_meshes.soup(V, F))
    atlas.generate()
    assert atlas.chart_count == len(whole.charts) < 10


def test_charts_are_not_mirrored_and_even() -> None:
    V, F = nasty_meshes.sphere()
    _, indices, uvs = xatlas.parametrize(V, F)
    texels = areas_in_map(uvs, indices) / igl.doublearea(V, F)
    assert 0 < texels.max() / 2 < texels.min()


def test_other_warnings_than_those_of_repairs_are_issued() -> None:
    options = xatlas.PackOptions()
    options.padding = 50
    atlas = xatlas.Atlas()
    atlas.add_mesh(*nasty_meshes.a_thousand_loose_triangles())
    with pytest.warns(FallbackWarning, match="is reduced"):
        atlas.generate(pack_options=options)


def test_several_meshes_share_pages_at_one_scale() -> None:
    sphere, plate = nasty_meshes.sphere(), nasty_meshes.sheet()
    atlas = xatlas.Atlas()
    for V, F in (sphere, plate):
        atlas.add_mesh(V, F)
    assert len(atlas) == atlas.atlas_count == atlas.width == 0
    atlas.generate()
    assert (len(atlas), atlas.mesh_count, atlas.atlas_count) == (2, 2, 1)
    counts = [atlas.get_mesh_chart_count(i) for i in range(2)]
    assert sum(counts) == atlas.chart_count
    points, triangles, first, covered = [], [], 0, 0.0
    for i, (V, F) in enumerate((sphere, plate)):
        vmapping, indices, uvs = atlas[i]
        check_arrays(F, vmapping, indices, uvs)
        page, chart = atlas.get_mesh_vertex_assignment(i)
        assert page.dtype == chart.dtype == np.uint32 and not page.any()
        assert set(chart) == set(range(sum(counts[:i]), sum(counts[: i + 1])))
        charts = [atlas.get_mesh_chart(i, k) for k in range(counts[i])]
        assert sorted(np.concatenate([one.faces for one in charts]).tolist()) == list(range(len(F)))
        for k, one in enumerate(charts):
            assert (chart[indices[one.faces]] == sum(counts[:i]) + k).all()
        area = areas_in_map(uvs, indices).sum()
        density = np.sqrt(area / (igl.doublearea(V, F).sum() / 2)) * atlas.width
        assert density == pytest.approx(atlas.texels_per_unit, rel=1e-3)
        points.append(uvs)
        triangles.append(indices.astype(int) + first)
        first, covered = first + len(uvs), covered + area
    assert len(overlaps(np.concatenate(points).astype(float), np.concatenate(triangles))) == 0
    assert atlas.utilization == atlas.get_utilization(0) == pytest.approx(covered, rel=1e-5)


def test_a_resolution_and_a_density_give_as_many_pages_as_necessary() -> None:
    options = xatlas.PackOptions()
    options.resolution, options.texels_per_unit = 64, 30.0
    atlas = xatlas.Atlas()
    for _ in range(3):
        atlas.add_mesh(np.column_stack((2 * SQUARE[0], np.zeros(4))), SQUARE[1])
    atlas.generate(pack_options=options)
    assert (atlas.atlas_count, atlas.width, atlas.height) == (3, 64, 64)
    assert atlas.texels_per_unit == pytest.approx(30)
    assert sorted(int(atlas.get_mesh_vertex_assignment(i)[0][0]) for i in range(3)) == [0, 1, 2]
    for i in range(3):
        check_arrays(SQUARE[1], *atlas[i])
        assert np.ptp(atlas[i][2], axis=0) == pytest.approx(60 / 64)
        assert atlas.get_utilization(i) == pytest.approx((60 / 64) ** 2)
    with pytest.raises(IndexError, match="out of bounds"):
        atlas.get_utilization(3)


@pytest.mark.parametrize("number", [1, 2])
def test_a_density_alone_determines_the_resolution(number: int) -> None:
    options = xatlas.PackOptions()
    options.texels_per_unit = 40.0
    atlas = xatlas.Atlas()
    for _ in range(number):
        atlas.add_mesh(*nasty_meshes.sphere())
    atlas.generate(pack_options=options)
    assert atlas.atlas_count == 1
    assert atlas.texels_per_unit == pytest.approx(40, rel=0.1)
    assert atlas.width != 1024


def test_given_charts_keep_their_shapes_and_do_not_overlap() -> None:
    """This also holds if two meshes or two materials have the same texture coordinates."""
    uv, F = SQUARE
    two = np.concatenate((uv, 0.5 * uv + [3, 0])), np.concatenate((F, F + 4))
    given = [(two, None), ((uv, np.concatenate((F, F))), [0, 0, 7, 7])]
    atlas = xatlas.Atlas()
    for (points, faces), materials in given:
        atlas.add_uv_mesh(points, faces, materials)
    atlas.generate()
    assert [atlas.get_mesh_chart_count(i) for i in range(2)] == [2, 2]
    assert sorted(atlas.get_mesh_chart(1, k).material for k in range(2)) == [0, 7]
    points, triangles, first = [], [], 0
    for i, ((old, faces), _) in enumerate(given):
        vmapping, indices, uvs = atlas[i]
        check_arrays(faces, vmapping, indices, uvs)
        new = np.linalg.norm(np.diff(uvs[indices], axis=1), axis=-1)
        assert new == pytest.approx(
            np.linalg.norm(np.diff(old[faces], axis=1), axis=-1) * atlas.texels_per_unit / atlas.width,
            rel=1e-5,
        )
        points.append(uvs)
        triangles.append(indices.astype(int) + first)
        first += len(uvs)
    assert len(overlaps(np.concatenate(points).astype(float), np.concatenate(triangles))) == 0


def test_given_charts_are_not_rotated_on_request() -> None:
    turned = SQUARE[0] @ [[0.8, 0.6], [-0.6, 0.8]]
    options = xatlas.PackOptions()
    options.rotate_charts = options.rotate_charts_to_axis = False
    atlas = xatlas.Atlas()
    atlas.add_uv_mesh(turned, SQUARE[1])
    atlas.generate(pack_options=options)
    vmapping, _, uvs = atlas[0]
    side = uvs - uvs[0]
    assert side * atlas.width / atlas.texels_per_unit == pytest.approx(
        turned[vmapping] - turned[vmapping[0]], abs=1e-5
    )


def test_faces_without_area_in_the_given_texture_stay() -> None:
    uv = np.concatenate((SQUARE[0], [[7, 7], [7.1, 7.7], [7.3, 9.1]]))
    F = np.concatenate((SQUARE[1], [[1, 1, 2], [4, 5, 6]]))
    atlas = xatlas.Atlas()
    atlas.add_uv_mesh(uv, F)
    atlas.generate()
    check_arrays(F, *atlas[0])
    vmapping, _, _ = atlas[0]
    page, chart = atlas.get_mesh_vertex_assignment(0)
    assert set(chart[vmapping < 4]) == {0} and set(page[vmapping < 4]) == {0}
    assert set(chart[vmapping >= 4]) == set(page[vmapping >= 4]) == {2**32 - 1}


def test_errors_are_those_of_xatlas() -> None:
    V, F = nasty_meshes.sphere()
    atlas = xatlas.Atlas()
    for wrong, message in (
        ((V[:, :2], F), "Nx3"),
        ((V[0], F), "Nx3"),
        ((V, F[:, :2]), "Nx3"),
        ((V, F, V[:, :2]), "Nx3"),
        ((V, F, V[1:]), "first dimension"),
        ((V, F, V, V), "Nx2"),
        ((V, F, V, V[1:, :2]), "first dimension"),
    ):
        with pytest.raises(ValueError, match=message):
            atlas.add_mesh(*wrong)
    for wrong, message in (((V, F), "Nx2"), ((V[:, :2], F, [0]), "first dimension")):
        with pytest.raises(ValueError, match=message):
            atlas.add_uv_mesh(*wrong)
    for faces in (F + 1, F - 1):
        with pytest.raises(RuntimeError, match="out of range"):
            atlas.add_mesh(V, faces)
    with pytest.raises(MeshError, match="positions of vertices 0, 1"):
        atlas.add_mesh(np.where(np.arange(len(V))[:, None] < 2, np.nan, V), F)
    for call in (atlas.get_mesh, atlas.get_mesh_chart_count, atlas.get_mesh_vertex_assignment):
        with pytest.raises(IndexError, match="out of bounds"):
            call(0)
    atlas.add_mesh(V, F)
    with pytest.raises(RuntimeError, match="add_uv_mesh"):
        atlas.add_uv_mesh(V[:, :2], F)
    atlas.generate()
    with pytest.raises(IndexError, match="out of bounds"):
        atlas[1]
    with pytest.raises(IndexError, match="out of bounds"):
        atlas.get_mesh_chart(0, atlas.chart_count)
    with pytest.raises(RuntimeError, match="create_image"):
        _ = atlas.chart_image


def test_one_warning_names_the_options_without_effect() -> None:
    charts, pack = xatlas.ChartOptions(), xatlas.PackOptions()
    charts.max_cost, charts.fix_winding = 8.0, True
    pack.bruteForce, pack.padding, pack.rotate_charts = True, 4, False
    atlas = xatlas.Atlas()
    atlas.add_mesh(*nasty_meshes.sphere())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        atlas.generate(charts, pack)
    (warning,) = caught
    assert warning.category is FallbackWarning and warning.filename == __file__
    names = str(warning.message).partition(" have")[0].split(", ")
    assert names == ["ChartOptions.max_cost", "PackOptions.bruteForce", "PackOptions.rotate_charts"]
    with pytest.raises(AttributeError):
        pack.paddding = 4


def test_the_padding_separates_charts() -> None:
    gaps = []
    for padding in (0, 40):
        options = xatlas.PackOptions()
        options.padding = padding
        atlas = xatlas.Atlas()
        for _ in range(2):
            atlas.add_mesh(np.column_stack((SQUARE[0], np.zeros(4))), SQUARE[1])
        atlas.generate(pack_options=options)
        (low, high), (low2, high2) = ((uv.min(axis=0), uv.max(axis=0)) for uv in (atlas[0][2], atlas[1][2]))
        gaps.append(float(np.maximum(low2 - high, low - high2).max()) * atlas.width)
    assert 2 <= gaps[0] < 6 and 40 <= gaps[1] < 44


def test_the_image_has_the_colour_of_a_chart_at_its_faces(capsys) -> None:
    options = xatlas.PackOptions()
    options.create_image, options.resolution = True, 256
    atlas = xatlas.Atlas()
    atlas.add_mesh(*nasty_meshes.sphere())
    atlas.add_mesh(*nasty_meshes.sheet())
    atlas.generate(pack_options=options, verbose=True)
    assert f"{atlas.chart_count} charts" in capsys.readouterr().out
    image = atlas.chart_image
    assert image.shape == (256, 256, 3) and image.dtype == np.uint8
    drawn = image.any(axis=2)
    assert drawn.mean() == pytest.approx(atlas.utilization, abs=0.03)
    colours = []
    for i in range(len(atlas)):
        _, indices, uvs = atlas[i]
        for k in range(atlas.get_mesh_chart_count(i)):
            column, row = (uvs[indices[atlas.get_mesh_chart(i, k).faces]].mean(axis=1) * 256).astype(int).T
            (colour,) = np.unique(image[row, column], axis=0)
            colours.append(tuple(colour.tolist()))
    assert len(set(colours)) == atlas.chart_count == len(np.unique(image[drawn], axis=0))


def test_exported_files_have_all_tables(tmp_path) -> None:
    V, F = nasty_meshes.sphere()
    vmapping, indices, uvs = xatlas.parametrize(V, F)
    xatlas.export(tmp_path / "all.obj", V[vmapping], indices, uvs, V[vmapping])
    mesh = read_file(tmp_path / "all.obj")
    assert (V[vmapping] == mesh.V).all() and (indices == mesh.F).all() and (indices == mesh.FTC).all()
    assert (uvs == mesh.TC).all() and (mesh.extras.normals == V[vmapping]).all()
    for name, tables, corner in (
        ("bare", {}, "2"),
        ("texture", {"uvs": V[:, :2]}, "2/2"),
        ("normals", {"normals": V}, "2//2"),
    ):
        xatlas.export(tmp_path / name, V, F + 0, **tables)
        faces = [line.split() for line in (tmp_path / name).read_text().splitlines() if line.startswith("f ")]
        assert len(faces) == len(F) and corner in np.ravel(faces)
    with pytest.raises(ValueError, match="first dimension"):
        xatlas.export(tmp_path / "bad.obj", V, F, V[1:, :2])
    assert not (tmp_path / "bad.obj").exists()


def test_arrays_may_change_after_they_are_added() -> None:
    V, F = nasty_meshes.sphere()
    expected = xatlas.parametrize(V, F)
    atlas = xatlas.Atlas()
    V, F = V.copy(), F.copy()
    atlas.add_mesh(V, F)
    V[:], F[:] = 0, 0
    atlas.generate()
    assert all((a == b).all() for a, b in zip(atlas[0], expected, strict=True))


def test_trimesh_calls_it_in_place_of_xatlas(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "xatlas", xatlas)
    V, F = nasty_meshes.sphere()
    vmapping, indices, uvs = xatlas.parametrize(V, F)
    mesh = trimesh.Trimesh(V, F, process=False).unwrap()
    assert (mesh.vertices == V[vmapping]).all() and (mesh.faces == indices).all()
    assert (mesh.visual.uv == uvs).all()


def test_types_of_charts_have_the_numbers_of_xatlas() -> None:
    names = ("Planar", "Ortho", "LSCM", "Piecewise", "Invalid")
    assert [int(getattr(xatlas.ChartType, name)) for name in names] == [0, 1, 2, 3, 4]
