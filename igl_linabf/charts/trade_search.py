"""Search for the `trade` at which an atlas meets bounds on its energy and on its number of charts."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np

from .._runtime import progress_part
from ..errors import FallbackWarning, stack_level
from .atlas import ISOMETRY_ENERGY, Atlas, list_unmet_bounds, mean_energy
from .options import ChartOptions

MIN_TRADE, MAX_TRADE = 0.1, 1_000.0  # range of `trade` that the search may try
BRACKETING_FACTOR = 4.0  # ratio of consecutive values of `trade` until the bound is bracketed
SUFFICIENT_RATIO = 1.1  # stop once the bracketing values of `trade` have this ratio
MAX_TRIALS = 12


def search_trade(make: Callable[[float], Atlas], asked: ChartOptions) -> Atlas:
    """Return the best atlas of a search over `trade` for the bounds in the options.

    The search starts at the `trade` of the options and bisects on a logarithmic scale. With `max_dirichlet`,
    the search looks for the smallest `trade` that meets this bound, and the best atlas has the shortest seams
    among the atlases that meet all bounds. With `max_charts` alone, the best atlas has the largest `trade`,
    at most the initial value, that meets the bound. If no atlas meets all bounds, the best atlas exceeds them
    least.

    Parameters
    ----------
    make : callable
        Returns an atlas for a value of `trade`, with the bounds in its report. Only the warnings of the best
        atlas are issued.
    asked : ChartOptions
    """
    low, high, trade = 0.0, np.inf, asked.trade
    best: Atlas | None = None
    issued: list[warnings.WarningMessage] = []
    for trial in range(MAX_TRIALS):
        end = (trial + 1) / MAX_TRIALS
        with progress_part("search", end), warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            atlas = make(trade)
        if best is None or _make_ranking_key(atlas) < _make_ranking_key(best):
            best, dropped, issued = atlas, issued, [*caught]
        else:
            dropped = caught
        issued += [warning for warning in dropped if not issubclass(warning.category, FallbackWarning)]
        unmet = list_unmet_bounds(atlas)
        if asked.max_dirichlet is not None:
            longer = not _compute_energy_excess(atlas) <= 1
        elif unmet or trial:
            longer = not unmet
        else:
            break
        low, high = (trade, high) if longer else (low, trade)
        following = _choose_next_trade(low, high)
        if following is None:
            break
        trade = following
    assert best is not None
    for warning in issued:
        warnings.warn(warning.message, warning.category, stacklevel=stack_level())
    return best


def _choose_next_trade(low: float, high: float) -> float | None:
    """Return the next `trade` to try above `low` and below `high`; None if the search is complete.

    `low` is 0 and `high` is infinite until trials have found these limits.
    """
    if high == np.inf:
        return None if low >= MAX_TRADE else min(max(low * BRACKETING_FACTOR, MIN_TRADE), MAX_TRADE)
    if low == 0:
        return None if high <= MIN_TRADE else max(high / BRACKETING_FACTOR, MIN_TRADE)
    return None if high / low <= SUFFICIENT_RATIO else float(np.sqrt(low * high))


def _compute_energy_excess(atlas: Atlas) -> float:
    """Return (energy - 4) divided by its largest allowed value; infinite if the energy is not finite."""
    largest = atlas.report.bounds.max_dirichlet
    if largest is None:
        return 0.0
    excess = (mean_energy(atlas) - ISOMETRY_ENERGY) / (largest - ISOMETRY_ENERGY)
    return excess if np.isfinite(excess) else np.inf


def _make_ranking_key(atlas: Atlas) -> tuple[bool, float, float]:
    """Return a key for sorting atlases; the best atlas has the smallest key."""
    bounds = atlas.report.bounds
    charts = 0.0 if bounds.max_charts is None else len(atlas.charts) / bounds.max_charts
    excess = max(_compute_energy_excess(atlas), 1.0) + max(charts, 1.0)
    return (
        not atlas.good,
        excess,
        -(bounds.trade or 0) if bounds.max_dirichlet is None else atlas.seam_length,
    )
