"""ARX models by least squares: gtfdi beside NumPy and SciPy, with the error of the coefficients.

All get the inputs and outputs, as a user has them, remove the means, form the regressors and solve.
"""

from timing import QUICK, Race, describe, milliseconds, optional

import numpy as np

import gtfdi

scipy_linalg = optional("scipy.linalg")

ORDER = 8
ORDERS = 12
INPUT_POLE = 0.99
#: Largest relative error of gtfdi's coefficients.
AGREEMENT = 1e-9
#: The same of peers: QR factorisations of a million rows are off by 1e-9 at a condition of 3e7.
PEERS_AGREE = 1e-8
#: Normal equations lose as many digits again as the condition has: from here on they are not timed.
NORMAL_EQUATIONS_AGREE = 1e-6
#: Largest relative difference of residual sums of squares from those of separate fits.
SUMS_AGREE = 1e-9


def record(samples, outputs, deviation):
    """Two slow inputs into outputs with double poles at 0.9 and less: lags are nearly alike."""
    generator = np.random.default_rng(1)

    def double_pole(pole):
        return np.array([[2.0 * pole, -pole * pole], [1.0, 0.0]])

    def of(a, b, drive):
        system = gtfdi.StateSpace(a, b, a[:1], b[:1], 0.08)
        return system.simulate(drive)[:, 0]

    drive = (1.0 - INPUT_POLE) ** 2 * generator.standard_normal((2, samples, 1))
    one = np.array([[1.0], [0.0]])
    u = np.stack([of(double_pole(INPUT_POLE), one, each) for each in drive], axis=1)
    late = np.zeros((samples, 2))
    late[1:, 0], late[2:, 1] = u[:-1, 0], u[:-2, 1]
    sources = 0.1 * (late[:, 0] + 0.5 * late[:, 1])[:, None] + deviation * (
        generator.standard_normal((samples, outputs))
    )
    y = [of(double_pole(0.9 - 0.02 * j), one, sources[:, j : j + 1]) for j in range(outputs)]
    return u, np.stack(y, axis=1)


def regressors(u, y, order=ORDER, first=ORDER):
    """The regressors and the outputs: columns are the lags of the outputs, then of the inputs."""
    channels = np.hstack([y - y.mean(axis=0), u - u.mean(axis=0)])
    rows = len(y) - first
    phi = np.empty((rows, order * channels.shape[1]))
    for channel, values in enumerate(channels.T):
        for lag in range(1, order + 1):
            phi[:, channel * order + lag - 1] = values[first - lag : first - lag + rows]
    return phi, channels[first:, : y.shape[1]]


def lstsq(phi, target):
    return np.linalg.lstsq(phi, target)[0]


def by_qr(phi, target):
    q, r = scipy_linalg.qr(phi, mode="economic", check_finite=False)
    return scipy_linalg.solve_triangular(r, q.T @ target)


def numpy_qr(phi, target):
    q, r = np.linalg.qr(phi)
    return np.linalg.solve(r, q.T @ target)


def normal_equations(phi, target):
    return np.linalg.solve(phi.T @ phi, phi.T @ target)


def exact_coefficients(phi, target):
    """The least squares solution, refined with sums in extended precision where there is one."""
    factor = np.linalg.qr(phi, mode="r")
    theta = lstsq(phi, target).astype(np.longdouble)
    for _ in range(12):
        gradient = np.zeros_like(theta)
        for start in range(0, len(phi), 10_000):
            rows = phi[start : start + 10_000].astype(np.longdouble)
            gradient += rows.T @ (target[start : start + 10_000] - rows @ theta)
        step = np.linalg.solve(factor, np.linalg.solve(factor.T, gradient.astype(float)))
        theta += step
        if np.linalg.norm(step) <= 1e-13 * np.linalg.norm(theta.astype(float)):
            break
    return theta.astype(float)


def coefficients(model):
    """The coefficients of a model in the order of the regressors."""
    channels = model.outputs + model.inputs
    theta = np.zeros((ORDER * len(channels), len(model.outputs)))
    for output, terms in enumerate(model.regression):
        for term in terms:
            row = channels.index(term["signal"]) * ORDER + term["lag"] - 1
            theta[row, output] = term["coefficient"]
    return theta


def fits(samples, outputs, deviation):
    u, y = record(samples, outputs, deviation)
    formed = regressors(u, y)
    exact = exact_coefficients(*formed)

    def error(theta):
        norms = np.linalg.norm(theta - exact, axis=0) / np.linalg.norm(exact, axis=0)
        return float(np.nan_to_num(norms, nan=np.inf).max())

    def fit(solver):
        return gtfdi.arx(u, y, order=ORDER, structure="full", solver=solver)

    condition = np.linalg.cond(np.linalg.qr(formed[0], mode="r"))
    solved_by = gtfdi.Arx(order=ORDER, structure="full", solver="automatic").fit_in_full(u, y)
    race = Race(
        f"ARX: N = {samples}, {outputs} output(s), {len(exact)} regressors, condition "
        f"{condition:.1e}, automatic solved by {solved_by.solved_by[0]}",
        "ms",
        milliseconds,
    )
    for name, solver in [("automatic", "automatic"), ("default, QR in blocks", "qr")]:
        race.add(
            f"gtfdi.arx, {name}",
            lambda solver=solver: fit(solver),
            error=lambda model: error(coefficients(model)),
            tolerance=AGREEMENT,
            note="also standard errors, condition, variances",
        )
    check = {"error": error, "tolerance": PEERS_AGREE}
    race.add("numpy.linalg.lstsq", lambda: lstsq(*regressors(u, y)), **check)
    race.add("numpy.linalg.lstsq, regressors formed before", lambda: lstsq(*formed), **check)
    race.add("numpy.linalg.qr", lambda: numpy_qr(*regressors(u, y)), **check)
    if scipy_linalg:
        race.add("scipy.linalg.qr", lambda: by_qr(*regressors(u, y)), **check)
        race.add(
            "scipy.linalg.lstsq, gelsy",
            lambda: scipy_linalg.lstsq(*regressors(u, y), lapack_driver="gelsy")[0],
            **check,
        )
    else:
        race.absent("scipy.linalg.qr")
        race.absent("scipy.linalg.lstsq, gelsy")
    wrong = error(normal_equations(*formed))
    if wrong <= NORMAL_EQUATIONS_AGREE:
        race.add(
            "normal equations",
            lambda: normal_equations(*regressors(u, y)),
            error=error,
            tolerance=NORMAL_EQUATIONS_AGREE,
        )
    else:
        race.absent("normal equations", f"not timed: the coefficients are off by {wrong:.0e}")
    race.finish()


def search(samples, outputs):
    u, y = record(samples, outputs, 1e-3)

    def repeated():
        """The residual variances of all orders on the same rows, each by a fit of its own."""
        found = []
        for order in range(1, ORDERS + 1):
            phi, target = regressors(u, y, order, ORDERS)
            residual = target - phi @ lstsq(phi, target)
            found.append((residual**2).sum(axis=0) / len(phi))
        return np.array(found)

    def one_qr():
        """The same of one factor of the largest order, columns sorted by lag: the rest is small."""
        phi, target = regressors(u, y, ORDERS, ORDERS)
        count = phi.shape[1] // ORDERS
        by_lag = phi.reshape(len(phi), count, ORDERS).swapaxes(1, 2).reshape(len(phi), -1)
        factor = np.linalg.qr(np.hstack([by_lag, target]), mode="r")
        right = factor[:, -target.shape[1] :] ** 2
        return np.array(
            [right[order * count :].sum(axis=0) / len(phi) for order in range(1, ORDERS + 1)]
        )

    race = Race(f"Orders 1 to {ORDERS}: N = {samples}, {outputs} output(s)", "ms", milliseconds)
    table = race.add(
        "gtfdi.order_table",
        lambda: gtfdi.order_table(u, y, (1, ORDERS), structure="full"),
        note="also the criteria, errors and conditions of every order",
    )
    own = np.array([row["residual_variance"] for row in table])

    def error(found):
        return float(np.abs(found / own - 1.0).max())

    race.add("numpy.linalg.lstsq for each order", repeated, error=error, tolerance=SUMS_AGREE)
    race.add("one numpy.linalg.qr for all", one_qr, error=error, tolerance=SUMS_AGREE)
    race.finish()


def main():
    describe("gtfdi", "numpy", "scipy")
    sizes = [1_000] if QUICK else [100_000, 1_000_000]
    for samples in sizes:
        for outputs, deviation in [(1, 1e-3), (1, 2e-7), (4, 1e-3)]:
            # The worst condition wants many samples, many outputs want much memory.
            if not (QUICK and deviation < 1e-3 or samples == 1_000_000 and outputs > 1):
                fits(samples, outputs, deviation)
    for outputs in [1, 4]:
        search(sizes[0], outputs)


if __name__ == "__main__":
    main()
