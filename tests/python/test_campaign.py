"""Campaigns from Python: the rows of the command line, resumed after Ctrl-C, and bad input."""

import json
import sys
import textwrap

import pytest
from interrupted_campaign import interrupted

import gtfdi
from gtfdi import campaign

SPEC = """
seed = 1
runs = RUNS
[record]
duration_s = 40.0
onset_s = [10.0, 20.0]
[[faults]]
case = "thermocouple_drift"
size = { log_uniform = [0.5, 1.0] }
shape = { ramp = { rise_s = 5.0 } }
[bank]
arl0_h = 0.02
calibration_h = 0.2
tests = [{ statistic = "cusum" }]
"""


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign")
    spec = folder / "drift.toml"
    spec.write_text(SPEC.replace("RUNS", "6"))
    return spec, folder / "drift", campaign.run(spec, folder / "drift")


def test_a_campaign_leaves_its_files_and_says_what_is_in_them(finished):
    _, out, summary = finished
    assert (summary["runs"], summary["ok"]) == (6, 6)
    assert json.loads((out / "summary.json").read_text()) == summary
    assert (out / "rows.parquet").is_file() and (out / "report.html").is_file()


def test_rows_are_those_of_the_campaign(finished):
    spec, out, _ = finished
    rows = campaign.rows(spec, [4, 1], out)
    assert [row["run"] for row in rows] == [4, 1]
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(out / "rows.parquet").to_pylist()
    for row in rows:
        assert table[row["run"]]["size"] == row["size"]
        assert table[row["run"]]["delay_s"] == row["delay_s"]


def test_what_is_done_is_not_done_again(finished):
    spec, out, summary = finished
    before = (out / "rows.parquet").stat().st_mtime_ns
    assert campaign.run(spec, out) == summary
    assert (out / "rows.parquet").stat().st_mtime_ns == before


def test_what_makes_no_sense_is_refused(finished, tmp_path):
    spec, out, _ = finished
    with pytest.raises(gtfdi.DesignError, match="expected below the number of runs, 6, found 6"):
        campaign.rows(spec, [6], out)
    with pytest.raises(gtfdi.DesignError, match="none.toml"):
        campaign.run(tmp_path / "none.toml", tmp_path / "out")
    changed = tmp_path / "other.toml"
    changed.write_text(SPEC.replace("RUNS", "7"))
    with pytest.raises(gtfdi.DesignError, match="drift"):
        campaign.run(changed, out)
    with pytest.raises(gtfdi.OptionError, match="^option folders: expected two or more, found 1$"):
        campaign.compare([out], tmp_path / "both")


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for another process")
def test_ctrl_c_leaves_a_campaign_that_goes_on(tmp_path):
    spec, out = tmp_path / "long.toml", tmp_path / "long"
    spec.write_text(SPEC.replace("RUNS", "200000"))
    # A shell's background jobs ignore the signal, and so would their children.
    program = f"""
        import signal
        from gtfdi import campaign
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            campaign.run({str(spec)!r}, {str(out)!r})
        except KeyboardInterrupt:
            print("stopped", flush=True)
    """
    # It answers within a tenth of a second; what this allows for is a machine that is busy.
    command = [sys.executable, "-c", textwrap.dedent(program)]
    assert interrupted(command, out, within_s=5.0) == ("stopped\n", 0)
    rows = campaign.rows(spec, [0], out)
    assert rows[0]["status"] == "ok"
