"""How long a test runs in the mean before it alarms, and the limit for a time that is asked for.

Run lengths are in samples, on residuals that are white, normal and of standard deviation 1. With a
shift of 0 they are the time between false alarms, with another one the delay of detection. Of any
other statistic or noise they are simulated, with an interval (`SimulatedRuns`).
"""

from gtfdi._gtfdi import (
    SimulatedRuns,
    cusum_run_length as cusum,
    cusum_threshold,
    exceedance_limit,
    exceedance_run_length as exceedance,
    mean_delay_bound,
    run_sum_run_length as run_sum,
    run_sum_width,
    shiryaev_roberts_run_length as shiryaev_roberts,
    shiryaev_roberts_threshold,
)

__all__ = [
    "SimulatedRuns",
    "cusum",
    "cusum_threshold",
    "exceedance",
    "exceedance_limit",
    "mean_delay_bound",
    "run_sum",
    "run_sum_width",
    "shiryaev_roberts",
    "shiryaev_roberts_threshold",
]
