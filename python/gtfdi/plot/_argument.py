"""Arguments of plots: their types and the names that they choose from."""

from collections.abc import Sequence
from typing import Any

from gtfdi.errors import OptionError


def of_type(name: str, value: object, *types: type) -> None:
    """Refuses an argument that has none of the types."""
    if not isinstance(value, types):
        expected = " or ".join(kind.__name__ for kind in types)
        raise TypeError(f"{name}: expected {expected}, found {type(value).__name__}")


def chosen(name: str, choice: str | Sequence[str] | None, there: Sequence[str]) -> list[str]:
    """The names that were chosen of those that are there, all where nothing was."""
    if choice is None:
        return list(there)
    names = [choice] if isinstance(choice, str) else list(choice)
    if not names:
        raise OptionError(f"{name}: expected at least one of {', '.join(there)}, found none")
    for each in names:
        if each not in there:
            raise OptionError(f"{name}: expected one of {', '.join(there)}, found {each!r}")
    return names


def between(name: str, value: Any, low: float, high: float) -> float:
    """A number strictly between two limits."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError(f"{name}: expected a number, found {type(value).__name__}")
    if not low < value < high:
        raise OptionError(f"{name}: expected a number between {low:g} and {high:g}, found {value}")
    return float(value)
