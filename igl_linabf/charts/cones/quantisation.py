"""Curvatures of cones in quarter turns: for little stretch, and for closed paths that turn by quarters."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...angles import HolonomyAngles
from ..cut_graphs import MAX_LOG_SCALE, expected_stretch
from . import constants
from .constants import MAX_QUARTERS, QUARTER_TURN
from .scale import ConeScale


@dataclass(frozen=True, eq=False)
class QuantisedCurvatures:
    """Curvatures of cones in quarter turns, found by exchanges.

    In an exchange one cone gets a quarter turn and another one loses it: so the sum stays what Gauss-Bonnet
    asks for. The boundary, if there is one, takes part as well, without bounds. So there is a *slot* for the
    ground, which is the boundary or else the first cone, and one for each other cone.

    Attributes
    ----------
    scale : ConeScale
        With all cones.
    least : (#C,) int64
        Of each of the scale's `nodes`; all have `MAX_QUARTERS` at most.
    """

    scale: ConeScale
    least: IntArray

    @property
    def _bounded(self) -> bool:
        return self.scale.first < 0

    @cached_property
    def _bounds(self) -> tuple[FloatArray | IntArray, FloatArray | IntArray]:
        """Fewest and most quarter turns of each slot; the boundary's are not bound."""
        upper = np.full(len(self.least), MAX_QUARTERS)
        if not self._bounded:
            return self.least, upper
        return np.append(-np.inf, self.least), np.append(np.inf, upper)

    @cached_property
    def _sampled(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """At samples: weights by area, u without the slots, and what a quarter turn of each adds to u."""
        scale = self.scale
        sample = np.arange(0, scale.piece.graph.n, -(-scale.piece.graph.n // constants.STRETCH_SAMPLES))
        weight = scale.piece.area[sample] / scale.piece.area[sample].sum()
        green = np.concatenate((np.zeros((1, len(sample))), scale.green[:, sample])) * QUARTER_TURN
        return weight, scale.bare[sample], green

    @cached_property
    def for_stretch(self) -> IntArray:
        """The curvature of each node: the nearest quarters, exchanged while the expected stretch falls."""
        exact, least = self.scale.curvature / QUARTER_TURN, self.least
        k = np.clip(np.round(exact).astype(np.int64), least, MAX_QUARTERS)
        if not self._bounded:
            while beyond := int(k.sum()) - round(float(exact.sum())):  # change those that round worst
                sign = -1 if beyond > 0 else 1
                able = (k > least) if beyond > 0 else (k < MAX_QUARTERS)
                able |= not able.any()  # more than there is room for is spread over all of them
                k[np.argmax(np.where(able, sign * (exact - k), -np.inf))] += sign
        k, (lower, upper) = self._in_slots(k), self._bounds
        weight, bare, green = self._sampled
        grown, shrunk = np.exp(2 * green), np.exp(-2 * green)
        for _ in range(constants.MAX_EXCHANGES):
            u = np.clip(bare + k @ green, -MAX_LOG_SCALE, MAX_LOG_SCALE)
            # with one quarter more at i and one less at j, u grows by green_i - green_j
            squared = (grown * (weight * np.exp(2 * u))) @ shrunk.T
            squared *= (shrunk * (weight * np.exp(-2 * u))) @ grown.T
            allowed = (k < upper)[:, None] & (k > lower)
            i, j = np.unravel_index(np.argmin(np.where(allowed, squared, np.inf)), squared.shape)
            if i == j or not squared[i, j] < constants.EXCHANGE_GAIN * squared[i, i]:
                break
            k[i], k[j] = k[i] + 1, k[j] - 1
        return self._of_nodes(k)

    @property
    def log_stretch(self) -> float:
        """The logarithm of the stretch that is expected of `for_stretch`."""
        curvature: FloatArray = np.asarray(self.for_stretch * QUARTER_TURN)
        return float(np.log(expected_stretch(self.scale.piece, self.scale.log_scale_of(curvature))))

    def for_paths(self, holonomy: HolonomyAngles) -> tuple[IntArray, FloatArray]:
        """The curvature of each node with which closed paths turn by nearly whole quarters, too.

        At most two more exchanges are made: those for which the log stretch, and what paths miss to whole
        quarters, cost least together. `holonomy` belongs to `for_stretch`, with a row for each node.

        Returns
        -------
        k : (#C,) int64
        quarters : (#paths,) float64
            What the paths are to turn by.
        """
        base, (lower, upper) = self._in_slots(self.for_stretch), self._bounds
        unit = np.eye(len(base), dtype=np.int64)
        single = (unit[:, None] - unit[None]).reshape(-1, len(base))
        single = single[(single != 0).any(axis=1)]
        likely = np.argsort(self._log_squared(base + single), kind="stable")[: constants.PAIRED_EXCHANGES]
        changed = np.concatenate((0 * base[None], single[likely]))
        i, j = np.tril_indices(len(changed))  # two of these; the first one changes nothing
        least, most = (np.clip(bound - base, -4, 4).astype(np.int8) for bound in (lower, upper))
        both = changed.astype(np.int8)[i] + changed.astype(np.int8)[j]
        able = ((both >= np.minimum(least, 0)) & (both <= np.maximum(most, 0))).all(axis=1)
        i, j, both = i[able], j[able], both[able]

        # one quarter more of curvature is one less of the angle sum
        by_change = self._of_nodes(changed) @ holonomy.by_vertex
        path_turns = holonomy.angle / QUARTER_TURN - by_change[i] - by_change[j]
        missing = constants.DISTORTION_PER_LOG_STRETCH * distortion(
            path_turns, quantise_holonomy(path_turns, holonomy.cost), holonomy.cost
        )
        one = self._log_squared(base + changed)
        mixed = 4 * changed @ self._variance[1] @ changed.T  # of the quadratic form
        squared = one[i] + one[j] - one[0] + 2 * mixed[i, j]
        best = np.argsort(missing + squared / 2, kind="stable")[: constants.ESTIMATED_PAIRS]
        chosen = best[np.argmin(missing[best] + self._log_stretch(base + both[best]))]
        return self._of_nodes(base + both[chosen]), quantise_holonomy(path_turns[[chosen]], holonomy.cost)[0]

    def _in_slots(self, k: IntArray) -> IntArray:
        return np.append(0, k) if self._bounded else k

    def _of_nodes(self, k: IntArray) -> IntArray:
        return k[..., 1:] if self._bounded else k

    def _log_squared(self, k: IntArray) -> FloatArray:
        """The logarithm of the squared stretch to second order: four times the variance of u."""
        alone, square, mixed = self._variance
        return np.asarray(4 * (alone + (k @ square * k).sum(axis=1) + 2 * k @ mixed))

    @cached_property
    def _variance(self) -> tuple[float, FloatArray, FloatArray]:
        """The variance of u, quadratic in the slots' curvatures: constant, form, half the linear part."""
        weight, bare, green = self._sampled
        bare, green = bare - weight @ bare, green - (green @ weight)[:, None]
        return float(weight @ bare**2), (green * weight) @ green.T, (green * weight) @ bare

    def _log_stretch(self, k: IntArray) -> FloatArray:
        """The logarithm of the expected stretch, (n,) for (n, #slots)."""
        weight, bare, green = (part.astype(np.float32) for part in self._sampled)  # many exponentials
        most = np.log(np.finfo(np.float32).max) / 2  # so that the squares of scales are finite
        scaled = np.exp(2 * np.clip(bare + k.astype(np.float32) @ green, -most, most))
        return np.asarray(np.log((scaled @ weight) * ((1 / scaled) @ weight)) / 2)


def quantise_holonomy(path_turns: FloatArray, cost: FloatArray) -> FloatArray:
    """Whole quarters near those that paths turn by, (n, #paths), for which `distortion` is low.

    They are rounded one path after another, with regard to what those before miss (Babai 1986).
    """
    upper = np.linalg.cholesky(cost).T
    quarters = np.zeros_like(path_turns)
    for i in range(len(cost) - 1, -1, -1):
        left = (path_turns - quarters)[:, i + 1 :] @ upper[i, i + 1 :] / upper[i, i]
        quarters[:, i] = np.round(path_turns[:, i] + left)
    return quarters


def distortion(path_turns: FloatArray, quarters: FloatArray, cost: FloatArray) -> FloatArray:
    """What it costs, (n,), as F/3nt, that paths turn by whole quarters instead, both (n, #paths)."""
    missing = (quarters - path_turns) * QUARTER_TURN
    return np.asarray(((missing @ cost) * missing).sum(axis=1))
