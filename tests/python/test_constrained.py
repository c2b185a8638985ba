"""Least squares with stable poles and known gains; refinement on the free run."""

import numpy as np
import pytest

import gtfdi

MAX_RADIUS = 0.999
# What the field may ask for; the last correction leaves rounding.
GAIN_TOLERANCE = 1e-7


def slow_record(seed, samples=60):
    """A slow oscillation seen through white noise: least squares is often unstable on it."""
    generator = np.random.default_rng(seed)
    u, y = generator.standard_normal(samples), np.zeros(samples)
    angle = generator.uniform(0.02, 0.3)
    for t in range(2, samples):
        y[t] = 2.0 * 0.999 * np.cos(angle) * y[t - 1] - 0.999**2 * y[t - 2]
        y[t] += u[t - 1] - 0.4 * u[t - 2]
    return u, y + 0.5 * generator.standard_normal(samples)


def sums(model):
    """A(1) and B(1)."""
    row = model.regression[0]
    total = {
        name: sum(term["coefficient"] for term in row if term["signal"] == name)
        for name in ("u1", "y1")
    }
    return 1.0 - total["y1"], total["u1"]


def residual_variance(model, u, y):
    error = model.equation_error(u, y)[model.max_lag :]
    return np.mean(error**2)


def radius(model):
    row = [term["coefficient"] for term in model.regression[0] if term["signal"] == "y1"]
    return np.abs(np.roots([1.0, *[-a for a in row]])).max()


@pytest.mark.parametrize(
    "gain", [None, "positive", "negative", 1.5, (-0.5, 2.0)], ids=lambda gain: f"{gain}"
)
def test_prop_constraints_hold_and_cost_little(gain):
    unstable, gains = 0, {} if gain is None else {("y1", "u1"): gain}
    for seed in range(40):
        u, y = slow_record(seed)
        wish = gtfdi.ConstrainedArx(order=4, dc_gains=gains)
        fit = wish.fit(u, y)
        free = gtfdi.arx(u, y, order=4, structure="diag")
        (row,) = fit.rows
        assert row["output"] == "y1"
        # Roots of a polynomial of degree 4 with some close together.
        assert row["least_squares_radius"] == pytest.approx(radius(free), abs=1e-6)
        assert row["radius"] == pytest.approx(radius(fit.model), abs=1e-6)
        assert row["radius"] <= MAX_RADIUS
        unstable += row["least_squares_radius"] > MAX_RADIUS
        a, b = sums(fit.model)
        tolerance = GAIN_TOLERANCE * max(1.0, abs(b))
        if gain == "positive":
            assert b >= -tolerance
        elif gain == "negative":
            assert b <= tolerance
        elif isinstance(gain, float):
            assert abs(b - gain * a) < tolerance
        elif gain is not None:
            assert gain[0] * a - tolerance < b < gain[1] * a + tolerance
        assert row["cost_ratio"] >= 1.0
        if row["reflected_cost_ratio"] is not None:
            assert row["cost_ratio"] <= row["reflected_cost_ratio"]
        # The ratio is that of the equation errors; the tolerance is the regressors' condition.
        ratio = residual_variance(fit.model, u, y) / residual_variance(free, u, y)
        assert row["cost_ratio"] == pytest.approx(ratio, rel=1e-8)
        assert fit.model.standard_errors is None
        if row["active"]:
            assert {key for each in row["active"] for key in each} <= {"stability", "dc_gain"}
    assert unstable >= 3, "some records have to need the constraint"


def test_what_meets_the_constraints_is_least_squares():
    generator = np.random.default_rng(1)
    u, y = generator.standard_normal((400, 2)), np.zeros(400)
    for t in range(1, 400):
        y[t] = 0.7 * y[t - 1] + u[t - 1] @ [1.0, -2.0] + 0.1 * generator.normal()
    data = gtfdi.Dataset(u, y, 0.1, inputs=["a", "b"], outputs="y")
    signs = {("y", "a"): "positive", ("y", "b"): "negative"}
    fit = gtfdi.ConstrainedArx(na=1, nb=1, dc_gains=signs).fit(data)
    free = gtfdi.arx(data, na=1, nb=1, structure="diag")
    assert fit.rows[0]["iterations"] == 0
    assert fit.rows[0]["active"] == []
    for found, expected in zip(fit.model.regression[0], free.regression[0], strict=True):
        assert found["coefficient"] == pytest.approx(expected["coefficient"], abs=1e-9)
    # A wrong sign binds.
    wrong = gtfdi.ConstrainedArx(na=1, nb=1, dc_gains={("y", "b"): "positive"}).fit(data)
    assert wrong.rows[0]["active"] == [{"dc_gain": {"input": "b"}}]
    assert wrong.rows[0]["cost_ratio"] > 10.0, "u explains nearly all of the output"


def test_constrained_refusals():
    u, y = slow_record(1)

    def refused(error, match, **options):
        with pytest.raises(error, match=match):
            gtfdi.ConstrainedArx(**{"order": 2, **options}).fit(u, y)

    refused(
        gtfdi.IdentError,
        "^option max_radius: expected a number above 0 and at most 1, found 1.5$",
        max_radius=1.5,
    )
    refused(
        gtfdi.IdentError,
        "^gain of `u1` on `y1`: expected finite limits with lower <= upper, found 2 and 1$",
        dc_gains={("y1", "u1"): (2.0, 1.0)},
    )
    refused(
        gtfdi.DataError,
        "^channel `z`: not found; there are: y1$",
        dc_gains={("z", "u1"): 1.0},
    )
    refused(
        gtfdi.OptionError,
        '^option dc_gains: expected positive or negative, found "up"$',
        dc_gains={("y1", "u1"): "up"},
    )
    with pytest.raises(
        gtfdi.IdentError,
        match=r"^gain of `u1` on `y1`: expected lags of `u1` \(nb >= 1\), found none$",
    ):
        gtfdi.ConstrainedArx(na=1, nb=0, dc_gains={("y1", "u1"): 1.0}).fit(u, y)


# y = B/A u + noise with poles 0.9 and 0.7, B = 0.5 q + 0.3 q^2.
TRUTH = np.array([1.6, -0.63, 0.5, 0.3])


def output_error_record(seed, samples, deviation=0.5):
    generator = np.random.default_rng(seed)
    u, x = generator.standard_normal(samples), np.zeros(samples)
    for t in range(2, samples):
        x[t] = TRUTH @ [x[t - 1], x[t - 2], u[t - 1], u[t - 2]]
    return u, x + deviation * generator.standard_normal(samples)


def free_run_error(model, u, y):
    error = model.simulate(u, y).y[model.max_lag :, 0] - y[model.max_lag :]
    return np.sqrt(np.mean(error**2))


def test_an_output_error_system_is_recovered_where_least_squares_is_biased():
    train, hold_out = output_error_record(1, 8000), output_error_record(2, 2000)
    start = gtfdi.arx(*train, order=2, structure="diag")
    refined = gtfdi.OutputErrorRefinement().refine(start, train, hold_out)
    (report,) = refined.outputs
    assert report["output"] == "y1"
    assert report["accepted"] is True
    distance = [
        np.linalg.norm([term["coefficient"] for term in model.regression[0]] - TRUTH)
        for model in (start, refined.model)
    ]
    # The bias of least squares at this noise is 0.3 and stays; the refined error falls as
    # 1 / sqrt(N), and is a few per cent of it over ten records of this length.
    assert distance[0] > 0.3
    assert distance[1] < 0.1 * distance[0]
    # The numbers are those of the free runs.
    assert report["train_before"] == pytest.approx(free_run_error(start, *train), rel=1e-9)
    assert report["hold_out_before"] == pytest.approx(free_run_error(start, *hold_out), rel=1e-9)
    after = free_run_error(refined.model, *hold_out)
    assert report["hold_out_after"] == pytest.approx(after, rel=1e-9)
    assert report["hold_out_after"] < report["hold_out_before"]
    assert report["radius"] == pytest.approx(radius(refined.model), abs=1e-9)
    assert refined.model.operating_point["u"] == start.operating_point["u"]


def test_a_row_that_the_hold_out_refuses_stays():
    train, hold_out = output_error_record(3, 40, 2.0), output_error_record(4, 400, 0.0)
    start = gtfdi.arx(*output_error_record(5, 2000, 0.0), order=2, structure="diag")
    refined = gtfdi.OutputErrorRefinement(initial="measured").refine(start, train, hold_out)
    # The start is the truth: forty samples with noise move away from it.
    assert refined.outputs[0]["accepted"] is False
    assert refined.outputs[0]["hold_out_after"] >= refined.outputs[0]["hold_out_before"]
    assert refined.model == start


def test_refinement_refusals():
    train = output_error_record(6, 300)
    start = gtfdi.arx(*train, order=2, structure="diag")
    with pytest.raises(
        gtfdi.OptionError, match='^option initial: expected estimated or measured, found "zero"$'
    ):
        gtfdi.OutputErrorRefinement(initial="zero")
    with pytest.raises(
        gtfdi.IdentError,
        match="^option max_radius: expected a number above 0 and below 1, found 1$",
    ):
        gtfdi.OutputErrorRefinement(max_radius=1.0).refine(start, train, train)
    with pytest.raises(
        gtfdi.IdentError, match="^output `y1`: expected poles within 0.5 before the refinement"
    ):
        gtfdi.OutputErrorRefinement(max_radius=0.5).refine(start, train, train)
    full = gtfdi.arx(*train, order=2, structure="full")
    with pytest.raises(
        gtfdi.IdentError,
        match=r"^output-error refinement: expected a diagonal structure \(own-output lags only\), "
        r"found full na=2 nb=2 nk=1$",
    ):
        gtfdi.OutputErrorRefinement().refine(full, train, train)
