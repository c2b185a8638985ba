"""Contenders timed side by side in one process, on one thread, after their results were compared.

Import this module before NumPy: libraries read the number of their threads when they are loaded.
"""

import argparse
import importlib
import importlib.metadata
import math
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

for _variable in (
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
):
    os.environ[_variable] = "1"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["JAX_PLATFORMS"] = "cpu"

#: A round of a contender is as many runs as take this long.
ROUND_S = 0.05

_parser = argparse.ArgumentParser()
_parser.add_argument("--quick", action="store_true", help="few samples, check only, time nothing")
_parser.add_argument("--rounds", type=int, default=7, help="rounds that are timed (default 7)")
_options = _parser.parse_args()

#: Whether results are only compared, on few samples.
QUICK: bool = _options.quick


def optional(module: str) -> Any:
    """A module, or None where its package is not installed."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        # What is installed but broken is an error.
        if error.name != module.partition(".")[0]:
            raise
        return None


def describe(*packages: str) -> None:
    """Prints the machine, the day and the versions of what is compared."""
    versions = [f"Python {platform.python_version()}"]
    for package in packages:
        try:
            versions.append(f"{package} {importlib.metadata.version(package)}")
        except importlib.metadata.PackageNotFoundError:
            versions.append(f"{package} not installed")
    print(f"{_processor()}, {os.cpu_count()} cores, {time.strftime('%Y-%m-%d')}")
    print(", ".join(versions))


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def relative_error(found: Any, expected: Any) -> float:
    """The largest difference over the largest expected value; infinite where a value is NaN."""
    import numpy as np

    found, expected = np.asarray(found), np.asarray(expected)
    if found.shape != expected.shape:
        sys.exit(f"expected the shape {expected.shape}, found {found.shape}")
    error = float(np.abs(found - expected).max() / np.abs(expected).max())
    return error if math.isfinite(error) else math.inf


class Race:
    """Contenders at one piece of work; the first one, and all called gtfdi, are gtfdi's.

    ``figure`` and ``unit`` make what is printed of the seconds that a unit of work takes.
    """

    def __init__(self, title: str, unit: str, figure: Callable[[float], float]) -> None:
        self.title, self.unit, self.figure = title, unit, figure
        self.rows: list[dict[str, Any]] = []

    def add(
        self,
        name: str,
        run: Callable[[], Any],
        *,
        work: float = 1.0,
        error: Callable[[Any], float] | None = None,
        tolerance: float = 0.0,
        note: str = "",
    ) -> Any:
        """Adds a contender whose ``run`` does so much ``work``, and returns its result.

        ``error`` compares the result with gtfdi's; above the ``tolerance`` the program ends here.
        """
        result = run()
        found = error(result) if error else None
        if found is not None and not found <= tolerance:
            sys.exit(f"{self.title}: {name} differs by {found:.1e}, at most {tolerance:.0e}")
        self.rows.append(
            {"name": name, "run": run, "work": work, "error": found, "note": note, "times": []}
        )
        return result

    def absent(self, name: str, why: str = "not installed") -> None:
        """Adds a row for a contender that is not there."""
        self.rows.append({"name": name, "run": None, "error": None, "note": why, "times": []})

    def finish(self) -> None:
        """Times all contenders, once a round each, and prints a row for each."""
        print(f"\n{self.title}")
        present = [row for row in self.rows if row["run"]]
        if not QUICK:
            for row in present:
                _, wall_s = _timed(row["run"], 1)
                row["repeats"] = max(1, math.ceil(ROUND_S / max(wall_s, 1e-9)))
            for _ in range(_options.rounds):
                for row in present:
                    row["times"].append(_timed(row["run"], row["repeats"]))
        bases = [index for index, row in enumerate(self.rows) if row["name"].startswith("gtfdi")]
        header = "".join(f"{f'[{base}] is':>10}" for base in bases)
        print(f"{'':<52}{self.unit:>16}{header}{'error':>10}")
        for index, row in enumerate(self.rows):
            print(self._line(index, row, bases))

    def _line(self, index: int, row: dict[str, Any], bases: list[int]) -> str:
        line, note = f"{f'[{index}] ' + row['name']:<52}", row["note"]
        if row["times"]:
            cpu_s = [cpu / row["work"] for cpu, _ in row["times"]]
            line += f"{self.figure(statistics.median(cpu_s)):>16.4g}"
            for base in bases:
                line += f"{f'{self._ratio(row, base, 0):.3g} x':>10}"
            threads = statistics.median(cpu / wall for cpu, wall in row["times"])
            if threads > 1.1:
                wall = f"{self._ratio(row, bases[0], 1):.3g} x by wall time"
                note = "; ".join(filter(None, [note, f"{threads:.1f} threads, {wall}"]))
        elif row["run"]:
            line += f"{'checked':>16}{'':>{10 * len(bases)}}"
        else:
            line += f"{'-':>16}{'':>{10 * len(bases)}}"
        error = "" if row["error"] is None else f"{row['error']:.0e}"
        return f"{line}{error:>10}  {note}".rstrip()

    def _ratio(self, row: dict[str, Any], base: int, clock: int) -> float:
        """How many times as fast the base is, the median over rounds."""
        own = self.rows[base]
        pairs = zip(row["times"], own["times"], strict=True)
        ratios = [a[clock] / row["work"] / (b[clock] / own["work"]) for a, b in pairs]
        return statistics.median(ratios)


def _timed(run: Callable[[], Any], repeats: int) -> tuple[float, float]:
    """Seconds of the process and of the clock that a run takes."""
    cpu, wall = time.process_time(), time.perf_counter()
    for _ in range(repeats):
        run()
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    return cpu / repeats, wall / repeats


def milliseconds(seconds: float) -> float:
    return 1e3 * seconds


def microseconds(seconds: float) -> float:
    return 1e6 * seconds


def millions_a_second(seconds: float) -> float:
    return 1e-6 / seconds


def thousands_a_second(seconds: float) -> float:
    return 1e-3 / seconds
