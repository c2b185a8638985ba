"""Isolators: which fault, since when, how large."""

import json
import pickle

import numpy as np
import pytest

import gtfdi

CASES = [
    ({"sensor": -0.08}, "sensor a", -0.08),
    ({"leak": 0.06}, "leak", 0.06),
    ({"lag_s": 0.6}, "valve", 0.6),
]


def test_what_pairs_of_records_show_is_learned(tank):
    hypotheses = {own["name"]: own for own in tank.isolator.hypotheses}
    changes = hypotheses["leak"]["effect"]["changes"]
    # The pair has the same noise, so that only the model's error of gain is left.
    assert changes == pytest.approx({"a": 0.0, "b": 1.0, "c": 0.7}, abs=0.05)
    assert hypotheses["valve"]["unit"] == "s"
    assert tank.isolator.statistics == ["sensor a", "leak", "valve", "any direction"]
    assert (tank.isolator.limits > 0.0).all()
    # Four statistics share one false alarm in two hours.
    assert [own["asked_hours"] for own in tank.isolator.mean_times] == [8.0] * 4


@pytest.mark.parametrize(("fault", "name", "size"), CASES)
def test_faults_are_named_sized_and_dated(tank, fault, name, size):
    found = tank.isolator.detect(tank.record(3, 5000, **fault))
    alarm = found.alarms[0]
    assert (alarm["finding"], alarm["fault"]) == ("named", name)
    assert alarm["probability"] >= 0.99
    assert alarm["time_s"] > tank.ONSET_S
    # The tolerance of directions is a tenth.
    assert alarm["magnitude"] == pytest.approx(size, rel=0.2)
    own = next(own for own in alarm["hypotheses"] if own["fault"] == name)
    low, high = own["onset_interval_s"]
    assert low <= tank.ONSET_S <= high
    assert len(found.peaks) == 500
    assert found.peaks.max() > 1.0


def test_healthy_records_are_silent(tank):
    found = tank.isolator.detect(tank.record(99, 6000))
    assert found.alarms == []
    assert found.judged == 6000 - tank.isolator.settle_samples


def test_samples_one_by_one_find_what_the_record_does(tank):
    record = tank.record(3, 5000, leak=0.06)
    monitor = tank.isolator.monitor()
    events, last = [], None
    for k in range(len(record)):
        for event in monitor.step(record.u[k], record.y[k]):
            events.append((event, k))
        last = monitor.diagnosis or last
    whole = tank.isolator.detect(record).alarms[0]
    assert [event for event, _ in events] == ["alarm", "name"]
    assert events[0][1] * tank.SAMPLE_TIME_S == pytest.approx(whole["time_s"])
    assert monitor.alarm
    assert last["fault"] == "leak"
    assert monitor.statistics.shape == (4,)
    with pytest.raises(gtfdi.StepError):
        monitor.step([0.0], [0.0])


def test_a_saved_state_goes_on_bit_for_bit(tank):
    record = tank.record(3, 4000, leak=0.06)
    first, second = tank.isolator.monitor(), tank.isolator.monitor()
    for k in range(3000):
        first.step(record.u[k], record.y[k])
    second.resume(first.state())
    for k in range(3000, len(record)):
        sample = record.u[k], record.y[k]
        assert first.step(*sample) == second.step(*sample)
        np.testing.assert_array_equal(first.statistics, second.statistics)
    assert first.diagnosis == second.diagnosis
    state = json.loads(first.state())
    state["detector"]["fingerprint"] += 1
    with pytest.raises(gtfdi.StepError, match="found that of another"):
        second.resume(json.dumps(state))


def test_files_and_pickles_keep_every_bit(tank, tmp_path):
    path = tmp_path / "isolator.json"
    tank.isolator.save(path)
    record = tank.record(3, 4000, sensor=0.1)
    expected = tank.isolator.detect(record)
    for other in (
        gtfdi.Isolator.load(path),
        pickle.loads(pickle.dumps(tank.isolator)),
    ):
        assert other == tank.isolator
        assert other.detect(record).alarms == expected.alarms
        np.testing.assert_array_equal(other.detect(record).peaks, expected.peaks)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ({"name": "f"}, "entry 0: fault `f`: expected `changes`"),
        ({"name": "f", "change": {"a": 1.0}}, "unknown field `change`"),
        ({"name": "f", "changes": {"a": 1.0}, "actuator": "u"}, "both changes and an actuator"),
        ({"name": "f", "changes": {"a": 1.0}, "nominal_s": 1.0}, "nominal_s without an actuator"),
    ],
)
def test_descriptions_that_say_nothing_or_two_things_are_refused(tank, fault, words):
    with pytest.raises(gtfdi.OptionError, match=words):
        gtfdi.design_isolator(tank.model, tank.healthy[:1], [fault])


def test_designs_that_cannot_be_are_refused(tank):
    record = tank.record(5, 3000)
    silent = {"name": "none", "pairs": [(record, record, tank.growth(3000))]}
    with pytest.raises(gtfdi.DesignError, match="fault `none`"):
        gtfdi.design_isolator(tank.model, tank.healthy[:1], [silent])
    absent = {"name": "absent", "changes": {"z": 1.0}}
    with pytest.raises(gtfdi.DesignError, match="z"):
        gtfdi.design_isolator(tank.model, tank.healthy[:1], [absent])
    with pytest.raises(gtfdi.DesignError, match="confidence"):
        gtfdi.design_isolator(tank.model, tank.healthy[:1], tank.faults[:1], confidence=2.0)
    with pytest.raises(gtfdi.OptionError, match="generator"):
        gtfdi.design_isolator(tank.model, tank.healthy[:1], tank.faults[:1], generator="none")
    # An hour has too few peaks for a day.
    with pytest.raises(gtfdi.DesignError, match=r"needs at least 27 h of healthy running, found 0\.828 h"):
        gtfdi.design_isolator(tank.model, tank.healthy[:1], tank.faults)
