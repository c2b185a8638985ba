"""Poles and zeros in the complex plane."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse
from numpy.typing import NDArray

from gtfdi import ArxFit, ArxModel, Observer, ObserverDesign, StateSpace
from gtfdi.plot._argument import between, of_type
from gtfdi.plot._panel import panel


def pole_map(
    model: StateSpace | ArxModel | ArxFit | Observer | ObserverDesign,
    *,
    confidence: float = 0.95,
    ax: Axes | None = None,
) -> Axes:
    """Poles (crosses) inside the unit circle; of an ArxFit also zeros (rings) and error ellipses.

    Parameters
    ----------
    model : StateSpace, ArxModel, ArxFit, Observer or ObserverDesign
        What has the poles.
    confidence : float, optional
        The probability with which a root lies in its ellipse, to first order.
    ax : Axes, optional
        Where it is drawn; a new figure where left out.

    Returns
    -------
    Axes

    Raises
    ------
    TypeError
        ``model`` is something else.
    OptionError
        ``confidence`` is not between 0 and 1.

    Examples
    --------
    >>> ax = gtfdi.plot.pole_map(model)
    >>> len(ax.lines[-1].get_xdata())
    8
    """
    of_type("model", model, StateSpace, ArxModel, ArxFit, Observer, ObserverDesign)
    confidence = between("confidence", confidence, 0.0, 1.0)
    drawn = panel(ax)
    angle = np.linspace(0.0, 2.0 * math.pi, 361)
    drawn.plot(np.cos(angle), np.sin(angle), color="0.6", linewidth=0.8, label="unit circle")
    if isinstance(model, ArxFit):
        report = model.pole_zero()
        zeros = [zero for channel in report["channels"] for zero in channel["zeros"]]
        # Normal errors of both parts: the square of their distance has a chi-square law of 2.
        scale = math.sqrt(-2.0 * math.log1p(-confidence))
        if zeros:
            _points(drawn, (zero["value"] for zero in zeros), "o", "zeros")
            _ellipses(drawn, zeros, scale)
        _points(drawn, (pole["value"] for pole in report["poles"]), "x", "poles")
        _ellipses(drawn, report["poles"], scale)
    else:
        _points(drawn, _poles(model), "x", "poles")
    drawn.set_aspect("equal", adjustable="datalim")
    drawn.set_xlabel("real part")
    drawn.set_ylabel("imaginary part")
    drawn.legend(loc="best")
    return drawn


def _poles(model: StateSpace | ArxModel | Observer | ObserverDesign) -> NDArray[Any]:
    if isinstance(model, StateSpace):
        return model.poles()
    if isinstance(model, ArxModel):
        return model.state_space().poles()
    return model.poles


def _points(ax: Axes, roots: Iterable[complex], marker: str, label: str) -> None:
    values = np.array([complex(root) for root in roots])
    colour = "C0" if marker == "x" else "C1"
    ax.plot(
        values.real,
        values.imag,
        marker,
        color=colour,
        fillstyle="none",
        linestyle="none",
        label=label,
    )


def _ellipses(ax: Axes, roots: Iterable[Mapping[str, Any]], scale: float) -> None:
    """An ellipse for every root that has a covariance of its real and imaginary part."""
    for root in roots:
        if root["covariance"] is None:
            continue
        variances, axes = np.linalg.eigh(np.asarray(root["covariance"]))
        widths = 2.0 * scale * np.sqrt(np.maximum(variances, 0.0))
        ax.add_patch(
            Ellipse(
                (root["value"].real, root["value"].imag),
                float(widths[1]),
                float(widths[0]),
                angle=math.degrees(math.atan2(axes[1, 1], axes[0, 1])),
                facecolor="none",
                edgecolor="0.4",
                linewidth=0.8,
            )
        )
