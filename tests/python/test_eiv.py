"""Errors-in-variables models: noise on the inputs too."""

import json
import pickle
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import gtfdi

# In bounds: the same likelihood was minimised by another optimiser to another tolerance.
ESTIMATE_TOLERANCE = 1e-3
# In standard errors of the estimate: one of a million normal numbers is further away.
STANDARD_ERRORS = 5.0
TRUTH = np.array([1.5, -0.7, 1.0, 0.5])
NOISE = {"u": 0.03, "y": 4.0 / 3.0}


def noisy_record(samples, seed=7):
    """A second-order system with a coloured input, white noise on both channels."""
    generator = np.random.default_rng(seed)
    u, y = np.zeros(samples + 2), np.zeros(samples + 2)
    for t in range(2, samples + 2):
        u[t] = 0.6 * u[t - 1] + generator.normal()
        y[t] = TRUTH @ [y[t - 1], y[t - 2], u[t - 1], u[t - 2]]
    u = 10.0 + u[2:] + np.sqrt(NOISE["u"]) * generator.standard_normal(samples)
    y = 50.0 + y[2:] + np.sqrt(NOISE["y"]) * generator.standard_normal(samples)
    return gtfdi.Dataset(u, y, 0.5, inputs="u", outputs="y")


@pytest.fixture(scope="module")
def record():
    return noisy_record(4000)


@pytest.fixture(scope="module")
def found(record):
    return gtfdi.eiv(record, order=2)


def coefficients(model, output=0):
    return np.array([term["coefficient"] for term in model.regression[output]])


def estimates(model, inputs):
    """Coefficients and variances in the order of the vectors: a, b, noise of y, noise of u."""
    (row,) = model.relation.regression
    terms = {(term["signal"], term["lag"]): term["coefficient"] for term in row}
    found = [-terms["y1", 1], -terms["y1", 2]]
    found += [terms[f"u{1 + k // 2}", 1 + k % 2] for k in range(2 * inputs)]
    return found + [model.noise_variances[tag] for tag in ("y1", "u1", "u2")[: 1 + inputs]]


@pytest.mark.parametrize(("name", "inputs"), [("eiv_S1_snr20.json", 1), ("eiv_M1_snr10.json", 2)])
def test_published_vectors_give_the_reference_estimates(vectors, name, inputs):
    vector = vectors(name)
    u, y = np.array(vector["data"]["u"]), np.array(vector["data"]["y"])
    assert u.shape == (500, inputs)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a variance that 500 samples do not tell
        model = gtfdi.eiv(u, y, order=2, autoregression_order=30)
    bound = np.array(vector["crlb_std_semi_N500"])
    error = np.abs(np.array(estimates(model, inputs)) - vector["results"]["PWML_p30_K256"])
    assert (error < ESTIMATE_TOLERANCE * bound).all()


@pytest.mark.parametrize(("name", "inputs"), [("eiv_S1_snr20.json", 1), ("eiv_M1_snr10.json", 2)])
@pytest.mark.parametrize(("criterion", "listed"), [("shift", "F-SR"), ("yule-walker", "F-YW")])
@pytest.mark.filterwarnings("ignore:the record does not tell the noise of")
def test_published_vectors_give_the_reference_frisch_estimates(
    vectors, name, inputs, criterion, listed
):
    # The reference took raw samples, another scaling and a grid that ends before the boundary:
    # coefficients agree to one bound, variances to two (the estimates' own deviations are 2 to 4).
    vector = vectors(name)
    u, y = np.array(vector["data"]["u"]), np.array(vector["data"]["y"])
    model = gtfdi.frisch(u, y, order=2, criterion=criterion)
    error = np.abs(np.array(estimates(model, inputs)) - vector["results"][listed])
    error /= vector["crlb_std_semi_N500"]
    assert (error[: 2 + 2 * inputs] < 1.0).all()
    assert (error[2 + 2 * inputs :] < 2.0).all()


def test_the_order_table_of_covariances():
    record = noisy_record(4000)
    table = gtfdi.frisch_order_table(record, orders=(1, 4))
    assert table.best == 2
    assert len(table) == 4
    assert table.window_rows == 4000 - 4 - 5
    assert [row["order"] for row in table] == [1, 2, 3, 4]
    for row in table:
        # Two channels at the lags 0 to 9, less coefficients and variances.
        assert row["degrees_of_freedom"] == 2 * 10 - (2 * row["order"] + 2)
        if row["statistic"] is not None:
            penalty = row["degrees_of_freedom"] * np.log(table.window_rows)
            assert row["selection"] == pytest.approx(row["statistic"] - penalty, rel=1e-12)
    low, true = table[0], table[1]
    for key in ("surface_gap", "yule_walker", "rank_ratio"):
        assert true[key] < 0.1 * low[key], key
    # A chi-square variable: five deviations.
    freedom = true["degrees_of_freedom"]
    assert abs(true["statistic"] - freedom) < 5.0 * np.sqrt(2.0 * freedom)
    both = gtfdi.Dataset(record.u, np.hstack([record.u**2, record.y]), 0.5, outputs=["v", "y"])
    assert gtfdi.frisch_order_table(both, orders=(1, 4), output="y") == table
    assert gtfdi.frisch_order_table(both, orders=(1, 4), output=1) == table
    with pytest.raises(gtfdi.DataError, match="^channel `z`: not found; there are: v, y$"):
        gtfdi.frisch_order_table(both, output="z")
    with pytest.raises(gtfdi.IdentError, match="^output 2: expected an index below 2$"):
        gtfdi.frisch_order_table(both, output=2)


# The shift relation looks at one lag more than the order: the variance of u is not told.
@pytest.mark.filterwarnings("ignore:the record does not tell the noise of `u`")
def test_the_noise_of_every_channel_is_found_and_the_bias_is_gone(record, found):
    biased = np.abs(coefficients(gtfdi.arx(record, order=2)) - TRUTH).max()
    assert biased > 0.1, "100 to 200 standard deviations of the best estimate"
    assert found.kind == "eiv"
    relation = found.relation
    signals = [(term["signal"], term["lag"]) for term in relation.regression[0]]
    assert signals == [("y", 1), ("y", 2), ("u", 1), ("u", 2)]
    (errors,) = found.standard_errors
    assert (errors > 0.0).all()
    assert (errors < 0.04).all()
    assert (np.abs(coefficients(relation) - TRUTH) < STANDARD_ERRORS * errors).all()
    for tag, truth in NOISE.items():
        noise = found.noise[tag]
        assert abs(noise["variance"] - truth) < STANDARD_ERRORS * noise["standard_error"]
        assert noise["identifiable"] is True
        assert noise["at_limit"] is False
        assert found.noise_variances[tag] == noise["variance"]
    assert list(found.noise) == ["y", "u"], "outputs first"
    assert found.order_table is None
    assert (found.inputs, found.outputs, found.sample_time_s) == (["u"], ["y"], 0.5)
    assert np.allclose(relation.operating_point["u"], record.u.mean(axis=0))
    for criterion in ("shift", "covariance", "yule-walker"):
        model = gtfdi.frisch(record, order=2, criterion=criterion)
        # Up to five times the bound, for the criteria.
        assert np.abs(coefficients(model.relation) - TRUTH).max() < 0.25 * biased, criterion
        assert model.kind == "frisch"
        assert model.standard_errors is None
    assert gtfdi.frisch(record, order=2) == model, "yule-walker is the default"
    assert gtfdi.frisch(record, order=2, criterion="shift") != model


def test_arguments_are_those_of_arx(record, found):
    assert (
        gtfdi.eiv(record.u, record.y, order=2, sample_time_s=0.5, inputs="u", outputs="y") == found
    )
    assert gtfdi.eiv((record.u, record.y), order=2) != found, "names and sample time are others"
    other = gtfdi.Dataset(
        np.hstack([record.u, record.u**2]), record.y, 0.5, inputs=["u", "v"], outputs="y"
    )
    assert gtfdi.eiv(other, order=2, inputs="u") == found
    direct = gtfdi.eiv(record, order=2, nk=0).relation
    assert direct.structure == {"diagonal": {"na": 2, "nb": [3], "nk": [0]}}
    # The direct term is zero in truth.
    direct_term = direct.regression[0][2]
    assert (direct_term["signal"], direct_term["lag"]) == ("u", 0)
    limit = STANDARD_ERRORS * direct.standard_errors[0][2]
    assert abs(direct_term["coefficient"]) < limit


def test_outputs_share_the_noise_of_their_inputs():
    generator = np.random.default_rng(8)
    u, first, second = np.zeros((3, 4000))
    for t in range(2, 4000):
        u[t] = 0.6 * u[t - 1] + generator.normal()
        first[t] = TRUTH @ [first[t - 1], first[t - 2], u[t - 1], u[t - 2]]
        second[t] = 0.9 * second[t - 1] - 0.3 * second[t - 2] + 0.8 * u[t - 1] - 0.4 * u[t - 2]
    noisy = [
        values + np.sqrt(variance) * generator.standard_normal(len(u))
        for values, variance in [(u, 0.1), (first, 1.0), (second, 0.2)]
    ]
    model = gtfdi.eiv(noisy[0], np.column_stack(noisy[1:]), order=2)
    assert list(model.noise) == ["y1", "y2", "u1"]
    for tag, truth in [("y1", 1.0), ("y2", 0.2), ("u1", 0.1)]:
        noise = model.noise[tag]
        assert abs(noise["variance"] - truth) < STANDARD_ERRORS * noise["standard_error"]
    found = coefficients(model.relation, 1)
    assert (
        np.abs(found - [0.9, -0.3, 0.8, -0.4]) < STANDARD_ERRORS * model.standard_errors[1]
    ).all()


@pytest.mark.parametrize("fit", [gtfdi.eiv, gtfdi.frisch])
def test_the_order_is_found_by_the_likelihood(fit):
    record = noisy_record(2000)
    model = fit(record, order=(1, 4))
    assert model.relation.structure["diagonal"]["na"] == 2
    table = model.order_table
    assert table == gtfdi.eiv_order_table(record, orders=(1, 4))
    assert table.best["bic"] == 2
    assert [row["order"] for row in table] == [1, 2, 3, 4]
    assert len(table) == 4
    row = table[2]
    assert row["parameters"] == 6
    assert row["bic"] == pytest.approx(2000 * row["criterion"] + 6 * np.log(2000), rel=1e-12)
    assert row["aic"] == pytest.approx(2000 * row["criterion"] + 12, rel=1e-12)
    with pytest.raises(IndexError, match="^row of the order table: .* below 4, found 4$"):
        table[4]
    automatic = fit(record, order="auto")
    assert len(automatic.order_table) == 6
    assert automatic.relation.max_lag == 2


def test_what_a_user_should_know_is_a_warning():
    short = noisy_record(36)
    with pytest.warns(UserWarning) as issued:
        model = gtfdi.eiv(short, order="auto")
    texts = [str(warning.message) for warning in issued]
    highest = model.order_table[len(model.order_table) - 1]["order"]
    assert highest < 6
    assert texts[0] == f"36 rows bear no order above {highest}: the search looked no further"
    assert "36 rows are few for this model: the standard errors promise too much" in texts
    # Every variance that is not told has its warning, and no other one has.
    untold = {tag for tag, noise in model.noise.items() if noise["identifiable"] is False}
    warned = {text.split("`")[1] for text in texts if "does not tell the noise of" in text}
    assert warned == untold


def test_models_pickle_and_keep_files(record, found, tmp_path):
    path = tmp_path / "model.json"
    found.save(path)
    file = json.loads(path.read_text())
    # The keys of the file that the command line writes.
    assert file["kind"] == "eiv"
    assert file["noise"]["inputs"][0]["variance"] == found.noise_variances["u"]
    searched = gtfdi.frisch(record, order=(2, 3))
    for model in (found, searched):
        pickled = pickle.loads(pickle.dumps(model))
        plain = gtfdi.EivModel.from_json(model.to_json())
        for copy in (pickled, plain):
            assert copy == model
            assert copy.kind == model.kind
            assert copy.noise == model.noise
            assert copy.relation == model.relation
        # A pickle keeps what the orders were compared by, a file does not.
        assert pickled.order_table == model.order_table
        assert plain.order_table is None
    assert gtfdi.EivModel.load(path) == found
    assert gtfdi.EivModel.from_json(path.read_text()) == found
    # Whatever takes an ARX model takes the relation.
    assert gtfdi.ArxModel.load(path) == found.relation
    found.relation.save(path)
    with pytest.raises(gtfdi.LogError) as error:
        gtfdi.EivModel.load(path)
    expected = "expected an errors-in-variables model (kind eiv or frisch), found kind arx"
    assert str(error.value) == f"{path}: {expected}"
    with pytest.raises(gtfdi.LogError) as error:
        gtfdi.EivModel.from_json(path.read_text())
    assert str(error.value) == f"errors-in-variables model: {expected}"
    file["noise"]["inputs"][0]["variance"] *= 2.0
    with pytest.raises(gtfdi.LogError, match="the file was changed after it was written"):
        gtfdi.EivModel.from_json(json.dumps(file))
    with pytest.raises(gtfdi.LogError, match="there is no such file"):
        gtfdi.EivModel.load(tmp_path / "none.json")


def test_a_bank_is_designed_for_the_relation(record, found):
    options = {"poles": 0.3, "margin": 1.2, "consecutive": 2}
    bank = gtfdi.design(found, [record], **options)
    assert bank == gtfdi.design(found.relation, [record], **options)
    assert bank.outputs == ["y"]
    with pytest.raises(TypeError, match="ArxModel | EivModel"):
        gtfdi.design(found.relation.state_space(), [record])


def test_threads_give_the_same_models(record, found):
    # The lock on the interpreter is released in a fit: several run at once on one record.
    with ThreadPoolExecutor(4) as pool:
        jobs = [pool.submit(gtfdi.eiv, record, order=2) for _ in range(8)]
        assert all(job.result() == found for job in jobs)


def test_refusals(record):
    def refused(error, match, *, fit=gtfdi.eiv, data=record, **options):
        with pytest.raises(error, match=match):
            fit(data, **options)

    refused(TypeError, "missing 1 required keyword argument: 'order'")
    for order in (0, (3, 2), "best"):
        refused(
            gtfdi.OptionError,
            r'^option order: expected a number from 1, a pair such as \(1, 12\), or "auto", found',
            order=order,
        )
    late = "^option nk, input 0: expected at most the order, 2, found 3$"
    refused(gtfdi.IdentError, late, order=2, nk=3)
    refused(gtfdi.IdentError, late, fit=gtfdi.frisch, order=2, nk=3)
    refused(
        gtfdi.OptionError,
        '^option criterion: expected shift, covariance or yule-walker, found "mean"$',
        fit=gtfdi.frisch,
        order=2,
        criterion="mean",
    )
    refused(TypeError, "unexpected keyword argument 'criterion'", order=2, criterion="shift")
    refused(ValueError, "zero", order=2, autoregression_order=0)
    refused(
        gtfdi.IdentError,
        "^option pole_prior: expected a finite number of at least 0, found -1$",
        order=2,
        pole_prior=-1.0,
    )
    refused(
        gtfdi.IdentError,
        "^samples: expected at least 123 for the autoregression, found 100$",
        data=record[:100],
        order=20,
    )
    refused(gtfdi.DimensionError, "^inputs of .*: expected 1, found 2$", order=2, nk=[1, 1])
    exact = gtfdi.Dataset(record.u, 2.0 * record.u, 1.0)
    refused(gtfdi.IdentError, "determine it$", data=exact, order=2, nk=0)
    broken = record.y.copy()
    broken[7] = np.nan
    refused(
        gtfdi.DataError,
        "^channel `y1`, sample 7: expected a finite number, found NaN$",
        data=(record.u, broken),
        order=2,
    )
