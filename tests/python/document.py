"""Markdown files of the repository: their code, and their links."""

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: A number with its sign, decimals and exponent.
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def repository() -> Path:
    """The repository, from GTFDI_ROOT or from this file's place."""
    return Path(os.environ.get("GTFDI_ROOT") or Path(__file__).resolve().parents[2])


@dataclass(frozen=True)
class Block:
    """A fenced block, and what the block right after it says that it prints."""

    language: str
    text: str
    printed: str | None


def blocks(text):
    """The fenced blocks in their order, with the ``text`` block that follows one as its output."""
    found = list(FENCE.finditer(text))
    for place, match in enumerate(found):
        printed = None
        if place + 1 < len(found):
            after = found[place + 1]
            if after[1] == "text" and not text[match.end() : after.start()].strip():
                printed = after[2]
        yield Block(match[1], match[2], printed)


def run(block, folder, binary):
    """Runs a block in a folder, as a reader would; what it prints on standard output.

    Shell blocks find the binary first on the path, Python blocks run with this interpreter.
    """
    environment = {
        key: value
        for key, value in os.environ.items()
        if not key.startswith("GTFDI_") or key == "GTFDI_REFERENCE_DATA"
    }
    environment["MPLBACKEND"] = "Agg"
    if binary:
        environment["PATH"] = f"{Path(binary).parent}{os.pathsep}{environment['PATH']}"
    program = ["sh", "-e", "-c"] if block.language == "sh" else [sys.executable, "-c"]
    ran = subprocess.run(
        [*program, block.text], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert ran.returncode == 0, f"{block.text}\n{ran.stdout}{ran.stderr}"
    return ran.stdout


def differs(printed, found):
    """How an output differs from the printed one, or None.

    Lines agree up to spaces, numbers to one unit of their last printed digit: other machines round
    otherwise. A printed line ``...`` stands for any lines.
    """
    wanted, lines = printed.splitlines(), found.splitlines()
    place, skipping = 0, False
    for line in wanted:
        if line.strip() == "...":
            skipping = True
            continue
        while skipping and place < len(lines) and not _agree(line, lines[place]):
            place += 1
        if place >= len(lines) or not _agree(line, lines[place]):
            there = lines[place] if place < len(lines) else "the end"
            return f"expected `{line}`, found `{there}` in\n{found}"
        place, skipping = place + 1, False
    if place < len(lines) and not skipping:
        return f"expected the end, found `{lines[place]}` in\n{found}"
    return None


def _agree(printed, found):
    words = [" ".join(NUMBER.sub("#", line).split()) for line in (printed, found)]
    if words[0] != words[1]:
        return False
    pairs = zip(NUMBER.findall(printed), NUMBER.findall(found), strict=True)
    return all(_near(*pair) for pair in pairs)


def _near(printed, found):
    digits, _, exponent = printed.partition("e")
    decimals = len(digits.partition(".")[2])
    unit = 10.0 ** (int(exponent or 0) - decimals)
    # Small whole numbers are counts or rows, and are what they are.
    is_count = decimals == 0 and not exponent and abs(float(printed)) < 1000.0
    tolerance = 0.0 if is_count else 1.01 * unit
    return abs(float(printed) - float(found)) <= tolerance


def without_blocks(text):
    """The text without fenced blocks, in which nothing is a link or a heading."""
    return re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)


def links(text):
    """The targets of all links and images that are not on the network."""
    bare = re.sub(r"`[^`\n]*`", "", without_blocks(text))
    inline = re.findall(r"\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)", bare)
    named = re.findall(r"^\s*\[[^\]]+\]:\s*<?(\S+?)>?\s*$", bare, re.M)
    return [link for link in inline + named if not re.match(r"[a-z][a-z0-9+.-]*:", link)]


def anchors(text):
    """The anchors that a code host gives to the headings."""
    seen: dict[str, int] = {}
    found = set()
    for heading in re.findall(r"^#{1,6}\s+(.*?)\s*#*$", without_blocks(text), re.M):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
        slug = re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")
        count = seen.get(slug, 0)
        seen[slug] = count + 1
        found.add(f"{slug}-{count}" if count else slug)
    found.update(re.findall(r"<a\s+(?:id|name)=\"([^\"]+)\"", text))
    return found
