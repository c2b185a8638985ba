"""Logs from Python: what the command line's verbs say, and what they refuse."""

import csv

import numpy as np
import pytest

import gtfdi
from gtfdi import log


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    run = gtfdi.simulate(20.0, seed=4)
    run.write(path)
    return path, run


def test_info_says_what_is_there(written):
    path, run = written
    report = log.info(path)
    topics = {topic["topic"]: topic for topic in report["topics"]}
    assert topics["/plant/measured"]["messages"] == len(run) == 250
    assert report["size_bytes"] == path.stat().st_size


def test_a_whole_log_is_sound_and_a_changed_one_is_not(written, tmp_path):
    path, _ = written
    report = log.verify(path)
    assert report["sound"] and report["problems"] == []
    broken = bytearray(path.read_bytes())
    broken[len(broken) // 2] ^= 0xFF
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(broken)
    report = log.verify(damaged)
    assert not report["sound"] and report["problems"]


def test_what_was_cut_off_is_saved_and_reads_like_the_rest(written, tmp_path):
    path, run = written
    cut, whole = tmp_path / "run.mcap.part", tmp_path / "saved.mcap"
    cut.write_bytes(path.read_bytes()[:-1500])
    report = log.recover(cut, whole)
    assert not report["sound"] and report["messages"] > 0
    assert log.verify(whole)["sound"]
    data = gtfdi.read(whole, inputs=["a_v", "M_f"], outputs="q_c")
    expected = run.measured.select(["a_v", "M_f"], ["q_c"])
    np.testing.assert_array_equal(data.y, expected.y[: len(data)])
    with pytest.raises(gtfdi.LogError, match="saved.mcap"):
        log.recover(whole, whole)


def test_a_topic_becomes_a_table(written, tmp_path):
    path, run = written
    out = tmp_path / "run.csv"
    report = log.export(path, out, tags=["t3", "p7"], rows=(10, 60), time="seconds")
    assert report["rows"] == 50
    with out.open() as file:
        rows = list(csv.DictReader(file))
    column = run.measured.outputs.index("t3")
    # What is written has all its digits.
    name = next(key for key in rows[0] if key.startswith("t3"))
    np.testing.assert_array_equal([float(row[name]) for row in rows], run.measured.y[10:60, column])


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda path, out: log.info(out / "none.mcap"), gtfdi.LogError, "none.mcap"),
        (lambda path, out: log.export(path, out / "run.txt"), gtfdi.LogError, "run.txt"),
        (lambda path, out: log.export(path, out / "a.csv", topic="/x"), gtfdi.LogError, "/x"),
        (lambda path, out: log.export(path, out / "a.csv", tags="zz"), gtfdi.LogError, "zz"),
        (lambda path, out: log.export(path, out / "a.csv", time="days"), gtfdi.OptionError, "days"),
    ],
    ids=["no file", "extension", "topic", "tag", "time"],
)
def test_what_is_not_there_is_refused_by_name(call, error, message, written, tmp_path):
    with pytest.raises(error, match=message):
        call(written[0], tmp_path)
    assert not list(tmp_path.glob("*.csv"))


def test_attachments_are_those_that_were_written(written):
    path, run = written
    assert log.attachment(path, "config.toml").decode() == run.config
    names = [each["name"] for each in log.info(path)["attachments"]]
    assert names == ["config.toml"]
    with pytest.raises(gtfdi.LogError, match="`other.toml`.*config.toml"):
        log.attachment(path, "other.toml")


def test_verdicts_are_written_as_they_are_given(model, tmp_path):
    drift = {"case": "compressor_fouling", "onset_s": 20.0, "rate_percent_per_h": 360.0}
    faulty = gtfdi.simulate(60.0, seed=9, faults=[drift]).measured
    calm = gtfdi.simulate(60.0, seed=8).measured
    bank = gtfdi.design(model, [calm], poles=0.7, margin=1.1)
    found = bank.detect(faulty)
    assert found.alarms
    path = tmp_path / "verdicts.mcap"
    bank.write_verdicts(path, faulty)
    assert log.verify(path)["sound"]
    log.export(path, tmp_path / "r.csv", topic=f"/fdi/{bank.name}/residual", time="seconds")
    with (tmp_path / "r.csv").open() as file:
        rows = list(csv.DictReader(file))
    residuals = np.array([float(row["q_c"]) for row in rows])
    np.testing.assert_array_equal(residuals, found.residuals[:, 0])
    raised = [each["value"] for each in log.messages(path, "/alarms")]
    onsets = [each["onset_s"] for each in raised if each["state"] == "active"]
    assert len(onsets) == len(found.alarms)
    assert [each["limit"] for each in raised[:1]] == [found.alarms[0]["threshold"]]
    assert gtfdi.Bank.from_json(log.attachment(path, f"models/{bank.name}.json").decode()) == bank
    with pytest.raises(gtfdi.LogError, match="`/nothing`.*/alarms"):
        log.messages(path, "/nothing")
    other = tmp_path / "other.mcap"
    with pytest.raises(gtfdi.DataError, match="q_c"):
        bank.write_verdicts(other, faulty.select(["a_v", "M_f"], ["t3"]))
    assert not other.exists()


def test_diagnoses_are_written_as_they_are_given(tank, tmp_path):
    leaking = tank.record(94, 4000, leak=2.0)
    found = tank.isolator.detect(leaking)
    assert found.alarms
    path = tmp_path / "diagnoses.mcap"
    tank.isolator.write_diagnoses(path, leaking.u, leaking.y)
    assert log.verify(path)["sound"]
    times = [each["time_ns"] for each in log.messages(path, "/fdi/diagnosis")]
    assert times and times == sorted(times)
    states = [each["value"]["state"] for each in log.messages(path, "/alarms")]
    assert states.count("active") == len(found.alarms)
