"""Plots draw what the objects hold, into the axes that they are given."""

import doctest
import inspect
import json
import math
import subprocess
import sys

import numpy as np
import pytest

import gtfdi

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402

import gtfdi.plot  # noqa: E402

DRIFT = [{"case": "thermocouple_drift", "onset_s": 60.0, "rate_percent_per_h": 20.0}]
ONSET_S = 60.0
TAGS = {"inputs": ["a_v", "M_f"], "outputs": ["q_c", "t3"]}


@pytest.fixture(autouse=True)
def _closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def faulty():
    return gtfdi.simulate(120.0, seed=3, faults=DRIFT).measured


@pytest.fixture(scope="module")
def fit(healthy):
    return gtfdi.Arx(order=2, nk=0).fit_in_full(healthy.measured.select(**TAGS))


@pytest.fixture(scope="module")
def bank(healthy):
    model = gtfdi.arx(healthy.measured, order=8, structure="diag", nk=[1, 0], **TAGS)
    return gtfdi.design(model, [gtfdi.simulate(300.0, seed=2).measured], margin=1.2, consecutive=2)


def labels(ax):
    """The lines by their label."""
    return {line.get_label(): line for line in ax.lines}


def test_a_record_is_drawn_with_its_units_and_gaps(healthy):
    data = healthy.measured[:500]
    y = data.y.copy()
    y[100:120, data.outputs.index("p7")] = np.nan
    units = {"input_units": data.input_units, "output_units": data.output_units}
    holed = gtfdi.Dataset(data.u, y, data.sample_time_s, data.inputs, data.outputs, **units)
    axes = gtfdi.plot.record(holed, ["M_f", "p7"], onset_s=10.0)
    assert [ax.get_ylabel() for ax in axes] == ["M_f (kg/s)", "p7 (Pa)"]
    assert [ax.get_xlabel() for ax in axes] == ["", "time (s)"]
    fuel, pressure = (ax.lines[0] for ax in axes)
    assert np.array_equal(fuel.get_xdata(), holed.time_s)
    assert np.array_equal(fuel.get_ydata(), holed.u[:, holed.inputs.index("M_f")])
    assert np.isnan(pressure.get_ydata()).sum() == 20
    assert labels(axes[0])["onset"].get_xdata() == [10.0, 10.0]
    assert len(gtfdi.plot.record(data.select("a_v", ["q_c", "t3"]))) == 3


def test_residuals_have_limits_alarms_and_the_onset(bank, faulty):
    detection = bank.detect(faulty)
    axes = gtfdi.plot.residuals(detection, bank, onset_s=ONSET_S)
    for column, (ax, test) in enumerate(zip(axes, bank.detectors, strict=True)):
        lines = labels(ax)
        values = lines[test["output"]].get_ydata()
        assert np.array_equal(values, detection.residuals[:, column], equal_nan=True)
        assert list(lines["limit"].get_ydata()) == [test["limit"]] * 2
        assert list(lines["_limit below"].get_ydata()) == [-test["limit"]] * 2
        assert list(lines["onset"].get_xdata()) == [ONSET_S] * 2
        unit = {"q_c": "N m", "t3": "K", "p7": "Pa", "m9": "kg/s"}[test["output"]]
        assert ax.get_ylabel() == f"residual {test['output']} ({unit})"
    own = [alarm["time_s"] for alarm in detection.alarms if alarm["tag"] == "t3"]
    assert own
    marked = [line.get_xdata()[0] for label, line in labels(axes[1]).items() if "alarm" in label]
    assert marked[0] == own[0]
    assert len(axes[1].patches) == len(own)
    assert not axes[0].patches
    # Without the bank nobody knows the limits and the units.
    ax, *_ = gtfdi.plot.residuals(detection)
    assert "limit" not in labels(ax) and ax.get_ylabel() == f"residual {detection.outputs[0]}"


def test_statistics_have_their_limits(bank, faulty):
    detection = bank.detect(faulty)
    axes = gtfdi.plot.statistics(detection, bank)
    for column, (ax, test) in enumerate(zip(axes, bank.detectors, strict=True)):
        lines = labels(ax)
        values = lines[test["output"]].get_ydata()
        assert np.array_equal(values, detection.statistics[:, column], equal_nan=True)
        assert list(lines["limit"].get_ydata()) == [test["limit"]] * 2
        assert ax.get_ylabel() == f"modulus of {test['output']}"


def test_limits_of_whitened_residuals_are_not_drawn_on_residuals(healthy):
    model = gtfdi.arx(healthy.measured, order=2, structure="diag", nk=0, **TAGS)
    records = [gtfdi.simulate(600.0, seed=2).measured]
    bank = gtfdi.design(model, records, generator="kalman", statistic="cusum", arl0_h=0.05)
    detection = bank.detect(healthy.measured)
    (first, _) = gtfdi.plot.residuals(detection, bank)
    assert "limit" not in labels(first)
    (first, _) = gtfdi.plot.statistics(detection, bank)
    assert first.get_ylabel() == "cusum of q_c"
    assert list(labels(first)["limit"].get_ydata()) == [bank.detectors[0]["limit"]] * 2


def test_a_pole_map_has_poles_zeros_and_their_ellipses(fit):
    report = fit.pole_zero()
    ax = gtfdi.plot.pole_map(fit, confidence=0.9)
    lines = labels(ax)
    # Points on a circle, to rounding.
    circle = lines["unit circle"]
    assert np.allclose(np.hypot(*circle.get_data()), 1.0, rtol=0.0, atol=1e-12)
    poles = [pole["value"] for pole in report["poles"]]
    assert np.array_equal(lines["poles"].get_xdata(), np.real(poles))
    assert np.array_equal(lines["poles"].get_ydata(), np.imag(poles))
    zeros = [zero for channel in report["channels"] for zero in channel["zeros"]]
    (drawn,) = (line for label, line in lines.items() if label.startswith("zeros"))
    assert np.array_equal(drawn.get_xdata(), np.real([zero["value"] for zero in zeros]))
    view = ax.get_xlim()[1]
    assert view >= max(1.0, np.abs(poles).max())
    away = sum(max(abs(zero["value"].real), abs(zero["value"].imag)) > view for zero in zeros)
    assert drawn.get_label() == (f"zeros ({away} out of view)" if away else "zeros")
    known = [own for own in [*zeros, *report["poles"]] if own["covariance"] is not None]
    assert len(ax.patches) == len(known)
    # The half axes squared over -2 ln(1 - confidence) are the eigenvalues of the covariance.
    for ellipse, own in zip(ax.patches, known, strict=True):
        squares = np.sort([ellipse.width, ellipse.height]) ** 2 / 4.0 / (-2.0 * math.log(0.1))
        expected = np.sort(np.linalg.eigvalsh(own["covariance"]))
        # An eigenvalue that is zero but for rounding is cut off there.
        np.testing.assert_allclose(squares, expected, rtol=1e-9, atol=1e-12 * expected[1])
        assert ellipse.center == (own["value"].real, own["value"].imag)


def test_every_kind_of_model_has_a_pole_map(fit, model):
    part = model.output_model("q_c")
    observer = gtfdi.observer(part, [0.6 + 0.3j, 0.6 - 0.3j, *[0.5] * 6])
    for thing, poles in [
        (part.model, part.model.poles()),
        (model, model.state_space().poles()),
        (observer, observer.poles),
    ]:
        ax = gtfdi.plot.pole_map(thing)
        assert np.array_equal(labels(ax)["poles"].get_xdata(), np.real(poles))
        assert not ax.patches
    del fit


def test_bode_has_bands_and_leaves_out_rest(fit):
    frequency_hz = np.array([0.0, 0.01, 0.1, 1.0])
    response = fit.frequency_response(frequency_hz)
    magnitude, phase = gtfdi.plot.bode(response, "t3", "M_f", confidence=0.9)
    (line,) = magnitude.lines
    assert line.get_label() == "t3 from M_f"
    assert np.array_equal(line.get_xdata(), frequency_hz[1:])
    assert np.array_equal(line.get_ydata(), np.abs(response.response[1:, 1, 1]))
    (band,) = magnitude.collections
    low, high = response.magnitude_band(0.9)[1:, 1, 1].T
    corners = band.get_paths()[0].vertices
    assert corners[:, 1].min() == low.min()
    assert corners[:, 1].max() == high.max()
    degrees = phase.lines[0].get_ydata()
    expected = np.degrees(np.angle(response.response[1:, 1, 1]))
    # Whole turns are taken out of it.
    turns = (degrees - expected) / 360.0
    assert np.allclose(turns, np.round(turns), rtol=0.0, atol=1e-9)
    assert phase.get_xlabel() == "frequency (Hz)"
    assert len(gtfdi.plot.bode(response)[0].lines) == 4


def test_orders_are_drawn_above_the_best(healthy):
    data = healthy.measured.select(["a_v", "M_f"], ["q_c"])
    table = gtfdi.order_table(data, orders=(1, 6))
    lines = labels(gtfdi.plot.orders(table))
    for label, key in [("AIC", "aic"), ("MDL", "mdl")]:
        values = np.array([row[key] for row in table])
        assert list(lines[label].get_xdata()) == [1, 2, 3, 4, 5, 6]
        assert np.array_equal(lines[label].get_ydata(), values - values.min())
        assert list(lines[f"_best {label}"].get_xdata()) == [table.best[key]]


def test_orders_of_the_frisch_scheme_have_one_criterion(healthy):
    data = healthy.measured.select(["a_v", "M_f"], ["q_c"])
    table = gtfdi.frisch_order_table(data, orders=(1, 4))
    lines = labels(gtfdi.plot.orders(table))
    known = {row["order"]: row["selection"] for row in table if row["selection"] is not None}
    line = lines["moment selection"]
    assert list(line.get_xdata()) == list(known)
    assert np.array_equal(line.get_ydata(), np.array(list(known.values())) - known[table.best])
    assert list(lines["_best moment selection"].get_xdata()) == [table.best]


def test_an_order_has_the_best_of_its_indices(healthy):
    data = healthy.measured.select(["a_v", "M_f"], ["q_c", "t3"])
    table = gtfdi.index_table(data, orders=(2, 4), spread=1)
    lines = labels(gtfdi.plot.orders(table))
    for label, key in [("AIC", "aic"), ("MDL", "mdl")]:
        orders = sorted({row["order"] for row in table})
        assert list(lines[label].get_xdata()) == orders
        least = np.array([min(row[key] for row in table if row["order"] == own) for own in orders])
        assert np.array_equal(lines[label].get_ydata(), least - table.best[key][key])
        assert list(lines[f"_best {label}"].get_xdata()) == [table.best[key]["order"]]


def test_a_roc_counts_runs_at_every_limit():
    ax = gtfdi.plot.roc([1.0, 2.0, 3.0, 4.0], [2.5, 3.5, 5.0])
    (line,) = ax.lines
    points = set(zip(*line.get_data(), strict=True))
    # At the limit 2.5: 3 and 4 of four healthy runs, all three faulty ones.
    assert (0.5, 1.0) in points
    assert (0.0, 0.0) in points
    assert (1.0, 1.0) in points
    assert (0.25, 2.0 / 3.0) in points


def test_published_wilson_intervals():
    # Newcombe (Statistics in Medicine 17, 1998), table I, method 3: 81 of 263 and 0 of 20.
    from gtfdi.plot.share import wilson

    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)


def test_shares_of_sizes_are_those_of_their_bins():
    sizes = [1.0, 1.5, 2.5, 3.9, 4.0]
    ax = gtfdi.plot.share_of_sizes(sizes, [False, True, True, True, False], bins=2, unit="%")
    (line,) = ax.lines[:1]
    assert line.get_xdata() == pytest.approx([math.sqrt(2.0), math.sqrt(8.0)])
    assert list(line.get_ydata()) == [0.5, 2.0 / 3.0]
    assert ax.get_xlabel() == "size (%)"


def proportion(share):
    return {"count": 1, "of": 2, "share": share, "low": share - 0.1, "high": share + 0.1}


@pytest.fixture
def summary():
    """A campaign's summary with the keys that are drawn."""
    sizes = [
        {"from": size, "to": 2 * size, "middle": 1.4 * size, "detected": proportion(share)}
        for size, share in [(0.1, 0.2), (0.2, 0.6)]
    ]
    fault = {"fault": "thermocouple_drift", "waveform": "ramp", "unit": "%", "sizes": sizes}
    roc = [
        {"false_alarms_per_hour": rate, "detected_by_fault": [proportion(share)]}
        for rate, share in [(None, 0.9), (2.0, 0.8), (0.5, 0.4), (0.0, 0.3)]
    ]
    return {"schema_version": 1, "faults": [fault], "roc": roc}


def test_a_campaign_is_drawn_from_its_summary(summary, tmp_path):
    path = tmp_path / "summary.json"
    path.write_text(json.dumps(summary))
    for source in (summary, path, str(path)):
        ax = gtfdi.plot.campaign_roc(source)
        line = labels(ax)["thermocouple_drift, ramp"]
        assert list(line.get_xdata()) == [2.0, 0.5]
        assert list(line.get_ydata()) == [0.8, 0.4]
        ax = gtfdi.plot.campaign_sizes(source)
        assert ax.lines[0].get_xdata() == pytest.approx([0.14, 0.28])
        assert list(ax.lines[0].get_ydata()) == [0.2, 0.6]
        assert (ax.get_xlabel(), ax.get_xscale()) == ("size (%)", "log")


def test_what_is_no_summary_is_refused(summary, tmp_path):
    with pytest.raises(gtfdi.DataError, match=r"^summary: expected schema_version 1, found 9$"):
        gtfdi.plot.campaign_roc({**summary, "schema_version": 9})
    with pytest.raises(gtfdi.DataError, match=r"^summary: expected the key 'roc' of a campaign's"):
        gtfdi.plot.campaign_sizes({"schema_version": 1, "faults": []})
    with pytest.raises(gtfdi.DataError, match=r"gone\.json: expected a campaign's summary, found"):
        gtfdi.plot.campaign_roc(tmp_path / "gone.json")
    with pytest.raises(TypeError, match="^summary: expected Mapping or str or PathLike, found int"):
        gtfdi.plot.campaign_roc(3)


def test_a_diagnosis_is_drawn_with_sizes(tank):
    found = tank.isolator.detect(tank.record(3, 5000, leak=0.06))
    alarm = found.alarms[0]
    ax = gtfdi.plot.fault_scores(alarm)
    widths = [bar.get_width() for bar in ax.patches]
    expected = [own["probability"] for own in alarm["hypotheses"]] + [alarm["none_of_these"]]
    assert widths[: len(expected) - 1] == expected[:-1]
    assert widths[-1] == expected[-1]
    names = [label.get_text() for label in ax.get_yticklabels()]
    assert names[:3] == ["sensor a", "leak", "valve"]
    own = alarm["hypotheses"][1]
    low, high = own["magnitude_interval"]
    notes = [text.get_text() for text in ax.texts]
    assert f"{own['magnitude']:.3g} ({low:.3g} to {high:.3g})" in notes
    ax = gtfdi.plot.peaks(found, onset_s=tank.ONSET_S)
    assert np.array_equal(ax.lines[0].get_ydata(), found.peaks)
    assert list(ax.lines[1].get_ydata()) == [1.0, 1.0]
    assert alarm["time_s"] in [line.get_xdata()[0] for line in ax.lines[2:]]


def test_given_axes_are_drawn_into_and_nothing_else_changes(healthy, fit):
    before, figures = dict(matplotlib.rcParams), plt.get_fignums()
    figure = matplotlib.figure.Figure()
    one, two = figure.subplots(2, 1)
    drawn = gtfdi.plot.record(healthy.measured, ["a_v", "t3"], axes=[one, two])
    assert drawn == [one, two]
    assert gtfdi.plot.record(healthy.measured, "t3", axes=one) == [one]
    assert gtfdi.plot.pole_map(fit, ax=two) is two
    assert gtfdi.plot.roc([1.0], [2.0], ax=one) is one
    assert plt.get_fignums() == figures
    assert dict(matplotlib.rcParams) == before


def test_what_cannot_be_drawn_is_refused(healthy, fit, bank, faulty):
    run, plot = healthy, gtfdi.plot
    one = matplotlib.figure.Figure().subplots()
    detection = bank.detect(faulty)
    refused = [
        (TypeError, "^data: expected Dataset, found Run$", lambda: plot.record(run)),
        (gtfdi.OptionError, "^channels: expected one of a_v, .*, found 'T9'$",
         lambda: plot.record(run.measured, "T9")),
        (gtfdi.OptionError, "^channels: expected at least one", lambda: plot.record(run.measured, [])),
        (gtfdi.DimensionError, "^axes: expected 2, one a panel, found 1$",
         lambda: plot.record(run.measured, ["a_v", "t3"], axes=one)),
        (TypeError, "^axes: expected matplotlib Axes, found int$",
         lambda: plot.record(run.measured, "t3", axes=[1])),
        (TypeError, "^ax: expected matplotlib Axes, found list$", lambda: plot.pole_map(fit, ax=[one])),
        (TypeError, "^model: expected StateSpace or .*, found dict$", lambda: plot.pole_map({})),
        (gtfdi.OptionError, "^confidence: expected a number between 0 and 1, found 1.0$",
         lambda: plot.pole_map(fit, confidence=1.0)),
        (TypeError, "^confidence: expected a number, found str$",
         lambda: plot.pole_map(fit, confidence="high")),
        (TypeError, "^detection: expected Detection, found Dataset$", lambda: plot.residuals(faulty)),
        (TypeError, "^bank: expected Bank, found str$", lambda: plot.statistics(detection, "bank.json")),
        (TypeError, "^response: expected FrequencyResponse, found ArxFit$", lambda: plot.bode(fit)),
        (gtfdi.OptionError, "^output: expected one of q_c, t3, found 'p7'$",
         lambda: plot.bode(fit.frequency_response([0.1]), "p7")),
        (TypeError, "^table: expected OrderTable or .* or IndexTable, found list$",
         lambda: plot.orders([])),
        (TypeError, "^isolation: expected Isolation, found Detection$", lambda: plot.peaks(detection)),
        (TypeError, "^diagnosis: expected Mapping, found list$", lambda: plot.fault_scores([])),
        (gtfdi.DataError, "^diagnosis: expected the key 'hypotheses', found time_s, ",
         lambda: plot.fault_scores(detection.alarms[0])),
        (gtfdi.DataError, r"^faulty_peaks: expected a number a run, found shape \(0,\)$",
         lambda: plot.roc([1.0], [])),
        (gtfdi.DataError, "^healthy_peaks: expected numbers, found NaN in run 1$",
         lambda: plot.roc([1.0, np.nan], [1.0])),
        (gtfdi.DimensionError, "^found: expected 2 runs, found 1$",
         lambda: plot.share_of_sizes([1.0, 2.0], [True])),
        (gtfdi.DataError, "^sizes: expected positive numbers, found 0.0$",
         lambda: plot.share_of_sizes([0.0, 2.0], [True, True])),
    ]
    for kind, text, call in refused:
        with pytest.raises(kind, match=text):
            call()


def test_another_banks_limits_are_refused(bank, faulty, model):
    other = gtfdi.design(model, [gtfdi.simulate(60.0, seed=2).measured], margin=1.2)
    with pytest.raises(gtfdi.OptionError, match="^bank: expected one with the tests q_c, t3, found q_c$"):
        gtfdi.plot.residuals(bank.detect(faulty), other)


def test_without_matplotlib_the_error_says_what_to_install():
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "import gtfdi\n"
        "try:\n    import gtfdi.plot\n"
        "except ImportError as error:\n    print(error)\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout == "gtfdi.plot needs matplotlib: pip install gtfdi[plot]\n"


def test_the_package_does_not_need_matplotlib():
    code = "import sys, gtfdi; print('matplotlib' in sys.modules)"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout == "False\n"


@pytest.mark.parametrize("name", gtfdi.plot.__all__)
def test_example_runs(name, healthy, model, tank):
    function = getattr(gtfdi.plot, name)
    text = inspect.getdoc(function)
    assert {"Parameters", "Returns", "Raises"} <= set(text.splitlines()), name
    record = healthy.measured.select(["a_v", "M_f"], ["q_c"])
    names = {
        "gtfdi": gtfdi,
        "run": healthy,
        "u": record.u,
        "y": record.y,
        "model": model,
        "bank": gtfdi.design(model, [record], margin=1.5),
        "isolator": tank.isolator,
        "record": tank.record(98, 2000),
        "alarm": tank.isolator.detect(tank.record(3, 5000, leak=0.06)).alarms[0],
    }
    test = doctest.DocTestParser().get_doctest(text, names, name, None, 0)
    report = []
    result = doctest.DocTestRunner().run(test, out=report.append)
    assert result.failed == 0, "".join(report)
