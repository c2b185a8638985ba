"""Kalman filters: of any noise, of noise on the inputs too, and before they are steady."""

import numpy as np
import pytest

import gtfdi

TS = 0.1
DRAW = np.random.default_rng(31).standard_normal
A = DRAW((3, 3))
A *= 0.85 / np.abs(np.linalg.eigvals(A)).max()
MODEL = gtfdi.StateSpace(A, DRAW((3, 2)), DRAW((2, 3)), DRAW((2, 2)), TS)
INPUT_VARIANCES, OUTPUT_VARIANCES = [0.3, 0.2], [0.5, 0.4]
POINT = (np.array([1.0, 2.0]), np.array([3.0, 4.0]))


def errors_in_variables(samples, seed):
    """Inputs and outputs without noise, and as they are measured, round the point."""
    draw = np.random.default_rng(seed).standard_normal
    u = draw((samples, 2)).cumsum(axis=0) * 0.1
    y = MODEL.simulate(u)
    u, y = u + POINT[0], y + POINT[1]
    noise = np.sqrt(INPUT_VARIANCES), np.sqrt(OUTPUT_VARIANCES)
    return (u, y), (u + noise[0] * draw(u.shape), y + noise[1] * draw(y.shape))


def test_the_noise_of_channels_is_that_of_states_and_outputs():
    noise = gtfdi.NoiseCovariance.errors_in_variables(MODEL, INPUT_VARIANCES, OUTPUT_VARIANCES)
    su, sy = np.diag(INPUT_VARIANCES), np.diag(OUTPUT_VARIANCES)
    np.testing.assert_allclose(noise.Q, MODEL.B @ su @ MODEL.B.T, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(noise.R, sy + MODEL.D @ su @ MODEL.D.T, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(noise.S, MODEL.B @ su @ MODEL.D.T, rtol=1e-14, atol=1e-15)
    filter = gtfdi.kalman(MODEL, INPUT_VARIANCES, OUTPUT_VARIANCES, POINT)
    assert filter == gtfdi.kalman(MODEL, point=POINT, noise=noise)
    assert filter.noise == noise
    assert noise == gtfdi.NoiseCovariance(noise.Q, noise.R, noise.S)
    assert (gtfdi.NoiseCovariance(np.eye(3), np.eye(2)).S == np.zeros((3, 2))).all()


def test_a_run_is_the_recursion_sample_by_sample():
    filter = gtfdi.kalman(MODEL, INPUT_VARIANCES, OUTPUT_VARIANCES, POINT)
    _, (u, y) = errors_in_variables(100, 1)
    x0 = np.array([1.0, -1.0, 0.5])
    run = filter.run(u, y, x0=x0)
    assert len(run) == 100
    factor = np.linalg.cholesky(filter.innovation_covariance)
    x = x0
    for t in range(100):
        e = y[t] - POINT[1] - MODEL.C @ x - MODEL.D @ (u[t] - POINT[0])
        np.testing.assert_allclose(run.innovations[t], e, atol=1e-12)
        np.testing.assert_allclose(run.normalised[t], np.linalg.solve(factor, e), atol=1e-12)
        np.testing.assert_allclose(run.predicted[t], x, atol=1e-12)
        np.testing.assert_allclose(run.filtered[t], x + filter.filter_gain @ e, atol=1e-12)
        x = MODEL.A @ x + MODEL.B @ (u[t] - POINT[0]) + filter.predictor_gain @ e
    # From rest it is what the residual generator gives.
    rest = filter.run(gtfdi.Dataset(u, y, TS))
    np.testing.assert_allclose(rest.innovations, filter.innovations(u, y), atol=1e-12)
    p = filter.predicted_covariance
    expected = p - filter.filter_gain @ MODEL.C @ p
    np.testing.assert_allclose(filter.filtered_covariance, expected, rtol=1e-12, atol=1e-13)


def test_channels_without_their_noise_are_as_near_as_is_said():
    filter = gtfdi.EivKalman(MODEL, INPUT_VARIANCES, OUTPUT_VARIANCES, point=POINT)
    (u, y), measured = errors_in_variables(40_000, 2)
    found = filter.estimate(*measured)
    # Five standard errors of a variance, the root of 2 / N, of errors that are white but for what
    # the filter leaves in them.
    for name, true, covariance, noise in [
        ("y", y, filter.output_error_covariance, OUTPUT_VARIANCES),
        ("u", u, filter.input_error_covariance, INPUT_VARIANCES),
        ("u_smoothed", u, filter.smoothed_input_error_covariance, INPUT_VARIANCES),
    ]:
        errors = (found[name] - true)[100:]
        np.testing.assert_allclose((errors**2).mean(axis=0), np.diag(covariance), rtol=0.05)
        np.testing.assert_allclose(errors.mean(axis=0), 0.0, atol=0.05)
        assert (np.diag(covariance) < noise).all(), name
    smoothed, now = filter.smoothed_input_error_covariance, filter.input_error_covariance
    assert (np.diag(smoothed) < np.diag(now)).all()
    np.testing.assert_array_equal(found["u_smoothed"][-1], found["u"][-1])


def test_both_ways_to_the_filter_of_channels_are_one():
    own = gtfdi.EivKalman(MODEL, INPUT_VARIANCES, OUTPUT_VARIANCES, point=POINT)
    other = gtfdi.kalman(MODEL, INPUT_VARIANCES, OUTPUT_VARIANCES, POINT)
    np.testing.assert_array_equal(own.predictor_gain, other.predictor_gain)
    np.testing.assert_array_equal(own.filter_gain, other.filter_gain)
    np.testing.assert_array_equal(own.innovation_covariance, other.innovation_covariance)
    _, measured = errors_in_variables(50, 3)
    assert own.run(*measured, x0=[1.0, 0.0, 0.0]) == other.run(*measured, x0=[1.0, 0.0, 0.0])
    assert own.model == MODEL
    np.testing.assert_array_equal(own.point["y"], POINT[1])


def test_a_filter_that_starts_steady_stays_so():
    steady = gtfdi.kalman(MODEL, INPUT_VARIANCES, OUTPUT_VARIANCES, POINT)
    started = {"P0": steady.predicted_covariance, "x0": [1.0, 2.0, 3.0], "point": POINT}
    filter = gtfdi.TimeVaryingKalman(MODEL, steady.noise, **started)
    _, (u, y) = errors_in_variables(200, 4)
    expected = steady.run(u, y, x0=[1.0, 2.0, 3.0]).normalised
    np.testing.assert_allclose(filter.process(u, y), expected, atol=1e-10)
    p = steady.predicted_covariance
    np.testing.assert_allclose(filter.covariance, p, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(filter.predictor_gain, steady.predictor_gain, rtol=1e-8, atol=1e-10)


def test_a_filter_from_a_stated_start_is_the_recursion():
    covariances = np.diag([0.1, 0.2, 0.3]), np.diag([0.4, 0.5]), np.full((3, 2), 0.05)
    noise = gtfdi.NoiseCovariance(*covariances)
    filter = gtfdi.TimeVaryingKalman(MODEL, noise, P0=10.0 * np.eye(3), point=POINT)
    _, (u, y) = errors_in_variables(60, 5)
    x, p = np.zeros(3), 10.0 * np.eye(3)
    c, steps = MODEL.C, []
    for t in range(60):
        covariance = c @ p @ c.T + noise.R
        gain = (MODEL.A @ p @ c.T + noise.S) @ np.linalg.inv(covariance)
        np.testing.assert_allclose(filter.covariance, p, rtol=1e-9, atol=1e-11)
        np.testing.assert_allclose(filter.predictor_gain, gain, rtol=1e-9, atol=1e-11)
        e = y[t] - POINT[1] - c @ x - MODEL.D @ (u[t] - POINT[0])
        found = filter.step(u[t], y[t])
        np.testing.assert_allclose(found["value"], e, atol=1e-10)
        np.testing.assert_allclose(found["covariance"], covariance, rtol=1e-9, atol=1e-11)
        assert found["squared"] == pytest.approx(e @ np.linalg.solve(covariance, e), rel=1e-9)
        assert found["squared"] == pytest.approx(found["normalised"] @ found["normalised"])
        x = MODEL.A @ x + MODEL.B @ (u[t] - POINT[0]) + gain @ e
        p = MODEL.A @ p @ MODEL.A.T + noise.Q - gain @ covariance @ gain.T
        np.testing.assert_allclose(filter.state, x, atol=1e-10)
        steps.append(found["normalised"])
    filter.reset()
    np.testing.assert_array_equal(filter.state, 0.0)
    np.testing.assert_array_equal(filter.process(u, y), steps)


def test_a_filter_whose_noise_is_right_has_innovations_of_unit_covariance():
    noise = gtfdi.NoiseCovariance.errors_in_variables(MODEL, INPUT_VARIANCES, OUTPUT_VARIANCES)
    filter = gtfdi.TimeVaryingKalman(MODEL, noise, P0=np.zeros((3, 3)), point=POINT)
    _, measured = errors_in_variables(20_000, 6)
    normalised = filter.process(*measured)
    # Five standard errors of a variance and of a correlation.
    error = 5.0 / np.sqrt(len(normalised))
    covariance = normalised.T @ normalised / len(normalised)
    np.testing.assert_allclose(covariance, np.eye(2), atol=np.sqrt(2.0) * error)
    correlation = normalised[1:].T @ normalised[:-1] / len(normalised)
    np.testing.assert_allclose(correlation, 0.0, atol=error)


def test_what_cannot_be_filtered_is_refused():
    message = "^option noise: expected both variances, or the noise in their place, found {}$"
    noise = gtfdi.NoiseCovariance(np.eye(3), np.eye(2))
    for given, found in [
        ({}, "none"),
        ({"input_variances": INPUT_VARIANCES}, "input_variances"),
        ({"output_variances": OUTPUT_VARIANCES, "noise": noise}, "output_variances and noise"),
    ]:
        with pytest.raises(gtfdi.OptionError, match=message.format(found)):
            gtfdi.kalman(MODEL, **given)
    with pytest.raises(gtfdi.DesignError, match="^R.*symmetric"):
        gtfdi.NoiseCovariance(np.eye(3), [[1.0, 0.5], [0.0, 1.0]])
    with pytest.raises(gtfdi.DesignError, match=r"\[Q S; S' R\]"):
        gtfdi.NoiseCovariance([[1.0]], [[1.0]], [[2.0]])
    with pytest.raises(gtfdi.DimensionError, match="^rows of S: expected 3, found 2$"):
        gtfdi.NoiseCovariance(np.eye(3), np.eye(2), np.zeros((2, 2)))
    with pytest.raises(gtfdi.DesignError, match="u1.*-1"):
        gtfdi.EivKalman(MODEL, [-1.0, 0.0], OUTPUT_VARIANCES)
    filter = gtfdi.EivKalman(MODEL, INPUT_VARIANCES, OUTPUT_VARIANCES)
    with pytest.raises(gtfdi.DimensionError, match=r"^rows of x0 \(states\): expected 3, found 2$"):
        filter.run(np.zeros((5, 2)), np.zeros((5, 2)), x0=[0.0, 0.0])
    slow = gtfdi.Dataset(np.zeros((5, 2)), np.zeros((5, 2)), 0.2)
    message = "^sample time of the record: expected 0.1 s, found 0.2 s$"
    for call in (filter.run, filter.estimate, gtfdi.kalman(MODEL, noise=noise).run):
        with pytest.raises(gtfdi.DesignError, match=message):
            call(slow)
    start = gtfdi.TimeVaryingKalman(MODEL, noise, P0=np.eye(3))
    with pytest.raises(gtfdi.DesignError, match=message):
        start.process(slow)
    with pytest.raises(gtfdi.DimensionError, match=r"^rows of u \(inputs\): expected 2, found 3$"):
        start.step(np.zeros(3), np.zeros(2))
    np.testing.assert_array_equal(start.state, 0.0)
    with pytest.raises(gtfdi.DesignError, match=r"P\(0\)"):
        gtfdi.TimeVaryingKalman(MODEL, noise, P0=-np.eye(3))
