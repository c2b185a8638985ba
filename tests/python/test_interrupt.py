"""Ctrl-C in long work: the call ends with KeyboardInterrupt, says what becomes of the work, and most
work ends with it."""

import os
import signal
import subprocess
import sys
import textwrap
import time

import pytest

import gtfdi

# A call answers within two looks, 0.1 s; what this allows for is a machine that is busy.
LIMIT_S = 5.0

# Each is far longer than a test may take, so that an end can only be the interrupt's.
CALLS = {
    "simulate": "gtfdi.simulate(1e5)",
    "arx": "gtfdi.arx(u, y, order=(1, 400))",
    "eiv": "gtfdi.eiv(u, y, order=(1, 60))",
    "eiv_order_table": "gtfdi.eiv_order_table(u, y, (1, 60))",
    "frisch": "gtfdi.frisch(u, y, order=60)",
    "frisch_order_table": "gtfdi.frisch_order_table(u, y, (1, 200))",
    "order_table": "gtfdi.order_table(u, y, (1, 400))",
    "optimise_observer": (
        "gtfdi.optimise_observer(part, [(healthy, faulty)], random_starts=10**7, radius=0.9)"
    ),
    "reproduce": "gtfdi.reproduce('out')",
    "SimulatedRuns": "SimulatedRuns(glr, lambda path: u[:1000, 0], 10**9, 1000)",
    "process": "glr.process(np.zeros(100_000_000))",
    "write_report": "gtfdi.write_report('report', model, *long)",
}

# Of these nothing goes on in the background. Of the others some come to their own end there.
ENDED = [
    "simulate",
    "eiv",
    "eiv_order_table",
    "frisch",
    "frisch_order_table",
    "SimulatedRuns",
    "process",
    "write_report",
]

# Between two stages of a table of orders or a report are seconds on a machine that is busy; the
# calls themselves would take minutes.
END_S = 30.0

# A shell's background jobs ignore the signal, and so would their children.
PROGRAM = """
    import os, signal, sys, time
    import numpy as np
    signal.signal(signal.SIGINT, signal.default_int_handler)
    import gtfdi
    from gtfdi.run_length import SimulatedRuns
    from gtfdi.statistics import Glr

    glr = Glr("ramp", (1e-4, 1e-2), 12.0, longest=65_536)
    generator = np.random.default_rng(1)
    u = generator.standard_normal((40_000, 2))
    y = generator.standard_normal((40_000, 1)) + np.cumsum(u[:, :1], axis=0) / 100
    drift = {"case": "thermocouple_drift", "onset_s": 10.0, "rate_percent_per_h": 50.0}
    healthy, faulty = (
        gtfdi.simulate(40.0, seed=7, faults=faults).measured for faults in ([], [drift])
    )
    report = healthy.select(["a_v", "M_f"], ["t3"])
    model = gtfdi.arx(report, order=3)
    long = [np.tile(part, (1000, 1)) for part in (report.u, report.y)]
    part = gtfdi.arx(healthy, order=3, inputs=["a_v", "M_f"], outputs="t3").output_model(0)

    def works():
        before = time.process_time()
        time.sleep(0.25)
        return time.process_time() - before > 0.05

    print("ready", flush=True)
    try:
        CALL
    except KeyboardInterrupt as stopped:
        print("stopped", *getattr(stopped, "__notes__", []), flush=True)
        assert gtfdi.steady_state()["p7"] > 0.0  # the package goes on
        end = time.monotonic() + WAIT
        while WAIT and works():
            assert time.monotonic() < end, "it goes on"
        assert not os.path.exists("report")
        # What was given up may go on in its thread; leaving ends it.
        print("well", file=sys.stderr, flush=True)
        sys.exit(0)
    print("the call came to its end", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for another process")
@pytest.mark.parametrize("name", CALLS)
def test_ctrl_c_ends_a_long_call(name, tmp_path):
    wait_s = END_S if name in ENDED else 0.0
    program = textwrap.dedent(PROGRAM).replace("CALL", CALLS[name]).replace("WAIT", str(wait_s))
    child = subprocess.Popen(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
    )
    try:
        assert child.stdout.readline() == "ready\n", child.stderr.read()
        # Within the call: what comes before it has been said.
        with pytest.raises(subprocess.TimeoutExpired):
            child.wait(0.7)
        os.kill(child.pid, signal.SIGINT)
        start = time.monotonic()
        out = child.stdout.readline()
        assert time.monotonic() - start < LIMIT_S
        _, complaint = child.communicate(timeout=LIMIT_S + wait_s)
    finally:
        child.kill()
    assert out.startswith("stopped"), (out, complaint)
    assert complaint.endswith("well\n"), (out, complaint)
    assert child.returncode == 0, complaint
    if sys.version_info >= (3, 11) and name not in ("SimulatedRuns", "process"):
        assert "the result is given up" in out


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for another process")
def test_a_reproduction_that_was_given_up_ends_and_writes_nothing(tmp_path):
    program = """
        import os, signal, threading, time
        from pathlib import Path
        import gtfdi

        signal.signal(signal.SIGINT, signal.default_int_handler)
        threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        try:
            gtfdi.reproduce("out")
            raise SystemExit("it came to its end")
        except KeyboardInterrupt:
            pass

        def works():
            before = time.process_time()
            time.sleep(0.5)
            return time.process_time() - before > 0.1

        assert works()
        end = time.monotonic() + 120.0
        while works():
            assert time.monotonic() < end, "it goes on"
        assert not Path("out").exists()
    """
    program = textwrap.dedent(program)
    subprocess.run([sys.executable, "-c", program], check=True, timeout=300, cwd=tmp_path)


def test_a_reproduction_into_a_file_is_refused(tmp_path):
    (tmp_path / "notes").write_text("")
    message = f"^option folder: expected a folder, found the file {tmp_path / 'notes'}$"
    for folder in (tmp_path / "notes", tmp_path / "notes" / "out"):
        with pytest.raises(gtfdi.OptionError, match=message):
            gtfdi.reproduce(folder)


def test_a_handler_that_does_not_raise_does_not_end_the_call():
    program = """
        import os, signal, threading, time
        import gtfdi

        heard = []
        signal.signal(signal.SIGINT, lambda *_: heard.append(True))
        threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        run = gtfdi.simulate(4000.0)
        assert len(run) == 50_000, len(run)
        time.sleep(0.3)
        assert heard
    """
    subprocess.run([sys.executable, "-c", textwrap.dedent(program)], check=True, timeout=300)
