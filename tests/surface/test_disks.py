"""In a batch of meshes, the valid disks are found among other meshes."""

from __future__ import annotations

import warnings

import igl
import numpy as np
import pytest
from bad_input import REFUSED, torus
from bad_input import F as STRIP
from bad_input import V as POINTS
from conftest import bumps

from igl_linabf import MeshError
from igl_linabf.surface import concatenate_sound_disks, planar_mesh

Surface = tuple[np.ndarray, np.ndarray]


def place_beside(*parts: Surface) -> Surface:
    start = np.cumsum([0, *(len(V) for V, _ in parts)])
    return np.concatenate([V for V, _ in parts]), np.concatenate(
        [F + k for (_, F), k in zip(parts, start, strict=False)]
    )


def meshes() -> dict[str, Surface]:
    """Return disks and other meshes, including meshes with one loop or the Euler characteristic of a disk."""
    V, F = bumps(60)
    inside = np.setdiff1d(np.arange(len(V)), igl.boundary_loop(F))[5]
    ring = F[~(inside == F).any(axis=1)]
    used, index = np.unique(ring, return_inverse=True)
    made = {
        "strip": (POINTS, STRIP),
        "triangle": (np.eye(3), np.array([[0, 1, 2]])),
        "handle": torus(1),
        "disk beside a torus": place_beside((V, F), torus(0)),
        "disk beside a ball": place_beside((V, F), igl.icosahedron()),
        "two disks": place_beside((V, F), (V, F)),
        "hole": (V[used], index.reshape(-1, 3)),
        "unused": (np.vstack((V, V[:1])), F),
        "not a number": (np.where(np.arange(len(V))[:, None] == 7, np.nan, V), F),
        "too large": (V * 1e100, F),
    }
    for name, (vertices, faces, pinned, _) in REFUSED.items():
        arrays = [
            x for x in (vertices, faces) if isinstance(x, np.ndarray) and x.shape[1:] == (3,) and len(x)
        ]
        if not pinned and [x.dtype for x in arrays] == [np.float64, np.int64]:
            made[name] = vertices, faces
    made["bumps"] = V, F
    return made


def is_sound(V: np.ndarray, F: np.ndarray) -> bool:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            mesh = planar_mesh(V, F)
        except MeshError:
            return False
    return len(mesh.topology.loops) == 1 and len(mesh.vertices) == len(V)


@pytest.mark.filterwarnings("ignore:invalid value")
def test_valid_disks_in_a_batch_are_found_and_equal_their_single_meshes() -> None:
    given = meshes()
    assert len(given) > 20
    for chosen in (list(given), *([name, "bumps"] for name in given), *([name] for name in given)):
        disks, places = concatenate_sound_disks([given[name] for name in chosen])
        assert [chosen[i] for i in places] == [name for name in chosen if is_sound(*given[name])]
        assert (disks is None) == (not len(places))
        for k, i in enumerate(places.tolist()):
            mesh = planar_mesh(*given[chosen[i]])
            own, first = disks.faces.split(disks.double_area)[k], disks.vertices.start[k]
            np.testing.assert_array_equal(own, mesh.double_area)
            loop = disks.topology.loops[k] - first
            np.testing.assert_array_equal(
                np.roll(loop, -np.argmin(loop)),
                np.roll(mesh.topology.loops[0], -np.argmin(mesh.topology.loops[0])),
            )
