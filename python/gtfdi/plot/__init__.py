"""Plots of records, models, residuals, campaigns and diagnoses with matplotlib.

``pip install gtfdi[plot]`` brings matplotlib along. Every function takes the package's own objects,
draws into the axes that it is given (``ax=`` for one, ``axes=`` for several) or into a new figure of
``matplotlib.pyplot``, and returns the axes. None shows a figure, changes a style or sets a default::

    import gtfdi
    import gtfdi.plot

    run = gtfdi.simulate(60.0, seed=1)
    axes = gtfdi.plot.record(run.measured, ["M_f", "t3", "p7"])
    axes[0].figure.savefig("record.svg")

Units are those of the objects, so SI; what a limit, a mark or a band is stands in each function.
"""

try:
    import matplotlib
except ImportError as _missing:
    raise ImportError("gtfdi.plot needs matplotlib: pip install gtfdi[plot]") from _missing

from gtfdi.plot.campaign import campaign_roc, campaign_sizes
from gtfdi.plot.detection import residuals, statistics
from gtfdi.plot.diagnosis import fault_scores, peaks
from gtfdi.plot.frequency import bode
from gtfdi.plot.order import orders
from gtfdi.plot.pole_map import pole_map
from gtfdi.plot.record import record
from gtfdi.plot.share import roc, share_of_sizes

__all__ = [
    "bode",
    "campaign_roc",
    "campaign_sizes",
    "fault_scores",
    "orders",
    "peaks",
    "pole_map",
    "record",
    "residuals",
    "roc",
    "share_of_sizes",
    "statistics",
]

del matplotlib
