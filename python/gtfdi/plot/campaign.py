"""What the runs of a campaign say: the summary that ``gtfdi campaign`` writes."""

import json
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

from matplotlib.axes import Axes

from gtfdi.errors import DataError
from gtfdi.plot._argument import of_type
from gtfdi.plot._panel import panel
from gtfdi.plot.share import share_bars

Summary: TypeAlias = Mapping[str, Any] | str | PathLike[str]

#: The version of the summaries that are understood.
SCHEMA_VERSION = 1


def campaign_roc(summary: Summary, *, ax: Axes | None = None) -> Axes:
    """Detections over false alarms an hour, all limits multiplied by one factor, a line a fault.

    Points at which no run had a false alarm, or all had one, have no rate and are left out.

    Parameters
    ----------
    summary : dict, or path
        A campaign's ``summary.json``.
    ax : Axes, optional
        Where it is drawn; a new figure where left out.

    Returns
    -------
    Axes

    Raises
    ------
    TypeError, DataError
        It is not a campaign's summary.
    """
    content = _summary(summary)
    drawn = panel(ax)
    for index, fault in enumerate(content["faults"]):
        points = [
            (point["false_alarms_per_hour"], point["detected_by_fault"][index])
            for point in content["roc"]
            if point["false_alarms_per_hour"]
        ]
        points = [(rate, share) for rate, share in points if share["share"] is not None]
        rates = [rate for rate, _ in points]
        (line,) = drawn.plot(rates, [share["share"] for _, share in points], label=_name(fault))
        lows, highs = ([share[end] for _, share in points] for end in ("low", "high"))
        drawn.fill_between(rates, lows, highs, color=line.get_color(), alpha=0.15)
    drawn.set_xscale("log")
    drawn.set_ylim(-0.02, 1.02)
    drawn.set_xlabel("false alarms an hour")
    drawn.set_ylabel("share found")
    if content["faults"]:
        drawn.legend(loc="best")
    return drawn


def campaign_sizes(summary: Summary, *, ax: Axes | None = None) -> Axes:
    """The share of runs that were found over the fault's size, with 95 % intervals, a line a fault.

    Parameters
    ----------
    summary, ax
        As for :func:`campaign_roc`.

    Returns
    -------
    Axes

    Raises
    ------
    TypeError, DataError
        It is not a campaign's summary.
    """
    content = _summary(summary)
    drawn = panel(ax)
    units = []
    for fault in content["faults"]:
        bins = [own for own in fault["sizes"] if own["detected"]["share"] is not None]
        units.append(fault["unit"])
        shares, lows, highs = (
            [own["detected"][key] for own in bins] for key in ("share", "low", "high")
        )
        share_bars(drawn, [own["middle"] for own in bins], shares, lows, highs, _name(fault))
    unit = ", ".join(dict.fromkeys(units))
    drawn.set_xlabel(f"size ({unit})" if unit else "size")
    drawn.set_ylabel("share found")
    if units:
        drawn.legend(loc="best")
    return drawn


def _summary(summary: Summary) -> Mapping[str, Any]:
    of_type("summary", summary, Mapping, str, PathLike)
    if isinstance(summary, Mapping):
        content, where = summary, "summary"
    else:
        where = str(Path(summary))
        try:
            content = json.loads(Path(summary).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise DataError(f"{where}: expected a campaign's summary, found {error}") from error
    missing = [key for key in ("schema_version", "faults", "roc") if key not in content]
    if missing:
        raise DataError(f"{where}: expected the key {missing[0]!r} of a campaign's summary")
    if content["schema_version"] != SCHEMA_VERSION:
        found = content["schema_version"]
        raise DataError(f"{where}: expected schema_version {SCHEMA_VERSION}, found {found}")
    return content


def _name(fault: Mapping[str, Any]) -> str:
    return f"{fault['fault']}, {fault['waveform']}"
