"""Residual tests, responses, gains, poles and zeros, realisations."""

import json

import numpy as np
import pytest
from test_arx_options import arx_record

import gtfdi

SAMPLE_TIME_S = 0.1
# Quantile of the normal law, as printed in the usual tables.
NORMAL_975 = 1.959964


@pytest.fixture(scope="module")
def data():
    return arx_record(2000, 21)


@pytest.fixture(scope="module")
def fit(data):
    return gtfdi.Arx(order=2).fit_in_full(data)


def with_coefficients(model, values):
    """The same model with other coefficients of its only row."""
    text = json.loads(model.to_json())
    for term, value in zip(text["rows"][0]["terms"], values, strict=True):
        term["coefficient"] = value
    return gtfdi.ArxModel.from_json(json.dumps(text))


def coefficients(model):
    return np.array([term["coefficient"] for term in model.regression[0]])


def propagated(function, fit):
    """The standard error of a function of the coefficients by central differences."""
    at, step = coefficients(fit.model), 1e-6
    gradient = np.array(
        [(function(at + move) - function(at - move)) / (2.0 * step) for move in step * np.eye(4)]
    )
    return np.sqrt(gradient @ fit.covariance[0] @ gradient)


def response(at, frequency_hz):
    """(b1 z + b2) / (z^2 - a1 z - a2), written out."""
    z = np.exp(2j * np.pi * frequency_hz * SAMPLE_TIME_S)
    return (at[2] * z + at[3]) / (z**2 - at[0] * z - at[1])


def test_prop_the_response_is_that_of_the_coefficients(fit):
    frequencies = np.array([0.0, 0.3, 1.0, 2.5, 5.0])
    found = fit.frequency_response(frequencies)
    assert np.array_equal(found.frequency_hz, frequencies)
    assert found.response.shape == (5, 1, 1)
    assert (found.inputs, found.outputs) == (["u1"], ["y1"])
    expected = response(coefficients(fit.model), frequencies)
    assert np.allclose(found.response[:, 0, 0], expected, rtol=1e-12)
    for index, frequency in enumerate(frequencies):
        error = propagated(lambda at, f=frequency: np.abs(response(at, f)), fit)
        # Central differences of a step of 1e-6 are good to about eight digits.
        assert found.magnitude_error[index, 0, 0] == pytest.approx(error, rel=1e-6)
        phase = propagated(lambda at, f=frequency: np.angle(response(at, f)), fit)
        inside = 0.0 < frequency < 5.0
        if inside:
            assert found.phase_error_rad[index, 0, 0] == pytest.approx(phase, rel=1e-6)
    for band, value, error in [
        (found.magnitude_band(), np.abs(expected), found.magnitude_error),
        (found.phase_band_rad(0.95), np.angle(expected), found.phase_error_rad),
    ]:
        assert band.shape == (5, 1, 1, 2)
        for side, sign in enumerate((-1.0, 1.0)):
            limit = value + sign * NORMAL_975 * error[:, 0, 0]
            assert np.allclose(
                band[:, 0, 0, side], limit, rtol=0.0, atol=1e-6 * np.abs(value).max()
            )
    # The truth is within five standard errors at every frequency.
    truth = np.abs(response([1.2, -0.5, 0.8, 0.3], frequencies))
    assert (np.abs(np.abs(expected) - truth) < 5.0 * found.magnitude_error[:, 0, 0]).all()


def test_gains_at_rest(fit):
    gains = fit.dc_gains(confidence=0.95)
    assert set(gains) == {"value", "standard_error", "low", "high"}
    expected = response(coefficients(fit.model), 0.0).real
    assert gains["value"].shape == (1, 1)
    assert gains["value"][0, 0] == pytest.approx(expected, rel=1e-12)
    error = propagated(lambda at: response(at, 0.0).real, fit)
    assert gains["standard_error"][0, 0] == pytest.approx(error, rel=1e-6)
    assert gains["high"][0, 0] == pytest.approx(expected + NORMAL_975 * error, rel=1e-6)
    assert gains["low"][0, 0] == pytest.approx(expected - NORMAL_975 * error, rel=1e-6)
    # B(1) / A(1) of the truth.
    truth = (0.8 + 0.3) / (1.0 - 1.2 + 0.5)
    assert abs(expected - truth) < 5.0 * error


def test_responses_refuse(fit):
    with pytest.raises(
        gtfdi.IdentError,
        match=r"^frequency: expected 0 to 5 Hz \(half the sampling rate\), found 6 Hz$",
    ):
        fit.frequency_response([1.0, 6.0])
    for confidence in (0.0, 1.0, float("nan")):
        found = "NaN" if confidence != confidence else f"{confidence:g}"
        message = f"^option confidence: expected a number above 0 and below 1, found {found}$"
        with pytest.raises(gtfdi.OptionError, match=message):
            fit.dc_gains(confidence)
        with pytest.raises(gtfdi.OptionError, match=message):
            fit.frequency_response([1.0]).magnitude_band(confidence)
    integrator = with_coefficients(fit.model, [1.0, 0.0, 1.0, 0.0])
    with pytest.raises(
        gtfdi.IdentError,
        match="^response at 0 Hz: expected a finite value, found a pole there$",
    ):
        gtfdi.ArxFit(integrator, fit.covariance).dc_gains()
    # Nothing where the response is zero: no phase, and so no band of it.
    silent = gtfdi.ArxFit(with_coefficients(fit.model, [0.5, 0.0, 0.0, 0.0]), fit.covariance)
    silence = silent.frequency_response([1.0])
    assert np.isinf(silence.phase_error_rad).all()
    assert np.isnan(silence.phase_band_rad()).all()


def test_prop_poles_and_zeros_are_those_of_the_coefficients(fit):
    report = fit.pole_zero()
    at = coefficients(fit.model)
    poles = np.array([pole["value"] for pole in report["poles"]])
    expected = np.roots([1.0, -at[0], -at[1]])
    assert np.allclose(np.sort_complex(poles), np.sort_complex(expected), rtol=0.0, atol=1e-10)
    for pole in report["poles"]:
        assert pole["output"] is None, "a full structure has the poles of the whole model"
        size, angle = np.abs(pole["value"]), np.angle(pole["value"])
        assert pole["magnitude"]["value"] == pytest.approx(size, rel=1e-12)
        time_constant = -SAMPLE_TIME_S / np.log(size)
        assert pole["time_constant_s"]["value"] == pytest.approx(time_constant, rel=1e-12)
        # |z| = sqrt(-a2) for a complex pair.
        error = propagated(lambda at: np.sqrt(-at[1]), fit)
        assert pole["magnitude"]["standard_error"] == pytest.approx(error, rel=1e-6)
        natural = np.hypot(np.log(size), angle) / (2.0 * np.pi * SAMPLE_TIME_S)
        assert pole["natural_frequency_hz"]["value"] == pytest.approx(natural, rel=1e-12)
        damping = -np.log(size) / np.hypot(np.log(size), angle)
        assert pole["damping"]["value"] == pytest.approx(damping, rel=1e-12)
        assert pole["covariance"].shape == (2, 2)
        trace = np.sqrt(np.trace(pole["covariance"]))
        assert pole["standard_error"] == pytest.approx(trace, rel=1e-12)
    (channel,) = report["channels"]
    assert (channel["output"], channel["input"]) == ("y1", "u1")
    zeros = [zero["value"] for zero in channel["zeros"]]
    # One from the coefficients; the lags put none at the origin.
    assert zeros == [pytest.approx(-at[3] / at[2], rel=1e-9)]
    error = propagated(lambda at: -at[3] / at[2], fit)
    assert channel["zeros"][0]["standard_error"] == pytest.approx(error, rel=1e-6)
    assert channel["cancellations"] == []
    assert report["superfluous_poles"] == []


def test_an_order_too_many_shows_as_a_cancellation(data):
    # One pair of order 3 cancels in truth; it is within two standard errors in most records.
    report = gtfdi.Arx(order=3, structure="diag").fit_in_full(data).pole_zero()
    assert all(pole["output"] == "y1" for pole in report["poles"])
    (pole,) = report["superfluous_poles"]
    (pair,) = report["channels"][0]["cancellations"]
    assert pair["pole"] == pole
    zero = report["channels"][0]["zeros"][pair["zero"]]["value"]
    distance = abs(zero - report["poles"][pole]["value"])
    assert pair["distance"] == pytest.approx(distance, rel=1e-12)
    assert 0.0 <= pair["standard_errors"] <= 2.0


def test_prop_correlations_are_those_of_the_errors(fit):
    fresh = arx_record(1000, 22)
    report = fit.model.test_residuals(fresh, lags=12, significance=0.05)
    error = fit.model.equation_error(fresh)[2:, 0]
    rows = len(error)
    assert report.rows == rows == 998
    lagged = np.array([error[k:] @ error[: rows - k] for k in range(1, 13)])
    expected = lagged / (error @ error)
    assert report.autocorrelation.shape == report.autocorrelation_band.shape == (12, 1)
    # Sums in another order.
    assert np.allclose(report.autocorrelation[:, 0], expected, rtol=0.0, atol=1e-12)
    # Far from the first lags the band is that of white noise.
    assert report.autocorrelation_band[-1, 0] == pytest.approx(NORMAL_975 / np.sqrt(rows), rel=1e-3)
    statistic = rows * (rows + 2) * np.sum(expected**2 / (rows - np.arange(1, 13)))
    (test,) = report.ljung_box
    assert test["statistic"] == pytest.approx(statistic, rel=1e-9)
    assert np.array_equal(report.cross_lags, np.arange(-12, 13))
    u = fresh.u[:, 0] - fresh.u.mean()
    size = np.sqrt(np.mean(error**2) * np.mean(u**2))
    cross = []
    for lag in range(-12, 13):
        times = [t for t in range(2, 1000) if 0 <= t - lag < 1000]
        cross.append(sum(error[t - 2] * u[t - lag] for t in times) / rows / size)
    assert report.cross_correlation.shape == (25, 1, 1)
    assert np.allclose(report.cross_correlation[:, 0, 0], cross, rtol=0.0, atol=1e-12)
    assert report.cross_correlation_band.shape == (1, 1)
    (channel,) = report.by_input
    assert (channel["output"], channel["input"]) == ("y1", "u1")
    verdict = report.verdict
    assert (verdict["lags"], verdict["significance"]) == (12, 0.05)
    outcome = {True: "rejected", False: "not_rejected"}
    (output,) = verdict["outputs"]
    assert output["output"] == "y1"
    assert output["whiteness"] == outcome[test["p_value"] < 0.05]
    assert output["independence"] == outcome[report.independence[0]["p_value"] < 0.05]
    assert verdict["joint_whiteness"] == outcome[report.hosking["p_value"] < 0.05]
    # One input: its test is that of all.
    assert channel["independence"] == report.independence[0]


def test_a_model_of_too_low_an_order_is_rejected(data, fit):
    fresh = arx_record(2000, 23)
    # One in a thousand records of the truth is rejected.
    good = fit.model.test_residuals(fresh, significance=0.001).verdict["outputs"][0]
    assert good == {"output": "y1", "whiteness": "not_rejected", "independence": "not_rejected"}
    low = gtfdi.arx(data, order=1)
    poor = low.test_residuals(fresh, significance=0.001).verdict["outputs"][0]
    assert poor == {"output": "y1", "whiteness": "rejected", "independence": "rejected"}
    # On the record of the fit the regressors are orthogonal to the errors.
    fitted = fit.model.test_residuals(data, origin="fitted")
    assert np.abs(fitted.cross_correlation[[21, 22], 0, 0]).max() < 1e-9
    # They leave 18 of the 20 past inputs to test there, and none is taken on another record.
    other = fit.model.test_residuals(data)
    assert fitted.independence[0]["degrees_of_freedom"] == 18.0
    assert fitted.independence[0]["correction"] == -2.0
    assert other.independence[0]["degrees_of_freedom"] == 20.0
    # The same errors are less white than they look where they were fitted.
    assert fitted.ljung_box[0]["statistic"] == other.ljung_box[0]["statistic"]
    assert fitted.ljung_box[0]["p_value"] < other.ljung_box[0]["p_value"]


def test_residual_tests_refuse(data, fit):
    with pytest.raises(
        gtfdi.OptionError, match='^option origin: expected fresh or fitted, found "other"$'
    ):
        fit.model.test_residuals(data, origin="other")
    with pytest.raises(gtfdi.IdentError, match="^option lags: expected 3 to 1997, found 2$"):
        fit.model.test_residuals(data, lags=2)
    with pytest.raises(
        gtfdi.IdentError,
        match="^option significance: expected a number above 0 and below 1, found 1$",
    ):
        fit.model.test_residuals(data, significance=1.0)


def test_prop_hankel_singular_values_are_those_of_the_gramians(fit):
    report = fit.model.realisation_report()
    space = fit.model.state_space()
    nx = len(space.A)
    assert report["order"] == report["reachable"] == report["observable"] == nx == 2
    # vec(P) = (I - A x A)^-1 vec(B B').
    system = np.eye(nx * nx) - np.kron(space.A, space.A)
    p = np.linalg.solve(system, (space.B @ space.B.T).ravel()).reshape(nx, nx)
    q = np.linalg.solve(
        np.eye(nx * nx) - np.kron(space.A.T, space.A.T), (space.C.T @ space.C).ravel()
    )
    values = np.sqrt(np.linalg.eigvals(p @ q.reshape(nx, nx)).real)
    assert np.allclose(report["hankel_singular_values"], np.sort(values)[::-1], rtol=1e-9)
    assert report["minimal_order"] == 2
    assert report["m_determinant"] == pytest.approx(1.0, abs=1e-12)
    assert report["warnings"] == []


def test_a_realisation_that_is_not_minimal_is_said_to_be(fit):
    # (1 - 0.3 q)(1 - 0.5 q) y = (1 - 0.3 q) q u.
    common = with_coefficients(fit.model, [0.8, -0.15, 1.0, -0.3])
    report = common.realisation_report()
    assert report["minimal_order"] == 1
    assert report["warnings"] == [{"not_minimal": {"order": 2, "minimal": 1}}]
    # A Hankel matrix of the rest: 1 / (1 - 0.5^2).
    assert report["hankel_singular_values"][0] == pytest.approx(1.0 / 0.75, rel=1e-9)
    unstable = with_coefficients(fit.model, [1.2, 0.0, 1.0, 0.0])
    assert unstable.realisation_report()["hankel_singular_values"] is None
