"""The book in `docs` does as it prints: every shell and Python block runs, in order, in an empty
folder without a network, and what it is said to print is what it prints."""

import os

import pytest
from document import Block, blocks, differs, repository, run

#: Pages that have tests of their own: `walk_through.rs` runs their shell blocks and asserts their
#: tables, since they read public records; `test_tennessee_eastman.py` runs the Python of the first.
ELSEWHERE = {"tennessee_eastman.md", "power_plant.md"}


def pages():
    """The pages of the book that are run here."""
    found = {path.name for path in (repository() / "docs").glob("*.md")}
    return sorted(found - ELSEWHERE)


@pytest.mark.parametrize("page", pages())
def test_page_runs_as_printed(page, root, tmp_path):
    found = list(blocks((root / "docs" / page).read_text(encoding="utf-8")))
    binary = os.environ.get("GTFDI_BINARY")
    if any(block.language == "sh" for block in found) and not binary:
        pytest.skip("GTFDI_BINARY is not set: no program for the shell blocks")
    for block in found:
        if block.language in ("sh", "python"):
            output = run(block, tmp_path, binary)
            if block.printed is not None:
                difference = differs(block.printed, output)
                assert difference is None, f"{block.text}\n{difference}"


def test_blocks_and_their_outputs_are_found():
    text = "# A\n\n```sh\nls\n```\n\n```text\nb\n```\n\n```python\n1\n```\n\nSo\n\n```text\nc\n```\n"
    assert list(blocks(text)) == [
        Block("sh", "ls\n", "b\n"),
        Block("text", "b\n", None),
        Block("python", "1\n", None),
        Block("text", "c\n", None),
    ]


@pytest.mark.parametrize(
    ("printed", "found", "same"),
    [
        ("a  1.25 s", "a 1.26 s", True),
        ("a 1.25", "a 1.27", False),
        ("12 alarms", "13 alarms", False),
        ("MDL -61490", "MDL -61491", True),
        ("1.5e-3", "1.6e-3", True),
        ("1.5e-3", "1.7e-3", False),
        ("a\n...\nd", "a\nb\nc\nd", True),
        ("a\n...\nd", "a\nb\nc", False),
        ("a", "a\nb", False),
        ("a\nb", "a", False),
        ("t3 1.5", "t4 1.5", False),
    ],
)
def test_outputs_agree_to_their_last_digit(printed, found, same):
    assert (differs(printed, found) is None) == same
