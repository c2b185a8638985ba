"""A record's channels over time."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from gtfdi import Dataset
from gtfdi.plot._argument import chosen, of_type
from gtfdi.plot._panel import AxesLike, mark_onset, panels, quantity


def record(
    data: Dataset,
    channels: str | Sequence[str] | None = None,
    *,
    onset_s: float | None = None,
    axes: AxesLike = None,
) -> list[Axes]:
    """Channels of a record over time, a panel each; missing samples leave a gap.

    Parameters
    ----------
    data : Dataset
        The record.
    channels : str or list of str, optional
        Tags of inputs or outputs; all where left out, inputs first.
    onset_s : float, optional
        When a fault is known to begin, marked by a dotted line.
    axes : Axes or list of Axes, optional
        One a channel; new ones where left out.

    Returns
    -------
    list of Axes

    Raises
    ------
    TypeError
        ``data`` is no Dataset, or ``axes`` holds something else than Axes.
    OptionError
        A channel is not in the record.
    DimensionError
        As many axes as channels were expected.

    Examples
    --------
    >>> axes = gtfdi.plot.record(run.measured, ["M_f", "t3"])
    >>> [ax.get_ylabel() for ax in axes]
    ['M_f (kg/s)', 't3 (K)']
    """
    of_type("data", data, Dataset)
    tags = chosen("channels", channels, [*data.inputs, *data.outputs])
    columns: dict[str, tuple[str, NDArray[np.float64]]] = {}
    for names, units, values in (
        (data.inputs, data.input_units, data.u),
        (data.outputs, data.output_units, data.y),
    ):
        columns.update(zip(names, zip(units, values.T, strict=True), strict=True))
    drawn = panels(axes, len(tags))
    time_s = data.time_s
    for ax, tag in zip(drawn, tags, strict=True):
        unit, values = columns[tag]
        ax.plot(time_s, values, linewidth=0.8, label=tag)
        ax.set_ylabel(quantity(tag, unit))
        mark_onset(ax, onset_s)
    drawn[-1].set_xlabel("time (s)")
    return drawn
