"""Many meshes at once: what a loop of `flatten` returns, for each its own outcome."""

from __future__ import annotations

import re
import warnings

import bad_input
import igl
import numpy as np
import pytest
from conftest import bumps, tree_cut

import igl_linabf as il
from igl_linabf.surface import Parts

Surface = tuple[np.ndarray, np.ndarray]


def one_by_one(V: object, F: object, method: object = "linabf") -> il.Flattening | il.MeshError:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return il.flatten(V, F, method)
        except il.MeshError as error:
            return error


def with_hole(V: np.ndarray, F: np.ndarray) -> Surface:
    """Without the faces around an interior vertex, which is left out."""
    inside = np.setdiff1d(np.arange(len(V)), igl.boundary_loop(F))
    kept = F[~(inside[np.argmin(np.linalg.norm(V[inside, :2], axis=1))] == F).any(axis=1)]
    used, index = np.unique(kept, return_inverse=True)
    return V[used], index.reshape(-1, 3)


def varied() -> dict[str, Surface]:
    """Disks that end in every way, and what is no disk."""
    sphere, faces = igl.icosahedron()
    for _ in range(3):
        sphere, faces = igl.upsample(sphere, faces)
        sphere = sphere / np.linalg.norm(sphere, axis=1)[:, None]
    V, F = bumps(150)
    stretched = sphere * [1, 1, 6]
    made = {f"bumps {k}": bumps(60 + 40 * k, k, 0.1 * k) for k in range(8)}
    made["flat"] = (V * [1, 1, 0], F)
    made["triangle"] = (np.eye(3), np.array([[0, 1, 2]]))
    made["square"] = (
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    made["fan"] = (np.vstack(([[0, 0, 1]], V[:8])), np.array([[0, i, i % 8 + 1] for i in range(1, 9)]))
    made["almost closed"] = (sphere, faces[1:])
    made["limb"] = tree_cut(stretched, faces, 2)
    made["folded"] = tree_cut(sphere * [0.1, 1, 3], faces, 3, seed=1)
    made["needles"] = (V * [1, 1e-7, 1], F)
    made["hole"] = with_hole(V, F)
    made["closed"] = (sphere, faces)
    made["two"] = (np.vstack((V, V + 5)), np.vstack((F, F + len(V))))
    made["unused"] = (np.vstack((V, V[:1])), F)
    made["turned"] = (V, np.vstack((F[:5, ::-1], F[5:])))
    made["cap"] = (
        np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-8, 0], [0.5, 1, 0]]),
        np.array([[0, 1, 2], [0, 2, 3], [2, 1, 3]]),
    )
    return made


@pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning", "ignore::igl_linabf.FallbackWarning")
@pytest.mark.parametrize(
    "method", ["linabf", il.LinABF(guarantee="injective", solver="direct"), "abf"], ids=str
)
def test_the_same_as_a_loop(method: object) -> None:
    meshes = varied()
    together = il.flatten_many(list(meshes.values()), method)
    assert len(together) == len(meshes)
    for (name, mesh), made in zip(meshes.items(), together, strict=True):
        alone = one_by_one(*mesh, method)
        if isinstance(alone, il.MeshError):
            assert type(made) is type(alone) and str(made) == str(alone), name
            continue
        assert isinstance(made, il.Flattening), name
        size = np.ptp(alone.uv[np.isfinite(alone.uv).all(axis=1)], axis=0).max()
        np.testing.assert_allclose(made.uv, alone.uv, rtol=0, atol=1e-10 * size, err_msg=name)
        np.testing.assert_allclose(made.angles, alone.angles, rtol=0, atol=1e-10, err_msg=name)
        assert [str(rung) for rung in made.ladder] == [str(rung) for rung in alone.ladder], name
        told, expected = (re.sub(r"residual \S+", "", result.message) for result in (made, alone))
        assert told == expected, name  # the residual may be of rounding
        for part in ("outcome", "method", "layout", "solver", "layout_solver", "inner_steps"):
            assert getattr(made, part) == getattr(alone, part), (name, part)
        for part in ("before", "after"):
            found, right = getattr(made, part), getattr(alone, part)
            assert found.largest == pytest.approx(right.largest, rel=1e-6, abs=1e-12), (name, part)
        assert made.gap == pytest.approx(alone.gap, rel=1e-6, abs=1e-12), name
        np.testing.assert_array_equal(made.flipped, alone.flipped)
        assert made.seconds.keys() == alone.seconds.keys()


@pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning")
def test_a_bad_mesh_is_its_own_error_and_never_the_end() -> None:
    good = bumps(80)
    bad = [(V, F) for V, F, *_ in bad_input.REFUSED.values()]
    made = il.flatten_many([mesh for pair in bad for mesh in (good, pair)] + [None, (1,), good])
    for mesh, result in zip(bad, made[1::2], strict=False):
        expected = one_by_one(*mesh)
        assert isinstance(result, type(expected))
        if isinstance(expected, il.MeshError):
            assert str(result) == str(expected) and result.__traceback__ is None
    alone = il.flatten(*good)
    for result in [*made[: 2 * len(bad) : 2], made[-1]]:
        np.testing.assert_allclose(result.uv, alone.uv, rtol=0, atol=1e-10)
    assert all(isinstance(result, il.MeshError) for result in made[-3:-1])
    assert il.flatten_many([]) == []


def test_a_symmetric_disk_is_turned_the_same_way_by_any_rounding() -> None:
    cross = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [-1, 0, 0], [0, -2, 0.0]])
    square = cross / [1, 2, 1]
    F = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]])
    rng = np.random.default_rng(0)
    for V in (cross, square):
        maps = [il.linabf(V * (1 + 1e-15 * rng.normal(size=V.shape)), F) for _ in range(10)]
        assert np.ptp(maps, axis=0).max() < 1e-12


def test_parts_are_reduced_and_summed_each_for_itself() -> None:
    sizes = np.array([3, 0, 1, 40, 7, 0])
    parts, rng = Parts.of_sizes(sizes), np.random.default_rng(0)
    values = rng.normal(size=sizes.sum())
    pieces = np.split(values, np.cumsum(sizes)[:-1])
    np.testing.assert_allclose(parts.sum(values), [piece.sum() for piece in pieces])
    np.testing.assert_array_equal(parts.max(values), [piece.max() if len(piece) else 0 for piece in pieces])
    np.testing.assert_array_equal(
        parts.cumsum(values), np.concatenate([np.cumsum(piece) for piece in pieces])
    )
    np.testing.assert_array_equal(parts.spread(np.arange(6)), np.repeat(np.arange(6), sizes))
