"""The public nouns of the Rust crates that the package wraps, read from their sources."""

import re

CRATES = ("core", "plant", "ident", "fdi", "log", "campaign")

_ITEM = re.compile(
    r"^pub (?:const |unsafe |async )?(?:fn|struct|enum|trait|type|const|static|union) (\w+)", re.M
)
_USE = re.compile(r"^pub use ([^;]+);", re.M)
_MODULE = re.compile(r"^pub mod (\w+);", re.M)


def public_nouns(root, crate):
    """The nouns of one crate: those of its root by their names, those of its public modules as
    ``module::name``, once each and without what the root repeats. Constants are none: what they
    limit stands in the documentation of what is limited."""
    everything = _of_file(root / "crates" / f"gt-{crate}" / "src" / "lib.rs", "")
    found = [noun for noun in everything if not noun.rsplit("::")[-1].isupper()]
    at_root = {noun for noun in found if "::" not in noun}
    nouns = dict.fromkeys(found)
    return [noun for noun in nouns if "::" not in noun or noun.rsplit("::")[-1] not in at_root]


def _of_file(path, prefix):
    text = re.sub(r"//[^\n]*", "", path.read_text())
    text = text.split("#[cfg(test)]")[0]
    for tree in _USE.findall(text):
        yield from (prefix + name for name in _leaves(tree))
    yield from (prefix + name for name in _ITEM.findall(text))
    folder = path.parent if path.name in ("lib.rs", "mod.rs") else path.parent / path.stem
    for module in _MODULE.findall(text):
        for candidate in (folder / f"{module}.rs", folder / module / "mod.rs"):
            if candidate.exists():
                yield from _of_file(candidate, f"{prefix}{module}::")


def _leaves(tree):
    """The names at the leaves of a ``use`` tree."""
    group = re.match(r"^[^{]*\{(.*)\}$", tree.strip(), re.S)
    if not group:
        name = tree.split(" as ")[-1].split("::")[-1].strip()
        return [name] if name and name != "self" else []
    names, depth, part = [], 0, ""
    for character in group.group(1) + ",":
        if character == "," and depth == 0:
            names += _leaves(part)
            part = ""
        else:
            depth += (character == "{") - (character == "}")
            part += character
    return names
