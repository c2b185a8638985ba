"""Banks of Kalman filters and calibrated statistics: whitened, joint, resumed."""

import json
import pickle

import numpy as np
import pytest

import gtfdi

SAMPLES = 20_000
SAMPLE_TIME_S = 0.08


def record(seed, step=0.0, onset=SAMPLES):
    """Two outputs of one input, all measured with noise; a step on the sensor of the second."""
    rng = np.random.default_rng(seed)
    u = rng.normal(size=SAMPLES)
    x = np.zeros((SAMPLES, 2))
    for t in range(1, SAMPLES):
        x[t] = np.array([0.9, 0.7]) * x[t - 1] + np.array([0.5, 1.0]) * u[t - 1]
    y = x + rng.normal(size=x.shape) * [0.2, 0.3]
    y[onset:, 1] += step
    measured = u + 0.1 * rng.normal(size=SAMPLES)
    return gtfdi.Dataset(measured, y, SAMPLE_TIME_S, ["u"], ["a", "b"])


@pytest.fixture(scope="module")
def model():
    return gtfdi.eiv(record(1), order=1)


@pytest.fixture(scope="module")
def healthy():
    return [record(2), record(3)]


def test_the_innovations_of_the_kalman_filter_are_white(model):
    part = model.relation.output_model("b")
    noise = model.noise_variances
    filter = gtfdi.kalman(part, [noise["u"]], [noise["b"]])
    data = record(4).select(["u"], ["b"])
    innovations = filter.innovations(data)[filter.settle_samples :, 0]
    # Six deviations of a correlation of N samples.
    centred = innovations - innovations.mean()
    lagged = [centred[k:] @ centred[: len(centred) - k] for k in range(6)]
    assert np.abs(np.array(lagged[1:]) / lagged[0]).max() < 6 / np.sqrt(SAMPLES)
    # The variance that the filter states, to six deviations of its estimate and 5 % of the model's.
    stated = filter.innovation_covariance[0, 0]
    assert centred.var() == pytest.approx(stated, rel=6 * np.sqrt(2 / SAMPLES) + 0.05)
    assert filter.predictor_gain.shape == filter.filter_gain.shape == (1, 1)
    assert 0.0 < filter.spectral_radius < 0.9
    assert pickle.loads(pickle.dumps(filter)) == filter
    closed = filter.model.A - filter.predictor_gain @ filter.model.C
    assert filter.spectral_radius == pytest.approx(np.abs(np.linalg.eigvals(closed)).max())


def test_two_outputs_are_filtered_together():
    system = gtfdi.StateSpace([[0.5]], [[1.0]], [[1.0], [2.0]], [[0.0], [0.0]], 0.1)
    filter = gtfdi.kalman(system, [0.1], [0.2, 0.3])
    p = filter.predicted_covariance
    a, c = system.A, system.C
    covariance = c @ p @ c.T + np.diag([0.2, 0.3])
    # The Riccati equation of the filter, with Q = B B' 0.1.
    gain = a @ p @ c.T @ np.linalg.inv(covariance)
    assert a @ p @ a.T + 0.1 - gain @ covariance @ gain.T == pytest.approx(p, rel=1e-12)
    assert filter.innovation_covariance == pytest.approx(covariance, rel=1e-12)
    with pytest.raises(gtfdi.DesignError, match="^noise of `u1`: expected a finite variance"):
        gtfdi.kalman(system, [-0.1], [0.2, 0.3])
    with pytest.raises(gtfdi.DimensionError, match="^output noise variances: expected 2, found 1"):
        gtfdi.kalman(system, [0.1], [0.2])


@pytest.mark.parametrize("statistic", ["cusum", "moving-average", "chi2", "glr"])
def test_statistics_find_a_small_step_with_the_rate_that_was_asked(model, healthy, statistic):
    waveform = {"waveform": "step", "sizes": (0.3, 3.0), "window": 256}
    options = waveform if statistic == "glr" else {}
    bank = gtfdi.design(
        model, healthy, generator="kalman", statistic=statistic, arl0_h=1.0, **options
    )
    assert (bank.name, bank.tests) == ("filters", ["a", "b"])
    for report in bank.detectors:
        mean_time = report["false_alarms"]["mean_time"]
        # Two tests share one alarm an hour.
        assert mean_time["asked_hours"] == 2.0
        assert report["poles"] == []
    onset = 12_000
    found = bank.detect(record(5, step=0.6, onset=onset))
    alarms = [a for a in found.alarms if a["time_s"] >= onset * SAMPLE_TIME_S]
    assert alarms[0]["tag"] == "b"
    # Two whitened standard deviations or so: found within a minute by all of them.
    assert alarms[0]["time_s"] < onset * SAMPLE_TIME_S + 60.0
    assert alarms[0]["statistic"] > alarms[0]["threshold"]
    early = [a for a in found.alarms if a["time_s"] < onset * SAMPLE_TIME_S]
    # A quarter of an hour at one an hour: more than three would be one chance in 10 000.
    assert len(early) <= 3
    if statistic in ("cusum", "glr"):
        assert abs(alarms[0]["onset_s"] - onset * SAMPLE_TIME_S) < 15.0
        # Of the sensor's step the filter, which follows it, leaves a part.
        assert 0.1 < alarms[0]["deviation"] < 1.2
    assert found.statistics.shape == (SAMPLES, 2)


def test_a_joint_test_watches_all_outputs(model, healthy):
    bank = gtfdi.design(
        model, healthy, generator="kalman", watch="joint", exceedance=0.01, consecutive=3
    )
    assert (bank.tests, bank.outputs) == (["joint"], ["a", "b"])
    (report,) = bank.detectors
    assert report["outputs"] == ["a", "b"]
    found = bank.detect(record(6))
    # Share 0.01 of SAMPLES: six standard deviations of its count.
    assert found.share_above_limit[0] == pytest.approx(0.01, abs=6 * np.sqrt(0.01 / SAMPLES))
    both = gtfdi.design(model, healthy, generator="kalman", watch="both", margin=1.5)
    assert both.tests == ["a", "b", "joint"]


def test_a_detector_resumes_bit_for_bit(model, healthy):
    bank = gtfdi.design(model, healthy, generator="kalman", statistic="cusum", arl0_h=1.0)
    data = record(7, step=1.0, onset=300)
    one, other = bank.detector(), bank.detector()
    one.process(data.u[:400], data.y[:400])
    state = one.state()
    other.resume(json.dumps(json.loads(state)))
    left, right = (each.process(data.u[400:900], data.y[400:900]) for each in (one, other))
    assert left.statistic.tobytes() == right.statistic.tobytes()
    # Without times given, a resumed clock counts on from the last one it had, not from the first.
    assert np.allclose(left.time_s, right.time_s, rtol=1e-14, atol=0.0)
    strange = gtfdi.design(model, healthy, generator="kalman", margin=2.0).detector()
    with pytest.raises(gtfdi.StepError, match="^state of the detector: expected that of this bank"):
        strange.resume(state)


def test_options_of_statistics_are_checked(model, healthy):
    def refused(message, **options):
        with pytest.raises(gtfdi.OptionError, match=message):
            gtfdi.design(model, healthy, **options)

    refused("^option statistic: expected one of threshold, .*, found mean", statistic="mean")
    refused("^option generator: expected one of observer, kalman", generator="luenberger")
    refused("^option watch: expected one of outputs, joint, both", watch="none")
    refused("^option `window`: expected with the statistic moving-average or", window=5)
    refused("^option `sizes`: sizes: expected 0 < smallest", statistic="glr", sizes=(2.0, 1.0))
    refused("^option poles: expected none with", generator="kalman", poles=0.5)
