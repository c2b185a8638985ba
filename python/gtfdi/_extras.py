"""Packages that only some of the methods need."""

from importlib import import_module
from typing import Any


def need(module: str, extra: str) -> Any:
    """The module, or an ImportError that says how to install it."""
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ImportError(
            f"expected the package {package}, found none that can be imported: "
            f"pip install 'gtfdi[{extra}]'"
        ) from error
