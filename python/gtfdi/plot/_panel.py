"""The axes that plots are drawn into."""

from collections.abc import Sequence
from typing import TypeAlias

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from gtfdi.errors import DimensionError

AxesLike: TypeAlias = Axes | Sequence[Axes] | None

#: Height in inches of one of several panels above each other, and of a figure with one.
PANEL_HEIGHT = 1.9
SINGLE_HEIGHT = 3.6
WIDTH = 7.0
#: What limits and alarms are drawn in, and onsets that are known.
LIMIT_COLOUR = "C3"
ONSET_COLOUR = "0.3"


def panels(axes: AxesLike, count: int) -> list[Axes]:
    """The axes that were given, or as many new ones above each other with one axis of time."""
    if axes is None:
        height = max(SINGLE_HEIGHT, PANEL_HEIGHT * count)
        _, grid = plt.subplots(
            count, 1, sharex=True, squeeze=False, figsize=(WIDTH, height), layout="constrained"
        )
        return list(grid[:, 0])
    given = [axes] if isinstance(axes, Axes) else list(axes)
    for each in given:
        if not isinstance(each, Axes):
            raise TypeError(f"axes: expected matplotlib Axes, found {type(each).__name__}")
    if len(given) != count:
        error = DimensionError(f"axes: expected {count}, one a panel, found {len(given)}")
        error.what, error.expected, error.found = "axes", count, len(given)
        raise error
    return given


def panel(ax: Axes | None) -> Axes:
    """The one axis that was given, or that of a new figure."""
    if ax is None:
        _, new = plt.subplots(figsize=(WIDTH, SINGLE_HEIGHT), layout="constrained")
        return new
    if not isinstance(ax, Axes):
        raise TypeError(f"ax: expected matplotlib Axes, found {type(ax).__name__}")
    return ax


def quantity(tag: str, unit: str) -> str:
    """The label of an axis."""
    return f"{tag} ({unit})" if unit else tag


def mark_onset(ax: Axes, onset_s: float | None) -> None:
    """A line at the time at which a fault is known to begin."""
    if onset_s is not None:
        ax.axvline(onset_s, color=ONSET_COLOUR, linestyle=":", label="onset")
