"""Every public object that holds a state or a result can be pickled, and a bad pickle is refused."""

import copy
import inspect
import pickle

import numpy as np
import pytest

import gtfdi
from gtfdi import run_length, statistics

INPUTS, OUTPUTS = ["a_v", "M_f"], ["q_c"]

# Classes whose objects have no pickle, with the reason.
WITHOUT = {
    "CusumFleet": "the sums of its streams have no stored form; its Cusum has, and makes another",
    "Fleet": "the states of its streams have no stored form; its generator has, and makes another",
}


def public_classes():
    """All classes of the package but its exceptions."""
    for module in (gtfdi, run_length, statistics):
        for name in module.__all__:
            thing = getattr(module, name)
            if inspect.isclass(thing) and not issubclass(thing, Exception):
                yield name


@pytest.fixture(scope="module")
def made(healthy, model, tank):
    """Makes an object of each class."""
    record = healthy.measured.select(INPUTS, OUTPUTS)
    bank = gtfdi.design(model, [record], margin=1.5)
    names = {"inputs": INPUTS, "outputs": OUTPUTS}
    fit = gtfdi.Arx(order=2, nk=0).fit_in_full(record)
    diagonal = gtfdi.arx(record, order=2, structure="diag")
    detector = bank.detector()
    detector.process(record[:300])
    monitor = tank.isolator.monitor()
    leaking = tank.record(97, 3000, leak=2.0)
    for u, y in zip(leaking.u, leaking.y):
        monitor.step(u, y)
    short = tank.record(96, 2000)
    few = gtfdi.OutputErrorRefinement(max_iterations=2)
    refined = few.refine(diagonal, record[:2000], record[2000:4000])
    drift = {"case": "thermocouple_drift", "onset_s": 10.0, "rate_percent_per_h": 50.0}
    twins = [gtfdi.simulate(40.0, seed=7, faults=faults).measured for faults in ([], [drift])]
    t3 = gtfdi.arx(twins[0], order=1, inputs=INPUTS, outputs="t3").output_model(0)
    searched = gtfdi.optimise_observer(t3, [tuple(twins)], radius=0.9, random_starts=2)
    scheduled = gtfdi.ScheduledArx("M_f", np.quantile(record.u[:, 1], [0.2, 0.8]), na=1, nb=[1, 0])
    constrained = gtfdi.ConstrainedArx(order=1, dc_gains={("q_c", "M_f"): "positive"})
    part, drawn = model.output_model(0), np.random.default_rng(4).standard_normal
    noise = gtfdi.NoiseCovariance.errors_in_variables(part, [1e-4, 1e-6], [0.01])
    varying = gtfdi.TimeVaryingKalman(part, noise, P0=np.eye(8))
    varying.process(record[:50])
    entering = {"E_d": drawn((8, 1)), "F_d": drawn((1, 1)), "F_f": [[1.0]]}
    faulty = gtfdi.FaultModel(part, **entering)
    tanks = gtfdi.StateSpace([[0.9, 0], [0.1, 0.9]], [[1], [0]], np.eye(2), np.zeros((2, 1)), 1)
    leaking_tanks = gtfdi.FaultModel(tanks, E_d=[[0.0], [1.0]], point=([1.0], [2.0, 3.0]))
    decoupled = gtfdi.UnknownInputObserver(leaking_tanks, poles=[0.5])
    white = np.random.default_rng(3).standard_normal((20, 50))
    objects = [
        gtfdi.Arx(order=(1, 4), nk=[0, 1], ridge=0.1, centre=([0.0, 0.0], [0.0])),
        fit,
        model,
        bank,
        bank.detect(record),
        constrained,
        constrained.fit(record),
        record,
        detector,
        detector.step(record.u[300], record.y[300]),
        bank.detector().process(record[:300]),
        gtfdi.EivKalman(part, [1e-4, 1e-6], [0.01]),
        gtfdi.eiv(short, order=(1, 2), nk=1),
        gtfdi.eiv_order_table(short, orders=(1, 2)),
        faulty,
        gtfdi.kalman(part, noise=noise).run(record[:100]),
        model.simulate(record),
        fit.frequency_response([0.0, 0.5]),
        gtfdi.frisch_order_table(short, orders=(1, 2)),
        gtfdi.index_table(short, orders=(3, 4)),
        monitor,
        tank.isolator.detect(leaking),
        tank.isolator,
        gtfdi.kalman(model.output_model(0), [1e-4, 1e-6], [0.01]),
        decoupled.linear_residual,
        noise,
        gtfdi.observer(model.output_model(0), 0.5),
        searched,
        gtfdi.order_table(record, orders=(1, 2)),
        few,
        refined,
        model.output_model(0),
        model.test_residuals(record),
        gtfdi.riccati([[1.0]], [[1.0]], [[1.0]], [[1.0]]),
        healthy,
        gtfdi.ScheduledGenerators("M_f", [(0.4, gtfdi.observer(part, 0.5))]),
        scheduled,
        scheduled.fit(record),
        gtfdi.signature({"leak": white.T}, 0.0 * white.T, 0.1),
        model.state_space(),
        varying,
        record.trend(),
        gtfdi.UnifiedFilter(faulty),
        decoupled,
        statistics.Cusum(0.5, 5.0),
        run_length.SimulatedRuns(statistics.Cusum(0.5, 2.0), lambda path: white[path], 20, 50),
        statistics.ShiryaevRoberts(1.0, 6.0),
        statistics.Glr("ramp", (0.01, 1.0), 12.0, longest=64),
        statistics.MovingAverage(5, 1.0),
        statistics.RunSum(1.0),
        statistics.Sprt(1.0, -5.0, 5.0),
        statistics.WindowedChiSquare(5, 20.0),
        statistics.WindowedVariance(5, 3.0),
        statistics.Whiteness(20, 3, 16.0),
        statistics.GrowingChiSquare(5, 3.0, longest=30),
        statistics.GrowingVariance(5, 3.0),
        statistics.AdaptiveThreshold(1.0, [0.5, 0.1], 10.0),
    ]
    noise = np.random.default_rng(5).standard_normal(50)
    for thing in objects:
        if isinstance(thing, statistics.AdaptiveThreshold):
            thing.step([1.0, 2.0], 0.5)
        elif type(thing).__name__ in statistics.__all__:
            thing.process(noise)
    return {type(thing).__name__: thing for thing in objects}


@pytest.mark.parametrize("name", list(public_classes()))
def test_a_pickle_keeps_everything(name, made):
    if name in WITHOUT:
        assert name not in made
        return
    thing = made[name]
    text = pickle.dumps(thing)
    twin = pickle.loads(text)
    assert type(twin) is type(thing)
    # What a pickle holds is everything, so the same bytes mean the same object, NaN included.
    assert pickle.dumps(twin) == text
    assert pickle.dumps(copy.deepcopy(thing)) == text
    if type(thing).__eq__ is not object.__eq__:
        assert twin == thing
    assert repr(twin) == repr(thing) or " object at " in repr(thing)


@pytest.mark.parametrize("name", [name for name in public_classes() if name not in WITHOUT])
def test_pickles_of_another_version_and_broken_ones_are_refused(name, made):
    restore, (own, form, version, digest, payload) = made[name].__reduce__()
    assert own == name
    other = f"^pickle of {name}: expected form {form}.*, found form 99 of gtfdi 9.9$"
    with pytest.raises(gtfdi.PickleError, match=other):
        restore(name, 99, "9.9", digest, payload)
    broken = f"^pickle of {name}: expected bytes whose SHA-256 is {digest}, found"
    with pytest.raises(gtfdi.PickleError, match=broken):
        restore(name, form, version, digest, payload[:-1] + b"\x00\x01")
    with pytest.raises(gtfdi.PickleError, match="pickle of Nothing: expected a class of gtfdi"):
        restore("Nothing", form, version, digest, payload)


def test_a_payload_of_another_class_is_refused(made):
    restore, (_, form, version, digest, payload) = made["Trend"].__reduce__()
    message = "^pickle of Bank: expected what gtfdi .* writes, found"
    with pytest.raises(gtfdi.PickleError, match=message):
        restore("Bank", form, version, digest, payload)


def test_a_detector_goes_on_from_its_pickle(made, healthy):
    record = healthy.measured
    detector = made["Bank"].detector()
    whole = made["Bank"].detector().process(record[:600])
    detector.process(record[:300])
    twin = pickle.loads(pickle.dumps(detector))
    rest = twin.process(record[300:600])
    np.testing.assert_array_equal(rest.statistic, whole.statistic[300:])
    np.testing.assert_array_equal(rest.alarm, whole.alarm[300:])


def test_a_monitor_goes_on_from_its_pickle(tank):
    record = tank.record(95, 3000, leak=2.0)
    monitor = tank.isolator.monitor()
    for u, y in zip(record.u[:2200], record.y[:2200]):
        monitor.step(u, y)
    twin = pickle.loads(pickle.dumps(monitor))
    for u, y in zip(record.u[2200:], record.y[2200:]):
        assert monitor.step(u, y) == twin.step(u, y)
        np.testing.assert_array_equal(monitor.statistics, twin.statistics)
    assert monitor.diagnosis == twin.diagnosis


def test_a_filter_goes_on_from_its_pickle(made, healthy):
    record = healthy.measured.select(INPUTS, OUTPUTS)
    filter = made["TimeVaryingKalman"]
    twin = pickle.loads(pickle.dumps(filter))
    np.testing.assert_array_equal(filter.process(record[50:300]), twin.process(record[50:300]))
    np.testing.assert_array_equal(filter.covariance, twin.covariance)
    filter.reset(), twin.reset()
    np.testing.assert_array_equal(filter.process(record[:99]), twin.process(record[:99]))


def test_a_statistic_goes_on_from_its_pickle():
    noise = np.random.default_rng(6).standard_normal(400)
    glr = statistics.Glr("step", (0.1, 10.0), 12.0, longest=64)
    glr.process(noise[:150])
    twin = pickle.loads(pickle.dumps(glr))
    np.testing.assert_array_equal(glr.process(noise[150:]), twin.process(noise[150:]))
    assert glr == twin and glr.change == twin.change


def test_a_run_that_ended_early_keeps_the_reason():
    broken = {"case": "turbine_damage", "onset_s": 2.0, "rate_percent_per_h": 36e3}
    run = gtfdi.simulate(60.0, faults=[broken | {"limit_percent": 99.0}])
    twin = pickle.loads(pickle.dumps(run))
    assert "expected between" in run.ended
    assert twin.ended == run.ended
    assert twin.warnings == run.warnings
    assert twin.measured == run.measured
