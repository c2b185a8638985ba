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
    assert run.measured.u.shape == (750, 6)
    assert run.measured.y.shape == (750, 28)
    assert run.faults.shape == (750, 0)
    assert run.hidden.shape == (750, 3)
    assert run.hidden_names == ["e_c", "e_t", "M_fc"]
    assert run.ended is None
    assert run.measured.y.dtype == np.float64
    assert run.measured.y.flags.c_contiguous
    # k Ts, no end point.
    assert np.array_equal(run.measured.time_s, 0.08 * np.arange(750))


def test_cogeneration_has_an_input_and_three_outputs_more():
    run = gtfdi.simulate(8.0, variant="cogeneration")
    assert run.measured.u.shape == (100, 7)
    assert run.measured.y.shape == (100, 31)
    assert run.measured.inputs[-1] == "IGV"
    assert run.measured.outputs[-3:] == ["P_e", "T_ot", "m_ot"]
    assert repr(run) == "Run(cogeneration, 100 samples of 0.08 s, seed 1, faults: none)"


def test_a_scenario_is_everything_and_arguments_replace_its_fields(tmp_path):
    scenario = {
        "variant": "cogeneration",
        "duration_s": 4,
        "seed": np.int64(5),
        "profile": {"fuel_schedule": np.array([[0.0, 0.9], [3.0, 0.88]]), "dither_fraction": 0},
        "boundary": {"temperature_k": {"offset": np.float32(-10.0), "rate_per_h": -3600.0}},
        "disturbance": {"torque_n_m": {"deviation": 1.0, "time_constant_s": 1.0}},
        "noise": None,
        "faults": [{"actuator": "IGV", "mode": "stuck", "onset_s": 2.0}],
    }
    run = gtfdi.simulate(scenario=scenario)
    assert len(run) == 50
    assert run.fault_names == ["IGV_actuator_stuck"]
    # The defaults of the arguments do not count beside a scenario: no noise.
    assert np.array_equal(run.measured.y, run.truth.y)
    ambient = run.truth.u[:, run.truth.inputs.index("T_a")]
    # A degree a second from 10 K below design, recorded as it is held from each sample on.
    expected = 288.16 - 10.0 - 0.08 * np.arange(50)
    assert np.allclose(ambient, expected, rtol=0.0, atol=1e-9)

    # A file, and the configuration of a run, say the same.
    path = tmp_path / "s.toml"
    path.write_text(run.config)
    for given in (path, str(path)):
        again = gtfdi.simulate(scenario=given)
        assert again.config == run.config
        assert np.array_equal(again.truth.y, run.truth.y)
    other = gtfdi.simulate(2.0, scenario=path, seed=6, faults=[], noise="low")
    assert (len(other), other.fault_names) == (25, [])
    assert not np.array_equal(other.truth.y, run.truth.y[:25])
    assert not np.array_equal(other.measured.y, other.truth.y)
    other = gtfdi.simulate(scenario=path, variant="prototype", faults=[])
    assert other.truth.y.shape == (50, 28)


def test_a_map_is_a_table_of_lines():
    lines = [(0.94, 0.979), (1.0, 1.0), (1.06, 1.021)]
    table = {
        "kind": "compressor",
        "extrapolation": "refuse",
        "line": [
            {
                "speed": speed,
                "pressure_ratio": [9.0 * speed**2, 9.97 * speed**2, 11.0 * speed**2],
                "flow": [17.0 * flow, 16.3 * flow, 15.4 * flow],
                "efficiency": [0.83, 0.84, 0.83],
            }
            for speed, flow in lines
        ],
    }
    scenario = {"maps": {"compressor": table}, "duration_s": 2.0}
    run = gtfdi.simulate(scenario=scenario)
    assert run.ended is None
    # Its flow at design is that of the built-in map but for the digits given here.
    m3 = run.truth.y[0, run.truth.outputs.index("m3")]
    assert m3 == pytest.approx(gtfdi.steady_state()["m3"], rel=0.01)
    with pytest.raises(gtfdi.PlantError, match="^map of the turbine: expected one of that kind"):
        gtfdi.simulate(scenario={"maps": {"turbine": table}})
    table["line"][0]["speed"] = 1.02
    table["line"][1]["speed"] = 1.04
    with pytest.raises(gtfdi.PlantError, match="^compressor map at 0 s, slowest line: expected"):
        gtfdi.simulate(scenario=scenario)
    table["line"][1]["flow"][2] = 18.0
    with pytest.raises(gtfdi.PlantError, match=r"map line 2 \(speed 1.04\), flow\[2\]: expected"):
        gtfdi.simulate(scenario=scenario)


def test_a_run_that_leaves_the_range_ends_with_what_it_has():
    broken = {"case": "turbine_damage", "onset_s": 2.0, "rate_percent_per_h": 36e3}
    run = gtfdi.simulate(60.0, faults=[broken | {"limit_percent": 99.0}])
    assert 25 < len(run) < 750
    assert run.measured.y.shape == (len(run), 28)
    assert run.hidden.shape == (len(run), 3)
    assert "expected between" in run.ended
    assert np.isfinite(run.truth.y).all()


def test_the_linear_turbine_has_the_gains_of_the_nonlinear_one():
    turbine, rest = gtfdi.linearise(), gtfdi.steady_state()
    assert np.abs(turbine.poles()).max() < 1.0
    still = np.linalg.solve(np.eye(len(turbine.A)) - turbine.A, turbine.B)
    gains = (turbine.C @ still + turbine.D)[:, turbine.inputs.index("T_a")]
    # A run begins at the equilibrium of its boundary conditions.
    warmer = {"boundary": {"temperature_k": {"offset": 0.1}}}
    run = gtfdi.simulate(1.0, scenario=warmer, profile="steady", noise="none")
    assert run.truth.outputs == turbine.outputs
    for output in ("q_c", "t3", "p7", "m9"):
        column = turbine.outputs.index(output)
        moved = run.truth.y[0, column] - rest[output]
        # What the second derivatives add over 0.1 K of 288 K.
        assert 0.1 * gains[column] == pytest.approx(moved, rel=2e-3)


def test_a_word_for_the_loop_is_checked():
    with pytest.raises(gtfdi.OptionError, match='^option loop: expected closed or open, found "x"'):
        gtfdi.linearise(loop="x")


def test_published_table3_is_the_steady_state():
    rest, units = gtfdi.steady_state(), gtfdi.units()
    assert len(rest) == 30
    assert list(rest)[-2:] == ["e_c", "e_t"]
    # Table 3 of the paper; what it prints is met but for its own contradictions.
    published = {"p3": 1014989.5034, "p7": 206408.6312, "t3": 577.543, "w_t": 1660.2491}
    for name, value in published.items():
        assert rest[name] == pytest.approx(value, rel=2e-6)
    assert rest["e_c"] == pytest.approx(0.87673, rel=2e-3)
    assert rest["e_t"] == pytest.approx(0.79353, rel=0.017)
    assert (units["p3"], units["t3"], units["e_c"]) == ("Pa", "K", "")
    rest, units = gtfdi.steady_state("cogeneration", "axial"), gtfdi.units("cogeneration")
    assert len(rest) == 33
    assert len(units) == 7 + 31 + 3
    assert set(rest) < set(units)
    with pytest.raises(gtfdi.PlantError, match="^variant: expected one of prototype, cogen"):
        gtfdi.steady_state("jet")
    with pytest.raises(gtfdi.PlantError, match="^map set: expected one of paper, axial"):
        gtfdi.steady_state(map_set="flat")


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


def test_faults_of_sensors_and_actuators():
    healthy = gtfdi.simulate(8.0, noise="none")
    bias = {"sensor": "t3", "mode": "bias", "onset_s": 2.0, "end_s": 4.0, "step": {"size": 2.0}}
    lost = {"sensor": "a_v", "mode": "dropout", "onset_s": 6.0}
    run = gtfdi.simulate(8.0, noise="none", faults=[bias, bias, lost])
    assert run.fault_names == ["t3_bias", "t3_bias_2", "a_v_dropout"]
    assert run.fault_units == ["K", "K", ""]
    assert np.array_equal(run.truth.y, healthy.truth.y)
    expected = healthy.truth.y.copy()
    expected[25:50, healthy.truth.outputs.index("t3")] += 4.0
    assert np.array_equal(run.measured.y, expected)
    gone = np.isnan(run.measured.u[:, 0])
    assert np.array_equal(gone, np.arange(100) >= 75)
    stuck = {"actuator": "M_f", "mode": "stuck", "onset_s": 4.0}
    run = gtfdi.simulate(8.0, noise="none", faults=[stuck])
    fuel = [run.truth.y[:, run.truth.outputs.index(name)] for name in ("m9", "m5")]
    # m9 = m5 + fuel; rounding of sums of about 8 kg/s.
    assert np.ptp((fuel[0] - fuel[1])[50:]) < 1e-14


def test_noise_by_channel():
    run = gtfdi.simulate(
        60.0,
        profile="steady",
        noise={"channels": {"t3": {"deviation": 2.0, "resolution": 0.5}}},
    )
    assert run.warnings == []
    t3 = run.truth.outputs.index("t3")
    assert np.array_equal(np.delete(run.measured.y, t3, 1), np.delete(run.truth.y, t3, 1))
    reading = run.measured.y[:, t3]
    assert np.array_equal(reading, np.round(reading / 0.5) * 0.5)
    # Standard error of a deviation 1 / sqrt(2 N) = 2.6 %; five of them.
    assert abs((reading - run.truth.y[:, t3]).std() / 2.0 - 1.0) < 0.13


def test_refusals_are_the_plants_own():
    with pytest.raises(gtfdi.PlantError, match="^profile: expected one of steady, .*`calm`$"):
        gtfdi.simulate(1.0, profile="calm")
    with pytest.raises(gtfdi.PlantError, match="^noise: expected one of none, low"):
        gtfdi.simulate(1.0, noise="loud")
    with pytest.raises(gtfdi.PlantError, match="^duration: expected between 0.08 and"):
        gtfdi.simulate(float("nan"))
    with pytest.raises(gtfdi.PlantError, match="^substeps: expected 24 to"):
        gtfdi.simulate(1.0, substeps=1)
    stuck = {"sensor": "t3", "mode": "stuck"}
    with pytest.raises(gtfdi.PlantError, match="at most one that holds sensor t3, found t3_stuck"):
        gtfdi.simulate(1.0, faults=[stuck, stuck])
    with pytest.raises(gtfdi.PlantError, match="^faults, entry 0: channel: expected one of a_v,"):
        gtfdi.simulate(1.0, faults=[stuck | {"sensor": "t33"}])
    with pytest.raises(gtfdi.PlantError, match="^noise: channel: expected one of .*`t33`"):
        gtfdi.simulate(1.0, noise={"channels": {"t33": {"deviation": 1.0}}})
    with pytest.raises(gtfdi.PlantError, match="^noise of t3, pole: expected a number between"):
        gtfdi.simulate(1.0, noise={"channels": {"t3": {"pole": 1.0}}})
    with pytest.raises(gtfdi.PlantError, match="^faults, entry 1: unknown variant `rust`"):
        gtfdi.simulate(1.0, faults=[FOULING, FOULING | {"case": "rust"}])
    with pytest.raises(gtfdi.PlantError, match="^faults, entry 0: unknown field `size`"):
        gtfdi.simulate(1.0, faults=[FOULING | {"size": 1.0}])
    with pytest.raises(gtfdi.PlantError, match="onset of a fault"):
        gtfdi.simulate(1.0, faults=[FOULING | {"onset_s": float("nan")}])
    with pytest.raises(gtfdi.PlantError, match="^variant: expected one of prototype, cogen"):
        gtfdi.simulate(1.0, variant="jet")
    with pytest.raises(gtfdi.PlantError, match="^profile: expected one of steady, standard, load_"):
        gtfdi.simulate(1.0, variant="cogeneration", profile="wide")
    with pytest.raises(gtfdi.PlantError, match="^actuator of a fault: expected in the variant"):
        gtfdi.simulate(1.0, faults=[{"actuator": "IGV", "mode": "stuck"}])


def test_refusals_of_a_scenario_name_its_key_or_file(tmp_path):
    for scenario, message in [
        ({"duration": 5.0}, "^scenario: unknown field `duration`, expected one of `variant`"),
        ({"seed": 1.5}, "^scenario: invalid type: floating point `1.5`"),
        ({"profile": "wild"}, "^scenario: profile: expected one of steady,"),
        ({"boundary": {"temperature_k": {"offset": 90}}}, "^boundary.temperature_k: expected"),
        ({"faults": [{"sensor": "t33", "mode": "bias"}]}, "^scenario: channel: expected one of"),
    ]:
        with pytest.raises(gtfdi.PlantError, match=message):
            gtfdi.simulate(scenario=scenario)
    with pytest.raises(gtfdi.OptionError, match="^option scenario: expected text, .* found object"):
        gtfdi.simulate(scenario={"seed": object()})
    with pytest.raises(TypeError):
        gtfdi.simulate(scenario=3)
    path = tmp_path / "s.toml"
    with pytest.raises(gtfdi.LogError, match=r"s\.toml: "):
        gtfdi.simulate(scenario=path)
    path.write_text("seed = 1\nduration = 5.0\n")
    with pytest.raises(gtfdi.PlantError, match=r"s\.toml: TOML parse error at line 2"):
        gtfdi.simulate(scenario=path)
