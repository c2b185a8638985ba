"""Disturbances of which nothing is known but where they enter."""

import pickle

import numpy as np
import pytest

import gtfdi

TS = 0.1
POINT = (np.array([2.0, -1.0]), np.array([10.0, 20.0, 30.0]))


def plant(seed, nx=4, ny=3):
    """A random stable model of two inputs, with a disturbance of the state and a fault of both."""
    draw = np.random.default_rng(seed).standard_normal
    a = draw((nx, nx))
    a *= 0.8 / np.abs(np.linalg.eigvals(a)).max()
    matrices = a, draw((nx, 2)), draw((ny, nx)), draw((ny, 2))
    entering = {"E_d": draw((nx, 1)), "E_f": draw((nx, 1)), "F_f": draw((ny, 1))}
    return gtfdi.FaultModel(gtfdi.StateSpace(*matrices, TS), **entering, point=POINT)


def record(faulty, u, d, f, w=0.0, v=0.0):
    """Inputs and outputs round the point, from rest at it, sample by sample in NumPy."""
    model, samples = faulty.model, len(u)
    w, v = np.broadcast_to(w, (samples, len(model.A))), np.broadcast_to(v, (samples, len(model.C)))
    x, y = np.zeros(len(model.A)), np.empty((samples, len(model.C)))
    for t in range(samples):
        y[t] = model.C @ x + model.D @ u[t] + faulty.F_d @ d[t] + faulty.F_f @ f[t] + v[t]
        x = model.A @ x + model.B @ u[t] + faulty.E_d @ d[t] + faulty.E_f @ f[t] + w[t]
    return u + POINT[0], y + POINT[1]


def response(system, hertz):
    """The frequency response of a system at one frequency."""
    z = np.exp(2j * np.pi * hertz * system.dt)
    return system.C @ np.linalg.solve(z * np.eye(len(system.A)) - system.A, system.B) + system.D


def unit_noise(nx=4, ny=3):
    return gtfdi.NoiseCovariance(np.eye(nx), np.eye(ny))


@pytest.mark.parametrize("seed", range(5))
def test_no_disturbance_reaches_the_residuals(seed):
    faulty = plant(seed)
    observer = gtfdi.UnknownInputObserver(faulty, noise=unit_noise())
    draw = np.random.default_rng(100 + seed).standard_normal
    u, d, f = draw((80, 2)), 1000.0 * draw((80, 1)), draw((80, 1))
    none = np.zeros((80, 1))
    u_quiet, y_quiet = record(faulty, u, none, none)
    disturbed, faulted = record(faulty, u, d, none), record(faulty, u, d, f)
    # What rounding leaves of outputs of that size, enlarged by what tells the disturbance.
    size = np.abs(disturbed[1]).max() * np.abs(observer.linear_residual.system.B).max()
    assert np.abs(observer.residuals(u_quiet, y_quiet)).max() < 1e-11 * size
    assert np.abs(observer.residuals(*disturbed)).max() < 1e-11 * size
    expected = observer.from_fault.simulate(f)
    np.testing.assert_allclose(observer.residuals(*faulted), expected, atol=1e-11 * size)
    assert expected.shape == (80, 2) and np.abs(expected).max() > 1.0
    # The gains say the same.
    assert gtfdi.peak_gain(observer.from_disturbance)["gain"] < 1e-11 * size
    assert gtfdi.peak_gain(observer.from_fault)["gain"] > 0.1


def test_the_residuals_are_white_under_the_noise():
    faulty, samples = plant(3), 20_000
    noise = gtfdi.NoiseCovariance(0.1 * np.eye(4), np.diag([0.1, 0.2, 0.3]))
    observer = gtfdi.UnknownInputObserver(faulty, noise=noise)
    draw = np.random.default_rng(7).standard_normal
    w, v = np.sqrt(0.1) * draw((samples, 4)), np.sqrt([0.1, 0.2, 0.3]) * draw((samples, 3))
    u, d = draw((samples, 2)), 10.0 * draw((samples, 1))
    residuals = observer.residuals(*record(faulty, u, d, np.zeros((samples, 1)), w, v))
    residuals = residuals[observer.settle_samples :]
    whitened = np.linalg.solve(np.linalg.cholesky(observer.covariance), residuals.T).T
    # Five standard errors of a variance (root of 2 / N) and of a correlation (root of 1 / N).
    error = 5.0 / np.sqrt(len(whitened))
    covariance = whitened.T @ whitened / len(whitened)
    np.testing.assert_allclose(covariance, np.eye(2), atol=np.sqrt(2.0) * error)
    for lag in (1, 2, 3):
        correlation = whitened[lag:].T @ whitened[:-lag] / len(whitened)
        np.testing.assert_allclose(correlation, 0.0, atol=error)


def test_poles_are_those_asked_for():
    faulty = plant(4, ny=2)
    faulty = gtfdi.FaultModel(faulty.model, E_d=faulty.E_d, F_f=np.ones((2, 1)))
    observer = gtfdi.UnknownInputObserver(faulty, poles=[0.1, 0.4, 0.6])
    found = np.sort(observer.linear_residual.system.poles().real)
    np.testing.assert_allclose(found, [0.1, 0.4, 0.6], atol=1e-9)
    assert observer.covariance is None and observer.gain.shape == (3, 1)
    assert observer.model == faulty


def test_samples_that_are_missing_begin_anew():
    faulty = plant(1)
    observer = gtfdi.UnknownInputObserver(faulty, noise=unit_noise())
    # What nobody measured before is what the filter has to forget.
    u, y = record(faulty, np.ones((300, 2)), np.ones((300, 1)), np.zeros((300, 1)))
    y[50, 1] = np.nan
    residuals = observer.residuals(u, y)
    assert np.isnan(residuals[50]).all() and np.isfinite(np.delete(residuals, 50, 0)).all()
    after = 51 + observer.settle_samples
    # Settled is a ten-thousandth of a start; some directions rise before they fall.
    assert np.abs(residuals[after:]).max() < 1e-3 * np.abs(residuals[51:after]).max()
    assert np.abs(residuals[-50:]).max() < 1e-9 * np.nanmax(np.abs(y))


def test_a_linear_residual_is_its_observer_and_goes_through_json():
    faulty = plant(2)
    observer = gtfdi.UnknownInputObserver(faulty, noise=unit_noise())
    alone = observer.linear_residual
    assert (alone.inputs, alone.outputs) == (["u1", "u2"], ["y1", "y2", "y3"])
    assert alone.residual_names == ["r0", "r1"]
    assert alone.settle_samples == observer.settle_samples
    draw = np.random.default_rng(3).standard_normal
    data = gtfdi.Dataset(draw((50, 2)), draw((50, 3)), TS)
    expected = observer.residuals(data)
    twin = gtfdi.LinearResidual.from_json(alone.to_json())
    assert twin == alone
    assert gtfdi.LinearResidual(alone.system, POINT) == alone
    for same in (alone, twin, pickle.loads(pickle.dumps(observer))):
        np.testing.assert_array_equal(same.residuals(data), expected)


def test_observers_that_cannot_be_are_refused():
    model = plant(0).model
    e = np.ones((4, 1))
    hidden = e - np.linalg.pinv(model.C) @ (model.C @ e)
    message = r"^disturbances of the state: expected rank\(C E\) = rank\(E\) = 1, found 0"
    with pytest.raises(gtfdi.DesignError, match=message):
        gtfdi.UnknownInputObserver(gtfdi.FaultModel(model, E_d=hidden), noise=unit_noise())
    three = gtfdi.FaultModel(model, E_d=np.eye(4)[:, :3])
    with pytest.raises(gtfdi.DesignError, match="outputs.*3"):
        gtfdi.UnknownInputObserver(three, noise=unit_noise())
    both = dict(noise=unit_noise(), poles=[0.1])
    for given, found in ({}, "none"), (both, "both"):
        message = f"^option noise: expected one of noise and poles, found {found}$"
        with pytest.raises(gtfdi.OptionError, match=message):
            gtfdi.UnknownInputObserver(plant(0), **given)
    with pytest.raises(gtfdi.DimensionError, match="^rows of E_d: expected 4, found 3$"):
        gtfdi.FaultModel(model, E_d=np.ones((3, 1)))
    with pytest.raises(gtfdi.DimensionError, match="^columns of F_f: expected 1, found 2$"):
        gtfdi.FaultModel(model, E_f=np.ones((4, 1)), F_f=np.ones((3, 2)))
    with pytest.raises(gtfdi.DesignError, match="^E_d.*finite"):
        gtfdi.FaultModel(model, E_d=[[1.0], [np.nan], [0.0], [0.0]])


def disturbed_everywhere(seed):
    """A model whose outputs all feel disturbances."""
    draw = np.random.default_rng(50 + seed).standard_normal
    model = plant(seed).model
    entering = {"E_d": draw((4, 5)), "F_d": draw((3, 5)), "E_f": draw((4, 1))}
    return gtfdi.FaultModel(model, **entering, F_f=draw((3, 1)), point=POINT)


@pytest.mark.parametrize("seed", range(5))
def test_disturbances_reach_normalised_residuals_with_a_gain_of_1(seed):
    unified = gtfdi.UnifiedFilter(disturbed_everywhere(seed))
    for hertz in np.linspace(0.0, 5.0, 21):
        own = response(unified.from_disturbance, hertz)
        np.testing.assert_allclose(own @ own.conj().T, np.eye(3), atol=1e-9)
    found = unified.robustness()
    assert found["disturbance"]["gain"] == pytest.approx(1.0, abs=1e-9)
    least = min(np.linalg.norm(response(unified.from_fault, f)) for f in np.linspace(0, 5, 501))
    # The sweep is refined, so it is at most that of a grid; the two differ by less than its step.
    assert found["fault"] <= least * (1.0 + 1e-12)
    assert found["fault"] == pytest.approx(least, rel=1e-2)
    at = response(unified.from_fault, found["fault_frequency_hz"])
    assert found["fault"] == pytest.approx(np.linalg.norm(at), rel=1e-9)
    assert found["ratio"] == found["fault"] / found["disturbance"]["gain"]


@pytest.mark.parametrize("seed", range(3))
def test_no_other_gain_is_as_robust(seed):
    faulty = disturbed_everywhere(seed)
    best = gtfdi.UnifiedFilter(faulty).robustness((0.0, 1.0))["ratio"]
    model = faulty.model
    for poles in (0.1, 0.5, 0.8):
        gain = gtfdi.place(model, poles)
        a = model.A - gain @ model.C
        systems = [
            gtfdi.StateSpace(a, e - gain @ f, model.C, f, TS)
            for e, f in [(faulty.E_d, faulty.F_d), (faulty.E_f, faulty.F_f)]
        ]
        assert gtfdi.robustness(*systems, (0.0, 1.0))["ratio"] < best


def test_a_unified_filter_is_a_kalman_filter_normalised():
    unified = gtfdi.UnifiedFilter(disturbed_everywhere(1))
    draw = np.random.default_rng(4).standard_normal
    u, y = draw((200, 2)), draw((200, 3))
    filter = unified.kalman
    v = unified.post_filter
    covariance = filter.innovation_covariance
    np.testing.assert_allclose(v @ covariance @ v.T, np.eye(3), atol=1e-12)
    expected = filter.innovations(u, y) @ v.T
    size = np.abs(expected).max()
    np.testing.assert_allclose(unified.residuals(u, y), expected, atol=1e-12 * size)
    assert unified.settle_samples == filter.settle_samples
    assert gtfdi.Fleet(filter, streams=2).streams == 2


def test_unified_filters_that_cannot_be_are_refused():
    model = plant(0).model
    with pytest.raises(gtfdi.DesignError, match="^disturbances: expected at least one .* none$"):
        gtfdi.UnifiedFilter(gtfdi.FaultModel(model, E_f=np.ones((4, 1))))
    with pytest.raises(gtfdi.DesignError, match="innovations.* positive definite"):
        gtfdi.UnifiedFilter(plant(0))
    unified = gtfdi.UnifiedFilter(disturbed_everywhere(0))
    message = r"^band 1..6 Hz: expected 0 <= low <= high <= 5 Hz$"
    with pytest.raises(gtfdi.DesignError, match=message):
        unified.robustness((1.0, 6.0))


@pytest.mark.parametrize("seed", range(10))
def test_the_peak_gain_is_nowhere_exceeded_and_reached(seed):
    system = plant(seed).model
    found = gtfdi.peak_gain(system)
    gains = [np.linalg.norm(response(system, f), 2) for f in np.linspace(0.0, 5.0, 2001)]
    assert found["gain"] * (1.0 - 1e-4) < max(gains) <= found["bound"]
    there = np.linalg.norm(response(system, found["frequency_hz"]), 2)
    assert there == pytest.approx(found["gain"], rel=1e-9)
    assert found["bound"] == pytest.approx(found["gain"] * (1.0 + 1e-7), rel=1e-14)


def test_gains_of_what_has_none_are_refused():
    growing = gtfdi.StateSpace([[1.5]], [[1.0]], [[1.0]], [[0.0]], TS)
    message = "^gain of a system: expected a stable one, found a spectral radius of 1.5$"
    with pytest.raises(gtfdi.DesignError, match=message):
        gtfdi.peak_gain(growing)
    one, two = plant(0).model, plant(0, ny=2).model
    with pytest.raises(gtfdi.DimensionError, match="^outputs of from_fault: expected 3, found 2$"):
        gtfdi.robustness(one, two)


def tank_record(seed, samples, inflow=0.0, level=0.0):
    """A tank with three levels, all readings with noise; from the middle on two of them are off."""
    rng = np.random.default_rng(seed)
    drive, noise = rng.normal(size=samples), 0.05 * rng.normal(size=(samples, 4))
    demand, x = np.zeros(samples), np.zeros(samples)
    for t in range(1, samples):
        demand[t] = 0.97 * demand[t - 1] + drive[t]
        x[t] = 0.95 * x[t - 1] + 0.05 * demand[t - 1]
    off = np.arange(samples) >= samples // 2
    y = np.column_stack([x, 0.5 * x + off * level, -0.8 * x]) + noise[:, 1:]
    return gtfdi.Dataset(
        demand + off * inflow + noise[:, 0], y, TS, inputs=["u"], outputs=["a", "b", "c"]
    )


def test_a_bank_does_without_an_unknown_input():
    # An hour between false alarms is asked for, and the records have five minutes.
    model = gtfdi.eiv(tank_record(1, 4000), order=1, nk=1)
    options = {"generator": "kalman", "statistic": "chi2", "arl0_h": 1.0}
    healthy = [tank_record(2, 20_000)]
    everything = gtfdi.design(model, healthy, watch="joint", **options)
    without = gtfdi.design(model, healthy, unknown=["u"], **options)
    assert [test["output"] for test in without.detectors] == ["joint"]
    inflow, level = tank_record(3, 3000, inflow=8.0), tank_record(3, 3000, level=0.5)
    assert everything.detect(inflow).alarms and not without.detect(inflow).alarms
    alarms = without.detect(level).alarms
    assert alarms and all(alarm["time_s"] >= 150.0 for alarm in alarms)


def test_unknown_channels_are_of_the_model_and_leave_something():
    model = gtfdi.eiv(tank_record(1, 4000), order=1, nk=1)
    healthy, options = [tank_record(2, 4000)], {"generator": "kalman", "statistic": "chi2"}
    with pytest.raises(gtfdi.OptionError, match="unknown: expected none without the generator"):
        gtfdi.design(model, healthy, unknown=["u"])
    with pytest.raises(gtfdi.GtfdiError, match="`v`"):
        gtfdi.design(model, healthy, unknown=["v"], **options)
    with pytest.raises(gtfdi.GtfdiError, match="outputs: expected more than the 1 independent"):
        gtfdi.design(model, healthy, unknown=["u", "a", "b"], **options)
