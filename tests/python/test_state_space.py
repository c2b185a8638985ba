"""Discrete linear models."""

import pickle

import numpy as np
import pytest
from conftest import mirrored

import gtfdi

# Sums of up to a hundred products of numbers near one.
TOLERANCE = 1e-12


def test_prop_simulation_is_the_recursion(random_record):
    for seed in range(5):
        system, u, y = random_record(seed, nx=5, nu=3, ny=2)
        assert np.allclose(system.simulate(u), y, rtol=0.0, atol=TOLERANCE * np.abs(y).max())
        x0 = np.arange(5.0)
        free = np.array([system.C @ np.linalg.matrix_power(system.A, k) @ x0 for k in range(9)])
        assert np.allclose(system.simulate(np.zeros((9, 3)), x0), free, rtol=0.0, atol=1e-11)


def test_prop_markov_parameters_and_poles(random_record):
    system, _, _ = random_record(1, nx=4, nu=3, ny=2)
    markov = system.markov_parameters(5)
    assert markov.shape == (5, 2, 3)
    assert not markov[0].any()
    for k in range(1, 5):
        expected = system.C @ np.linalg.matrix_power(system.A, k - 1) @ system.B
        assert np.allclose(markov[k], expected, rtol=0.0, atol=TOLERANCE)
    # The poles come in any order.
    expected = np.linalg.eigvals(system.A)
    distance = np.abs(system.poles()[:, None] - expected[None, :]).min(axis=1)
    assert distance.max() < 1e-9
    assert np.abs(system.poles()).max() == pytest.approx(0.8, abs=1e-9)


def test_matrices_keep_their_orientation(random_record):
    a = np.array([[0.1, 0.2], [0.0, 0.3]])
    for layout in (a, np.asfortranarray(a), a.tolist()):
        system = gtfdi.StateSpace(layout, [[1.0], [2.0]], [[3.0, 4.0]], [[5.0]], 0.1)
        assert np.array_equal(system.A, a)
        assert np.array_equal(system.B, [[1.0], [2.0]])
        assert np.array_equal(system.C, [[3.0, 4.0]])
        assert np.array_equal(system.D, [[5.0]])
    assert (system.dt, system.inputs, system.outputs) == (0.1, ["u1"], ["y1"])


def test_pickle_is_exact(random_record):
    system, _, _ = random_record(2)
    copy = pickle.loads(pickle.dumps(system))
    assert copy == system
    assert np.array_equal(copy.A, system.A)


def test_refusals():
    with pytest.raises(gtfdi.DimensionError, match="^columns of A: expected 1, found 2$"):
        gtfdi.StateSpace([[1.0, 0.0]], [[1.0]], [[1.0]], [[0.0]], 0.1)
    with pytest.raises(gtfdi.DimensionError, match="^dimensions of A: expected 2, found 1$"):
        gtfdi.StateSpace([1.0], [[1.0]], [[1.0]], [[0.0]], 0.1)
    with pytest.raises(gtfdi.ModelError, match=r"^matrix B\(0, 0\): expected a finite"):
        gtfdi.StateSpace([[1.0]], [[np.nan]], [[1.0]], [[0.0]], 0.1)
    with pytest.raises(gtfdi.ModelError, match="^sample time: .*found 0$"):
        gtfdi.StateSpace([[1.0]], [[1.0]], [[1.0]], [[0.0]], 0.0)
    system = gtfdi.StateSpace([[0.5]], [[1.0]], [[1.0]], [[0.0]], 0.1)
    with pytest.raises(gtfdi.DimensionError, match=r"^rows of u \(inputs\): expected 1, found 2$"):
        system.simulate(np.zeros((4, 2)))
    with pytest.raises(gtfdi.DimensionError, match=r"^rows of x0 \(states\): expected 1"):
        system.simulate(np.zeros((4, 1)), [1.0, 2.0])
    with pytest.raises(gtfdi.OptionError, match="^option n: expected at most 1000000, found"):
        system.markov_parameters(2**62)


def test_published_vector_realises_canonically(vectors):
    # tests/vectors/mimo_21_small.json: a system in canonical form with v = (2, 1), written out by
    # hand; its noise-free record must lead back to the same A, B and C.
    case = vectors("mimo_21_small.json")
    a, b, c = (np.array(case[key]) for key in "ABC")
    system = gtfdi.StateSpace(a, b, c, np.zeros((2, 1)), 1.0)
    impulse = np.zeros((6, 1))
    impulse[0] = 1.0
    assert np.allclose(system.simulate(impulse), case["impulse_response"], rtol=0.0, atol=1e-14)
    u, y = mirrored(a, b, c, np.random.default_rng(5).standard_normal((300, 1)))
    model = gtfdi.arx(u, y, indices=case["v"])
    realised = model.state_space()
    # Rounding times the condition of the regression, which is below 1e3 here.
    for found, expected in [(realised.A, a), (realised.B, b), (realised.C, c)]:
        assert np.allclose(found, expected, rtol=0.0, atol=1e-11)
    assert realised.A.shape == (3, 3)
    assert not realised.D.any()


@pytest.mark.parametrize("seed", range(5))
def test_zeros_are_where_the_model_loses_rank(seed):
    draw = np.random.default_rng(60 + seed).standard_normal
    a, b, c, d = draw((4, 4)), draw((4, 2)), draw((2, 4)), draw((2, 2))
    system = gtfdi.StateSpace(a, b, c, d, 0.1)
    # With an invertible direct term they are the eigenvalues of A - B D^-1 C.
    expected = np.linalg.eigvals(a - b @ np.linalg.solve(d, c))
    found = np.sort_complex(system.zeros())
    np.testing.assert_allclose(found, np.sort_complex(expected), rtol=1e-8, atol=1e-9)
    for zero in found:
        pencil = np.block([[a - zero * np.eye(4), b], [c, d]])
        values = np.linalg.svd(pencil, compute_uv=False)
        assert values[-1] < 1e-9 * values[0]


def test_a_model_without_zeros_has_none():
    delay = gtfdi.StateSpace([[0.0]], [[1.0]], [[1.0]], [[0.0]], 0.1)
    zeros = delay.zeros()
    assert zeros.shape == (0,) and zeros.dtype == np.complex128
