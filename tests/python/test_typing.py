"""The stubs say what the compiled module has, and the Python half is typed."""

import subprocess
import sys
from pathlib import Path

import pytest

import gtfdi

pytest.importorskip("mypy")
PACKAGE = Path(gtfdi.__file__).parent


def run(*arguments, folder):
    return subprocess.run(
        [sys.executable, "-m", *arguments], capture_output=True, text=True, cwd=folder
    )


def test_the_stubs_are_those_of_the_module(tmp_path):
    done = run("mypy.stubtest", "gtfdi", folder=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_python_half_is_strictly_typed(tmp_path):
    options = "--strict", "--ignore-missing-imports", "--cache-dir", str(tmp_path / "cache")
    done = run("mypy", *options, "-p", "gtfdi", folder=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_user_is_told_of_wrong_types(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(
        "import gtfdi\n"
        "model = gtfdi.arx([1.0], [2.0], order=1)\n"
        "reveal_type(model.output_model(0).model.A)\n"
        "gtfdi.arx([1.0], [2.0], order='three')\n"
        "gtfdi.StateSpace.from_json(3)\n"
    )
    done = run("mypy", "--cache-dir", str(tmp_path / "cache"), program.name, folder=tmp_path)
    assert 'Revealed type is "numpy.ndarray[' in done.stdout, done.stdout
    errors = [line for line in done.stdout.splitlines() if ": error: " in line]
    assert [line.split(":")[1] for line in errors] == ["4", "5"], done.stdout


def test_types_are_announced():
    assert (PACKAGE / "py.typed").is_file()
