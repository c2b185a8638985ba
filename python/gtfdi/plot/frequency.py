"""Frequency responses."""

import numpy as np
from matplotlib.axes import Axes

from gtfdi import FrequencyResponse
from gtfdi.plot._argument import between, chosen, of_type
from gtfdi.plot._panel import AxesLike, panels


def bode(
    response: FrequencyResponse,
    output: str | None = None,
    input: str | None = None,  # noqa: A002
    *,
    confidence: float = 0.95,
    axes: AxesLike = None,
) -> list[Axes]:
    """Magnitude and phase over the frequency, with the bands between which they are.

    The frequency 0 has no place on a logarithmic axis and is left out.

    Parameters
    ----------
    response : FrequencyResponse
        What ``ArxFit.frequency_response`` gave.
    output, input : str, optional
        One channel; all where left out, a line each.
    confidence : float, optional
        The probability of the bands, to first order.
    axes : list of Axes, optional
        Two: of the magnitude and of the phase. New ones where left out.

    Returns
    -------
    list of Axes

    Raises
    ------
    TypeError
        ``response`` is no FrequencyResponse.
    OptionError
        There is no such channel, or ``confidence`` is not between 0 and 1.

    Examples
    --------
    >>> fit = gtfdi.ArxFit.from_record(model, u, y)
    >>> axes = gtfdi.plot.bode(fit.frequency_response([0.01, 0.1, 1.0]), input="M_f")
    >>> axes[0].lines[0].get_label(), axes[1].get_ylabel()
    ('q_c from M_f', 'phase (deg)')
    """
    of_type("response", response, FrequencyResponse)
    confidence = between("confidence", confidence, 0.0, 1.0)
    outputs = chosen("output", output, response.outputs)
    inputs = chosen("input", input, response.inputs)
    magnitude_ax, phase_ax = panels(axes, 2)
    rows = response.frequency_hz > 0.0
    frequency_hz = response.frequency_hz[rows]
    magnitude = np.abs(response.response)
    phase = np.degrees(np.unwrap(np.angle(response.response), axis=0))
    bands = response.magnitude_band(confidence)
    # The half width of the band goes with the unwrapped phase.
    half = np.degrees(response.phase_band_rad(confidence))
    half = 0.5 * (half[..., 1] - half[..., 0])
    for tag in outputs:
        for source in inputs:
            place = (rows, response.outputs.index(tag), response.inputs.index(source))
            (line,) = magnitude_ax.loglog(
                frequency_hz, magnitude[place], label=f"{tag} from {source}"
            )
            colour = line.get_color()
            low, high = bands[place].T
            magnitude_ax.fill_between(frequency_hz, low, high, color=colour, alpha=0.2)
            phase_ax.semilogx(frequency_hz, phase[place], color=colour)
            low, high = phase[place] - half[place], phase[place] + half[place]
            phase_ax.fill_between(frequency_hz, low, high, color=colour, alpha=0.2)
    magnitude_ax.set_ylabel("magnitude")
    magnitude_ax.legend(loc="best")
    phase_ax.set_ylabel("phase (deg)")
    phase_ax.set_xlabel("frequency (Hz)")
    return [magnitude_ax, phase_ax]
