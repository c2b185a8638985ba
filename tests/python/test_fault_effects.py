"""What faults do: to the turbine's outputs, and to residuals."""

import numpy as np
import pytest

import gtfdi

SHORT = {"window_s": 8.0, "settle_s": 2.0}


@pytest.fixture(scope="module")
def effects():
    return gtfdi.fault_effects(**SHORT)


def test_regress_effects_of_the_first_prototype(effects):
    # Percent, in the closed loop and with inputs held, of fouling and of damage.
    table = {
        "p7": [-2.84, 3.18, 0.04, -3.55],
        "m9": [-1.84, -1.89, 0.06, -5.64],
        "t3": [-0.86, 0.39, 0.00, -1.76],
        "q_c": [-3.57, -0.65, -3.27, -1.64],
    }
    for tag, values in table.items():
        row = effects["outputs"].index(tag)
        raw, held = (effects[key]["static_percent"][row] for key in ("raw", "inputs_held"))
        # 1.5 % of the effect and 0.04 points, where effects cancel to little: the first one had
        # smaller flows and twice the loss.
        found = np.array([raw[0], raw[2], held[0], held[2]])
        assert (np.abs(found - values) < 0.04 + 0.015 * np.abs(values)).all(), tag
    # The drift moves its own reading by what it is, and nothing else.
    drift = effects["raw"]["static_percent"][:, 1]
    assert drift[effects["outputs"].index("t3")] == pytest.approx(5.0, rel=1e-12)
    assert np.count_nonzero(drift) == 1


def test_the_healthy_values_are_those_at_rest(effects):
    rest, units = gtfdi.steady_state(), gtfdi.units()
    found = dict(zip(effects["outputs"], effects["steady"], strict=True))
    assert found == {tag: rest[tag] for tag in found} and len(found) == 28
    assert effects["units"] == [units[tag] for tag in effects["outputs"]]
    assert effects["cases"] == [
        "compressor_fouling",
        "thermocouple_drift",
        "turbine_damage",
        "fuel_actuator_lag",
    ]


def test_delivered_fuel_hides_the_fourth_case(effects):
    # Rounding of a plant that feels the same fuel.
    assert np.abs(effects["delivered_fuel_rms_percent"]).max() < 1e-9
    lag = effects["inputs_held"]["rms_percent"][:, 3]
    assert lag[effects["outputs"].index("m9")] > 0.1


def test_a_signature_is_of_shares(effects):
    for reading in effects["raw"], effects["inputs_held"]:
        for name in ("static", "rms"):
            signature = reading[f"{name}_signature"]
            rows = [effects["outputs"].index(tag) for tag in signature["monitored"]]
            sizes = np.abs(reading[f"{name}_percent"][rows])
            share = sizes / sizes.max(axis=1, keepdims=True)
            np.testing.assert_allclose(signature["share"], share, rtol=1e-14)
            assert signature["strongest_case"] == [1 + int(i) for i in share.argmax(axis=1)]
            strongest = signature["strongest_case"] == [1, 2, 3, 4]
            assert signature["is_diagonal"] == strongest
    # Nothing is settled by a lag.
    assert effects["raw"]["static_signature"]["most_affected"][3] is None


def test_settings_count(effects):
    half = gtfdi.fault_effects(**SHORT, drift_percent=2.5)
    t3 = effects["outputs"].index("t3")
    assert half["raw"]["static_percent"][t3, 1] == pytest.approx(2.5, rel=1e-12)
    other = gtfdi.fault_effects("axial", **SHORT)
    assert not np.allclose(other["raw"]["static_percent"], effects["raw"]["static_percent"])
    same = gtfdi.fault_effects(**SHORT)
    np.testing.assert_array_equal(same["raw"]["rms_percent"], effects["raw"]["rms_percent"])
    seeded = gtfdi.fault_effects(**SHORT, seed=5)["raw"]["rms_percent"]
    assert not np.array_equal(seeded, effects["raw"]["rms_percent"])


def test_settings_that_make_no_sense_are_refused():
    with pytest.raises(gtfdi.PlantError, match="flow_loss_percent: expected between 0 and 99"):
        gtfdi.fault_effects(**SHORT, flow_loss_percent=150.0)
    with pytest.raises(gtfdi.PlantError, match="wild"):
        gtfdi.fault_effects(**SHORT, profile="wild")
    with pytest.raises(gtfdi.PlantError, match="flat"):
        gtfdi.lag_limit("flat")


def test_the_loop_swings_above_the_limit_of_its_lag():
    limit = gtfdi.lag_limit()
    # Published with the case: 3.05 s with the default maps.
    assert limit["lag_s"] == pytest.approx(3.05, abs=0.01)
    assert 0.1 < limit["frequency_rad_s"] < 10.0

    def swing(lag_s):
        lag = {"case": "fuel_actuator_lag", "onset_s": 1.0, "step": {"size": lag_s}}
        run = gtfdi.simulate(400.0, profile="gentle", noise="none", faults=[lag])
        return run.measured.select([], ["w_t"]).y[-1000:].std()

    assert swing(1.3 * limit["lag_s"]) > 3.0 * swing(0.7 * limit["lag_s"])


def test_a_signature_matrix_is_root_mean_squares_of_differences():
    generator = np.random.default_rng(8)
    healthy = generator.standard_normal((300, 3))
    moves = {name: np.zeros((300, 3)) for name in ("a", "b", "c")}
    for column, run in enumerate(moves.values()):
        run[:, column] = 4.0
        run += generator.standard_normal((300, 3))
    faulty = {name: healthy + move for name, move in moves.items()}
    found = gtfdi.signature(faulty, healthy, 0.1, window=(50, 300))
    raw = [np.sqrt((move[50:300] ** 2).mean(axis=0)) for move in moves.values()]
    np.testing.assert_allclose(found.raw, raw, rtol=1e-12)
    np.testing.assert_allclose(found.matrix, found.raw / found.raw.max(axis=0), rtol=1e-14)
    assert (found.faults, found.residuals) == (["a", "b", "c"], ["r1", "r2", "r3"])
    assert found.is_diagonal and "samples 50..300 at 0.1 s" in found.definition
    turned = dict(reversed(faulty.items()))
    assert not gtfdi.signature(turned, healthy, 0.1).is_diagonal


def test_features_are_taken_first():
    generator = np.random.default_rng(9)
    series = generator.standard_normal((200, 2)).cumsum(axis=0)
    mean = np.array([series[max(0, t - 4) : t + 1, 0].mean() for t in range(200)])
    found = gtfdi.feature(series[:, 0], 0.1, "moving_mean", 0.5)
    np.testing.assert_allclose(found, mean, atol=1e-12)
    high = gtfdi.feature(series[:, 0], 0.1, "high_pass", 0.5)
    np.testing.assert_allclose(high, series[:, 0] - mean, atol=1e-12)
    np.testing.assert_array_equal(gtfdi.feature(series[:, 0], 0.1, "plain"), series[:, 0])
    rest = np.zeros((200, 2))
    features = [("moving_mean", 0.5), "plain"]
    each = gtfdi.signature({"f": series}, rest, 0.1, features=features, residuals=["a", "b"])
    expected = np.sqrt([(mean**2).mean(), (series[:, 1] ** 2).mean()])
    np.testing.assert_allclose(each.raw[0], expected, rtol=1e-12)
    both = gtfdi.signature({"f": series}, rest, 0.1, features=("moving_mean", 0.5))
    assert both.raw[0, 0] == each.raw[0, 0] and both.raw[0, 1] != each.raw[0, 1]


def test_signatures_that_make_no_sense_are_refused():
    rest, other = np.zeros((20, 2)), {"f": np.ones((20, 2))}
    with pytest.raises(gtfdi.DimensionError, match="^residuals of `f`: expected 2, found 1$"):
        gtfdi.signature({"f": np.ones((20, 1))}, rest, 0.1)
    with pytest.raises(gtfdi.DimensionError, match="^samples of .* expected 20, found 19$"):
        gtfdi.signature({"f": np.ones((19, 2))}, rest, 0.1)
    with pytest.raises(gtfdi.DimensionError, match="^features: expected 2, found 1$"):
        gtfdi.signature(other, rest, 0.1, features=["plain"])
    with pytest.raises(gtfdi.DesignError, match="5..30"):
        gtfdi.signature(other, rest, 0.1, window=(5, 30))
    with pytest.raises(gtfdi.DesignError, match="window_s.*-1"):
        gtfdi.signature(other, rest, 0.1, features=("moving_mean", -1.0))
    known = "^option features: expected plain, moving_mean or high_pass, found \"median\"$"
    with pytest.raises(gtfdi.OptionError, match=known):
        gtfdi.signature(other, rest, 0.1, features="median")
    message = '^option kind: expected "moving_mean" with a window in seconds, found one without$'
    with pytest.raises(gtfdi.OptionError, match=message):
        gtfdi.feature([1.0], 0.1, "moving_mean")
    message = '^option kind: expected "plain" without a window in seconds, found one with$'
    with pytest.raises(gtfdi.OptionError, match=message):
        gtfdi.feature([1.0], 0.1, "plain", 1.0)
