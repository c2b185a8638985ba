"""Logs of 28 numbers a message in MCAP files: gtfdi beside the writers of mcap and Foxglove's SDK.

The Python package of gtfdi writes logs of whole runs and of verdicts, not of single messages. What
stands for it is `LogWriter` in Rust, measured by `cargo bench -p gt-log --bench writing` before and
after the peers: in wall time, and of another record made by the same rule.
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
COMPRESSIONS = ["none", "lz4", "zstd"]
TOPIC = "/plant/measured"
SCHEMA = b"float64[28] values"


def readings():
    """A plant that moves slowly, with the noise of sensors."""
    channels = np.arange(WIDTH)
    slow = np.sin(0.3 * PERIOD_S * np.arange(MESSAGES)[:, None] + channels)
    noise = np.random.default_rng(7).uniform(-0.5, 0.5, (MESSAGES, WIDTH))
    return 1e3 * (1.0 + channels) * (1.0 + 0.05 * slow + 1e-3 * noise)


def times_ns():
    return [round(k * PERIOD_S * 1e9) for k in range(MESSAGES)]


def with_mcap(path, samples, times, by):
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType[by.upper()])
        writer.start(profile="", library="")
        schema = writer.register_schema(name="Raw", encoding="ros1msg", data=SCHEMA)
        channel = writer.register_channel(topic=TOPIC, message_encoding="ros1", schema_id=schema)
        for time_ns, sample in zip(times, samples, strict=True):
            writer.add_message(channel, time_ns, sample.tobytes(), time_ns)
        writer.finish()


def with_foxglove(path, samples, times, by):
    from foxglove.mcap import MCAPCompression, MCAPWriteOptions

    compression = {"none": None, "lz4": MCAPCompression.Lz4, "zstd": MCAPCompression.Zstd}[by]
    context = foxglove.Context()
    schema = foxglove.Schema(name="Raw", encoding="ros1msg", data=SCHEMA)
    options = MCAPWriteOptions(compression=compression, compression_threads=0)
    with foxglove.open_mcap(path, allow_overwrite=True, context=context, writer_options=options):
        channel = foxglove.Channel(TOPIC, schema=schema, message_encoding="ros1", context=context)
        for time_ns, sample in zip(times, samples, strict=True):
            channel.log(sample.tobytes(), log_time=time_ns)
        channel.close()


def check(path, samples):
    """Raises unless gtfdi finds every message in a log, and their bytes are the numbers."""
    from mcap.reader import make_reader

    topics = gtfdi.log.info(path)["topics"]
    assert [(topic["topic"], topic["messages"]) for topic in topics] == [(TOPIC, len(samples))]
    with path.open("rb") as file:
        messages = make_reader(file).iter_messages()
        data = b"".join(message.data for _, _, message in messages)
    assert data == samples.tobytes(), "the log holds other numbers"


def cargo_rates():
    """Messages a second of gtfdi's and mcap's writers in Rust by compression, from the bench."""
    root = Path(__file__).resolve().parents[2]
    command = ["cargo", "bench", "--quiet", "-p", "gt-log", "--bench", "writing"]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True)
    rates = {}
    for by in COMPRESSIONS:
        table = re.search(rf"writing .* compression {by}\n(.*?)(?:\n\n|\Z)", done.stdout, re.S)[1]
        rates[by] = {
            name.strip(): 1e3 * float(rate)
            for name, rate in re.findall(r"^\[\d\] (.{44}) +([0-9.]+)", table, re.M)
        }
    return rates


def main():
    describe("gtfdi", "numpy", "mcap", "foxglove-sdk")
    samples, times = readings(), times_ns()
    with_cargo = not QUICK and shutil.which("cargo") is not None
    before = cargo_rates() if with_cargo else None
    shared = "/dev/shm" if os.path.isdir("/dev/shm") else None
    tables = []
    with tempfile.TemporaryDirectory(dir=shared) as folder:
        for by in COMPRESSIONS:
            table = Race(
                f"Writing {MESSAGES} messages of {WIDTH} numbers, compression {by}",
                "k messages/s",
                thousands_a_second,
            )
            for name, package, module, write in [
                ("mcap, numbers as they are", "mcap", mcap, with_mcap),
                ("foxglove-sdk, numbers as they are", "foxglove", foxglove, with_foxglove),
            ]:
                if not module or not mcap:
                    table.absent(name, "not installed, or no mcap to read it back")
                    continue
                path = Path(folder) / f"{package}_{by}.mcap"
                run = partial(write, path, samples, times, by)
                table.add(name, run, work=MESSAGES)
                check(path, samples)
                table.rows[-1]["note"] = f"{path.stat().st_size / MESSAGES:.0f} bytes a message"
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
