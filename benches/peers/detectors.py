"""Statistics on one residual: gtfdi beside numba, plain Python and river."""

from timing import QUICK, Race, describe, millions_a_second, optional, relative_error

import numpy as np

from gtfdi import statistics

numba = optional("numba")
drift = optional("river.drift")

SAMPLES = 5_000 if QUICK else 500_000
#: Samples of what is a hundred times slower.
FEW = min(SAMPLES, 50_000)
#: Streams among which residuals are dealt out for many sums at once.
STREAMS = 250
ALLOWANCE, THRESHOLD = 0.5, 14.0
#: Longest window of the likelihood ratio, and the sizes of its ramps.
LONGEST, SIZES = 4096, (1e-3, 1e-2)
#: Samples between the alarms with the mean known and with the running mean.
ALARMS_NEAR = 10
#: Largest difference of a sum over the largest sum.
SUMS_AGREE = 1e-12
#: The same of likelihood ratios: the running sums begin elsewhere, and differences of them cancel.
RATIOS_AGREE = 1e-7


def python_cusum(residuals):
    upper = lower = 0.0
    values = []
    for r in residuals:
        upper = max(0.0, upper + (r - ALLOWANCE))
        lower = max(0.0, lower + (-r - ALLOWANCE))
        values.append(max(upper, lower))
    return values


def python_page_hinkley(residuals):
    """The first alarm of a CUSUM of the residuals less their running mean."""
    mean = value = 0.0
    for k, r in enumerate(residuals):
        mean += (r - mean) / (k + 1)
        value = max(0.0, value + (r - mean - ALLOWANCE))
        if value > THRESHOLD:
            return k
    return None


def gtfdi_page_hinkley(cusum, residuals):
    """The same with a gtfdi CUSUM, the running mean by NumPy."""
    cusum.reset()
    means = np.cumsum(residuals) / np.arange(1, len(residuals) + 1)
    return first_above(cusum.process(residuals - means))


def river_page_hinkley(residuals):
    detector = drift.PageHinkley(
        min_instances=1, delta=ALLOWANCE, threshold=THRESHOLD, alpha=1.0, mode="up"
    )
    for k, r in enumerate(residuals):
        detector.update(r)
        if detector.drift_detected:
            return k
    return None


def first_above(values):
    above = values > THRESHOLD
    return int(above.argmax()) if above.any() else None


def window_lengths():
    """1, 2, 3, 4, 6, 8, 11, 16, ...: each about the root of two times the one before."""
    lengths = {int(2.0 ** (power / 2) + 0.5) for power in range(64)}
    return np.array(sorted({length for length in lengths if length < LONGEST} | {LONGEST}))


def numba_loops():
    @numba.njit
    def cusum(residuals):
        upper = lower = 0.0
        values = np.empty_like(residuals)
        for k in range(len(residuals)):
            r = residuals[k]
            upper = max(0.0, upper + (r - ALLOWANCE))
            lower = max(0.0, lower + (-r - ALLOWANCE))
            values[k] = max(upper, lower)
        return values

    @numba.njit
    def cusums(residuals):
        """Many streams, those of a sample side by side."""
        samples, streams = residuals.shape
        upper, lower = np.zeros(streams), np.zeros(streams)
        values = np.empty_like(residuals)
        for k in range(samples):
            for s in range(streams):
                r = residuals[k, s]
                upper[s] = max(0.0, upper[s] + (r - ALLOWANCE))
                lower[s] = max(0.0, lower[s] + (-r - ALLOWANCE))
                values[k, s] = max(upper[s], lower[s])
        return values

    @numba.njit
    def ramp_ratio(residuals, lengths):
        """Two-sided likelihood ratios of ramps by running sums over the whole record."""
        count = len(residuals)
        p, q = np.zeros(count + 1), np.zeros(count + 1)
        energies = lengths * (lengths + 1.0) * (2.0 * lengths + 1.0) / 6.0
        values = np.zeros(count)
        for k in range(count):
            p[k + 1] = p[k] + residuals[k]
            q[k + 1] = q[k] + (k + 1) * residuals[k]
            best = 0.0
            for w in range(len(lengths)):
                before = k + 1 - lengths[w]
                if before < 0:
                    break
                moment = abs(q[k + 1] - q[before] - before * (p[k + 1] - p[before]))
                size = min(max(moment / energies[w], SIZES[0]), SIZES[1])
                best = max(best, size * (moment - 0.5 * size * energies[w]))
            values[k] = best
        return values

    return cusum, cusums, ramp_ratio


def race(title):
    return Race(f"{title}, N = {SAMPLES}", "M residuals/s", millions_a_second)


def sums(residuals, loops):
    table = race("Two-sided CUSUM, the value after each residual")
    own = statistics.Cusum(ALLOWANCE, THRESHOLD)

    def process():
        own.reset()
        return own.process(residuals)

    note = "also whether each residual is finite"
    expected = table.add("gtfdi Cusum.process", process, work=SAMPLES, note=note)

    def error(found):
        return relative_error(found, expected[: len(found)])

    check = {"error": error, "tolerance": SUMS_AGREE}
    few = residuals[:FEW]

    def steps():
        own.reset()
        return [own.step(r)[0] for r in few]

    table.add("gtfdi Cusum.step, a residual a call", steps, work=FEW, **check)
    if loops:
        table.add("numba", lambda: loops[0](residuals), work=SAMPLES, **check)
    else:
        table.absent("numba")
    numbers = few.tolist()
    table.add("plain Python", lambda: python_cusum(numbers), work=FEW, **check)
    table.finish()


def many_sums(residuals, loops):
    table = race(f"Two-sided CUSUM of {STREAMS} streams")
    dealt = residuals.reshape(-1, STREAMS)
    fleet = statistics.CusumFleet(statistics.Cusum(ALLOWANCE, THRESHOLD), STREAMS)

    def process():
        fleet.reset()
        return fleet.process(dealt)

    note = "also whether each residual is finite"
    expected = table.add("gtfdi CusumFleet.process", process, work=SAMPLES, note=note)
    if loops:
        table.add(
            "numba, streams side by side",
            lambda: loops[1](dealt),
            work=SAMPLES,
            error=lambda found: relative_error(found, expected),
            tolerance=SUMS_AGREE,
        )
    else:
        table.absent("numba, streams side by side")
    table.finish()


def page_hinkley(residuals):
    """The alarm comes in the last hundredth, so that all contenders go through all residuals."""
    table = race("Page-Hinkley, upwards, until its alarm")
    few = residuals[:FEW].copy()
    few[-FEW // 100 :] += 2.0
    own = statistics.Cusum(ALLOWANCE, THRESHOLD, sides="upper")
    expected = table.add(
        "gtfdi Cusum.process, running mean by NumPy",
        lambda: gtfdi_page_hinkley(own, few),
        work=FEW,
    )
    assert expected is not None and expected > FEW - FEW // 100, "the alarm is not where it was put"

    def with_mean_known():
        own.reset()
        return first_above(own.process(few))

    table.add(
        "gtfdi Cusum.process, mean known",
        with_mean_known,
        work=FEW,
        error=lambda found: abs(found - expected),
        tolerance=ALARMS_NEAR,
        note="error: samples between the alarms",
    )
    # The same sample: there is nothing to tolerate.
    check = {"error": lambda found: 0.0 if found == expected else float("inf"), "tolerance": 0.0}
    numbers = few.tolist()
    if drift:
        table.add("river PageHinkley", lambda: river_page_hinkley(numbers), work=FEW, **check)
    else:
        table.absent("river PageHinkley")
    table.add("plain Python", lambda: python_page_hinkley(numbers), work=FEW, **check)
    table.finish()


def likelihood_ratio(residuals, loops):
    lengths = window_lengths()
    table = race(f"Likelihood ratio of ramps, two-sided, {len(lengths)} windows")
    own = statistics.Glr("ramp", SIZES, THRESHOLD, longest=LONGEST)

    def process():
        own.reset()
        return own.process(residuals)

    note = "also onset and size; sums do not grow with the record"
    expected = table.add("gtfdi Glr.process", process, work=SAMPLES, note=note)
    if loops:
        table.add(
            "numba, running sums over the record",
            lambda: loops[2](residuals, lengths),
            work=SAMPLES,
            error=lambda found: relative_error(found, expected),
            tolerance=RATIOS_AGREE,
        )
    else:
        table.absent("numba, running sums over the record")
    table.finish()


def main():
    describe("gtfdi", "numpy", "numba", "river")
    residuals = np.random.default_rng(7).standard_normal(SAMPLES)
    loops = numba_loops() if numba else None
    sums(residuals, loops)
    many_sums(residuals, loops)
    page_hinkley(residuals)
    likelihood_ratio(residuals, loops)


if __name__ == "__main__":
    main()
