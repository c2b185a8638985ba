"""Every public noun of the Rust crates is in Python, or a reason why not stands in a table."""

import inspect

import pytest

import gtfdi
from rust_nouns import CRATES, public_nouns

tomllib = pytest.importorskip("tomllib", reason="Python 3.10 does not read TOML")


@pytest.fixture(scope="module")
def table(root):
    return tomllib.loads((root / "tests" / "python" / "parity.toml").read_text())


@pytest.mark.parametrize("crate", CRATES)
def test_every_rust_noun_has_a_line(root, table, crate):
    lines = set(table[crate])
    nouns = set(public_nouns(root, crate))
    # `module::*` stands for all of a module; it names a reason.
    modules = {line.removesuffix("*") for line in lines if line.endswith("::*")}
    inside = {noun for noun in nouns if any(noun.startswith(module) for module in modules)}
    assert all(table[crate][f"{module}*"] in table["reasons"] for module in modules)
    assert all(any(noun.startswith(module) for noun in nouns) for module in modules)
    assert nouns - inside - lines == set(), "say in parity.toml where these are, or why not"
    single = {line for line in lines if not line.endswith("::*")}
    assert single - nouns == set(), "these are no longer public in Rust"


@pytest.mark.parametrize("crate", CRATES)
def test_what_a_line_names_is_there(table, crate):
    reasons = set(table["reasons"])
    for noun, place in table[crate].items():
        if place in reasons:
            continue
        thing = gtfdi
        for name in place.split("."):
            assert hasattr(thing, name), f"{crate}: {noun} should be gtfdi.{place}"
            thing = getattr(thing, name)


def test_no_reason_is_idle(table):
    used = {place for crate in CRATES for place in table[crate].values()}
    assert set(table["reasons"]) <= used


def test_every_python_class_wraps_a_rust_noun(table):
    places = {place.split(".")[-1] for crate in CRATES for place in table[crate].values()}
    classes = [name for name in gtfdi.__all__ if inspect.isclass(getattr(gtfdi, name))]
    # What only Python needs, with what it stands for.
    own = {
        "ArrayTypeError": "an array of no numbers",
        "DesignError": "FdiError and CampaignError",
        "GtfdiError": "the root of all exceptions",
        "OptionError": "an argument of Python's own",
        "PickleError": "pickles",
        "VerdictSeries": "a Verdict a sample",
    }
    for name in classes:
        assert name in places or name in own, name
