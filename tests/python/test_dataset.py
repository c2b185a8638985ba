"""Records: shapes, conversions, errors."""

import pickle

import numpy as np
import pytest

import gtfdi


def record(samples=6):
    u = np.arange(2.0 * samples).reshape(samples, 2)
    y = 100.0 + np.arange(3.0 * samples).reshape(samples, 3)
    return gtfdi.Dataset(
        u, y, 0.5, ["a", "b"], ["p", "q", "r"], ["deg", ""], ["Pa", "K", "N m"], start_time_s=2.0
    )


def test_what_goes_in_comes_out():
    data = record()
    assert len(data) == 6
    assert np.array_equal(data.u, np.arange(12.0).reshape(6, 2))
    assert np.array_equal(data.y, 100.0 + np.arange(18.0).reshape(6, 3))
    assert np.array_equal(data.time_s, 2.0 + 0.5 * np.arange(6))
    assert (data.inputs, data.outputs) == (["a", "b"], ["p", "q", "r"])
    assert (data.input_units, data.output_units) == (["deg", ""], ["Pa", "K", "N m"])
    assert gtfdi.Dataset([1, 2], [[3, 4], [5, 6]], 1.0).outputs == ["y1", "y2"]


@pytest.mark.parametrize("dtype", ["float32", "float16", "int64", "uint8", "bool", ">f8"])
def test_other_numbers_are_converted(dtype):
    values = np.array([[1, 0], [0, 1], [1, 1]]).astype(dtype)
    assert np.array_equal(gtfdi.Dataset(values, values[:, 0], 1.0).u, values.astype(float))


def test_memory_layout_does_not_matter():
    base = np.random.default_rng(0).standard_normal((40, 6))
    expected = gtfdi.Dataset(base[::2, ::3].copy(), base[::2, 1].copy(), 1.0)
    for u in (base[::2, ::3], np.asfortranarray(base[::2, ::3]), base[::2, ::3].tolist()):
        assert gtfdi.Dataset(u, base[::2, 1], 1.0) == expected
    backwards = base[::-1][:, :2]
    assert np.array_equal(gtfdi.Dataset(backwards, base[:, 0], 1.0).u, backwards)
    base.flags.writeable = False
    assert np.array_equal(gtfdi.Dataset(base, base[:, 0], 1.0).u, base)


def test_masked_samples_are_not_valid_samples():
    masked = np.ma.masked_array([[1.0, 2.0], [3.0, 4.0]], mask=[[False, True], [False, False]])
    expected = [[1.0, np.nan], [3.0, 4.0]]
    assert np.array_equal(gtfdi.Dataset(masked, [0, 1], 1.0).u, expected, equal_nan=True)


def test_the_record_owns_its_samples():
    u = np.zeros((3, 1))
    data = gtfdi.Dataset(u, u, 1.0)
    u[0] = 9.0
    assert not data.u.any()


def test_slices_keep_the_time():
    data = record()
    assert np.array_equal(data[2:4].u, data.u[2:4])
    assert data[2:4].start_time_s == 3.0
    assert np.array_equal(data[-2:].y, data.y[-2:])
    with pytest.raises(gtfdi.OptionError, match="^option step of the slice: expected 1 .*found 2$"):
        data[::2]
    with pytest.raises(gtfdi.DataError, match="^rows 4:4: expected a non-empty range within 0:6$"):
        data[4:4]


def test_select_takes_channels_from_either_side():
    chosen = record().select(["r", "a"], "q")
    assert (chosen.inputs, chosen.outputs) == (["r", "a"], ["q"])
    assert np.array_equal(chosen.u, np.column_stack([record().y[:, 2], record().u[:, 0]]))
    with pytest.raises(gtfdi.DataError, match="^channel `z`: not found; there are: a, b, p, q, r$"):
        record().select(["z"], ["q"])


def test_a_trend_goes_and_comes_back():
    data = record()
    trend = data.trend()
    # Every channel climbs by 2 (inputs) or 3 (outputs) a sample of 0.5 s; small whole numbers.
    assert trend.u_slope_per_s == [4.0, 4.0]
    assert trend.y_slope_per_s == [6.0, 6.0, 6.0]
    assert trend.centre_time_s == 3.25
    flat = data.detrended(trend)
    assert np.array_equal(flat.y, np.tile(data.y.mean(axis=0), (6, 1)))
    assert np.array_equal(flat.retrended(trend).u, data.u)
    assert pickle.loads(pickle.dumps(trend)) == trend
    assert trend == gtfdi.Trend([4.0, 4.0], [6.0, 6.0, 6.0], 3.25)
    refused = "^output slopes of the trend: expected 3, found 1$"
    with pytest.raises(gtfdi.DimensionError, match=refused):
        data.detrended(gtfdi.Trend([0.0, 0.0], [0.0], 0.0))


def test_pickle_keeps_everything():
    data = record()
    copy = pickle.loads(pickle.dumps(data))
    assert copy == data
    assert copy.output_units == data.output_units
    assert copy.start_time_s == 2.0


def test_sizes_that_disagree_say_so():
    u, y = np.zeros((5, 2)), np.zeros((4, 1))
    with pytest.raises(
        gtfdi.DimensionError, match=r"^columns of y \(samples\): expected 5, found 4$"
    ) as caught:
        gtfdi.Dataset(u, y, 1.0)
    assert (caught.value.expected, caught.value.found) == (5, 4)
    assert isinstance(caught.value, ValueError)
    with pytest.raises(gtfdi.DimensionError, match="rows of u .*expected 3, found 2"):
        gtfdi.Dataset(u, u, 1.0, inputs=["a", "b", "c"])
    with pytest.raises(gtfdi.DimensionError, match="^dimensions of u .*: expected 2, found 3"):
        gtfdi.Dataset(np.zeros((5, 2, 2)), u, 1.0)
    with pytest.raises(gtfdi.DimensionError, match="^dimensions of u .*: expected 2, found 0"):
        gtfdi.Dataset(np.array(1.0), u, 1.0)
    with pytest.raises(gtfdi.DimensionError, match="^units of the channels of u: expected 2"):
        gtfdi.Dataset(u, u[:, 0], 1.0, input_units=["K"])


@pytest.mark.parametrize(
    ("values", "found"),
    [
        (np.array([["a"], ["b"]]), "dtype <U1"),
        (np.array([[object()], [None]]), "dtype object"),
        (np.array([[1j], [2.0]]), "dtype complex128"),
        (np.array([["2026-01-01"]], dtype="datetime64[s]"), "dtype datetime64"),
        ([[1.0], [2.0, 3.0]], "setting an array element"),
    ],
)
def test_arrays_of_something_else_are_refused(values, found):
    with pytest.raises(
        gtfdi.ArrayTypeError, match="^u: expected an array of real numbers, found "
    ) as caught:
        gtfdi.Dataset(values, np.zeros((2, 1)), 1.0)
    assert found in str(caught.value)
    assert isinstance(caught.value, TypeError)


def test_names_and_sample_time_are_checked():
    u = np.zeros((3, 1))
    with pytest.raises(gtfdi.DataError, match="^sample time: expected a positive.*found -1$"):
        gtfdi.Dataset(u, u, -1.0)
    with pytest.raises(gtfdi.DataError, match="^channel `a`: expected unique"):
        gtfdi.Dataset(u, u, 1.0, "a", "a")


def test_csv_is_read_and_broken_ones_are_refused(tmp_path):
    path = tmp_path / "data.csv"
    path.write_text("t,x1,x2,y\n0.0,1,2,3\n0.5,4,5,6\n1.0,7,8,9\n")
    data = gtfdi.read(path, inputs="x*", outputs=["y"])
    assert data.inputs == ["x1", "x2"]
    assert np.array_equal(data.u, [[1.0, 2.0], [4.0, 5.0], [7.0, 8.0]])
    assert data.sample_time_s == 0.5
    tail = gtfdi.read(path, inputs=["x1"], outputs=["y"], rows=(1, 3))
    assert np.array_equal(tail.y, [[6.0], [9.0]])
    path.write_text("y\n1\n2\n")
    with pytest.warns(UserWarning, match="time is counted in samples"):
        assert gtfdi.read(path, inputs=[], outputs=["y"]).sample_time_s == 1.0
    path.write_text("t,y\n0,1\n1,two\n")
    with pytest.raises(gtfdi.LogError, match="data.csv: line 3, column `y`: .*two"):
        gtfdi.read(path, inputs=[], outputs=["y"])
    with pytest.raises(gtfdi.LogError, match="there is no such file"):
        gtfdi.read(tmp_path / "none.csv", inputs=[], outputs=["y"])
