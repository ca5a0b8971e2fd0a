"""A map does not depend on position, scale, numbering, or storage of the arrays."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import load

from igl_linabf import LinABF, abf, flatten, linabf, lscm, unwrap

NAMES = ("bumps", "cortex", "disk__igl_camel_b.obj", "disk__igl_lion.off", "stress__optcuts_golf.obj")


def size(uv: np.ndarray) -> float:
    return float(np.ptp(uv, axis=0).max())


@pytest.mark.filterwarnings("ignore:.*overlaps itself:igl_linabf.OutcomeWarning")
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_maps_do_not_depend_on_rigid_motion_or_scale(name: str, scale: float) -> None:
    V, F = load(name)
    uv = linabf(V, F)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    moved = scale * (V @ turn.T + np.ptp(V) * np.array([1.0, -2.0, 0.5]))
    assert np.abs(linabf(moved, F) / scale - uv).max() <= 1e-8 * size(uv)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("layout", ["auto", "least-squares", "greedy"])
def test_maps_do_not_depend_on_numbering(name: str, layout: str) -> None:
    V, F = load(name)
    rng = np.random.default_rng(0)
    new = rng.permutation(len(V))
    turned = F[np.arange(len(F))[:, None], (np.arange(3) + rng.integers(0, 3, (len(F), 1))) % 3]
    renumbered = np.empty_like(V)
    renumbered[new] = V
    # after one exact step, the angles do not fit together, and both layouts must distribute the residual
    # equally
    method = LinABF(layout=layout, iterations=1, rtol=1e-10)
    a = flatten(V, F, method=method)
    b = flatten(renumbered, new[turned][rng.permutation(len(F))], method=method)
    assert a.report.layout == b.report.layout
    assert np.abs(b.uv[new] - a.uv).max() <= 1e-7 * size(a.uv)


@pytest.mark.filterwarnings("ignore:.*overlaps itself:igl_linabf.OutcomeWarning")
@pytest.mark.parametrize("name", NAMES[:-1])
def test_converged_abf_does_not_depend_on_motion_scale_or_numbering(name: str) -> None:
    V, F = load(name)
    uv = abf(V, F, tol=1e-9)
    new = np.random.default_rng(0).permutation(len(V))
    moved = np.empty_like(V)
    moved[new] = 1e3 * (V[:, [1, 2, 0]] + np.ptp(V))
    assert np.abs(abf(moved, new[F], tol=1e-9)[new] / 1e3 - uv).max() <= 1e-7 * size(uv)


@pytest.mark.parametrize("name", ["bumps", "cortex"])
def test_pins_do_not_depend_on_numbering(name: str) -> None:
    V, F = load(name)
    new = np.random.default_rng(1).permutation(len(V))
    renumbered = np.empty_like(V)
    renumbered[new] = V
    b, bc = np.array([3, len(V) // 2]), np.array([[0.0, 1.0], [2.0, 1.0]])
    for layout in ("boundary", "least-squares"):
        options = {"layout": layout, "rtol": 1e-10}
        uv = linabf(V, F, b, bc, **options)
        assert np.abs(uv[b] - bc).max() <= 1e-12
        again = linabf(renumbered, new[F], new[b], bc, **options)[new]
        assert np.abs(again - uv).max() <= 1e-6 * size(uv)


def test_arrays_of_any_dtype_and_order_give_the_same_map() -> None:
    V, F = load("bumps")
    V = np.round(V * 4096) / 4096  # exact in single precision, and in integers after scaling
    uv = linabf(V, F)
    same = [
        (V.astype(np.float32), F.astype(np.int32)),
        (np.asfortranarray(V), np.asfortranarray(F.astype(np.uint16))),
        (V.tolist(), F.tolist()),
        (V[::-1][::-1], F.astype(float)),
    ]
    for positions, faces in same:
        assert (linabf(positions, faces) == uv).all()
    whole = linabf((4096 * V).astype(np.int32), F)
    assert np.abs(whole / 4096 - uv).max() <= 1e-10 * size(uv)


def test_the_input_does_not_change_and_runs_repeat_exactly() -> None:
    V, F = load("bumps")
    before = V.copy(), F.copy()
    V.flags.writeable = F.flags.writeable = False
    for call in (
        linabf,
        abf,
        lscm,
        lambda *mesh: flatten(*mesh, method="isometric").uv,
        lambda *mesh: unwrap(*mesh).TC,
        lambda *mesh: unwrap(*mesh, cones=2).TC,
    ):
        assert (call(V, F) == call(V, F)).all()
    assert (before[0] == V).all()
    assert (before[1] == F).all()


@pytest.mark.parametrize("scale", [1e-20, 1e3, 1e20])
def test_the_spectral_map_has_the_size_of_the_surface_in_any_unit(scale: float) -> None:
    V, F = load("disk__igl_camel_b.obj")
    uv, other = (flatten(factor * V, F, method="scp").uv @ [1, 1j] for factor in (1.0, scale))
    one, other = uv - uv.mean(), (other - other.mean()) / scale
    turn = np.vdot(one, other) / np.vdot(one, one)
    assert np.abs(other - turn * one).max() <= 1e-4 * np.abs(one).max()  # igl iterates until 1e-6
    assert abs(abs(turn) - 1) <= 1e-4
    covered, area = (igl.doublearea(P, F).sum() for P in (np.column_stack((uv.real, uv.imag)), V))
    assert abs(covered / area - 1) < 1e-2  # two triangles of this map are flipped
