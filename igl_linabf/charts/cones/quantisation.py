"""Choose cone curvatures that are multiples of a quarter turn, with little stretch.

The turning along closed paths around holes and along handles also has to be a whole number of quarter turns.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...angles import HolonomyAngles
from ..cut_graphs import MAX_LOG_SCALE
from .constants import MAX_QUARTERS, QUARTER_TURN
from .scale import ConeScale

STRETCH_SAMPLES = 4_000  # number of sample nodes for estimates of the stretch
MAX_EXCHANGES = 500  # maximum number of exchanges of a quarter turn between two cones
EXCHANGE_GAIN = 0.999  # an exchange is made only if it multiplies the squared stretch by less than this
PAIRED_EXCHANGES = 160  # number of the best single exchanges that are combined in pairs
MAX_EVALUATED_PAIRS = 150  # number of pairs evaluated in full, after a quadratic estimate ranks all pairs
DISTORTION_PER_LOG_STRETCH = 30.0  # weight of the angle distortion F/3nt, relative to the log stretch


@dataclass(frozen=True, eq=False)
class QuantisedCurvatures:
    """Curvatures of cones that are multiples of a quarter turn, found by exchanges.

    An exchange adds a quarter turn to the curvature of one cone and subtracts it from another. Therefore the
    sum of all curvatures does not change, as Gauss-Bonnet requires. If there is a boundary, it takes part in
    exchanges, and its curvature is unbounded. Curvatures are stored in *slots*: one slot for the boundary, if
    there is one, followed by one slot for each cone.

    Attributes
    ----------
    scale : ConeScale
        The scale with all cones.
    least : (#C,) int64
        Lower bound of the curvature at each of `scale.nodes`; the upper bound is `MAX_QUARTERS`.
    """

    scale: ConeScale
    least: IntArray

    @property
    def _has_boundary(self) -> bool:
        """Return True if the surface has a boundary."""
        return self.scale.first < 0

    @cached_property
    def _slot_bounds(self) -> tuple[FloatArray | IntArray, FloatArray | IntArray]:
        """Lower and upper bounds of the quarter turns of each slot; infinite for the boundary."""
        upper = np.full(len(self.least), MAX_QUARTERS)
        if not self._has_boundary:
            return self.least, upper
        return np.append(-np.inf, self.least), np.append(np.inf, upper)

    @cached_property
    def _sampled_log_scales(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Area weights, log scale without cones, and log scale per quarter turn of each slot, at samples."""
        scale = self.scale
        sample = np.arange(0, scale.piece.graph.n, -(-scale.piece.graph.n // STRETCH_SAMPLES))
        weight = scale.piece.area[sample] / scale.piece.area[sample].sum()
        green = np.concatenate((np.zeros((1, len(sample))), scale.green[:, sample])) * QUARTER_TURN
        return weight, scale.bare[sample], green

    @cached_property
    def quarters_for_stretch(self) -> IntArray:
        """Cone curvatures in quarter turns: rounded, then exchanged between cones to reduce the stretch."""
        exact, least = self.scale.cone_curvatures / QUARTER_TURN, self.least
        k = np.clip(np.round(exact).astype(np.int64), least, MAX_QUARTERS)
        if not self._has_boundary:
            # correct the sum by changing the cones with the largest rounding errors
            while beyond := int(k.sum()) - round(float(exact.sum())):
                sign = -1 if beyond > 0 else 1
                able = (k > least) if beyond > 0 else (k < MAX_QUARTERS)
                able |= not able.any()  # if all cones are at their bounds, let one exceed its bound
                k[np.argmax(np.where(able, sign * (exact - k), -np.inf))] += sign
        k, (lower, upper) = self._to_slots(k), self._slot_bounds
        weight, bare, green = self._sampled_log_scales
        grown, shrunk = np.exp(2 * green), np.exp(-2 * green)
        for _ in range(MAX_EXCHANGES):
            u = np.clip(bare + k @ green, -MAX_LOG_SCALE, MAX_LOG_SCALE)
            # moving a quarter turn from slot j to slot i changes the log scale u by green_i - green_j
            squared = (grown * (weight * np.exp(2 * u))) @ shrunk.T
            squared *= (shrunk * (weight * np.exp(-2 * u))) @ grown.T
            allowed = (k < upper)[:, None] & (k > lower)
            i, j = np.unravel_index(np.argmin(np.where(allowed, squared, np.inf)), squared.shape)
            if i == j or not squared[i, j] < EXCHANGE_GAIN * squared[i, i]:
                break
            k[i], k[j] = k[i] + 1, k[j] - 1
        return self._to_nodes(k)

    def fit_path_turns(self, holonomy: HolonomyAngles) -> tuple[IntArray, FloatArray]:
        """Choose curvatures with which closed paths turn by nearly whole quarter turns.

        At most two exchanges are made, starting from `quarters_for_stretch`. They minimise the log stretch
        plus the cost of rounding the turning of the paths. `holonomy` is measured with the curvatures
        `quarters_for_stretch`, and has a row for each cone.

        Returns
        -------
        k : (#C,) int64
            Curvature of each cone, in quarter turns.
        quarters : (#paths,) float64
            The turning to prescribe for each path, in quarter turns; whole numbers.
        """
        base, (lower, upper) = self._to_slots(self.quarters_for_stretch), self._slot_bounds
        unit = np.eye(len(base), dtype=np.int64)
        single = (unit[:, None] - unit[None]).reshape(-1, len(base))
        single = single[(single != 0).any(axis=1)]
        likely = np.argsort(self._approximate_log_squared_stretch(base + single), kind="stable")[
            :PAIRED_EXCHANGES
        ]
        changed = np.concatenate((0 * base[None], single[likely]))
        i, j = np.tril_indices(len(changed))  # pairs of exchanges; exchange 0 changes nothing
        least, most = (np.clip(bound - base, -4, 4).astype(np.int8) for bound in (lower, upper))
        both = changed.astype(np.int8)[i] + changed.astype(np.int8)[j]
        able = ((both >= np.minimum(least, 0)) & (both <= np.maximum(most, 0))).all(axis=1)
        i, j, both = i[able], j[able], both[able]

        # the minus signs: more curvature at a cone means a smaller angle sum
        by_change = self._to_nodes(changed) @ holonomy.by_vertex
        path_turns = holonomy.angle / QUARTER_TURN - by_change[i] - by_change[j]
        missing = DISTORTION_PER_LOG_STRETCH * _estimate_distortion(
            path_turns, quantise_holonomy(path_turns, holonomy.cost), holonomy.cost
        )
        one = self._approximate_log_squared_stretch(base + changed)
        mixed = 4 * changed @ self._variance_form[1] @ changed.T  # mixed term: interaction of two exchanges
        squared = one[i] + one[j] - one[0] + 2 * mixed[i, j]
        best = np.argsort(missing + squared / 2, kind="stable")[:MAX_EVALUATED_PAIRS]
        chosen = best[np.argmin(missing[best] + self._compute_log_stretch(base + both[best]))]
        return self._to_nodes(base + both[chosen]), quantise_holonomy(path_turns[[chosen]], holonomy.cost)[0]

    def _to_slots(self, k: IntArray) -> IntArray:
        """Convert cone curvatures to slots: add a slot for the boundary, if there is one."""
        return np.append(0, k) if self._has_boundary else k

    def _to_nodes(self, k: IntArray) -> IntArray:
        """Convert slots to cone curvatures: remove the slot of the boundary, if there is one."""
        return k[..., 1:] if self._has_boundary else k

    def _approximate_log_squared_stretch(self, k: IntArray) -> FloatArray:
        """Return the log of the squared stretch to second order: four times the variance of the log scale."""
        alone, square, mixed = self._variance_form
        return np.asarray(4 * (alone + (k @ square * k).sum(axis=1) + 2 * k @ mixed))

    @cached_property
    def _variance_form(self) -> tuple[float, FloatArray, FloatArray]:
        """Variance of the log scale as a quadratic form: constant term, matrix, and half the linear term."""
        weight, bare, green = self._sampled_log_scales
        bare, green = bare - weight @ bare, green - (green @ weight)[:, None]
        return float(weight @ bare**2), (green * weight) @ green.T, (green * weight) @ bare

    def _compute_log_stretch(self, k: IntArray) -> FloatArray:
        """Return the logarithm of the expected stretch, (n,), for curvatures (n, #slots)."""
        # single precision, because it computes exponentials faster
        weight, bare, green = (part.astype(np.float32) for part in self._sampled_log_scales)
        most = np.log(np.finfo(np.float32).max) / 2  # larger exponents would overflow when squared
        scaled = np.exp(2 * np.clip(bare + k.astype(np.float32) @ green, -most, most))
        return np.asarray(np.log((scaled @ weight) * ((1 / scaled) @ weight)) / 2)


def quantise_holonomy(path_turns: FloatArray, cost: FloatArray) -> FloatArray:
    """Round the turning of paths, (n, #paths), to whole quarter turns with little distortion.

    The paths are rounded one after another. Each is corrected beforehand for the rounding errors of the
    previous paths (Babai 1986).
    """
    upper = np.linalg.cholesky(cost).T
    quarters = np.zeros_like(path_turns)
    for i in range(len(cost) - 1, -1, -1):
        left = (path_turns - quarters)[:, i + 1 :] @ upper[i, i + 1 :] / upper[i, i]
        quarters[:, i] = np.round(path_turns[:, i] + left)
    return quarters


def _estimate_distortion(path_turns: FloatArray, quarters: FloatArray, cost: FloatArray) -> FloatArray:
    """Return the increase of the mean angle distortion F/3nt, (n,), if `quarters` replace `path_turns`."""
    missing = (quarters - path_turns) * QUARTER_TURN
    return np.asarray(((missing @ cost) * missing).sum(axis=1))
