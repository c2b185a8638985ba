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

    The circle and all poles are in view. Zeros may lie far away; the legend says how many do.

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
        poles = np.array([complex(pole["value"]) for pole in report["poles"]])
        view = _view(poles)
        zeros = [zero for channel in report["channels"] for zero in channel["zeros"]]
        # Normal errors of both parts: the square of their distance has a chi-square law of 2.
        scale = math.sqrt(-2.0 * math.log1p(-confidence))
        if zeros:
            values = np.array([complex(zero["value"]) for zero in zeros])
            away = int((np.maximum(np.abs(values.real), np.abs(values.imag)) > view).sum())
            _points(drawn, values, "o", f"zeros ({away} out of view)" if away else "zeros")
            _ellipses(drawn, zeros, scale)
        _points(drawn, poles, "x", "poles")
        _ellipses(drawn, report["poles"], scale)
    else:
        poles = np.asarray(_poles(model), dtype=complex)
        view = _view(poles)
        _points(drawn, poles, "x", "poles")
    drawn.set_xlim(-view, view)
    drawn.set_ylim(-view, view)
    drawn.set_aspect("equal", adjustable="box")
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


def _view(poles: NDArray[Any]) -> float:
    """Half the width of the map: the circle and all poles, with room around them."""
    return 1.15 * max(1.0, float(np.abs(poles).max(initial=0.0)))


def _points(ax: Axes, values: NDArray[Any], marker: str, label: str) -> None:
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
