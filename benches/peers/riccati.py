"""Riccati equations and poles placed, 8 states: gtfdi beside SciPy, python-control and Slycot."""

import warnings

from timing import QUICK, Race, describe, microseconds, optional, relative_error

import numpy as np

import gtfdi

control = optional("control")
scipy_linalg = optional("scipy.linalg")
scipy_signal = optional("scipy.signal")
slycot = optional("slycot")

NX = 8
#: Largest difference of solutions over the largest entry.
SOLUTIONS_AGREE = 1e-10
#: Largest difference of a placed pole from the pole asked for.
POLES_AGREE = 1e-8


def problem(outputs):
    """A stable system: A, C, Q and R."""
    generator = np.random.default_rng(outputs)
    a = 0.7 * np.eye(NX) + generator.uniform(-0.15, 0.15, (NX, NX))
    c = generator.uniform(-0.5, 0.5, (outputs, NX))
    return a, c, np.eye(NX), np.eye(outputs)


def equation(outputs):
    a, c, q, r = problem(outputs)
    table = Race(
        f"Discrete Riccati equation of a filter, {NX} states, {outputs} output(s)",
        "us",
        microseconds,
    )
    own = gtfdi.riccati(a, c, q, r)
    expected = own.P
    note = f"relative residual {own.relative_residual:.0e}; also that it stabilises"
    table.add("gtfdi.riccati", lambda: gtfdi.riccati(a, c, q, r), note=note)
    check = {
        "error": lambda found: relative_error(found, expected),
        "tolerance": SOLUTIONS_AGREE,
    }
    if scipy_linalg:
        table.add(
            "scipy.linalg.solve_discrete_are",
            lambda: scipy_linalg.solve_discrete_are(a.T, c.T, q, r),
            **check,
        )
    else:
        table.absent("scipy.linalg.solve_discrete_are")
    if control:
        by = "Slycot" if slycot else "SciPy"
        table.add(
            f"control.dare, by {by}",
            lambda: control.dare(a.T, c.T, q, r)[0],
            **check,
            note="also the gain and the poles",
        )
    else:
        table.absent("control.dare")
    if slycot:
        weighted = c.T @ np.linalg.solve(r, c)
        table.add(
            "slycot.sb02md",
            # Of the inverse pencil, whose stable half comes first.
            lambda: slycot.sb02md(NX, a.T, weighted, q, "D", hinv="I")[0],
            **check,
        )
    else:
        table.absent("slycot.sb02md")
    table.finish()


def placement(outputs):
    a, c, _, _ = problem(outputs)
    poles = np.linspace(0.1, 0.6, NX)
    model = gtfdi.StateSpace(a, np.zeros((NX, 1)), c, np.zeros((outputs, 1)), 0.1)
    table = Race(
        f"Gain of an observer by its poles, {NX} states, {outputs} output(s)", "us", microseconds
    )

    def error(gain):
        """The gains of several outputs differ, the poles do not."""
        found = np.linalg.eigvals(a - np.reshape(gain, (NX, outputs)) @ c)
        return float(np.abs(np.sort_complex(found) - poles).max())

    check = {"error": error, "tolerance": POLES_AGREE}
    table.add("gtfdi.place", lambda: gtfdi.place(model, poles), **check)
    if scipy_signal:
        table.add(
            "scipy.signal.place_poles",
            lambda: scipy_signal.place_poles(a.T, c.T, poles).gain_matrix.T,
            **check,
            note="a gain of well-conditioned eigenvectors" if outputs > 1 else "",
        )
    else:
        table.absent("scipy.signal.place_poles")
    if slycot:
        # Of gains that are large beside A.
        warnings.simplefilter("ignore", slycot.exceptions.SlycotResultWarning)
        table.add(
            "slycot.sb01bd",
            # The feedback is added there.
            lambda: -slycot.sb01bd(NX, outputs, NX, 0.0, a.T, c.T, poles, "D")[5].T,
            **check,
            note="makes a warning of a large gain" if outputs == 1 else "",
        )
    else:
        table.absent("slycot.sb01bd")
    table.finish()


def main():
    describe("gtfdi", "numpy", "scipy", "control", "slycot")
    for outputs in [1] if QUICK else [1, 4]:
        equation(outputs)
        placement(outputs)


if __name__ == "__main__":
    main()
