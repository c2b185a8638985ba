"""Campaigns on the workers of an executor: the bytes of one process, and what goes wrong."""

import multiprocessing
import os
import pickle
import re
import sys
import textwrap
import threading
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor

import pytest
from interrupted_campaign import interrupted

import gtfdi
from gtfdi import campaign
from gtfdi._gtfdi import _CampaignDesk, _CampaignTask

# Four chunks of 32 runs, the last one of 4; noise is a share of signals, so it is sent too.
SPEC = """
seed = 5
runs = RUNS
healthy_share = 0.2
[plant]
noise = "table8"
noise_record_s = 60.0
[record]
duration_s = 20.0
onset_s = [5.0, 10.0]
[[faults]]
case = "thermocouple_drift"
size = { log_uniform = [0.05, 0.5] }
shape = { ramp = { rise_s = 3.0 } }
[model]
method = "arx"
record_s = 60.0
order = 2
[bank]
arl0_h = 0.02
calibration_h = 0.05
tests = [{ statistic = "cusum" }]
"""


def files(folder):
    """The bytes of all files of a campaign, by their names."""
    paths = [path for path in folder.rglob("*") if path.is_file()]
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """A campaign in this process: its file, its folder and what it says."""
    folder = tmp_path_factory.mktemp("alone")
    spec = folder / "drift.toml"
    spec.write_text(SPEC.replace("RUNS", "100"))
    return spec, folder / "drift", campaign.run(spec, folder / "drift")


@pytest.fixture(scope="module")
def processes():
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as executor:
        yield executor


class Executing(Executor):
    """Two threads, and something between them and whoever hands out work."""

    def __init__(self, between):
        self.between = between
        self.threads = ThreadPoolExecutor(2)

    def submit(self, call, /, *arguments, **named):
        return self.threads.submit(self.between, call, *arguments, **named)

    def shutdown(self, wait=True, *, cancel_futures=False):
        self.threads.shutdown(wait, cancel_futures=cancel_futures)


class Client:
    """What is asked of a client of dask."""

    def __init__(self, executor):
        self.executor = executor

    def submit(self, *_):
        raise AssertionError("its executor is asked")

    def get_executor(self, *, pure):
        assert pure is False
        return self.executor


@pytest.mark.parametrize("kind", ["processes", "threads", "client"])
def test_the_files_are_those_of_one_process(kind, alone, processes, tmp_path):
    spec, out, summary = alone
    with ThreadPoolExecutor(2) as threads:
        executor = {"processes": processes, "threads": threads, "client": Client(threads)}[kind]
        assert campaign.run(spec, tmp_path / "out", executor) == summary
        # What is done is not done again.
        executor = Executing(lambda *_: pytest.fail("nothing was left to do"))
        assert campaign.run(spec, tmp_path / "out", executor) == summary
    assert files(tmp_path / "out") == files(out)


def test_a_bound_number_of_batches_is_handed_out(alone, tmp_path):
    spec, _, summary = alone
    lock, under_way, most = threading.Lock(), set(), []

    class Counting(Executing):
        def submit(self, *arguments):
            with lock:
                under_way.add(tuple(arguments[-1]))
                most.append(len(under_way))
            return super().submit(*arguments)

    def between(call, task, chunks):
        outcome = call(task, chunks)
        with lock:
            under_way.discard(tuple(chunks))
        return outcome

    with Counting(between) as executor:
        assert campaign.run(spec, tmp_path / "out", executor, in_flight=1) == summary
    assert most == [1] * len(most) and len(most) >= 1


def test_the_error_of_a_worker_names_its_runs_and_the_campaign_goes_on(alone, tmp_path):
    spec, out, summary = alone
    came_back = threading.Event()

    def between(call, task, chunks):
        if 2 in chunks:
            assert came_back.wait(60.0)
            raise OSError("no room on this worker")
        outcome = call(task, chunks)
        if 1 in chunks:
            came_back.set()
        return outcome

    folder = tmp_path / "out"
    message = (
        r"^runs 64 to 95: no room on this worker; (32|64|68|96) of 100 runs are kept in "
        rf"{re.escape(str(folder))}, and the same call goes on from there$"
    )
    with Executing(between) as executor, pytest.raises(gtfdi.GtfdiError, match=message) as failed:
        campaign.run(spec, folder, executor)
    assert isinstance(failed.value.__cause__, OSError)
    # The exception is still there, and the folder is free and has what had come back.
    kept = int(re.search(r"(\d+) of 100", str(failed.value))[1])
    chunks = list(folder.glob("rows-*.parquet"))
    assert sum(4 if "rows-00003" in path.name else 32 for path in chunks) == kept
    assert campaign.run(spec, folder) == summary
    assert files(folder) == files(out)


def test_a_worker_that_dies_is_named_by_its_runs(alone, tmp_path):
    spec, out, summary = alone

    class Dying(ProcessPoolExecutor):
        def submit(self, call, task, chunks):
            if 1 in chunks:
                return super().submit(os._exit, 3)
            return super().submit(call, task, chunks)

    context = multiprocessing.get_context("spawn")
    with Dying(1, mp_context=context) as executor:
        with pytest.raises(gtfdi.GtfdiError, match=r"^runs \d+ to \d+: .*terminated"):
            campaign.run(spec, tmp_path / "out", executor)
        # Nor does a broken pool take any more work.
        with pytest.raises(gtfdi.GtfdiError, match=r"^runs \d+ to \d+: .*goes on from there$"):
            campaign.run(spec, tmp_path / "out", executor)
    assert campaign.run(spec, tmp_path / "out") == summary
    assert files(tmp_path / "out") == files(out)


def test_a_worker_of_another_version_is_refused(alone, tmp_path):
    spec, _, _ = alone

    def elsewhere(call, task, chunks):
        """As if the pickle had gone to another machine."""
        sent = pickle.dumps(task)
        kind, (version, text) = pickle.loads(sent).__reduce__()
        assert (kind, version) == (_CampaignTask, gtfdi.__version__)
        return call(_CampaignTask("9.0.0", text), chunks)

    message = (
        r"^runs \d+ to \d+: expected a worker with gtfdi 9\.0\.0, with which the campaign began, "
        rf"found {re.escape(gtfdi.__version__)}; 0 of 100 runs are kept in "
    )
    with Executing(elsewhere) as executor, pytest.raises(gtfdi.DesignError, match=message):
        campaign.run(spec, tmp_path / "out", executor)


def test_rows_of_something_else_are_not_kept(alone, tmp_path):
    spec, _, _ = alone

    def wrong(call, task, chunks):
        spent_s, parts = call(task, chunks)
        return spent_s, [(chunk, sha256, part[:-1]) for chunk, sha256, part in parts]

    message = r"^runs \d+ to \d+: expected the rows of chunk \d+ of this campaign, found bytes with"
    with Executing(wrong) as executor, pytest.raises(gtfdi.DesignError, match=message):
        campaign.run(spec, tmp_path / "out", executor)
    assert not list((tmp_path / "out").glob("rows-*"))


def test_what_is_no_executor_is_refused_before_anything_is_made(alone, tmp_path):
    spec, _, _ = alone
    with pytest.raises(gtfdi.OptionError, match="^option executor: expected .*, found int$"):
        campaign.run(spec, tmp_path / "out", 2)
    with ThreadPoolExecutor(1) as executor:
        with pytest.raises(gtfdi.OptionError, match="^option in_flight: expected 1 or more, found"):
            campaign.run(spec, tmp_path / "out", executor, in_flight=0)
    assert not (tmp_path / "out").exists()


PROGRAM = """
    import multiprocessing, signal, time
    from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
    from gtfdi import campaign

    if __name__ == "__main__":
        # A shell's background jobs ignore the signal, and so would their children.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        executor = EXECUTOR
        try:
            campaign.run("long.toml", "long", executor)
        except KeyboardInterrupt as stopped:
            kept = stopped  # with all that it refers to
            executor.shutdown()
            start = time.process_time()
            time.sleep(0.5)
            print("stopped", time.process_time() - start < 0.1, flush=True)
"""
EXECUTORS = {
    "processes": "ProcessPoolExecutor(2, mp_context=multiprocessing.get_context('spawn'))",
    "threads": "ThreadPoolExecutor(2)",
}


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for another process")
@pytest.mark.parametrize("kind", EXECUTORS)
def test_ctrl_c_leaves_whole_chunks_and_a_free_folder(kind, tmp_path):
    spec, out = tmp_path / "long.toml", tmp_path / "long"
    spec.write_text(SPEC.replace("RUNS", "200000"))
    program = tmp_path / "program.py"
    program.write_text(textwrap.dedent(PROGRAM).replace("EXECUTOR", EXECUTORS[kind]))
    # Threads end with their group of runs, processes with their batch.
    command = [sys.executable, program.name]
    found = interrupted(command, out, within_s=60.0, cwd=tmp_path)
    assert found == ("stopped True\n", 0)
    chunks = list(out.glob("rows-*.parquet"))
    assert chunks and not list(out.glob("*.part"))
    desk = _CampaignDesk(spec, out)
    assert len(desk.missing()) == 200_000 / 32 - len(chunks)
    desk.close()
    with pytest.raises(gtfdi.OptionError, match="expected one that is open, found one that was"):
        desk.missing()
