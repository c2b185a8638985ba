"""Residuals of one stream by a steady Kalman filter: gtfdi beside filters and loops in Python."""

from systems import canonical
from timing import QUICK, Race, describe, millions_a_second, optional, relative_error

import numpy as np

import gtfdi

filterpy = optional("filterpy.kalman")
numba = optional("numba")
scipy_signal = optional("scipy.signal")

NX, NU = 8, 2
SAMPLES = 2_000 if QUICK else 200_000
#: Samples of what is a hundred times slower.
FEW = min(SAMPLES, 10_000)
SAMPLE_TIME_S = 0.08
#: Largest difference of residuals over the largest residual: additions come in another order.
AGREEMENT = 1e-11
#: The same of transfer functions, which lose digits.
TRANSFER_FUNCTIONS_AGREE = 1e-6


def dense(outputs):
    """A random stable system."""
    generator = np.random.default_rng(outputs)
    a = generator.standard_normal((NX, NX))
    a *= 0.95 / np.abs(np.linalg.eigvals(a)).max()
    return a, generator.standard_normal((NX, NU)), generator.standard_normal((outputs, NX))


def numpy_loop(a, b, c, gain, u, y):
    """The innovation form as it stands in a book."""
    x, residuals = np.zeros(NX), np.empty_like(y)
    for k in range(len(y)):
        r = y[k] - c @ x
        x = a @ x + b @ u[k] + gain @ r
        residuals[k] = r
    return residuals


def filterpy_loop(a, b, c, filter_gain, u, y):
    own = filterpy.KalmanFilter(dim_x=NX, dim_z=len(c), dim_u=NU)
    own.F, own.B, own.H = a, b, c
    own.K = filter_gain
    own.x, residuals = np.zeros((NX, 1)), np.empty_like(y)
    u, y = u[:, :, None], y[:, :, None]
    for k in range(len(y)):
        own.update_steadystate(y[k])
        residuals[k] = own.y[:, 0]
        own.predict_steadystate(u[k])
    return residuals


def numba_loops(ny):
    """Two compiled functions of (a, b, c, gain, u, y) whose sizes the compiler knows."""

    @numba.njit
    def innovation_form(a, b, c, gain, u, y):
        x, after, r = np.zeros(NX), np.zeros(NX), np.zeros(ny)
        residuals = np.empty_like(y)
        for k in range(len(y)):
            for o in range(ny):
                r[o] = y[k, o]
                for j in range(NX):
                    r[o] -= c[o, j] * x[j]
                residuals[k, o] = r[o]
            for i in range(NX):
                total = 0.0
                for j in range(NX):
                    total += a[i, j] * x[j]
                for j in range(NU):
                    total += b[i, j] * u[k, j]
                for o in range(ny):
                    total += gain[i, o] * r[o]
                after[i] = total
            x[:] = after
        return residuals

    @numba.njit
    def closed_loop(a, b, c, gain, u, y):
        """By columns of A - K C: no product waits for a residual, and columns fill registers."""
        closed = np.ascontiguousarray((a - gain @ c).T)
        inputs, gains, rows = b.T.copy(), gain.T.copy(), c.T.copy()
        x, after, r = np.zeros(NX), np.zeros(NX), np.zeros(ny)
        residuals = np.empty_like(y)
        for k in range(len(y)):
            for i in range(NX):
                after[i] = 0.0
            for o in range(ny):
                r[o] = y[k, o]
                for i in range(NX):
                    after[i] += gains[o, i] * y[k, o]
            for j in range(NU):
                for i in range(NX):
                    after[i] += inputs[j, i] * u[k, j]
            for j in range(NX):
                for o in range(ny):
                    r[o] -= rows[j, o] * x[j]
                for i in range(NX):
                    after[i] += closed[j, i] * x[j]
            for o in range(ny):
                residuals[k, o] = r[o]
            for i in range(NX):
                x[i] = after[i]
        return residuals

    return innovation_form, closed_loop


def from_both(a, b, c, gain):
    """The system from inputs and outputs to residuals."""
    ny = len(c)
    return a - gain @ c, np.hstack([b, gain]), -c, np.hstack([np.zeros((ny, NU)), np.eye(ny)])


def by_transfer_functions(systems, both):
    """A filter for each channel and residual; ``systems`` are (numerators, denominator)."""
    ny = len(systems[0][0])
    residuals = np.zeros((len(both), ny))
    for channel, (numerators, denominator) in enumerate(systems):
        for output in range(ny):
            residuals[:, output] += scipy_signal.lfilter(
                numerators[output], denominator, both[:, channel]
            )
    return residuals


def race(name, a, b, c):
    ny = len(c)
    system = gtfdi.StateSpace(a, b, c, np.zeros((ny, NU)), SAMPLE_TIME_S)
    noise = gtfdi.NoiseCovariance(Q=np.eye(NX), R=np.eye(ny))
    own = gtfdi.kalman(system, noise=noise)
    gain, filter_gain = own.predictor_gain, own.filter_gain
    generator = np.random.default_rng(7)
    u = generator.standard_normal((SAMPLES, NU))
    y = system.simulate(u) + generator.standard_normal((SAMPLES, ny))
    record = gtfdi.Dataset(u, y, SAMPLE_TIME_S)

    table = Race(
        f"Residuals of one stream, {name}: n = {NX}, r = {NU}, m = {ny}, N = {SAMPLES}",
        "M samples/s",
        millions_a_second,
    )
    checks = "also whether each sample is valid"
    run = {"work": SAMPLES, "note": checks}
    expected = table.add("gtfdi, record is a Dataset", lambda: own.innovations(record), **run)
    expected = np.reshape(expected, (SAMPLES, ny))

    def error(found):
        return relative_error(np.reshape(found, (-1, ny)), expected[: len(found)])

    check = {"error": error, "tolerance": AGREEMENT}
    table.add("gtfdi, record is arrays", lambda: own.innovations(u, y), **run, **check)
    if numba:
        innovation_form, closed_loop = numba_loops(ny)
        for title, compiled in [
            ("numba, innovation form", innovation_form),
            ("numba, columns of A - K C", closed_loop),
        ]:
            table.add(
                title,
                lambda compiled=compiled: compiled(a, b, c, gain, u, y),
                work=SAMPLES,
                **check,
            )
    else:
        table.absent("numba, innovation form")
        table.absent("numba, columns of A - K C")
    if scipy_signal:
        closed = from_both(a, b, c, gain)
        both = np.hstack([u, y])
        systems = [scipy_signal.ss2tf(*closed, input=j) for j in range(NU + ny)]
        table.add(
            "scipy.signal.lfilter, transfer functions",
            lambda: by_transfer_functions(systems, both),
            work=SAMPLES,
            error=error,
            tolerance=TRANSFER_FUNCTIONS_AGREE,
        )
        discrete = (*closed, SAMPLE_TIME_S)
        table.add(
            "scipy.signal.dlsim",
            lambda: scipy_signal.dlsim(discrete, both[:FEW])[1],
            work=FEW,
            **check,
        )
    else:
        table.absent("scipy.signal.lfilter, transfer functions")
        table.absent("scipy.signal.dlsim")
    few = u[:FEW], y[:FEW]
    table.add("NumPy loop", lambda: numpy_loop(a, b, c, gain, *few), work=FEW, **check)
    if filterpy:
        table.add(
            "filterpy, steady state",
            lambda: filterpy_loop(a, b, c, filter_gain, *few),
            work=FEW,
            **check,
        )
    else:
        table.absent("filterpy, steady state")
    table.finish()


def main():
    describe("gtfdi", "numpy", "numba", "scipy", "filterpy")
    race("canonical form", *canonical(NX, NU))
    race("dense", *dense(1))
    race("dense", *dense(4))


if __name__ == "__main__":
    main()
