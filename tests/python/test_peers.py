"""The comparisons with other packages still run, and what is installed agrees with gtfdi."""

import subprocess
import sys

#: What the scripts share.
SHARED = ("systems", "timing")

# One process for all, since most of the time is the imports; of its own, since libraries read the
# number of their threads when they are loaded.
RUN_ALL = """
import runpy, sys
folder, *names = sys.argv[1:]
sys.path.insert(0, folder)
sys.argv[1:] = ["--quick"]
for name in names:
    print("script", name, flush=True)
    runpy.run_path(f"{folder}/{name}.py", run_name="__main__")
"""


def test_peers_agree(root):
    folder = root / "benches" / "peers"
    names = sorted(path.stem for path in folder.glob("*.py") if path.stem not in SHARED)
    assert len(names) == 6
    command = [sys.executable, "-c", RUN_ALL, folder, *names]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr}"
    sections = done.stdout.split("script ")[1:]
    assert [section.partition("\n")[0] for section in sections] == names
    assert all("checked" in section or "not installed" in section for section in sections)
