"""How often something was found: detections against false alarms, and against the size."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from gtfdi.errors import DataError, DimensionError
from gtfdi.plot._panel import panel

#: The normal deviate with 2.5 % above it.
DEVIATE = 1.959963984540054


def roc(healthy_peaks: ArrayLike, faulty_peaks: ArrayLike, *, ax: Axes | None = None) -> Axes:
    """The share of faulty runs with an alarm over that of healthy runs with one, for all limits.

    Parameters
    ----------
    healthy_peaks : array_like, shape (runs,)
        The largest value of a statistic, or of its ratio to its limit, in each healthy stretch; all
        stretches as long as each other.
    faulty_peaks : array_like, shape (runs,)
        The same in each stretch with a fault.
    ax : Axes, optional
        Where it is drawn; a new figure where left out.

    Returns
    -------
    Axes

    Raises
    ------
    DataError
        No runs, or a peak that is no number.

    Examples
    --------
    >>> ax = gtfdi.plot.roc([0.2, 0.4, 0.6], [0.5, 0.9, 1.2])
    >>> ax.get_xlabel()
    'healthy runs with an alarm'
    """
    healthy, faulty = _peaks("healthy_peaks", healthy_peaks), _peaks("faulty_peaks", faulty_peaks)
    limits = np.unique(np.concatenate([healthy, faulty]))[::-1]
    # An alarm is at the limit or above; before the first limit nothing alarms.
    false = [0.0, *(np.mean(healthy >= limit) for limit in limits)]
    found = [0.0, *(np.mean(faulty >= limit) for limit in limits)]
    drawn = panel(ax)
    drawn.step(false, found, where="post", label=f"{len(healthy)} healthy, {len(faulty)} faulty")
    drawn.set_xlabel("healthy runs with an alarm")
    drawn.set_ylabel("faulty runs with an alarm")
    drawn.set_xlim(0.0, 1.0)
    drawn.set_ylim(0.0, 1.02)
    drawn.legend(loc="lower right")
    return drawn


def share_of_sizes(
    sizes: ArrayLike,
    found: ArrayLike,
    *,
    bins: int = 8,
    unit: str = "",
    ax: Axes | None = None,
) -> Axes:
    """The share of runs whose fault was found over its size, with 95 % intervals (Wilson).

    Parameters
    ----------
    sizes : array_like, shape (runs,)
        The size of the fault in each run, positive.
    found : array_like of bool, shape (runs,)
        Whether it was found.
    bins : int, optional
        Bins of the logarithm of the size; empty ones are left out.
    unit : str, optional
        The size's unit.
    ax : Axes, optional
        Where it is drawn; a new figure where left out.

    Returns
    -------
    Axes

    Raises
    ------
    DimensionError
        As many sizes as runs were expected.
    DataError
        No runs, or a size that is not positive.

    Examples
    --------
    >>> ax = gtfdi.plot.share_of_sizes([1.0, 2.0, 4.0], [False, True, True], bins=2, unit="%")
    >>> ax.get_xlabel()
    'size (%)'
    """
    values = _peaks("sizes", sizes)
    flags = np.asarray(found, dtype=bool)
    if flags.shape != values.shape:
        error = DimensionError(f"found: expected {len(values)} runs, found {flags.size}")
        error.what, error.expected, error.found = "found", len(values), flags.size
        raise error
    if not (values > 0.0).all():
        raise DataError(f"sizes: expected positive numbers, found {values.min()}")
    edges = np.geomspace(values.min(), values.max(), bins + 1)
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, bins - 1)
    middles, shares, lows, highs = [], [], [], []
    for index in range(bins):
        own = flags[place == index]
        if own.size:
            low, high = wilson(int(own.sum()), own.size)
            middles.append(math.sqrt(edges[index] * edges[index + 1]))
            shares.append(own.mean())
            lows.append(low)
            highs.append(high)
    drawn = panel(ax)
    share_bars(drawn, middles, shares, lows, highs, "found")
    drawn.set_xlabel(f"size ({unit})" if unit else "size")
    drawn.set_ylabel("share found")
    return drawn


def share_bars(
    ax: Axes,
    sizes: Sequence[float],
    shares: Sequence[float],
    lows: Sequence[float],
    highs: Sequence[float],
    label: str,
) -> None:
    """Shares with their intervals over a logarithmic size."""
    shares_, below, above = np.array(shares), np.array(lows), np.array(highs)
    # Rounding may put an end of an interval a hair inside.
    errors = np.maximum([shares_ - below, above - shares_], 0.0)
    ax.errorbar(sizes, shares_, yerr=errors, fmt="o-", markersize=4, capsize=2, label=label)
    ax.set_xscale("log")
    ax.set_ylim(-0.02, 1.02)


def wilson(count: int, of: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    share, squared = count / of, DEVIATE * DEVIATE
    middle = (share + squared / (2.0 * of)) / (1.0 + squared / of)
    half = DEVIATE * math.sqrt(share * (1.0 - share) / of + squared / (4.0 * of * of))
    half /= 1.0 + squared / of
    return max(middle - half, 0.0), min(middle + half, 1.0)


def _peaks(name: str, values: ArrayLike) -> NDArray[Any]:
    array = np.asarray(values, dtype=float)
    if array.ndim != 1 or array.size == 0:
        raise DataError(f"{name}: expected a number a run, found shape {array.shape}")
    if np.isnan(array).any():
        raise DataError(f"{name}: expected numbers, found NaN in run {int(np.isnan(array).argmax())}")
    return array
