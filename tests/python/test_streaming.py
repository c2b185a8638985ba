"""The statistics sample by sample: recursions written out, states that come back, bad input."""

import copy

import numpy as np
import pytest

import gtfdi
from gtfdi import statistics

NOISE = np.random.default_rng(11).standard_normal(500)
# Sums of some hundred doubles in another order.
ROUNDING = 1e-10


def cusum(residuals, allowance):
    upper = lower = 0.0
    for r in residuals:
        upper, lower = max(0.0, upper + r - allowance), max(0.0, lower - r - allowance)
        yield max(upper, lower)


def shiryaev_roberts(residuals, shift):
    total = 0.0
    for r in residuals:
        total = (1.0 + total) * np.exp(shift * r - shift**2 / 2.0)
        yield np.log1p(total)


def windows(residuals, length):
    padded = np.concatenate([np.zeros(length - 1), residuals])
    return np.lib.stride_tricks.sliding_window_view(padded, length)


EXPECTED = {
    "cusum": (statistics.Cusum(0.5, 5.0), list(cusum(NOISE, 0.5))),
    "shiryaev-roberts": (
        statistics.ShiryaevRoberts(0.8, 6.0, "upper"),
        list(shiryaev_roberts(NOISE, 0.8)),
    ),
    "moving average": (statistics.MovingAverage(7, 1.0), np.abs(windows(NOISE, 7).mean(axis=1))),
    "chi-square": (statistics.WindowedChiSquare(9, 30.0), (windows(NOISE, 9) ** 2).sum(axis=1)),
    "sprt": (statistics.Sprt(0.5, -99.0, 99.0), np.cumsum(0.5 * NOISE - 0.125)),
}


@pytest.mark.parametrize("name", EXPECTED)
def test_many_samples_are_the_recursion_written_out(name):
    statistic, expected = EXPECTED[name]
    own = copy.deepcopy(statistic)
    np.testing.assert_allclose(own.process(NOISE), expected, atol=ROUNDING)
    assert own.value == pytest.approx(expected[-1], abs=ROUNDING)
    # One by one it is the same to the bit, and a reset begins anew.
    own.reset()
    assert own == statistic
    single = [own.step(r)[0] for r in NOISE]
    np.testing.assert_array_equal(single, copy.deepcopy(statistic).process(NOISE))


@pytest.mark.parametrize("name", EXPECTED)
def test_a_missing_sample_changes_nothing(name):
    statistic = copy.deepcopy(EXPECTED[name][0])
    statistic.process(NOISE[:40])
    before = copy.deepcopy(statistic)
    for missing in (np.nan, np.inf):
        value, _, flagged = statistic.step(missing)
        assert flagged and value == before.value and statistic == before
    assert statistic.step(0.1)[2] is False


def test_an_alarm_is_a_value_above_the_threshold():
    own = statistics.Cusum(0.0, 2.0, sides="upper")
    assert [own.step(1.0)[1] for _ in range(4)] == [False, False, True, True]
    assert own.change == (4, pytest.approx(1.0))
    assert statistics.Cusum(0.0, 2.0, sides="lower").step(9.0)[0] == 0.0


def test_the_likeliest_step_has_its_age_and_size():
    own = statistics.Glr("step", (0.1, 10.0), 12.0, longest=64)
    own.process(np.concatenate([np.zeros(100), np.full(16, -2.0)]))
    age, size = own.change
    # 16 is among the lengths of its windows.
    assert (age, size) == (16, pytest.approx(-2.0))
    # Sixteen squares of two, halved.
    assert own.value == pytest.approx(32.0)


def test_the_run_sum_of_the_zone_chart():
    own = statistics.RunSum(1.0)
    assert own.process([0.5, 1.5, 2.5, 3.5, -1.5]).tolist() == [0.0, 2.0, 6.0, 14.0, 2.0]
    assert (own.upper, own.lower) == (0, 2)


def test_an_adaptive_threshold_gives_way_and_comes_back():
    own = statistics.AdaptiveThreshold(1.0, [0.5, 0.0], 4.0)
    own.step([0.0, 0.0], 0.0)
    own.step([2.0, 9.0], 0.0)
    assert own.limit == 2.0
    for _ in range(4):
        own.step([2.0, 9.0], 0.0)
    assert own.limit == pytest.approx(1.0 + np.exp(-1.0), abs=ROUNDING)
    with pytest.raises(gtfdi.DesignError, match="^inputs of the sample: expected 2, found 1$"):
        own.step([0.0], 0.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: statistics.Cusum(-1.0, 5.0), "^allowance: expected a finite number not below 0"),
        (lambda: statistics.Cusum(0.5, 0.0), "^threshold: expected a positive finite number"),
        (lambda: statistics.Glr("step", (2.0, 1.0), 5.0), "^sizes: expected 0 < smallest <= "),
        (lambda: statistics.MovingAverage(0, 1.0), "^window: expected 1 to .* found 0$"),
        (lambda: statistics.Sprt(0.0, -1.0, 1.0), "^shift: expected a finite number other than 0"),
        (lambda: statistics.Whiteness(10, 10, 5.0), "^lags: expected 1 to 9, found 10$"),
        (lambda: statistics.GrowingVariance(9, 1.0, longest=5), "^growing window: expected"),
    ],
)
def test_options_out_of_range_are_refused(make, message):
    with pytest.raises(gtfdi.DesignError, match=message):
        make()


def test_words_are_checked():
    message = '^option sides: expected upper, lower or both, found "up"$'
    with pytest.raises(gtfdi.OptionError, match=message):
        statistics.Cusum(0.5, 5.0, sides="up")
    message = '^option waveform: expected step or ramp, found "sine"$'
    with pytest.raises(gtfdi.OptionError, match=message):
        statistics.Glr("sine", (0.1, 1.0), 5.0)
