"""Reports: self-contained pages about models and detections."""

import json
import re

import numpy as np
import pytest

import gtfdi


def page(folder):
    """The page of a report; every chart on it has its files, and nothing is asked of the network."""
    html = (folder / "index.html").read_text(encoding="utf-8")
    own = html.replace("http://www.w3.org/2000/svg", "")
    assert not re.search(r"https?://|src=|@import", own)
    ids = re.findall(r'<figure id="figure_([^"]+)"', html)
    files = {path.name for path in (folder / "figures").iterdir()}
    assert files == {f"{own}.{ending}" for own in ids for ending in ("svg", "csv")}
    return html


def charts(html):
    """The numbers behind the charts."""
    found = re.findall(r'<script type="application/json">(.*?)</script>', html, re.S)
    return [json.loads(text) for text in found]


def test_a_fit_has_bands_and_a_model_alone_has_none(tmp_path, random_record):
    _, u, y = random_record(3, nx=2, nu=1, samples=600)
    y = y + 0.1 * np.random.default_rng(4).standard_normal(y.shape)
    fit = gtfdi.Arx(order=2).fit_in_full(u, y)
    for subject, banded in [(fit, True), (fit.model, False)]:
        folder = tmp_path / str(banded) / "report"
        gtfdi.write_report(folder, subject, u, y)
        html = page(folder)
        gains = [own["curves"][0] for own in charts(html) if own["curves"][0]["label"] == "gain"]
        assert len(gains) == 1
        assert ("band" in gains[0]) == banded
        fits = fit.model.validate(u, y)[0]
        assert f"<td>{fits['fit_prediction_percent']:.2f}</td>" in html


def test_orders_are_compared(tmp_path, random_record):
    _, u, y = random_record(3, nx=2, nu=1, samples=600)
    y = y + 0.1 * np.random.default_rng(4).standard_normal(y.shape)
    model = gtfdi.arx(u, y, order=2)
    tables = {"MDL": gtfdi.order_table(u, y, (1, 4)), "BIC": gtfdi.eiv_order_table(u, y, (1, 2))}
    for criterion, orders in tables.items():
        gtfdi.write_report(tmp_path / criterion, model, u, y, orders=orders)
        html = page(tmp_path / criterion)
        (chart,) = [own for own in charts(html) if own["x_label"] == "order"]
        assert [curve["label"] for curve in chart["curves"]] == [criterion, "AIC"]
        best = orders.best[criterion.lower()]
        assert chart["marks"] == [[best, f"order {best}"]]
        # To the precision of single numbers, which is enough for a curve.
        wanted = [row[criterion.lower()] for row in orders]
        assert np.allclose(chart["curves"][0]["y"], wanted, rtol=1e-6)
        assert all(f"<td>{row['aic']:.1f}</td>" in html for row in orders)
    gtfdi.write_report(tmp_path / "none", model, u, y)
    assert "Orders compared" not in page(tmp_path / "none")
    bank = gtfdi.design(model, [gtfdi.Dataset(u, y, 1.0)], margin=1.2)
    with pytest.raises(gtfdi.OptionError, match="^option orders: expected a model .*, found a detect"):
        gtfdi.write_report(tmp_path / "bank", bank, u, y, orders=orders)


def test_noise_is_shown(tmp_path):
    generator = np.random.default_rng(5)
    u, y = np.zeros((2, 1500))
    for t in range(1, 1500):
        u[t] = 0.6 * u[t - 1] + generator.normal()
        y[t] = 0.8 * y[t - 1] + u[t - 1]
    noisy = (u + generator.normal(0.0, 0.5, 1500), y + generator.normal(0.0, 1.0, 1500))
    gtfdi.write_report(tmp_path, gtfdi.eiv(*noisy, order=1), *noisy)
    assert "Noise on the channels" in page(tmp_path)


def test_alarms_are_marked(tmp_path, healthy, model):
    record = healthy.measured.select(["a_v", "M_f"], ["q_c"])
    bank = gtfdi.design(model, [record], margin=1.2)
    y = record.y.copy()
    y[3000:] += 100.0
    faulty = gtfdi.Dataset(record.u, y, record.sample_time_s, inputs=["a_v", "M_f"], outputs=["q_c"])
    gtfdi.write_report(tmp_path, bank, faulty)
    html = page(tmp_path)
    alarms = bank.detect(faulty).alarms
    assert alarms
    residual = next(own for own in charts(html) if own["curves"][0]["label"] == "residual of q_c")
    assert [at for at, _ in residual["marks"]] == [own["time_s"] for own in alarms]


def test_an_isolation_says_what_it_found(tmp_path, tank):
    gtfdi.write_report(tmp_path, tank.isolator, tank.record(4, 5000, leak=0.06))
    assert "1. leak: from " in page(tmp_path)


def test_what_cannot_be_shown_is_refused(tmp_path, healthy, model):
    record = healthy.measured.select(["a_v", "M_f"], ["t3"])
    with pytest.raises(gtfdi.DataError, match="q_c"):
        gtfdi.write_report(tmp_path / "report", model, record)
    with pytest.raises(TypeError, match="subject"):
        gtfdi.write_report(tmp_path / "report", "model", record)
    assert not (tmp_path / "report").exists()
    (tmp_path / "file").write_text("")
    record = healthy.measured.select(["a_v", "M_f"], ["q_c"])
    with pytest.raises(gtfdi.LogError, match="file"):
        gtfdi.write_report(tmp_path / "file", model, record)
