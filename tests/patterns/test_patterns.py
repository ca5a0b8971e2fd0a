"""Patterns have true lengths, the same marks on both sides of a seam, and readable files."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import igl
import numpy as np
import pytest
import shapely
from carried import quads
from nasty_meshes import NASTY

from igl_linabf import MeshError, MeshWarning, Packing, linabf, unwrap
from igl_linabf.cli import main
from igl_linabf.patterns import Pattern, PatternOptions, build_pattern, write_pattern
from igl_linabf.patterns.pieces import lay_out

pytest.importorskip("svgwrite")
ezdxf = pytest.importorskip("ezdxf")
pytest.importorskip("matplotlib")
# most surfaces and maps of these tests are not made to be sewn; test_changes.py tests the warning
pytestmark = pytest.mark.filterwarnings("ignore:the pattern changes the lengths:igl_linabf.OutcomeWarning")


def sheet(
    n: int, m: int, radius: object, turn: float = 5.0, height: float = 200.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return quadrangles around an axis, open along one line, with a radius that depends on the height."""
    a, z = np.meshgrid(np.linspace(0, 5, n), np.linspace(0, 200, m), indexing="ij")
    r = radius(z)
    V = np.stack((r * np.cos(a), r * np.sin(a), z), axis=-1).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n - 1), np.arange(m - 1), indexing="ij"))
    return V, np.column_stack((i * m + j, (i + 1) * m + j, (i + 1) * m + j + 1, i * m + j + 1))


def box(x: float = 40, y: float = 60, z: float = 80) -> tuple[np.ndarray, list[list[int]]]:
    V = np.array([[a, b, c] for c in (0, z) for b in (0, y) for a in (0, x)], dtype=float)
    return V, [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


DEVELOPABLE = {
    "cylinder": sheet(60, 20, lambda z: 80 + 0 * z),
    "cone": sheet(50, 12, lambda z: 30 + 0.4 * z),
    "box": box(),
}


@pytest.mark.parametrize("name", DEVELOPABLE)
@pytest.mark.parametrize("method", ["linabf", "isometric"])
def test_lengths_of_developable_surfaces_are_true(tmp_path: Path, name: str, method: str) -> None:
    V, F = DEVELOPABLE[name]
    pattern = write_pattern(tmp_path / "p.svg", V, F, unwrap(V, F, method=method, progress=False))
    assert pattern.error < 1e-6
    assert all(abs(seam.difference) < 1e-6 for seam in pattern.seams)
    # the length of the outline equals the surface's boundary length plus twice the seam length
    split = unwrap(V, F, method=method, progress=False).report.split
    edges = igl.boundary_facets(split.F)[0]
    rim = np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1).sum()
    outline = sum(np.linalg.norm(line - np.roll(line, -1, axis=0), axis=1).sum() for line in pattern.outlines)
    assert outline == pytest.approx(rim + 2 * sum(seam.length for seam in pattern.seams), rel=1e-6)


def test_patterns_of_plain_maps_have_the_given_unit(tmp_path: Path) -> None:
    V, F = DEVELOPABLE["cylinder"]
    T = np.concatenate((F[:, :3], F[:, [0, 2, 3]]))
    one = write_pattern(tmp_path / "p.svg", V, T, linabf(V, T))
    other = write_pattern(tmp_path / "p.svg", V / 25.4, T, linabf(V, T), "in")
    assert np.allclose(one.size, other.size)
    assert sorted(one.size) == pytest.approx([200, 400], rel=1e-3)


def read_svg(path: Path) -> tuple[ElementTree.Element, dict[str, list[np.ndarray]]]:
    root = ElementTree.parse(path).getroot()
    space = "{http://www.w3.org/2000/svg}"
    lines = {
        group.get("id", ""): [
            np.array([list(map(float, pair.split(","))) for pair in shape.get("points", "").split()])
            for shape in group
        ]
        for group in root.iter(f"{space}g")
        if group.get("id")
    }
    return root, lines


def write_box_pattern(path: Path) -> Pattern:
    """Write the net of a box: a row of four sides, 200 mm long, with lid and bottom."""
    V, F = box()
    seams = [[0, 4], [0, 1], [0, 2], [2, 3], [4, 5], [4, 6], [6, 7]]
    return write_pattern(path, V, F, unwrap(V, F, seams, progress=False))


def test_svg_has_the_outline_in_millimetres(tmp_path: Path) -> None:
    pattern = write_box_pattern(tmp_path / "box.svg")
    root, lines = read_svg(tmp_path / "box.svg")
    assert root.get("width", "").endswith("mm")
    assert root.get("viewBox") == f"0 0 {root.get('width', '')[:-2]} {root.get('height', '')[:-2]}"
    (outline,) = lines["outline"]
    step = np.linalg.norm(outline - np.roll(outline, -1, axis=0), axis=1)
    assert set(np.round(step, 6).tolist()) <= {40.0, 60.0, 80.0}
    upright = outline * [1, -1]  # y points down in SVG
    np.testing.assert_allclose(upright - upright[0], pattern.outlines[0] - pattern.outlines[0][0], atol=1e-6)
    ends = shapely.points([notch[1] for notch in lines["seam"]])
    assert len(ends) == 2 * len(pattern.seams)
    # notches start at the outline and end inside the piece
    assert shapely.contains(shapely.Polygon(outline), ends).all()
    assert len(lines["mountain"]) == len(pattern.folds) == 5
    texts = [text.text for text in root.iter("{http://www.w3.org/2000/svg}text")]
    for seam in pattern.seams:
        assert texts.count(str(seam.number)) == 2  # once on each side of the seam
    assert "100 mm" in texts
    bar = next(line for line in lines["text"] if np.ptp(line[:, 0]) > 1)
    assert np.ptp(bar[:, 0]) == 100


def test_both_sides_of_a_seam_run_the_same_way_on_the_surface(tmp_path: Path) -> None:
    V, F = quads()
    atlas = unwrap(V, F, method="isometric", progress=False)
    pattern = write_pattern(tmp_path / "p.svg", V, F, atlas)
    cut = lay_out(V, F, atlas, PatternOptions.from_arguments("mm", 30.0, (0, 0, 1))).cut
    place = {tuple(np.round(p, 9)): v for p, v in zip(cut.flat, cut.origin.tolist(), strict=True)}
    covered = 0
    for seam in pattern.seams:
        one, other = ([place[tuple(np.round(p, 9))] for p in side.tolist()] for side in seam.sides)
        assert one == other
        assert seam.length == pytest.approx(np.linalg.norm(np.diff(V[one], axis=0), axis=1).sum())
        assert seam.lengths[0] == pytest.approx(np.linalg.norm(np.diff(seam.sides[0], axis=0), axis=1).sum())
        covered += len(one) - 1
    assert covered == len(atlas.seams)


def test_diagonals_of_bent_polygons_are_not_folds(tmp_path: Path) -> None:
    V = np.array([[0, 0, 0], [10, 0, 0], [10, 10, 20], [0, 10, 0.0]])
    for F, folds in (([[0, 1, 3], [1, 2, 3]], 1), ([[0, 1, 2, 3]], 0)):
        assert len(write_pattern(tmp_path / "p.svg", V, F, unwrap(V, F, progress=False)).folds) == folds


def test_both_sides_of_a_seam_are_measured_separately() -> None:
    square = np.array([[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 0.0]])
    F = np.array([[0, 1, 2], [0, 2, 3]])
    beside = square + np.array([100, 0, 0])
    flat = np.vstack((square[:, :2], beside[:, :2] * [1, 1.25] + [50, 0]))
    V, faces = np.vstack((square, beside)), np.vstack((F, F + 4))
    (seam,) = build_pattern(V, faces, flat, PatternOptions.from_arguments("mm", 30.0, (0, 0, 1))).seams
    scale = np.sqrt(1 + 1.25) / np.sqrt(2)  # the scale of the map relative to the pattern
    assert seam.length == 100
    assert [length * scale for length in seam.lengths] == pytest.approx([100, 125])
    assert seam.difference == pytest.approx(-0.25 / scale)


def test_dxf_is_read_by_ezdxf(tmp_path: Path) -> None:
    pattern = write_box_pattern(tmp_path / "box.dxf")
    document = ezdxf.readfile(tmp_path / "box.dxf")
    assert document.units == ezdxf.units.MM
    assert not document.audit().errors
    (outline,) = document.modelspace().query('LWPOLYLINE[layer=="outline"]')
    points = np.array([point[:2] for point in outline])
    assert outline.closed
    assert np.allclose(points - points[0], pattern.outlines[0] - pattern.outlines[0][0], atol=1e-9)
    texts = [text.dxf.text for text in document.modelspace().query("TEXT")]
    assert all(texts.count(str(seam.number)) == 2 for seam in pattern.seams)


def test_pdf_is_tiled_at_true_scale(tmp_path: Path) -> None:
    V, F = box(100, 150, 200)
    pattern = write_pattern(tmp_path / "box.pdf", V, F, unwrap(V, F, progress=False))
    data = (tmp_path / "box.pdf").read_bytes()
    boxes = re.findall(rb"/MediaBox \[ ?([\d. ]+)\]", data)
    sizes = {tuple(float(x) * 25.4 / 72 for x in found.split()[2:]) for found in boxes}
    assert len(sizes) == 1
    assert sorted(sizes.pop()) == pytest.approx([210, 297], abs=0.01)
    assert len(boxes) > 1
    free = (210 - 20 - 10) * (297 - 20 - 10)  # printed area of a page without its overlap
    assert len(boxes) >= pattern.size[0] * pattern.size[1] / free
    # the pattern of a small box takes one page, and its scale bar has the stated length
    write_box_pattern(tmp_path / "small.pdf")
    pdfium = pytest.importorskip("pypdfium2")
    page = pdfium.PdfDocument(tmp_path / "small.pdf")[0]
    scale = 4.0
    image = np.asarray(page.render(scale=scale).to_pil().convert("L"))
    dark = image < 128
    rows = np.flatnonzero(dark.sum(axis=1) > 0.3 * dark.shape[1])
    bar = np.ptp(np.flatnonzero(dark[rows[-1]]))  # the scale bar is below all pieces
    assert bar * 25.4 / 72 / scale == pytest.approx(100, abs=0.5)


def test_the_command_draws_and_lists_the_seams(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    V, F = igl.icosahedron()
    igl.write_triangle_mesh(str(tmp_path / "ball.obj"), V, F)
    out = tmp_path / "ball.dxf"
    assert (
        main(["pattern", str(tmp_path / "ball.obj"), "-o", str(out), "--units", "cm", "--paper", "A3"]) == 0
    )
    output = capsys.readouterr().out
    assert re.search(r"seam +pieces +side 1 +side 2 +surface +sides differ", output)
    lines = ezdxf.readfile(out).modelspace().query('LWPOLYLINE[layer=="outline"]')
    step = [np.linalg.norm(np.diff(np.array([p[:2] for p in line]), axis=0), axis=1) for line in lines]
    edge = 10 * np.linalg.norm(V[F[0, 0]] - V[F[0, 1]])
    assert np.allclose(np.concatenate(step), edge)  # no edge of an icosahedron changes its length
    assert main(["pattern", str(tmp_path / "ball.obj"), "-o", str(tmp_path / "ball.jpg")]) == 2


def test_invalid_arguments_of_patterns_are_refused(tmp_path: Path) -> None:
    V, F = box()
    atlas = unwrap(V, F, progress=False)
    with pytest.raises(ValueError, match=r"use one that ends in \.svg, \.dxf, \.pdf"):
        write_pattern(tmp_path / "p.ai", V, F, atlas)
    with pytest.raises(ValueError, match="units is 'ell'"):
        write_pattern(tmp_path / "p.svg", V, F, atlas, "ell")
    with pytest.raises(ValueError, match="paper is 'B5'"):
        write_pattern(tmp_path / "p.pdf", V, F, atlas, paper="B5")
    with pytest.raises(MeshError, match="uv has 3 rows for 8 vertices"):
        write_pattern(tmp_path / "p.svg", V, F, np.zeros((3, 2)))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a one sided band", "a bottle without an inside", "a projective plane"])
def test_one_sided_surfaces_are_drawn_and_both_sides_of_their_cuts_are_numbered(
    tmp_path: Path, name: str
) -> None:
    V, F = NASTY[name]()
    with pytest.warns(MeshWarning):
        # prevent cuts that fill the page, because the pattern would join the parts again
        atlas = unwrap(V, F, packing=Packing(resolution=2048, texel_density=1), progress=False)
    pattern = write_pattern(tmp_path / "p.svg", V, F, atlas)
    assert any(seam.twisted for seam in pattern.seams)
    edges = igl.boundary_facets(F)[0]
    rim = np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1).sum()
    # the outline is the boundary of the surface and both sides of the seams
    flat = igl.boundary_facets(atlas.FTC)[0]
    around = V[atlas.origin[flat]]
    outline = np.linalg.norm(around[:, 0] - around[:, 1], axis=1).sum()
    assert outline == pytest.approx(rim + 2 * sum(seam.length for seam in pattern.seams))


@pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning")
@pytest.mark.parametrize("name", sorted(NASTY.keys() - {"all on a line", "coordinates of 1e200"}))
def test_repaired_surfaces_can_be_drawn(tmp_path: Path, name: str) -> None:
    V, F = NASTY[name]()
    atlas = unwrap(V, F, progress=False)
    pattern = write_pattern(tmp_path / "p.svg", V, F, atlas)
    assert 0 < pattern.pieces <= len(atlas.charts)
    assert all(len(line) >= 3 for line in pattern.outlines)


def test_the_error_of_a_pattern_counts_edges_that_shrink() -> None:
    square = np.array([[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 0.0]])
    strip = square * [4, 1, 1] + [200, 0, 0]
    F = np.array([[0, 1, 2], [0, 2, 3]])
    # the square shrinks by half in x and grows by a tenth in y; the strip makes up for the change of area
    flat = np.vstack((square[:, :2] * [0.5, 1.1], strip[:, :2] * np.sqrt(1 + 0.45 / 4)))
    made = build_pattern(
        np.vstack((square, strip)),
        np.vstack((F, F + 4)),
        flat,
        PatternOptions.from_arguments("mm", 30.0, (0, 0, 1)),
    )
    assert made.error == pytest.approx(0.5)
