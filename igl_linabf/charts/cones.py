"""Cones: the vertices that keep curvature when the rest of a surface is flattened."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import advance
from .._types import IntArray
from ..surface import Submesh
from .cone_scale import ConeScale
from .cut_graph import closed_surface

CONE_TRADE = 30.0
MAX_CONES = 100
IN_VAIN = 4
LEAST_ANGLE = np.pi / 3

def cones_of(piece, n, trade):
    scale = ConeScale.of(piece)
    best, least, in_vain = scale.nodes, np.inf, 0
    for _ in range(MAX_CONES):
        angle = 2*np.pi - scale.curvature
        narrow = angle.min(initial=np.pi) < LEAST_ANGLE
        u = np.abs(scale.log_scale)
        cost = scale.stretch + len(scale.nodes)/trade + 1e3*narrow
        print(len(scale.nodes), 'stretch %.3f'%scale.stretch, 'cost %.3f'%cost,np.round(np.sort(angle)/np.pi,2)[:4],np.round(np.sort(angle)/np.pi,2)[-3:])
        in_vain = 0 if cost < least else in_vain + 1
        if in_vain == 0:
            best, least = scale, cost
        if in_vain >= IN_VAIN and not narrow: break
        if narrow:
            _,_,source = piece.search(scale.nodes)
            u = np.where(source == scale.nodes[np.argmin(angle)], u, 0)
        scale = scale.with_cone(int(np.argmax(u)))
    return best
