"""Faces of zero area: short sides collapsed, caps opened by a hair, so that the surface stays closed."""

from __future__ import annotations

import numpy as np

from .._types import FloatArray, IntArray
from .areas import without_area
from .components import connected_labels

SAME_PLACE = 1e-9  # of the extent: a shorter side of a face without area is collapsed
OPENED = 1e-4  # of its face's shortest side: how far a vertex moves, so that the face has an area
DOUBLINGS = 14  # of that, until it has


def sides_of(V: FloatArray, F: IntArray) -> FloatArray:
    """Lengths of the sides from corner k to k + 1, (#F, 3)."""
    return np.asarray(np.linalg.norm(V[F[:, [1, 2, 0]]] - V[F], axis=2))


def collapsed(V: FloatArray, F: IntArray) -> IntArray:
    """For each vertex the one that it becomes, where the short sides of faces without area collapse."""
    merged = np.arange(len(V))
    while True:
        now = merged[F]
        whole = np.flatnonzero((now != now[:, [1, 2, 0]]).all(axis=1))
        flat = whole[without_area(V, now[whole])] if len(whole) else whole
        corners = now[flat]
        extent = np.abs(V[corners]).max(axis=(1, 2), initial=0)
        lengths = sides_of(V, corners)
        t, k = np.nonzero(lengths <= SAME_PLACE * np.maximum(extent, lengths.max(axis=1, initial=0))[:, None])
        if not len(t):
            return merged
        label = connected_labels(np.column_stack((corners[t, k], corners[t, (k + 1) % 3])), len(V))
        merged = np.unique(label, return_index=True)[1][label][merged]


def opened_caps(V: FloatArray, F: IntArray) -> tuple[FloatArray, IntArray]:
    """`V` with the vertices of faces without area moved by a hair, and these faces.

    The vertex opposite to the longest side moves. In the flattened surface, where such a face keeps
    its angles, the vertex is on that side but for the same hair.
    """
    found = flat = without_area(V, F)
    random, step, still = np.random.default_rng(0), OPENED, V
    for _ in range(DOUBLINGS):
        if not len(flat):
            break
        lengths = sides_of(still, F[flat])
        mover = F[flat, (lengths.argmax(axis=1) + 2) % 3]
        reach = np.full(len(V), np.inf)
        np.minimum.at(reach, mover, step * lengths.min(axis=1))
        middle = np.unique(mover)
        away = random.normal(size=(len(middle), 3))
        away /= np.linalg.norm(away, axis=1, keepdims=True)
        V = V.copy()
        V[middle] = still[middle] + reach[middle, None] * away
        step *= 2
        flat = without_area(V, F)
    return V, found
