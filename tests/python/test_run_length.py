"""Run lengths: published numbers, limits that give the time asked for, bad input."""

import numpy as np
import pytest

import gtfdi
from gtfdi import run_length
from gtfdi.statistics import AdaptiveThreshold, Cusum, MovingAverage, WindowedChiSquare


@pytest.mark.parametrize(
    ("allowance", "threshold", "shift", "sides", "published", "digit"),
    [
        # Lucas and Crosier 1982, Technometrics 24, table 1; Montgomery, Statistical Quality
        # Control, table 9.3: both sides.
        (0.5, 4.0, 0.0, "both", 168.0, 1.0),
        (0.5, 4.0, 1.0, "both", 8.38, 0.01),
        (0.5, 5.0, 0.0, "both", 465.0, 1.0),
        (0.5, 5.0, 0.5, "both", 38.0, 0.1),
        (0.5, 5.0, 1.0, "both", 10.4, 0.1),
        (0.5, 5.0, 2.0, "both", 4.01, 0.01),
    ],
)
def test_published_run_lengths_of_the_cusum(allowance, threshold, shift, sides, published, digit):
    found = run_length.cusum(allowance, threshold, shift, sides)
    # Within one of the last digit that is printed.
    assert abs(found - published) <= digit


def test_published_run_length_of_the_shewhart_chart():
    # Three standard deviations on both sides: 1 / 0.0026998.
    assert run_length.exceedance(3.0) == pytest.approx(370.398, abs=5e-4)
    p = 0.5  # beyond zero on one side
    assert run_length.exceedance(0.0, 3, sides="upper") == pytest.approx((p**-3 - 1) / (1 - p))


@pytest.mark.parametrize("samples", [500.0, 1e5])
def test_limits_give_the_time_asked_for(samples):
    found = [
        run_length.cusum(0.5, run_length.cusum_threshold(0.5, samples)),
        run_length.exceedance(run_length.exceedance_limit(samples, 2), 2),
        run_length.run_sum(run_length.run_sum_width(samples)),
        run_length.shiryaev_roberts(1.0, run_length.shiryaev_roberts_threshold(1.0, samples)),
    ]
    # What roots are found to.
    np.testing.assert_allclose(found, samples, rtol=1e-6)


def test_no_detector_is_quicker_than_the_bound():
    for samples in (1e3, 1e6):
        threshold = run_length.cusum_threshold(0.5, samples, "upper")
        delay = run_length.cusum(0.5, threshold, 1.0, "upper")
        assert 1.0 < run_length.mean_delay_bound("step", 1.0, samples) < delay


def white(path, samples=400):
    return np.random.default_rng([1, path]).standard_normal(samples)


def test_simulated_run_lengths_are_the_exact_ones():
    cusum = Cusum(0.5, 2.5)
    cusum.process(white(0)[:5])
    before = cusum.value
    runs = run_length.SimulatedRuns(cusum, white, paths=3000, samples=400)
    assert cusum.value == before  # it stays as it is
    found = runs.run_length(2.5)
    exact = run_length.cusum(0.5, 2.5)
    # A 99 % interval of this seed, 2.58 / sqrt(3000) wide on each side.
    assert found["low"] < exact < found["high"] < 1.1 * found["low"]
    assert found["samples"] == pytest.approx(np.sqrt(found["low"] * found["high"]), rel=1e-12)
    assert found["alarms"] > 2990
    other = runs.threshold_for(exact)
    assert other["samples"] >= exact and other["threshold"] == pytest.approx(2.5, abs=0.1)
    # A single sample beyond a limit, of paths that mostly end before.
    single = run_length.SimulatedRuns(MovingAverage(1, 1.0), lambda p: white(p, 20), 20_000, 20)
    found = single.run_length(2.5)
    assert found["low"] < run_length.exceedance(2.5) < found["high"]


def test_simulated_run_lengths_are_of_any_noise():
    # Every path is five samples of nothing, then one of the path's index in deviations.
    def ramp(path):
        return np.where(np.arange(8) == 5, path, 0.0)

    runs = run_length.SimulatedRuns(WindowedChiSquare(1, 1.0), ramp, paths=40, samples=8)
    found = runs.run_length(100.0)
    # Of paths 11 to 39 the sixth sample is beyond, the other eleven end without an alarm.
    assert (found["alarms"], found["samples"]) == (29, (29 * 6 + 11 * 8) / 29)
    twice = run_length.SimulatedRuns(WindowedChiSquare(1, 99.0), ramp, paths=40, samples=8)
    assert twice == runs


def test_simulations_that_make_no_sense_are_refused():
    simulated = run_length.SimulatedRuns
    with pytest.raises(gtfdi.DesignError, match="paths.*at least 1"):
        simulated(Cusum(0.5, 2.5), white, paths=0, samples=400)
    with pytest.raises(gtfdi.DimensionError, match="^samples of noise: expected 300, found 400$"):
        simulated(Cusum(0.5, 2.5), white, paths=2, samples=300)
    with pytest.raises(ZeroDivisionError):
        simulated(Cusum(0.5, 2.5), lambda path: [1 / (1 - path)], paths=2, samples=1)
    with pytest.raises(TypeError):
        simulated(AdaptiveThreshold(1.0, [0.5], 10.0), white, paths=1, samples=400)
    runs = simulated(Cusum(0.5, 2.5), white, paths=10, samples=400)
    with pytest.raises(gtfdi.DesignError, match="20.*found 10|10.*20"):
        runs.run_length(2.5)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: run_length.cusum(-0.1, 5.0), "allowance.*found -0.1"),
        (lambda: run_length.cusum(0.5, 5.0, shift=np.nan), "shift.*found NaN"),
        (lambda: run_length.cusum(0.5, 300.0), "threshold.*expected a number from 0 to 250"),
        (lambda: run_length.exceedance(3.0, consecutive=0), "consecutive.*found 0"),
        (lambda: run_length.cusum_threshold(0.5, 0.5), "expected .*found 0.5"),
        (lambda: run_length.mean_delay_bound("step", -1.0, 100.0), "size.*found -1"),
        (lambda: run_length.shiryaev_roberts(9.0, 3.0), "shift.*from 0.1 to 5.*found 9"),
    ],
)
def test_what_makes_no_sense_is_refused(call, message):
    with pytest.raises(gtfdi.DesignError, match=message):
        call()
