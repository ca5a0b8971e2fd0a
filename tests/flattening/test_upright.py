"""`up` rotates a map upright, and reports directions that vanish; pinned maps stay in place."""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pytest
from conftest import load
from own_measures import count_flipped_exactly

from igl_linabf import Flattener, MeshWarning, flatten
from igl_linabf.cli import main


def shell(turn: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return a part of a cylinder about z, 20 degrees wider on one side, rotated by `turn`."""
    a, z = np.meshgrid(turn + np.linspace(-1, 1.35, 15), np.linspace(0, 1, 9), indexing="ij")
    V = np.column_stack((np.cos(a.ravel()), np.sin(a.ravel()), z.ravel()))
    i, j = (k.ravel() for k in np.meshgrid(np.arange(14), np.arange(8), indexing="ij"))
    corner = 9 * i + j
    square = np.column_stack((corner, corner + 9, corner + 10, corner + 1))
    return V, np.concatenate((square[:, :3], square[:, [0, 2, 3]]))


@pytest.mark.parametrize("method", ["linabf", "isometric", "lscm"])
@pytest.mark.parametrize("up", [(0, 0, 1), (0, 0, -3), (0, 1, 0)])
def test_the_map_is_turned_so_that_the_direction_points_up(method: str, up: tuple[float, ...]) -> None:
    V, F = shell()
    plain, turned = flatten(V, F, method=method), flatten(V, F, method=method, up=up)
    z, other = (uv.uv @ [1, 1j] for uv in (plain, turned))
    # the two maps differ by a rotation
    assert np.allclose(np.abs(z - z.mean()), np.abs(other - other.mean()))
    height = V @ np.array(up)
    u, v = (np.linalg.lstsq(np.column_stack((turned.uv, np.ones(len(V)))), height, rcond=None)[0])[:2]
    assert v > 0
    assert abs(u) < 0.2 * v if up[2] == 0 else abs(u) < 1e-3 * v
    assert len(turned.flipped) == 0
    assert np.array_equal(Flattener(F).flatten(V, method=method, up=up).uv, turned.uv)


def test_directions_that_vanish_in_the_map_are_reported() -> None:
    V, F = shell()
    flat = np.column_stack((flatten(V, F).uv, np.zeros(len(V))))
    with pytest.warns(MeshWarning, match=r"points nowhere on this surface: the map is not turned"):
        made = flatten(flat, F, up=(0, 0, 1))
    assert np.array_equal(made.uv, flatten(flat, F).uv)


@pytest.mark.parametrize("asked", [{"up": (0, 0, 1)}, {"up": (1, 2, 3)}, {"fit": "lengths"}], ids=str)
def test_maps_are_not_moved_if_rounding_would_flip_a_triangle(asked: dict) -> None:
    V, F = load("limb")  # the map of this mesh reaches the limit of double precision
    plain = flatten(V, F)
    with pytest.warns(MeshWarning, match="the map is not (turned|scaled): faces .* at the end of double"):
        made = flatten(V, F, **asked)
    assert np.array_equal(made.uv, plain.uv)
    assert len(made.flipped) == count_flipped_exactly(made.uv, F)


def test_up_is_refused_with_pins_corners_or_invalid_directions() -> None:
    V, F = shell()
    with pytest.raises(ValueError, match="up does not go together with pins"):
        flatten(V, F, [0, 9], [[0, 0], [1, 0]], method="linabf", up=(0, 0, 1))
    with pytest.raises(ValueError, match="up does not go together with the rectangle's corners"):
        flatten(V, F, boundary="rectangle", up=(0, 0, 1))
    for bad in ((0, 0), (0, 0, 0), "z", (0, np.nan, 1)):
        with pytest.raises(ValueError, match=r"up is .*: give a direction in space"):
            flatten(V, F, up=bad)


@pytest.mark.parametrize(("text", "up"), [("z", (0, 0, 1)), ("-z", (0, 0, -1)), ("0,1,1", (0, 1, 1))])
def test_the_command_takes_axes_and_directions(tmp_path: Path, text: str, up: tuple[float, ...]) -> None:
    V, F = shell()
    igl.write_triangle_mesh(str(tmp_path / "shell.obj"), V, F)
    out = tmp_path / "map.obj"
    assert (
        main(["flatten", str(tmp_path / "shell.obj"), "-o", str(out), f"--up={text}", "--units", "mesh"]) == 0
    )
    _, TC, *_ = igl.readOBJ(str(out))
    assert np.allclose(TC[:, :2], flatten(V, F, up=up).uv, atol=1e-5)
