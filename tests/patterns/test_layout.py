"""Pieces of a pattern are joined if possible, keep their holes, stand upright, and use few pages."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import igl
import numpy as np
import pytest

from igl_linabf import overlaps, unwrap
from igl_linabf.cli import main
from igl_linabf.patterns import Pattern, write_pattern

pytest.importorskip("svgwrite")
pytest.importorskip("matplotlib")

Surface = tuple[np.ndarray, np.ndarray]
TURNED = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
TURNED *= np.linalg.det(TURNED)


def band(sides: int, height: float, top: float = 1.0, whole: bool = True) -> Surface:
    """Return an open prism or frustum of radius 1; without `whole`, one of its sides is missing."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.column_stack((np.cos(angle), np.sin(angle), 0 * angle))
    V = np.concatenate((ring, ring * [top, top, 1] + [0, 0, height]))
    j = np.arange(sides if whole else sides - 1)
    k = (j + 1) % sides
    return V, np.concatenate((np.column_stack((j, k, sides + k)), np.column_stack((j, sides + k, sides + j))))


def plate(holes: set[tuple[int, int]], n: int = 13, m: int = 9) -> Surface:
    """Return a plate of n x m squares of 10 mm, without the squares in `holes`."""
    x, y = np.meshgrid(10.0 * np.arange(n + 1), 10.0 * np.arange(m + 1), indexing="ij")
    V = np.column_stack((x.ravel(), y.ravel(), np.zeros(x.size)))
    cells = np.array([i * (m + 1) + j for i in range(n) for j in range(m) if (i, j) not in holes])
    a, b = cells, cells + m + 1
    F = np.concatenate((np.column_stack((a, b, b + 1)), np.column_stack((a, b + 1, a + 1))))
    used, F = np.unique(F, return_inverse=True)
    return V[used], F.reshape(-1, 3)


def thicken_plate(V: np.ndarray, F: np.ndarray, height: float) -> Surface:
    """Return a closed plate of the given height, with walls along its rim and around its holes."""
    rim = igl.boundary_facets(F)[0]
    walls = np.concatenate((rim[:, [0, 1]], rim[:, [1, 0]]))
    third = np.concatenate((rim[:, 1], rim[:, 0])) + len(V)
    third[len(rim) :] = rim[:, 0] + len(V)
    walls = np.concatenate(
        (np.column_stack((rim, rim[:, 1] + len(V))), np.column_stack((rim[:, 0], rim + len(V)))[:, [0, 2, 1]])
    )
    return np.concatenate((V, V + np.array([0, 0, height]))), np.concatenate((F[:, ::-1], F + len(V), walls))


def box(x: float, y: float, z: float) -> Surface:
    return thicken_plate(
        np.array([[0, 0, 0], [x, 0, 0], [x, y, 0], [0, y, 0.0]]), np.array([[0, 1, 2], [0, 2, 3]]), z
    )


def made(path: Path, surface: Surface, **options: object) -> Pattern:
    V, F = surface
    return write_pattern(path, V, F, unwrap(V, F, method="isometric", progress=False), **options)


def directions(pattern: Pattern) -> np.ndarray:
    along = pattern.grain[:, 1] - pattern.grain[:, 0]
    return along / np.linalg.norm(along, axis=1)[:, None]


ONE_PIECE = {
    **{f"band of {n} sides, {h} high": band(n, h) for n in (3, 4, 5, 6, 9, 24) for h in (0.1, 0.3, 1, 4)},
    **{f"open band of {n}": band(n, 0.2, whole=False) for n in (4, 5, 12)},
    **{f"frustum of {n}": band(n, 0.7, 0.5) for n in (4, 5, 24)},
    **{f"box {size}": box(*size) for size in ((1, 1, 1), (5, 1, 1), (10, 10, 0.3), (1, 2, 3))},
}


@pytest.mark.parametrize("name", ONE_PIECE)
def test_developable_surfaces_are_one_piece_with_true_lengths(tmp_path: Path, name: str) -> None:
    V, F = ONE_PIECE[name]
    for turn in (np.eye(3), TURNED):
        pattern = made(tmp_path / "p.svg", (V @ turn.T, F))
        assert pattern.pieces == len(pattern.outlines) == 1
        assert pattern.error < 1e-6
        outline = np.vstack((pattern.outlines[0], pattern.outlines[0][:1]))
        x, y = outline.T
        enclosed = (x[:-1] * y[1:] - x[1:] * y[:-1]).sum() / 2
        assert enclosed == pytest.approx(igl.doublearea(V, F).sum() / 2)  # equal areas exclude overlaps


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize(
    "holes", [{(6, 4)}, {(2, 2), (10, 2)}, {(i, j) for i in range(1, 12, 2) for j in (2, 6)}]
)
def test_holes_of_a_plate_stay_holes(tmp_path: Path, holes: set[tuple[int, int]], single: bool) -> None:
    V, F = plate(holes)
    for turn in (np.eye(3), TURNED):
        turned = V @ turn.T
        if single:
            turned = turned.astype(np.float32).astype(float)
        pattern = made(tmp_path / "p.svg", (turned, F))
        assert (pattern.pieces, len(pattern.seams)) == (1, 0)
        assert len(pattern.outlines) == 1 + len(holes)
        length = sum(
            np.linalg.norm(np.roll(line, -1, axis=0) - line, axis=1).sum() for line in pattern.outlines
        )
        assert length == pytest.approx(2 * (130 + 90) + 40 * len(holes), rel=1e-6)
    pattern = made(tmp_path / "p.svg", thicken_plate(V, F, 2))
    assert len(pattern.outlines) >= pattern.pieces + 2 * len(holes)  # both sides of the plate have the holes
    assert pattern.error < 1e-6


def test_a_tab_stays_joined_to_its_plate(tmp_path: Path) -> None:
    V, F = plate(set(), 12, 8)
    edge = np.flatnonzero(V[:, 1] == 80)[[5, 6]]  # a tab of 10 mm width, bent up, on a side of 120 mm
    tab = np.vstack((V, V[edge] + [0, 0, 30.0]))
    n = len(V)
    faces = np.vstack((F, [[edge[0], edge[1], n], [edge[1], n + 1, n]]))
    assert made(tmp_path / "p.svg", (tab, faces)).pieces == 1


@pytest.mark.parametrize("wide", [10.0, 2.5])
def test_pieces_are_joined_along_the_longer_edge(tmp_path: Path, wide: float) -> None:
    """Two walls that form one piece stand on a floor, and are joined to it along the longer of two edges."""
    V = np.array([[0, 0, 0], [wide, 0, 0], [wide, 4, 0], [0, 4, 0], [0, 0, 1], [wide, 0, 1], [wide, 4, 1.0]])
    F = [[0, 1, 2, 3], [1, 0, 4, 5], [2, 1, 5, 6]]
    atlas = unwrap(V, F, [[0, 1], [1, 2]], method="isometric", progress=False)
    assert len(atlas.charts) == 2
    report = replace(atlas.report, given_seams=atlas.report.given_seams[:0])
    pattern = write_pattern(tmp_path / "p.svg", V, F, replace(atlas, report=report))
    assert pattern.pieces == 1
    assert sum(seam.length for seam in pattern.seams) == pytest.approx(min(wide, 4))


def test_given_seams_are_kept(tmp_path: Path) -> None:
    V, F = plate({(6, 4)}, 13, 9)
    across = np.flatnonzero(np.isclose(V[:, 0], 60))
    across = across[np.argsort(V[across, 1])]
    seams = np.column_stack((across[:-1], across[1:]))
    seams = seams[np.linalg.norm(V[seams[:, 0]] - V[seams[:, 1]], axis=1) < 11]
    pattern = write_pattern(tmp_path / "p.svg", V, F, unwrap(V, F, seams[:4], progress=False))
    assert len(pattern.outlines) == 1  # a slit joins the hole to the rim, so that there is one outline
    V, F = band(5, 1.0)
    every = np.column_stack((np.arange(5), np.arange(5, 10)))
    assert write_pattern(tmp_path / "p.svg", V, F, unwrap(V, F, every, progress=False)).pieces == 5


def test_all_arrows_point_up(tmp_path: Path) -> None:
    tubes, faces, n = [], [], 0
    for k, axes in enumerate(([0, 1, 2], [2, 0, 1], [1, 2, 0])):
        V, F = band(24, 7.0 + k)
        tubes.append(V[:, axes] + [30 * k, 0, 0])
        faces.append(F + n)
        n += len(V)
    pattern = made(tmp_path / "p.svg", (np.concatenate(tubes), np.concatenate(faces)))
    assert pattern.pieces == 3
    assert np.allclose(directions(pattern), [0, 1])
    for line, height in zip(
        sorted(pattern.outlines, key=lambda line: np.ptp(line[:, 1])), (7, 8, 9), strict=True
    ):
        assert np.ptp(line[:, 1]) == pytest.approx(
            height
        )  # the piece is longer than wide, so the arrow is along the axis


def test_the_arrow_of_a_box_lies_along_its_edges(tmp_path: Path) -> None:
    for size in ((80, 80, 80), (10, 40, 40), (30, 80, 50)):
        arrow = directions(made(tmp_path / "p.svg", box(*size)))
        assert np.sort(abs(arrow[0])) == pytest.approx([0, 1], abs=1e-6), size


def test_up_rotates_the_pieces_and_arrows_follow_the_grain(tmp_path: Path) -> None:
    V, F = band(4, 3.0, whole=False)
    for up, size in (([0, 0, 1], (3 * np.sqrt(2), 3)), ([0, 0, -2], (3 * np.sqrt(2), 3))):
        pattern = made(tmp_path / "p.svg", (V, F), up=up)
        assert pattern.size == pytest.approx(size)
        assert np.allclose(directions(pattern), [0, np.sign(up[2])])
    with pytest.raises(ValueError, match="up is "):
        made(tmp_path / "p.svg", (V, F), up=[0, 0, 0])


def pages(path: Path) -> int:
    return len(re.findall(rb"/MediaBox", path.read_bytes()))


@pytest.mark.parametrize("turn", [np.eye(3), np.eye(3)[[2, 0, 1]], TURNED])
def test_a_rectangle_is_axis_aligned_and_uses_few_pages(tmp_path: Path, turn: np.ndarray) -> None:
    V = np.array([[0, 0, 0], [251, 0, 0], [251, 100, 0], [0, 100, 0.0]]) @ turn.T
    pattern = made(tmp_path / "p.pdf", (V, np.array([[0, 1, 2], [0, 2, 3]])))
    assert sorted(pattern.size) == pytest.approx([100, 251])
    assert pages(tmp_path / "p.pdf") <= (1 if pattern.size[0] > pattern.size[1] else 2)


@pytest.mark.parametrize("length", [1850, 1920, 1990])
def test_pages_cover_a_whole_strip(tmp_path: Path, length: float) -> None:
    V = np.array([[0, 0, 0], [length, 0, 0], [length, 60, 0], [0, 60, 0.0]])
    made(tmp_path / "p.pdf", (V, np.array([[0, 1, 2], [0, 2, 3]])))
    # the first page of 297 mm shows 277 mm, and each next page overlaps it by 10 mm; the strip starts at 10
    # mm
    assert 277 + 267 * (pages(tmp_path / "p.pdf") - 1) >= 10 + length


def test_many_pieces_do_not_overlap(tmp_path: Path) -> None:
    V, F = band(3, 0.5, whole=False)
    grid = [V + np.array([3.0 * i, 3.0 * j, 0]) for i in range(12) for j in range(12)]
    faces = np.concatenate([F + len(V) * k for k in range(len(grid))])
    pattern = made(tmp_path / "p.svg", (np.concatenate(grid), faces))
    assert pattern.pieces == 144
    assert np.allclose(directions(pattern), [0, 1])
    flat, fans, n = [], [], 0
    for line in pattern.outlines:
        fans += [[n, n + k, n + k + 1] for k in range(1, len(line) - 1)]
        flat.append(line)
        n += len(line)
    assert not len(overlaps(np.concatenate(flat), fans, between=True))


def test_the_command_rotates_pieces_by_an_axis(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    V, F = band(5, 0.2)
    igl.write_triangle_mesh(str(tmp_path / "band.obj"), 1000 * V, F)
    out = str(tmp_path / "band.svg")
    assert main(["pattern", str(tmp_path / "band.obj"), "-o", out, "--units", "mm", "--up", "z"]) == 0
    assert "1 piece, 5877.9 x 200.0 mm" in capsys.readouterr().out
    with pytest.raises(SystemExit) as stopped:
        main(["pattern", str(tmp_path / "band.obj"), "-o", out, "--up", "w"])
    assert stopped.value.code == 2
    assert "give x, y, z" in capsys.readouterr().err
