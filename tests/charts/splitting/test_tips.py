"""Seams end where a map would shrink most."""

from __future__ import annotations

import numpy as np
from nasty_meshes import sphere

from igl_linabf.charts.cut_graphs import ClosedSurface, log_scale
from igl_linabf.charts.splitting import constants
from igl_linabf.charts.splitting.tips import seams_to_fine_tips
from igl_linabf.surface import Submesh, connected_labels


def test_a_seam_ends_at_the_most_shrunk_node_of_each_limb() -> None:
    V, F = sphere(5)
    limbs = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1.0], -np.ones(3) / np.sqrt(3)])
    height = np.exp((V @ limbs.T - 1) / 0.03).max(axis=1)
    closed = ClosedSurface.of(Submesh.checked(V * (1 + 2 * height)[:, None], F))
    body = np.flatnonzero((height < 1e-3)[closed.edges].all(axis=1))  # is cut everywhere: limbs alone shrink
    u = log_scale(closed, closed.graph.boundary_nodes(body), closed.curvature)
    ends = closed.graph.ends
    nodes, times = np.unique(ends[seams_to_fine_tips(closed, body, u, 10.0)], return_counts=True)
    found = set(nodes[times == 1].tolist()) - set(ends[body].ravel().tolist())
    share = closed.area / closed.area.sum()
    shrunk = np.exp(2 * u) < constants.TIP_AREA_SHARE * float(share @ np.exp(2 * u))
    limb = connected_labels(ends[shrunk[ends].all(axis=1)], closed.graph.n)
    rows = [np.flatnonzero(shrunk & (limb == of)) for of in np.unique(limb[shrunk])]
    assert len(rows) == len(limbs)
    assert found == {int(of[np.argmin(u[of])]) for of in rows}
