"""Observers, banks, the online detector."""

import pickle

import numpy as np
import pytest

import gtfdi

INPUTS, OUTPUTS = ["a_v", "M_f"], ["q_c"]


@pytest.fixture(scope="module")
def records():
    return [gtfdi.simulate(120.0, seed=seed).measured for seed in (1, 2, 3, 4)]


@pytest.fixture(scope="module")
def bank(model, records):
    return gtfdi.design(model, records[:3], poles=0.7, margin=1.5)


def test_prop_residual_is_the_equation_error_through_the_poles(model, records):
    # r = eps / P: eps the equation error from rest, P the polynomial of the placed poles. Both are
    # computed here from the model's listed coefficients.
    data = records[0].select(INPUTS, OUTPUTS)
    point = model.operating_point
    signals = dict(zip(INPUTS, (data.u - point["u"]).T, strict=True))
    signals["q_c"] = data.y[:, 0] - point["y"][0]
    eps = signals["q_c"].copy()
    for term in model.regression[0]:
        lag = term["lag"]
        past = signals[term["signal"]][: len(eps) - lag]
        eps[lag:] -= term["coefficient"] * past
    poles = np.linspace(0.1, 0.7, 8)
    denominator = np.poly(poles)
    expected = np.zeros_like(eps)
    for t in range(len(eps)):
        lags = min(t, 8)
        past = expected[t - lags : t][::-1]
        expected[t] = eps[t] - denominator[1 : lags + 1] @ past
    observer = gtfdi.observer(model.output_model("q_c"), poles=list(poles))
    residual = observer.residual(records[0])
    scale = np.abs(signals["q_c"]).max()
    assert np.allclose(residual, expected, rtol=0.0, atol=1e-9 * scale)
    assert np.array_equal(observer.poles, poles)
    # The gain puts the eigenvalues of A - K C where they were asked for.
    part = observer.model
    placed = np.linalg.eigvals(part.A - np.outer(observer.gain, part.C[0]))
    # Eight poles on a line: eigenvalues are worse conditioned than the polynomial.
    assert np.allclose(np.sort(placed.real), poles, rtol=0.0, atol=1e-3)
    assert np.allclose(np.poly(placed), denominator, rtol=0.0, atol=1e-9)
    arrays = observer.residual(data.u, data.y)
    assert np.array_equal(arrays, residual)
    copy = pickle.loads(pickle.dumps(observer))
    assert copy == observer
    assert copy.settle_samples == observer.settle_samples


def test_prop_observer_of_the_true_system_sees_nothing(random_record):
    system, u, y = random_record(3, nx=3, nu=2)
    observer = gtfdi.observer(system, 0.2, point=(np.array([1.0, -2.0]), [5.0]))
    residual = observer.residual(u + [1.0, -2.0], y + 5.0)
    # From rest the state is known; rounding of the point's subtraction is all that is left.
    assert np.abs(residual).max() < 1e-10 * np.abs(y).max()
    assert np.array_equal(observer.point["u"], [1.0, -2.0])


def test_observers_take_pairs_of_complex_poles(model, records):
    poles = [0.6 + 0.3j, 0.6 - 0.3j, 0.5, np.complex128(0.2j), -0.2j, 0.1, -0.3, np.float32(0.25)]
    observer = gtfdi.observer(model.output_model("q_c"), poles)
    assert observer.poles.dtype == complex
    assert np.array_equal(observer.poles, poles)
    part = observer.model
    placed = np.linalg.eigvals(part.A - np.outer(observer.gain, part.C[0]))
    assert np.allclose(np.poly(placed), np.poly(poles).real, rtol=0.0, atol=1e-9)
    assert "0.6+0.3j, 0.6-0.3j, 0.5, " in repr(observer)
    copy = pickle.loads(pickle.dumps(observer))
    assert copy == observer
    assert np.array_equal(copy.poles, poles)
    # Without an imaginary part they are real, as ever.
    real = gtfdi.observer(model.output_model("q_c"), np.full(8, 0.5 + 0.0j))
    assert real.poles.dtype == float
    assert real == gtfdi.observer(model.output_model("q_c"), 0.5)
    bank = gtfdi.design(model, records[:2], poles={"q_c": poles})
    (report,) = bank.detectors
    assert report["poles"] == []
    assert [complex(*pole) for pole in report["complex_poles"]] == poles
    residuals = bank.detect(records[2]).residuals[:, 0]
    assert np.array_equal(residuals, observer.residual(records[2]))
    with pytest.raises(gtfdi.DesignError, match=r"^pole 0, 0.5\+0.1i: expected its complex conj"):
        gtfdi.observer(model.output_model("q_c"), 0.5 + 0.1j)


def test_observer_refuses_poles():
    system = gtfdi.StateSpace([[0.0, 1.0], [-0.5, 1.0]], [[1.0], [1.0]], [[1.0, 0.0]], [[0.0]], 0.1)
    with pytest.raises(gtfdi.DesignError, match="^pole 1: expected a modulus below 1, found 1.2$"):
        gtfdi.observer(system, [0.5, 1.2])
    with pytest.raises(gtfdi.DesignError, match="^poles: expected 2, one a state, found 3$"):
        gtfdi.observer(system, [0.5, 0.4, 0.3])
    with pytest.raises(gtfdi.DimensionError, match="^inputs of the operating point: expected 1"):
        gtfdi.observer(system, 0.5, point=([1.0, 2.0], [0.0]))
    blind = gtfdi.StateSpace([[0.5, 0.0], [0.0, 0.6]], [[1.0], [1.0]], [[1.0, 0.0]], [[0.0]], 0.1)
    with pytest.raises(gtfdi.DesignError, match="^model of `y1`: expected an observable pair"):
        gtfdi.observer(blind, 0.5)


def test_a_step_fault_is_found_at_its_onset_and_not_before(bank, records):
    data = records[3].select(INPUTS, OUTPUTS)
    assert bank.detect(data).alarms == []
    onset = 700
    (report,) = bank.detectors
    y = data.y.copy()
    y[onset:] += 10.0 * report["limit"]
    faulty = gtfdi.Dataset(data.u, y, 0.08, INPUTS, OUTPUTS)
    detection = bank.detect(faulty)
    first = detection.alarms[0]
    # The observer passes a step on the sensor at once: r(onset) = step + healthy r.
    assert first["time_s"] == first["first_exceedance_s"] == faulty.time_s[onset]
    assert (first["tag"], first["threshold"]) == ("q_c", report["limit"])
    assert abs(first["residual"]) > report["limit"]
    assert np.array_equal(detection.residuals[:onset], bank.detect(data).residuals[:onset])
    # Arrays have the bank's channels.
    assert bank.detect(data.u, y).alarms == detection.alarms


def test_design_counts_its_false_alarms(bank, model, records):
    (report,) = bank.detectors
    assert report["poles"] == [0.7] * 8
    assert (report["consecutive"], report["output"]) == (1, "q_c")
    in_sample = report["false_alarms"]["in_sample"]
    assert in_sample["alarms"] == 0
    settled = sum(len(record) - report["settle_samples"] for record in records[:3])
    assert in_sample["hours"] == pytest.approx(settled * 0.08 / 3600.0, rel=1e-12)
    residuals = [bank.detect(record).residuals for record in records[:3]]
    largest = max(np.abs(each[report["settle_samples"] :]).max() for each in residuals)
    assert report["limit"] == 1.5 * largest
    # The default rule: 1.2 times the largest healthy residual; the paper's pole for q_c.
    (default,) = gtfdi.design(model, records[:3]).detectors
    assert (default["consecutive"], default["poles"]) == (1, [0.7] * 8)
    assert default["limit"] == 1.2 * largest
    # One healthy sample in a hundred above the limit, six in a row.
    by_share = gtfdi.design(model, records[:3], poles=0.5, exceedance=0.01)
    (report,) = by_share.detectors
    assert (report["consecutive"], report["poles"]) == (6, [0.5] * 8)
    shares = [by_share.detect(record).share_above_limit[0] for record in records[:3]]
    assert np.mean(shares) == pytest.approx(0.01, abs=1e-3)
    pairs = [(chosen.u, chosen.y) for chosen in (r.select(INPUTS, OUTPUTS) for r in records[:3])]
    assert gtfdi.design(model, pairs, poles={"q_c": 0.7}, margin=1.5) == bank


def test_online_steps_are_the_batch_bit_for_bit(bank, records):
    data = records[3].select(INPUTS, OUTPUTS)
    u, y, times = data.u.copy(), data.y.copy(), data.time_s
    y[300] = np.nan
    u[500, 1] = np.nan
    y[900:] += 5.0 * bank.detectors[0]["limit"]
    batch = bank.detect(gtfdi.Dataset(u, y, 0.08, INPUTS, OUTPUTS))
    detector = bank.detector()
    assert (detector.inputs, detector.outputs) == (INPUTS, OUTPUTS)
    verdicts = [detector.step(u[k], y[k], times[k]) for k in range(len(u))]
    residuals = np.array([verdict.residual for verdict in verdicts])
    assert residuals.tobytes() == batch.residuals.tobytes()
    alarms = [verdict.time_s for verdict in verdicts if verdict.new_alarm.any()]
    assert alarms == [alarm["time_s"] for alarm in batch.alarms]
    assert times[900] in alarms
    assert verdicts[0].settling.all()
    assert verdicts[900].first_exceedance_s[0] == times[900]
    assert not any(verdict.gap for verdict in verdicts)
    # In one call, in two, and without times.
    detector.reset()
    series = detector.process(u, y)
    assert series.residual.tobytes() == residuals.tobytes()
    assert np.array_equal(series.time_s, times)
    assert np.array_equal(series.alarm, [verdict.alarm for verdict in verdicts])
    detector.reset()
    halves = [detector.process(u[:400], y[:400]), detector.process(u[400:], y[400:])]
    assert np.vstack([half.residual for half in halves]).tobytes() == residuals.tobytes()
    detector.reset()
    # A record has its own times and is looked through by name.
    assert len(detector.process(records[3])) == len(u)


def test_the_detector_refuses_samples_and_keeps_its_state(bank):
    detector, twin = bank.detector(), bank.detector()
    with pytest.raises(gtfdi.StepError, match="^inputs of the sample: expected 2, found 1$"):
        detector.step([0.0], [1.0])
    with pytest.raises(gtfdi.StepError, match="^outputs of the sample: expected 1, found 2$"):
        detector.step([0.0, 0.0], [1.0, 2.0])
    with pytest.raises(gtfdi.StepError, match="^time of the sample: expected a finite"):
        detector.step([0.0, 0.0], [1.0], float("nan"))
    with pytest.raises(gtfdi.ArrayTypeError, match="^u: "):
        detector.step(["a", "b"], [1.0])
    first = detector.step([0.0, 0.0], [1.0], 10.0)
    with pytest.raises(gtfdi.StepError, match="^time of the sample: expected about 0.08 s after"):
        detector.step([0.0, 0.0], [1.0], 10.0)
    assert first.residual == twin.step([0.0, 0.0], [1.0]).residual
    assert detector.step([0.1, 0.0], [1.0]).time_s == 10.0 + 0.08
    assert detector.step([0.1, 0.0], [1.0], 60.0).gap


def test_banks_pickle_and_keep_files(bank, records, tmp_path):
    path = tmp_path / "bank.json"
    bank.save(path)
    for copy in (gtfdi.Bank.load(path), pickle.loads(pickle.dumps(bank))):
        assert copy == bank
        found = copy.detect(records[3]).residuals
        assert found.tobytes() == bank.detect(records[3]).residuals.tobytes()
    path.write_text(bank.to_json().replace('"schema_version":2', '"schema_version":99'))
    with pytest.raises(gtfdi.LogError, match="schema_version 2, found 99"):
        gtfdi.Bank.load(path)


def test_refusals_of_designs(model, records):
    with pytest.raises(gtfdi.DesignError, match="^healthy residuals: expected at least one record"):
        gtfdi.design(model, [])
    with pytest.raises(gtfdi.OptionError, match="^option exceedance: expected one of"):
        gtfdi.design(model, records, exceedance=0.1, margin=2.0)
    with pytest.raises(gtfdi.DesignError, match="^option `share`: expected a share above 0"):
        gtfdi.design(model, records, exceedance=1.5)
    with pytest.raises(gtfdi.DesignError, match="^pole 0: expected a modulus below 1, found 1$"):
        gtfdi.design(model, records, poles=1.0)
    with pytest.raises(gtfdi.DataError, match="^channel `p9`: not found; there are: q_c$"):
        gtfdi.design(model, records, poles={"p9": 0.5})
    with pytest.raises(gtfdi.DesignError, match="hours of healthy running|h of healthy running"):
        gtfdi.design(model, records, arl0_h=24.0)
    with pytest.raises(gtfdi.DataError, match="^channel `M_f`: not found"):
        gtfdi.design(model, [gtfdi.Dataset(np.zeros(50), np.zeros(50), 0.08, "a_v", "q_c")])


def test_a_record_without_the_banks_channels_is_refused(bank, records):
    with pytest.raises(gtfdi.DesignError, match="^record: expected the channels M_f, found only"):
        bank.detect(records[0].select(["a_v"], ["q_c"]))
    with pytest.raises(gtfdi.DesignError, match="^sample time of the record: expected 0.08 s"):
        data = records[0].select(INPUTS, OUTPUTS)
        bank.detect(gtfdi.Dataset(data.u, data.y, 0.1, INPUTS, OUTPUTS))
