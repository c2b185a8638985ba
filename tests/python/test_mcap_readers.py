"""Our logs, read by the independent packages mcap and mcap-protobuf-support."""

import json
import os
import subprocess

import numpy as np
import pytest
from mcap.reader import NonSeekingReader, SeekingReader
from mcap.records import Chunk, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory

import gtfdi

TOPICS = ["/plant/truth", "/plant/measured"]


@pytest.fixture(scope="module")
def run():
    return gtfdi.simulate(60.0, seed=3)


@pytest.fixture(scope="module")
def log(run, tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "s.mcap"
    run.write(path)
    return path


def samples(reader, data):
    """The messages of a topic as an array, with their times: (times, u, y)."""
    tags = data.inputs + data.outputs
    times, rows = [], []
    for _, _, message, sample in reader:
        assert all(sample.HasField(tag) for tag in tags)
        times.append(message.log_time)
        rows.append([getattr(sample, tag) for tag in tags])
    values = np.array(rows)
    return np.array(times), values[:, : len(data.inputs)], values[:, len(data.inputs) :]


@pytest.mark.parametrize("reader_class", [SeekingReader, NonSeekingReader])
@pytest.mark.parametrize("topic", TOPICS)
def test_every_value_comes_back_exactly(run, log, topic, reader_class):
    data = run.truth if topic == "/plant/truth" else run.measured
    with log.open("rb") as stream:
        reader = reader_class(stream, decoder_factories=[DecoderFactory()])
        times, u, y = samples(reader.iter_decoded_messages(topics=[topic]), data)
    assert len(times) == 750
    assert u.tobytes() == data.u.tobytes()
    assert y.tobytes() == data.y.tobytes()
    # k Ts on from the first, in whole nanoseconds.
    assert np.array_equal(times - times[0], 80_000_000 * np.arange(750))


def test_schemas_name_their_fields_and_channels_their_units(run, log):
    with log.open("rb") as stream:
        reader = SeekingReader(stream, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        channels = {channel.topic: channel for channel in summary.channels.values()}
        assert set(TOPICS) <= set(channels)
        for topic in TOPICS:
            schema = summary.schemas[channels[topic].schema_id]
            assert schema.encoding == "protobuf"
            assert schema.name.startswith("gtfdi.v1.")
            assert "units" in channels[topic].metadata
        _, _, _, sample = next(reader.iter_decoded_messages(topics=TOPICS))
    fields = {field.name: field for field in sample.DESCRIPTOR.fields}
    # The first message is one of the truth: 6 inputs, 28 outputs, and what no sensor measures.
    assert list(fields) == run.truth.inputs + run.truth.outputs + run.hidden_names
    assert len(fields) == 6 + 28 + 3
    # Optional: absent is not zero.
    assert all(field.has_presence for field in fields.values())


def test_metadata_stands_before_the_first_message(log):
    with log.open("rb") as stream:
        records = list(StreamReader(stream, emit_chunks=False).records)
    metadata = [k for k, record in enumerate(records) if isinstance(record, Metadata)]
    messages = [k for k, record in enumerate(records) if isinstance(record, (Message, Chunk))]
    named = {records[k].name: records[k].metadata for k in metadata}
    assert max(metadata) < min(messages)
    assert named["gtfdi.run"]["seed"] == "3"
    assert "gtfdi.config" in named


def test_attachments_and_metadata_are_indexed(run, log):
    with log.open("rb") as stream:
        reader = SeekingReader(stream)
        (attachment,) = reader.iter_attachments()
        names = [record.name for record in reader.iter_metadata()]
    assert attachment.name == "config.toml"
    assert attachment.data.decode() == run.config
    assert names[0] == "gtfdi.run"


def test_one_seed_gives_one_file(run, log, tmp_path):
    again = tmp_path / "elsewhere.mcap"
    gtfdi.simulate(60.0, seed=3).write(again)
    assert again.read_bytes() == log.read_bytes()


def test_our_own_reader_agrees(run, log):
    data = gtfdi.read(log, inputs=run.measured.inputs, outputs=run.measured.outputs)
    assert data == run.measured
    truth = gtfdi.read(log, inputs=["a_v"], outputs=["p7"], topic="/plant/truth", rows=(10, 20))
    assert np.array_equal(truth.u, run.truth.select(["a_v"], ["p7"])[10:20].u)


def test_injected_faults_are_logged(tmp_path):
    fault = {"case": "turbine_damage", "onset_s": 1.0, "rate_percent_per_h": 5.0}
    run = gtfdi.simulate(4.0, faults=[fault])
    path = tmp_path / "f.mcap"
    run.write(path)
    with path.open("rb") as stream:
        reader = SeekingReader(stream, decoder_factories=[DecoderFactory()])
        found = [
            (sample.turbine_damage, sample.turbine_damage_active)
            for _, _, _, sample in reader.iter_decoded_messages(topics=["/plant/faults"])
        ]
    assert np.array_equal(np.array(found), np.column_stack([run.faults, run.faults != 0.0]))
    with pytest.raises(gtfdi.LogError, match="could not"):
        run.write(tmp_path / "no" / "such" / "folder.mcap")


def test_a_recovered_log_is_whole(run, log, tmp_path):
    """Cut in the middle, mended by the binary, read with both readers and by our own."""
    binary = os.environ.get("GTFDI_BINARY")
    if binary is None:
        pytest.skip("GTFDI_BINARY is not set")
    part, out = tmp_path / "s.mcap.part", tmp_path / "s.mcap"
    whole = log.read_bytes()
    part.write_bytes(whole[: 2 * len(whole) // 3])
    command = [binary, "log", "recover", part, "--out", out, "--json"]
    done = subprocess.run(command, capture_output=True, check=True, text=True)
    report = json.loads(done.stdout)
    assert not report["sound"]
    found = {}
    for reader_class in [SeekingReader, NonSeekingReader]:
        with out.open("rb") as stream:
            reader = reader_class(stream, decoder_factories=[DecoderFactory()])
            times, u, y = samples(reader.iter_decoded_messages(topics=TOPICS[1:]), run.measured)
        found[reader_class] = (times.tobytes(), u.tobytes(), y.tobytes())
        assert 100 < len(times) < 750
        assert np.array_equal(u, run.measured.u[: len(times)])
        assert np.array_equal(y, run.measured.y[: len(times)])
    assert found[SeekingReader] == found[NonSeekingReader]
    with out.open("rb") as stream:
        reader = SeekingReader(stream)
        (attachment,) = reader.iter_attachments()
        names = [record.name for record in reader.iter_metadata()]
    assert attachment.data.decode() == run.config
    assert names == ["gtfdi.run", "gtfdi.config", "gtfdi.recovery"]


def test_a_recovered_log_has_the_other_topics_too(log, tmp_path):
    """What a cut log says of qualities is read with its enumeration."""
    binary = os.environ.get("GTFDI_BINARY")
    if binary is None:
        pytest.skip("GTFDI_BINARY is not set")
    part, out = tmp_path / "s.mcap.part", tmp_path / "s.mcap"
    whole = log.read_bytes()
    part.write_bytes(whole[: len(whole) // 2])
    subprocess.run([binary, "log", "recover", part, "--out", out], capture_output=True, check=True)
    for path in [log, out]:
        with path.open("rb") as stream:
            reader = SeekingReader(stream, decoder_factories=[DecoderFactory()])
            ((_, _, _, sample),) = reader.iter_decoded_messages(topics=["/plant/quality"])
        fields = sample.DESCRIPTOR.fields
        assert len(fields) == 6 + 28
        names = {field.enum_type.values_by_number[getattr(sample, field.name)].name for field in fields}
        assert names == {"GOOD"}
        values = fields[0].enum_type.values
        assert [value.name for value in values] == [
            "GOOD",
            "UNCERTAIN",
            "BAD",
            "STALE",
            "INTERPOLATED",
        ]


def test_every_file_of_a_rotated_log_is_whole(tmp_path):
    examples = os.environ.get("GTFDI_EXAMPLES")
    if examples is None:
        pytest.skip("GTFDI_EXAMPLES is not set")
    rotate = [os.path.join(examples, "rotate_log"), tmp_path]
    done = subprocess.run(rotate, capture_output=True, check=True, text=True)
    names = done.stdout.split()
    # Two hours and a half from midnight on.
    assert names == [
        f"log-20060118T{hour:02}0000.000000000Z.mcap" for hour in range(3)
    ]
    times, levels, temperatures = [], [], []
    for name in names:
        counts = []
        for reader_class in [SeekingReader, NonSeekingReader]:
            with (tmp_path / name).open("rb") as stream:
                reader = reader_class(stream, decoder_factories=[DecoderFactory()])
                found = list(reader.iter_decoded_messages())
            counts.append(len(found))
        assert counts[0] == counts[1]
        with (tmp_path / name).open("rb") as stream:
            reader = SeekingReader(stream)
            (attachment,) = reader.iter_attachments()
            assert attachment.data == b'asset = "tank"\n'
            assert "gtfdi.run" in [record.name for record in reader.iter_metadata()]
        for _, channel, message, sample in found:
            assert json.loads(channel.metadata["tags"]) == {"T_101": "T-101", "level": "level"}
            times.append(message.log_time)
            temperatures.append(sample.T_101)
            levels.append(sample.level if sample.HasField("level") else np.nan)
    k = np.arange(150)
    assert np.array_equal(np.array(times) - times[0], 60_000_000_000 * k)
    # A sine of another library.
    assert np.allclose(temperatures, 300.0 + np.sin(0.1 * k), rtol=0.0, atol=1e-12)
    assert np.array_equal(np.isnan(levels), k % 10 == 9)


def test_an_exported_log_has_the_numbers_of_the_messages(run, log, tmp_path):
    binary = os.environ.get("GTFDI_BINARY")
    if binary is None:
        pytest.skip("GTFDI_BINARY is not set")
    out = tmp_path / "s.csv"
    command = [binary, "log", "export", log, "--out", out, "--time", "seconds"]
    subprocess.run(command, capture_output=True, check=True)
    table = np.genfromtxt(out, delimiter=",", names=True, deletechars="", replace_space=" ")
    with log.open("rb") as stream:
        reader = SeekingReader(stream, decoder_factories=[DecoderFactory()])
        times, u, y = samples(reader.iter_decoded_messages(topics=TOPICS[1:]), run.measured)
    assert list(table.dtype.names) == ["time", *run.measured.inputs, *run.measured.outputs]
    columns = np.column_stack([table[name] for name in table.dtype.names])
    assert np.allclose(columns[:, 0], (times - times[0]) / 1e9, rtol=0.0, atol=1e-12)
    # Digits that give the same bits.
    assert np.array_equal(columns[:, 1:], np.column_stack([u, y]))
