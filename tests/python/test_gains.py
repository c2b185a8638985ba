"""Gains: poles of several outputs, the Riccati equation, one generator on many streams."""

import numpy as np
import pytest

import gtfdi
from gtfdi.statistics import Cusum, CusumFleet

SYSTEM = np.random.default_rng(21)
A = SYSTEM.standard_normal((5, 5))
A *= 1.2 / np.abs(np.linalg.eigvals(A)).max()
C = SYSTEM.standard_normal((2, 5))
MODEL = gtfdi.StateSpace(A, SYSTEM.standard_normal((5, 3)), C, np.zeros((2, 3)), 0.1)


def test_poles_of_several_outputs_are_those_asked_for():
    poles = [0.1, 0.2, 0.3, 0.4 + 0.2j, 0.4 - 0.2j]
    gain = gtfdi.place(MODEL, poles)
    assert gain.shape == (5, 2)
    found = np.linalg.eigvals(A - gain @ C)
    # Eigenvalues of a matrix of order one, moved by rounding times its condition.
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(poles), atol=1e-9)


def test_poles_inside_the_radius_stay():
    before = np.linalg.eigvals(A)
    inside = before[np.abs(before) < 0.9]
    assert 0 < len(inside) < 5
    after = np.linalg.eigvals(A - gtfdi.place(MODEL, 0.1, radius=0.9) @ C)
    for pole in inside:
        assert np.abs(after - pole).min() < 1e-9
    # The others are repeated now, and those move by the root of rounding.
    assert (np.abs(after - 0.1) < 1e-3).sum() == 5 - len(inside)


def test_one_output_has_the_gain_of_its_observer(model):
    part = model.output_model(0).model
    gain = gtfdi.place(part, [0.5, 0.6, 0.55, 0.65, 0.45, 0.4, 0.35, 0.3])
    observer = gtfdi.observer(part, [0.5, 0.6, 0.55, 0.65, 0.45, 0.4, 0.35, 0.3])
    # Two ways to the only gain there is.
    np.testing.assert_allclose(gain[:, 0], observer.gain, rtol=1e-5, atol=1e-6)


def test_poles_that_cannot_be_are_refused():
    with pytest.raises(gtfdi.DesignError, match="pole.*1.5"):
        gtfdi.place(MODEL, 1.5)
    with pytest.raises(gtfdi.DesignError, match="conjugate"):
        gtfdi.place(MODEL, [0.1, 0.2, 0.3, 0.4, 0.5j])
    with pytest.raises(gtfdi.DesignError, match="expected"):
        gtfdi.place(MODEL, [0.1, 0.2])


def test_the_riccati_equation_holds_and_is_scipys():
    q, r, s = np.diag([1.0, 2.0, 3.0, 1.0, 0.5]), np.diag([0.5, 2.0]), np.full((5, 2), 0.1)
    solution = gtfdi.riccati(A, C, q, r, s)
    p = solution.P
    cross = A @ p @ C.T + s
    innovation = C @ p @ C.T + r
    right = A @ p @ A.T - cross @ np.linalg.solve(innovation, cross.T) + q
    np.testing.assert_allclose(p, right, rtol=1e-9, atol=1e-9 * np.abs(p).max())
    assert solution.relative_residual < 1e-12
    gain = cross @ np.linalg.inv(innovation)
    radius = np.abs(np.linalg.eigvals(A - gain @ C)).max()
    assert solution.spectral_radius == pytest.approx(radius, rel=1e-9) and radius < 1.0
    linalg = pytest.importorskip("scipy.linalg")
    other = linalg.solve_discrete_are(A.T, C.T, q, r, s=s)
    np.testing.assert_allclose(p, other, rtol=1e-8, atol=1e-8 * np.abs(p).max())


def test_equations_without_a_solution_are_refused():
    eye = np.eye(2)
    with pytest.raises(gtfdi.DesignError, match="(?i)not symmetric|symmetric"):
        gtfdi.riccati(eye, eye, [[1.0, 2.0], [0.0, 1.0]], eye)
    with pytest.raises(gtfdi.DesignError):
        # The growing state does not show.
        gtfdi.riccati([[2.0, 0.0], [0.0, 0.5]], [[0.0, 1.0]], eye, [[1.0]])
    with pytest.raises(gtfdi.DesignError, match="finite"):
        gtfdi.riccati(eye, eye, np.full((2, 2), np.nan), eye)


def test_a_fleet_is_its_generator_on_each_stream_bit_for_bit(healthy, model):
    record = healthy.measured.select(["a_v", "M_f"], ["q_c"])
    observer = gtfdi.observer(model.output_model(0), 0.5)
    starts = [0, 100, 700, 1500, 2000]
    streams = [record[start : start + 400] for start in starts]
    u, y = (np.stack([getattr(each, side) for each in streams], axis=2) for side in ("u", "y"))
    y[50, 0, 2] = np.nan
    fleet = gtfdi.Fleet(observer, streams=5)
    first, second = fleet.process(u[:150], y[:150]), fleet.process(u[150:], y[150:])
    together = np.concatenate([first, second])
    for stream in range(5):
        alone = observer.residual(u[:, :, stream], y[:, :, stream])
        np.testing.assert_array_equal(together[:, 0, stream], alone)
    assert np.isnan(together[50, 0, 2])
    fleet.reset()
    np.testing.assert_array_equal(fleet.process(u[:150], y[:150]), first)


def test_a_fleet_refuses_other_sizes(model):
    observer = gtfdi.observer(model.output_model(0), 0.5)
    fleet = gtfdi.Fleet(observer, streams=2)
    u, y = np.zeros((4, 2, 2)), np.zeros((4, 1, 2))
    for bad, expected, found in [
        ((u[:, :1], y), 2, 1),
        ((u[..., :1], y), 2, 1),
        ((u[:3], y), 4, 3),
        ((u[0], y), 3, 2),
    ]:
        with pytest.raises(gtfdi.DimensionError) as caught:
            fleet.process(*bad)
        assert (caught.value.expected, caught.value.found) == (expected, found)
    with pytest.raises(gtfdi.OptionError, match="^option streams: expected 1 or more, found 0$"):
        gtfdi.Fleet(observer, streams=0)


@pytest.mark.parametrize("sides", ["upper", "lower", "both"])
def test_a_fleet_of_sums_is_a_cusum_on_each_stream_bit_for_bit(sides):
    residuals = np.random.default_rng(12).standard_normal((300, 11)) + 0.3
    residuals[40, 3] = np.nan
    residuals[60, 10] = np.inf
    fleet = CusumFleet(Cusum(0.25, 6.0, sides), streams=11)
    together = np.concatenate([fleet.process(residuals[:130]), fleet.process(residuals[130:])])
    for stream in range(11):
        alone = Cusum(0.25, 6.0, sides).process(residuals[:, stream])
        np.testing.assert_array_equal(together[:, stream], alone)
    assert together[40, 3] == together[39, 3]
    assert (fleet.streams, fleet.threshold) == (11, 6.0)
    fleet.reset()
    np.testing.assert_array_equal(fleet.process(residuals[:130]), together[:130])


def test_a_fleet_of_sums_refuses_other_sizes():
    fleet = CusumFleet(Cusum(0.5, 5.0), streams=3)
    with pytest.raises(gtfdi.DimensionError, match="^streams of residuals: expected 3, found 2$"):
        fleet.process(np.ones((4, 2)))
    np.testing.assert_array_equal(fleet.process(np.zeros((1, 3))), 0.0)
    with pytest.raises(gtfdi.OptionError, match="^option streams: expected 1 or more, found 0$"):
        CusumFleet(Cusum(0.5, 5.0), streams=0)
