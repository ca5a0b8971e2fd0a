"""Notebook representations of results: a short repr, and HTML with a table and a picture of the map."""

from __future__ import annotations

import json
import warnings
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import igl
import numpy as np
import pytest
from conftest import load

from igl_linabf import MeshWarning, compare, flatten, quality, unwrap
from igl_linabf._notebook import draw_map_as_svg
from igl_linabf._notebook.pages import MAX_DRAWN_CHARTS
from igl_linabf.surface import Submesh

ROOT = Path(__file__).parents[2]
SVG = "{http://www.w3.org/2000/svg}"


def parse_html(html: str) -> ElementTree.Element:
    """Parse HTML that must also be well-formed XML."""
    return ElementTree.fromstring(f"<div>{html}</div>")


def count_loops(page: ElementTree.Element) -> list[int]:
    """Return the number of loops of each filled outline, over all pictures of a page."""
    paths = (path for path in page.iter(f"{SVG}path") if path.get("fill") != "none")
    return [path.get("d").count("M") for path in paths]


def test_a_flattening_shows_its_table_and_the_outline_of_its_map() -> None:
    V, F = load("bumps")
    result = flatten(V, F)
    assert repr(result) == f"<Flattening of {len(F):,} triangles by linabf: valid>"
    page = parse_html(result._repr_html_())
    shown = [cell.text for cell in page.iter("td")]
    for line in str(result).splitlines():
        assert line.split("  ")[0] in shown
    assert count_loops(page) == [1]


def test_the_picture_has_every_boundary_loop_and_stays_in_its_box() -> None:
    V, F = load("pial_with_holes")
    result = flatten(V, F)
    loops = Submesh.manifold_from_input(V, F).topology.loops
    page = parse_html(result._repr_html_())
    assert count_loops(page) == [len(loops)]
    (svg,) = page.iter(f"{SVG}svg")
    size = float(svg.get("width")), float(svg.get("height"))
    (path,) = (path for path in page.iter(f"{SVG}path") if path.get("fill") != "none")
    points = path.get("d").replace("Z", " ").replace("M", " ").replace("L", " ").split()
    at = np.array(points, dtype=np.float64).reshape(-1, 2)
    assert len(at) == sum(map(len, loops))
    assert at.min() >= 0
    assert (at.max(axis=0) <= size).all()


def test_the_faces_of_a_result_are_those_of_the_caller() -> None:
    V, F = load("bumps")
    V, F = np.vstack((np.full((1, 3), np.nan), V)), F + 1  # a vertex that no face uses
    for method in ("linabf", "lscm"):
        with pytest.warns(MeshWarning, match="belong to no face"):
            result = flatten(V, F, method=method)
        assert np.array_equal(result.F, F)
        assert count_loops(parse_html(result._repr_html_())) == [1]


def test_an_atlas_shows_each_chart_and_its_repairs() -> None:
    V, F = igl.icosahedron()
    V, F = np.vstack((V, V + 3)), np.vstack((F, F + len(V), F[:1]))  # two components and a repeated face
    with pytest.warns(match="repaired"):
        atlas = unwrap(V, F)
    page = parse_html(atlas._repr_html_())
    assert len(count_loops(page)) == len(atlas.charts)
    text = "".join(page.itertext())
    assert all(str(repair) in text for repair in atlas.report.repairs)
    assert repr(atlas).startswith(f"<Atlas of {len(F)} triangles: {len(atlas.charts)} charts")


def test_an_atlas_of_polygons_shows_the_outlines_of_its_charts() -> None:
    V = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    box = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    V, lone = [*V, [2, 0, 0], [3, 0, 0], [2, 1, 0], [9, 9, 9], [9, 9, 9]], [8, 9, 10]
    for F in (box, [*box[:-1], [1, 3, 7], [1, 7, 5]], [*box, lone], [*box, lone, [11, 11, 12]]):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MeshWarning)
            atlas = unwrap(V, F)
        page = parse_html(atlas._repr_html_())
        assert count_loops(page) == [1] * len(atlas.charts)


def test_a_thousand_charts_make_a_short_page() -> None:
    tetrahedron = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    n = np.arange(1_000)
    atlas = unwrap(
        (V + 2.0 * n[:, None, None]).reshape(-1, 3), (tetrahedron + 4 * n[:, None, None]).reshape(-1, 3)
    )
    page = atlas._repr_html_()
    assert len(page) < 300_000
    assert "more" in page
    parse_html(page)


def list_outlines(svg: str) -> list[np.ndarray]:
    """Return the points of each filled outline of a picture in SVG."""
    paths = [path for path in parse_html(svg).iter(f"{SVG}path") if path.get("fill") != "none"]
    words = (path.get("d").replace("Z", " ").replace("M", " ").replace("L", " ").split() for path in paths)
    return [np.array(points, dtype=np.float64).reshape(-1, 2) for points in words]


def test_a_picture_has_v_upwards() -> None:
    uv = np.array([[5, 1], [9, 1], [5, 3.0]])
    (outline,) = list_outlines(draw_map_as_svg(uv, np.array([[0, 1, 2]])))
    scale = np.ptp(outline[:, 0]) / 4
    wanted = np.column_stack((uv[:, 0] - 5, 3 - uv[:, 1])) * scale + outline.min(axis=0)
    assert {tuple(p) for p in np.round(wanted).tolist()} == {tuple(p) for p in np.round(outline).tolist()}


def test_only_the_largest_of_many_charts_are_drawn() -> None:
    n = MAX_DRAWN_CHARTS + 50
    # every eleventh chart is a square, and all other charts are smaller triangles
    size = np.where(np.arange(n) % 11 == 5, 1.0, 0.5)
    squares = [[[i, 0], [i + s, 0], [i + s, s], [i, s]] for i, s in enumerate(size.tolist())]
    F, piece = list[list[int]](), list[int]()
    for i, s in enumerate(size.tolist()):
        F += [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]][: 2 if s == 1 else 1]
        piece += [i] * (2 if s == 1 else 1)
    outlines = list_outlines(draw_map_as_svg(np.array(squares).reshape(-1, 2), np.array(F), np.array(piece)))
    assert len(outlines) == MAX_DRAWN_CHARTS
    assert sum(len(outline) == 4 for outline in outlines) == (size == 1).sum()


def test_qualities_and_comparisons_show_their_figures() -> None:
    V, F = load("bumps")
    compared = compare(V, F, ("lscm", "linabf"), repeat=1, others=False)
    page = parse_html(compared._repr_html_())
    assert count_loops(page) == [1, 1]
    measured = quality(V, F, compared.entries["linABF"].uv)
    cells = [cell.text for cell in parse_html(measured._repr_html_()).iter("td")]
    assert cells[1::2] == [line.split()[-1] for line in str(measured).splitlines()]
    assert f"{measured.angle_distortion:.4g}" in [cell.text for cell in page.iter("td")]
    assert max(map(len, (repr(compared), repr(measured)))) < 100


def run_cells(cells: list[str]) -> list[list[dict]]:
    """Run cells in a notebook kernel, and return the outputs of each cell."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    nbclient.NotebookClient(book, timeout=500, kernel_name="python3").execute()
    return [cell.outputs for cell in book.cells]


def count_pictures(outputs: list[dict]) -> int:
    """Count the outputs that show a picture or a view."""
    kinds = {"image/png", "application/vnd.jupyter.widget-view+json"}
    return sum(bool(kinds & set(output.get("data", {}))) for output in outputs)


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["static", "trame"])
def test_a_picture_that_ends_a_cell_is_shown_once(backend: str) -> None:
    pytest.importorskip("pyvista")
    pytest.importorskip("trame_pyvista" if backend == "trame" else "ipykernel")
    begin = """
import igl, pyvista, igl_linabf
from igl_linabf.plot import plot_compare, plot_uv
pyvista.set_jupyter_backend({backend!r})
V, F = igl.icosahedron()
uv = igl_linabf.linabf(V, F[1:])
"""
    compared, drawn, alone = run_cells(
        [
            begin.format(backend=backend) + "plot_compare(V, F[1:], {'linABF': uv})",
            "plot_uv(uv, F[1:])",
            "plot_uv(uv, F[1:], show=True)",
        ]
    )
    assert [count_pictures(outputs) for outputs in (compared, drawn, alone)] == [1, 0, 1]


@pytest.mark.slow
def test_the_notebook_of_the_docs_runs() -> None:
    pytest.importorskip("nilearn")
    book = json.loads((ROOT / "docs" / "notebook.ipynb").read_text(encoding="utf-8"))
    code = ["".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == "code"]
    outputs = run_cells(code)
    assert not any(
        cell["outputs"] for cell in book["cells"] if cell["cell_type"] == "code"
    )  # the notebook is stored without outputs
    tables = [o["data"]["text/html"] for out in outputs for o in out if "text/html" in o.get("data", {})]
    assert len(tables) == 4
    assert sum("<svg" in table for table in tables) == 3
    assert count_pictures(outputs[-1]) == 1
