"""The examples in the documentation run, and what is exported is documented and typed."""

import ast
import doctest
import inspect
import re

import numpy as np
import pytest

import gtfdi

MODULES = {name: thing for name, thing in vars(gtfdi).items() if inspect.ismodule(thing)}
PUBLIC = [
    name for name in gtfdi.__all__ if name != "__version__" and name not in MODULES
]
# Everything that is not an exception, with the name that a user writes.
OBJECTS = {name: getattr(gtfdi, name) for name in PUBLIC} | {
    f"{module}.{name}": getattr(MODULES[module], name)
    for module in gtfdi.__all__
    if module in MODULES
    for name in MODULES[module].__all__
}

# Objects without an example of their own or of a method, with the place where one stands.
ELSEWHERE = {
    "ConstrainedFit": "ConstrainedArx",
    "EivModel": "eiv",
    "EivOrderTable": "eiv_order_table",
    "FilterRun": "KalmanFilter.run",
    "FreeRun": "ArxModel.simulate",
    "FrequencyResponse": "ArxFit.frequency_response",
    "FrischOrderTable": "frisch_order_table",
    "IndexTable": "index_table",
    "Isolation": "Isolator.detect",
    "ObserverDesign": "optimise_observer",
    "OrderTable": "order_table",
    "OutputModel": "observer",
    "Refined": "OutputErrorRefinement",
    "ResidualReport": "ArxModel.test_residuals",
    "Riccati": "riccati",
    "ScheduledModel": "ScheduledArx",
    "SignatureMatrix": "signature",
    "Verdict": "Detector.step",
    "campaign.compare": "campaign.run",
    "campaign.rows": "campaign.run",
}


def documented():
    """Every public object and method with an example."""
    for name, thing in OBJECTS.items():
        members = vars(thing).items() if inspect.isclass(thing) else []
        for label, each in [(name, thing), *((f"{name}.{key}", value) for key, value in members)]:
            if ">>>" in (getattr(each, "__doc__", None) or ""):
                yield label, each.__doc__


def test_every_object_has_an_example():
    examples = {label for label, _ in documented()}
    exceptions = {name for name in OBJECTS if name.endswith("Error")}
    without = {
        name
        for name in OBJECTS.keys() - exceptions
        if not any(label == name or label.startswith(f"{name}.") for label in examples)
    }
    assert without == ELSEWHERE.keys()
    assert set(ELSEWHERE.values()) <= examples


@pytest.mark.parametrize(("label", "text"), list(documented()), ids=lambda value: value.split()[0])
def test_example_runs(label, text, healthy, model, tank, tmp_path, monkeypatch):
    for package in re.findall(r"gtfdi\[(\w+)\]", text):
        pytest.importorskip({"arrow": "pyarrow"}.get(package, package))
    for package in re.findall(r"^ *>>> (?:import|from) (\w+)", text, re.M):
        pytest.importorskip(package)
    monkeypatch.chdir(tmp_path)
    record = healthy.measured.select(["a_v", "M_f"], ["q_c"])
    names = {
        "np": np,
        "gtfdi": gtfdi,
        "u": record.u,
        "y": record.y,
        "run": healthy,
        "model": model,
        "bank": gtfdi.design(model, [record], margin=1.5),
        "isolator": tank.isolator,
        "record": tank.record(98, 2000),
    }
    test = doctest.DocTestParser().get_doctest(inspect.cleandoc(text), names, label, None, 0)
    assert test.examples
    report = []
    result = doctest.DocTestRunner().run(test, out=report.append)
    assert result.failed == 0, "".join(report)


def test_everything_public_has_documentation():
    for name, thing in OBJECTS.items():
        assert thing.__doc__, name
        if not inspect.isclass(thing) or issubclass(thing, Exception):
            continue
        for key, member in vars(thing).items():
            if not key.startswith("_"):
                assert member.__doc__, f"{name}.{key}"


def test_exceptions_have_one_root():
    for name in PUBLIC:
        if name.endswith("Error"):
            assert issubclass(getattr(gtfdi, name), gtfdi.GtfdiError)


def test_version_is_that_of_the_workspace(root):
    assert f'version = "{gtfdi.__version__}"' in (root / "Cargo.toml").read_text()


def test_the_readme_runs_as_printed(root, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", (root / "README.md").read_text(), re.M | re.S)
    printed = []
    for block in blocks:
        exec(compile(block, "README.md", "exec"), {})  # noqa: S102
        printed.append(capsys.readouterr().out.splitlines())
    road, noisy, plant = printed
    # The thermocouple drifts, so its output alone alarms, after the onset at 60 s.
    alarms = [ast.literal_eval(line) for line in road]
    assert {alarm["tag"] for alarm in alarms} == {"t3"}
    assert min(alarm["time_s"] for alarm in alarms) > 60.0
    # The true coefficient is 0.8, the variances are 1 and 0.25; five standard errors of each.
    (*_, biased), (_, found, error) = (line.split() for line in noisy[:2])
    assert abs(float(biased) - 0.8) > 10.0 * float(error)
    assert abs(float(found) - 0.8) < 5.0 * float(error)
    truth = {"y1": 1.0, "u1": 0.25}
    for tag, variance, error in (line.split() for line in noisy[2:]):
        assert abs(float(variance) - truth.pop(tag)) < 5.0 * float(error)
    assert not truth
    assert plant == ["(750, 31) ['e_c', 'e_t', 'M_fc'] None", "p7 206409 Pa"]
