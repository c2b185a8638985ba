"""What is in a file, and all that is wrong with it."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import gtfdi

ROWS = [f"{t},{t % 5},{(t * t) % 7}" for t in range(60)]


def write(folder, rows, name="export.csv", header="time,u,y", encoding="utf-8"):
    path = folder / name
    path.write_bytes("\n".join([header, *rows, ""]).encode(encoding))
    return path


def test_a_whole_table_has_nothing_that_read_would_refuse(tmp_path):
    path = write(tmp_path, ROWS)
    report = gtfdi.check(path)
    assert report["damages"] == []
    assert (report["rows"], report["layout"], report["separator"]) == (60, "wide", ",")
    assert (report["time"]["column"], report["time"]["period_s"]) == ("time", 1.0)
    assert report["time"]["span_s"] == 59.0
    u, y = report["tags"]
    assert (u["name"], u["values"], u["minimum"], u["maximum"]) == ("u", 60, 0.0, 4.0)
    assert (y["name"], y["missing"], y["constant"]) == ("y", 0, False)
    assert len(gtfdi.read(path, inputs="u", outputs="y")) == 60


def test_every_damage_is_named_with_what_mends_it(tmp_path):
    rows = list(ROWS)
    rows[10] = "10,Bad,2"
    rows[20] = "20,1,2x"
    rows[30] = "29,0,1"
    del rows[40]
    path = write(tmp_path, rows)
    damages = gtfdi.check(path)["damages"]
    assert [(each["kind"], each["line"], each["tag"], each["mended_by"]) for each in damages] == [
        ("missing", 12, "u", "missing"),
        ("number", 22, "y", "bad_values"),
        ("duplicate", 32, "time", "resample_s"),
        ("gap", 33, "time", "missing"),
        ("gap", 42, "time", "missing"),
    ]
    # Keywords of Python stand where the command line has options.
    assert not any("--" in each["text"] for each in damages)
    assert "found `2x`" in damages[1]["text"] and str(path) in damages[1]["text"]
    # What ``read`` refuses first is the first.
    with pytest.raises(gtfdi.LogError) as caught:
        gtfdi.read(path, inputs="u", outputs="y")
    assert "line 12, column `u`" in str(caught.value)


def test_what_stands_in_the_way_is_passed_over(tmp_path):
    readings = [f"{t};{t % 3},5;{t % 4},25" for t in range(30)]
    rows = ["", "time;10FT1;t\u00fcr", ";kg/h;\u00b0C", *readings]
    path = write(tmp_path, rows, header="Anlage 3", encoding="windows-1252")
    report = gtfdi.check(path)
    assert [(each["kind"], each["mended_by"]) for each in report["damages"]] == [
        ("file", "encoding"),
        ("file", "header_line"),
    ]
    assert [tag["name"] for tag in report["tags"]] == ["10FT1", "t\u00fcr"]
    assert [tag["unit"] for tag in report["tags"]] == ["kg/h", "\u00b0C"]
    assert report["decimal"] == "comma"
    given = gtfdi.check(path, encoding="windows-1252", header_line=3, decimal="comma")
    assert given["damages"] == [] and given["tags"] == report["tags"]


def test_readings_are_judged_as_the_samples_that_they_become(tmp_path):
    shifts = {"u": 0.0, "y": 0.3}
    rows = [f"{tag},{t + shifts[tag]},{(t * t) % 5}" for t in range(40) for tag in shifts]
    path = write(tmp_path, rows, header="tag,time,value")
    plain = gtfdi.check(path)
    assert plain["layout"] == "long"
    assert [each["mended_by"] for each in plain["damages"]] == ["resample_s"]
    done = gtfdi.check(path, resample_s=2.0, resample_method="mean")
    assert done["damages"] == [] and done["time"]["period_s"] == 2.0
    assert (done["resampled"]["samples"], done["resampled"]["step_s"]) == (20, 2.0)
    assert [tag["averaged_from"] for tag in done["resampled"]["tags"]] == [40, 40]


def test_roles_are_suggested(tmp_path):
    run = gtfdi.simulate(120.0, seed=4).measured.select(["a_v", "M_f"], ["q_c", "t3"])
    header = ",".join(["time", "valve_position", "fuel_flow_setpoint", *run.outputs])
    samples = np.column_stack([run.time_s, run.u, run.y]).tolist()
    rows = [",".join(map(repr, sample)) for sample in samples]
    report = gtfdi.check(write(tmp_path, rows, header=header))
    suggested = {each["tag"]: each["confidence"] for each in report["suggested_inputs"]}
    assert suggested["fuel_flow_setpoint"] == "likely"
    assert all(0.0 <= each["lead_share"] <= 1.0 for each in report["suggested_inputs"])
    only = gtfdi.check(tmp_path / "export.csv", inputs="valve*", outputs=["t3"])
    assert [tag["name"] for tag in only["tags"]] == ["valve_position", "t3"]


def test_logs_are_looked_at_too(tmp_path):
    gtfdi.simulate(8.0).write(tmp_path / "run.mcap")
    report = gtfdi.check(tmp_path / "run.mcap")
    assert (report["topic"], report["rows"]) == ("/plant/measured", 100)
    assert report["damages"] == []
    wrong = gtfdi.check(tmp_path / "run.mcap", topic="/plant/other")["damages"]
    assert [each["mended_by"] for each in wrong] == ["topic"]


def test_what_cannot_be_looked_at_is_refused(tmp_path):
    with pytest.raises(gtfdi.LogError, match="nothing.csv"):
        gtfdi.check(tmp_path / "nothing.csv")
    (tmp_path / "notes.txt").write_text("text")
    with pytest.raises(gtfdi.LogError, match="`.txt`"):
        gtfdi.check(tmp_path / "notes.txt")
    path = write(tmp_path, ROWS)
    message = "^option `hold_at_most_s`: expected with resample_s, found without$"
    with pytest.raises(gtfdi.OptionError, match=message):
        gtfdi.check(path, hold_at_most_s=3.0)
    message = "^option decimal: expected point or comma, found \"dot\"$"
    with pytest.raises(gtfdi.OptionError, match=message):
        gtfdi.check(path, decimal="dot")


def test_it_is_what_the_command_line_prints(tmp_path):
    binary = os.environ.get("GTFDI_BINARY")
    if not binary:
        pytest.skip("GTFDI_BINARY is not set: no command line to compare with")
    rows = list(ROWS)
    rows[7] = "7,No Data,3"
    path = write(tmp_path, rows)
    command = [Path(binary), "data", "check", path, "--json"]
    printed = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    assert printed.pop("file") == str(path)
    printed.pop("schema_version")
    own = gtfdi.check(path)
    for report in own, printed:
        for damage in report["damages"]:
            damage.pop("text"), damage.pop("mended_by")
    assert own == printed
