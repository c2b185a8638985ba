"""Parquet against pyarrow and DuckDB: what they write is read alike, what is exported they read alike."""

import os
import subprocess

import numpy as np
import pytest

import gtfdi

pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")
duckdb = pytest.importorskip("duckdb")

ROWS = 300
TIME = np.datetime64("2026-03-04T10:00:00", "us") + np.arange(ROWS) * np.timedelta64(500, "ms")


def table(nulls):
    """A column of every type that is read, ``missing`` where ``nulls``."""
    k = np.arange(ROWS)
    real = np.sin(0.1 * k) * 10.0 ** (k % 5)

    def column(values, kind):
        mask = (k % 7 == 3) if nulls else np.zeros(ROWS, bool)
        return pa.array(values, kind, mask=mask)

    return pa.table({
        "time": pa.array(TIME, pa.timestamp("us", "UTC")),
        "double": column(real, pa.float64()),
        "float": column(real.astype(np.float32), pa.float32()),
        "int64": column(k * 1_000_003 - 7, pa.int64()),
        "int32": column(3 * k - 50, pa.int32()),
        "int16": column((k % 100 - 50).astype(np.int16), pa.int16()),
        "bool": column(k % 3 == 0, pa.bool_()),
        "coarse": column(np.round(real / 1e4), pa.float64()),
        "text": column([f"{v:.6g}" for v in real], pa.string()),
    })


def expected(source, name):
    """The numbers of a column; a null is NaN."""
    values = source.column(name).to_pylist()
    return np.array([np.nan if value is None else float(value) for value in values])


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("nulls", [False, True], ids=["whole", "nulls"])
@pytest.mark.parametrize("codec", ["none", "snappy", "zstd", "gzip"])
@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("dictionary", [False, True], ids=["plain", "dictionary"])
def test_pyarrow_files_are_read_alike(tmp_path, nulls, codec, version, dictionary):
    source = table(nulls)
    path = tmp_path / "a.parquet"
    pq.write_table(source, path, compression=codec, data_page_version=version,
                   use_dictionary=dictionary, row_group_size=128)
    names = source.column_names[1:]
    data = gtfdi.read(path, inputs=[], outputs=names, missing="break")
    assert data.sample_time_s == 0.5
    for column, name in enumerate(names):
        np.testing.assert_array_equal(data.y[:, column], expected(source, name), err_msg=name)


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("codec", ["uncompressed", "snappy", "zstd", "gzip"])
def test_duckdb_files_are_read_alike(tmp_path, codec):
    source = table(True)
    path = tmp_path / "a.parquet"
    connection = duckdb.connect()
    connection.register("source", source)
    connection.execute(f"copy source to '{path}' (format parquet, compression {codec})")
    names = source.column_names[1:]
    data = gtfdi.read(path, inputs=[], outputs=names, missing="break")
    assert len(data) == ROWS
    for column, name in enumerate(names):
        np.testing.assert_array_equal(data.y[:, column], expected(source, name), err_msg=name)


def test_a_codec_that_is_not_built_in_is_named(tmp_path):
    path = tmp_path / "a.parquet"
    pq.write_table(table(False), path, compression="brotli")
    with pytest.raises(gtfdi.LogError, match="Snappy, gzip or zstd, found BROTLI"):
        gtfdi.read(path, inputs=[], outputs="double")


def test_exports_are_read_alike(tmp_path):
    """All columns of a log, bit for bit, in both readers."""
    binary = os.environ.get("GTFDI_BINARY")
    if not binary:
        pytest.skip("GTFDI_BINARY is not set: no binary that exports")
    run = gtfdi.simulate(20.0, seed=3)
    log, path = tmp_path / "run.mcap", tmp_path / "run.parquet"
    run.write(log)
    subprocess.run([binary, "log", "export", log, "--out", path], check=True)
    wanted = run.measured.inputs + run.measured.outputs
    values = np.hstack([run.measured.u, run.measured.y])
    arrow = pq.read_table(path)
    assert [name for name in arrow.column_names if name != "time"] == wanted
    relation = duckdb.connect().execute(f"select * from '{path}'").fetchnumpy()
    for column, name in enumerate(wanted):
        assert arrow.schema.field(name).type == pa.float64()
        np.testing.assert_array_equal(arrow.column(name).to_numpy(), values[:, column])
        np.testing.assert_array_equal(np.ma.getdata(relation[name]), values[:, column])
    data = gtfdi.read(path, inputs=run.measured.inputs, outputs=run.measured.outputs)
    np.testing.assert_array_equal(data.y, run.measured.y)
