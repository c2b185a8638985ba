"""Poles chosen by pairs of records without and with a fault."""

import pickle

import numpy as np
import pytest

import gtfdi

DRIFT = {"case": "thermocouple_drift", "onset_s": 20.0, "rate_percent_per_h": 20.0}


def twins(seed):
    """A run of a minute without and with the drift."""
    return tuple(
        gtfdi.simulate(60.0, seed=seed, faults=faults).measured for faults in ([], [DRIFT])
    )


@pytest.fixture(scope="module")
def pairs():
    return [twins(seed) for seed in (5, 6, 7)]


@pytest.fixture(scope="module")
def part(healthy):
    inputs = ["a_v", "M_f"]
    model = gtfdi.arx(healthy.measured, order=2, nk=1, inputs=inputs, outputs="t3")
    return model.output_model(0)


def energy(observer, record, skip=0):
    return np.sum(observer.residual(record)[skip:] ** 2)


def effect(observer, healthy, faulty, skip=0):
    """The energy of what the fault adds to the residual, by linearity the residuals' difference."""
    difference = observer.residual(faulty) - observer.residual(healthy)
    return np.sum(difference[skip:] ** 2)


def fault_energy(observer, pairs, skip=0):
    below = sum(effect(observer, *pair, skip) for pair in pairs)
    return sum(energy(observer, pair[0], skip) for pair in pairs) / below


@pytest.mark.parametrize("skip", [0, 50])
def test_prop_v_is_the_ratio_of_the_observers_residuals(part, pairs, skip):
    training, validation = pairs[:2], pairs[2:]
    design = gtfdi.optimise_observer(part, training, validation, radius=0.95, skip_samples=skip)
    assert (design.criterion, design.radius) == ("fault-energy", 0.95)
    # A residual is a difference of numbers near each other: rounding of it in both programs.
    assert design.v == pytest.approx(fault_energy(design.observer, training, skip), rel=1e-6)
    expected = fault_energy(design.observer, validation, skip)
    assert design.v_validation == pytest.approx(expected, rel=1e-6)
    assert 0.0 < design.bound <= design.v
    assert design.bound_validation > 0.0
    # The cap is one on coefficients: a double pole is known to the root of their rounding.
    assert np.abs(design.poles).max() <= 0.95 + 1e-7
    assert design.poles.dtype == complex
    assert np.array_equal(design.observer.poles, design.poles)
    # No equal real poles inside the cap do better.
    for pole in np.linspace(-0.9, 0.95, 12):
        assert fault_energy(gtfdi.observer(part, pole), training, skip) >= design.v * (1 - 1e-6)


def test_the_papers_criterion_is_of_the_faulty_residual(part, pairs):
    design = gtfdi.optimise_observer(part, pairs[:1], criterion="paper", radius=0.9)
    healthy, faulty = pairs[0]
    expected = energy(design.observer, healthy) / energy(design.observer, faulty)
    assert design.v == pytest.approx(expected, rel=1e-6)
    assert (design.criterion, design.v_validation, design.bound_validation) == ("paper", None, None)


def test_attempts_are_told_and_the_best_is_taken(part, pairs):
    options = {"radius": 0.9, "diagonal_starts": 3, "random_starts": 4}
    design = gtfdi.optimise_observer(part, pairs[:1], seed=3, **options)
    # Two poles: three vertices, as many inside, and the starts asked for.
    assert len(design.attempts) == 3 + 3 + 3 + 4
    assert design.evaluations == sum(attempt["evaluations"] for attempt in design.attempts)
    best = min(design.attempts, key=lambda attempt: attempt["v"])
    assert best["start"] == design.start
    assert best["v"] == pytest.approx(design.v, rel=1e-9)
    assert gtfdi.optimise_observer(part, pairs[:1], seed=3, **options) == design
    other = gtfdi.optimise_observer(part, pairs[:1], seed=4, **options)
    assert other.attempts[:9] == design.attempts[:9]
    assert other.attempts[9:] != design.attempts[9:]
    evolution = gtfdi.optimise_observer(part, pairs[:1], method="evolution", radius=0.9)
    assert evolution.start == {"kind": "evolution"}
    assert evolution.v == pytest.approx(design.v, rel=0.01)


def test_designs_pickle_and_go_into_a_bank(part, pairs, healthy):
    design = gtfdi.optimise_observer(part, pairs[:1], pairs[1:2], radius=0.9)
    copy = pickle.loads(pickle.dumps(design))
    assert copy == design
    assert (copy.v, copy.bound, copy.start) == (design.v, design.bound, design.start)
    assert repr(design).startswith("ObserverDesign(output: t3, v: ")
    with pytest.raises(gtfdi.OptionError, match="^option `poles`: expected those of the observer"):
        text = design.to_json()
        part_of = gtfdi.observer(part, 0.5).to_json()
        head, _ = text.split('"observer":')
        gtfdi.ObserverDesign.from_json(f'{head}"observer":{part_of}}}')
    inputs = ["a_v", "M_f"]
    model = gtfdi.arx(healthy.measured, order=2, nk=1, inputs=inputs, outputs="t3")
    bank = gtfdi.design(model, [pair[0] for pair in pairs], poles=design.poles)
    assert bank.detect(pairs[0][1]).alarms
    residuals = bank.detect(pairs[2][0]).residuals[:, 0]
    assert np.array_equal(residuals, design.observer.residual(pairs[2][0]))


def test_arrays_and_a_state_space_model(random_record):
    system, u, y = random_record(4, nx=2, nu=1)
    noise = np.random.default_rng(5).standard_normal(y.shape)
    faulty = y + noise
    faulty[200:] += 1.0
    pair = ((u + 2.0, y + noise + 3.0), (u + 2.0, faulty + 3.0))
    design = gtfdi.optimise_observer(system, [pair], point=([2.0], [3.0]), random_starts=0)
    without, with_fault = (design.observer.residual(*record) for record in pair)
    expected = np.sum(without**2) / np.sum((with_fault - without) ** 2)
    assert design.v == pytest.approx(expected, rel=1e-9)
    # A step of the sensor: V' of the deadbeat observer, which forgets it, is far above.
    deadbeat = gtfdi.optimise_observer(system, [pair], point=([2.0], [3.0]), radius=1e-6)
    assert deadbeat.v > design.v


def test_refusals_of_searches(part, pairs):
    def refused(error, match, pairs, **options):
        with pytest.raises(error, match=match):
            gtfdi.optimise_observer(part, pairs, **options)

    healthy, faulty = pairs[0]
    refused(gtfdi.DesignError, "^training records: expected at least one healthy and faulty", [])
    refused(gtfdi.DesignError, "^option `radius`: expected a radius above 0", pairs, radius=1.0)
    refused(gtfdi.DesignError, "^training pairs of the paper's criterion", pairs, criterion="paper")
    refused(
        gtfdi.OptionError,
        '^option criterion: expected fault-energy or paper, found "v"$',
        pairs,
        criterion="v",
    )
    refused(
        gtfdi.OptionError,
        '^option method: expected descent or evolution, found "luck"$',
        pairs,
        method="luck",
    )
    refused(
        gtfdi.DesignError,
        "^training records, energy of the difference that the fault makes: expected a positive",
        [(healthy, healthy)],
    )
    refused(
        gtfdi.DesignError,
        "^validation pair 0, samples of the faulty record: expected 750, found 1$",
        [(healthy, faulty)],
        validation=[(healthy, ([[0.0, 0.0]], [0.0]))],
    )
