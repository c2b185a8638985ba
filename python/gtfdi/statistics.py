"""Decisions on one residual with memory, sample by sample or many samples at once.

Residuals are whitened and in units of their healthy standard deviation. ``step`` takes one and
returns ``(value, alarm, missing)``, ``process`` takes many and returns the value after each. An
alarm is up while the value is above the threshold; nothing resets by itself. States are values:
they compare, and a pickle goes on as if nothing had happened.

=========================================  ==================================
looks for                                  statistic
=========================================  ==================================
a step of about known size                 `Cusum`, `ShiryaevRoberts`
the same, on many streams                  `CusumFleet`
a step or ramp, with its onset and size    `Glr`
a shift, by simple means                   `MovingAverage`, `RunSum`
which of two means it is, once             `Sprt`
more energy                                `WindowedChiSquare`, `GrowingChiSquare`
more or less noise                         `WindowedVariance`, `GrowingVariance`
a model that no longer fits                `Whiteness`
a residual beside moving inputs            `AdaptiveThreshold`
=========================================  ==================================
"""

from gtfdi._gtfdi import (
    AdaptiveThreshold,
    Cusum,
    CusumFleet,
    Glr,
    GrowingChiSquare,
    GrowingVariance,
    MovingAverage,
    RunSum,
    ShiryaevRoberts,
    Sprt,
    Whiteness,
    WindowedChiSquare,
    WindowedVariance,
)

__all__ = [
    "AdaptiveThreshold",
    "Cusum",
    "CusumFleet",
    "Glr",
    "GrowingChiSquare",
    "GrowingVariance",
    "MovingAverage",
    "RunSum",
    "ShiryaevRoberts",
    "Sprt",
    "Whiteness",
    "WindowedChiSquare",
    "WindowedVariance",
]
