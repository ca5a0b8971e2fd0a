"""Fold directions, glue tabs, seam allowances and compensation are right in the pattern and in its files."""

from __future__ import annotations

import json
from pathlib import Path

import igl
import numpy as np
import pytest
import shapely
from hard_surfaces import pipe
from test_layout import TURNED, band, box, plate
from test_patterns import read_svg

from igl_linabf import MeshWarning, Packing, unwrap
from igl_linabf.cli import main
from igl_linabf.patterns import Pattern, PatternOptions, build_pattern, write_pattern
from igl_linabf.patterns.folds import join_segments

pytest.importorskip("svgwrite")
ezdxf = pytest.importorskip("ezdxf")
pytest.importorskip("matplotlib")

Mesh = tuple[np.ndarray, object]


def star(tips: int = 5, height: float = 40.0) -> Mesh:
    """Return a prism over a star, with radii of 60 and 30 mm."""
    m = 2 * tips
    angle = np.arange(m) * 2 * np.pi / m
    radius = np.where(np.arange(m) % 2 == 0, 60.0, 30.0)
    ring = np.column_stack((radius * np.cos(angle), radius * np.sin(angle), 0 * angle))
    walls = [[i, (i + 1) % m, m + (i + 1) % m, m + i] for i in range(m)]
    caps = [list(range(m))[::-1], list(range(m, 2 * m))]
    return np.vstack((ring, ring + np.array([0, 0, height]))), caps + walls


def draw(path: Path, mesh: Mesh, seams: object = None, **options: object) -> Pattern:
    """Unwrap a mesh without cuts that fill the page, and write its pattern."""
    V, F = mesh
    roomy = Packing(resolution=4096, texel_density=1)
    return write_pattern(path, V, F, unwrap(V, F, seams, packing=roomy, progress=False), **options)


def build_regions(lines: tuple[np.ndarray, ...]) -> list[shapely.Polygon]:
    """Return the regions within closed lines, whose holes are traced clockwise."""
    rings = [shapely.LinearRing(line) for line in lines]
    holes = [ring for ring in rings if not ring.is_ccw]
    return [
        shapely.Polygon(ring, [h for h in holes if shapely.Polygon(ring).contains(h)])
        for ring in rings
        if ring.is_ccw
    ]


def assert_apart(pattern: Pattern) -> None:
    """Assert that the cut pieces are simple, and do not overlap on the sheet."""
    cut = build_regions(pattern.cut_lines)
    assert shapely.is_valid(cut).all()
    one, other = shapely.STRtree(cut).query(cut, predicate="intersects")
    assert (one == other).all()
    corner = np.concatenate(pattern.cut_lines)
    assert corner.min(axis=0) == pytest.approx([0, 0])
    assert corner.max(axis=0) == pytest.approx(pattern.size)


@pytest.mark.parametrize("turned", [False, True])
def test_folds_are_mountain_folds_seen_from_outside(tmp_path: Path, turned: bool) -> None:
    V, F = box(60, 40, 80)
    V = V @ TURNED.T if turned else V
    mirrored = V * [-1, 1, 1]
    for points, faces, expected in ((V, F, 90), (V, F[:, ::-1], -90), (mirrored, F, -90)):
        assert draw(tmp_path / "p.svg", (points, faces)).fold_angles == pytest.approx(np.full(5, expected))


def test_a_star_has_mountain_folds_at_its_tips_and_valley_folds_between(tmp_path: Path) -> None:
    pattern = draw(tmp_path / "p.svg", star())
    tip = 2 * np.degrees(np.arctan2(30 * np.sin(np.pi / 5), 60 - 30 * np.cos(np.pi / 5)))
    mountain = pattern.fold_angles > 0
    assert pattern.fold_angles[mountain] == pytest.approx(180 - tip)
    assert pattern.fold_angles[~mountain] == pytest.approx(tip + 360 / 5 - 180)
    assert mountain.sum() >= 4
    assert (~mountain).sum() >= 4


def test_mountain_and_valley_folds_differ_in_every_format(tmp_path: Path) -> None:
    pattern = draw(tmp_path / "p.svg", star())
    counts = {
        "mountain": int((pattern.fold_angles > 0).sum()),
        "valley": int((pattern.fold_angles < 0).sum()),
    }
    root, lines = read_svg(tmp_path / "p.svg")
    assert {name: len(lines[name]) for name in counts} == counts
    dashes = {
        group.get("id"): {shape.get("stroke-dasharray") for shape in group}
        for group in root.iter()
        if group.get("id")
    }
    assert len(dashes["mountain"]) == len(dashes["valley"]) == 1
    assert None not in dashes["mountain"] | dashes["valley"]
    assert dashes["mountain"] != dashes["valley"]
    assert dashes["legend"] == dashes["mountain"] | dashes["valley"]
    texts = [text.text for text in root.iter("{http://www.w3.org/2000/svg}text")]
    assert {"mountain fold: away from you", "valley fold: towards you"} <= set(texts)

    draw(tmp_path / "p.dxf", star())
    document = ezdxf.readfile(tmp_path / "p.dxf")
    assert not document.audit().errors
    for name, count in counts.items():
        assert len(document.modelspace().query(f'LWPOLYLINE[layer=="{name}"]')) == count
    kinds = [document.layers.get(name).dxf.linetype for name in counts]
    assert len({*kinds, "CONTINUOUS"}) == 3
    assert all(kind in document.linetypes for kind in kinds)

    draw(tmp_path / "p.pdf", star(), paper="A0")
    page = pytest.importorskip("pypdfium2").PdfDocument(tmp_path / "p.pdf")[0]
    text = page.get_textpage().get_text_range()
    assert "mountain fold" in text
    assert "valley fold" in text
    image = np.asarray(page.render(scale=1.0).to_pil().convert("RGB")).astype(int)
    assert (image[..., 0] - image[..., 2] > 100).any()  # orange mountain folds
    assert (image[..., 2] - image[..., 0] > 100).any()  # blue valley folds


def test_short_segments_are_drawn_as_one_line() -> None:
    angle = np.linspace(0, 2 * np.pi, 61)
    ring = np.column_stack((np.cos(angle), np.sin(angle)))
    ring[-1] = ring[0]
    segments = np.stack((ring[:-1], ring[1:]), axis=1)
    segments[::2] = segments[::2, ::-1]
    (line,) = join_segments(np.random.default_rng(1).permutation(segments))
    assert len(line) == 61
    (arc,) = join_segments(segments[:20])
    assert len(arc) == 21
    corner = np.array([[[0, 0], [1, 0]], [[1, 0], [1, 1]]], dtype=float)
    junction = np.array([[[0, 0], [1, 0]], [[1, 0], [2, 0]], [[1, 0], [1, 1]]], dtype=float)
    assert (len(join_segments(corner)), len(join_segments(junction)), len(join_segments(corner[:0]))) == (
        2,
        3,
        0,
    )


def reflect_tab(tab: object, pattern: Pattern) -> shapely.Polygon:
    """Return where a tab is glued: beside the other side of its seam."""
    seam = pattern.seams[tab.seam - 1]
    for own, other in (seam.sides, seam.sides[::-1]):
        rows = [np.flatnonzero((own == tab.base[k]).all(axis=1)) for k in (0, -1)]
        if all(len(found) for found in rows):
            a, b = (own[found[0]] @ [1, 1j] for found in rows)
            c, d = (other[found[0]] @ [1, 1j] for found in rows)
            z = c + (d - c) / (b - a) * (tab.outline @ [1, 1j] - a)
            return shapely.Polygon(np.column_stack((z.real, z.imag)))
    raise AssertionError("the tab is on neither side of its seam")


TABBED = {
    "box": box(60, 40, 80),
    "star": star(),
    "thin plate": box(80, 60, 5),
    "cone": (band(24, 60, 0.4)[0] * [50, 50, 1], band(24, 60, 0.4)[1]),
    "shallow cone": (band(24, 6, 0.4)[0] * [50, 50, 1], band(24, 6, 0.4)[1]),  # seam sides face each other
    "icosahedron": (40 * igl.icosahedron()[0], igl.icosahedron()[1]),
}


@pytest.mark.parametrize("name", TABBED)
def test_each_seam_has_tabs_on_one_side_that_overlap_nothing(tmp_path: Path, name: str) -> None:
    V, F = TABBED[name]
    pattern = draw(tmp_path / "p.svg", (V, F), tabs=8)
    plain = draw(tmp_path / "q.svg", (V, F))
    assert pattern.report.seams_without_room == ()
    area = sum(shapely.Polygon(tab.outline).area for tab in pattern.tabs)
    inside = sum(part.area for part in build_regions(plain.cut_lines))
    assert sum(part.area for part in build_regions(pattern.cut_lines)) == pytest.approx(inside + area)
    assert_apart(pattern)
    edges = [[*line, line[0]] for line in pattern.outlines]
    drawn = [shapely.LineString(line) for line in (*edges, *pattern.folds)]
    faces = shapely.get_parts(shapely.polygonize([shapely.unary_union(drawn)])).tolist()
    for seam in pattern.seams:
        own = [tab for tab in pattern.tabs if tab.seam == seam.number]
        base = sum(float(np.linalg.norm(np.diff(tab.base, axis=0), axis=1).sum()) for tab in own)
        assert base == pytest.approx(seam.lengths[0])
        assert len({tab.piece for tab in own}) == 1
    for tab in pattern.tabs:
        along = (tab.base[-1] - tab.base[0]) / np.linalg.norm(tab.base[-1] - tab.base[0])
        depth = (tab.top - tab.base[0]) @ [along[1], -along[0]]
        assert depth[0] == pytest.approx(depth[1])
        assert 2 <= depth[0] <= 8 + 1e-9
        inset = (tab.top[0] - tab.base[0]) @ along, (tab.base[-1] - tab.top[1]) @ along
        assert min(inset) > 0.3 * depth[0]
        glued = reflect_tab(tab, pattern).buffer(-0.02)
        assert any(face.covers(glued) for face in faces)
    if name == "box":
        assert all(np.ptp((tab.outline - tab.base[0]) @ [1, 0]) >= 8 - 1e-9 for tab in pattern.tabs)


def test_the_base_of_a_tab_is_a_fold_where_the_surface_has_a_crease(tmp_path: Path) -> None:
    pattern = draw(tmp_path / "p.svg", box(60, 40, 80), tabs=8)
    _, lines = read_svg(tmp_path / "p.svg")
    assert [tab.angle for tab in pattern.tabs] == pytest.approx([90] * 7)
    assert len(lines["mountain"]) == 12  # each edge of the box is folded once
    V, F = band(48, 60, 0.4)
    pattern = draw(tmp_path / "p.svg", (V * [50, 50, 1], F), tabs=8)
    _, lines = read_svg(tmp_path / "p.svg")
    assert len(lines["tab"]) == len(pattern.tabs) == 1
    assert not lines["mountain"]


def test_lengths_have_the_unit_of_the_surface(tmp_path: Path) -> None:
    V, F = box(6, 4, 8)
    inches = draw(tmp_path / "p.svg", (V, F), units="in", tabs=0.5)
    assert inches.report.tab_width == pytest.approx(12.7)
    assert shapely.Polygon(inches.tabs[0].outline).area > 0
    millimetres = draw(tmp_path / "p.svg", (V * 25.4, F), allowance=12.7)
    inches = draw(tmp_path / "p.svg", (V, F), units="in", allowance=0.5)
    assert inches.size == pytest.approx(millimetres.size)


def test_an_allowance_has_a_constant_width_also_in_holes(tmp_path: Path) -> None:
    pattern = draw(tmp_path / "p.svg", plate({(i, j) for i in (5, 6, 7) for j in (3, 4)}), allowance=7)
    assert pattern.size == pytest.approx((130 + 14, 90 + 14))
    sizes = sorted(np.ptp(line, axis=0).tolist() for line in pattern.cut_lines)
    assert sizes == [pytest.approx([30 - 14, 20 - 14]), pytest.approx([130 + 14, 90 + 14])]
    pattern = draw(tmp_path / "p.svg", star(), allowance=6)
    sewing = shapely.MultiLineString([[*line, line[0]] for line in pattern.outlines])
    corners = np.concatenate(pattern.cut_lines)
    distance = shapely.distance(sewing, shapely.points(corners))
    assert distance.min() == pytest.approx(6, rel=1e-6)
    assert distance.max() <= 4 * 6
    for line in pattern.cut_lines:
        middle = (line + np.roll(line, -1, axis=0)) / 2
        assert shapely.distance(sewing, shapely.points(middle)).min() >= 6 - 1e-6
    assert_apart(pattern)


def test_notches_reach_from_the_cutting_line_across_the_sewing_line(tmp_path: Path) -> None:
    pattern = draw(tmp_path / "p.svg", box(60, 40, 80), allowance=10)
    _, lines = read_svg(tmp_path / "p.svg")
    assert len(lines["outline"]) == len(pattern.cut_lines)
    assert len(lines["sewing"]) == len(pattern.outlines)
    cutting, sewing = (
        shapely.MultiLineString([[*line, line[0]] for line in lines[name]]) for name in ("outline", "sewing")
    )
    assert len(lines["seam"]) == 2 * len(pattern.seams)
    for notch in lines["seam"]:
        assert shapely.distance(cutting, shapely.Point(notch[0])) == pytest.approx(0, abs=1e-6)
        assert shapely.intersects(sewing, shapely.LineString(notch))
        assert shapely.contains(shapely.Polygon(lines["sewing"][0]), shapely.Point(notch[1]))


@pytest.mark.parametrize("finish", [{"tabs": 2.0}, {"allowance": 2.0}])
def test_many_finished_pieces_do_not_overlap(tmp_path: Path, finish: dict[str, float]) -> None:
    V, F = star(4, 20)
    V = V / 3
    grid = np.concatenate([V + np.array([60.0 * i, 60.0 * j, 0]) for i in range(3) for j in range(3)])
    faces = [[v + len(V) * k for v in face] for k in range(9) for face in F]
    pattern = draw(tmp_path / "p.svg", (grid, faces), **finish)
    assert pattern.pieces >= 9
    assert_apart(pattern)


@pytest.mark.parametrize("grain", [(0, 1, 0), (1, 0, 0)])
def test_compensation_enlarges_across_and_along_the_grain(
    tmp_path: Path, grain: tuple[int, int, int]
) -> None:
    V, F = plate(set())
    plain = draw(tmp_path / "p.svg", (V, F), grain=grain)
    pattern = draw(tmp_path / "p.svg", (V, F), grain=grain, compensation=(1.02, 1.1))
    along = plain.grain[0, 1] - plain.grain[0, 0]
    factors = (1.02, 1.1) if abs(along[1]) > abs(along[0]) else (1.1, 1.02)
    assert pattern.size == pytest.approx(np.multiply(plain.size, factors))
    assert pattern.report.compensation == (1.02, 1.1)
    assert pattern.error == pytest.approx(0, abs=1e-6)
    assert "1.02 across and 1.1 along" in str(pattern)
    # the width of the allowance is not enlarged
    wide = draw(tmp_path / "p.svg", (V, F), grain=grain, compensation=(1.02, 1.1), allowance=5)
    assert wide.size == pytest.approx(np.add(pattern.size, 10))


def test_each_piece_is_enlarged_along_its_own_grain(tmp_path: Path) -> None:
    V, F = band(5, 40.0)
    V = V * [30, 30, 1]
    every = np.column_stack((np.arange(5), np.arange(5, 10)))
    pattern = draw(tmp_path / "p.svg", (V, F), every, compensation=(1.0, 1.2))
    assert pattern.pieces == 5
    for line in pattern.outlines:
        assert np.ptp(line[:, 1]) == pytest.approx(48)
    assert [seam.lengths for seam in pattern.seams] == [pytest.approx((48, 48))] * 5
    assert [seam.length for seam in pattern.seams] == pytest.approx([40] * 5)


def test_mirrored_pieces_of_a_map_are_drawn_from_the_other_side() -> None:
    V = np.array([[0, 0, 0], [60, 0, 0], [60, 40, 0], [0, 40, 0], [60, 0, -30], [60, 40, -30.0]])
    F = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
    flat = np.array([[0, 0], [60, 0], [60, 40], [0, 40], [90, 0], [90, 40.0]])
    for sign in (1, -1):
        options = PatternOptions.from_arguments("mm", 30.0, (0, 0, 1))
        pattern = build_pattern(V, F, flat * [sign, 1], options)
        assert pattern.fold_angles == pytest.approx([sign * 90])
        assert all(shapely.LinearRing(line).is_ccw for line in pattern.outlines)


def test_seams_and_holes_without_room_are_reported(tmp_path: Path) -> None:
    V, F = plate({(6, 4)})
    across = np.flatnonzero(np.isclose(V[:, 0], 60))
    across = across[np.argsort(V[across, 1])][:5]
    slit = np.column_stack((across[:-1], across[1:]))
    with pytest.warns(MeshWarning, match=r"no tab fits beside 1 of 1 seams \(1\)"):
        pattern = draw(tmp_path / "p.svg", (V, F), slit, tabs=5)
    assert pattern.report.seams_without_room == (1,)
    with pytest.warns(MeshWarning, match=r"closer than twice the allowance at 1 of 1 seams \(1\)"):
        pattern = draw(tmp_path / "p.svg", (V, F), slit, allowance=2)
    assert pattern.report.seams_without_room == (1,)
    with pytest.warns(MeshWarning, match=r"covers holes \(1\)"):
        assert len(draw(tmp_path / "p.svg", (V, F), allowance=6).cut_lines) == 1
    assert len(draw(tmp_path / "p.svg", (V, F), allowance=4).cut_lines) == 2


WRONG = {
    "no width": ({"tabs": 0}, "tabs is 0: use a positive width in mm, or leave it out"),
    "negative": ({"allowance": -3}, "allowance is -3: use a positive width"),
    "infinite": ({"allowance": np.inf}, "allowance is inf: use a positive width"),
    "not a number": ({"tabs": "8 mm"}, "tabs is '8 mm': use a positive width"),
    "too wide": ({"tabs": 500}, "the largest piece measures only 200 mm: use a smaller width"),
    "both": ({"tabs": 8, "allowance": 8}, "cannot be combined, because both fill the space beside a seam"),
    "one factor": ({"compensation": 1.05}, "compensation is 1.05: use two factors"),
    "percentages": ({"compensation": (3, 5)}, r"compensation is \(3, 5\): use two factors, .* from 0.5 to 2"),
    "three factors": ({"compensation": (1, 1, 1)}, "use two factors"),
    "angle": ({"crease": 200}, "crease is 200: use an angle from 0 to 180 degrees"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_options_are_refused_with_a_remedy(tmp_path: Path, name: str) -> None:
    options, message = WRONG[name]
    with pytest.raises(ValueError, match=message):
        draw(tmp_path / "p.svg", box(60, 40, 80), **options)
    assert not list(tmp_path.iterdir())


def test_the_command_cuts_along_given_seams_and_for_no_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    V, F = pipe([(0, 2, 0.6), (2, 1, 0.3)], 32, 21)
    igl.write_triangle_mesh(str(tmp_path / "pipe.obj"), V, F)
    drawing = ["pattern", str(tmp_path / "pipe.obj"), "-o", str(tmp_path / "pipe.svg"), "--json", "--force"]

    def draw_pipe(*options: str) -> list[tuple[list[int], float]]:
        assert main([*drawing, *options]) == 0
        seams = json.loads(capsys.readouterr().out)["pattern"]["seams"]
        return [(seam["pieces"], round(seam["length"], 6)) for seam in seams]

    assert draw_pipe() == [([0, 0], 4)]
    ring = np.flatnonzero(np.isclose(V[:, 2], 3.2))
    beside = [pair for pair in igl.edges(F).tolist() if set(pair) <= set(ring.tolist())]
    (tmp_path / "pairs.txt").write_text("\n".join(f"{a} {b}" for a, b in beside))
    parts = draw_pipe("--seams", str(tmp_path / "pairs.txt"), "--extend-seams")
    assert sorted(length for pieces, length in parts if pieces in ([0, 0], [1, 1])) == [0.8, 3.2]
    assert [0, 1] in [pieces for pieces, _ in parts]


def test_the_command_has_the_options(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    V, F = box(6, 4, 8)
    igl.write_triangle_mesh(str(tmp_path / "box.obj"), V, F)
    drawing = ["pattern", str(tmp_path / "box.obj"), "-o", str(tmp_path / "box.svg"), "--units", "cm"]
    assert main([*drawing, "--tabs", "0.8", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["pattern"]
    assert found["tab_width"] == 8
    assert [sorted(tab) for tab in found["tabs"]] == [["angle", "piece", "seam"]] * 7
    assert "cut_lines" not in found
    assert main([*drawing, "--allowance", "1", "--compensation", "1.03,1.05"]) == 0
    printed = capsys.readouterr().out
    assert "a seam allowance of 10 mm; enlarged by 1.03 across and 1.05 along the grain" in printed
    assert main([*drawing, "--tabs", "1", "--allowance", "1"]) == 2
    assert "cannot be combined" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main([*drawing, "--compensation", "1.03"])
    assert "give two numbers, such as 1.03,1.05" in capsys.readouterr().err
