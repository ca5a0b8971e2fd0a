"""`flatten(..., clean=True)` returns a map of all given vertices of a disk with degenerate faces."""

import numpy as np
import pytest

from igl_linabf import MeshError, flatten
from igl_linabf._types import FloatArray, IntArray


def make_disk(n: int = 12) -> tuple[FloatArray, IntArray]:
    row, column = np.mgrid[:n, :n].astype(float)
    V = np.stack((column, row, 2 * np.sin(column / 4)), axis=2).reshape(-1, 3)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    return V, np.concatenate((np.column_stack((a, a + 1, a + n)), np.column_stack((a + 1, a + n + 1, a + n))))


def make_coincident(pairs: list[tuple[int, int]]) -> tuple[FloatArray, IntArray]:
    V, F = make_disk()
    for keep, moved in pairs:
        V[moved] = V[keep]
    return V, F


PAIRS = [(30, 31), (77, 89), (0, 1)]


def test_coincident_neighbours_get_the_same_position() -> None:
    V, F = make_coincident(PAIRS)
    with pytest.raises(MeshError, match="zero area"):
        flatten(V, F)
    result = flatten(V, F, method="isometric", clean=True)
    assert np.isfinite(result.uv).all() and result.outcome.good
    for keep, moved in PAIRS:
        np.testing.assert_array_equal(result.uv[keep], result.uv[moved])
    assert [repair.kind for repair in result.report.repairs] == ["collapsed"]
    given = {frozenset(face) for face in F.tolist()}
    merged = {moved: keep for keep, moved in PAIRS}
    assert {frozenset(merged.get(i, i) for i in face) for face in given} >= {
        frozenset(face) for face in result.F.tolist()
    }


def test_a_sound_disk_has_the_same_result_to_the_bit() -> None:
    V, F = make_disk()
    np.testing.assert_array_equal(flatten(V, F).uv, flatten(V, F, clean=True).uv)


def test_options_refer_to_given_vertices() -> None:
    V, F = make_coincident(PAIRS)
    pinned = flatten(V, F, [1, 143], [[0, 0], [3, 4]], clean=True).uv
    np.testing.assert_allclose(pinned[[0, 1, 143]], [[0, 0], [0, 0], [3, 4]], atol=1e-9)
    square = flatten(V, F, boundary="rectangle", corners=[1, 11, 143, 132], clean=True)
    assert sorted(square.report.corners.tolist()) == [0, 11, 132, 143]
    assert np.isfinite(square.uv).all()


def test_a_repair_that_cuts_vertices_apart_is_refused() -> None:
    V, F = make_disk()
    bowtie = np.concatenate((F, [[143, 144, 145]]))
    V = np.concatenate((V, [[20, 11, 0], [20, 12, 0]]))
    with pytest.raises(MeshError, match="cuts the surface apart at vertices 143"):
        flatten(V, bowtie, clean=True)
