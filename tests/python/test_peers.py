"""The comparisons with other packages still run: all contenders that are installed agree."""

import subprocess
import sys

import pytest

NAMES = ["arx", "residual", "fleet", "detectors", "riccati", "log_writing"]


@pytest.fixture
def runs(root):
    """All scripts at once with few samples, so that they start side by side."""
    folder = root / "benches" / "peers"
    commands = [[sys.executable, folder / f"{name}.py", "--quick"] for name in NAMES]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return dict(zip(NAMES, [subprocess.Popen(each, **pipes) for each in commands], strict=True))


def test_peers_agree_with_gtfdi(root, runs):
    listed = {path.stem for path in (root / "benches" / "peers").glob("*.py")}
    assert listed == {*NAMES, "timing"}
    for name, run in runs.items():
        printed, errors = run.communicate(timeout=120)
        assert run.returncode == 0, f"{name}: {errors}"
        assert "checked" in printed or "not installed" in printed, name
