"""Arrays of any kind: read where they are, converted, or refused by what was expected and found."""

import gc
import subprocess
import sys
import textwrap
import warnings

import numpy as np
import pytest

import gtfdi
from gtfdi.statistics import Cusum


@pytest.fixture(scope="module")
def arrays():
    generator = np.random.default_rng(3)
    return generator.standard_normal((200, 2)), generator.standard_normal((200, 1))


@pytest.fixture(scope="module")
def system():
    return gtfdi.StateSpace(0.5 * np.eye(2), np.eye(2), np.ones((1, 2)), np.zeros((1, 2)), 0.1)


FORMS = {
    "fortran": np.asfortranarray,
    "strided": lambda a: np.repeat(a, 2, axis=0)[::2],
    "reversed": lambda a: a[::-1].copy()[::-1],
    "read-only": lambda a: _read_only(a),
    "byte-swapped": lambda a: a.astype(">f8"),
    "masked": lambda a: np.ma.masked_array(a, np.zeros(a.shape, dtype=bool)),
    "matrix": lambda a: _quiet(np.matrix, a),
    "list": lambda a: a.tolist(),
    "memoryview": lambda a: memoryview(a),
    "long double": lambda a: a.astype(np.longdouble),
}


def _read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def _quiet(make, array):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)
        return make(array)


@pytest.mark.parametrize("form", FORMS)
def test_every_form_means_the_same_numbers(form, arrays, system):
    u, y = arrays
    other = FORMS[form](u), FORMS[form](y)
    assert gtfdi.Dataset(*other, 0.1) == gtfdi.Dataset(u, y, 0.1)
    np.testing.assert_array_equal(system.simulate(other[0]), system.simulate(u))
    expected = gtfdi.arx(u, y, order=2).predict(u, y)
    np.testing.assert_array_equal(gtfdi.arx(*other, order=2).predict(*other), expected)


@pytest.mark.parametrize("dtype", ["f4", "f2", "i8", "u1", "?"])
def test_narrower_numbers_are_widened(dtype, arrays):
    u = (10 * arrays[0]).astype(dtype)
    data = gtfdi.Dataset(u, arrays[1], 0.1)
    assert data.u.dtype == np.float64
    np.testing.assert_array_equal(data.u, u.astype(np.float64))


@pytest.mark.parametrize(
    ("value", "found"),
    [
        (np.array([["a"], ["b"]]), "dtype <U1"),
        (np.array([[1j], [2j]]), "dtype complex128"),
        (np.array([[None], [1.0]], dtype=object), "dtype object"),
        (np.array([["2020-01-01"]], dtype="datetime64[s]"), r"dtype datetime64\[s\]"),
        (np.zeros(3, dtype=[("a", "f8")]), r"dtype \[\('a', '<f8'\)\]"),
        ([[1.0, 2.0], [3.0]], "setting an array element with a sequence"),
        ("text", "dtype <U4"),
        (None, "dtype object"),
    ],
    ids=["text", "complex", "object", "instants", "records", "ragged", "str", "None"],
)
def test_what_is_no_array_of_numbers_is_refused(value, found):
    message = f"^u: expected an array of real numbers, found {found}"
    with pytest.raises(gtfdi.ArrayTypeError, match=message) as caught:
        gtfdi.Dataset(value, np.zeros((2, 1)), 0.1)
    assert isinstance(caught.value, TypeError)


def test_wrong_shapes_say_expected_and_found(arrays, system, healthy):
    u, y = arrays
    cases = [
        (lambda: gtfdi.Dataset(u[None], y, 0.1), 2, 3),
        (lambda: gtfdi.Dataset(1.0, y, 0.1), 2, 0),
        (lambda: gtfdi.Dataset(u, y[:-1], 0.1), 200, 199),
        (lambda: system.simulate(u[:, :1]), 2, 1),
        (lambda: system.simulate(u, x0=[0.0]), 2, 1),
        (lambda: gtfdi.arx(u, y, order=1).predict(u[:, :1], y), 2, 1),
        (lambda: Cusum(0.5, 5.0).process(u), 1, 2),
        (lambda: gtfdi.riccati(np.eye(2), np.ones((1, 3)), np.eye(2), np.eye(1)), 2, 3),
    ]
    for call, expected, found in cases:
        with pytest.raises(gtfdi.DimensionError) as caught:
            call()
        assert (caught.value.expected, caught.value.found) == (expected, found)
        assert f"expected {expected}, found {found}" in str(caught.value)


def test_a_detector_refuses_other_shapes_and_stays_as_it_was(healthy, model):
    record = healthy.measured.select(["a_v", "M_f"], ["q_c"])
    detector = gtfdi.design(model, [record], margin=1.5).detector()
    detector.process(record.u[:100], record.y[:100])
    before = detector.state()
    for u, y, expected, found in [
        (record.u[:9, :1], record.y[:9], 2, 1),
        (record.u[:9], np.repeat(record.y[:9], 2, axis=1), 1, 2),
        (record.u[:9], record.y[:8], 9, 8),
    ]:
        with pytest.raises(gtfdi.DimensionError) as caught:
            detector.process(u, y)
        assert (caught.value.expected, caught.value.found) == (expected, found)
    assert detector.state() == before


def test_nan_is_a_missing_sample_or_refused(arrays):
    u, y = arrays[0].copy(), arrays[1]
    u[50, 0] = np.nan
    message = "^channel `u1`, sample 50: expected a finite number, found NaN$"
    with pytest.raises(gtfdi.DataError, match=message):
        gtfdi.arx(u, y, order=1)
    masked = np.ma.masked_invalid(u)
    assert np.isnan(gtfdi.Dataset(masked, y, 0.1).u[50, 0])
    kept = gtfdi.arx(u, y, order=1, missing="break")
    # A row needs the sample before it: two rows and the first are missing.
    assert kept.rows_used == 200 - 1 - 2


def test_empty_arrays_are_records_without_samples(system):
    empty = gtfdi.Dataset(np.zeros((0, 2)), np.zeros((0, 1)), 0.1)
    assert len(empty) == 0 and empty.u.shape == (0, 2) and empty.y.shape == (0, 1)
    assert system.simulate(np.zeros((0, 2))).shape == (0, 1)
    assert Cusum(0.5, 5.0).process([]).shape == (0,)
    with pytest.raises(gtfdi.GtfdiError, match="expected .* found"):
        gtfdi.arx(np.zeros((0, 2)), np.zeros((0, 1)), order=1)


def test_the_samples_of_a_record_are_a_view_of_it(arrays):
    u, y = arrays
    data = gtfdi.Dataset(u, y, 0.1)
    # It keeps its own copy of what it is given,
    assert not np.shares_memory(data.u, u)
    # and lends it without another one.
    assert np.shares_memory(data.u, data.u)
    assert data.u.flags.c_contiguous and not data.u.flags.owndata
    with pytest.raises(ValueError, match="read-only"):
        data.u[0, 0] = 1.0
    with pytest.raises(ValueError, match="WRITEABLE"):
        data.u.flags.writeable = True


def test_a_view_outlives_its_record(arrays):
    u, y = arrays
    view = gtfdi.Dataset(u, y, 0.1).y
    gc.collect()
    _ = [np.ones(200) for _ in range(100)]
    np.testing.assert_array_equal(view, y)


def test_a_record_is_fitted_through_its_views(arrays):
    data = gtfdi.Dataset(*arrays, 0.1)
    assert gtfdi.arx(data.u, data.y, order=2).regression == gtfdi.arx(*arrays, order=2).regression


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_a_million_samples_go_in_without_a_copy():
    # In a process of its own, whose largest memory is that of these calls.
    program = """
        import numpy as np
        import gtfdi

        def status_mb(key):
            lines = open("/proc/self/status").read().splitlines()
            return int(next(line for line in lines if line.startswith(key)).split()[1]) / 1024

        def taken_mb(work):
            # How far the peak rises above what is there before; 5 resets the peak.
            open("/proc/self/clear_refs", "w").write("5")
            before = status_mb("VmRSS")
            kept = work()
            return status_mb("VmHWM") - before, kept

        u, y = np.ones((1_000_000, 6)), np.ones((1_000_000, 1))

        # One copy, which the record keeps: 7e6 doubles are 53.4 MB. What is above that is slack of
        # the allocator and pages of code.
        once, record = taken_mb(lambda: gtfdi.Dataset(u, y, 0.1))
        assert 53.0 < once < 60.0, once
        # Its samples are looked at without another.
        seen, total = taken_mb(lambda: record.u[::2].sum() + record.y.sum())
        assert total == 4e6
        assert seen < 4.0, seen
        # And arrays that nobody keeps are read where they are: nothing is new but the residuals of
        # one output, 7.6 MB.
        model = gtfdi.StateSpace([[0.5]], [[1.0] * 6], [[1.0]], [[0.0] * 6], 0.1)
        fleet = gtfdi.Fleet(gtfdi.observer(model, 0.1), streams=1)
        taken, residuals = taken_mb(lambda: fleet.process(u[:, :, None], y[:, :, None]))
        assert residuals.shape == (1_000_000, 1, 1)
        assert taken < 12.0, taken
        observer = gtfdi.observer(model, 0.1)
        taken, residual = taken_mb(lambda: observer.residual(u, y))
        assert residual.shape == (1_000_000,)
        assert taken < 12.0, taken
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
