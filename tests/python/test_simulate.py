"""The embedded plant."""

import numpy as np
import pytest

import gtfdi

FOULING = {
    "case": "compressor_fouling",
    "onset_s": 4.0,
    "rate_percent_per_h": 3600.0,
    "limit_percent": 2.0,
}


def test_one_seed_gives_one_run():
    first, second = gtfdi.simulate(8.0, seed=3), gtfdi.simulate(8.0, seed=3)
    for one, other in [(first.truth, second.truth), (first.measured, second.measured)]:
        assert np.array_equal(one.u, other.u)
        assert np.array_equal(one.y, other.y)
    for different in (gtfdi.simulate(8.0, seed=4), gtfdi.simulate(8.0, seed=3, run_index=1)):
        assert not np.array_equal(first.measured.y, different.measured.y)


def test_run_has_the_shapes_of_time_on_axis_0():
    run = gtfdi.simulate(60.0, seed=3)
    assert len(run) == 750
    assert run.measured.u.shape == (750, 5)
    assert run.measured.y.shape == (750, 28)
    assert run.faults.shape == (750, 0)
    assert run.measured.y.dtype == np.float64
    assert run.measured.y.flags.c_contiguous
    # k Ts, no end point.
    assert np.array_equal(run.measured.time_s, 0.08 * np.arange(750))


def test_published_table3_is_where_the_plant_rests():
    # Table 3 of the paper: p7 = 206408 Pa, m9 = 1.82 .. the equilibrium is trimmed to it; 1e-4 is
    # what the printed digits of the other entries leave.
    run = gtfdi.simulate(2.0, profile="steady", noise="none")
    p7 = run.truth.y[:, run.truth.outputs.index("p7")]
    assert np.allclose(p7, 206408.0, rtol=1e-4, atol=0.0)
    assert run.truth.output_units[run.truth.outputs.index("p7")] == "Pa"


def test_truth_carries_no_noise_and_measured_does():
    run = gtfdi.simulate(8.0, noise="none")
    assert np.array_equal(run.truth.y, run.measured.y)
    run = gtfdi.simulate(8.0, noise="low")
    assert not np.array_equal(run.truth.y, run.measured.y)
    steady = gtfdi.simulate(2.0, profile="steady", noise="low")
    assert len(steady.warnings) == 1
    assert steady.warnings[0].startswith("no noise")


def test_faults_are_ramps_with_a_limit():
    run = gtfdi.simulate(8.0, faults=[FOULING])
    assert run.fault_names == ["compressor_fouling"]
    assert run.fault_units == ["%"]
    ramp = np.clip(run.truth.time_s - 4.0, 0.0, 2.0)[:, None]
    # One per cent a second; rounding of rate times time.
    assert np.allclose(run.faults, ramp, rtol=0.0, atol=1e-12)
    healthy = gtfdi.simulate(8.0)
    before = run.truth.time_s <= 4.0
    assert np.array_equal(run.truth.y[before], healthy.truth.y[before])
    assert not np.array_equal(run.truth.y[~before], healthy.truth.y[~before])


def test_refusals_are_the_plants_own():
    with pytest.raises(gtfdi.PlantError, match="^profile: expected one of steady, .*`calm`$"):
        gtfdi.simulate(1.0, profile="calm")
    with pytest.raises(gtfdi.PlantError, match="^noise: expected one of none, low"):
        gtfdi.simulate(1.0, noise="loud")
    with pytest.raises(gtfdi.PlantError, match="^duration: expected between 0.08 and"):
        gtfdi.simulate(float("nan"))
    with pytest.raises(gtfdi.PlantError, match="^substeps: expected 24 to"):
        gtfdi.simulate(1.0, substeps=1)
    with pytest.raises(gtfdi.PlantError, match="expected each case once, found compressor_fouling"):
        gtfdi.simulate(1.0, faults=[FOULING, FOULING])
    with pytest.raises(gtfdi.PlantError, match="^faults, entry 1: unknown variant `rust`"):
        gtfdi.simulate(1.0, faults=[FOULING, FOULING | {"case": "rust"}])
    with pytest.raises(gtfdi.PlantError, match="^faults, entry 0: unknown field `size`"):
        gtfdi.simulate(1.0, faults=[FOULING | {"size": 1.0}])
    with pytest.raises(gtfdi.PlantError, match="onset of a fault"):
        gtfdi.simulate(1.0, faults=[FOULING | {"onset_s": float("nan")}])
