"""What the tests share."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

import gtfdi


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository, from GTFDI_ROOT or from this file's place."""
    return Path(os.environ.get("GTFDI_ROOT") or Path(__file__).resolve().parents[2])


@pytest.fixture(scope="session")
def vectors(root):
    """Reads an exact vector of tests/vectors by name."""

    def read(name):
        return json.loads((root / "tests" / "vectors" / name).read_text())

    return read


@pytest.fixture(scope="session")
def reference_data(request) -> Path:
    """The folder of public records, or a skip that names the variable."""
    folder = os.environ.get("GTFDI_REFERENCE_DATA")
    if not folder:
        pytest.skip("GTFDI_REFERENCE_DATA is not set: no public records to read")
    return Path(folder)


@pytest.fixture(scope="session")
def healthy():
    """A healthy run of ten minutes."""
    return gtfdi.simulate(600.0, seed=1)


@pytest.fixture(scope="session")
def model(healthy):
    """A model of order 8 of the compressor's torque."""
    return gtfdi.arx(healthy.measured, order=8, nk=0, inputs=["a_v", "M_f"], outputs="q_c")


@pytest.fixture
def random_record():
    """Makes a record of a random stable system without noise: (system, u, y)."""

    def make(seed, nx=4, nu=2, ny=1, samples=400):
        generator = np.random.default_rng(seed)
        a = generator.standard_normal((nx, nx))
        a *= 0.8 / np.abs(np.linalg.eigvals(a)).max()
        b, c = generator.standard_normal((nx, nu)), generator.standard_normal((ny, nx))
        system = gtfdi.StateSpace(a, b, c, np.zeros((ny, nu)), 0.1)
        u = generator.standard_normal((samples, nu))
        return system, u, free_response(a, b, c, u)

    return make


def free_response(a, b, c, u):
    """The outputs of x+ = A x + B u, y = C x from x = 0, sample by sample in NumPy."""
    x, y = np.zeros(len(a)), np.empty((len(u), len(c)))
    for t, sample in enumerate(u):
        y[t] = c @ x
        x = a @ x + b @ sample
    return y


def mirrored(a, b, c, u):
    """A record of inputs `u` and then `-u`, each followed by rest: its means are zero.

    A fit removes the means first; where they are zero, a record from rest obeys its difference
    equation exactly.
    """
    rest = np.zeros((200, u.shape[1]))
    u = np.vstack([u, rest, -u, rest])
    return u, free_response(a, b, c, u)
