"""The walk through the Tennessee Eastman records in Python: what the page prints, and the alarms of
the command line."""

import json
import os
import shutil
import subprocess

import pytest
from document import blocks, differs, run

import gtfdi

RECORDS = ("d00_te", "d01_te", "d05_te", "d11_te")
READING = {"inputs": [], "outputs": ["xmeas*", "xmv*"], "sample_time_s": 180}


@pytest.fixture(scope="module")
def folder(reference_data, tmp_path_factory):
    """The records under their own names."""
    place = tmp_path_factory.mktemp("tep")
    for name in ("d00", *RECORDS):
        shutil.copy(reference_data / "tep" / f"{name}.csv", place)
    return place


def test_the_page_prints_what_its_python_prints(folder, root):
    text = (root / "docs" / "tennessee_eastman.md").read_text(encoding="utf-8")
    (block,) = (block for block in blocks(text) if block.language == "python")
    difference = differs(block.printed, run(block, folder, None))
    assert difference is None, difference


@pytest.fixture(scope="module")
def command_line(folder):
    """What `detect` reports of each record."""
    binary = os.environ.get("GTFDI_BINARY")
    if not binary:
        pytest.skip("GTFDI_BINARY is not set: no program to compare with")

    def gtfdi_(*arguments):
        done = subprocess.run(
            [binary, *arguments, "--json"], cwd=folder, capture_output=True, text=True, check=True
        )
        return json.loads(done.stdout)

    gtfdi_("identify", "d00.csv", "--outputs", "xmeas*,xmv*", "--structure", "full", "--order", "1",
           "--ridge", "0.1", "--sample-time", "180", "--out", "model.json")
    gtfdi_("design", "--model", "model.json", "--healthy", "d00.csv", "--generator", "kalman",
           "--watch", "joint", "--exceedance", "0.01", "--consecutive", "6", "--out", "bank.json")
    return {name: gtfdi_("detect", "--bank", "bank.json", f"{name}.csv") for name in RECORDS}


def test_python_raises_the_alarms_of_the_command_line(folder, command_line):
    normal = gtfdi.read(folder / "d00.csv", **READING)
    model = gtfdi.arx(normal, order=1, structure="full", ridge=0.1)
    bank = gtfdi.design(
        model, [normal], generator="kalman", watch="joint", exceedance=0.01, consecutive=6,
        in_sample=True,
    )
    alarms = 0
    for name in RECORDS:
        found = bank.detect(gtfdi.read(folder / f"{name}.csv", **READING))
        report = command_line[name]
        assert len(found.time_s) == report["samples"] == 960
        # One code and one road: the same numbers, to the bit.
        keys = ("tag", "time_s", "first_exceedance_s", "end_s", "statistic", "threshold")
        expected = [{key: alarm[key] for key in keys} for alarm in report["alarms"]]
        assert [{key: alarm[key] for key in keys} for alarm in found.alarms] == expected, name
        assert found.share_above_limit[0] == report["outputs"][0]["exceedance_share"]
        alarms += len(expected)
        # A bank file of one side is read by the other.
        stored = gtfdi.Bank.load(folder / "bank.json")
        assert stored.detectors[0]["limit"] == bank.detectors[0]["limit"]
    assert alarms > 0
    assert command_line["d00_te"]["alarms"] == []


def test_python_draws_the_page_of_the_command_line(folder, command_line):
    assert command_line["d05_te"]["alarms"]
    subprocess.run(
        [os.environ["GTFDI_BINARY"], "detect", "--bank", "bank.json", "d05_te.csv", "--report", "cli"],
        cwd=folder, capture_output=True, check=True,
    )
    bank = gtfdi.Bank.load(folder / "bank.json")
    gtfdi.write_report(folder / "python", bank, gtfdi.read(folder / "d05_te.csv", **READING))
    # The statistic, 52 residuals and 52 outputs, each as SVG and CSV, the same bytes.
    names = sorted(path.name for path in (folder / "cli" / "figures").iterdir())
    assert len(names) == 2 * 105
    for name in names:
        own, other = (folder / side / "figures" / name for side in ("python", "cli"))
        assert own.read_bytes() == other.read_bytes(), name
