"""The notebooks run from their first cell to their last, and are stored without outputs."""

import importlib.util
import json

import pytest
from document import repository

NOTEBOOKS = sorted((repository() / "docs" / "notebooks").glob("*.ipynb"))
#: Seconds after which a cell hangs.
CELL_S = 300


def cells(path):
    return json.loads(path.read_text(encoding="utf-8"))["cells"]


def code(path):
    return ["".join(cell["source"]) for cell in cells(path) if cell["cell_type"] == "code"]


def is_there(name):
    return importlib.util.find_spec(name) is not None


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, tmp_path, monkeypatch):
    """With Jupyter's own machinery where it is installed, else its cells in plain Python."""
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    if is_there("nbclient") and is_there("ipykernel"):
        import nbclient
        import nbformat

        notebook = nbformat.read(path, as_version=4)
        nbformat.validate(notebook)
        client = nbclient.NotebookClient(
            notebook, timeout=CELL_S, resources={"metadata": {"path": str(tmp_path)}}
        )
        client.execute()
    else:
        monkeypatch.setenv("MPLBACKEND", "Agg")
        names = {"__name__": "__main__"}
        for place, text in enumerate(code(path)):
            exec(compile(text, f"{path.name}, code cell {place}", "exec"), names)  # noqa: S102


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_stored_without_outputs(path):
    for cell in cells(path):
        if cell["cell_type"] == "code":
            assert (cell["outputs"], cell["execution_count"]) == ([], None)
    # Text alone.
    assert path.stat().st_size < 40_000


def test_there_are_three():
    assert len(NOTEBOOKS) == 3
