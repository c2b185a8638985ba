"""Models along a load."""

import pickle

import numpy as np
import pytest

import gtfdi

# Rounding times the condition of the regressors.
ROUNDING = 1e-8


def varying(seed, load, coefficients):
    """y(t) = a(s) y(t-1) + b(s) u(t-1) + c(s) with the load s(t); u2 is the load."""
    generator = np.random.default_rng(seed)
    drive, y = generator.standard_normal(len(load)), np.zeros(len(load))
    for t, s in enumerate(load):
        a, b, c = coefficients(s)
        y[t] = a * y[t - 1] + b * drive[t - 1] + c if t else c / (1.0 - a)
    return gtfdi.Dataset(np.column_stack([drive, load]), y, 0.5)


def linear(s):
    """Linear in the load from 1 to 2 and from 2 to 4."""
    bend = max(0.0, s - 2.0)
    return 0.5 + 0.1 * s - 0.05 * bend, 2.0 - 0.3 * bend, 1.0 + s


@pytest.fixture(scope="module")
def data():
    load = np.random.default_rng(9).uniform(1.0, 4.0, 600)
    return varying(3, load, linear)


WISH = {"na": 1, "nb": [1, 0], "structure": "diag"}


@pytest.fixture(scope="module")
def model(data):
    wish = gtfdi.ScheduledArx("u2", [1.0, 2.0, 4.0], **WISH, estimation="joint")
    return wish.fit([data[:300], data[300:]])


def test_a_system_linear_in_the_load_is_recovered_exactly(data, model):
    assert (model.channel, model.width, model.max_lag) == ("u2", 1.0, 1)
    assert (model.inputs, model.outputs, model.sample_time_s) == (["u1", "u2"], ["y1"], 0.5)
    assert [point["value"] for point in model.points] == [1.0, 2.0, 4.0]
    for point in model.points:
        a, b, _ = linear(point["value"])
        found = [term["coefficient"] for term in point["model"].regression[0]]
        assert np.allclose(found, [a, b], rtol=0.0, atol=ROUNDING)
    predicted = model.predict(data)
    assert np.isnan(predicted[0]).all()
    assert np.allclose(predicted[1:], data.y[1:], rtol=0.0, atol=ROUNDING)
    free = model.simulate(data.u, data.y)
    assert not free.diverged
    assert np.allclose(free.y, data.y, rtol=0.0, atol=ROUNDING)


def test_local_points_of_constant_loads_are_the_systems_there():
    records = [
        varying(10 + k, np.full(400, load), linear) for k, load in enumerate([1.0, 2.0, 4.0])
    ]
    model = gtfdi.ScheduledArx("u2", [1.0, 2.0, 4.0], **WISH).fit(records)
    for point in model.points:
        a, b, c = linear(point["value"])
        found = [term["coefficient"] for term in point["model"].regression[0]]
        assert np.allclose(found, [a, b], rtol=0.0, atol=ROUNDING)
        # The point's rest: (1 - a) y = b u + c.
        rest = point["model"].operating_point
        expected = (b * rest["u"][0] + c) / (1.0 - a)
        assert rest["y"][0] == pytest.approx(expected, rel=1e-8)


def test_models_fitted_apart_hand_over_by_the_width(model, data):
    points = [(point["value"], point["model"]) for point in model.points]
    assert gtfdi.ScheduledModel("u2", points) == model
    switch = gtfdi.ScheduledModel("u2", points, width=0.0)
    assert switch != model
    # A switch half-way: below 1.5 the first model stands alone, above 3 the last.
    (_, first), _, (_, last) = points
    predicted = switch.predict(data)
    load = data.u[:, 1]
    for alone, where in [(first, load < 1.5), (last, load > 3.0)]:
        where[0] = False
        assert np.allclose(predicted[where], alone.predict(data)[where], rtol=0.0, atol=1e-10)
    one = gtfdi.ScheduledModel("u2", points[:1])
    assert np.allclose(one.predict(data)[1:], first.predict(data)[1:], rtol=0.0, atol=1e-10)


def test_models_pickle(model):
    for copy in (
        pickle.loads(pickle.dumps(model)),
        gtfdi.ScheduledModel.from_json(model.to_json()),
    ):
        assert copy == model
    with pytest.raises(gtfdi.LogError, match="^scheduled model: expected a JSON form, found none"):
        gtfdi.ScheduledModel.from_json("[]")


def test_refusals(data, model):
    def refused(error, match, channel="u2", values=(1.0, 2.0), **options):
        with pytest.raises(error, match=match):
            gtfdi.ScheduledArx(channel, list(values), **{**WISH, **options}).fit(data)

    refused(
        gtfdi.IdentError,
        r"^schedule: expected at least 1 finite value, in ascending order, found \[2.0, 1.0\]$",
        values=(2.0, 1.0),
    )
    refused(gtfdi.IdentError, "^option width: expected a number from 0 to 1, found 2$", width=2.0)
    refused(gtfdi.DataError, "^channel `load`: not found; there are: u1, u2$", channel="load")
    refused(
        gtfdi.OptionError,
        '^option estimation: expected local or joint, found "all"$',
        estimation="all",
    )
    refused(
        gtfdi.IdentError,
        "^samples around `u2` = 9: expected at least .*, found 0$",
        values=(1.0, 8.0, 9.0),
    )
    with pytest.raises(gtfdi.DimensionError, match="^rows of u .*: expected 2, found 1$"):
        model.predict(data.u[:, :1], data.y)


def local(load):
    """A model whose pole and gain depend on the load, and its observer."""
    a, b = 0.9 - 0.3 * load, 0.2 + load
    model = gtfdi.StateSpace([[a]], [[b]], [[1.0]], [[0.0]], 0.1, ["u"], ["y"])
    return a, b, gtfdi.observer(model, 0.5)


def loaded_record(load, seed=0):
    """A record whose plant is at each sample the local model of its load."""
    u, y = np.random.default_rng(seed).standard_normal(len(load)), np.zeros(len(load))
    for t in range(1, len(load)):
        a, b, _ = local(load[t - 1])
        y[t] = a * y[t - 1] + b * u[t - 1]
    return gtfdi.Dataset(np.stack([u, load], axis=1), y, 0.1, ["u", "load"], ["y"])


def test_generators_are_weighted_by_the_distance_to_their_points():
    points = [(load, local(load)[2]) for load in (0.0, 1.0, 3.0)]
    made = gtfdi.ScheduledGenerators("load", points)
    assert (made.channel, made.hysteresis) == ("load", None)
    np.testing.assert_array_equal(made.breakpoints, [0.0, 1.0, 3.0])
    assert made.settle_samples == points[0][1].settle_samples
    expected = {-1.0: [1, 0, 0], 0.25: [0.75, 0.25, 0], 2.0: [0, 0.5, 0.5], 9.0: [0, 0, 1]}
    for value, weights in expected.items():
        np.testing.assert_allclose(made.weights(value), weights, atol=1e-15)
    load = np.linspace(-0.5, 3.5, 200)
    data = loaded_record(np.clip(load, 0.0, 1.0))
    data = gtfdi.Dataset(np.stack([data.u[:, 0], load], axis=1), data.y, 0.1, ["u", "load"], ["y"])
    found = made.run(data)
    alone = np.stack([each.residual(data) for _, each in points], axis=1)
    expected = (found["weights"] * alone).sum(axis=1)
    np.testing.assert_allclose(found["residuals"][:, 0], expected, atol=1e-12)
    np.testing.assert_array_equal(made.residuals(data), found["residuals"])
    np.testing.assert_allclose(found["weights"].sum(axis=1), 1.0, rtol=1e-15)
    twin = gtfdi.ScheduledGenerators.from_json(made.to_json())
    assert twin == made


def test_residuals_vanish_where_a_local_model_is_exact():
    load = np.repeat([0.0, 1.0], 300)
    points = [(value, local(value)[2]) for value in (0.0, 1.0)]
    for hysteresis in (None, 0.1):
        made = gtfdi.ScheduledGenerators("load", points, hysteresis)
        residuals = made.residuals(loaded_record(load))[:, 0]
        settled = np.r_[0:300, 300 + made.settle_samples + 1 : 600]
        # A ten-thousandth of the start is what settling leaves.
        assert np.abs(residuals[settled]).max() < 1e-3
        assert made.hysteresis == hysteresis


def test_switching_waits_for_the_hysteresis():
    points = [(value, local(value)[2]) for value in (0.0, 1.0)]
    load = np.concatenate([np.linspace(0.0, 1.0, 101), np.linspace(1.0, 0.0, 101)])
    run = gtfdi.ScheduledGenerators("load", points, 0.2).run(loaded_record(load))
    active = run["weights"].argmax(axis=1)
    changes = load[np.flatnonzero(np.diff(active)) + 1]
    # Up beyond the middle and the hysteresis, down as far on the other side; a step is 0.01.
    np.testing.assert_allclose(changes, [0.7, 0.3], atol=0.0101)
    assert set(run["weights"].ravel()) == {0.0, 1.0}


def test_schedules_of_generators_that_do_not_fit_are_refused():
    _, _, one = local(0.0)
    with pytest.raises(gtfdi.DesignError, match="expected at least one, found none"):
        gtfdi.ScheduledGenerators("load", [])
    with pytest.raises(gtfdi.DesignError, match="^breakpoint 1: expected a finite number above 1"):
        gtfdi.ScheduledGenerators("load", [(1.0, one), (0.5, one)])
    with pytest.raises(gtfdi.DesignError, match=r"^hysteresis: expected 0 to 0.5 .* found 0.6$"):
        gtfdi.ScheduledGenerators("load", [(0.0, one), (1.0, one)], 0.6)
    made = gtfdi.ScheduledGenerators("other", [(0.0, one)])
    with pytest.raises(gtfdi.DesignError, match="other"):
        made.run(loaded_record(np.zeros(5)))
