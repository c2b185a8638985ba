"""Least squares with options: several records, gaps, ridge, centre, correlated errors, solvers."""

import json
import pickle

import numpy as np
import pytest
from conftest import free_response

import gtfdi

# Sums in another order, times the condition of these regressors, which is below 100.
ROUNDING = 1e-10


def arx_record(samples, seed, offset=0.0):
    """y(t) = 1.2 y(t-1) - 0.5 y(t-2) + 0.8 u(t-1) + 0.3 u(t-2) + e(t)."""
    generator = np.random.default_rng(seed)
    u, e = generator.standard_normal(samples), 0.1 * generator.standard_normal(samples)
    y = np.zeros(samples)
    for t in range(2, samples):
        y[t] = 1.2 * y[t - 1] - 0.5 * y[t - 2] + 0.8 * u[t - 1] + 0.3 * u[t - 2] + e[t]
    return gtfdi.Dataset(u + offset, y + offset, 0.1)


TRUTH = np.array([1.2, -0.5, 0.8, 0.3])


def coefficients(model, output=0):
    return np.array([term["coefficient"] for term in model.regression[output]])


def regressors(data, point, first=2):
    """The regressors and targets of order 2, written out, as deviations from `point`."""
    u, y = data.u[:, 0] - point["u"][0], data.y[:, 0] - point["y"][0]
    rows = range(first, len(u))
    phi = np.array([[y[t - 1], y[t - 2], u[t - 1], u[t - 2]] for t in rows])
    return phi, y[first:]


def test_several_records_are_one_least_squares_problem():
    records = [arx_record(300, 1, 5.0), arx_record(150, 2, 5.0), arx_record(40, 3, 5.0)]
    model = gtfdi.arx(records, order=2)
    assert model.rows_used == 298 + 148 + 38
    # The point is the mean of all samples; no row reaches from one record into another.
    point = model.operating_point
    assert point["u"][0] == pytest.approx(np.concatenate([r.u for r in records]).mean(), abs=1e-12)
    parts = [regressors(record, point) for record in records]
    phi, target = (
        np.vstack([part[0] for part in parts]),
        np.concatenate([part[1] for part in parts]),
    )
    expected, squares, _, _ = np.linalg.lstsq(phi, target, rcond=None)
    assert np.allclose(coefficients(model), expected, rtol=0.0, atol=ROUNDING)
    assert model.residual_variance[0] == pytest.approx(squares[0] / len(target), rel=1e-9)
    variance = squares[0] / (len(target) - 4)
    fit = gtfdi.Arx(order=2).fit_in_full(records)
    assert fit.model == model
    covariance = variance * np.linalg.inv(phi.T @ phi)
    assert np.allclose(fit.covariance[0], covariance, rtol=1e-8, atol=0.0)
    assert np.allclose(model.standard_errors[0], np.sqrt(np.diag(covariance)), rtol=1e-8)
    # Five standard errors: one of a million.
    assert (np.abs(coefficients(model) - TRUTH) < 5.0 * model.standard_errors[0]).all()
    tuples = [(record.u, record.y) for record in records]
    assert gtfdi.arx(tuples, order=2, sample_time_s=0.1) == model
    assert gtfdi.arx(records[:1], order=2) == gtfdi.arx(records[0], order=2)


def test_gaps_break_a_record():
    whole = arx_record(400, 4)
    y = whole.y.copy()
    y[200] = np.nan
    gap = gtfdi.Dataset(whole.u, y, 0.1)
    with pytest.raises(gtfdi.DataError, match="sample 200: expected a finite number, found NaN$"):
        gtfdi.arx(gap, order=2)
    broken = gtfdi.arx(gap, order=2, missing="break")
    assert broken.rows_used == 198 + 197
    parts = gtfdi.arx([whole[:200], whole[201:]], order=2)
    assert np.allclose(coefficients(broken), coefficients(parts), rtol=0.0, atol=ROUNDING)


def test_centre_is_what_is_subtracted():
    data = arx_record(300, 5, 5.0)
    zero = gtfdi.arx(data, order=2, centre="zero")
    assert np.array_equal(zero.operating_point["u"], [0.0])
    known = gtfdi.arx(data, order=2, centre=([5.0], [5.0]))
    assert np.array_equal(known.operating_point["y"], [5.0])
    for model in (zero, known):
        phi, target = regressors(data, model.operating_point)
        expected = np.linalg.lstsq(phi, target, rcond=None)[0]
        assert np.allclose(coefficients(model), expected, rtol=0.0, atol=ROUNDING)
    assert gtfdi.arx(data, order=2, centre="means") == gtfdi.arx(data, order=2)


def test_first_row_and_ridge():
    data = arx_record(300, 6)
    late = gtfdi.arx(data, order=2, first_row=50)
    assert late.rows_used == 250
    phi, target = regressors(data, late.operating_point, first=50)
    expected = np.linalg.lstsq(phi, target, rcond=None)[0]
    assert np.allclose(coefficients(late), expected, rtol=0.0, atol=ROUNDING)
    # The penalty is ridge times the squared norm of each regressor.
    ridge = gtfdi.arx(data, order=2, ridge=0.5)
    phi, target = regressors(data, ridge.operating_point)
    normal = phi.T @ phi
    normal += 0.5 * np.diag(np.diag(normal))
    expected = np.linalg.solve(normal, phi.T @ target)
    assert np.allclose(coefficients(ridge), expected, rtol=0.0, atol=ROUNDING)


def correlated_errors(samples, seed):
    """White errors of two outputs with deviation 0.5 and a correlation of 0.8."""
    e = np.random.default_rng(seed).standard_normal((samples, 2))
    e[:, 1] = 0.8 * e[:, 0] + 0.6 * e[:, 1]
    return 0.5 * e


def test_correlated_errors_bias_rows_with_another_output_at_lag_0():
    u, e = np.random.default_rng(7).standard_normal((20000, 1)), correlated_errors(20000, 8)
    truth = [np.array([0.9, -0.3, 0.2, 1.0, 0.5]), np.array([0.4, -0.2, 0.6, 0.7])]
    y = np.zeros((20000, 2))
    for t in range(2, 20000):
        past = [y[t - 1, 0], y[t - 2, 0], y[t - 2, 1], u[t - 1, 0], u[t - 2, 0]]
        y[t, 0] = truth[0] @ past + e[t, 0]
        y[t, 1] = truth[1] @ [y[t, 0], y[t - 1, 0], y[t - 1, 1], u[t - 1, 0]] + e[t, 1]
    wish = {"indices": [2, 1]}
    alone = gtfdi.arx(u, y, **wish)
    joint = gtfdi.Arx(**wish, equation_errors="correlated").fit_in_full(u, y)
    assert joint.solved_by == ["joint", "joint"]
    row = [(term["signal"], term["lag"]) for term in joint.model.regression[1]]
    assert row == [("y1", 0), ("y1", 1), ("y2", 1), ("u1", 1)]
    for output in range(2):
        limit = 5.0 * joint.model.standard_errors[output]
        assert (np.abs(coefficients(joint.model, output) - truth[output]) < limit).all()
    # The coefficient of y1(t) is off by cov(e1, e2) over the variance of what the row's other terms
    # leave of y1(t), however long the record; the tolerance is five standard errors.
    others = np.column_stack([y[1:-1, 0], y[1:-1, 1], u[1:-1, 0]])
    left = y[2:, 0] - others @ np.linalg.lstsq(others, y[2:, 0], rcond=None)[0]
    bias = 0.8 * 0.5**2 / np.var(left)
    assert bias > 0.4
    limit = 5.0 * alone.standard_errors[1][0]
    assert coefficients(alone, 1)[0] == pytest.approx(0.4 + bias, abs=limit)


def test_solvers_agree():
    data = arx_record(4000, 13)
    quick = gtfdi.Arx(order=2, solver="automatic").fit_in_full(data)
    assert quick.solved_by == ["refinement"]
    exact = gtfdi.Arx(order=2).fit_in_full(data)
    assert exact.solved_by == ["qr"]
    assert np.allclose(
        coefficients(quick.model), coefficients(exact.model), rtol=0.0, atol=ROUNDING
    )


def test_fits_pickle_and_are_checked():
    data = arx_record(300, 8)
    fit = gtfdi.Arx(order=2).fit_in_full(data)
    copy = pickle.loads(pickle.dumps(fit))
    assert copy == fit
    assert copy.solved_by == ["qr"]
    assert gtfdi.ArxFit(fit.model, fit.covariance, ["qr"]) == fit
    assert gtfdi.ArxFit(fit.model, fit.covariance).solved_by is None
    # From the record again: another factorisation of the same regressors.
    again = gtfdi.ArxFit.from_record(fit.model, data)
    assert again.solved_by is None
    assert np.allclose(again.covariance[0], fit.covariance[0], rtol=1e-9, atol=0.0)
    with pytest.raises(
        gtfdi.DimensionError, match=r"^covariances \(one per output\): expected 1, found 0$"
    ):
        gtfdi.ArxFit(fit.model, [])
    with pytest.raises(
        gtfdi.DimensionError,
        match=r"^rows of covariance 0 \(coefficients of the row\): expected 4, found 3$",
    ):
        gtfdi.ArxFit(fit.model, [np.eye(3)])
    with pytest.raises(
        gtfdi.IdentError,
        match="^covariance 0: expected finite numbers, none below 0 on the diagonal, found -1$",
    ):
        gtfdi.ArxFit(fit.model, [-np.eye(4)])
    with pytest.raises(
        gtfdi.OptionError,
        match='^option solved_by: expected qr, refinement or joint, found "lu"$',
    ):
        gtfdi.ArxFit(fit.model, fit.covariance, ["lu"])
    with pytest.raises(gtfdi.DimensionError, match="^entries of solved_by: expected 1, found 2$"):
        gtfdi.ArxFit(fit.model, fit.covariance, ["qr", "qr"])
    # A file of an older version has no standard errors.
    text = json.loads(fit.model.to_json())
    del text["standard_errors"]
    assert gtfdi.ArxModel.from_json(json.dumps(text)).standard_errors is None


def test_an_automatic_order_looks_as_far_as_the_record_bears():
    # Order n needs n + 2 n + 1 rows.
    short = arx_record(28, 9)
    with pytest.warns(UserWarning) as issued:
        model = gtfdi.arx(short, order="auto")
    text = '28 rows bear no order above 9: order="auto" looked at 1 to 9'
    assert [str(warning.message) for warning in issued] == [text]
    assert model == gtfdi.arx(short, order=(1, 9))


def test_index_table_finds_the_indices():
    # Indices (1, 2) are not generic for order 3: the first output has a state of its own.
    a = np.array([[0.6, 0.0, 0.0], [0.0, 0.0, 1.0], [0.3, -0.4, 1.1]])
    b, c = np.array([[1.0], [0.5], [0.8]]), np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    generator = np.random.default_rng(11)
    u = generator.standard_normal((3000, 1))
    y = free_response(a, b, c, u) + 1e-3 * generator.standard_normal((3000, 2))
    table = gtfdi.index_table(u, y, orders=(2, 3), spread=1)
    assert sorted(row["indices"] for row in table) == [[1, 1], [1, 2], [2, 1]]
    assert len(table) == 3
    # Each set's criteria are those of its own fit on the window that all share.
    for row in table:
        model = gtfdi.arx(u, y, indices=row["indices"], first_row=2)
        assert model.rows_used == table.window_rows == 2998
        parameters = sum(len(terms) for terms in model.regression)
        assert row["parameters"] == parameters
        error = model.equation_error(u, y)[2:]
        ln_det = np.log(np.linalg.det(error.T @ error / len(error)))
        assert row["ln_det"] == pytest.approx(ln_det, abs=1e-8)
        assert row["mdl"] == pytest.approx(2998 * ln_det + parameters * np.log(2998), rel=1e-8)
    best = min(table, key=lambda row: row["mdl"])
    assert table.best["mdl"] == best
    with pytest.raises(IndexError, match="^row of the index table: .* below 3, found 7$"):
        table[7]
    with pytest.raises(gtfdi.IdentError, match="^index sets: expected at most 5000 within 60"):
        gtfdi.index_table(u, np.tile(y, 2), orders=(240, 240), spread=60)


def test_refusals():
    data = arx_record(300, 10)

    def refused(error, match, record=data, **options):
        with pytest.raises(error, match=match):
            gtfdi.arx(record, order=options.pop("order", 2), **options)

    refused(
        gtfdi.OptionError,
        '^option missing: expected refuse or break, found "skip"$',
        missing="skip",
    )
    refused(
        gtfdi.OptionError,
        r'^option centre: expected means, zero or a tuple \(u, y\), found "median"$',
        centre="median",
    )
    refused(
        gtfdi.DimensionError,
        "^inputs of the operating point: expected 1, found 2$",
        centre=([1.0, 2.0], [0.0]),
    )
    refused(
        gtfdi.OptionError,
        '^option equation_errors: expected uncorrelated or correlated, found "white"$',
        equation_errors="white",
    )
    refused(gtfdi.OptionError, '^option solver: expected qr or automatic, found "lu"$', solver="lu")
    refused(
        gtfdi.IdentError,
        "^option ridge: expected a finite number of at least 0, found -1$",
        ridge=-1.0,
    )
    refused(
        gtfdi.IdentError,
        "^option ridge: expected 0 with correlated equation errors, found 1$",
        ridge=1.0,
        equation_errors="correlated",
    )
    refused(gtfdi.IdentError, "^records: expected at least 1, found none$", record=[])
    for order in ((1, 3), "auto"):
        refused(
            gtfdi.OptionError,
            "^option order: expected a number with several records: orders are compared on one, "
            "found a search$",
            record=[data, data],
            order=order,
        )
    slower = gtfdi.Dataset(data.u, data.y, 0.2)
    refused(gtfdi.IdentError, "^sample time: expected 0.1 s .*found 0.2 s$", record=[data, slower])
    refused(gtfdi.OptionError, "^option y: .*found ndarray alone$", record=[data.u])
