"""What a bank says of a record: residuals, statistics, limits and alarms over time."""

from collections.abc import Mapping
from typing import Any

from matplotlib.axes import Axes

from gtfdi import Bank, Detection
from gtfdi.errors import OptionError
from gtfdi.plot._argument import of_type
from gtfdi.plot._panel import LIMIT_COLOUR, AxesLike, mark_onset, panels, quantity


def residuals(
    detection: Detection,
    bank: Bank | None = None,
    *,
    onset_s: float | None = None,
    axes: AxesLike = None,
) -> list[Axes]:
    """Residuals over time, a panel an output, with the limits of tests that are on them as they are.

    Alarms of a test that is named after the output are vertical lines, where they came up, and a
    shade for as long as they lasted. Limits of tests on whitened residuals are not in the
    residual's unit: :func:`statistics` draws those.

    Parameters
    ----------
    detection : Detection
        What ``Bank.detect`` gave.
    bank : Bank, optional
        The bank that gave it, for the limits and the units.
    onset_s : float, optional
        When a fault is known to begin, marked by a dotted line.
    axes : Axes or list of Axes, optional
        One an output; new ones where left out.

    Returns
    -------
    list of Axes

    Raises
    ------
    TypeError
        ``detection`` is no Detection, ``bank`` no Bank.
    OptionError
        The bank has other tests than the detection.

    Examples
    --------
    >>> (ax,) = gtfdi.plot.residuals(bank.detect(run.measured), bank)
    >>> [line.get_label() for line in ax.lines]
    ['q_c', 'limit', '_limit below']
    """
    of_type("detection", detection, Detection)
    tests = _tests(detection, bank)
    drawn = panels(axes, len(detection.outputs))
    alarms = detection.alarms
    units = {} if bank is None else dict(zip(bank.outputs, bank.output_units, strict=True))
    for ax, tag, values in zip(drawn, detection.outputs, detection.residuals.T, strict=True):
        ax.plot(detection.time_s, values, linewidth=0.8, label=tag)
        test = tests.get(tag)
        if test is not None and _is_of_the_residual(test):
            ax.axhline(test["limit"], color=LIMIT_COLOUR, linestyle="--", label="limit")
            ax.axhline(-test["limit"], color=LIMIT_COLOUR, linestyle="--", label="_limit below")
        _mark_alarms(ax, tag, alarms, float(detection.time_s[-1]))
        mark_onset(ax, onset_s)
        ax.set_ylabel(quantity(f"residual {tag}", units.get(tag, "")))
    drawn[-1].set_xlabel("time (s)")
    return drawn


def statistics(
    detection: Detection,
    bank: Bank | None = None,
    *,
    onset_s: float | None = None,
    axes: AxesLike = None,
) -> list[Axes]:
    """Statistics over time, a panel a test, with their limits and alarms.

    Parameters
    ----------
    detection, bank, onset_s
        As for :func:`residuals`.
    axes : Axes or list of Axes, optional
        One a test; new ones where left out.

    Returns
    -------
    list of Axes

    Raises
    ------
    TypeError, OptionError
        As for :func:`residuals`.

    Examples
    --------
    >>> (ax,) = gtfdi.plot.statistics(bank.detect(run.measured), bank)
    >>> ax.get_ylabel(), float(ax.lines[1].get_ydata()[0]) == bank.detectors[0]["limit"]
    ('modulus of q_c', True)
    """
    of_type("detection", detection, Detection)
    tests = _tests(detection, bank)
    drawn = panels(axes, len(detection.tests))
    alarms = detection.alarms
    for ax, name, values in zip(drawn, detection.tests, detection.statistics.T, strict=True):
        ax.plot(detection.time_s, values, linewidth=0.8, label=name)
        label = f"statistic of {name}"
        if name in tests:
            test = tests[name]
            ax.axhline(test["limit"], color=LIMIT_COLOUR, linestyle="--", label="limit")
            label = f"{test['statistic']['kind'].replace('_', ' ')} of {name}"
        _mark_alarms(ax, name, alarms, float(detection.time_s[-1]))
        mark_onset(ax, onset_s)
        ax.set_ylabel(label)
    drawn[-1].set_xlabel("time (s)")
    return drawn


def _tests(detection: Detection, bank: Bank | None) -> dict[str, Mapping[str, Any]]:
    """The bank's tests by name."""
    if bank is None:
        return {}
    of_type("bank", bank, Bank)
    if bank.tests != detection.tests:
        expected, found = ", ".join(detection.tests), ", ".join(bank.tests)
        raise OptionError(f"bank: expected one with the tests {expected}, found {found}")
    return {test["output"]: test for test in bank.detectors}


def _is_of_the_residual(test: Mapping[str, Any]) -> bool:
    """Whether a limit is one on the residual itself, in its unit."""
    return (
        test["statistic"]["kind"] == "modulus"
        and test["whitening_order"] is None
        and len(test["outputs"]) == 1
    )


def _mark_alarms(ax: Axes, tag: str, alarms: list[Any], last_s: float) -> None:
    label = "alarm"
    for alarm in alarms:
        if alarm["tag"] == tag:
            end_s = last_s if alarm["end_s"] is None else alarm["end_s"]
            ax.axvline(alarm["time_s"], color=LIMIT_COLOUR, linewidth=1.0, label=label)
            ax.axvspan(alarm["time_s"], end_s, color=LIMIT_COLOUR, alpha=0.12, linewidth=0.0)
            label = "_alarm"
