"""The examples in the documentation run, and what is exported is documented and typed."""

import ast
import doctest
import inspect
import re

import numpy as np
import pytest

import gtfdi

PUBLIC = [name for name in gtfdi.__all__ if name != "__version__"]


def documented():
    """Every public object and method with an example."""
    for name in PUBLIC:
        thing = getattr(gtfdi, name)
        members = vars(thing).items() if inspect.isclass(thing) else []
        for label, each in [(name, thing), *((f"{name}.{key}", value) for key, value in members)]:
            if ">>>" in (getattr(each, "__doc__", None) or ""):
                yield label, each.__doc__


@pytest.mark.parametrize(("label", "text"), list(documented()), ids=lambda value: value.split()[0])
def test_example_runs(label, text, healthy, model, tank, tmp_path, monkeypatch):
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
    for name in PUBLIC:
        thing = getattr(gtfdi, name)
        assert thing.__doc__, name
        if not inspect.isclass(thing) or issubclass(thing, Exception):
            continue
        for key, member in vars(thing).items():
            if not key.startswith("_"):
                assert member.__doc__, f"{name}.{key}"


def test_stubs_name_what_is_there(root):
    stubs = ast.parse((root / "python" / "gtfdi" / "_gtfdi.pyi").read_text())
    classes = {node.name: node for node in stubs.body if isinstance(node, ast.ClassDef)}
    functions = {node.name for node in stubs.body if isinstance(node, ast.FunctionDef)}
    for name in PUBLIC:
        thing = getattr(gtfdi, name)
        if not inspect.isclass(thing):
            assert name in functions
        elif not issubclass(thing, Exception):
            body = classes[name].body
            stubbed = {node.name for node in body if isinstance(node, ast.FunctionDef)}
            there = {key for key in vars(thing) if not key.startswith("_")}
            assert {key for key in stubbed if not key.startswith("_")} == there, name


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
