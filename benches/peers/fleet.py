"""Residuals of 4096 streams by one observer, canonical form: gtfdi beside numba, NumPy and JAX."""

from systems import canonical
from timing import QUICK, Race, describe, millions_a_second, optional, relative_error

import numpy as np

import gtfdi

jax = optional("jax")
numba = optional("numba")

NX, NU = 8, 2
STREAMS = 256 if QUICK else 4096
SAMPLES = 32 if QUICK else 512
#: Streams that a tiled loop takes through all samples.
TILE = 64
#: Largest difference of residuals over the largest residual: additions come in another order.
AGREEMENT = 1e-10


def model():
    """Eight poles from 0.3 to 0.97 in canonical form."""
    a, b, c = canonical(NX, NU)
    return gtfdi.StateSpace(a, b, c, np.full((1, NU), 0.1), 0.08)


def numba_loops():
    """Compiled functions of (last row of A, B, D, gain, u, y), and of dense matrices."""

    @numba.njit
    def canonical(last, b, d, gain, u, y):
        """All streams of a sample side by side."""
        samples, streams = y.shape
        x, residuals = np.zeros((NX, streams)), np.empty_like(y)
        for k in range(samples):
            for s in range(streams):
                u0, u1, x0 = u[k, 0, s], u[k, 1, s], x[0, s]
                r = y[k, s] - x0 - d[0] * u0 - d[1] * u1
                residuals[k, s] = r
                total = last[0] * x0
                for i in range(NX - 1):
                    after = x[i + 1, s]
                    total += last[i + 1] * after
                    x[i, s] = after + b[i, 0] * u0 + b[i, 1] * u1 + gain[i] * r
                x[NX - 1, s] = total + b[NX - 1, 0] * u0 + b[NX - 1, 1] * u1 + gain[NX - 1] * r
        return residuals

    @numba.njit
    def tiled(last, b, d, gain, u, y):
        """A tile of streams through all samples, so that its states stay in the cache."""
        samples, streams = y.shape
        x, residuals = np.zeros((NX, TILE)), np.empty_like(y)
        for start in range(0, streams, TILE):
            x[:] = 0.0
            for k in range(samples):
                for t in range(TILE):
                    u0, u1, x0 = u[k, 0, start + t], u[k, 1, start + t], x[0, t]
                    r = y[k, start + t] - x0 - d[0] * u0 - d[1] * u1
                    residuals[k, start + t] = r
                    total = last[0] * x0
                    for i in range(NX - 1):
                        after = x[i + 1, t]
                        total += last[i + 1] * after
                        x[i, t] = after + b[i, 0] * u0 + b[i, 1] * u1 + gain[i] * r
                    x[NX - 1, t] = total + b[NX - 1, 0] * u0 + b[NX - 1, 1] * u1 + gain[NX - 1] * r
        return residuals

    @numba.njit
    def dense(a, b, c, d, gain, u, y):
        """One stream after the other, with all of A."""
        samples, streams = y.shape
        residuals = np.empty_like(y)
        x, after = np.zeros(NX), np.zeros(NX)
        for s in range(streams):
            x[:] = 0.0
            for k in range(samples):
                r = y[k, s]
                for j in range(NU):
                    r -= d[j] * u[k, j, s]
                for j in range(NX):
                    r -= c[j] * x[j]
                for i in range(NX):
                    after[i] = gain[i] * r
                for j in range(NU):
                    for i in range(NX):
                        after[i] += b[i, j] * u[k, j, s]
                for j in range(NX):
                    for i in range(NX):
                        after[i] += a[i, j] * x[j]
                for i in range(NX):
                    x[i] = after[i]
                residuals[k, s] = r
        return residuals

    return canonical, tiled, dense


def numpy_loop(closed, b, c, d, gain, u, y):
    """All streams at once, a product of matrices a sample."""
    x, residuals = np.zeros((NX, y.shape[1])), np.empty_like(y)
    for k in range(len(y)):
        residuals[k] = y[k] - c @ x - d @ u[k]
        x = closed @ x + b @ u[k] + gain[:, None] * y[k]
    return residuals


def jax_scans(a, b, c, d, gain, last):
    """Two compiled functions of (u, y): with all of A, and with its canonical form."""
    numbers = jax.numpy

    def dense_step(x, sample):
        u, y = sample
        r = y - c @ x - d @ u
        return a @ x + b @ u + gain[:, None] * r, r

    def canonical_step(x, sample):
        u, y = sample
        r = y - x[0] - d @ u
        shifted = numbers.concatenate([x[1:], (last @ x)[None]])
        return shifted + b @ u + gain[:, None] * r, r

    def scan(step):
        @jax.jit
        def run(u, y):
            return jax.lax.scan(step, numbers.zeros((NX, y.shape[1])), (u, y))[1]

        return lambda u, y: run(u, y).block_until_ready()

    return scan(dense_step), scan(canonical_step)


def main():
    describe("gtfdi", "numpy", "numba", "jax")
    system = model()
    observer = gtfdi.observer(system, poles=0.4)
    fleet = gtfdi.Fleet(observer, STREAMS)
    generator = np.random.default_rng(7)
    u = generator.standard_normal((SAMPLES, NU, STREAMS))
    y = generator.standard_normal((SAMPLES, STREAMS))
    a, b, c, d = system.A, system.B, system.C[0], system.D[0]
    gain = observer.gain

    def own():
        fleet.reset()
        return fleet.process(u, y[:, None])[:, 0]

    table = Race(
        f"Residuals of {STREAMS} streams: n = {NX}, r = {NU}, m = 1, N = {SAMPLES}",
        "M residuals/s",
        millions_a_second,
    )
    work = {"work": SAMPLES * STREAMS}
    checks = "also whether each sample is valid"
    expected = table.add("gtfdi.Fleet.process", own, **work, note=checks)
    alone = observer.residual(u[:, :, 0].copy(), y[:, 0].copy())
    assert relative_error(alone, expected[:, 0]) == 0.0, "a stream by itself has other residuals"
    check = {
        "error": lambda found: relative_error(found, expected),
        "tolerance": AGREEMENT,
    } | work
    if numba:
        canonical, tiled, dense = numba_loops()
        parts = (a[-1].copy(), b, d, gain, u, y)
        table.add("numba, canonical, streams side by side", lambda: canonical(*parts), **check)
        table.add(f"numba, canonical, tiles of {TILE}", lambda: tiled(*parts), **check)
        table.add("numba, dense, stream by stream", lambda: dense(a, b, c, d, gain, u, y), **check)
    else:
        for name in ["canonical, streams side by side", f"canonical, tiles of {TILE}"]:
            table.absent(f"numba, {name}")
        table.absent("numba, dense, stream by stream")
    closed, to_states = a - np.outer(gain, c), b - np.outer(gain, d)
    table.add(
        "NumPy, a product a sample",
        lambda: numpy_loop(closed, to_states, c, d, gain, u, y),
        **check,
    )
    if jax:
        jax.config.update("jax_enable_x64", True)
        with_dense, with_canonical = jax_scans(a, b, c, d, gain, a[-1])
        on_device = jax.numpy.asarray(u), jax.numpy.asarray(y)
        for name, run in [("dense", with_dense), ("canonical", with_canonical)]:
            table.add(f"JAX scan, {name}", lambda run=run: run(*on_device), **check)
    else:
        table.absent("JAX scan, dense")
        table.absent("JAX scan, canonical")
    table.finish()


if __name__ == "__main__":
    main()
