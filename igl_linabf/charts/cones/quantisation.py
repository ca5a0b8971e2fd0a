"""Curvatures of cones, and holonomy angles, as multiples of 90 degrees."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...angles import HolonomyAngles
from ..cut_graphs import MAX_LOG_SCALE, expected_stretch
from .constants import EXCHANGE_GAIN, QUARTER_TURN, SAMPLED_NODES, STRETCH_PER_DISTORTION, TRIED_EXCHANGES
from .scale import ConeScale


@dataclass(frozen=True, eq=False)
class QuantisedCurvatures:
    """Curvatures of cones in quarter turns.

    An exchange takes a quarter turn from one cone and gives it to another one, so the sum stays what
    Gauss-Bonnet asks. On a surface with a boundary, the boundary gives and takes freely, as one more cone
    would. So there is a *slot* for the ground of the scale, be it the first cone or the boundary, and one for
    each other cone.

    Attributes
    ----------
    scale : ConeScale
        With all cones.
    least : (#C,) int64
        The least curvature of each of the scale's `nodes`.
    most : int
        The largest curvature of all.
    """

    scale: ConeScale
    least: IntArray
    most: int

    @property
    def _has_boundary(self) -> bool:
        return self.scale.ground_cone < 0

    @cached_property
    def _bounds(self) -> tuple[IntArray, IntArray]:
        """The least and the largest curvature of each slot; the boundary has none."""
        upper = np.full(len(self.least), self.most)
        if not self._has_boundary:
            return self.least, upper
        unbound = np.iinfo(np.int32).max
        return np.append(-unbound, self.least), np.append(unbound, upper)

    @cached_property
    def _sampled(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """At some nodes: weights, the log scale without the slots, and what a quarter turn of each adds."""
        scale, n = self.scale, self.scale.closed.graph.n
        sample = np.arange(0, n, -(-n // SAMPLED_NODES))
        weight = scale.closed.area[sample] / scale.closed.area[sample].sum()
        green = np.concatenate((np.zeros((1, len(sample))), scale.green[:, sample])) * QUARTER_TURN
        return weight, scale.bare[sample], green

    @cached_property
    def for_stretch(self) -> IntArray:
        """The curvature of each node: rounded, and exchanged as long as the expected stretch falls."""
        exact, least = self.scale.curvature / QUARTER_TURN, self.least
        k = np.clip(np.round(exact).astype(np.int64), least, self.most)
        if not self._has_boundary:
            while excess := int(k.sum()) - round(float(exact.sum())):  # change those that round worst
                sign = -1 if excess > 0 else 1
                able = (k > least) if excess > 0 else (k < self.most)
                able |= not able.any()  # more than there is room for is spread over all of them
                k[np.argmax(np.where(able, sign * (exact - k), -np.inf))] += sign
        k, (lower, upper) = self._in_slots(k), self._bounds
        weight, bare, green = self._sampled
        grown, shrunk = np.exp(2 * green), np.exp(-2 * green)
        while True:
            u = np.clip(bare + k @ green, -MAX_LOG_SCALE, MAX_LOG_SCALE)
            # with a quarter turn more at i and one less at j, u grows by green_i - green_j
            squared = (grown * (weight * np.exp(2 * u))) @ shrunk.T
            squared *= (shrunk * (weight * np.exp(-2 * u))) @ grown.T
            allowed = (k < upper)[:, None] & (k > lower)
            i, j = np.unravel_index(np.argmin(np.where(allowed, squared, np.inf)), squared.shape)
            if i == j or not squared[i, j] < EXCHANGE_GAIN * squared[i, i]:
                break
            k[i], k[j] = k[i] + 1, k[j] - 1
        return self._of_nodes(k)

    @property
    def log_stretch(self) -> float:
        """The logarithm of the L2 stretch that is expected with `for_stretch`."""
        curvature: FloatArray = np.asarray(self.for_stretch * QUARTER_TURN)
        return float(np.log(expected_stretch(self.scale.closed, self.scale.log_scale_of(curvature))))

    def for_holonomy(self, holonomy: HolonomyAngles) -> tuple[IntArray, FloatArray]:
        """Curvatures with which holonomy angles, too, come near multiples of 90 degrees.

        They differ from `for_stretch` by at most two exchanges: those for which the log stretch and the
        distortion of the missing holonomy cost least. `holonomy` is predicted for `for_stretch`, and
        `holonomy.by_vertex` is of the nodes.

        Returns
        -------
        k : (#C,) int64
            The curvature of each node, quarter turns.
        turns : (#paths,) float64
            The holonomy angles to ask for, quarter turns.
        """
        base, (lower, upper) = self._in_slots(self.for_stretch), self._bounds
        unit = np.eye(len(base), dtype=np.int64)
        exchanges = (unit[:, None] - unit[None]).reshape(-1, len(base))
        exchanges = exchanges[(exchanges != 0).any(axis=1)]
        likely = np.argsort(self._log_squared(base + exchanges), kind="stable")[:TRIED_EXCHANGES]
        changed = np.concatenate((0 * base[None], exchanges[likely]))  # the first one changes nothing
        i, j = np.tril_indices(len(changed))
        # two exchanges change a slot by two at most
        least, most = (np.clip(bound - base, -2, 2).astype(np.int8) for bound in (lower, upper))
        both = changed.astype(np.int8)[i] + changed.astype(np.int8)[j]
        able = ((both >= np.minimum(least, 0)) & (both <= np.maximum(most, 0))).all(axis=1)
        i, j, both = i[able], j[able], both[able]

        # a quarter turn more of curvature is one less of the angle sum
        by_change = self._of_nodes(changed) @ holonomy.by_vertex
        angle = holonomy.angle / QUARTER_TURN - by_change[i] - by_change[j]
        missing = (quantise_holonomy(angle, holonomy.cost) - angle) * QUARTER_TURN
        distortion = STRETCH_PER_DISTORTION * ((missing @ holonomy.cost) * missing).sum(axis=1)
        one = self._log_squared(base + changed)
        mixed = 4 * changed @ self._variance[1] @ changed.T  # of the quadratic form
        squared = one[i] + one[j] - one[0] + 2 * mixed[i, j]
        best = np.argsort(distortion + squared / 2, kind="stable")[:TRIED_EXCHANGES]
        chosen = best[np.argmin(distortion[best] + self._log_stretches(base + both[best]))]
        turns = quantise_holonomy(angle[[chosen]], holonomy.cost)[0]
        return self._of_nodes(base + both[chosen]), turns

    def _in_slots(self, k: IntArray) -> IntArray:
        return np.append(0, k) if self._has_boundary else k

    def _of_nodes(self, k: IntArray) -> IntArray:
        return k[..., 1:] if self._has_boundary else k

    def _log_squared(self, k: IntArray) -> FloatArray:
        """The log of the squared stretch to first order, 4 times the variance of u: (n,) of (n, #slots)."""
        alone, square, mixed = self._variance
        return np.asarray(4 * (alone + (k @ square * k).sum(axis=1) + 2 * k @ mixed))

    @cached_property
    def _variance(self) -> tuple[float, FloatArray, FloatArray]:
        """The variance of u, a polynomial of the slots: constant, square, half of the linear part."""
        weight, bare, green = self._sampled
        bare, green = bare - weight @ bare, green - (green @ weight)[:, None]
        return float(weight @ bare**2), (green * weight) @ green.T, (green * weight) @ bare

    def _log_stretches(self, k: IntArray) -> FloatArray:
        """The log of the expected stretch, (n,) of (n, #slots); in single precision, which is faster."""
        weight, bare, green = (values.astype(np.float32) for values in self._sampled)
        limit = np.log(np.finfo(np.float32).max / 2) / 2  # the sums below do not overflow
        scaled = np.exp(2 * np.clip(bare + k.astype(np.float32) @ green, -limit, limit))
        return np.asarray(np.log((scaled @ weight) * ((1 / scaled) @ weight)) / 2)


def quantise_holonomy(angle: FloatArray, cost: FloatArray) -> FloatArray:
    """Whole quarter turns near holonomy angles, (n, #paths) quarter turns, for which the cost is low.

    They are rounded one after another, with regard to what is missing to those before (Babai 1986).
    """
    upper = np.linalg.cholesky(cost).T
    turns = np.zeros_like(angle)
    for i in range(len(cost) - 1, -1, -1):
        left = (angle - turns)[:, i + 1 :] @ upper[i, i + 1 :] / upper[i, i]
        turns[:, i] = np.round(angle[:, i] + left)
    return turns
