"""What the tests share."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from document import repository

import gtfdi


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return repository()


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


class Tank:
    """One state, three sensors, a valve: faults of known size, and an isolator that knows them."""

    SAMPLE_TIME_S = 0.1
    ONSET_S, RISE_S = 200.0, 60.0

    def record(self, seed, samples, sensor=0.0, leak=0.0, lag_s=0.0):
        """A record; ``sensor`` is an error of a, ``leak`` moves b and c, the valve lags its demand
        by ``lag_s``; each grows evenly over a minute and stays."""
        generator = np.random.default_rng(seed)
        drive = generator.standard_normal(samples)
        noise = 0.1 * generator.standard_normal((samples, 3))
        growth = self.growth(samples)
        u, y = np.zeros((samples, 1)), np.zeros((samples, 3))
        demand = short = x = 0.0
        for t in range(samples):
            before, demand = demand, 0.97 * demand + drive[t]
            lag = max(growth[t] * lag_s, 1e-9)
            decay = np.exp(-self.SAMPLE_TIME_S / lag)
            # What the valve is short of its held demand at the sample's start, and over it.
            short = decay * short + demand - before
            position = demand - short * lag * (1.0 - decay) / self.SAMPLE_TIME_S
            u[t] = demand
            y[t] = [x, 0.5 * x, -0.8 * x]
            x = 0.95 * x + 0.05 * position
        y += noise + growth[:, None] * np.array([sensor, leak, 0.7 * leak])
        names = {"inputs": ["u"], "outputs": ["a", "b", "c"]}
        return gtfdi.Dataset(u, y, self.SAMPLE_TIME_S, **names)

    def growth(self, samples):
        """The share of a fault's size at each sample."""
        time_s = self.SAMPLE_TIME_S * np.arange(samples)
        return np.clip((time_s - self.ONSET_S) / self.RISE_S, 0.0, 1.0)

    def __init__(self):
        self.model = gtfdi.eiv(self.record(1, 6000), order=1, nk=1)
        self.healthy = [self.record(10 + seed, 30000) for seed in range(7)]
        pair = (self.record(2, 4000), self.record(2, 4000, leak=2.0), 2.0 * self.growth(4000))
        self.faults = [
            {"name": "sensor a", "unit": "K", "both_signs": True, "changes": {"a": 1.0}},
            {"name": "leak", "pairs": [pair]},
            {"name": "valve", "actuator": "u", "nominal_s": 0.5},
        ]
        self.isolator = gtfdi.design_isolator(self.model, self.healthy, self.faults, arl0_h=2.0)


@pytest.fixture(scope="session")
def tank():
    """A tank with its isolator."""
    return Tank()
