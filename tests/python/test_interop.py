"""Models and records to other packages and back."""

import numpy as np
import pytest

import gtfdi


@pytest.fixture(scope="module")
def system():
    generator = np.random.default_rng(4)
    a = generator.standard_normal((3, 3))
    a *= 0.8 / np.abs(np.linalg.eigvals(a)).max()
    b, c, d = (generator.standard_normal(shape) for shape in [(3, 2), (2, 3), (2, 2)])
    return gtfdi.StateSpace(a, b, c, d, 0.08, ["fuel", "vane"], ["t3", "p7"])


@pytest.fixture(scope="module")
def record():
    generator = np.random.default_rng(5)
    u, y = generator.standard_normal((50, 1)), generator.standard_normal((50, 2))
    y[7, 1] = np.nan
    return gtfdi.Dataset(u, y, 0.08, "M_f", ["t3", "p7"], "kg/s", ["K", "Pa"], start_time_s=16.0)


def same(one, other):
    """Equal records, a missing sample being like a missing sample."""
    np.testing.assert_array_equal(one.u, other.u)
    np.testing.assert_array_equal(one.y, other.y)
    for what in (
        "inputs",
        "outputs",
        "input_units",
        "output_units",
        "sample_time_s",
        "start_time_s",
    ):
        assert getattr(one, what) == getattr(other, what), what


def test_control_and_back_is_exact(system):
    control = pytest.importorskip("control")
    there = system.to_control()
    assert (there.dt, there.input_labels, there.output_labels) == (
        0.08,
        ["fuel", "vane"],
        ["t3", "p7"],
    )
    assert gtfdi.StateSpace.from_control(there) == system
    u = np.random.default_rng(6).standard_normal((100, 2))
    response = control.forced_response(there, inputs=u.T)
    # The same recursion in another order of sums.
    np.testing.assert_allclose(response.outputs.T, system.simulate(u), atol=1e-12)


def test_scipy_and_back_is_exact(system):
    signal = pytest.importorskip("scipy.signal")
    there = system.to_scipy()
    assert gtfdi.StateSpace.from_scipy(there, ["fuel", "vane"], ["t3", "p7"]) == system
    u = np.random.default_rng(6).standard_normal((100, 2))
    _, outputs, _ = signal.dlsim(there, u)
    np.testing.assert_allclose(outputs, system.simulate(u), atol=1e-12)


def test_a_transfer_function_is_realised():
    control, signal = pytest.importorskip("control"), pytest.importorskip("scipy.signal")
    impulse = [1.0, 0.0, 0.0, 0.0]
    for model in (
        gtfdi.StateSpace.from_control(control.tf([2.0], [1.0, -0.5], 0.1)),
        gtfdi.StateSpace.from_scipy(signal.dlti([2.0], [1.0, -0.5], dt=0.1)),
    ):
        assert model.dt == 0.1
        np.testing.assert_allclose(model.simulate(impulse).ravel(), [0, 2, 1, 0.5], atol=1e-15)


def test_continuous_time_is_refused():
    control, signal = pytest.importorskip("control"), pytest.importorskip("scipy.signal")
    expected = "expected discrete time with a sample time in seconds, found dt ="
    with pytest.raises(gtfdi.ModelError, match=f"^control system: {expected} 0$"):
        gtfdi.StateSpace.from_control(control.tf([1.0], [1.0, 1.0]))
    with pytest.raises(gtfdi.ModelError, match=f"^control system: {expected} True$"):
        gtfdi.StateSpace.from_control(control.tf([1.0], [1.0, 0.5], True))
    with pytest.raises(gtfdi.ModelError, match=f"^scipy system: {expected} None$"):
        gtfdi.StateSpace.from_scipy(signal.lti([1.0], [1.0, 1.0]))


def test_pandas_and_back_is_exact(record):
    pytest.importorskip("pandas")
    frame = record.to_pandas()
    assert list(frame.columns) == ["M_f", "t3", "p7"]
    assert frame.index.name == "time_s" and frame.index[0] == 16.0
    assert frame.attrs["units"]["t3"] == "K"
    same(gtfdi.Dataset.from_pandas(frame, "M_f", ["t3", "p7"]), record)


def test_pandas_times_may_be_instants_or_a_column_or_left_out(record):
    pandas = pytest.importorskip("pandas")
    frame = record.to_pandas()
    instants = frame.set_axis(
        pandas.Timestamp("2026-01-01") + pandas.to_timedelta(frame.index, "s")
    )
    from_instants = gtfdi.Dataset.from_pandas(instants, "M_f", "t3")
    assert (from_instants.sample_time_s, from_instants.start_time_s) == (0.08, 0.0)
    column = frame.reset_index()
    assert gtfdi.Dataset.from_pandas(column, "M_f", "t3").start_time_s == 16.0
    assert gtfdi.Dataset.from_pandas(column, "M_f", "t3", time="time_s").sample_time_s == 0.08
    bare = frame.reset_index(drop=True)
    assert gtfdi.Dataset.from_pandas(bare, "M_f", "t3", sample_time_s=0.5).sample_time_s == 0.5
    with pytest.raises(
        gtfdi.OptionError, match="^option sample_time_s: expected seconds, or times"
    ):
        gtfdi.Dataset.from_pandas(bare, "M_f", "t3")


def test_a_frame_that_does_not_fit_is_refused(record):
    pytest.importorskip("pandas")
    frame = record.to_pandas()
    with pytest.raises(
        gtfdi.DataError, match="^channel `x`: expected one of M_f, t3, p7, found no"
    ):
        gtfdi.Dataset.from_pandas(frame, "x", "t3")
    gap = frame.drop(frame.index[20])
    for given_s in (None, 0.08):
        with pytest.raises(gtfdi.DataError, match="^times, sample 20: expected 0.08 s .* 0.16 s$"):
            gtfdi.Dataset.from_pandas(gap, "M_f", "t3", sample_time_s=given_s)
    with pytest.raises(gtfdi.DataError, match="^times, sample 1: expected 0.1 s .*found 0.08 s$"):
        gtfdi.Dataset.from_pandas(frame, "M_f", "t3", sample_time_s=0.1)
    words = frame.assign(t3="hot")
    with pytest.raises(gtfdi.ArrayTypeError, match="^y: expected an array of real numbers"):
        gtfdi.Dataset.from_pandas(words, "M_f", "t3")


def test_arrow_is_read_by_others_and_read_back(record):
    pyarrow = pytest.importorskip("pyarrow")
    table = pyarrow.table(record)
    assert table.column_names == ["time_s", "M_f", "t3", "p7"]
    assert table.schema.field("p7").metadata == {b"units": b"Pa"}
    same(gtfdi.Dataset.from_arrow(table, "M_f", ["t3", "p7"]), record)
    # A null is a missing sample.
    holes = table.set_column(2, "t3", pyarrow.array([None, *table["t3"].to_pylist()[1:]]))
    assert np.isnan(gtfdi.Dataset.from_arrow(holes, "M_f", "t3").y[0, 0])
    with pytest.raises(gtfdi.OptionError, match="^option table: expected an object with __arrow"):
        gtfdi.Dataset.from_arrow({"t3": [1.0]}, [], "t3")


def test_polars_in_and_out(record):
    polars = pytest.importorskip("polars")
    frame = record.to_polars()
    assert frame.columns == ["time_s", "M_f", "t3", "p7"]
    assert frame.schema["t3"] == polars.Float64
    pytest.importorskip("pyarrow")
    assert polars.DataFrame(record).equals(frame, null_equal=True)
    back = gtfdi.Dataset.from_arrow(frame, "M_f", ["t3", "p7"])
    np.testing.assert_array_equal(back.y, record.y)


def test_verdicts_are_tables(healthy, model):
    pytest.importorskip("pandas")
    bank = gtfdi.design(model, [healthy.measured], margin=1.2)
    detection = bank.detect(healthy.measured).to_pandas()
    assert list(detection.columns) == ["residual q_c", "statistic q_c"]
    assert len(detection) == len(healthy)
    series = bank.detector().process(healthy.measured[:100])
    frame = series.to_pandas()
    assert list(frame.columns) == [
        "gap",
        *(f"{what} q_c" for what in ("residual", "statistic", "exceeds", "alarm", "settling")),
    ]
    np.testing.assert_array_equal(frame["residual q_c"], series.residual[:, 0])
    assert frame["alarm q_c"].dtype == bool


@pytest.mark.parametrize(
    ("package", "extra", "use"),
    [
        ("control", "control", lambda system, record: system.to_control()),
        ("scipy", "scipy", lambda system, record: system.to_scipy()),
        ("pandas", "pandas", lambda system, record: record.to_pandas()),
        ("polars", "polars", lambda system, record: record.to_polars()),
        ("pyarrow", "arrow", lambda system, record: record.__arrow_c_stream__()),
    ],
)
def test_a_missing_package_says_how_to_install_it(package, extra, use, system, record, monkeypatch):
    def absent(name, *_):
        raise ImportError(f"No module named {name!r}")

    monkeypatch.setattr("gtfdi._extras.import_module", absent)
    with pytest.raises(ImportError) as caught:
        use(system, record)
    assert f"expected the package {package}, found none" in str(caught.value)
    assert f"pip install 'gtfdi[{extra}]'" in str(caught.value)
