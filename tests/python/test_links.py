"""Links between the Markdown files of the repository lead somewhere."""

import json
import os
from pathlib import Path

import pytest
from document import anchors, links

#: Folders of what is built and fetched, not written here.
NOT_OURS = {"target", "out", ".git", ".venv", "node_modules"}


def documents(root):
    """Every Markdown file and notebook below the root, with its Markdown."""
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(set(folders) - NOT_OURS)
        for name in sorted(names):
            path = Path(folder) / name
            if path.suffix == ".md":
                yield path, path.read_text(encoding="utf-8")
            elif path.suffix == ".ipynb":
                cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
                texts = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown"]
                yield path, "\n\n".join(texts)


def broken(path, text):
    """The links of a document that lead nowhere, with the reason."""
    for link in links(text):
        name, _, anchor = link.partition("#")
        target = path.parent / name
        if name and not target.exists():
            yield link, "no such file"
        elif anchor:
            there = target.read_text(encoding="utf-8") if name else text
            if anchor not in anchors(there):
                yield link, "no such heading"


def test_all_links_lead_somewhere(root):
    found = list(documents(root))
    assert {path.name for path, _ in found} >= {"README.md", "ARCHITECTURE.md", "SUMMARY.md"}
    wrong = [
        f"{path.relative_to(root)}: {link}: {reason}"
        for path, text in found
        for link, reason in broken(path, text)
    ]
    assert wrong == []


def listed(path):
    """The files that a document links to, without anchors."""
    return {link.partition("#")[0] for link in links(path.read_text(encoding="utf-8"))}


def test_every_page_of_the_book_is_in_its_contents(root):
    docs = root / "docs"
    pages = {path.relative_to(docs).as_posix() for path in docs.rglob("*.md")} - {"SUMMARY.md"}
    assert listed(docs / "SUMMARY.md") == pages
    notebooks = {path.name for path in (docs / "notebooks").glob("*.ipynb")}
    assert listed(docs / "notebooks" / "README.md") == notebooks


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[a](there.md) and [b](#two-words) ![c](there.md#one \"title\")", []),
        ("[a](gone.md)", [("gone.md", "no such file")]),
        ("[a](there.md#two)", [("there.md#two", "no such heading")]),
        ("[a](#one)", [("#one", "no such heading")]),
        ("[a]: gone.md", [("gone.md", "no such file")]),
        ("`[a](gone.md)` and [b](https://example.org/gone.md)", []),
        ("```sh\n[a](gone.md)\n```", []),
    ],
)
def test_broken_links_are_found(tmp_path, text, expected):
    (tmp_path / "there.md").write_text("# One\n\n## One\n")
    page = tmp_path / "page.md"
    whole = f"## Two `words`!\n\n{text}\n"
    assert list(broken(page, whole)) == expected


def test_headings_of_one_name_are_counted():
    text = "# A b\n\n```sh\n# no heading\n```\n\n## A b\n\n## [C](d.md), e_f\n"
    assert anchors(text) == {"a-b", "a-b-1", "c-e_f"}
