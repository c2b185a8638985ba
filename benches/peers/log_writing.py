"""MCAP logs: gtfdi beside the writers of mcap and Foxglove's SDK.

The peers write numbers as they are. The Python package of gtfdi writes logs of whole runs, not
single messages. So the log of a run is timed beside peers that write the same numbers; and for
messages of 28 numbers `LogWriter` in Rust stands for gtfdi, measured before and after the peers by
`cargo bench -p gt-mcap --bench writing`, in wall time and of another record made by the same rule.
"""

import os
import re
import shutil
import statistics
import subprocess
import tempfile
from functools import partial
from pathlib import Path

from timing import QUICK, Race, describe, optional, thousands_a_second

import numpy as np

import gtfdi

foxglove = optional("foxglove")
mcap = optional("mcap")

WIDTH = 28
MESSAGES = 500 if QUICK else 50_000
PERIOD_S = 1e-3
#: Simulated time of the run whose log is written.
RUN_S = 8.0 if QUICK else 1600.0
COMPRESSIONS = ["none", "lz4", "zstd"]
TOPIC = "/plant/measured"


def readings():
    """A plant that moves slowly, with the noise of sensors."""
    channels = np.arange(WIDTH)
    slow = np.sin(0.3 * PERIOD_S * np.arange(MESSAGES)[:, None] + channels)
    noise = np.random.default_rng(7).uniform(-0.5, 0.5, (MESSAGES, WIDTH))
    return 1e3 * (1.0 + channels) * (1.0 + 0.05 * slow + 1e-3 * noise)


def times_ns(count, period_s):
    return [round(k * period_s * 1e9) for k in range(count)]


def schema_of(samples):
    return f"float64[{samples.shape[1]}] values".encode()


def with_mcap(path, topics, times, by):
    """Writes a message a topic and sample; ``topics`` are names and samples."""
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType[by.upper()])
        writer.start(profile="", library="")
        channels = []
        for name, samples in topics.items():
            schema = writer.register_schema(
                name=f"Raw{samples.shape[1]}", encoding="ros1msg", data=schema_of(samples)
            )
            channels.append(
                writer.register_channel(topic=name, message_encoding="ros1", schema_id=schema)
            )
        for time_ns, *own in zip(times, *topics.values(), strict=True):
            for channel, sample in zip(channels, own, strict=True):
                writer.add_message(channel, time_ns, sample.tobytes(), time_ns)
        writer.finish()


def with_foxglove(path, topics, times, by):
    from foxglove.mcap import MCAPCompression, MCAPWriteOptions

    compression = {"none": None, "lz4": MCAPCompression.Lz4, "zstd": MCAPCompression.Zstd}[by]
    context = foxglove.Context()
    options = MCAPWriteOptions(compression=compression, compression_threads=0)
    with foxglove.open_mcap(path, allow_overwrite=True, context=context, writer_options=options):
        channels = []
        for name, samples in topics.items():
            schema = foxglove.Schema(
                name=f"Raw{samples.shape[1]}", encoding="ros1msg", data=schema_of(samples)
            )
            channels.append(
                foxglove.Channel(name, schema=schema, message_encoding="ros1", context=context)
            )
        for time_ns, *own in zip(times, *topics.values(), strict=True):
            for channel, sample in zip(channels, own, strict=True):
                channel.log(sample.tobytes(), log_time=time_ns)
        for channel in channels:
            channel.close()


def check(path, topics):
    """Raises unless gtfdi finds every message in a log, and their bytes are the numbers."""
    from mcap.reader import make_reader

    found = {topic["topic"]: topic["messages"] for topic in gtfdi.log.info(path)["topics"]}
    assert found == {name: len(samples) for name, samples in topics.items()}
    for name, samples in topics.items():
        with path.open("rb") as file:
            messages = make_reader(file).iter_messages(topics=[name])
            data = b"".join(message.data for _, _, message in messages)
        assert data == samples.tobytes(), "the log holds other numbers"


def add_peers(table, folder, topics, times, by):
    messages = len(times) * len(topics)
    for name, module, write in [
        ("mcap, numbers as they are", mcap, with_mcap),
        ("foxglove-sdk, numbers as they are", foxglove, with_foxglove),
    ]:
        if not module or not mcap:
            table.absent(name, "not installed, or no mcap to read it back")
            continue
        path = Path(folder) / f"{write.__name__}_{by}.mcap"
        table.add(name, partial(write, path, topics, times, by), work=messages)
        check(path, topics)
        table.rows[-1]["note"] = f"{path.stat().st_size / messages:.0f} bytes a message"


def whole_run(folder):
    """The log of a simulated run; gtfdi compresses it with zstd."""
    run = gtfdi.simulate(RUN_S, seed=1)
    measured, truth = run.measured, run.truth
    topics = {
        "/plant/measured": np.hstack([measured.u, measured.y]),
        "/plant/truth": np.hstack([truth.u, truth.y, run.hidden]),
    }
    widths = " and ".join(str(samples.shape[1]) for samples in topics.values())
    table = Race(
        f"The log of a run: {len(measured)} samples, {widths} numbers, compression zstd",
        "k messages/s",
        thousands_a_second,
    )
    path, messages = Path(folder) / "run.mcap", len(measured) * len(topics)
    table.add("gtfdi Run.write", lambda: run.write(path), work=messages)
    for name, data in [("/plant/measured", measured), ("/plant/truth", truth)]:
        back = gtfdi.read(path, inputs=data.inputs, outputs=data.outputs, topic=name)
        assert (back.u == data.u).all() and (back.y == data.y).all(), "other numbers came back"
    size = path.stat().st_size / messages
    table.rows[-1]["note"] = f"{size:.0f} bytes a message; names, units, scenario; flushed"
    times = times_ns(len(measured), measured.sample_time_s)
    add_peers(table, folder, topics, times, "zstd")
    table.finish()


def cargo_rates():
    """Messages a second of gtfdi's and mcap's writers in Rust by compression, from the bench."""
    root = Path(__file__).resolve().parents[2]
    command = ["cargo", "bench", "--quiet", "-p", "gt-mcap", "--bench", "writing"]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True)
    rates = {}
    for by in COMPRESSIONS:
        title = rf"writing [^\n]*, compression {by}\n"
        table = re.search(rf"{title}(.*?)(?:\n\n|\Z)", done.stdout, re.S)[1]
        rates[by] = {
            name.strip(): 1e3 * float(rate)
            for name, rate in re.findall(r"^\[\d\] (.{44}) +([0-9.]+)", table, re.M)
        }
    return rates


def main():
    describe("gtfdi", "numpy", "mcap", "foxglove-sdk")
    topics, times = {TOPIC: readings()}, times_ns(MESSAGES, PERIOD_S)
    with_cargo = not QUICK and shutil.which("cargo") is not None
    shared = "/dev/shm" if os.path.isdir("/dev/shm") else None
    tables = []
    with tempfile.TemporaryDirectory(dir=shared) as folder:
        whole_run(folder)
        before = cargo_rates() if with_cargo else None
        for by in COMPRESSIONS:
            table = Race(
                f"Writing {MESSAGES} messages of {WIDTH} numbers, compression {by}",
                "k messages/s",
                thousands_a_second,
            )
            add_peers(table, folder, topics, times, by)
            tables.append(table)
            table.finish()
    after = cargo_rates() if with_cargo else None
    report_cargo(before, after, tables)


def report_cargo(before, after, tables):
    """Prints the rows of the Rust bench, and how many times as fast gtfdi is as each peer."""
    print("\nLogWriter in Rust, wall time, mean of a run before and one after the above")
    if before is None:
        print("not run: wants cargo, and not --quick")
        return
    for by, table in zip(COMPRESSIONS, tables, strict=True):
        names = [name for name in before[by] if "write of the numbers" not in name]
        rates = {name: 0.5 * (before[by][name] + after[by][name]) for name in names}
        for name, rate in rates.items():
            print(f"{by:<6}{name:<46}{1e-3 * rate:>16.4g} k messages/s")
        own = rates["gtfdi LogWriter::write"]
        for row in table.rows:
            if row["times"]:
                wall_s = statistics.median(wall for _, wall in row["times"]) / MESSAGES
                print(f"{by:<6}gtfdi is {own * wall_s:.3g} x as fast as {row['name']}")


if __name__ == "__main__":
    main()
