"""Identification."""

import json
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import mirrored

import gtfdi

# The reference's own solvers agree to 1.2e-13; 1e-8 is what the specification asks for.
COEFFICIENT_TOLERANCE = 1e-8
# The reference prints fits with three decimals.
FIT_TOLERANCE_PERCENT = 1e-3


@pytest.mark.parametrize("kind", ["diag", "full"])
@pytest.mark.parametrize("name", ["dryer", "powerplant", "winding", "evaporator"])
def test_published_records_give_the_reference_models(reference_data, name, kind):
    case = json.loads((reference_data / "arx_reference.json").read_text())["arx"][name]
    if kind not in case:
        assert (name, kind) == ("dryer", "full"), "one output: diag and full are the same"
        return
    expected = case[kind]
    with pytest.warns(UserWarning, match="time is counted in samples"):
        data = gtfdi.read(reference_data / case["csv"], inputs=case["u"], outputs=case["y"])
    assert len(data) == case["rows"]
    train, validation = (data[slice(*case[block])] for block in ("train", "val"))
    lags = {"na": case["na"], "nb": case["nb"], "nk": case["nk"], "structure": kind}
    model = gtfdi.arx(train, **lags)
    assert len(model.regression) == len(expected["regression"])
    for found, listed in zip(model.regression, expected["regression"], strict=True):
        listed = {(term["signal"], term["lag"]): term["coefficient"] for term in listed}
        assert {(term["signal"], term["lag"]) for term in found} == set(listed)
        for term in found:
            reference = listed[term["signal"], term["lag"]]
            error = abs(term["coefficient"] - reference) / max(1.0, abs(reference))
            assert error <= COEFFICIENT_TOLERANCE, term
    # Arrays give what the record gives.
    assert gtfdi.arx(train.u, train.y, inputs=case["u"], outputs=case["y"], **lags) == model
    keys = {
        "fit_pred": "fit_prediction_percent",
        "fit_sim": "fit_simulation_percent",
        "ppre_pred": "ppcre_prediction_percent",
        "ppre_sim": "ppcre_simulation_percent",
    }
    scores = model.validate(validation)
    for theirs, ours in keys.items():
        for score, reference in zip(scores, expected[theirs], strict=True):
            if reference is None or abs(reference) > 1e6:
                assert score[ours] is None, "a free run that diverges has no fit"
            else:
                assert score[ours] == pytest.approx(reference, abs=FIT_TOLERANCE_PERCENT)
    variances = model.residual_variance
    assert np.allclose(variances, expected["mse_train"], rtol=1e-8, atol=0.0)


def test_prop_noise_free_records_give_the_system_back(random_record):
    for seed in range(8):
        system, _, _ = random_record(seed, nx=3, nu=2, ny=1)
        excitation = np.random.default_rng(100 + seed).standard_normal((250, 2))
        u, y = mirrored(system.A, system.B, system.C, excitation)
        model = gtfdi.arx(u, y, order=3, sample_time_s=0.1)
        realised = model.state_space()
        # Markov parameters do not depend on the coordinates of the state. The tolerance is rounding
        # times the condition of the regression.
        markov, expected = (each.markov_parameters(10) for each in (realised, system))
        tolerance = 1e-13 * model.condition.max() * np.abs(expected).max()
        assert np.allclose(markov, expected, rtol=0.0, atol=tolerance)
        assert np.allclose(
            np.sort_complex(realised.poles()), np.sort_complex(system.poles()), atol=1e-6
        )
        free = model.simulate(u, y)
        assert not free.diverged
        assert np.allclose(free.y, y, rtol=0.0, atol=tolerance * len(u))


def test_prop_prediction_and_equation_error_are_the_regression(random_record):
    _, u, y = random_record(3, ny=2)
    y = y + np.random.default_rng(4).standard_normal(y.shape)
    model = gtfdi.arx(u, y, na=2, nb=[2, 1], nk=[1, 2], structure="full")
    assert model.structure == {"full": {"na": 2, "nb": [2, 1], "nk": [1, 2]}}
    assert model.max_lag == 2
    point = model.operating_point
    assert np.allclose(point["u"], u.mean(axis=0))
    channels = {name: u[:, i] - point["u"][i] for i, name in enumerate(model.inputs)}
    channels |= {name: y[:, i] - point["y"][i] for i, name in enumerate(model.outputs)}
    expected = np.full_like(y, np.nan)
    for output, row in enumerate(model.regression):
        lagged = [t["coefficient"] * np.roll(channels[t["signal"]], t["lag"]) for t in row]
        expected[2:, output] = (np.sum(lagged, axis=0) + point["y"][output])[2:]
    predicted = model.predict(u, y)
    # Sums of eight products in another order.
    assert np.allclose(predicted, expected, rtol=0.0, atol=1e-12, equal_nan=True)
    assert np.allclose(model.equation_error(u, y), y - predicted, atol=1e-12, equal_nan=True)
    # Normal equations: the error is orthogonal to every regressor.
    score = model.validate(u, y)[0]
    error = (y - predicted)[2:, 0]
    fit = 100.0 * (1.0 - np.linalg.norm(error) / np.linalg.norm(y[2:, 0] - y[2:, 0].mean()))
    assert score["fit_prediction_percent"] == pytest.approx(fit, abs=1e-9)


def test_defaults_are_those_of_the_command_line(random_record):
    _, u, y = random_record(5, ny=2)
    y = y + 0.1 * np.random.default_rng(6).standard_normal(y.shape)
    one = y[:, :1]
    assert gtfdi.arx(u, one, order=3).structure == {"full": {"na": 3, "nb": [3], "nk": [1]}}
    assert gtfdi.arx(u, one, order=3, nk=0).structure == {"full": {"na": 3, "nb": [4], "nk": [0]}}
    canonical = {"canonical": {"indices": [2, 1], "feedthrough": False}}
    assert gtfdi.arx(u, y, order=3).structure == canonical
    assert gtfdi.arx(u, y, indices=[2, 1]).structure == canonical
    assert gtfdi.arx(u, y, indices=[2, 1], nk=0).structure["canonical"]["feedthrough"]
    diagonal = gtfdi.arx(u, y, order=2, structure="diag").structure
    assert diagonal == {"diagonal": {"na": 2, "nb": [2], "nk": [1]}}
    table = gtfdi.order_table(u, one, orders=(1, 6))
    best = table.best["mdl"]
    searched = gtfdi.arx(u, one, order=(1, 6)).structure
    assert searched == {"full": {"na": best, "nb": [best], "nk": [1]}}
    assert gtfdi.Arx(order=3).fit(u, one) == gtfdi.arx(u, one, order=3)


def test_order_table_finds_the_order(random_record):
    _, u, y = random_record(9, nx=3, nu=1, samples=2000)
    generator = np.random.default_rng(10)
    noise, e = 0.05 * y.std() * generator.standard_normal(len(y) + 3), np.zeros(len(y))
    # An ARX record of order 3: the noise passes the system's own denominator.
    system, _, _ = random_record(9, nx=3, nu=1)
    denominator = np.real(np.poly(system.poles()))
    for t in range(len(y)):
        past = sum(denominator[k] * e[t - k] for k in range(1, 4) if t >= k)
        e[t] = noise[t] - past
    table = gtfdi.order_table(u, y + e[:, None], orders=(1, 8))
    assert len(table) == 8
    assert [row["order"] for row in table] == list(range(1, 9))
    assert table.best["mdl"] == 3
    assert table.window_rows == 2000 - 8
    row = table[2]
    t, d = table.window_rows, row["parameters"]
    assert d == 6
    assert row["ln_det"] == pytest.approx(np.log(row["residual_variance"][0]), abs=1e-9)
    assert row["mdl"] == pytest.approx(t * row["ln_det"] + d * np.log(t), rel=1e-12)
    with pytest.raises(IndexError, match="expected an index below 8, found 8"):
        table[8]


def test_memory_layout_does_not_matter(random_record):
    _, u, y = random_record(11)
    y = y + 0.1 * np.random.default_rng(12).standard_normal(y.shape)
    expected = gtfdi.arx(u, y, order=4)
    wide = np.zeros((2 * len(u), 5))
    wide[::2, [0, 3]] = u
    for other in (np.asfortranarray(u), wide[::2, ::3], u.tolist()):
        assert gtfdi.arx(other, y[:, 0], order=4) == expected


def test_names_are_found_in_a_larger_record(healthy, model):
    measured = healthy.measured
    narrow = measured.select(["a_v", "M_f"], ["q_c"])
    assert np.array_equal(model.predict(measured), model.predict(narrow), equal_nan=True)
    arrays = model.predict(narrow.u, narrow.y)
    assert np.array_equal(arrays, model.predict(narrow), equal_nan=True)
    assert np.array_equal(model.predict((narrow.u, narrow.y)), arrays, equal_nan=True)
    assert model.sample_time_s == 0.08


def test_models_pickle_and_keep_files(model, tmp_path):
    path = tmp_path / "model.json"
    model.save(path)
    assert json.loads(path.read_text())["kind"] == "arx"
    for copy in (gtfdi.ArxModel.load(path), pickle.loads(pickle.dumps(model))):
        assert copy == model
        assert copy.regression == model.regression
    with pytest.raises(gtfdi.LogError, match="there is no such file"):
        gtfdi.ArxModel.load(tmp_path / "none.json")
    path.write_text("{}")
    with pytest.raises(gtfdi.LogError, match="missing field"):
        gtfdi.ArxModel.load(path)
    with pytest.raises(gtfdi.LogError, match="ARX model: "):
        gtfdi.ArxModel.from_json("[]")


def test_a_diverging_free_run_is_said_to(random_record):
    generator = np.random.default_rng(13)
    u = generator.standard_normal((400, 1))
    y = np.zeros((400, 1))
    for t in range(1, 400):
        y[t] = 1.02 * y[t - 1] + u[t - 1] + 0.01 * generator.standard_normal()
    # The fit takes the means off an explosive record; its first 100 samples hardly have any.
    model = gtfdi.arx(u[:100], y[:100], na=1, nb=1)
    model_run = model.simulate(np.ones((2000, 1)), np.zeros((2000, 1)))
    assert model_run.diverged
    (sample,) = model_run.diverges_at
    assert np.isfinite(model_run.y[:sample]).all()
    assert np.isnan(model_run.y[sample:]).all()


def test_threads_give_the_same_models(random_record):
    # The lock on the interpreter is released in a fit: several run at once on one record.
    _, u, y = random_record(16, samples=3000)
    y = y + np.random.default_rng(17).standard_normal(y.shape)
    expected = gtfdi.arx(u, y, order=4, structure="diag")
    with ThreadPoolExecutor(4) as pool:
        jobs = [pool.submit(gtfdi.arx, u, y, order=4, structure="diag") for _ in range(8)]
        assert all(job.result() == expected for job in jobs)


def test_refusals_of_options(random_record):
    _, u, y = random_record(14)
    for order in (0, -1, (0, 3), (4, 3), "best"):
        with pytest.raises(gtfdi.OptionError, match="^option order: expected a number from 1"):
            gtfdi.arx(u, y, order=order)
    with pytest.raises(gtfdi.OptionError, match="^option order: expected one of .*found several"):
        gtfdi.arx(u, y, order=2, na=2, nb=2)
    with pytest.raises(gtfdi.OptionError, match="^option order: .*found none of them"):
        gtfdi.arx(u, y)
    with pytest.raises(TypeError, match='order.*int | tuple of two int | "auto"'):
        gtfdi.arx(u, y, order=2.5)
    with pytest.raises(gtfdi.OptionError, match="^option structure: .*found na and nb$"):
        gtfdi.arx(u, y, na=2, nb=2, structure="canonical")
    with pytest.raises(gtfdi.OptionError, match="^option structure: .*found full or diag$"):
        gtfdi.arx(u, y, indices=[2], structure="full")
    with pytest.raises(gtfdi.OptionError, match="^option nk: "):
        gtfdi.arx(u, y, order=2, nk=3, structure="canonical")
    with pytest.raises(gtfdi.OptionError, match='^option structure: .*found "fir"'):
        gtfdi.arx(u, y, order=2, structure="fir")
    with pytest.raises(gtfdi.OptionError, match="^option nb: "):
        gtfdi.arx(u, y, na=2)
    with pytest.raises(gtfdi.OptionError, match="^option y: .*found ndarray alone"):
        gtfdi.arx(u, order=2)
    with pytest.raises(gtfdi.OptionError, match="^option sample_time_s: "):
        gtfdi.arx(gtfdi.Dataset(u, y, 1.0), order=2, sample_time_s=1.0)
    with pytest.raises(gtfdi.IdentError, match="^option nb: expected 1 entry or 2 .*found 3"):
        gtfdi.arx(u, y, na=1, nb=[1, 1, 1])
    with pytest.raises(gtfdi.IdentError, match="^order: expected at least 2"):
        gtfdi.arx(u, np.hstack([y, y]), order=1)


def test_refusals_of_records(random_record):
    _, u, y = random_record(15)
    broken = y.copy()
    broken[7] = np.nan
    with pytest.raises(
        gtfdi.DataError, match="^channel `y1`, sample 7: expected a finite number, found NaN$"
    ):
        gtfdi.arx(u, broken, order=2)
    with pytest.raises(gtfdi.DimensionError, match="^columns of y .*: expected 400, found 399$"):
        gtfdi.arx(u, y[1:], order=2)
    with pytest.raises(gtfdi.ArrayTypeError, match="^y: .*found dtype object"):
        gtfdi.arx(u, y.astype(object), order=2)
    with pytest.raises(gtfdi.IdentError, match="^samples: expected at least 9 for full"):
        gtfdi.arx(u[:8], y[:8], order=2)
    with pytest.raises(gtfdi.IdentError, match="^channel `u1`: expected a signal that varies"):
        gtfdi.arx(u * 0.0, y, order=2)
    with pytest.raises(gtfdi.IdentError, match="expected independent regressors"):
        gtfdi.arx(np.hstack([u, u]), y, order=2)
    model = gtfdi.arx(u, y, order=2)
    with pytest.raises(gtfdi.DimensionError, match="^rows of u .*: expected 2, found 1$"):
        model.predict(u[:, :1], y)
    with pytest.raises(gtfdi.IdentError, match="^sample time: expected 1 s .*found 0.5 s"):
        model.predict(gtfdi.Dataset(u, y, 0.5))
    with pytest.raises(gtfdi.IdentError, match="^output 3: expected an index below 1"):
        model.output_model(3)
    with pytest.raises(gtfdi.DataError, match="^channel `z`: not found; there are: y1$"):
        model.output_model("z")
