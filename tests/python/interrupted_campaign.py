"""A campaign in a process of its own that Ctrl-C meets while rows are being added."""

import os
import signal
import subprocess
import time


def interrupted(command, out, within_s, cwd=None):
    """What the process prints and its exit code; it has so many seconds to end in."""
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=cwd)
    try:
        # The bank is made, and rows are being added.
        for _ in range(600):
            if list(out.glob("rows-*.parquet")):
                break
            assert child.poll() is None
            time.sleep(0.2)
        os.kill(child.pid, signal.SIGINT)
        text, _ = child.communicate(timeout=within_s)
    finally:
        child.kill()
    return text, child.returncode
