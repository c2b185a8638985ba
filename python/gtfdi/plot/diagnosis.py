"""What an isolator says: the evidence over time, and which fault."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from gtfdi import Isolation
from gtfdi.errors import DataError
from gtfdi.plot._argument import of_type
from gtfdi.plot._panel import LIMIT_COLOUR, mark_onset, panel


def peaks(
    isolation: Isolation, *, onset_s: float | None = None, ax: Axes | None = None
) -> Axes:
    """The largest ratio of a statistic to its limit in each second, with the alarms.

    Parameters
    ----------
    isolation : Isolation
        What ``Isolator.detect`` gave.
    onset_s : float, optional
        When a fault is known to begin, in seconds of the record, marked by a dotted line.
    ax : Axes, optional
        Where it is drawn; a new figure where left out.

    Returns
    -------
    Axes

    Raises
    ------
    TypeError
        ``isolation`` is no Isolation.

    Examples
    --------
    >>> ax = gtfdi.plot.peaks(isolator.detect(record))
    >>> ax.get_ylabel()
    'largest statistic over its limit'
    """
    of_type("isolation", isolation, Isolation)
    drawn = panel(ax)
    values = isolation.peaks
    drawn.plot(np.arange(len(values)), values, linewidth=0.8, label="peak of a second")
    drawn.axhline(1.0, color=LIMIT_COLOUR, linestyle="--", label="limit")
    for alarm in isolation.alarms:
        drawn.axvline(alarm["time_s"], color=LIMIT_COLOUR, linewidth=1.0)
    mark_onset(drawn, onset_s)
    drawn.set_xlabel("time (s)")
    drawn.set_ylabel("largest statistic over its limit")
    return drawn


def fault_scores(diagnosis: Mapping[str, Any], *, ax: Axes | None = None) -> Axes:
    """The probability of each fault, of none of them, and of a pair where there is one.

    Beside each fault stands its size with the interval of it.

    Parameters
    ----------
    diagnosis : dict
        One of ``Isolation.alarms``, or ``IsolationMonitor.diagnosis``.
    ax : Axes, optional
        Where it is drawn; a new figure where left out.

    Returns
    -------
    Axes

    Raises
    ------
    TypeError, DataError
        It is not a diagnosis.

    Examples
    --------
    >>> ax = gtfdi.plot.fault_scores(alarm)
    >>> [label.get_text() for label in ax.get_yticklabels()]
    ['sensor a', 'leak', 'valve', 'none of these']
    """
    of_type("diagnosis", diagnosis, Mapping)
    for key in ("hypotheses", "none_of_these"):
        if key not in diagnosis:
            raise DataError(f"diagnosis: expected the key {key!r}, found {', '.join(diagnosis)}")
    names, shares, notes = [], [], []
    for own in diagnosis["hypotheses"]:
        low, high = own["magnitude_interval"]
        names.append(own["fault"])
        shares.append(own["probability"])
        notes.append(f"{own['magnitude']:.3g} ({low:.3g} to {high:.3g}) {own['unit']}".rstrip())
    if diagnosis.get("pair"):
        pair = diagnosis["pair"]
        names.append(" and ".join(pair["faults"]))
        shares.append(pair["probability"])
        notes.append("")
    names.append("none of these")
    shares.append(diagnosis["none_of_these"])
    notes.append("")
    drawn = panel(ax)
    places = np.arange(len(names))
    bars = drawn.barh(places, shares)
    drawn.bar_label(bars, labels=notes, padding=3, fontsize="small")
    drawn.set_yticks(places, names)
    drawn.invert_yaxis()
    # Room for the sizes beside the bars.
    drawn.set_xlim(0.0, 1.5)
    drawn.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0])
    drawn.set_xlabel("probability")
    return drawn
